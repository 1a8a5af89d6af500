//! Rendering with a clock: exact sums of a frame and the core seconds they cost.

mod cpu_time;
mod film;
mod render;

pub use cpu_time::thread_cpu_seconds;
pub use film::FrameSums;
pub use render::{How, MeasureError, Spent, render_more};
