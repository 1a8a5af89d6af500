//! Metals by complex index and by edge tint, mixed with dielectrics, and under a
//! clear coat: exact values, furnaces and limits.

#[path = "bsdf_support/mod.rs"]
mod support;

use glam::Vec3;
use shearwater_tracer::bsdf::fresnel::{
    F82_COS, conductor, conductor_f0, dielectric, f82_depth, f82_dip, schlick,
};
use shearwater_tracer::bsdf::{
    Bsdf, BsdfError, CoatParameters, GgxModel, GgxParameters, LayerParameters, Layered, MetalLaw,
    TableNeeds, Tables,
};
use support::metals::{ALUMINIUM, COPPER, coat, layers, tables};
use support::quadrature::{Narrow, direction, integrate};
use support::{Moments, uniform, uniform3};

const ANGLES_DEG: [f64; 8] = [0.0, 30.0, 60.0, 75.0, 82.0, 85.0, 89.0, 89.99];
const SAMPLES: u64 = 40_000;
/// Rounding of the albedo tables where a body takes what they leave.
const CONSERVATION: f64 = 1e-3;

fn metal(tables: &Tables, color: Vec3, metalness: f32, alpha: f32, layer: LayerParameters) -> Bsdf {
    let parameters = GgxParameters {
        base_color: color,
        metalness,
        alpha,
        dielectric_f0: 0.04,
    };
    Bsdf::Layered(Layered::new(tables, &parameters, &layer).expect("valid"))
}

fn bare(metal: MetalLaw) -> LayerParameters {
    LayerParameters { metal, coat: None }
}

#[test]
fn conductors_have_their_closed_form_at_normal_incidence() {
    for (n, k) in [
        (0.2f32, 3.9f32),
        (1.5, 7.6),
        (0.0, 3.0),
        (1.0, 0.0),
        (2.5, 0.0),
        (20.0, 20.0),
    ] {
        let exact =
            f64::from((n - 1.0) * (n - 1.0) + k * k) / f64::from((n + 1.0) * (n + 1.0) + k * k);
        for r in [conductor(n, k, 1.0), conductor_f0(n, k)] {
            assert!((f64::from(r) - exact).abs() < 1e-6, "{n} {k}: {r} {exact}");
        }
        let grazing = conductor(n, k, 0.0);
        assert!(grazing == 1.0 || (n, k) == (1.0, 0.0), "{n} {k}: {grazing}");
    }
}

// The complex square root written out in f64: r_s = (c - q)/(c + q) and
// r_p = (N^2 c - q)/(N^2 c + q) with q^2 = N^2 - sin^2.
#[test]
fn conductors_follow_fresnels_equations() {
    use num_complex::Complex64;
    for (n, k) in [
        (0.2, 3.9),
        (1.5, 7.6),
        (0.05, 4.2),
        (3.0, 3.0),
        (0.5, 0.0),
        (2.5, 0.0),
    ] {
        let index2 = Complex64::new(n, k) * Complex64::new(n, k);
        for i in 0..=1000 {
            let c = f64::from(i) / 1000.0;
            let q = (index2 - (1.0 - c * c)).sqrt();
            let s = ((c - q) / (c + q)).norm_sqr();
            let p = ((index2 * c - q) / (index2 * c + q)).norm_sqr();
            let r = f64::from(conductor(n as f32, k as f32, c as f32));
            // Near the critical angle of an index below 1 the curve is a square root.
            let bound = if k == 0.0 && n < 1.0 { 2e-3 } else { 2e-5 };
            assert!(
                (r - 0.5 * (s + p)).abs() < bound,
                "{n} {k} {c}: {r} {}",
                0.5 * (s + p)
            );
        }
    }
}

#[test]
fn a_conductor_that_does_not_absorb_is_a_dielectric() {
    for eta in [1.0f32, 1.333, 1.5, 2.4, 10.0] {
        for i in 0..=1000 {
            let cos = i as f32 / 1000.0;
            let (a, b) = (conductor(eta, 0.0, cos), dielectric(eta, cos));
            assert!((a - b).abs() < 1e-5, "{eta} {cos}: {a} {b}");
        }
    }
}

#[test]
fn f82_has_its_tint_at_82_degrees_and_stays_a_share() {
    assert!((libm::acos(f64::from(F82_COS)).to_degrees() - 81.787).abs() < 1e-3);
    for f0 in [0.3f32, 0.6, 0.9, 1.0] {
        for tint in [0.4f32, 0.7, 1.0] {
            let (base, tint3) = (Vec3::splat(f0), Vec3::splat(tint));
            let law = |cos: f32| (schlick(base, cos) - f82_depth(base, tint3) * f82_dip(cos)).x;
            let expected = tint * schlick(base, F82_COS).x;
            assert!((law(F82_COS) - expected).abs() < 1e-6, "{f0} {tint}");
            assert!((law(1.0) - f0).abs() < 1e-7 && law(0.0) == 1.0);
        }
    }
    // Never negative and never above Schlick's, however dark and however tinted.
    for f0 in [0.0f32, 0.01, 0.1, 0.5, 0.95, 1.0] {
        for tint in [0.0f32, 0.2, 0.6] {
            let base = Vec3::splat(f0);
            for i in 0..=10_000 {
                let cos = i as f32 / 10_000.0;
                let law =
                    (schlick(base, cos) - f82_depth(base, Vec3::splat(tint)) * f82_dip(cos)).x;
                assert!(
                    law >= -1e-6 && law <= schlick(base, cos).x,
                    "{f0} {tint} {cos}: {law}"
                );
            }
        }
    }
}

/// Without coat, with Schlick's law, it is the plain GGX.
#[test]
fn a_layer_of_nothing_is_the_plain_ggx() {
    let tables = tables();
    for (metalness, alpha) in [(0.0, 0.3), (0.4, 0.05), (1.0, 0.5), (0.7, 0.0)] {
        let parameters = GgxParameters {
            base_color: Vec3::new(0.9, 0.5, 0.1),
            metalness,
            alpha,
            dielectric_f0: 0.04,
        };
        let plain = Bsdf::ggx(&tables, GgxModel::Corrected, &parameters).expect("valid");
        let layered = metal(
            &tables,
            parameters.base_color,
            metalness,
            alpha,
            LayerParameters::default(),
        );
        for i in 0..5_000 {
            let [a, b, c] = uniform3(1, i);
            let wo = shearwater_tracer::math::warp::cosine_hemisphere([a, b]);
            let wi = shearwater_tracer::math::warp::cosine_hemisphere([c, uniform(2, i)]);
            let (f, p) = plain.eval_pdf(&tables, wo, wi);
            let (g, q) = layered.eval_pdf(&tables, wo, wi);
            assert!(
                (f - g).abs().max_element() <= 1e-5 * f.max_element() && (p - q).abs() <= 1e-5 * p
            );
            let u = uniform3(3, i);
            match (plain.sample(&tables, wo, u), layered.sample(&tables, wo, u)) {
                (Some(a), Some(b)) => {
                    assert_eq!((a.wi, a.delta), (b.wi, b.delta));
                    assert!(
                        (a.weight - b.weight).abs().max_element() <= 1e-5 * a.weight.max_element()
                    );
                }
                (a, b) => assert_eq!(a, b),
            }
        }
    }
}

/// Mean weight of the samples in green, and four standard errors.
fn sampled(bsdf: &Bsdf, tables: &Tables, degrees: f64) -> (f64, f64) {
    let wo = direction(degrees).as_vec3();
    let mut moments = Moments::default();
    for i in 0..SAMPLES {
        let sample = bsdf.sample(tables, wo, uniform3(17, i));
        moments.add(sample.map_or(0.0, |s| f64::from(s.weight.y)));
    }
    (moments.mean(), moments.four_sigma())
}

/// Nothing reflects more than arrives: white, every law, every coat, every angle.
#[test]
fn furnaces_stay_below_one() {
    let tables = tables();
    for layer in layers() {
        for (metalness, alpha) in [
            (1.0, 0.0),
            (1.0, 0.02),
            (1.0, 0.4),
            (0.0, 0.0),
            (0.0, 0.3),
            (0.5, 0.1),
        ] {
            let bsdf = metal(&tables, Vec3::ONE, metalness, alpha, layer);
            for degrees in ANGLES_DEG {
                let (mean, four_sigma) = sampled(&bsdf, &tables, degrees);
                let bound = if metalness < 1.0 { CONSERVATION } else { 1e-4 };
                assert!(
                    mean <= 1.0 + bound + four_sigma,
                    "{layer:?} {metalness} {alpha} at {degrees}: {mean} +- {four_sigma}"
                );
                assert!(
                    mean > 0.05,
                    "{layer:?} {metalness} {alpha} at {degrees}: {mean}"
                );
            }
        }
    }
}

/// By quadrature, where lobes are wide enough, to the promised 1e-4; and the
/// sampler agrees.
#[test]
fn furnaces_by_quadrature() {
    let tables = tables();
    for layer in layers() {
        if layer.coat.is_some_and(|coat| coat.alpha < 0.1) {
            continue;
        }
        for alpha in [0.15, 0.5] {
            let bsdf = metal(&tables, Vec3::ONE, 1.0, alpha, layer);
            for degrees in [0.0, 60.0, 85.0, 89.0] {
                let wo = direction(degrees);
                let narrow = Narrow::Ggx(
                    layer
                        .coat
                        .map_or(alpha, |coat| coat.alpha.min(alpha))
                        .into(),
                );
                let e = integrate(&bsdf, &tables, wo, narrow, 60_000, |f, _| f64::from(f.y));
                assert!(e <= 1.0 + 1e-4, "{layer:?} {alpha} at {degrees}: {e}");
                let (mean, four_sigma) = sampled(&bsdf, &tables, degrees);
                assert!(
                    (mean - e).abs() <= four_sigma + 2e-4,
                    "{layer:?} {alpha} at {degrees}: {mean} +- {four_sigma}, {e}"
                );
            }
        }
    }
}

/// A white body below a mixed metal gets just what the interface leaves.
#[test]
fn white_bodies_below_half_metals_conserve_energy() {
    let tables = tables();
    // At metalness 0 every law is the dielectric's.
    for layer in layers().into_iter().filter(|layer| layer.coat.is_none()) {
        for alpha in [0.1, 0.5] {
            let bsdf = metal(&tables, Vec3::ONE, 0.0, alpha, layer);
            for degrees in [0.0, 60.0, 85.0] {
                let narrow = Narrow::Ggx(alpha.into());
                let e = integrate(
                    &bsdf,
                    &tables,
                    direction(degrees),
                    narrow,
                    60_000,
                    |f, _| f64::from(f.y),
                );
                assert!(
                    (e - 1.0).abs() <= CONSERVATION,
                    "{layer:?} {alpha} at {degrees}: {e}"
                );
            }
        }
    }
}

#[test]
fn smooth_metal_under_smooth_varnish_has_its_closed_form() {
    let tables = tables();
    let layer = LayerParameters {
        metal: COPPER,
        coat: Some(coat(1.0, 0.0)),
    };
    let bsdf = metal(&tables, Vec3::ONE, 1.0, 0.0, layer);
    assert!(bsdf.is_delta() && !bsdf.light_sampling_pays());
    let MetalLaw::Conductor { n, k } = COPPER else {
        panic!("copper is a conductor")
    };
    for degrees in ANGLES_DEG {
        let wo = direction(degrees).as_vec3();
        let f = dielectric(1.5, wo.z);
        let expected = f + (1.0 - f) * (1.0 - f) * conductor(n.y, k.y, wo.z);
        let (mean, four_sigma) = sampled(&bsdf, &tables, degrees);
        assert!(
            (mean - f64::from(expected)).abs() <= four_sigma,
            "{degrees}: {mean} {expected}"
        );
        assert_eq!(
            bsdf.eval_pdf(&tables, wo, Vec3::new(-wo.x, 0.0, wo.z)).1,
            0.0
        );
    }
    // One rough layer and it is no mirror any more.
    let rough = LayerParameters {
        coat: Some(coat(1.0, 0.2)),
        ..layer
    };
    assert!(!metal(&tables, Vec3::ONE, 1.0, 0.0, rough).is_delta());
    assert!(!metal(&tables, Vec3::ONE, 1.0, 0.2, layer).is_delta());
    assert!(!metal(&tables, Vec3::ONE, 0.5, 0.0, layer).is_delta());
}

#[test]
fn a_black_tint_is_black_and_a_coat_of_no_weight_is_none() {
    let tables = tables();
    let black = metal(&tables, Vec3::ZERO, 1.0, 0.2, bare(COPPER));
    let none = LayerParameters {
        metal: ALUMINIUM,
        coat: Some(coat(0.0, 0.2)),
    };
    let (none, plain) = (
        metal(&tables, Vec3::ONE, 1.0, 0.2, none),
        metal(&tables, Vec3::ONE, 1.0, 0.2, bare(ALUMINIUM)),
    );
    for i in 0..2_000 {
        let wo = direction(80.0 * f64::from(uniform(1, i))).as_vec3();
        let wi = shearwater_tracer::math::warp::cosine_hemisphere([uniform(2, i), uniform(3, i)]);
        assert_eq!(black.eval_pdf(&tables, wo, wi).0, Vec3::ZERO);
        assert_eq!(black.sample(&tables, wo, uniform3(4, i)), None);
        assert_eq!(
            none.eval_pdf(&tables, wo, wi),
            plain.eval_pdf(&tables, wo, wi)
        );
    }
}

#[test]
fn what_cannot_be_built_is_an_error() {
    let build = |layers: Vec<LayerParameters>| {
        Tables::build(&TableNeeds {
            layers,
            ..TableNeeds::default()
        })
    };
    let law = |n: f32| {
        bare(MetalLaw::Conductor {
            n: Vec3::splat(n),
            k: Vec3::ONE,
        })
    };
    assert!(matches!(
        build(vec![law(-0.1)]),
        Err(BsdfError::OutOfRange { .. })
    ));
    assert!(matches!(
        build(vec![law(f32::NAN)]),
        Err(BsdfError::OutOfRange { .. })
    ));
    let many = (0..9).map(|i| law(1.0 + i as f32)).collect();
    assert!(matches!(
        build(many),
        Err(BsdfError::TooMany { count: 9, .. })
    ));
    let tint = bare(MetalLaw::F82 {
        tint: Vec3::splat(1.1),
    });
    assert!(matches!(
        build(vec![tint]),
        Err(BsdfError::OutOfRange { .. })
    ));
    for bad in [
        CoatParameters {
            weight: 1.5,
            ..coat(1.0, 0.0)
        },
        CoatParameters {
            alpha: -0.5,
            ..coat(1.0, 0.0)
        },
        CoatParameters {
            eta: 0.9,
            ..coat(1.0, 0.0)
        },
    ] {
        let layer = LayerParameters {
            coat: Some(bad),
            ..LayerParameters::default()
        };
        assert!(
            matches!(build(vec![layer]), Err(BsdfError::OutOfRange { .. })),
            "{bad:?}"
        );
    }
    let unknown = Layered::new(&Tables::default(), &GgxParameters::default(), &bare(COPPER));
    assert!(matches!(unknown, Err(BsdfError::MissingTable { .. })));
}

/// A hit carries its reflection by value: it stays as small as it was.
#[test]
fn a_reflection_is_small() {
    assert!(size_of::<Bsdf>() <= 60, "{}", size_of::<Bsdf>());
}
