//! Water: a plane to the horizon whose normals come from waves.
//!
//! What all frames share is a [`SeaStage`]; [`SeaStage::at`] makes the [`Sea`] of
//! one frame, which answers [`Sea::at`] for every ray.

mod fft;
mod flat;
mod gerstner;
mod phillips;
mod picture;
mod slopes;
mod spectrum;
mod tessendorf;
#[cfg(test)]
mod tests;
mod whitecaps;

pub use picture::{PictureError, WaterPictures, water_pictures};
pub use slopes::{SlopeMap, Slopes};
pub use spectrum::{HeightField, Spectrum};

use crate::load::Texture;
use flat::{FlatSea, FlatStage};
use gerstner::{GerstnerSea, GerstnerStage};
use glam::{Vec2, Vec3};
use shearwater_shared::scene::{Water, WaterLook};
use tessendorf::{TessendorfSea, TessendorfStage};

/// What the frames of a sea share.
#[derive(Clone, Debug)]
pub struct SeaStage {
    look: WaterLook,
    foam: (Vec3, f32),
    waves: StageWaves,
}

#[derive(Clone, Debug)]
enum StageWaves {
    Tessendorf(TessendorfStage),
    Gerstner(GerstnerStage),
    Flat(FlatStage),
}

/// The sea of one frame.
#[derive(Clone, Debug)]
pub struct Sea {
    /// Height of the mean surface, in metres, in the scene's own coordinates.
    pub height_m: f64,
    waves: Waves,
    /// Drift in metres per second.
    drift_mps: Vec2,
    /// Square of the GGX alpha of ripples that no wave shows.
    ripple_alpha2: f32,
    body_color: Vec3,
    /// Reflectance and square of the GGX alpha of foam.
    foam: (Vec3, f32),
}

#[derive(Clone, Debug)]
enum Waves {
    Tessendorf(TessendorfSea),
    Gerstner(GerstnerSea),
    Flat(FlatSea),
}

/// What the tracer needs to know of a point of the surface.
#[derive(Clone, Copy, Debug)]
pub struct WaterPoint {
    /// dh/dx and dh/dz.
    pub slope: Vec2,
    /// GGX alpha of what is finer than the footprint.
    pub alpha: f32,
    /// Reflectance of what lies under the surface.
    pub body_color: Vec3,
}

impl SeaStage {
    /// What the frames of `water` share: its random waves. `texture` is the number of
    /// its texture, if it has one.
    #[must_use]
    pub fn new(water: &Water, texture: Option<u32>) -> Self {
        let foam = match water {
            Water::Tessendorf(sea) => sea.whitecaps.map(|caps| {
                let alpha = caps.roughness * caps.roughness;
                (Vec3::from_array(caps.albedo), alpha * alpha)
            }),
            Water::Gerstner(_) | Water::Flat(_) => None,
        };
        Self {
            look: water.look(),
            foam: foam.unwrap_or_default(),
            waves: match water {
                Water::Tessendorf(sea) => StageWaves::Tessendorf(TessendorfStage::new(sea)),
                Water::Gerstner(sea) => StageWaves::Gerstner(GerstnerStage::new(sea)),
                Water::Flat(sea) => StageWaves::Flat(FlatStage::new(sea, texture)),
            },
        }
    }

    /// The sea while the shutter is open, from `frame_time_s` for `shutter_s`.
    /// `origin_m` is the point of the scene that is (0, 0, 0) for the tracer.
    #[must_use]
    pub fn at(&self, frame_time_s: f64, shutter_s: f64, origin_m: [f64; 3]) -> Sea {
        let look = &self.look;
        let origin_m = [
            origin_m[0] - look.velocity_mps[0] * frame_time_s,
            origin_m[2] - look.velocity_mps[1] * frame_time_s,
        ];
        let alpha = look.roughness * look.roughness;
        Sea {
            height_m: look.height_m,
            waves: match &self.waves {
                StageWaves::Tessendorf(stage) => {
                    Waves::Tessendorf(stage.at(frame_time_s, shutter_s, origin_m))
                }
                StageWaves::Gerstner(stage) => Waves::Gerstner(stage.at(frame_time_s, origin_m)),
                StageWaves::Flat(stage) => Waves::Flat(stage.at(origin_m)),
            },
            drift_mps: Vec2::from_array(look.velocity_mps.map(|v| v as f32)),
            ripple_alpha2: alpha * alpha,
            body_color: Vec3::from_array(look.body_color),
            foam: self.foam,
        }
    }
}

impl Sea {
    /// The surface at the horizontal point (x, z) metres from the render origin,
    /// `time_s` after the shutter opened, seen by a ray as wide as `footprint_m`.
    /// Waves finer than that become roughness: a Gaussian of slope variance s^2 per
    /// axis is a Beckmann lobe of alpha^2 = 2 s^2 (Walter et al. 2007), to which GGX
    /// is matched. `textures` are those of the scene.
    #[inline]
    #[must_use]
    pub fn at(
        &self,
        x: f32,
        z: f32,
        time_s: f32,
        footprint_m: f32,
        textures: &[Texture],
    ) -> WaterPoint {
        let p = Vec2::new(x, z) - self.drift_mps * time_s;
        let slopes = match &self.waves {
            Waves::Tessendorf(sea) => sea.at(p, time_s, footprint_m),
            Waves::Gerstner(sea) => sea.at(p, time_s, footprint_m),
            Waves::Flat(sea) => {
                return WaterPoint {
                    slope: Vec2::ZERO,
                    alpha: self.ripple_alpha2.sqrt(),
                    body_color: self.body_color * sea.color(p, textures),
                };
            }
        };
        let mut alpha2 = self.ripple_alpha2 + 2.0 * slopes.variance;
        let mut body_color = self.body_color;
        if slopes.foam > 0.0 {
            let (color, foam_alpha2) = self.foam;
            body_color += (color - body_color) * slopes.foam;
            alpha2 += (foam_alpha2 - alpha2) * slopes.foam;
        }
        WaterPoint {
            slope: slopes.slope,
            alpha: alpha2.sqrt().min(1.0),
            body_color,
        }
    }
}
