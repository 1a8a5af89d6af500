//! Mathematics with the same bits on every machine: elementary functions,
//! counter-based hashes, local frames and sampling warps.
pub mod elementary;
pub mod frame;
pub mod hash;
pub mod warp;
