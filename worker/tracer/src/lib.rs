//! The path tracer: scene in, exact sums out.
//!
//! Pure: no files, no network, no clock, no environment, no threads of its own
//! beyond the build of a scene. [`Scene::build`] makes a scene from a description
//! and the bytes of its files; [`render_run`] renders a range of samples of a
//! tile. A sample is a pure function of (scene, seed, frame, half, pixel, index),
//! with the same bits on every machine.

// Without effects much is defined and not called.
#![cfg_attr(not(feature = "effects"), allow(dead_code))]

pub mod bsdf;
mod camera;
mod cloud;
pub mod export;
pub mod geometry;
pub mod light;
pub mod load;
pub mod math;
pub mod medium;
mod path;
mod render;
pub mod sampler;
mod scene;
mod strategy;
pub mod uses;
pub mod water;

pub use render::render_run;
pub use scene::{Assets, BuildOptions, BuildReport, Scene, Stage};

/// Name of this build's arithmetic: a hash of every source that can change a bit
/// of a picture. Workers of one farm must agree on it.
pub const BUILD: &str = env!("SHEARWATER_TRACER_BUILD");
