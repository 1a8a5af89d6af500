//! A finite dome: a sphere that emits inwards what its map says, with parallax.

use super::map::SkyMap;
use super::sky::SkySample;
use glam::Vec3;
use std::sync::Arc;

/// A sphere seen from inside. Its wall emits inwards the radiance that the map has
/// in the direction from the centre to the place on the wall, and ends every ray.
/// From outside the near wall lets light through, the far wall shines.
#[derive(Clone, Debug)]
pub struct SkyDome {
    map: Arc<SkyMap>,
    centre: Vec3,
    radius: f32,
}

/// Where a ray meets the far wall.
struct FarWall {
    /// Metres along the ray.
    t: f32,
    /// Unit, from the centre to the place.
    n: Vec3,
    /// Cosine between ray and `n`, not negative.
    cos: f32,
}

impl SkyDome {
    /// A dome about `centre` (render space) of `radius` metres, above 0.
    #[must_use]
    pub fn new(map: Arc<SkyMap>, centre: Vec3, radius: f32) -> Self {
        Self {
            map,
            centre,
            radius,
        }
    }

    /// What its wall shows.
    #[must_use]
    pub fn map(&self) -> &SkyMap {
        &self.map
    }

    // By the perpendicular from the centre to the ray, not by b^2 - 4ac: for a
    // small dome far away the latter has no digits left.
    #[inline]
    fn far_wall(&self, o: Vec3, d: Vec3) -> Option<FarWall> {
        let to_centre = self.centre - o;
        let along = to_centre.dot(d);
        let across = d * along - to_centre;
        let rest = self.radius * self.radius - across.length_squared();
        // NaN, too, is no hit.
        if rest.is_nan() || rest < 0.0 {
            return None;
        }
        let half_chord = rest.sqrt();
        let t = along + half_chord;
        (t > 0.0).then(|| FarWall {
            t,
            n: ((across + d * half_chord) / self.radius).normalize(),
            cos: half_chord / self.radius,
        })
    }

    /// Distance to the far wall; infinite for a ray that misses the dome.
    #[inline]
    #[must_use]
    pub(super) fn reach(&self, o: Vec3, d: Vec3) -> f32 {
        self.far_wall(o, d).map_or(f32::INFINITY, |wall| wall.t)
    }

    /// What arrives at `o` from `d`; black for a ray that misses the dome.
    #[inline]
    #[must_use]
    pub(super) fn radiance(&self, o: Vec3, d: Vec3) -> Vec3 {
        self.far_wall(o, d)
            .map_or(Vec3::ZERO, |wall| self.map.radiance(wall.n))
    }

    /// What arrives at `o` from `d`, and the density of [`Self::sample`] there.
    ///
    /// A density q per solid angle at the centre is q / R^2 per area of the wall,
    /// and that is q t^2 / (R^2 cos) per solid angle at a distance t.
    #[inline]
    #[must_use]
    pub(super) fn radiance_and_pdf(&self, o: Vec3, d: Vec3) -> (Vec3, f32) {
        let Some(wall) = self.far_wall(o, d) else {
            return (Vec3::ZERO, 0.0);
        };
        let (radiance, at_centre) = self.map.radiance_and_pdf(wall.n);
        let distance = wall.t / self.radius;
        // Grazing the rim from outside: so dense that the weight of a chance hit
        // vanishes.
        let pdf = if at_centre > 0.0 {
            at_centre * distance * distance / wall.cos
        } else {
            0.0
        };
        (radiance, pdf)
    }

    /// A place of the wall by the map's own tables; `None` where it turns its back
    /// on `o`.
    #[inline]
    #[must_use]
    pub(super) fn sample(&self, o: Vec3, u: [f32; 2]) -> Option<SkySample> {
        let drawn = self.map.sample(u)?;
        let to_wall = self.centre - o + drawn.d * self.radius;
        let distance = to_wall.length();
        let wi = to_wall / distance;
        let cos = wi.dot(drawn.d);
        let share = distance / self.radius;
        let pdf = drawn.pdf * share * share / cos;
        // NaN at the wall itself is no sample either.
        (cos > 0.0 && pdf > 0.0 && pdf.is_finite()).then_some(SkySample {
            wi,
            radiance: drawn.radiance,
            pdf,
        })
    }
}

#[cfg(test)]
#[path = "dome_tests.rs"]
mod tests;
