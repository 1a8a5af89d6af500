//! Two normals at one point: no light leaks, no black where a mirror leans too
//! far, no light made.

#[path = "bsdf_support/mod.rs"]
mod support;

use glam::Vec3;
use shearwater_tracer::bsdf::shading_frame::{bend_normal, face_viewer, same_side};
use shearwater_tracer::bsdf::{Bsdf, TableNeeds, Tables, Water};
use shearwater_tracer::math::frame::Frame;
use support::{direction, uniform3};

/// A unit vector anywhere.
fn anywhere(seed: u64, i: u64) -> Vec3 {
    let [a, b, c] = uniform3(seed, i);
    (Vec3::new(a, b, c) - 0.5)
        .try_normalize()
        .unwrap_or(Vec3::Z)
}

#[test]
fn normals_turn_to_the_viewer() {
    for i in 0..10_000 {
        let (shading, geometric, wo) = (anywhere(1, i), anywhere(2, i), anywhere(3, i));
        let (s, g) = face_viewer(shading, geometric, wo);
        assert!(g.dot(wo) >= 0.0 && s.dot(g) >= 0.0);
        assert!((s == shading || s == -shading) && (g == geometric || g == -geometric));
    }
}

#[test]
fn bent_normals_keep_the_mirror_image_above_the_surface() {
    let (mut bent, mut kept) = (0, 0);
    for i in 0..100_000 {
        let wo = anywhere(4, i);
        let (shading, geometric) = face_viewer(anywhere(5, i), anywhere(6, i), wo);
        let normal = bend_normal(shading, geometric, wo);
        let image = normal * (2.0 * wo.dot(normal)) - wo;
        let view_height = wo.dot(geometric);
        assert!((normal.length() - 1.0).abs() < 1e-5);
        assert!(
            normal.dot(wo) >= -1e-5,
            "the viewer is below: {normal} {wo}"
        );
        let wanted = 0.01f32.min(0.9 * view_height);
        assert!(image.dot(geometric) >= wanted - 1e-4, "{image} {geometric}");
        let old_image = shading * (2.0 * wo.dot(shading)) - wo;
        if old_image.dot(geometric) >= wanted {
            assert_eq!(normal, shading);
            kept += 1;
        } else {
            // Hardly further than needed, unless it lay far below.
            let height = old_image.dot(geometric);
            assert!(
                height < -0.3 || image.dot(geometric) <= 1.1 * wanted + 1e-4,
                "{image} {geometric}"
            );
            bent += 1;
        }
    }
    assert!(bent > 20_000 && kept > 20_000, "{bent} {kept}");
}

#[test]
fn flat_normals_are_untouched_at_every_angle() {
    for degrees in [0.0, 45.0, 89.0, 89.99, 90.0] {
        let wo = direction(degrees, 20.0);
        assert_eq!(bend_normal(Vec3::Z, Vec3::Z, wo), Vec3::Z, "{degrees}");
    }
    // The viewer exactly in the plane, looking along a leaning normal.
    let lean = Vec3::new(0.5, 0.0, 0.75f32.sqrt());
    for wo in [Vec3::X, Vec3::NEG_X] {
        let normal = bend_normal(lean, Vec3::Z, wo);
        assert!(
            normal.is_finite() && (normal.length() - 1.0).abs() < 1e-5,
            "{normal}"
        );
    }
}

/// A white furnace over a bumped white mirror and bumped white water, each
/// sample that leaves below the true surface counting nothing: never more light
/// than arrives, and the bent mirror loses none.
#[test]
fn bumps_make_no_light() {
    let tables = Tables::build(&TableNeeds {
        schlick: false,
        etas: vec![1.333],
        ..TableNeeds::default()
    })
    .expect("valid needs");
    for (alpha, least) in [(0.0, 0.90), (0.2, 0.80)] {
        let bsdf = Bsdf::Water(Water::new(&tables, 1.333, Vec3::ONE, alpha).expect("valid"));
        for degrees in [0.0, 60.0, 85.0, 89.5] {
            let wo = direction(degrees, 0.0);
            let (mut sum, mut mirrors_lost) = (0.0, 0u32);
            let count = 100_000;
            for i in 0..count {
                let [a, b, _] = uniform3(8, i);
                let bump = Vec3::new(a - 0.5, b - 0.5, 1.0).normalize();
                let (shading, geometric) = face_viewer(bump, Vec3::Z, wo);
                let frame = Frame::from_normal(bend_normal(shading, geometric, wo));
                if let Some(sample) = bsdf.sample(&tables, frame.to_local(wo), uniform3(9, i)) {
                    let wi = frame.to_world(sample.wi);
                    if same_side(geometric, wo, wi) {
                        sum += f64::from(sample.weight.x);
                    } else {
                        mirrors_lost += u32::from(sample.delta);
                    }
                }
            }
            let e = sum / count as f64;
            println!("alpha {alpha} at {degrees}: {e:.4}");
            assert!(
                e <= 1.0 + 2e-3 && e >= least,
                "alpha {alpha} at {degrees}: {e}"
            );
            assert_eq!(mirrors_lost, 0);
        }
    }
}

#[test]
fn light_from_the_far_side_does_not_count() {
    // Above the leaning normal's horizon, below the surface.
    let (geometric, wo) = (Vec3::Z, direction(20.0, 0.0));
    let below = direction(100.0, 0.0);
    let lean = direction(45.0, 0.0);
    assert!(below.dot(lean) > 0.0);
    assert!(!same_side(geometric, wo, below));
    assert!(!same_side(-geometric, wo, below));
    assert!(same_side(geometric, wo, direction(80.0, 0.0)));
    assert!(same_side(geometric, -wo, below));
    assert!(!same_side(geometric, wo, Vec3::X));
}
