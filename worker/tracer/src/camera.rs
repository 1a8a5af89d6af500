//! Camera rays.

use crate::geometry::PIECES;
use crate::math::warp::uniform_disc;
use crate::scene::motion::{Exposure, view};
use crate::uses;
use glam::{DVec3, Vec2, Vec3};
use shearwater_shared::scene;

/// A camera in render space, still or moving.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    /// When the shutter opens.
    opening: View,
    motion: Option<Box<Motion>>,
    // Pixel coordinates of the middle of the picture.
    centre: Vec2,
    lens_radius_m: f32,
    shutter_s: f32,
    /// Angle of one pixel in the middle of the picture, in radians.
    pub(crate) pixel_angle_rad: f32,
}

/// Where the camera is and how it looks, at one time.
#[derive(Clone, Copy, Debug)]
struct View {
    eye: Vec3,
    forward: Vec3,
    // To the right and downwards, as long as one pixel at distance 1.
    right: Vec3,
    down: Vec3,
    lens_right: Vec3,
    lens_up: Vec3,
    focus_distance_m: f32,
}

/// What it takes to see at another time.
#[derive(Clone, Debug)]
struct Motion {
    piece_s: f64,
    /// Relative to the anchor, at the ends of even pieces of the shutter.
    eye_m: [DVec3; PIECES + 1],
    target_m: [DVec3; PIECES + 1],
    sight: Sight,
}

/// What a view needs besides eye and target.
#[derive(Clone, Copy, Debug)]
struct Sight {
    up: DVec3,
    /// Side of a pixel at distance 1.
    pixel: f64,
    focus_distance_m: Option<f64>,
}

/// Why there is no view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "at some time of this frame the eye is on its target, or looks along `up`: move the keys apart"
)]
pub(crate) struct NoView;

impl View {
    fn new(eye: DVec3, target: DVec3, sight: &Sight) -> Option<Self> {
        let view = target - eye;
        let distance_m = view.length();
        let forward = view / distance_m;
        let right = forward.cross(sight.up).try_normalize()?;
        let up = right.cross(forward);
        Some(Self {
            eye: eye.as_vec3(),
            forward: forward.as_vec3(),
            right: (right * sight.pixel).as_vec3(),
            down: (-up * sight.pixel).as_vec3(),
            lens_right: right.as_vec3(),
            lens_up: up.as_vec3(),
            focus_distance_m: sight.focus_distance_m.unwrap_or(distance_m) as f32,
        })
    }
}

impl Motion {
    fn at(&self, time_s: f32) -> Option<View> {
        let piece = f64::from(time_s) / self.piece_s;
        let k = (piece as usize).min(PIECES - 1);
        let w = piece - k as f64;
        let between = |v: &[DVec3; PIECES + 1]| v[k] + (v[k + 1] - v[k]) * w;
        View::new(between(&self.eye_m), between(&self.target_m), &self.sight)
    }
}

impl Camera {
    /// A camera for a picture of `width` x `height` pixels, in the render space
    /// about `anchor_m`. Its own motion is exact; keyed motion is even within
    /// quarters of the shutter.
    ///
    /// # Errors
    /// A target on the eye, a view along `up`.
    pub(crate) fn new(
        camera: &scene::Camera,
        anchor_m: DVec3,
        exposure: Exposure,
        (width, height): (u32, u32),
    ) -> Result<Self, NoView> {
        let half_height = libm::tan(camera.vertical_fov_deg.to_radians() * 0.5);
        let pixel = 2.0 * half_height / f64::from(height);
        let sight = Sight {
            up: DVec3::from_array(camera.up),
            pixel,
            focus_distance_m: camera.focus_distance_m,
        };
        let ends = exposure.ends().map(|time_s| view(camera, time_s));
        let (eye_m, target_m) = (
            ends.map(|(eye, _)| eye - anchor_m),
            ends.map(|(_, target)| target - anchor_m),
        );
        let seen = |i: usize| View::new(eye_m[i], target_m[i], &sight).ok_or(NoView);
        for i in 0..=PIECES {
            seen(i)?;
        }
        let is_moving = exposure.shutter_s > 0.0 && ends.iter().any(|end| *end != ends[0]);
        let motion = Motion {
            piece_s: exposure.piece_s(),
            eye_m,
            target_m,
            sight,
        };
        Ok(Self {
            opening: seen(0)?,
            motion: is_moving.then(|| Box::new(motion)),
            centre: Vec2::new(width as f32 * 0.5, height as f32 * 0.5),
            lens_radius_m: camera.lens_radius_m as f32,
            shutter_s: exposure.shutter_s,
            pixel_angle_rad: pixel as f32,
        })
    }

    /// Where the eye is when the shutter opens, render space, metres.
    #[must_use]
    pub(crate) fn eye_m(&self) -> Vec3 {
        self.opening.eye
    }

    /// Whether it moves while the shutter is open.
    #[must_use]
    pub(crate) fn is_moving(&self) -> bool {
        self.motion.is_some()
    }

    /// Whether rays need a position on the lens.
    #[inline]
    #[must_use]
    pub(crate) fn has_lens(&self) -> bool {
        self.lens_radius_m > 0.0
    }

    /// Time of a sample after the shutter opens, in seconds; `u` in [0, 1).
    #[inline]
    #[must_use]
    pub(crate) fn time_s(&self, u: f32) -> f32 {
        self.shutter_s * u
    }

    /// Origin and unit direction through the picture at (x, y) in pixels, from the
    /// lens at `lens` in [0, 1)^2, `time_s` seconds after the shutter opens. Without
    /// [`MOTION`](uses::MOTION) in `USES` the camera stands where it was then.
    #[inline]
    #[must_use]
    pub(crate) fn ray<const USES: u8>(
        &self,
        x: f32,
        y: f32,
        lens: [f32; 2],
        time_s: f32,
    ) -> (Vec3, Vec3) {
        if USES & uses::MOTION != 0
            && let Some(motion) = &self.motion
        {
            // Only the shutter's ends were checked: in between, a view that is
            // none is that of the opening.
            let view = motion.at(time_s).unwrap_or(self.opening);
            return self.ray_of(&view, x, y, lens);
        }
        self.ray_of(&self.opening, x, y, lens)
    }

    #[inline]
    fn ray_of(&self, view: &View, x: f32, y: f32, lens: [f32; 2]) -> (Vec3, Vec3) {
        let d = view.forward + view.right * (x - self.centre.x) + view.down * (y - self.centre.y);
        if !self.has_lens() {
            return (view.eye, d.normalize());
        }
        let on_lens = uniform_disc(lens) * self.lens_radius_m;
        let offset = view.lens_right * on_lens.x + view.lens_up * on_lens.y;
        // All rays of a pixel meet where its pinhole ray meets the plane of focus.
        let d = (d * view.focus_distance_m - offset).normalize();
        (view.eye + offset, d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description() -> scene::Camera {
        scene::Camera {
            position_m: [10.0, 5.0, 3.0],
            target_m: [10.0, 5.0, -7.0],
            up: [0.0, 1.0, 0.0],
            vertical_fov_deg: 90.0,
            shutter_s: 0.5,
            lens_radius_m: 0.0,
            focus_distance_m: None,
            velocity_mps: [0.0; 3],
            path: Vec::new(),
        }
    }

    const EXPOSURE: Exposure = Exposure {
        open_s: 0.0,
        shutter_s: 0.5,
    };

    fn camera(description: &scene::Camera) -> Camera {
        let anchor = DVec3::from_array(description.position_m);
        Camera::new(description, anchor, EXPOSURE, (200, 100)).unwrap()
    }

    #[test]
    fn the_picture_has_its_corners_where_they_belong() {
        let camera = camera(&description());
        let (_, middle) = camera.ray::<0>(100.0, 50.0, [0.0; 2], 0.0);
        assert!((middle - Vec3::NEG_Z).length() < 1e-6);
        let (_, top_left) = camera.ray::<0>(0.0, 0.0, [0.0; 2], 0.0);
        assert!(
            (top_left - Vec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-6,
            "{top_left}"
        );
        assert!((camera.time_s(0.5) - 0.25).abs() < 1e-7);
    }

    #[test]
    fn lens_rays_meet_at_the_focus() {
        let camera = camera(&scene::Camera {
            lens_radius_m: 0.3,
            ..description()
        });
        let focus = |lens| {
            let (o, d) = camera.ray::<0>(30.0, 80.0, lens, 0.0);
            o + d * ((-10.0 - o.z) / d.z)
        };
        for lens in [[0.1, 0.9], [0.7, 0.2], [0.99, 0.5]] {
            assert!((focus(lens) - focus([0.4, 0.4])).length() < 1e-4);
        }
    }
}
