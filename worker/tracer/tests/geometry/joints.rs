//! Instances in motion for tests.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use shearwater_tracer::geometry::{Joint, Keyed, PIECES, TriMesh, Turn};

use super::shapes::{Mesh, Random, skew};

/// How long the shutter is open.
pub(crate) const SHUTTER_S: f32 = 0.25;

fn axis(r: &mut Random) -> DVec3 {
    r.direction().as_dvec3().normalize()
}

fn keyed(r: &mut Random, reach: f64, turn: f64) -> Joint {
    let mut at = || r.cube().as_dvec3();
    Joint::Keyed(Box::new(Keyed {
        piece_s: f64::from(SHUTTER_S) / PIECES as f64,
        offset_m: std::array::from_fn(|_| at() * reach),
        turns: std::array::from_fn(|_| at() * turn),
    }))
}

pub(crate) fn fixed(seed: u64) -> Joint {
    let m = skew(seed);
    Joint::Fixed(DAffine3 {
        matrix3: DMat3::from_cols(
            m.matrix3.x_axis.as_dvec3(),
            m.matrix3.y_axis.as_dvec3(),
            m.matrix3.z_axis.as_dvec3(),
        ),
        translation: m.translation.as_dvec3(),
    })
}

/// Chains of every kind: slow and fast turns, slides, keys, and all of them.
pub(crate) fn chain(seed: u64) -> Vec<Joint> {
    let mut r = Random(seed + 900);
    let turn = |r: &mut Random, most: f64| {
        Joint::Turn(Turn {
            axis: axis(r),
            start: f64::from(r.unit()),
            rate: most * (2.0 * f64::from(r.unit()) - 1.0) / f64::from(SHUTTER_S),
        })
    };
    let slide = |r: &mut Random| Joint::Slide(r.cube().as_dvec3() * 8.0);
    match seed % 6 {
        0 => vec![fixed(seed), turn(&mut r, 0.24), fixed(seed + 1)],
        1 => vec![fixed(seed), turn(&mut r, 3.0), fixed(seed + 1)],
        2 => vec![slide(&mut r), fixed(seed)],
        3 => vec![fixed(seed), keyed(&mut r, 1.0, 0.1), fixed(seed + 1)],
        4 => vec![keyed(&mut r, 0.5, 1.0), fixed(seed)],
        _ => vec![
            slide(&mut r),
            fixed(seed),
            keyed(&mut r, 0.4, 0.05),
            fixed(seed + 1),
            turn(&mut r, 0.2),
            fixed(seed + 2),
            turn(&mut r, 5.0),
            fixed(seed + 3),
        ],
    }
}

/// The product of a chain, by other formulas than the tracer's.
pub(crate) fn product(joints: &[Joint], time_s: f64) -> DAffine3 {
    let turned = |axis: DVec3, turns: f64| {
        let (sin, cos) = (
            libm::sin(turns * std::f64::consts::PI),
            libm::cos(turns * std::f64::consts::PI),
        );
        let half = axis * sin;
        DAffine3::from_quat(DQuat::from_xyzw(half.x, half.y, half.z, cos))
    };
    let one = |joint: &Joint| match joint {
        Joint::Fixed(affine) => *affine,
        Joint::Slide(velocity) => DAffine3::from_translation(*velocity * time_s),
        Joint::Turn(turn) => turned(turn.axis, turn.start + turn.rate * time_s),
        Joint::Keyed(keyed) => {
            let k = ((time_s / keyed.piece_s) as usize).min(PIECES - 1);
            let w = time_s / keyed.piece_s - k as f64;
            let a = keyed.turns[k].lerp(keyed.turns[k + 1], w);
            let offset = keyed.offset_m[k].lerp(keyed.offset_m[k + 1], w);
            DAffine3::from_translation(offset)
                * turned(DVec3::Y, a.y)
                * turned(DVec3::X, a.x)
                * turned(DVec3::Z, a.z)
        }
    };
    joints
        .iter()
        .map(one)
        .fold(DAffine3::IDENTITY, |a, b| a * b)
}

pub(crate) fn build(mesh: &Mesh) -> TriMesh {
    TriMesh::build(&mesh.0, &mesh.1).unwrap()
}
