//! Water: a plane to the horizon whose normals come from a wave spectrum.

mod picture;
mod slopes;
mod spectrum;

pub use picture::{HeightPictureError, HeightPictures, height_pictures};
pub use slopes::{SlopeMap, Slopes};
pub use spectrum::{HeightField, height_field};

use glam::Vec2;
use shearwater_shared::scene::Water;

/// A built sea.
#[derive(Clone, Debug)]
pub struct Sea {
    /// Height of the mean surface, in metres, in the scene's own coordinates.
    pub height_m: f64,
    slopes: SlopeMap,
    /// Tile coordinates of the render origin, in [0, 1).
    origin: Vec2,
    per_metre: f32,
    /// Drift in tiles per second.
    drift: Vec2,
    /// Square of the GGX alpha of ripples below the grid.
    ripple_alpha2: f32,
    /// Reflectance of the water body.
    pub body_color: glam::Vec3,
    /// Index of refraction.
    pub ior: f32,
}

/// What the tracer needs to know of a point of the surface.
#[derive(Clone, Copy, Debug)]
pub struct WaterPoint {
    /// dh/dx and dh/dz.
    pub slope: Vec2,
    /// GGX alpha of what is finer than the footprint.
    pub alpha: f32,
}

impl Sea {
    /// Build the height field and its slopes. `origin_m` is the point of the
    /// scene that is (0, 0, 0) for the tracer.
    #[must_use]
    pub fn build(water: &Water, origin_m: [f64; 3]) -> Self {
        let Water::Tessendorf(sea) = water;
        let field = height_field(sea);
        let wrap = |v: f64| {
            let tiles = v / sea.tile_m;
            (tiles - libm::floor(tiles)) as f32
        };
        let alpha = sea.roughness * sea.roughness;
        Self {
            height_m: sea.height_m,
            slopes: SlopeMap::new(&field),
            origin: Vec2::new(wrap(origin_m[0]), wrap(origin_m[2])),
            per_metre: (1.0 / sea.tile_m) as f32,
            drift: Vec2::new(
                (sea.velocity_mps[0] / sea.tile_m) as f32,
                (sea.velocity_mps[1] / sea.tile_m) as f32,
            ),
            ripple_alpha2: alpha * alpha,
            body_color: glam::Vec3::from_array(sea.body_color),
            ior: sea.ior,
        }
    }

    /// Slope at the horizontal point (x, z) metres from the render origin at
    /// `time_s`, seen by a ray as wide as `footprint_m`. Waves finer than that
    /// become roughness: a Gaussian of slope variance s^2 per axis is a Beckmann
    /// lobe of alpha^2 = 2 s^2 (Walter et al. 2007), to which GGX is matched.
    #[inline]
    #[must_use]
    pub fn at(&self, x: f32, z: f32, time_s: f32, footprint_m: f32) -> WaterPoint {
        let tile = Vec2::new(x, z) * self.per_metre + self.origin - self.drift * time_s;
        let Slopes { slope, variance } = self.slopes.lookup(tile, footprint_m * self.per_metre);
        WaterPoint {
            slope,
            alpha: (self.ripple_alpha2 + 2.0 * variance).sqrt().min(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Drifting by v for t seconds is looking v t metres upstream.
    #[test]
    fn the_surface_drifts_with_its_velocity() {
        let sea = shearwater_shared::scene::TessendorfWater {
            velocity_mps: [3.0, -7.0],
            ..spectrum::tests::sea()
        };
        let sea = Sea::build(&Water::Tessendorf(sea), [10.0, 5.0, -20.0]);
        for (x, z, t) in [(1.0, 2.0, 0.5), (-40.0, 13.0, 2.0)] {
            let (moved, there) = (
                sea.at(x, z, t, 0.0),
                sea.at(x - 3.0 * t, z + 7.0 * t, 0.0, 0.0),
            );
            assert!((moved.slope - there.slope).length() < 1e-3, "{x} {z} {t}");
        }
        let (now, later) = (sea.at(1.0, 2.0, 0.0, 0.0), sea.at(1.0, 2.0, 0.5, 0.0));
        assert!((now.slope - later.slope).length() > 1e-2);
    }
}
