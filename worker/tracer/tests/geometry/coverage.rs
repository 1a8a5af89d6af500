//! For how much of the shutter a moving thing covers a point: propellers, edges.

use glam::{DAffine3, DVec3};
use shearwater_tracer::geometry::{Instance, Joint, Placement, Turn};

use super::blades::{blades, coverage, spinning};
use super::joints::{SHUTTER_S, build};
use super::shapes::Mesh;

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
