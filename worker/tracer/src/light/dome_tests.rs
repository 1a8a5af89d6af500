//! The dome against geometry: inverse squares, parallax, densities.

use super::*;
use crate::light::MapTables;
use crate::math::frame::Frame;
use crate::math::hash::{mix32, u32_to_unit};
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use std::f64::consts::PI;

const CENTRE: Vec3 = Vec3::new(30.0, -20.0, 10.0);
const RADIUS: f32 = 500.0;

fn dome(width: usize, height: usize, texel: impl Fn(usize, usize) -> f32) -> SkyDome {
    let rgb = (0..width * height)
        .map(|i| [texel(i % width, i / width); 3])
        .collect();
    let any = MapTables {
        any_contrast: true,
        ..MapTables::default()
    };
    let map = SkyMap::new(width, height, rgb, 0.0, any);
    SkyDome::new(Arc::new(map), CENTRE, RADIUS)
}

fn draw(i: u32) -> [f32; 2] {
    [mix32(2 * i + 1), mix32(2 * i + 0x8000_0001)].map(u32_to_unit)
}

// Mean and its standard error.
fn mean_of(n: u32, value: impl Fn([f32; 2]) -> f64) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..n {
        let v = value(draw(i));
        sum += v;
        squares += v * v;
    }
    let mean = sum / f64::from(n);
    let variance = (squares / f64::from(n) - mean * mean).max(0.0);
    (mean, (variance / f64::from(n)).sqrt())
}

fn by_light(dome: &SkyDome, o: Vec3, normal: Vec3, u: [f32; 2]) -> f64 {
    dome.sample(o, u).map_or(0.0, |s| {
        f64::from(s.radiance.x * s.wi.dot(normal).max(0.0) / s.pdf)
    })
}

fn by_surface(dome: &SkyDome, o: Vec3, normal: Vec3, u: [f32; 2]) -> f64 {
    let wi = Frame::from_normal(normal).to_world(cosine_hemisphere(u));
    PI * f64::from(dome.radiance(o, wi.normalize()).x)
}

// Both, by the power heuristic.
fn by_both(dome: &SkyDome, o: Vec3, normal: Vec3, u: [f32; 2], v: [f32; 2]) -> f64 {
    let weight = |a: f32, b: f32| f64::from(a * a / (a * a + b * b));
    let light = dome.sample(o, u).map_or(0.0, |s| {
        let cos = s.wi.dot(normal).max(0.0);
        f64::from(s.radiance.x * cos / s.pdf) * weight(s.pdf, cosine_hemisphere_pdf(cos))
    });
    let wi = Frame::from_normal(normal).to_world(cosine_hemisphere(v));
    let (radiance, pdf) = dome.radiance_and_pdf(o, wi.normalize());
    light + PI * f64::from(radiance.x) * weight(cosine_hemisphere_pdf(wi.dot(normal)), pdf)
}

// Points inside: the centre, off it, and close to the wall.
fn inside() -> [(Vec3, Vec3); 3] {
    [
        (CENTRE, Vec3::Y),
        (CENTRE + Vec3::new(200.0, -100.0, 150.0), Vec3::Y),
        (
            CENTRE + Vec3::new(0.0, 0.0, -470.0),
            Vec3::new(0.6, 0.0, 0.8),
        ),
    ]
}

#[test]
fn a_constant_dome_gives_pi_everywhere_inside() {
    let dome = dome(64, 32, |_, _| 1.0);
    for (o, normal) in inside() {
        let (mean, error) = mean_of(1 << 17, |u| by_light(&dome, o, normal, u));
        assert!(
            (mean - PI).abs() < 4.0 * error,
            "{o}: {mean} +- {error} by the light"
        );
        let (mean, _) = mean_of(1 << 10, |u| by_surface(&dome, o, normal, u));
        assert!(
            (mean - PI).abs() < 1e-5,
            "{o}: {mean} by the surface's directions"
        );
    }
}

// A patch of the wall that is small beside its distance: E = L A cos cos / d^2,
// integrated over the hat of its bilinear texel.
#[test]
fn a_patch_obeys_the_inverse_square() {
    let (width, height, column, row) = (256usize, 128usize, 128usize, 40usize);
    let dome = dome(width, height, |x, y| {
        if (x, y) == (column, row) { 1e4 } else { 0.0 }
    });
    for (o, normal) in inside() {
        let mut expected = 0.0f64;
        let fine = 32;
        for i in 0..2 * fine {
            for j in 0..2 * fine {
                let offset = |k: i32| (f64::from(k) + 0.5) / f64::from(fine) - 1.0;
                let hat = (1.0 - offset(i).abs()) * (1.0 - offset(j).abs());
                let theta = PI * (row as f64 + 0.5 + offset(j)) / height as f64;
                let phi = 2.0 * PI * ((column as f64 + 0.5 + offset(i)) / width as f64 - 0.5);
                let n = glam::DVec3::new(
                    libm::sin(theta) * libm::sin(phi),
                    libm::cos(theta),
                    -libm::sin(theta) * libm::cos(phi),
                );
                let area = f64::from(RADIUS * RADIUS) * libm::sin(theta) * 2.0 * PI * PI
                    / (width * height) as f64
                    / f64::from(fine * fine);
                let d = CENTRE.as_dvec3() + n * f64::from(RADIUS) - o.as_dvec3();
                let cosines = d.dot(normal.as_dvec3()).max(0.0) * d.dot(n);
                let squared = d.length_squared();
                expected += 1e4 * hat * area * cosines / (squared * squared);
            }
        }
        let (mean, error) = mean_of(1 << 17, |u| by_light(&dome, o, normal, u));
        assert!(expected > 0.0);
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-3 * expected,
            "{o}: {mean} +- {error} against {expected}"
        );
    }
}

// One place of the wall lies where it lies: two points see it in two directions
// that meet there.
#[test]
fn parallax_is_real() {
    let (width, height) = (64usize, 32usize);
    let dome = dome(
        width,
        height,
        |x, y| if (x, y) == (10, 12) { 9.0 } else { 0.0 },
    );
    let theta = PI * 12.5 / height as f64;
    let phi = 2.0 * PI * (10.5 / width as f64 - 0.5);
    let n = Vec3::new(
        (libm::sin(theta) * libm::sin(phi)) as f32,
        libm::cos(theta) as f32,
        (-libm::sin(theta) * libm::cos(phi)) as f32,
    );
    let place = CENTRE + n * RADIUS;
    let mut directions = Vec::new();
    for (o, _) in inside() {
        let d = (place - o).normalize();
        assert!((dome.radiance(o, d).x - 9.0).abs() < 0.01, "{o}");
        assert!((dome.reach(o, d) / (place - o).length() - 1.0).abs() < 1e-5);
        directions.push(d);
    }
    // Ten degrees at least; a texel has less than six.
    assert!(directions[1..].iter().all(|d| d.dot(directions[0]) < 0.985));
    assert_eq!(
        dome.radiance(CENTRE, directions[1]).x,
        0.0,
        "a map at infinity would shine here"
    );
}

#[test]
fn every_technique_agrees_on_a_dome_with_a_hot_spot() {
    let dome = dome(32, 16, |x, y| if (x, y) == (16, 5) { 200.0 } else { 0.5 });
    for (o, normal) in inside() {
        let light = mean_of(1 << 18, |u| by_light(&dome, o, normal, u));
        let surface = mean_of(1 << 20, |u| by_surface(&dome, o, normal, u));
        let both = mean_of(1 << 18, |u| {
            let v = [u[1], u[0]].map(|v| mix32((v * 16_777_216.0) as u32));
            by_both(&dome, o, normal, u, v.map(u32_to_unit))
        });
        for (what, other) in [("surface", surface), ("both", both)] {
            let spread = (light.1 * light.1 + other.1 * other.1).sqrt();
            assert!(
                (light.0 - other.0).abs() < 4.0 * spread,
                "{o}: light {light:?}, {what} {other:?}"
            );
        }
    }
}

// The density integrates to 1 over the directions from any point inside, and to
// the share of the wall that faces it from outside.
#[test]
fn the_density_is_one_over_all_directions() {
    let dome = dome(32, 16, |x, y| 0.1 + ((x * 7 + y * 13) % 11) as f32);
    let outside = (CENTRE + Vec3::new(900.0, 100.0, 0.0), Vec3::Y);
    for (o, _) in inside().into_iter().chain([outside]) {
        let (total, error) = mean_of(1 << 20, |u| {
            let y = 1.0 - 2.0 * u[0];
            let (sin, cos) = crate::math::elementary::sin_cos(2.0 * std::f32::consts::PI * u[1]);
            let r = (1.0 - y * y).max(0.0).sqrt();
            let (_, pdf) = dome.radiance_and_pdf(o, Vec3::new(r * cos, y, r * sin));
            4.0 * PI * f64::from(pdf)
        });
        let (share, share_error) = mean_of(1 << 16, |u| {
            f64::from(u8::from(dome.sample(o, u).is_some()))
        });
        let spread = (error * error + share_error * share_error).sqrt();
        assert!(
            (total - share).abs() < 4.0 * spread,
            "{o}: {total} +- {error} for a share of {share}"
        );
    }
}

// Chi-square of directions from an off-centre point against the stated density,
// at 0.001.
#[test]
fn sampled_directions_follow_the_density() {
    let dome = dome(16, 8, |x, y| if (x + 3 * y) % 7 == 0 { 20.0 } else { 0.2 });
    let o = inside()[1].0;
    let (columns, rows, fine) = (16usize, 8usize, 64usize);
    let n = 1u32 << 18;
    let cell = |d: Vec3| {
        let azimuth = libm::atan2(f64::from(d.x), f64::from(d.z)) / (2.0 * PI) + 0.5;
        let row = (((1.0 - f64::from(d.y)) * 0.5 * rows as f64) as usize).min(rows - 1);
        row * columns + ((azimuth * columns as f64) as usize).min(columns - 1)
    };
    let mut counts = vec![0.0f64; columns * rows];
    for i in 0..n {
        let s = dome.sample(o, draw(i)).expect("light everywhere inside");
        let (_, pdf) = dome.radiance_and_pdf(o, s.wi);
        // On the border of two cells of the map rounding may choose the other.
        if (pdf / s.pdf - 1.0).abs() > 1e-2 {
            continue;
        }
        counts[cell(s.wi)] += 1.0;
    }
    // The expected shares by a fine grid of directions, equal in solid angle.
    let mut expected = vec![0.0f64; columns * rows];
    let (wide, high) = (columns * fine, rows * fine);
    for j in 0..high {
        let y = 1.0 - 2.0 * (j as f64 + 0.5) / high as f64;
        let r = (1.0 - y * y).sqrt();
        for i in 0..wide {
            let a = 2.0 * PI * ((i as f64 + 0.5) / wide as f64 - 0.5);
            let d = glam::DVec3::new(r * libm::sin(a), y, r * libm::cos(a)).as_vec3();
            let (_, pdf) = dome.radiance_and_pdf(o, d);
            expected[cell(d)] += f64::from(pdf) * 4.0 * PI / (wide * high) as f64 * f64::from(n);
        }
    }
    let total: f64 = counts.iter().sum();
    assert!(total > 0.999 * f64::from(n), "{total}");
    let chi: f64 = counts
        .iter()
        .zip(&expected)
        .map(|(c, e)| (c - e) * (c - e) / e)
        .sum();
    // 127 degrees of freedom: the 0.999 quantile is 181.
    assert!(chi < 181.0, "{chi}");
}

#[test]
fn from_outside_only_the_far_wall_shines() {
    let dome = dome(8, 4, |_, _| 3.0);
    let o = CENTRE + Vec3::new(2000.0, 0.0, 0.0);
    assert_eq!(dome.radiance(o, Vec3::NEG_X).x, 3.0);
    assert!((dome.reach(o, Vec3::NEG_X) - 2500.0).abs() < 0.01);
    for missed in [Vec3::X, Vec3::Y, Vec3::Z] {
        assert_eq!(dome.radiance(o, missed), Vec3::ZERO);
        assert_eq!(dome.reach(o, missed), f32::INFINITY);
    }
    assert_eq!(dome.radiance(Vec3::NAN, Vec3::X), Vec3::ZERO);
}
