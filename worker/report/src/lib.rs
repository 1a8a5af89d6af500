//! Pictures compared, and speed measured against error.
//!
//! [`compare`] holds one picture against another: squared errors, the perceptual
//! difference FLIP, pictures of where they differ.

pub mod compare;
pub mod flip;
mod heat;
pub mod metrics;
pub mod picture;
