//! Whole scenes whose radiance is known: the tracer from scene.json to sums.

mod common;
mod dome;
mod exactness;
mod lights;
mod maps;
mod motion;
mod particles;
mod sprites;
mod surfaces;
mod volumes;
mod water;
