//! Lights: the sky, at infinity or as a finite dome, and the sun.

mod alias;
mod cells;
mod dome;
mod map;
mod sky;
mod sun;

pub use alias::AliasTable;
pub use dome::SkyDome;
pub use map::{SkyMap, SkySampling};
pub use sky::{SkyLight, SkySample};
pub use sun::SunLight;
