//! Against the authors' program: `expected.py` beside this file prints the values.

use super::*;

const WIDTH: usize = 96;
const HEIGHT: usize = 64;

/// Agreement that is asked for; single precision leaves about 1e-6.
const TOLERANCE: f64 = 1e-4;

/// `python worker/report/src/flip/expected.py` with flip-evaluator 1.7: kind, LDR mean,
/// HDR mean, first and last exposure, how many.
const EXPECTED: [(&str, f64, f64, f32, f32, usize); 4] = [
    ("noisy", 0.1632547, 0.1764207, -3.08737, 3.70562, 7),
    ("shifted", 0.2717446, 0.2897650, -3.08737, 3.70562, 7),
    ("tinted", 0.1649797, 0.2012669, -3.08737, 3.70562, 7),
    ("fireflies", 0.0199652, 0.0375884, -3.08737, 3.70562, 7),
];

fn noise(number: usize) -> f64 {
    let mut x = (number as u32).wrapping_mul(2_654_435_761);
    x ^= x >> 15;
    x = x.wrapping_mul(2_246_822_519);
    x ^= x >> 13;
    f64::from(x >> 8) / 16_777_216.0
}

fn reference(x: usize, y: usize, c: usize) -> f64 {
    let (u, v) = (x as f64 / WIDTH as f64, y as f64 / HEIGHT as f64);
    let mut base = [u, v, 0.25][c];
    if (x / 12 + y / 12).is_multiple_of(2) {
        base *= 0.2;
    }
    let lamp = (60..70).contains(&x) && (20..26).contains(&y);
    base * if lamp { 40.0 } else { 1.0 }
}

fn picture(kind: &str) -> Vec<[f32; 3]> {
    let value = |x: usize, y: usize, c: usize| {
        let n = noise((y * WIDTH + x) * 3 + c);
        let r = reference(x, y, c);
        let r = match kind {
            "noisy" => r * (0.5 + n),
            "shifted" => reference(x.saturating_sub(2), y, c),
            "tinted" => r * [1.1, 1.0, 0.8][c],
            "fireflies" if n > 0.998 => r + 30.0,
            _ => r,
        };
        r as f32
    };
    (0..WIDTH * HEIGHT)
        .map(|p| [0, 1, 2].map(|c| value(p % WIDTH, p / WIDTH, c)))
        .collect()
}

const fn plane(rgb: &[[f32; 3]]) -> Plane<'_> {
    Plane {
        width: WIDTH,
        height: HEIGHT,
        rgb,
    }
}

#[test]
fn agrees_with_the_authors_program() {
    let reference = picture("reference");
    for (kind, ldr, hdr, start, stop, count) in EXPECTED {
        let test = picture(kind);
        let found = mean(&ldr_flip(
            &plane(&test),
            &plane(&reference),
            PIXELS_PER_DEGREE,
        ));
        assert!((found - ldr).abs() < TOLERANCE, "{kind}: {found} {ldr}");
        let found = hdr_flip(&plane(&test), &plane(&reference), PIXELS_PER_DEGREE).expect("light");
        let exposures = found.exposures;
        assert!((exposures.start - start).abs() < 1e-4, "{exposures:?}");
        assert!((exposures.stop - stop).abs() < 1e-4, "{exposures:?}");
        assert_eq!(exposures.count, count);
        let found = mean(&found.map);
        assert!((found - hdr).abs() < TOLERANCE, "{kind}: {found} {hdr}");
    }
}

#[test]
fn equal_pictures_have_no_error() {
    let picture = picture("reference");
    let ldr = ldr_flip(&plane(&picture), &plane(&picture), PIXELS_PER_DEGREE);
    assert!(ldr.iter().all(|&error| error == 0.0));
    let hdr = hdr_flip(&plane(&picture), &plane(&picture), PIXELS_PER_DEGREE).expect("light");
    assert!(hdr.map.iter().all(|&error| error == 0.0));
}

#[test]
fn the_largest_difference_is_near_one() {
    let (green, blue) = (
        [[0.0, 1.0, 0.0]; WIDTH * HEIGHT],
        [[0.0, 0.0, 1.0]; WIDTH * HEIGHT],
    );
    let map = ldr_flip(&plane(&green), &plane(&blue), PIXELS_PER_DEGREE);
    assert!((mean(&map) - 1.0).abs() < 1e-3, "{}", mean(&map));
}

#[test]
fn hostile_pictures_end_in_no_panic() {
    let black = [[0.0; 3]; WIDTH * HEIGHT];
    let bright = [[f32::MAX; 3]; WIDTH * HEIGHT];
    let negative = [[-1.0; 3]; WIDTH * HEIGHT];
    assert_eq!(hdr_flip(&plane(&bright), &plane(&black), 67.0), None);
    assert_eq!(hdr_flip(&plane(&bright), &plane(&negative), 67.0), None);
    let found = hdr_flip(&plane(&negative), &plane(&bright), 67.0).expect("light");
    assert!(found.map.iter().all(|e| (0.0..=1.0).contains(e)));
    let mut dark = black;
    dark[7] = [1.0; 3];
    let found = hdr_flip(&plane(&black), &plane(&dark), 67.0).expect("light");
    // From 1 to f32::EPSILON, 2^-23.
    assert_eq!(found.exposures.count, 23);
    let small = Plane {
        width: 3,
        height: 1,
        rgb: &dark[..3],
    };
    assert!(ldr_flip(&small, &plane(&dark), 67.0).is_empty());
    assert_eq!(ldr_flip(&small, &small, 67.0).len(), 3);
}
