//! What every BSDF must keep: reciprocity, finite values at the edges, bounds
//! on weights, exact peaks, and errors for what cannot be built.

#[path = "bsdf_support/mod.rs"]
mod support;

use glam::Vec3;
use shearwater_tracer::bsdf::microfacet::ggx_d;
use shearwater_tracer::bsdf::{
    Bsdf, BsdfError, GgxModel, GgxParameters, LobeSampling, Phong, TableNeeds, Tables, Water,
};
use shearwater_tracer::math::hash::mix64;
use shearwater_tracer::math::warp::cosine_hemisphere;
use support::gallery::{ETA, gallery, phong, water};
use support::metals::tables;
use support::{direction, uniform, uniform3};

fn ggx(tables: &Tables, model: GgxModel, color: Vec3, metalness: f32, alpha: f32) -> Bsdf {
    let parameters = GgxParameters {
        base_color: color,
        metalness,
        alpha,
        dielectric_f0: 0.04,
    };
    Bsdf::ggx(tables, model, &parameters).expect("valid parameters")
}

#[test]
fn nothing_comes_from_below() {
    let tables = tables();
    for (name, bsdf) in gallery(&tables) {
        let (up, down) = (direction(30.0, 20.0), direction(150.0, 70.0));
        let nothing = (Vec3::ZERO, 0.0);
        assert_eq!(bsdf.eval_pdf(&tables, up, down), nothing, "{name}");
        assert_eq!(bsdf.eval_pdf(&tables, down, up), nothing, "{name}");
        assert_eq!(bsdf.eval_pdf(&tables, up, Vec3::X), nothing, "{name}");
        assert_eq!(bsdf.eval_pdf(&tables, Vec3::NAN, up), nothing, "{name}");
        assert_eq!(bsdf.sample(&tables, down, [0.3; 3]), None, "{name}");
        assert_eq!(bsdf.sample(&tables, Vec3::NAN, [0.3; 3]), None, "{name}");
    }
}

#[test]
fn absent_lobes_are_never_chosen_and_black_is_exactly_black() {
    let tables = tables();
    let (wo, wi) = (direction(50.0, 0.0), direction(50.0, 180.0));
    for (name, bsdf) in [
        ("lambert", Bsdf::Lambert { albedo: Vec3::ZERO }),
        ("phong", phong(0.0, 0.0, 20.0)),
    ] {
        assert_eq!(bsdf.eval_pdf(&tables, wo, wi).0, Vec3::ZERO, "{name}");
        for i in 0..1000 {
            assert_eq!(bsdf.sample(&tables, wo, uniform3(5, i)), None, "{name}");
        }
    }
    // ks = 0 is Lambert; kd = 0 only the lobe.
    let matte = phong(0.6, 0.0, 20.0);
    for i in 0..1000 {
        let sample = matte
            .sample(&tables, wo, uniform3(6, i))
            .expect("never below");
        assert!((sample.weight - 0.6).abs().max_element() < 1e-6);
    }
    assert!(!phong(0.0, 1.0, 1e6).has_diffuse() && !phong(0.0, 1.0, 1e6).light_sampling_pays());
    assert!(matte.light_sampling_pays());
    // A black texel on a metal leaves the grazing rise of Schlick, and no more.
    let soot = ggx(&tables, GgxModel::Corrected, Vec3::ZERO, 1.0, 0.3);
    let (f, pdf) = soot.eval_pdf(&tables, Vec3::Z, Vec3::Z);
    assert_eq!(f, Vec3::ZERO);
    assert!(pdf > 0.0);
    assert!(water(&tables, Vec3::ZERO, 0.0).is_delta());
    assert!(!water(&tables, Vec3::splat(0.1), 0.0).is_delta());
}

/// The exact height-correlated form: reciprocal masking lets through more than
/// the product of both sides, and never more than either.
#[test]
fn shadowing_is_height_correlated() {
    let tables = tables();
    let alpha = 0.5f32;
    let bsdf = ggx(&tables, GgxModel::Corrected, Vec3::ONE, 1.0, alpha);
    let (wo, wi) = (direction(70.0, 0.0), direction(60.0, 150.0));
    let (f, _) = bsdf.eval_pdf(&tables, wo, wi);
    let g2 = f64::from(f.x) * 4.0 * f64::from(wo.z) / f64::from(ggx_d(alpha, wo + wi));
    let lambda = |w: Vec3| {
        let tan2 = f64::from(w.x * w.x + w.y * w.y) / f64::from(w.z * w.z);
        0.5 * ((1.0 + f64::from(alpha * alpha) * tan2).sqrt() - 1.0)
    };
    let exact = 1.0 / (1.0 + lambda(wo) + lambda(wi));
    assert!((g2 / exact - 1.0).abs() < 1e-5, "{g2} {exact}");
}

#[test]
fn texels_and_footprints_change_a_material_in_place() {
    let tables = tables();
    let colors = [Vec3::new(0.2, 0.4, 0.8), Vec3::ONE, Vec3::ZERO];
    let Bsdf::Ggx(start) = ggx(&tables, GgxModel::Corrected, Vec3::splat(0.3), 0.4, 0.2) else {
        panic!("a GGX")
    };
    for color in colors {
        let built = ggx(&tables, GgxModel::Corrected, color, 0.4, 0.2);
        assert_eq!(Bsdf::Ggx(start.with_base_color(&tables, color)), built);
    }
    let calm = Water::new(&tables, ETA, colors[0], 0.0).expect("valid");
    for alpha in [0.0, 5e-4, 0.02, 1.0] {
        assert_eq!(
            Bsdf::Water(calm.with_alpha(&tables, alpha)),
            water(&tables, colors[0], alpha)
        );
    }
    assert_eq!(calm.with_alpha(&tables, 7.0), calm.with_alpha(&tables, 1.0));
    assert_eq!(water(&tables, colors[0], 5e-4).roughness(), 0.0);
}

#[test]
fn impossible_materials_are_refused() {
    let tables = tables();
    let good = GgxParameters::default();
    for bad in [
        GgxParameters { alpha: 1.5, ..good },
        GgxParameters {
            alpha: f32::NAN,
            ..good
        },
        GgxParameters {
            metalness: -0.1,
            ..good
        },
        GgxParameters {
            base_color: Vec3::new(0.0, 1.2, 0.0),
            ..good
        },
        GgxParameters {
            dielectric_f0: 2.0,
            ..good
        },
    ] {
        for model in [GgxModel::Corrected, GgxModel::Report] {
            assert!(
                matches!(
                    Bsdf::ggx(&tables, model, &bad),
                    Err(BsdfError::OutOfRange { .. })
                ),
                "{bad:?}"
            );
        }
    }
    let missing = Bsdf::ggx(&Tables::default(), GgxModel::Corrected, &good);
    assert!(matches!(missing, Err(BsdfError::MissingTable { .. })));
    assert!(Bsdf::ggx(&Tables::default(), GgxModel::Report, &good).is_ok());
    assert!(matches!(
        Water::new(&tables, 1.7, Vec3::ZERO, 0.0),
        Err(BsdfError::MissingTable { .. })
    ));
    let bright = Phong::new(Vec3::splat(0.6), Vec3::new(0.1, 0.5, 0.1), 3.0);
    assert!(matches!(bright, Err(BsdfError::TooBright { .. })));
    assert!(Phong::new(Vec3::ZERO, Vec3::ONE, -1.0).is_err());
    let many = TableNeeds {
        schlick: false,
        etas: vec![1.1, 1.2, 1.3, 1.4, 1.5],
        ..TableNeeds::default()
    };
    assert!(matches!(
        Tables::build(&many),
        Err(BsdfError::TooMany { .. })
    ));
    let zero = TableNeeds {
        schlick: false,
        etas: vec![0.5],
        ..TableNeeds::default()
    };
    assert!(Tables::build(&zero).is_err());
}

/// The same bits everywhere, tables included.
#[test]
fn output_bits_are_fixed() {
    let tables = tables();
    let mut hash = 0u64;
    let mut fold =
        |v: f32| hash = mix64(hash ^ u64::from(v.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    for (_, bsdf) in gallery(&tables) {
        for i in 0..500 {
            let wo = cosine_hemisphere([uniform(10, i), uniform(11, i)]);
            let wi = cosine_hemisphere([uniform(12, i), uniform(13, i)]);
            let (f, pdf) = bsdf.eval_pdf(&tables, wo, wi);
            let sample = bsdf.sample(&tables, wo, uniform3(14, i));
            let (direction, weight) = sample.map_or((Vec3::ZERO, Vec3::ZERO), |s| (s.wi, s.weight));
            for v in [f, direction, weight] {
                v.to_array().into_iter().for_each(&mut fold);
            }
            fold(pdf);
        }
    }
    assert_eq!(hash, 0x81f5a4293d2d2f8f, "{hash:#018x}");
}

/// A lobe that is absent is never drawn, whichever way samples are weighed.
#[test]
fn absent_lobes_are_never_drawn_however_samples_are_weighed() {
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
