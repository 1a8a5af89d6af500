//! What a scene uses, as bits of a const parameter: the hot code is compiled once
//! for every set of them, so a scene without an effect has no trace of it in its
//! loops. A new bit doubles the code; it needs a measurement.

/// Semi-opaque things: particles and sprites.
pub const PARTICLES: u8 = 1;
/// Instances or a camera that move while the shutter is open.
pub const MOTION: u8 = 2;
/// Participating media.
pub const MEDIA: u8 = 4;

/// Whether this build has any effects: see the feature of that name.
pub const EFFECTS: bool = cfg!(feature = "effects");

/// Nothing but opaque things that stand still.
pub const NOTHING: u8 = 0;
