use super::*;
use crate::picture::{Planes, Range};

/// Numbers in 0..1 for a made-up picture (SplitMix64; Steele, Lea, Flood 2014).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
}

/// Mean and deviation 1, with a long tail, like light in a pixel.
fn exponential(random: &mut impl FnMut() -> f64) -> f64 {
    -libm::log(random())
}

fn picture(width: usize, grey: &[f64]) -> Picture {
    Picture {
        width,
        height: grey.len() / width,
        rgb: grey.iter().map(|&v| [v as f32; 3]).collect(),
        range: Range::Linear,
        planes: Planes::default(),
    }
}

fn with_counts(mut picture: Picture, counts: Vec<u32>) -> Picture {
    picture.planes.sample_count = Some(counts);
    picture
}

#[test]
fn known_pixels_give_known_figures() {
    // Two tiles side by side; the right one has 128 samples and alternating errors.
    let (width, height) = (128, 64);
    let right = |at: usize| at % width >= 64;
    let error = |at: usize| match (right(at), at % 2) {
        (false, _) => 0.0,
        (true, 0) => 0.3,
        (true, _) => -0.1,
    };
    let pixels = 0..width * height;
    let x: Vec<f64> = pixels.clone().map(|at| 1.0 + error(at)).collect();
    let counts = pixels.map(|at| if right(at) { 128 } else { 64 }).collect();
    let mut reference = picture(width, &vec![1.0; x.len()]);
    reference.planes.variance = Some(vec![[0.02; 3]; x.len()]);
    let found = groups(&with_counts(picture(width, &x), counts), &reference);
    let [early, late] = found[..] else {
        panic!("{found:?}");
    };
    assert_eq!((early.samples_min, early.samples_max), (64, 64));
    assert_eq!((early.pixels, early.tiles, early.mse), (4096, 1, 0.0));
    assert_eq!(
        (early.difference.z, early.difference.interval_95),
        (0.0, 0.0)
    );
    assert_eq!((late.samples_min, late.pixels, late.tiles), (128, 4096, 1));
    assert!((late.difference.mean - 0.1).abs() < 1e-7, "{late:?}");
    // Deviation 0.2 over the root of n - 1.
    let standard_error = 0.2 / 4095f64.sqrt();
    let relative = late.difference.standard_error / standard_error - 1.0;
    assert!(relative.abs() < 1e-6, "{late:?}");
    assert!((late.difference.z - 0.1 / standard_error).abs() < 1e-3);
    assert!((late.relative_difference.mean - 0.1 / 1.1).abs() < 1e-7);
    assert!((late.rel_mse - 0.05 / 1.01).abs() < 1e-7, "{late:?}");
    let own = late.reference_rel_mse.expect("has variances");
    assert!((own - 0.02 / 1.01).abs() < 1e-7, "{own}");
    assert_eq!(own_rel_mse(&picture(width, &x)), None);
}

/// Made-up pictures of noise alone, on both sides: z has mean square 1. False alarm of
/// this test: the sum of 800 squares of normal numbers lies 5 deviations off, 1e-6.
#[test]
fn the_standard_error_is_honest() {
    let mut random = random(1);
    let (mut squares, mut relative, mut inside) = (0.0, 0.0, 0);
    for _ in 0..400 {
        let mut noise = |scale: f64| -> Vec<f64> {
            (0..64 * 64)
                .map(|_| 1.0 + scale * (exponential(&mut random) - 1.0))
                .collect()
        };
        let (x, r) = (noise(0.5), noise(0.2));
        let counts = (0..x.len()).map(|at| 64 << (at / 32 % 2)).collect();
        for group in groups(&with_counts(picture(64, &x), counts), &picture(64, &r)) {
            let (own, weighed) = (group.difference.z, group.relative_difference.z);
            squares += own * own;
            relative += weighed * weighed;
            inside += i32::from(group.difference.mean.abs() <= group.difference.interval_95);
        }
    }
    let deviation = (2.0 / 800f64).sqrt();
    assert!((squares / 800.0 - 1.0).abs() < 5.0 * deviation, "{squares}");
    assert!(
        (relative / 800.0 - 1.0).abs() < 5.0 * deviation,
        "{relative}"
    );
    // 95 % of 800 are 760, deviation 6.
    assert!((730..=790).contains(&inside), "{inside}");
}

/// The noise of the reference is a third of its light: weights that know it would make
/// every pixel that it left too dark count for more.
#[test]
fn the_weights_know_nothing_of_what_they_weigh() {
    let mut random = random(2);
    let r: Vec<f64> = (0..128 * 64)
        .map(|_| 1.0 + 0.33 * (exponential(&mut random) - 1.0))
        .collect();
    let counts = (0..r.len()).map(|at| 64 << (at / 64 % 2)).collect();
    let x = with_counts(picture(128, &vec![1.0; r.len()]), counts);
    let found = groups(&x, &picture(128, &r));
    assert_eq!(found.len(), 2);
    for group in found {
        assert!(group.relative_difference.z.abs() < 4.0, "{group:?}");
    }
}

/// Tiles that end because they have not met any bright sample are too dark, and their row
/// says so, while all pixels together are right.
#[test]
fn what_ended_early_by_luck_is_seen() {
    let mut random = random(3);
    let tiles = 32;
    let (mut x, mut counts) = (Vec::new(), Vec::new());
    for _ in 0..tiles {
        // 64 rows of one tile; one pixel of 4096 is twenty times as bright as it should be.
        let tile: Vec<f64> = (0..64 * 64)
            .map(|_| {
                let firefly = if random() < 1.0 / 4096.0 { 20.0 } else { 0.0 };
                1.0 - 20.0 / 4096.0 + firefly + 0.05 * (exponential(&mut random) - 1.0)
            })
            .collect();
        let lucky = tile.iter().all(|&v| v < 10.0);
        counts.extend(vec![if lucky { 64 } else { 128 }; tile.len()]);
        x.extend(tile);
    }
    let reference = picture(64, &vec![1.0; x.len()]);
    let whole = metrics(&picture(64, &x).rgb, &reference.rgb);
    assert!(whole.mean_difference.abs() < 2.0 * whole.mean_difference_95);
    let found = groups(&with_counts(picture(64, &x), counts), &reference);
    assert_eq!(found[0].samples_min, 64);
    assert!(found[0].tiles > 4, "{found:?}");
    assert!(found[0].difference.z < -6.0, "{found:?}");
    assert!(found[1].difference.effective_pixels < 40.0, "{found:?}");
}

#[test]
fn one_number_is_no_group_and_many_are_few() {
    let grey = vec![1.0; 64 * 64];
    let plain = picture(64, &grey);
    assert_eq!(groups(&plain, &plain), []);
    let uniform = with_counts(plain.clone(), vec![64; grey.len()]);
    assert_eq!(groups(&uniform, &plain), []);
    let counts: Vec<u32> = (0..grey.len() as u32).collect();
    let found = groups(&with_counts(plain.clone(), counts), &plain);
    assert_eq!(found.len(), 13);
    let last = found.last().expect("thirteen");
    assert_eq!((last.samples_min, last.samples_max), (2048, 4095));
    assert_eq!(found.iter().map(|g| g.pixels).sum::<usize>(), grey.len());
    // Another size is told apart elsewhere; here it is no panic.
    let wide = picture(128, &grey);
    let counts = (0..grey.len() as u32).map(|at| at % 2).collect();
    assert_eq!(groups(&with_counts(plain, counts), &wide), []);
}
