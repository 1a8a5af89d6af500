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
mod checks;
mod document;
mod table;
