//! The radial formation.

use super::{Draws, Place};
use glam::DVec3;
use shearwater_shared::scene::RadialFormation;

/// How far the two jittered components of the spreading direction go, as in the
/// report: 0.8 u - 0.4.
const JITTER: f64 = 0.4;
/// Exponent on the uniform number that says how far a particle is pushed: below 1
/// it thins the cloud towards its far end less than linearly.
const PUSH_EXPONENT: f64 = 0.7;

/// Uniform in the core ellipsoid (uniform direction, cube-root radius), then pushed
/// along the jittered direction; opacity falls with the push.
pub(super) fn place(radial: &RadialFormation, draw: &mut Draws) -> Place {
    let axis = DVec3::from_array(radial.direction).normalize_or(DVec3::X);
    let (side, other) = axis.any_orthonormal_pair();
    let in_core = draw.in_unit_ball() * DVec3::from_array(radial.radii_m);
    let jitter = (side * (2.0 * draw.next() - 1.0) + other * (2.0 * draw.next() - 1.0)) * JITTER;
    let push = libm::pow(draw.next(), PUSH_EXPONENT);
    Place {
        centre_m: DVec3::from_array(radial.centre_m)
            + in_core
            + (axis + jitter).normalize() * (push * radial.length_m),
        size: draw.next(),
        opacity: 1.0 - push,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::chi_square::assert_counts;

    fn places(radial: &RadialFormation, count: u32) -> Vec<DVec3> {
        let centre = DVec3::from_array(radial.centre_m);
        (0..count)
            .map(|i| place(radial, &mut Draws::new(3, i)).centre_m - centre)
            .collect()
    }

    fn radial(radii_m: [f64; 3], length_m: f64) -> RadialFormation {
        RadialFormation {
            centre_m: [5.0, 0.0, -3.0],
            radii_m,
            direction: [0.0, 0.0, 2.0],
            length_m,
        }
    }

    // Uniform in the ellipsoid: cells of equal volume in the ball it comes from, by
    // radius cubed, height on the axis of any octant, and angle.
    #[test]
    fn the_core_is_a_uniform_ellipsoid() {
        let radii = DVec3::new(1.0, 0.2, 3.0);
        let (shells, rings, sectors) = (8, 6, 12);
        let mut counts = vec![0; shells * rings * sectors];
        let bin = |share: f64, bins: usize| ((share * bins as f64) as usize).min(bins - 1);
        for p in places(&radial(radii.to_array(), 0.0), 200_000) {
            let unit = p / radii;
            let radius = unit.length();
            assert!(radius < 1.0 + 1e-12);
            let shell = bin(radius * radius * radius, shells);
            // About x, so that the sampling's own axis is not that of the cells.
            let ring = bin((unit.x / radius + 1.0) / 2.0, rings);
            let turn = libm::atan2(unit.y, unit.z) / std::f64::consts::TAU + 0.5;
            counts[(shell * rings + ring) * sectors + bin(turn, sectors)] += 1;
        }
        let share = 1.0 / counts.len() as f64;
        assert_counts("core", &counts, &vec![share; counts.len()]);
    }

    // With next to no core, the way along the direction is the push, whose power
    // 1 / 0.7 is uniform, and the two jittered components are uniform about it.
    #[test]
    fn the_push_is_distributed_as_said() {
        let mut pushes = [0; 50];
        let mut sides = [0; 100];
        for p in places(&radial([1e-9; 3], 40.0), 200_000) {
            let push = libm::pow(p.length() / 40.0, 1.0 / PUSH_EXPONENT);
            pushes[((push * 50.0) as usize).min(49)] += 1;
            let cell = |side: f64| ((side / p.z / JITTER + 1.0) * 5.0).clamp(0.0, 9.0) as usize;
            sides[cell(p.x) * 10 + cell(p.y)] += 1;
        }
        assert_counts("push", &pushes, &[0.02; 50]);
        assert_counts("jitter", &sides, &[0.01; 100]);
    }
}
