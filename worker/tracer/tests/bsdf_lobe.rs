//! The two ways to weigh a sample of one of two lobes agree in the mean, and the
//! mixture is never noisier: its weight is the mean of the other's, given the
//! direction.

#[path = "bsdf_support/mod.rs"]
mod support;

use glam::Vec3;
use shearwater_tracer::bsdf::{Bsdf, GgxParameters, GgxReport, LobeSampling, Phong, Tables};
use support::{Moments, direction, uniform3};

const SAMPLES: u64 = 400_000;

/// Light from everywhere, and twenty times more from around the mirror direction
/// of a view at 45 degrees.
fn radiance(wi: Vec3) -> f64 {
    if wi.dot(direction(45.0, 180.0)) > 0.97 {
        20.0
    } else {
        1.0
    }
}

fn estimate(bsdf: &Bsdf, wo: Vec3) -> Moments {
    let mut spread = Moments::default();
    for i in 0..SAMPLES {
        let sample = bsdf.sample(&Tables::default(), wo, uniform3(23, i));
        spread.add(sample.map_or(0.0, |s| f64::from(s.weight.y) * radiance(s.wi)));
    }
    spread
}

fn compare(name: &str, mixture: &Bsdf, lobe: &Bsdf) {
    let mut noisier = 0.0f64;
    for degrees in [0.0, 30.0, 45.0, 60.0, 80.0] {
        let wo = direction(degrees, 0.0);
        let (a, b) = (estimate(mixture, wo), estimate(lobe, wo));
        println!(
            "{name} at {degrees}: mean {:.4} {:.4}, variance {:.4} {:.4}",
            a.mean(),
            b.mean(),
            a.variance(),
            b.variance()
        );
        let sigma = ((a.variance() + b.variance()) / SAMPLES as f64).sqrt();
        assert!(
            (a.mean() - b.mean()).abs() <= 4.0 * sigma,
            "{name} at {degrees}: {} {} +- {sigma}",
            a.mean(),
            b.mean()
        );
        // One per cent is four standard errors of a variance of bounded weights.
        assert!(
            a.variance() <= 1.01 * b.variance(),
            "{name} at {degrees}: {} {}",
            a.variance(),
            b.variance()
        );
        noisier = noisier.max(b.variance() / a.variance());
    }
    // They are two samplers and not one by two names.
    assert!(noisier > 1.01, "{name}: {noisier}");
}

#[test]
fn phong() {
    let half = Vec3::splat(0.5);
    let phong = Phong::new(half, half, 50.0).expect("valid");
    compare(
        "phong 50",
        &Bsdf::Phong(phong),
        &Bsdf::Phong(phong.with_sampling(LobeSampling::Lobe)),
    );
}

#[test]
fn report_ggx() {
    for (metalness, alpha) in [(0.0, 0.1), (0.5, 0.2)] {
        let parameters = GgxParameters {
            base_color: Vec3::splat(0.6),
            metalness,
            alpha,
            dielectric_f0: 0.2,
        };
        let report = GgxReport::new(&parameters).expect("valid");
        compare(
            &format!("report {alpha}"),
            &Bsdf::GgxReport(report),
            &Bsdf::GgxReport(report.with_sampling(LobeSampling::Lobe)),
        );
    }
}

/// A lobe that is absent is never drawn, whichever way samples are weighed.
#[test]
fn absent_lobes() {
    let (zero, grey) = (Vec3::ZERO, Vec3::splat(0.4));
    for (kd, ks) in [(zero, grey), (grey, zero), (zero, zero)] {
        let phong = Phong::new(kd, ks, 50.0).expect("valid");
        let lobe = Bsdf::Phong(phong.with_sampling(LobeSampling::Lobe));
        let wo = direction(40.0, 0.0);
        for i in 0..2_000 {
            let (a, b) = (
                Bsdf::Phong(phong).sample(&Tables::default(), wo, uniform3(5, i)),
                lobe.sample(&Tables::default(), wo, uniform3(5, i)),
            );
            match (a, b) {
                (Some(a), Some(b)) => {
                    assert_eq!(a.wi, b.wi);
                    assert!((a.weight - b.weight).abs().max_element() <= 1e-5);
                }
                (a, b) => assert_eq!(a, b),
            }
            assert!(kd != zero || ks != zero || a.is_none());
        }
    }
}
