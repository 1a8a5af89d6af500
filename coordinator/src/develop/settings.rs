//! What may be chosen when a picture is developed, and in which ranges.

use super::error::DevelopError;

/// Largest exposure correction in stops, both ways: 2^32 covers starlight to
/// the sun's disc and keeps every product far from overflow.
pub const EXPOSURE_EV_MAX: f32 = 32.0;

pub use shearwater_shared::limits::{BLOOM_PASSES_MAX, BLOOM_STRENGTH_MAX};

/// Everything between linear light and the display.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PostSettings {
    /// Exposure correction in stops; light is multiplied by 2^ev. Range:
    /// ±[`EXPOSURE_EV_MAX`].
    pub exposure_ev: f32,
    /// Glow around what is bright; `None` for none.
    pub bloom: Option<Bloom>,
    /// From exposed linear light to display code values.
    pub view: View,
}

/// Glow: `B = I + strength * K * max(I - threshold, 0)`, each channel by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bloom {
    /// Linear value above which light glows, before exposure, at least 0.
    /// +inf switches the bloom off.
    pub threshold: f32,
    /// Factor on the glow, 0 to [`BLOOM_STRENGTH_MAX`]; 0 switches it off.
    pub strength: f32,
    /// Half-width of the box filter as a fraction of the picture's height,
    /// 0 to 1, so that the glow keeps its look at every resolution.
    pub radius: f32,
    /// How often the box is applied, 1 to [`BLOOM_PASSES_MAX`]. One is the
    /// plain box, whose halo is a square; with more the boxes shrink so that
    /// the halo keeps its spread (standard deviation) and becomes round.
    pub passes: u32,
}

impl Default for Bloom {
    /// Threshold 1 (white before exposure), one pass: the plain box filter.
    fn default() -> Self {
        Self {
            threshold: 1.0,
            strength: 0.1,
            radius: 0.03,
            passes: 1,
        }
    }
}

/// The step from exposed linear light to display code values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// Clamp to [0, 1] and the sRGB curve: exact, for tests and measurements.
    Standard,
    /// AgX: 16.5 stops in an S-curve, bright colours fade to white as on film.
    #[default]
    Agx,
}

impl View {
    /// Every view.
    pub const ALL: [Self; 2] = [Self::Standard, Self::Agx];

    /// The name used in scenes, queries and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Agx => "agx",
        }
    }

    /// The view of this name, if there is one.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|view| view.name() == name)
    }
}

impl PostSettings {
    /// Checks every range.
    ///
    /// # Errors
    /// [`DevelopError::Setting`] with the first setting out of range.
    pub fn check(&self) -> Result<(), DevelopError> {
        let ev = self.exposure_ev;
        if !(-EXPOSURE_EV_MAX..=EXPOSURE_EV_MAX).contains(&ev) {
            let expected = format!("-{EXPOSURE_EV_MAX} to {EXPOSURE_EV_MAX} stops");
            return Err(setting("exposure_ev", ev.into(), expected));
        }
        self.bloom.as_ref().map_or(Ok(()), Bloom::check)
    }
}

impl Bloom {
    /// Checks every range.
    ///
    /// # Errors
    /// [`DevelopError::Setting`] with the first setting out of range.
    pub fn check(&self) -> Result<(), DevelopError> {
        if self.threshold.is_nan() || self.threshold < 0.0 {
            let expected = "a number of at least 0".to_owned();
            return Err(setting("bloom.threshold", self.threshold.into(), expected));
        }
        if !(0.0..=BLOOM_STRENGTH_MAX).contains(&self.strength) {
            let expected = format!("0 to {BLOOM_STRENGTH_MAX}");
            return Err(setting("bloom.strength", self.strength.into(), expected));
        }
        if !(0.0..=1.0).contains(&self.radius) {
            let expected = "0 to 1, a fraction of the picture's height".to_owned();
            return Err(setting("bloom.radius", self.radius.into(), expected));
        }
        if !(1..=BLOOM_PASSES_MAX).contains(&self.passes) {
            let expected = format!("1 to {BLOOM_PASSES_MAX}");
            return Err(setting("bloom.passes", self.passes.into(), expected));
        }
        Ok(())
    }
}

fn setting(name: &'static str, value: f64, expected: String) -> DevelopError {
    DevelopError::Setting {
        name,
        value,
        expected,
    }
}
