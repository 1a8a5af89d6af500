//! For how much of the shutter a moving thing covers a point: propellers, edges.

use glam::{DAffine3, DVec3, Vec3};
use shearwater_tracer::geometry::{Geometry, Instance, Joint, Placement, Ray, Turn};
use shearwater_tracer::uses::MOTION;

use super::motion::{SHUTTER_S, build};
use super::shapes::Mesh;

/// Sectors of `angle` turns between two radii, in the plane across z.
fn blades(count: usize, angle: f64, inner: f64, outer: f64) -> Mesh {
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
fn coverage(scene: &Geometry, x: f64, y: f64, count: u32) -> f64 {
    let blocked = (0..count).filter(|i| {
        let time_s = SHUTTER_S * ((*i as f32 + 0.5) / count as f32);
        let ray = Ray::at_time(Vec3::new(x as f32, y as f32, 5.0), Vec3::NEG_Z, time_s);
        scene.transmittance_depth::<MOTION>(&ray).is_blocked()
    });
    blocked.count() as f64 / f64::from(count)
}

fn spinning(mesh: &Mesh, turns: f64) -> Geometry {
    let turn = Joint::Turn(Turn {
        axis: DVec3::Z,
        start: 0.3,
        rate: turns / f64::from(SHUTTER_S),
    });
    let instance = Instance::moving(0, vec![turn], SHUTTER_S).unwrap();
    Geometry::build(vec![build(mesh)], vec![instance], None, None).unwrap()
}

#[test]
fn whole_turns_of_a_propeller_cover_the_same_share_at_every_radius() {
    let samples = 4096;
    for (count, degrees, expected) in [(3, 12.0, 0.1), (2, 10.0, 0.055_56), (4, 15.0, 0.166_67)] {
        let scene = spinning(
            &blades(count, degrees / 360.0, 0.1, 1.0),
            1.0 / count as f64,
        );
        for radius in [0.11, 0.3, 0.7, 0.999] {
            let found = coverage(&scene, radius * 0.6, radius * 0.8, samples);
            assert!(
                (found - expected).abs() <= 2.0 / f64::from(samples) + 1e-5,
                "{count} {radius}: {found}"
            );
        }
        assert_eq!(coverage(&scene, 1.001, 0.0, samples), 0.0);
    }
}

#[test]
fn blades_of_constant_chord_cover_less_further_out() {
    // Three rectangles of chord 0.2.
    let chord = 0.2;
    let mut mesh: Mesh = (vec![], vec![]);
    for blade in 0..3 {
        let turns = f64::from(blade) / 3.0 * std::f64::consts::TAU;
        let (u, v) = (
            Vec3::new(libm::cos(turns) as f32, libm::sin(turns) as f32, 0.0),
            Vec3::new(-libm::sin(turns) as f32, libm::cos(turns) as f32, 0.0) * (0.5 * chord),
        );
        let first = mesh.0.len() as u32;
        mesh.0.extend([v * -1.0, u * 2.0 - v, u * 2.0 + v, v]);
        mesh.1
            .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let scene = spinning(&mesh, 1.0);
    for radius in [0.25_f64, 0.5, 1.0, 1.9] {
        let expected = 3.0 / std::f64::consts::PI * libm::asin(f64::from(chord) / (2.0 * radius));
        let found = coverage(&scene, radius, 0.0, 16_384);
        assert!(
            (found - expected).abs() < 6.0 / 16_384.0,
            "{radius}: {found}, {expected}"
        );
    }
}

#[test]
fn part_of_a_turn_gives_a_trapezoid() {
    // One blade of 10 degrees turns by 30: it covers angle a for the share of the
    // shutter in which a lies within it.
    let (blade, turn) = (10.0_f64 / 360.0, 30.0_f64 / 360.0);
    let scene = spinning(&blades(1, blade, 0.1, 1.0), turn);
    let samples = 4096;
    for at in [-2.0, 1.0, 4.0, 9.0, 11.0, 25.0, 31.0, 36.0, 39.5, 41.0] {
        let angle: f64 = at / 360.0;
        // Covered while start + rate t < angle < start + rate t + blade.
        let expected = ((angle.min(turn) - (angle - blade).max(0.0)) / turn).max(0.0);
        let turns = (0.3 + angle) * std::f64::consts::TAU;
        let found = coverage(
            &scene,
            0.5 * libm::cos(turns),
            0.5 * libm::sin(turns),
            samples,
        );
        assert!(
            (found - expected).abs() <= 2.0 / f64::from(samples),
            "{at}: {found}, {expected}"
        );
    }
}

/// Vertices that moved straight would cut a quarter turn at 0.707 of the radius.
#[test]
fn a_quarter_turn_keeps_its_radius() {
    let scene = spinning(&blades(1, 2.0 / 360.0, 0.9, 1.0), 0.25);
    for radius in [0.905, 0.95, 0.999] {
        for degrees in [5.0, 30.0, 45.0, 60.0, 85.0] {
            let turns = (0.3 + degrees / 360.0) * std::f64::consts::TAU;
            let found = coverage(
                &scene,
                radius * libm::cos(turns),
                radius * libm::sin(turns),
                4096,
            );
            assert!(
                (found - 2.0 / 90.0).abs() < 2.0 / 4096.0,
                "{radius} {degrees}: {found}"
            );
        }
    }
}

#[test]
fn a_moving_edge_is_a_ramp() {
    let square = (
        vec![
            Vec3::new(-10.0, -1.0, 0.0),
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(-10.0, 1.0, 0.0),
        ],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let reach = 3.0;
    let slide = Joint::Slide(DVec3::X * reach / f64::from(SHUTTER_S));
    let instance = Instance::moving(0, vec![slide], SHUTTER_S).unwrap();
    let scene = Geometry::build(vec![build(&square)], vec![instance], None, None).unwrap();
    for x in [-0.5, 0.1, 0.75, 1.5, 2.9, 3.2] {
        let expected = (1.0 - x / reach).clamp(0.0, 1.0);
        let found = coverage(&scene, x, 0.0, 1000);
        assert!((found - expected).abs() <= 1.0 / 1000.0, "{x}: {found}");
    }
}

#[test]
fn swept_boxes_are_close() {
    let ring = |joints: Vec<Joint>, mesh: &Mesh| {
        let instance = Instance::moving(0, joints, SHUTTER_S).unwrap();
        let placement = Placement::build(&[build(mesh)], vec![instance]).unwrap();
        placement.world_box(0).unwrap()
    };
    let spin = |turns: f64| {
        Joint::Turn(Turn {
            axis: DVec3::Z,
            start: 0.0,
            rate: turns / f64::from(SHUTTER_S),
        })
    };
    let mesh = blades(3, 12.0 / 360.0, 0.1, 1.0);
    let far = Joint::Fixed(DAffine3::from_translation(DVec3::X * 50.0));
    let (lo, hi) = ring(vec![far, spin(7.0)], &mesh);
    assert!(
        lo.x > 48.97 && lo.x <= 49.0 && hi.x < 51.03 && hi.x >= 51.0,
        "{lo} {hi}"
    );
    assert!(hi.z - lo.z < 1e-3, "a propeller's disc is flat: {lo} {hi}");
    // A twentieth of a turn of one blade stays near the blade.
    let (lo, hi) = ring(vec![spin(0.05)], &blades(1, 12.0 / 360.0, 0.1, 1.0));
    assert!(
        lo.x > 0.0 && lo.y > -0.02 && hi.x < 1.02 && hi.y < 0.56,
        "{lo} {hi}"
    );
    let (lo, hi) = ring(vec![Joint::Slide(DVec3::X * 4.0)], &mesh);
    assert!(hi.x - lo.x < 3.0 + 1e-3, "{lo} {hi}");
}
