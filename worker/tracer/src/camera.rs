//! Camera rays.

use crate::math::warp::uniform_disc;
use glam::{DVec3, Vec2, Vec3};
use shearwater_shared::scene;

/// A camera at the origin of the render space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    forward: Vec3,
    // To the right and downwards, as long as one pixel at distance 1.
    right: Vec3,
    down: Vec3,
    // Pixel coordinates of the middle of the picture.
    centre: Vec2,
    lens_radius_m: f32,
    focus_distance_m: f32,
    lens_right: Vec3,
    lens_up: Vec3,
    shutter_s: f32,
    /// Angle of one pixel in the middle of the picture, in radians.
    pub(crate) pixel_angle_rad: f32,
}

impl Camera {
    /// A camera for a picture of `width` x `height` pixels. The description must
    /// be valid: a target apart from the eye, an up that is not the view.
    #[must_use]
    pub(crate) fn new(camera: &scene::Camera, width: u32, height: u32) -> Self {
        let eye = DVec3::from_array(camera.position_m);
        let view = DVec3::from_array(camera.target_m) - eye;
        let distance_m = view.length();
        let forward = view / distance_m;
        let right = forward.cross(DVec3::from_array(camera.up)).normalize();
        let up = right.cross(forward);
        let half_height = libm::tan(camera.vertical_fov_deg.to_radians() * 0.5);
        let pixel = 2.0 * half_height / f64::from(height);
        Self {
            forward: forward.as_vec3(),
            right: (right * pixel).as_vec3(),
            down: (-up * pixel).as_vec3(),
            centre: Vec2::new(width as f32 * 0.5, height as f32 * 0.5),
            lens_radius_m: camera.lens_radius_m as f32,
            focus_distance_m: camera.focus_distance_m.unwrap_or(distance_m) as f32,
            lens_right: right.as_vec3(),
            lens_up: up.as_vec3(),
            shutter_s: camera.shutter_s as f32,
            pixel_angle_rad: pixel as f32,
        }
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
    /// lens at `lens` in [0, 1)^2.
    #[inline]
    #[must_use]
    pub(crate) fn ray(&self, x: f32, y: f32, lens: [f32; 2]) -> (Vec3, Vec3) {
        let d = self.forward + self.right * (x - self.centre.x) + self.down * (y - self.centre.y);
        if !self.has_lens() {
            return (Vec3::ZERO, d.normalize());
        }
        let on_lens = uniform_disc(lens) * self.lens_radius_m;
        let origin = self.lens_right * on_lens.x + self.lens_up * on_lens.y;
        // All rays of a pixel meet where its pinhole ray meets the plane of focus.
        (origin, (d * self.focus_distance_m - origin).normalize())
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

    #[test]
    fn the_picture_has_its_corners_where_they_belong() {
        let camera = Camera::new(&description(), 200, 100);
        let (_, middle) = camera.ray(100.0, 50.0, [0.0; 2]);
        assert!((middle - Vec3::NEG_Z).length() < 1e-6);
        let (_, top_left) = camera.ray(0.0, 0.0, [0.0; 2]);
        assert!(
            (top_left - Vec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-6,
            "{top_left}"
        );
        assert!((camera.time_s(0.5) - 0.25).abs() < 1e-7);
    }

    #[test]
    fn lens_rays_meet_at_the_focus() {
        let camera = Camera::new(
            &scene::Camera {
                lens_radius_m: 0.3,
                ..description()
            },
            200,
            100,
        );
        let focus = |lens| {
            let (o, d) = camera.ray(30.0, 80.0, lens);
            o + d * ((-10.0 - o.z) / d.z)
        };
        for lens in [[0.1, 0.9], [0.7, 0.2], [0.99, 0.5]] {
            assert!((focus(lens) - focus([0.4, 0.4])).length() < 1e-4);
        }
    }
}
