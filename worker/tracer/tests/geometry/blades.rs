//! Propellers, and for how much of the shutter they cover a point.

use glam::{DVec3, Vec3};
use shearwater_tracer::geometry::{Geometry, Instance, Joint, Ray, Turn};
use shearwater_tracer::uses::MOTION;

use super::joints::{SHUTTER_S, build};
use super::shapes::Mesh;

/// Sectors of `angle` turns between two radii, in the plane across z.
pub(crate) fn blades(count: usize, angle: f64, inner: f64, outer: f64) -> Mesh {
    let steps = 64;
    let mut mesh: Mesh = (vec![], vec![]);
    for blade in 0..count {
        for step in 0..=steps {
            let turns = blade as f64 / count as f64 + angle * f64::from(step) / f64::from(steps);
            let (sin, cos) = (
                libm::sin(turns * std::f64::consts::TAU),
                libm::cos(turns * std::f64::consts::TAU),
            );
            // Outside of the chord, so that the rim is no less than the radius.
            let rim = Vec3::new(cos as f32, sin as f32, 0.0);
            mesh.0.extend([rim * inner as f32, rim * outer as f32]);
        }
        let first = (blade * 2 * (steps as usize + 1)) as u32;
        for step in 0..steps as u32 {
            let a = first + 2 * step;
            mesh.1.extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
        }
    }
    mesh
}

/// Share of the shutter for which a ray along z at (x, y) is blocked.
pub(crate) fn coverage(scene: &Geometry, x: f64, y: f64, count: u32) -> f64 {
    let blocked = (0..count).filter(|i| {
        let time_s = SHUTTER_S * ((*i as f32 + 0.5) / count as f32);
        let ray = Ray::at_time(Vec3::new(x as f32, y as f32, 5.0), Vec3::NEG_Z, time_s);
        scene.transmittance_depth::<MOTION>(&ray).is_blocked()
    });
    blocked.count() as f64 / f64::from(count)
}

pub(crate) fn spinning(mesh: &Mesh, turns: f64) -> Geometry {
    let turn = Joint::Turn(Turn {
        axis: DVec3::Z,
        start: 0.3,
        rate: turns / f64::from(SHUTTER_S),
    });
    let instance = Instance::moving(0, vec![turn], SHUTTER_S).unwrap();
    Geometry::build(vec![build(mesh)], vec![instance], None, None).unwrap()
}
