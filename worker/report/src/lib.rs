//! Pictures compared, and speed measured against error.
//!
//! [`compare`] holds one picture against another: squared errors, the perceptual
//! difference FLIP, pictures of where they differ. [`study`] renders variants of scenes
//! to rising numbers of samples, with a clock, and holds them against references;
//! [`output`] makes a page and tables of what it finds.

pub mod compare;
mod develop;
pub mod flip;
pub mod groups;
mod heat;
pub mod measure;
pub mod metrics;
pub mod output;
pub mod picture;
mod student;
pub mod study;
pub mod variants;
