//! Lights: the sky and the sun, both infinitely far away.

mod alias;
mod cells;
mod sky;
mod sun;

pub use alias::AliasTable;
pub use sky::{SkyLight, SkySample, SkySampling};
pub use sun::SunLight;
