//! Paths: light carried from the scene to the pixels.

mod batch;
mod direct;
mod escape;
mod flight;
mod interaction;
mod vertex;
mod weight;

pub(crate) use batch::{LANES, PathResult, trace_batch};
