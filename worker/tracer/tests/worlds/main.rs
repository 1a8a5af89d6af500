//! Large and small worlds: the picture does not know where the origin is, nor how long
//! a metre.

mod picture;
mod place;

use picture::{Picture, noise_ratio, render};
use place::{moved, scaled, scene, with_far_vertices};
use shearwater_shared::scene::SceneDescription;

/// Samples of each half of a pixel.
const SAMPLES: u32 = 32;
/// Largest mean squared difference, as a share of the noise that the halves of both
/// pictures show. Two pictures of one scene with different seeds have 1 on average;
/// twice that is what this project promises.
const RATIO_MAX: f64 = 2.0;

/// The same for pictures of the same seed, which differ by roundings alone.
const RATIO_SAME_SEED_MAX: f64 = 0.02;

/// Holds the picture of `other` against that of `original`, with its seed and with another.
fn assert_same(what: &str, original: &Picture, other: &SceneDescription, far_mesh: bool) {
    for seed in [1, 2] {
        let picture = render(other, seed, SAMPLES, far_mesh);
        let ratio = noise_ratio(original, &picture);
        println!("{what}, seed {seed}: {ratio:.4} of the noise");
        let most = if seed == 1 {
            RATIO_SAME_SEED_MAX
        } else {
            RATIO_MAX
        };
        assert!(ratio <= most, "{what}, seed {seed}: {ratio}");
        let share = picture.mean() / original.mean() - 1.0;
        let error = original.error_of_mean() + picture.error_of_mean();
        let slack = 5.0 * error / original.mean() + 1e-4;
        assert!(share.abs() <= slack, "{what}: {share} brighter, {slack}");
    }
}

// 100,000 m are 2,000 tiles of the sea, 10,000 of its texture and whole waves.
const FAR: [f64; 3] = [1e5, 1e4, -1e5];

#[test]
fn a_scene_may_stand_anywhere() {
    for water in place::WATERS {
        let here = scene(water);
        let original = render(&here, 1, SAMPLES, false);
        assert!(
            original.mean() > 0.05 && original.noise() > 0.0,
            "a picture"
        );
        let there = moved(&here, FAR);
        assert_same(&format!("{water}, moved"), &original, &there, false);
        // And back: but for the last digits of decimals, the original.
        let back = moved(&there, FAR.map(|x| -x));
        let ratio = noise_ratio(&original, &render(&back, 1, SAMPLES, false));
        assert!(ratio < 1e-2, "{water} moved there and back: {ratio}");
    }
}

// Lengths times s, times and the roots of lengths (deep water: w^2 = g k) times sqrt s.
#[test]
fn a_scene_may_have_any_size() {
    for water in place::WATERS {
        let here = scene(water);
        let original = render(&here, 1, SAMPLES, false);
        for by in [1e-3, 1e3] {
            assert_same(
                &format!("{water}, scaled by {by}"),
                &original,
                &scaled(&here, by),
                false,
            );
        }
    }
}

// Meshes whose own vertices lie 100 km from their origin (as maps have them) and that
// instances bring back.
#[test]
fn vertices_may_lie_far_from_the_origin_of_their_mesh() {
    let here = scene("none");
    let original = render(&here, 1, SAMPLES, false);
    assert_same("far vertices", &original, &with_far_vertices(&here), true);
}

// The measure itself: a scene shifted by a hand's breadth is another picture.
#[test]
fn a_small_shift_is_seen() {
    let here = scene("none");
    let original = render(&here, 1, SAMPLES, false);
    let mut shifted = here.clone();
    shifted.camera.position_m[0] += 0.05;
    let ratio = noise_ratio(&original, &render(&shifted, 1, SAMPLES, false));
    println!("shifted by a hand's breadth: {ratio:.4} of the noise");
    assert!(ratio > 2.0 * RATIO_SAME_SEED_MAX, "{ratio}");
}
