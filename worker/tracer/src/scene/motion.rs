//! What moves: from velocities, spins and keys to joints and camera poses.

use super::keyframes::interpolate;
use super::transform::rotation;
use crate::geometry::{Joint, Keyed, PIECES, Turn};
use glam::{DAffine3, DMat3, DVec3};
use shearwater_shared::scene::{Camera, Instance, SceneDescription};
use std::collections::BTreeMap;

/// When the shutter opens and for how long, seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposure {
    pub(crate) open_s: f64,
    pub(crate) shutter_s: f32,
}

impl Exposure {
    /// Of a frame.
    pub(crate) fn of(description: &SceneDescription, frame: u32) -> Self {
        Self {
            open_s: description.frame_time_s(frame),
            shutter_s: description.camera.shutter_s as f32,
        }
    }

    /// Length of a piece in which keyed motion is even.
    pub(crate) fn piece_s(&self) -> f64 {
        f64::from(self.shutter_s) / PIECES as f64
    }

    /// The ends of the pieces.
    pub(crate) fn ends(&self) -> [f64; PIECES + 1] {
        std::array::from_fn(|i| self.open_s + self.piece_s() * i as f64)
    }
}

/// Who is placed in whose space, by number; itself first. A parent that does not
/// exist, or a circle, ends the chain: `validate` refuses both.
pub(super) fn chains(instances: &[Instance]) -> Vec<Vec<u32>> {
    let mut named: BTreeMap<&str, u32> = BTreeMap::new();
    for (i, instance) in instances.iter().enumerate() {
        if let Some(name) = &instance.name {
            named.insert(name, i as u32);
        }
    }
    let parent = |i: u32| {
        let parent = instances[i as usize].parent.as_ref()?;
        named.get(parent.as_str()).copied()
    };
    let numbers = 0..instances.len() as u32;
    numbers
        .map(|i| {
            std::iter::successors(Some(i), |&i| parent(i))
                .take(shearwater_shared::limits::INSTANCE_DEPTH_MAX)
                .collect()
        })
        .collect()
}

/// Whether an instance by itself stands elsewhere at another time.
pub(super) fn moves(instance: &Instance) -> bool {
    instance.velocity_mps != [0.0; 3]
        || instance.path.len() > 1
        || instance.spin.as_ref().is_some_and(|spin| spin.rpm != 0.0)
}

/// The joints of one instance in the space it is placed in, appended to those of
/// that space. `origin_m` is where that space begins: the stage's anchor for the
/// world, else zero.
pub(super) fn push_joints(
    joints: &mut Vec<Joint>,
    instance: &Instance,
    origin_m: DVec3,
    exposure: Exposure,
) {
    let is_open = exposure.shutter_s > 0.0;
    let velocity = DVec3::from_array(instance.velocity_mps);
    if is_open && velocity != DVec3::ZERO {
        joints.push(Joint::Slide(velocity));
    }
    let poses = exposure.ends().map(|time_s| pose(instance, time_s));
    let opened = DVec3::from_array(instance.translate_m) + velocity * exposure.open_s;
    let scale = DMat3::from_diagonal(DVec3::from_array(instance.scale));
    if is_open && poses.iter().any(|p| *p != poses[0]) {
        joints.push(Joint::Fixed(DAffine3::from_translation(opened - origin_m)));
        joints.push(Joint::Keyed(Box::new(Keyed {
            piece_s: exposure.piece_s(),
            offset_m: poses.map(|p| p.offset_m),
            turns: poses.map(|p| p.turn_deg / 360.0),
        })));
        joints.push(Joint::Fixed(DAffine3::from_mat3(scale)));
    } else {
        joints.push(Joint::Fixed(DAffine3 {
            matrix3: rotation(poses[0].turn_deg.to_array()) * scale,
            translation: opened + poses[0].offset_m - origin_m,
        }));
    }
    push_spin(joints, instance, exposure);
}

fn push_spin(joints: &mut Vec<Joint>, instance: &Instance, exposure: Exposure) {
    let Some(spin) = instance.spin.as_ref().filter(|spin| spin.rpm != 0.0) else {
        return;
    };
    let axis = DVec3::from_array(spin.axis);
    let rate = spin.rpm / 60.0;
    let turns = rate * exposure.open_s;
    let turn = Turn {
        // Scaled first, so that no square underflows.
        axis: (axis / axis.abs().max_element()).normalize(),
        start: turns - libm::round(turns),
        rate,
    };
    let pivot = DVec3::from_array(spin.pivot_m);
    joints.push(Joint::Fixed(DAffine3::from_translation(pivot)));
    if exposure.shutter_s > 0.0 {
        joints.push(Joint::Turn(turn));
    } else if turn.start != 0.0 {
        joints.push(Joint::Fixed(Joint::Turn(turn).at(0.0)));
    }
    joints.push(Joint::Fixed(DAffine3::from_translation(-pivot)));
}

/// Offset and angles (the placement's own with the path's) at a time.
#[derive(Clone, Copy, PartialEq)]
struct Pose {
    offset_m: DVec3,
    turn_deg: DVec3,
}

fn pose(instance: &Instance, time_s: f64) -> Pose {
    let path = &instance.path;
    let offset = interpolate(path, |k| k.time_s, |k| k.offset_m, time_s);
    let turn = interpolate(path, |k| k.time_s, |k| k.turn_deg, time_s);
    Pose {
        offset_m: DVec3::from_array(offset),
        turn_deg: DVec3::from_array(instance.rotate_deg) + DVec3::from_array(turn),
    }
}

/// Eye and target of the camera at a time, metres.
pub(crate) fn view(camera: &Camera, time_s: f64) -> (DVec3, DVec3) {
    let moved = DVec3::from_array(camera.velocity_mps) * time_s;
    let path = &camera.path;
    let eye = interpolate(path, |k| k.time_s, |k| k.offset_m, time_s);
    let target = interpolate(path, |k| k.time_s, |k| k.target_offset_m, time_s);
    (
        DVec3::from_array(camera.position_m) + moved + DVec3::from_array(eye),
        DVec3::from_array(camera.target_m) + moved + DVec3::from_array(target),
    )
}

/// Places at which the camera's path is looked at to find its middle.
const ANCHOR_SAMPLES: u32 = 1024;

/// The origin of the render space: the middle of the box around everywhere the eye
/// goes in all frames, the eye itself if it stands still.
pub(super) fn anchor(description: &SceneDescription) -> DVec3 {
    let camera = &description.camera;
    let first = description.frame_time_s(0);
    let frames = description.animation.map_or(1, |a| a.frames);
    let last = description.frame_time_s(frames.saturating_sub(1)) + camera.shutter_s;
    let start = view(camera, first).0;
    let (mut lo, mut hi) = (start, start);
    if camera.velocity_mps != [0.0; 3] || camera.path.len() > 1 {
        for i in 0..=ANCHOR_SAMPLES {
            let share = f64::from(i) / f64::from(ANCHOR_SAMPLES);
            let eye = view(camera, first + (last - first) * share).0;
            (lo, hi) = (lo.min(eye), hi.max(eye));
        }
    }
    if lo == hi { start } else { (lo + hi) * 0.5 }
}
