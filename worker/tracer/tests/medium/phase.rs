//! Henyey-Greenstein: normalised, sampled as it is evaluated, of the right mean.

use crate::common::unit;
use glam::Vec3;
use shearwater_tracer::math::frame::Frame;
use shearwater_tracer::medium::Phase;
use std::f64::consts::PI;

const ALL_G: [f32; 11] = [
    -0.99, -0.7, -0.5, -0.2, 0.0, 1e-6, 0.05, 0.5, 0.501, 0.9, 0.99,
];

fn phase(g: f32) -> Phase {
    Phase {
        albedo: Vec3::ONE,
        g,
    }
}

// Share of directions whose cosine is below `cos`: the integral of the formula.
fn below(g: f64, cos: f64) -> f64 {
    if g.abs() < 1e-3 {
        return 0.5 * (1.0 + cos);
    }
    let root = (1.0 + g * g - 2.0 * g * cos).sqrt();
    (1.0 - g * g) / (2.0 * g) * (1.0 / root - 1.0 / (1.0 + g))
}

#[test]
fn the_density_integrates_to_one_and_has_mean_cosine_g() {
    for g in ALL_G {
        let n = 400_000;
        let (mut total, mut cosine) = (0.0, 0.0);
        for i in 0..n {
            // Finer where a peak may be: cos = sin(angle).
            let angle = PI * ((f64::from(i) + 0.5) / f64::from(n) - 0.5);
            let (cos, sin) = (libm::sin(angle), libm::cos(angle));
            let wi = Vec3::new(sin as f32, 0.0, cos as f32);
            let p = f64::from(phase(g).pdf(Vec3::NEG_Z, wi)) * 2.0 * PI * sin * PI / f64::from(n);
            total += p;
            cosine += p * cos;
        }
        assert!((total - 1.0).abs() < 1e-3, "{g}: {total}");
        assert!((cosine - f64::from(g)).abs() < 1e-3, "{g}: {cosine}");
    }
}

#[test]
fn samples_follow_the_density() {
    const COSINES: usize = 40;
    const AZIMUTHS: usize = 5;
    let n = 200_000_u64;
    let wo = Vec3::new(0.36, -0.48, 0.8);
    for g in ALL_G {
        let mut counts = [0_u32; COSINES * AZIMUTHS];
        let mut cosine = 0.0;
        for i in 0..n {
            let sample = phase(g).sample(wo, [unit(2 * i), unit(2 * i + 1)]);
            assert!(
                (sample.wi.length() - 1.0).abs() < 1e-5,
                "{g}: {}",
                sample.wi
            );
            let local = Frame::from_normal(-wo).to_local(sample.wi).as_dvec3();
            cosine += local.z / n as f64;
            let turn = libm::atan2(local.y, local.x) / (2.0 * PI) + 0.5;
            let row = below(g.into(), local.z) * COSINES as f64;
            let column = turn * AZIMUTHS as f64;
            let bin = |v: f64, count: usize| (v as usize).min(count - 1);
            counts[bin(row, COSINES) * AZIMUTHS + bin(column, AZIMUTHS)] += 1;
            let again = phase(g).pdf(wo, sample.wi);
            // The peak of g = 0.99 is a third of a degree wide: f32 directions blur it.
            let slack = if g.abs() > 0.95 { 0.02 } else { 1e-3 };
            assert!(
                (again / sample.pdf - 1.0).abs() < slack,
                "{g}: {again} {}",
                sample.pdf
            );
        }
        assert!((cosine - f64::from(g)).abs() < 0.01, "{g}: {cosine}");
        let expected = n as f64 / counts.len() as f64;
        let chi2: f64 = counts
            .iter()
            .map(|&c| (f64::from(c) - expected) * (f64::from(c) - expected) / expected)
            .sum();
        let freedom = (counts.len() - 1) as f64;
        assert!(chi2 < freedom + 5.0 * (2.0 * freedom).sqrt(), "{g}: {chi2}");
    }
}
