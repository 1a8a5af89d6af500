//! Large and small worlds: the picture does not know where the origin is, nor how long
//! a metre.

mod picture;
mod place;

use crate::table::{Case, Form, Law, Row, Section};
use picture::{Picture, noise_ratio, render};
use place::{WATERS, moved, scaled, scene, with_far_vertices};
use shearwater_shared::scene::SceneDescription;

/// What pictures of one seed may differ by: roundings move a few edges and decisions.
const SAME_SEED: f64 = 0.02;
/// What this project promises; 1 is the mean for independent pictures.
const OTHER_SEED: f64 = 2.0;

static SECTION: Section = Section::new(
    "Large and small worlds",
    &[
        Case {
            name: "a scene 100 km away",
            note: "Still, spinning and sliding instances, particles, sprites, tracked and marched volumes, sun, lens, open shutter, \
                   each kind of water; everything moved by (1e5, 1e4, -1e5) m, which are whole tiles and waves. Mean squared \
                   difference of the pictures over the error that the halves of both show.",
            broken_by: "render space about the scene's origin",
            rows: far,
        },
        Case {
            name: "there and back",
            note: "The same moved back: decimals lose a last digit. Same seed.",
            broken_by: "the seed mixed with the bits of the eye's place",
            rows: back,
        },
        Case {
            name: "another length of a metre",
            note: "All lengths times s, times and speeds as waves have them (sqrt s), extinction over s.",
            broken_by: "origins of rays moved by 1e-4 m",
            rows: sizes,
        },
        Case {
            name: "meshes 100 km from their own origin",
            note: "Vertices about (1e5, -2e4, 1e5) m, as maps have them, in instances that bring them back. The file's numbers are read \
                   in 32 bits, which have steps of 8 mm there: corners stand that far off, which is 0.03 of the noise of 512 samples.",
            broken_by: "the roundings of corners weighed by (u, v) left out of a point's error",
            rows: vertices,
        },
        Case {
            name: "the measure sees 5 cm",
            note: "The camera moved by 5 cm, same seed: the tolerance of the rows above would not pass it.",
            broken_by: "the eye's place rounded to half a metre",
            rows: shifted,
        },
    ],
);

#[test]
fn worlds() {
    SECTION.check();
}

/// Samples of each half of a pixel.
fn samples(form: Form) -> u32 {
    form.pick(24, 256)
}

fn original(water: &str, form: Form) -> Picture {
    let picture = render(&scene(water), 1, samples(form), false);
    assert!(picture.mean() > 0.05 && picture.noise() > 0.0, "a picture");
    picture
}

/// Rows of `other` against `original`: with its seed, and with another.
fn against(
    what: &str,
    original: &Picture,
    other: &SceneDescription,
    form: Form,
    far: bool,
) -> [Row; 2] {
    let ratio = |seed| noise_ratio(original, &render(other, seed, samples(form), far));
    [
        Row::at_most(format!("{what}, same seed"), SAME_SEED, ratio(1)),
        Row::at_most(format!("{what}, other seed"), OTHER_SEED, ratio(2)),
    ]
}

fn far(form: Form) -> Vec<Row> {
    let rows = |water: &str| {
        let other = moved(&scene(water), place::FAR_M);
        against(
            &format!("water: {water}"),
            &original(water, form),
            &other,
            form,
            false,
        )
    };
    WATERS.iter().flat_map(|water| rows(water)).collect()
}

fn back(form: Form) -> Vec<Row> {
    let there = moved(&scene("tessendorf"), place::FAR_M);
    let back = render(
        &moved(&there, place::FAR_M.map(|x| -x)),
        1,
        samples(form),
        false,
    );
    let ratio = noise_ratio(&original("tessendorf", form), &back);
    vec![Row::at_most("", SAME_SEED, ratio)]
}

fn sizes(form: Form) -> Vec<Row> {
    let rows = |water: &str| {
        let original = original(water, form);
        [1e-3, 1e3].map(|by| {
            let what = format!("water: {water}, s = {by}");
            against(&what, &original, &scaled(&scene(water), by), form, false)
        })
    };
    WATERS
        .iter()
        .flat_map(|water| rows(water).concat())
        .collect()
}

fn vertices(form: Form) -> Vec<Row> {
    let other = with_far_vertices(&scene("none"));
    let [_, other_seed] = against("vertices", &original("none", form), &other, form, true);
    vec![other_seed]
}

fn shifted(form: Form) -> Vec<Row> {
    let mut other = scene("none");
    other.camera.position_m[0] += 0.05;
    let ratio = noise_ratio(
        &original("none", form),
        &render(&other, 1, samples(form), false),
    );
    vec![Row::at_least("", 2.0 * SAME_SEED, ratio).by(Law::Fixed)]
}
