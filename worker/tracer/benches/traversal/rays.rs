//! The three kinds of rays a path tracer shoots, 524,288 of each.

use glam::Vec3;
use shearwater_tracer::geometry::{Geometry, Ray};
use shearwater_tracer::uses::NOTHING;

use super::scenes::Scene;

const WIDTH: usize = 1024;
const HEIGHT: usize = 512;

/// Rays of each kind.
pub(crate) const COUNT: usize = WIDTH * HEIGHT;

/// Sine of the sun's angular radius, 0.27 degrees.
const SUN_RADIUS: f32 = 0.004_712;

pub(crate) struct Rays {
    /// Camera rays, in tiles of 8x8 and within these in groups of 4x2.
    pub(crate) primary: Vec<Ray>,
    /// Cosine-distributed from the hits of the camera rays.
    pub(crate) diffuse: Vec<Ray>,
    /// From the same hits to the disc of the sun.
    pub(crate) shadow: Vec<Ray>,
    /// Share of the camera rays that hit.
    pub(crate) covered: f32,
}

pub(crate) fn shoot(scene: &Scene, geometry: &Geometry) -> Rays {
    let primary = camera_rays(scene);
    let hits: Vec<_> = primary
        .iter()
        .filter_map(|ray| {
            geometry
                .intersect::<NOTHING>(ray, 0)
                .map(|hit| (ray, geometry.surface_point(ray, &hit)))
        })
        .collect();
    let mut random = Random(1);
    let mut diffuse = Vec::with_capacity(COUNT);
    let mut shadow = Vec::with_capacity(COUNT);
    let sun = Vec3::new(0.5, 0.35, 0.6).normalize();
    // Every hit in turn, as often as the count asks.
    for i in 0..COUNT {
        let (ray, point) = &hits[i % hits.len()];
        let n = if point.n_geometric.dot(ray.d) < 0.0 {
            point.n_geometric
        } else {
            -point.n_geometric
        };
        let d = (n + random.direction()).normalize_or(n);
        diffuse.push(Ray::new(point.origin_towards(d), d));
        let d = (sun + random.direction() * SUN_RADIUS).normalize();
        shadow.push(Ray::new(point.origin_towards(d), d));
    }
    Rays {
        covered: hits.len() as f32 / COUNT as f32,
        primary,
        diffuse,
        shadow,
    }
}

fn camera_rays(scene: &Scene) -> Vec<Ray> {
    let forward = (scene.target - scene.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize() * scene.half_width;
    let up = right.cross(forward).normalize() * (scene.half_width * HEIGHT as f32 / WIDTH as f32);
    let mut rays = Vec::with_capacity(COUNT);
    for tile in 0..COUNT / 64 {
        for i in 0..64 {
            let (group, lane) = (i / 8, i % 8);
            let x = tile % (WIDTH / 8) * 8 + group % 2 * 4 + lane % 4;
            let y = tile / (WIDTH / 8) * 8 + group / 2 * 2 + lane / 4;
            let sx = (x as f32 + 0.5) / WIDTH as f32 * 2.0 - 1.0;
            let sy = 1.0 - (y as f32 + 0.5) / HEIGHT as f32 * 2.0;
            rays.push(Ray::new(
                scene.eye,
                (forward + right * sx + up * sy).normalize(),
            ));
        }
    }
    rays
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0;
            let l = v.length_squared();
            if l > 1e-4 && l < 1.0 {
                return v.normalize();
            }
        }
    }
}
