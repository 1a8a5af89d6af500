//! tmp
mod camera;
mod cloud;
pub mod geometry;
pub mod light;
pub mod math;
pub mod sampler;
pub mod water;
