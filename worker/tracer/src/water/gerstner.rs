//! Gerstner's waves: a short list of waves, summed at every point (Fournier and Reeves
//! 1986, "A Simple Model of Ocean Waves"; Tessendorf 2001, section 4.1).

use super::slopes::Slopes;
use super::spectrum::{frequency_hz, whole_turns};
use crate::math::elementary::sin_cos;
use glam::Vec2;
use shearwater_shared::scene::{GerstnerWater, Profile};
use std::f64::consts::PI;

/// Steps at most towards the water that a trochoid has moved to a point; three or four
/// do, but near the cusp of the steepest waves.
const STEPS_MAX: usize = 32;
/// The search ends at this share of the sum of amplitudes.
const CLOSE: f32 = 1e-6;
/// Least area of a squeezed patch of water: at the cusp of the steepest wave slopes
/// are infinite.
const AREA_MIN: f32 = 1e-4;
/// A wave is all there for rays narrower than this share of its length, and gone,
/// into roughness, for those wider than twice this.
const NARROW: f32 = 0.25;

/// What all frames share: the description, checked.
#[derive(Clone, Debug)]
pub(super) struct GerstnerStage {
    sea: GerstnerWater,
}

/// The waves of one frame.
#[derive(Clone, Debug)]
pub(super) struct GerstnerSea {
    waves: Vec<Wave>,
    trochoid: bool,
}

#[derive(Clone, Copy, Debug)]
struct Wave {
    /// Radians per metre.
    k: Vec2,
    amplitude_m: f32,
    /// k times amplitude: the largest slope of a sine.
    steepness: f32,
    direction: Vec2,
    /// Radians per second.
    omega: f32,
    /// Phase at the render origin when the shutter opens, radians.
    phase: f32,
    /// Turns per metre.
    per_metre: f32,
}

/// A point of the surface, before a trochoid moves it.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    height: f32,
    /// Where the water goes.
    shift: Vec2,
    /// Gradient of the height.
    gradient: Vec2,
    /// Derivatives of the shift, negative: xx, zz, xz.
    squeeze: [f32; 3],
}

impl GerstnerStage {
    pub(super) fn new(sea: &GerstnerWater) -> Self {
        Self { sea: sea.clone() }
    }

    /// `origin_m` is the point of the undrifted field that lies at the render
    /// origin when the shutter opens, `time_s` from the waves' own beginning.
    pub(super) fn at(&self, time_s: f64, origin_m: [f64; 2]) -> GerstnerSea {
        let time_s = self.sea.time_s + time_s;
        let wave = |wave: &shearwater_shared::scene::GerstnerWave| {
            let azimuth = wave.direction_deg.to_radians();
            let direction = [libm::sin(azimuth), -libm::cos(azimuth)];
            let k = 2.0 * PI / wave.wavelength_m;
            let hz = frequency_hz(k);
            let hz = self
                .sea
                .loop_s
                .map_or(hz, |loop_s| whole_turns(hz * loop_s) / loop_s);
            let along_m = direction[0] * origin_m[0] + direction[1] * origin_m[1];
            let turns = along_m / wave.wavelength_m - hz * time_s + wave.phase_deg / 360.0;
            let direction = Vec2::from_array(direction.map(|v| v as f32));
            Wave {
                k: direction * k as f32,
                amplitude_m: wave.amplitude_m as f32,
                steepness: (k * wave.amplitude_m) as f32,
                direction,
                omega: (2.0 * PI * hz) as f32,
                // Whole turns are taken away before they can cost digits.
                phase: (2.0 * PI * (turns - libm::floor(turns))) as f32,
                per_metre: (1.0 / wave.wavelength_m) as f32,
            }
        };
        GerstnerSea {
            waves: self.sea.waves.iter().map(wave).collect(),
            trochoid: self.sea.profile == Profile::Trochoid,
        }
    }
}

impl GerstnerSea {
    /// Slopes at `p` metres from the render origin, `time_s` after the shutter opened,
    /// under a ray `footprint_m` wide. What a wave loses to the footprint is slope
    /// variance, exact for one wave.
    #[inline]
    pub(super) fn at(&self, p: Vec2, time_s: f32, footprint_m: f32) -> Slopes {
        let sums = self.sums(p, time_s, footprint_m);
        let slope = if self.trochoid {
            unsqueeze(&sums, sums.gradient)
        } else {
            sums.gradient
        };
        let lost = |wave: &Wave| {
            let share = wave.share(footprint_m);
            self.slope_square(wave.steepness) - self.slope_square(wave.steepness * share)
        };
        let variance = if footprint_m > 0.0 {
            self.waves.iter().map(lost).sum::<f32>() * 0.5
        } else {
            0.0
        };
        Slopes {
            slope,
            variance,
            foam: 0.0,
        }
    }

    /// Height above the mean surface in metres, at [`Self::at`]'s place and time.
    pub(super) fn height_m(&self, p: Vec2, time_s: f32) -> f32 {
        self.sums(p, time_s, 0.0).height
    }

    // Mean square of the slope of one wave over the plane: e^2/2 for a sine; for a
    // trochoid the mean of e^2 cos^2 t / (1 - e sin t) over t, which is the integral
    // 1 - sqrt(1 - e^2).
    fn slope_square(&self, e: f32) -> f32 {
        if self.trochoid {
            // Without a difference of nearly equal numbers.
            let e2 = (e * e).min(1.0);
            e2 / (1.0 + (1.0 - e2).sqrt())
        } else {
            0.5 * e * e
        }
    }

    // The sums at the water that lies at `p`, of which each wave's share remains.
    #[inline]
    fn sums(&self, p: Vec2, time_s: f32, footprint_m: f32) -> Sums {
        let (mut q, mut sums) = (p, self.sums_of(p, time_s, footprint_m));
        if !self.trochoid {
            return sums;
        }
        // Far away the digits of p are coarser than what the waves would deserve.
        let reach: f32 = self.waves.iter().map(|w| w.amplitude_m).sum();
        let close = (CLOSE * reach).max(2.0 * f32::EPSILON * p.abs().max_element());
        // How far q + shift(q) is from p, and the share of Newton's step that is tried.
        let (mut rest, mut step) = (p - q - sums.shift, 1.0);
        for _ in 0..STEPS_MAX {
            if rest.length_squared() <= close * close {
                break;
            }
            let next = q + unsqueeze(&sums, rest) * step;
            let there = self.sums_of(next, time_s, footprint_m);
            let rest_there = p - next - there.shift;
            if rest_there.length_squared() < rest.length_squared() {
                (q, sums, rest, step) = (next, there, rest_there, 1.0);
            } else {
                step *= 0.5;
            }
        }
        sums
    }

    #[inline]
    fn sums_of(&self, q: Vec2, time_s: f32, footprint_m: f32) -> Sums {
        let mut sums = Sums::default();
        for wave in &self.waves {
            let share = wave.share(footprint_m);
            if share <= 0.0 {
                continue;
            }
            let (sin, cos) = sin_cos(wave.k.dot(q) - wave.omega * time_s + wave.phase);
            let amplitude = wave.amplitude_m * share;
            let (d, slope) = (wave.direction, wave.steepness * share);
            sums.height += amplitude * sin;
            sums.shift += d * (amplitude * cos);
            sums.gradient += d * (slope * cos);
            let squeeze = slope * sin;
            sums.squeeze[0] += d.x * d.x * squeeze;
            sums.squeeze[1] += d.y * d.y * squeeze;
            sums.squeeze[2] += d.x * d.y * squeeze;
        }
        sums
    }
}

impl Wave {
    /// Share of the amplitude that a ray `footprint_m` wide still sees.
    #[inline]
    fn share(&self, footprint_m: f32) -> f32 {
        (2.0 - footprint_m * self.per_metre / NARROW).clamp(0.0, 1.0)
    }
}

// A vector times the inverse of d(q + shift)/dq, which is symmetric and, because
// steepnesses sum to at most 1, positive: q + shift is the gradient of a convex
// function, so that Newton's method with shortened steps always arrives.
#[inline]
fn unsqueeze(sums: &Sums, v: Vec2) -> Vec2 {
    let [xx, zz, xz] = sums.squeeze;
    let (a, d) = (1.0 - xx, 1.0 - zz);
    let area = (a * d - xz * xz).max(AREA_MIN);
    Vec2::new(d * v.x + xz * v.y, xz * v.x + a * v.y) / area
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::scene::GerstnerWave;

    fn wave(amplitude_m: f64, wavelength_m: f64, direction_deg: f64) -> GerstnerWave {
        GerstnerWave {
            amplitude_m,
            wavelength_m,
            direction_deg,
            phase_deg: 40.0,
        }
    }

    fn sea(profile: Profile, waves: Vec<GerstnerWave>) -> GerstnerSea {
        let sea = GerstnerWater {
            height_m: 0.0,
            waves,
            profile,
            body_color: [0.0; 3],
            ior: 1.333,
            roughness: 0.0,
            velocity_mps: [0.0; 2],
            time_s: 0.0,
            loop_s: None,
        };
        GerstnerStage::new(&sea).at(0.7, [3.0, -1.0])
    }

    fn five() -> Vec<GerstnerWave> {
        vec![
            wave(0.5, 20.0, 60.0),
            wave(0.25, 13.0, 90.0),
            wave(0.15, 8.0, 20.0),
            wave(0.08, 5.0, 75.0),
            wave(0.05, 3.1, 130.0),
        ]
    }

    // Crests of a trochoid are narrow and troughs wide: mean height over x is -k a^2/2,
    // for k = 1 and a = .3 exactly -.045. A sine has none.
    #[test]
    fn a_trochoid_lies_lower_on_average() {
        for (profile, expected) in [(Profile::Trochoid, -0.045), (Profile::Sine, 0.0)] {
            let sea = sea(profile, vec![wave(0.3, 2.0 * PI, 90.0)]);
            let count = 4096;
            let step = 2.0 * PI / f64::from(count);
            let heights = (0..count).map(|i| {
                let x = (f64::from(i) * step) as f32;
                f64::from(sea.height_m(Vec2::new(x, 0.0), 0.0))
            });
            let mean = heights.sum::<f64>() / f64::from(count);
            assert!((mean - expected).abs() < 1e-6, "{profile:?}: {mean}");
        }
    }

    // Height in f64 by plain fixed-point steps, which contract by the sum of
    // steepnesses, .6 here.
    fn reference(profile: Profile, sea: &GerstnerSea, x: f64, z: f64, t: f64) -> f64 {
        let (mut qx, mut qz) = (x, z);
        let mut height = 0.0;
        for _ in 0..200 {
            let (mut shift_x, mut shift_z) = (0.0, 0.0);
            height = 0.0;
            for w in &sea.waves {
                let [kx, kz, dx, dz] = [w.k.x, w.k.y, w.direction.x, w.direction.y].map(f64::from);
                let angle = kx * qx + kz * qz - f64::from(w.omega) * t + f64::from(w.phase);
                let amplitude = f64::from(w.amplitude_m);
                height += amplitude * libm::sin(angle);
                shift_x += dx * amplitude * libm::cos(angle);
                shift_z += dz * amplitude * libm::cos(angle);
            }
            if profile == Profile::Trochoid {
                (qx, qz) = (x - shift_x, z - shift_z);
            }
        }
        height
    }

    // Analytic slopes against differences of heights.
    #[test]
    fn slopes_are_the_derivatives_of_the_heights() {
        for profile in [Profile::Trochoid, Profile::Sine] {
            let sea = sea(profile, five());
            for i in 0..100 {
                let (x, z) = (f64::from(i) * 0.17 - 8.0, f64::from(i) * 0.11 - 5.0);
                let p = Vec2::new(x as f32, z as f32);
                let (x, z) = (f64::from(p.x), f64::from(p.y));
                let height = |dx: f64, dz: f64| reference(profile, &sea, x + dx, z + dz, 0.5);
                let d = |dx: f64, dz: f64| (height(dx, dz) - height(-dx, -dz)) / 2e-4;
                let numeric = [d(1e-4, 0.0), d(0.0, 1e-4)];
                let slope = sea.at(p, 0.5, 0.0).slope;
                let error = (f64::from(slope.x) - numeric[0]).abs()
                    + (f64::from(slope.y) - numeric[1]).abs();
                assert!(error < 1e-5, "{profile:?} at {p}: {slope} {numeric:?}");
                let error = f64::from(sea.height_m(p, 0.5)) - height(0.0, 0.0);
                assert!(error.abs() < 1e-5, "{profile:?} at {p}: {error}");
            }
        }
    }

    // One trochoid has a parametric form: x = q + a cos t, y = a sin t, so that the slope
    // is e cos t / (1 - e sin t). Exact, up to the steepest.
    #[test]
    fn the_search_finds_the_water_of_a_point() {
        for steepness in [0.1, 0.5, 0.9, 0.99] {
            let sea = sea(Profile::Trochoid, vec![wave(steepness, 2.0 * PI, 90.0)]);
            for i in 0..500 {
                let q = f64::from(i) * 0.02;
                let phase = f64::from(sea.waves[0].phase);
                let (sin, cos) = (libm::sin(q + phase), libm::cos(q + phase));
                let (slope, x) = (
                    steepness * cos / (1.0 - steepness * sin),
                    q + steepness * cos,
                );
                let found = sea.at(Vec2::new(x as f32, 0.0), 0.0, 0.0).slope.x;
                // Near a cusp the slope runs away with the rounding of x.
                let open = 1.0 - steepness * sin;
                let bound = 1e-5 / (open * open * open).min(1.0);
                assert!(
                    (f64::from(found) - slope).abs() < bound,
                    "{steepness} at {q}: {found} {slope}"
                );
            }
        }
    }

    // Crests run along the direction at sqrt(g / k): 3.9513 m/s for 10 m.
    #[test]
    fn waves_run_as_fast_as_deep_water_lets_them() {
        for profile in [Profile::Trochoid, Profile::Sine] {
            let sea = sea(profile, vec![wave(0.3, 10.0, 30.0)]);
            let direction = Vec2::new(0.5, -0.866_025_4);
            for (x, t) in [(0.0, 1.0), (3.0, 0.37), (-4.0, 2.0)] {
                let p = Vec2::new(x, 2.0);
                let there = p - direction * 3.951_3 * t;
                let change = sea.height_m(p, t) - sea.height_m(there, 0.0);
                assert!(change.abs() < 1e-4, "{profile:?}: {change}");
            }
        }
    }

    // Seen from afar the slopes are roughness: their mean square stays.
    #[test]
    fn the_footprint_keeps_the_mean_square_of_slopes() {
        for profile in [Profile::Trochoid, Profile::Sine] {
            let sea = sea(profile, vec![wave(0.6, 10.0, 90.0)]);
            let square = |footprint_m: f32| {
                let count = 4096;
                let one = |i: u32| {
                    let x = i as f32 * 10.0 / count as f32;
                    let found = sea.at(Vec2::new(x, 0.0), 0.0, footprint_m);
                    f64::from(found.slope.length_squared() + 2.0 * found.variance)
                };
                (0..count).map(one).sum::<f64>() / f64::from(count)
            };
            let all = square(0.0);
            assert!(all > 0.05);
            for footprint_m in [1.0, 3.0, 4.0, 4.9, 6.0, f32::INFINITY] {
                let ratio = square(footprint_m) / all;
                assert!(
                    (ratio - 1.0).abs() < 1e-4,
                    "{profile:?} {footprint_m}: {ratio}"
                );
            }
            assert_eq!(sea.at(Vec2::ZERO, 0.0, 6.0).slope, Vec2::ZERO);
        }
    }

    #[test]
    fn any_number_is_answered() {
        let sea = sea(Profile::Trochoid, vec![wave(1.0, 2.0 * PI, 90.0)]);
        for i in 0..1000 {
            let found = sea.at(Vec2::new(i as f32 * 0.01, 0.0), 0.0, 0.0);
            assert!(found.slope.is_finite() && found.variance.is_finite());
        }
        let found = sea.at(Vec2::new(1e30, 1e9), 1.0, 1.0);
        assert!(found.variance.is_finite());
    }
}
