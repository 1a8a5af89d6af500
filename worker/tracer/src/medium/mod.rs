//! Participating media: what scatters light without a surface.

pub mod phase;

pub use phase::Phase;
