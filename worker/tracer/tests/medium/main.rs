//! Volumes alone, against integrals: phase functions, densities and their bounds,
//! tracking, marching and its bias.

mod common;
mod density;
mod march;
mod phase;
mod tracking;
