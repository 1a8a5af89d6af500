//! What a scene uses, as bits of a const parameter: the hot code is compiled once
//! for every set of them, so a scene without an effect has no trace of it in its
//! loops. A new bit doubles the code; it needs a measurement.

/// Semi-opaque things: particles and sprites.
pub const PARTICLES: u8 = 1;
/// Instances or a camera that move while the shutter is open.
pub const MOTION: u8 = 2;
/// Participating media.
pub const MEDIA: u8 = 4;

/// Water, or a sky at a finite distance: what ends rays without being a mesh.
/// Set by itself or beside any other bit, so it adds one copy of the code, not as
/// many again: see [`copy_for`].
pub const SURROUNDINGS: u8 = 8;

/// The copy of the hot code that serves a scene with these bits: the least set
/// among those that are compiled.
#[must_use]
pub const fn copy_for(bits: u8) -> u8 {
    if bits == NOTHING {
        NOTHING
    } else {
        bits | SURROUNDINGS
    }
}

/// Whether this build has any effects: see the feature of that name.
pub const EFFECTS: bool = cfg!(feature = "effects");

/// Nothing but opaque things that stand still.
pub const NOTHING: u8 = 0;
