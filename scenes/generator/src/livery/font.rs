//! A stroke font: capitals and digits as polylines in a box 4 wide, 6 high.

/// One stroke: points (x, y), y upwards, in units of the letter box.
pub type Stroke = &'static [(f64, f64)];

/// Width of a letter's box, in the units of the strokes.
pub const WIDTH: f64 = 4.0;
/// Height of a letter's box.
pub const HEIGHT: f64 = 6.0;
/// Distance from one letter's left edge to the next one's.
pub const ADVANCE: f64 = 6.0;

const A: &[Stroke] = &[&[(0., 0.), (2., 6.), (4., 0.)], &[(0.75, 2.2), (3.25, 2.2)]];
const E_: &[Stroke] = &[
    &[(4., 6.), (0., 6.), (0., 0.), (4., 0.)],
    &[(0., 3.1), (3.2, 3.1)],
];
const H: &[Stroke] = &[
    &[(0., 0.), (0., 6.)],
    &[(4., 0.), (4., 6.)],
    &[(0., 3.1), (4., 3.1)],
];
const N: &[Stroke] = &[&[(0., 0.), (0., 6.), (4., 0.), (4., 6.)]];
const R: &[Stroke] = &[
    &[
        (0., 0.),
        (0., 6.),
        (2.8, 6.),
        (3.6, 5.7),
        (4., 5.0),
        (4., 4.0),
        (3.6, 3.2),
        (2.8, 2.9),
        (0., 2.9),
    ],
    &[(2.2, 2.9), (4., 0.)],
];
const S: &[Stroke] = &[&[
    (4., 5.2),
    (3.4, 5.8),
    (2.5, 6.),
    (1.4, 6.),
    (0.5, 5.7),
    (0., 5.0),
    (0., 4.2),
    (0.5, 3.5),
    (1.4, 3.2),
    (2.6, 2.9),
    (3.5, 2.6),
    (4., 1.9),
    (4., 1.0),
    (3.5, 0.3),
    (2.6, 0.),
    (1.4, 0.),
    (0.6, 0.2),
    (0., 0.8),
]];
const T: &[Stroke] = &[&[(0., 6.), (4., 6.)], &[(2., 6.), (2., 0.)]];
const W: &[Stroke] = &[&[(0., 6.), (0.9, 0.), (2., 4.4), (3.1, 0.), (4., 6.)]];
const FOUR: &[Stroke] = &[&[(3., 0.), (3., 6.), (0., 1.8), (4., 1.8)]];
const TWO: &[Stroke] = &[&[
    (0., 4.8),
    (0.4, 5.6),
    (1.3, 6.),
    (2.7, 6.),
    (3.6, 5.6),
    (4., 4.8),
    (4., 4.1),
    (3.6, 3.3),
    (0., 0.),
    (4., 0.),
]];
const ONE: &[Stroke] = &[&[(0.8, 4.8), (2.2, 6.), (2.2, 0.)], &[(0.8, 0.), (3.6, 0.)]];

/// Strokes of a character; what the font does not hold is a blank.
#[must_use]
pub fn strokes(letter: char) -> &'static [Stroke] {
    match letter {
        'A' => A,
        'E' => E_,
        'H' => H,
        'N' => N,
        'R' => R,
        'S' => S,
        'T' => T,
        'W' => W,
        '1' => ONE,
        '2' => TWO,
        '4' => FOUR,
        _ => &[],
    }
}

/// Width of a text in units of the strokes.
#[must_use]
pub fn text_width(text: &str) -> f64 {
    ADVANCE * text.chars().count() as f64 - (ADVANCE - WIDTH)
}

/// Distance of a point (x from the text's left end, y from its foot) to the
/// nearest stroke, in units of the strokes; large if far from every letter.
#[must_use]
pub fn distance(text: &str, x: f64, y: f64) -> f64 {
    let mut nearest = 1e3;
    if !(-2.0..=HEIGHT + 2.0).contains(&y) || x < -2.0 || x > text_width(text) + 2.0 {
        return nearest;
    }
    for (i, letter) in text.chars().enumerate() {
        let local = x - ADVANCE * i as f64;
        if !(-2.0..=WIDTH + 2.0).contains(&local) {
            continue;
        }
        for stroke in strokes(letter) {
            for pair in stroke.windows(2) {
                nearest = f64::min(nearest, to_segment((local, y), pair[0], pair[1]));
            }
        }
    }
    nearest
}

/// Distance of a point to a segment of the plane.
#[must_use]
pub fn to_segment(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = dx * dx + dy * dy;
    let t = if length2 > 0.0 {
        (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (ex, ey) = (p.0 - a.0 - t * dx, p.1 - a.1 - t * dy);
    (ex * ex + ey * ey).sqrt()
}
