//! Hard cases: each measured value beside the one that must come out.
//!
//! A section is a file with a `static SECTION` of cases and one test that checks
//! it; a case is a function that measures and returns rows. `tests/hard-cases`
//! writes them all to docs/hard-cases.md.

#[path = "../bsdf_support/mod.rs"]
mod support;

#[path = "../radiance/common.rs"]
mod common;

mod accumulation;
mod albedos;
mod bsdf_energy;
mod bsdf_numbers;
mod bsdf_samplers;
mod checks;
mod document;
mod lights;
mod not_offered;
mod table;
mod water_furnace;
