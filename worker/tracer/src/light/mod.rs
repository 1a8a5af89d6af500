//! Lights: the sky, at infinity or as a finite dome, given or computed, and the
//! sun.

mod alias;
pub mod atmosphere;
mod cells;
mod dome;
mod map;
mod sky;
mod sun;

pub use alias::AliasTable;
pub use dome::SkyDome;
pub use map::{MapTables, SkyMap};
pub use sky::{SkyLight, SkySample};
pub use sun::SunLight;
