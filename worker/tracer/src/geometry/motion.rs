//! Transforms that change while the shutter is open.
//!
//! A chain of joints takes mesh space to world space; each is evaluated exactly
//! at a ray's own time, so a blade describes a circle and not a polygon. All of
//! it in f64, rounded once at the end: the way back from the surface then agrees
//! with the way there as well as through a transform that stands still, and the
//! error bounds of surface points are the same.

use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3, Vec3};

use super::ray::Ray;
use crate::math::elementary::sin_cos_turns;

/// Pieces of the shutter within which keyed motion is even.
pub const PIECES: usize = 4;

/// One step from the space below to the space above.
#[derive(Clone, Debug)]
pub enum Joint {
    /// Stands still.
    Fixed(DAffine3),
    /// Moves by `velocity * t`, metres per second.
    Slide(DVec3),
    /// Turns about an axis through the origin.
    Turn(Turn),
    /// Moves and turns along keys.
    Keyed(Box<Keyed>),
}

/// A steady turn.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Unit axis.
    pub axis: DVec3,
    /// Angle when the shutter opens, in turns.
    pub start: f64,
    /// Turns per second.
    pub rate: f64,
}

/// A rotation Ry * Rx * Rz, then an offset, each even within a piece of the
/// shutter.
#[derive(Clone, Copy, Debug)]
pub struct Keyed {
    /// Length of a piece, seconds, positive.
    pub piece_s: f64,
    /// Offsets at the ends of the pieces, metres.
    pub offset_m: [DVec3; PIECES + 1],
    /// Angles about x, y and z there, in turns.
    pub turns: [DVec3; PIECES + 1],
}

impl Turn {
    #[inline]
    pub(super) fn matrix(&self, time_s: f64) -> DMat3 {
        let (sin, cos) = sin_cos_turns(self.start + self.rate * time_s);
        // Rodrigues: cos I + (1 - cos) a a^T + sin [a].
        let a = self.axis;
        let (k, s) = (a * (1.0 - cos), a * sin);
        DMat3::from_cols(
            DVec3::new(cos + k.x * a.x, k.x * a.y + s.z, k.x * a.z - s.y),
            DVec3::new(k.y * a.x - s.z, cos + k.y * a.y, k.y * a.z + s.x),
            DVec3::new(k.z * a.x + s.y, k.z * a.y - s.x, cos + k.z * a.z),
        )
    }
}

impl Keyed {
    #[inline]
    pub(super) fn at(&self, time_s: f64) -> (DMat3, DVec3) {
        let piece = time_s / self.piece_s;
        let k = (piece as usize).min(PIECES - 1);
        let w = piece - k as f64;
        let between = |v: &[DVec3; PIECES + 1]| v[k] + (v[k + 1] - v[k]) * w;
        (euler(between(&self.turns)), between(&self.offset_m))
    }
}

/// Ry * Rx * Rz of angles about x, y, z in turns.
#[inline]
fn euler(turns: DVec3) -> DMat3 {
    let (sx, cx) = sin_cos_turns(turns.x);
    let (sy, cy) = sin_cos_turns(turns.y);
    let (sz, cz) = sin_cos_turns(turns.z);
    DMat3::from_cols(
        DVec3::new(cy * cz + sy * sx * sz, cx * sz, cy * sx * sz - sy * cz),
        DVec3::new(sy * sx * cz - cy * sz, cx * cz, sy * sz + cy * sx * cz),
        DVec3::new(sy * cx, -sx, cy * cx),
    )
}

impl Joint {
    /// The transform `time_s` seconds after the shutter opens.
    #[inline]
    pub fn at(&self, time_s: f64) -> DAffine3 {
        match self {
            Self::Fixed(affine) => *affine,
            Self::Slide(velocity) => DAffine3::from_translation(*velocity * time_s),
            Self::Turn(turn) => DAffine3 {
                matrix3: turn.matrix(time_s),
                translation: DVec3::ZERO,
            },
            Self::Keyed(keyed) => {
                let (matrix3, translation) = keyed.at(time_s);
                DAffine3 {
                    matrix3,
                    translation,
                }
            }
        }
    }
}

/// A chain of joints, neighbours that stand still made one.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// Mesh space last.
    joints: Vec<Joint>,
    /// How a fixed joint is undone; the identity for the others.
    undone: Vec<DAffine3>,
    /// The shutter is open from 0 to here.
    pub(super) shutter_s: f64,
}

impl Motion {
    /// `joints` from the world down to the mesh.
    pub(super) fn new(joints: Vec<Joint>, shutter_s: f32) -> Self {
        let mut merged: Vec<Joint> = Vec::new();
        for joint in joints {
            match (merged.last_mut(), joint) {
                (Some(Joint::Fixed(above)), Joint::Fixed(below)) => *above *= below,
                (_, joint) => merged.push(joint),
            }
        }
        let undo = |joint: &Joint| match joint {
            Joint::Fixed(affine) => affine.inverse(),
            _ => DAffine3::IDENTITY,
        };
        Self {
            undone: merged.iter().map(undo).collect(),
            joints: merged,
            shutter_s: f64::from(shutter_s),
        }
    }

    /// Nothing moves.
    pub(super) fn is_fixed(&self) -> bool {
        self.joints.iter().all(|j| matches!(j, Joint::Fixed(_)))
    }

    pub(super) fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Mesh space to world space at a time.
    pub(super) fn world_from_local(&self, time_s: f64) -> DAffine3 {
        let mut joints = self.joints.iter().map(|joint| joint.at(time_s));
        let first = joints.next().unwrap_or(DAffine3::IDENTITY);
        joints.fold(first, |above, below| above * below)
    }

    /// A ray in mesh space, at its own time.
    #[inline]
    pub(super) fn local_ray(&self, ray: &Ray) -> (Vec3, Vec3) {
        let time_s = f64::from(ray.time_s);
        let (mut o, mut d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        for (joint, undone) in self.joints.iter().zip(&self.undone) {
            match joint {
                Joint::Fixed(_) => {
                    o = undone.transform_point3(o);
                    d = undone.transform_vector3(d);
                }
                Joint::Slide(velocity) => o -= *velocity * time_s,
                Joint::Turn(turn) => {
                    let back = turn.matrix(time_s).transpose();
                    (o, d) = (back * o, back * d);
                }
                Joint::Keyed(keyed) => {
                    let (turned, offset) = keyed.at(time_s);
                    let back = turned.transpose();
                    (o, d) = (back * (o - offset), back * d);
                }
            }
        }
        (o.as_vec3(), d.as_vec3())
    }

    /// Both ways through the chain at a time, as a still instance has them.
    pub(super) fn both_ways(&self, time_s: f32) -> (Affine3A, Affine3A) {
        let world_from_local = self.world_from_local(f64::from(time_s));
        (
            narrow(&world_from_local),
            narrow(&world_from_local.inverse()),
        )
    }

    /// Takes normals to world space at a time; not normalised.
    pub(super) fn normal_from_local(&self, time_s: f32) -> Mat3 {
        let matrix = self.world_from_local(f64::from(time_s)).matrix3;
        matrix.inverse().transpose().as_mat3()
    }
}

pub(super) fn narrow(a: &DAffine3) -> Affine3A {
    Affine3A {
        matrix3: a.matrix3.as_mat3().into(),
        translation: a.translation.as_vec3().into(),
    }
}
