//! What every BSDF must keep: reciprocity, finite values at the edges, bounds
//! on weights, exact peaks, and errors for what cannot be built.

#[path = "bsdf_support/mod.rs"]
mod support;

use glam::Vec3;
use shearwater_tracer::bsdf::microfacet::{MIRROR_ALPHA_MAX, ggx_d};
use shearwater_tracer::bsdf::{
    Bsdf, BsdfError, GgxModel, GgxParameters, Layered, Phong, TableNeeds, Tables, Water,
};
use shearwater_tracer::math::hash::mix64;
use shearwater_tracer::math::warp::cosine_hemisphere;
use support::metals::{layers, tables};
use support::{direction, uniform, uniform3};

const ETA: f32 = 1.333;
const PAIRS: u64 = 30_000;
/// Relative, for f32.
const RECIPROCITY: f32 = 1e-4;

fn ggx(tables: &Tables, model: GgxModel, color: Vec3, metalness: f32, alpha: f32) -> Bsdf {
    let parameters = GgxParameters {
        base_color: color,
        metalness,
        alpha,
        dielectric_f0: 0.04,
    };
    Bsdf::ggx(tables, model, &parameters).expect("valid parameters")
}

fn phong(kd: f32, ks: f32, exponent: f32) -> Bsdf {
    Bsdf::Phong(Phong::new(Vec3::splat(kd), Vec3::splat(ks), exponent).expect("valid parameters"))
}

fn water(tables: &Tables, color: Vec3, alpha: f32) -> Bsdf {
    Bsdf::Water(Water::new(tables, ETA, color, alpha).expect("valid parameters"))
}

/// One of each kind, narrow and wide, white and coloured.
fn gallery(tables: &Tables) -> Vec<(String, Bsdf)> {
    let color = Vec3::new(0.9, 0.5, 0.1);
    let mut all = vec![
        ("lambert".to_owned(), Bsdf::Lambert { albedo: color }),
        ("phong 0".to_owned(), phong(0.3, 0.7, 0.0)),
        ("phong 40".to_owned(), phong(0.3, 0.7, 40.0)),
        ("phong 1e6".to_owned(), phong(0.0, 1.0, 1e6)),
    ];
    for alpha in [0.0, MIRROR_ALPHA_MAX, 0.03, 0.3, 1.0] {
        all.push((format!("water {alpha}"), water(tables, color, alpha)));
        for model in [GgxModel::Corrected, GgxModel::Report] {
            for metalness in [0.0, 0.6, 1.0] {
                let name = format!("{model:?} metal {metalness} alpha {alpha}");
                all.push((name, ggx(tables, model, color, metalness, alpha)));
            }
        }
    }
    for (i, layer) in layers().into_iter().enumerate() {
        for (metalness, alpha) in [(1.0, 0.0), (1.0, 0.3), (0.5, 0.05)] {
            let parameters = GgxParameters {
                base_color: color,
                metalness,
                alpha,
                dielectric_f0: 0.04,
            };
            let metal = Layered::new(tables, &parameters, &layer).expect("valid parameters");
            let name = format!("layer {i} metal {metalness} alpha {alpha}");
            all.push((name, Bsdf::Layered(metal)));
        }
    }
    all
}

#[test]
fn reflection_is_reciprocal() {
    let tables = tables();
    for (name, bsdf) in gallery(&tables) {
        // A lobe of 0.1 degrees turns the rounding of a direction into more.
        let bound = if name.contains("1e6") || name.contains("0.001") {
            40.0 * RECIPROCITY
        } else {
            RECIPROCITY
        };
        for i in 0..PAIRS {
            let [a, b, c] = uniform3(1, i);
            let o = cosine_hemisphere([a, b]);
            // Half of the pairs lie near the mirror direction.
            let spread = if i % 2 == 0 { 1.0 } else { 0.01 };
            let wide = cosine_hemisphere([c, uniform(2, i)]);
            let mirror = Vec3::new(-o.x, -o.y, o.z);
            let v = (mirror * (1.0 - spread) + wide * spread).normalize();
            if v.z < 1e-3 || o.z < 1e-3 {
                continue;
            }
            let forth = bsdf.eval_pdf(&tables, o, v).0 / v.z;
            let back = bsdf.eval_pdf(&tables, v, o).0 / o.z;
            let difference = (forth - back).abs().max_element();
            let size = forth.max(back).max_element();
            assert!(
                difference <= bound * size + 1e-30,
                "{name}: {o} {v}: {forth} {back}"
            );
        }
    }
}

#[test]
fn ggx_peak_is_exact_down_to_tiny_alphas() {
    for alpha in [1e-4f32, 2e-4, 5e-4, 1e-3, 0.1, 1.0] {
        let exact = 1.0 / (core::f64::consts::PI * f64::from(alpha) * f64::from(alpha));
        for half in [Vec3::Z, Vec3::new(0.0, 0.0, 2.0)] {
            let d = f64::from(ggx_d(alpha, half));
            assert!((d / exact - 1.0).abs() < 1e-5, "{alpha}: {d} {exact}");
        }
    }
}

#[test]
fn visible_normal_weights_lie_between_zero_and_one() {
    let tables = tables();
    for alpha in [MIRROR_ALPHA_MAX, 0.01, 0.1, 0.5, 1.0] {
        let bsdf = ggx(&tables, GgxModel::Corrected, Vec3::ONE, 1.0, alpha);
        for degrees in [0.0, 45.0, 80.0, 89.0, 89.99, 90.0] {
            let wo = direction(degrees, 10.0);
            for i in 0..20_000 {
                if let Some(sample) = bsdf.sample(&tables, wo, uniform3(3, i)) {
                    let w = sample.weight;
                    assert!(
                        w.min_element() >= 0.0 && w.max_element() <= 1.0 + 1e-5,
                        "{alpha} {degrees}: {w}"
                    );
                }
            }
        }
    }
}

/// No NaN, no infinity, nothing negative, at any angle and any random number,
/// the ends of their ranges included.
#[test]
fn values_stay_finite_at_the_edges() {
    let tables = tables();
    let top = 1.0 - 1.0 / 16_777_216.0;
    let ends = [0.0, 0.5, top];
    for (name, bsdf) in gallery(&tables) {
        for degrees in [0.0, 60.0, 89.99, 89.9999, 90.0] {
            for azimuth in [0.0, 133.0] {
                let wo = direction(degrees, azimuth);
                for i in 0..2_000u64 {
                    let u = if i < 27 {
                        [
                            ends[i as usize % 3],
                            ends[i as usize / 3 % 3],
                            ends[i as usize / 9],
                        ]
                    } else {
                        uniform3(4, i)
                    };
                    let Some(sample) = bsdf.sample(&tables, wo, u) else {
                        continue;
                    };
                    let label = || format!("{name} at {degrees}: {u:?} {sample:?}");
                    assert!(
                        sample.wi.is_finite() && (sample.wi.length() - 1.0).abs() < 1e-5,
                        "{}",
                        label()
                    );
                    assert!(sample.wi.z > 0.0, "{}", label());
                    assert!(
                        sample.weight.is_finite() && sample.weight.min_element() >= 0.0,
                        "{}",
                        label()
                    );
                    assert!(sample.pdf.is_finite() && sample.pdf > 0.0, "{}", label());
                    let (f, pdf) = bsdf.eval_pdf(&tables, wo, sample.wi);
                    assert!(
                        f.is_finite() && f.min_element() >= 0.0 && pdf.is_finite() && pdf >= 0.0,
                        "{}",
                        label()
                    );
                    if !sample.delta {
                        assert!(
                            (f / pdf - sample.weight).abs().max_element()
                                < 1e-4 * (1.0 + sample.weight.max_element()),
                            "{}",
                            label()
                        );
                    }
                }
            }
        }
    }
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

/// An exponent of a million must not fall into rings.
#[test]
fn narrow_phong_lobes_have_no_rings() {
    let tables = Tables::default();
    let bsdf = phong(0.0, 1.0, 1e6);
    let mut sines = Vec::new();
    let mut within = 0;
    for i in 0..1_000_000u64 {
        let Some(sample) = bsdf.sample(&tables, Vec3::Z, uniform3(7, i)) else {
            continue;
        };
        let sin2 = f64::from(sample.wi.x) * f64::from(sample.wi.x)
            + f64::from(sample.wi.y) * f64::from(sample.wi.y);
        within += u32::from(sin2.sqrt() < 1.1774e-3);
        sines.push((sin2.sqrt() * 1e12) as u64);
    }
    let drawn = sines.len() as f64;
    sines.sort_unstable();
    sines.dedup();
    assert!(sines.len() > 100_000, "{} distinct angles", sines.len());
    // Half of the lobe lies within the half-power angle sqrt(2 ln 2 / n).
    assert!((f64::from(within) / drawn - 0.5).abs() < 2.5e-3, "{within}");
    let peak = f64::from(bsdf.eval_pdf(&tables, Vec3::Z, Vec3::Z).0.x);
    assert!((peak / 159_155.26 - 1.0).abs() < 1e-5, "{peak}");
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
    assert_eq!(hash, 0x0c423303a5a4d79a, "{hash:#018x}");
}
