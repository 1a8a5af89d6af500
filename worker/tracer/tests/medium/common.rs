//! Volumes for tests, and what is measured of them.

use glam::{Mat3, UVec3, Vec3};
use shearwater_tracer::geometry::Ray;
use shearwater_tracer::math::hash::{mix64, u32_to_unit};
use shearwater_tracer::medium::{DensityGrid, Media, Method, Outline, Phase, Volume};

/// A uniform number for `what`.
pub(crate) fn unit(what: u64) -> f32 {
    u32_to_unit((mix64(what ^ 0x7E57) >> 32) as u32)
}

/// The box from -1 to 1 (metres) with a density.
pub(crate) fn cube(size: UVec3, values: Vec<f32>, sigma_t_per_m: f32) -> Volume {
    Volume {
        density: DensityGrid::new(size, values).expect("densities"),
        sigma_t_per_m,
        phase: Phase {
            albedo: Vec3::ONE,
            g: 0.0,
        },
        method: Method::Tracking,
        outline: Outline::Box,
        centre: Vec3::ZERO,
        voxels_from_world: Mat3::from_diagonal(size.as_vec3() * 0.5),
    }
}

/// The unit ball of density 1.
pub(crate) fn ball(sigma_t_per_m: f32) -> Volume {
    Volume {
        outline: Outline::Ellipsoid,
        ..cube(UVec3::ONE, vec![1.0], sigma_t_per_m)
    }
}

/// A cube of 24 voxels a side, most of them empty or nearly so.
pub(crate) fn lumpy(sigma_t_per_m: f32, seed: u64) -> Volume {
    lumpy_over(0.0, sigma_t_per_m, seed)
}

/// The same with `base` added everywhere.
pub(crate) fn lumpy_over(base: f32, sigma_t_per_m: f32, seed: u64) -> Volume {
    let size = UVec3::splat(24);
    let values = (0..24 * 24 * 24)
        .map(|i| {
            let (x, y, z) = (i % 24, i / 24 % 24, i / 576);
            let lump = unit(seed + x / 6 + 10 * (y / 6) + 100 * (z / 6));
            base + (lump - 0.6).max(0.0) * (0.5 + unit(seed + 1000 + i))
        })
        .collect();
    cube(size, values, sigma_t_per_m)
}

/// Rays from all around towards places inside the cube.
pub(crate) fn rays(count: u64) -> impl Iterator<Item = Ray> {
    (0..count).map(|i| {
        let at = |k| Vec3::new(unit(10 * i + k), unit(10 * i + k + 1), unit(10 * i + k + 2));
        let from = (at(1) - 0.5).normalize() * 5.0;
        let to = (at(4) - 0.5) * 1.6;
        Ray::new(from, (to - from).normalize())
    })
}

/// The optical depth of a ray up to `t_limit`, by 20,000 midpoints in f64.
pub(crate) fn depth(volume: &Volume, ray: &Ray, t_limit: f32) -> f64 {
    let Some(span) = volume.span(ray, t_limit) else {
        return 0.0;
    };
    let n = 20_000;
    let step = f64::from(span.t1 - span.t0) / f64::from(n);
    (0..n)
        .map(|i| {
            let t = f64::from(span.t0) + (f64::from(i) + 0.5) * step;
            f64::from(volume.sigma_t(span.at(t as f32)))
        })
        .sum::<f64>()
        * step
}

/// Mean and standard error of `f` over `count` keys.
pub(crate) fn mean(count: u64, mut f: impl FnMut(u64) -> f64) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for key in 0..count {
        let v = f(mix64(key + 1));
        sum += v;
        squares += v * v;
    }
    let n = count as f64;
    let mean = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

pub(crate) fn assert_near(what: &str, (mean, error): (f64, f64), expected: f64) {
    assert!(
        (mean - expected).abs() <= 5.0 * error + 1e-5,
        "{what}: {mean} +- {error}, expected {expected}"
    );
    assert!(error < 0.01, "{what}: too noisy to tell, {error}");
}

pub(crate) fn passes(media: &Media, ray: &Ray, key: u64) -> f64 {
    f64::from(media.transmittance(ray, key).expect("few steps"))
}

/// 1 if nothing was met before `t_limit`.
pub(crate) fn survives(media: &Media, ray: &Ray, t_limit: f32, key: u64) -> f64 {
    let met = media.collide(ray, t_limit, key).expect("few steps");
    f64::from(u8::from(met.is_none()))
}
