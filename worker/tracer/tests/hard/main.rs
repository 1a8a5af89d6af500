//! Hard cases: each measured value beside the one that must come out.
//!
//! A section is a file with a `static SECTION` of cases and one test that checks
//! it; a case is a function that measures and returns rows. `tests/hard-cases`
//! writes them all to docs/hard-cases.md.

#[path = "../bsdf_support/mod.rs"]
mod support;

#[path = "../radiance/common.rs"]
mod common;

#[path = "../geometry/blades.rs"]
mod blades;
#[path = "../geometry/joints.rs"]
#[allow(dead_code, reason = "other tests need the rest")]
mod joints;
#[path = "../geometry/self_hits.rs"]
mod self_hits;
#[path = "../geometry/shapes.rs"]
#[allow(dead_code, reason = "other tests need the rest")]
mod shapes;
#[path = "../medium/common.rs"]
#[allow(dead_code, reason = "other tests need the rest")]
mod volumes;

mod accumulation;
mod albedos;
mod bsdf_energy;
mod bsdf_numbers;
mod bsdf_samplers;
mod checks;
mod document;
mod geometry;
mod layers;
mod media;
mod motion;
mod not_offered;
mod sky;
mod sun;
mod table;
mod trochoid;
mod water;
mod water_furnace;
mod worlds;
