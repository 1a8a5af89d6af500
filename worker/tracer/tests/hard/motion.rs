//! Things that move while the shutter is open.

use crate::blades::{blades, coverage, spinning};
use crate::common::{RECT, SIDE, sums};
use crate::joints::{SHUTTER_S, build, chain};
use crate::shapes::{Mesh, Random, ball, soup};
use crate::table::{Case, Form, Row, Section};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use shearwater_shared::film::TileFilm;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::parse;
use shearwater_tracer::geometry::{Geometry, HitKind, Instance, Joint, Ray};
use shearwater_tracer::uses::MOTION;
use shearwater_tracer::{Assets, BuildOptions, Scene, Stage};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

static SECTION: Section = Section::new(
    "Motion",
    &[
        Case {
            name: "propeller of N blades",
            note: "Blades of an angle b that turn by 1/N cover N b / 360 of the shutter at every radius; the largest deviation at six \
                   radii, with 4096 even times: 2/4096, and 1e-5 for the blades' polygons.",
            broken_by: "corners that move straight from the opening to the end of the shutter",
            rows: propellers,
        },
        Case {
            name: "blades of constant chord c",
            note: "(N/pi) asin(c / 2r) of the shutter; N = 3, c = 0.2, whole turn, 16,384 even times.",
            broken_by: "corners that move straight from the opening to the end of the shutter",
            rows: chord,
        },
        Case {
            name: "edge that moves by v",
            note: "The share of the shutter falls linearly over v. Largest deviation over 31 places with 1000 even times: at most 1/1000.",
            broken_by: "a slide at 0.99 of its speed",
            rows: edge,
        },
        Case {
            name: "trees of what moves",
            note: "Random chains of turns, slides and keys: rays of 100,000 for which the tree finds another hit than a look at every \
                   instance by itself, bit for bit.",
            broken_by: "swept boxes of the shutter's two ends alone",
            rows: trees,
        },
        Case {
            name: "closed shutter",
            note: "Sums (pixels, halves, channels) that differ from those of the scene without any motion.",
            broken_by: "a shutter that is open for at least 1e-3 s",
            rows: closed,
        },
        Case {
            name: "open shutter against the mean of closed ones",
            note: "A spinning child of a sliding, keyed parent under a moving camera; mean of all pixels, and the largest difference of one.",
            broken_by: "the camera left where it was when the shutter opened",
            rows: open,
        },
    ],
);

#[test]
fn motion() {
    SECTION.check();
}

fn moving(mesh: &Mesh, joint: Joint) -> Geometry {
    let instance = Instance::moving(0, vec![joint], SHUTTER_S).expect("an instance");
    Geometry::build(vec![build(mesh)], vec![instance], None, None).expect("a scene")
}

// The value that lies furthest from `expected`.
fn furthest(values: impl Iterator<Item = f64>, expected: f64) -> f64 {
    let off = |v: f64| (v - expected).abs();
    values.fold(
        expected,
        |worst, v| if off(v) > off(worst) { v } else { worst },
    )
}

fn propellers(_: Form) -> Vec<Row> {
    let row = |(count, degrees): (usize, f64)| {
        let scene = spinning(
            &blades(count, degrees / 360.0, 0.1, 1.0),
            1.0 / count as f64,
        );
        let expected = count as f64 * degrees / 360.0;
        let radii = [0.11, 0.2, 0.3, 0.5, 0.7, 0.999];
        let found = radii.map(|r| coverage(&scene, r * 0.6, r * 0.8, 4096));
        let beyond = coverage(&scene, 1.001, 0.0, 4096);
        assert!(beyond == 0.0, "{beyond}");
        let worst = furthest(found.into_iter(), expected);
        Row::near(
            format!("{count} x {degrees} degrees"),
            expected,
            worst,
            2.0 / 4096.0 + 1e-5,
        )
    };
    [(3, 12.0), (2, 10.0), (4, 15.0)].map(row).to_vec()
}

fn chord(_: Form) -> Vec<Row> {
    let chord = 0.2_f32;
    let mut mesh: Mesh = (vec![], vec![]);
    for blade in 0..3 {
        let angle = f64::from(blade) / 3.0 * TAU;
        let (cos, sin) = (libm::cos(angle) as f32, libm::sin(angle) as f32);
        let (u, v) = (
            Vec3::new(cos, sin, 0.0),
            Vec3::new(-sin, cos, 0.0) * (0.5 * chord),
        );
        let first = mesh.0.len() as u32;
        mesh.0.extend([v * -1.0, u * 2.0 - v, u * 2.0 + v, v]);
        mesh.1
            .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let scene = spinning(&mesh, 1.0);
    let row = |radius: f64| {
        let expected = 3.0 / PI * libm::asin(f64::from(chord) / (2.0 * radius));
        let found = coverage(&scene, radius, 0.0, 16_384);
        Row::near(format!("r = {radius}"), expected, found, 6.0 / 16_384.0)
    };
    [0.25, 0.5, 1.0, 1.9].map(row).to_vec()
}

fn edge(_: Form) -> Vec<Row> {
    let corners = [(-10.0, -1.0), (0.0, -1.0), (0.0, 1.0), (-10.0, 1.0)];
    let square = (
        corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let reach = 3.0;
    let scene = moving(
        &square,
        Joint::Slide(DVec3::X * reach / f64::from(SHUTTER_S)),
    );
    let off = (-2..29).map(|i| {
        let x = f64::from(i) * 0.12 + 0.003;
        coverage(&scene, x, 0.0, 1000) - (1.0 - x / reach).clamp(0.0, 1.0)
    });
    vec![Row::near("", 0.0, furthest(off, 0.0), 1e-3)]
}

fn trees(form: Form) -> Vec<Row> {
    let meshes = || vec![build(&soup(300, 5)), build(&ball(6, Vec3::ZERO, 0.5))];
    let instances: Vec<_> = (0..24)
        .map(|i| Instance::moving(i % 2, chain(u64::from(i)), SHUTTER_S).expect("an instance"))
        .collect();
    let scene = |of: Vec<Instance>| Geometry::build(meshes(), of, None, None).expect("a scene");
    let all = scene(instances.clone());
    let each: Vec<_> = instances.into_iter().map(|i| scene(vec![i])).collect();
    let mut r = Random(5);
    let (mut hits, mut other) = (0, 0);
    for _ in 0..form.pick(20_000, 100_000) {
        let o = r.cube() * 6.0;
        let d = (r.cube() * 3.0 - o).normalize();
        let ray = Ray::at_time(o, d, SHUTTER_S * r.unit());
        let best = each
            .iter()
            .enumerate()
            .filter_map(|(i, g)| g.intersect::<MOTION>(&ray, 0).map(|h| (h.t, i, h.kind)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let found = all.intersect::<MOTION>(&ray, 0).map(|hit| match hit.kind {
            HitKind::Triangle {
                instance,
                prim,
                u,
                v,
            } => {
                let kind = HitKind::Triangle {
                    instance: 0,
                    prim,
                    u,
                    v,
                };
                (hit.t, instance as usize, kind)
            }
            other => (hit.t, usize::MAX, other),
        });
        hits += usize::from(found.is_some());
        other += usize::from(found != best);
    }
    assert!(hits > 2_000, "{hits}");
    vec![Row::exact("", 0.0, other as f64)]
}

/// An L, so that no turn leaves it as it is.
const CARD: &str =
    "v -1 -1 0\nv 1 -1 0\nv 1 -0.4 0\nv -0.3 -0.4 0\nv -0.3 1 0\nv -1 1 0\nf 1 2 3 4\nf 1 4 5 6\n";

fn stage(instances: &Value, camera: &Value, animation: &Value) -> Stage {
    let mut seen = json!({"position_m": [0, 0, 8], "target_m": [0, 0, 0], "vertical_fov_deg": 40});
    for (key, value) in camera.as_object().expect("an object") {
        seen[key] = value.clone();
    }
    let described = json!({
        "version": 1, "name": "motion", "image": {"width": SIDE, "height": SIDE},
        "camera": seen, "animation": animation,
        "materials": {"black": {"type": "lambert", "albedo": [0, 0, 0]}},
        "meshes": {"card": {"file": "card.obj"}},
        "instances": instances, "sky": {"type": "constant", "radiance": [1, 1, 1]}
    });
    let assets: Assets = [("card.obj".to_owned(), Arc::from(CARD.as_bytes()))].into();
    let description = parse(described.to_string().as_bytes()).expect("a valid scene");
    let (stage, _) = Stage::build(&description, &assets, BuildOptions::default()).expect("a stage");
    stage
}

fn frame(stage: &Stage, frame: u32) -> Scene {
    let settings = RenderSettings {
        width: SIDE,
        height: SIDE,
        samples: 2,
        seed: 5,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    stage.frame(&settings, frame).expect("a frame")
}

fn cards(moving: bool) -> Value {
    let mut cards = json!([
        {"mesh": "card", "material": "black", "name": "body", "translate_m": [-1, 0, 0]},
        {"mesh": "card", "material": "black", "parent": "body", "translate_m": [1.5, 0, -1], "scale": [0.7, 0.7, 0.7]}
    ]);
    if moving {
        cards[0]["velocity_mps"] = json!([4, 0, 0]);
        cards[0]["path"] = json!([{"time_s": 0}, {"time_s": 0.2, "offset_m": [0, 1, 0], "turn_deg": [0, 0, 40]}, {"time_s": 0.5}]);
        cards[1]["spin"] = json!({"axis": [0, 0, 2], "rpm": 200, "pivot_m": [0.3, 0, 0]});
    }
    cards
}

fn closed(_: Form) -> Vec<Row> {
    let shut = json!({"velocity_mps": [1, 0, 0], "shutter_s": 0});
    let moving = sums(&frame(&stage(&cards(true), &shut, &Value::Null), 0), 0..16);
    let standing = stage(&cards(false), &json!({"shutter_s": 0.3}), &Value::Null);
    let standing = sums(&frame(&standing, 0), 0..16);
    let pairs = moving
        .radiance
        .iter()
        .flatten()
        .zip(standing.radiance.iter().flatten());
    let other = pairs.filter(|(a, b)| a != b).count();
    vec![Row::exact("", 0.0, other as f64)]
}

fn film(scene: &Scene, samples: u32) -> TileFilm {
    let mut film = TileFilm::zero(RECT.pixels());
    film.add(&sums(scene, 0..samples)).expect("fits");
    film
}

fn open(form: Form) -> Vec<Row> {
    let (shutter_s, moments, start_s) = (0.2, 64, 0.1);
    let camera = |shutter_s: f64| {
        json!({"velocity_mps": [0, 2, 1], "shutter_s": shutter_s,
            "path": [{"time_s": 0.05}, {"time_s": 0.35, "target_offset_m": [1, 0, 0]}]})
    };
    let samples = form.pick(2048, 16_384);
    let animation = json!({"fps": 5, "frames": 1, "start_s": start_s});
    let blurred = film(
        &frame(&stage(&cards(true), &camera(shutter_s), &animation), 0),
        samples,
    );
    // Moments in the middle of even parts of the shutter.
    let fps = f64::from(moments) / shutter_s;
    let animation = json!({"fps": fps, "frames": moments, "start_s": start_s + 0.5 / fps});
    let moment = stage(&cards(true), &camera(0.0), &animation);
    let mut mean = vec![[0.0; 2]; RECT.pixels()];
    for f in 0..moments {
        let film = film(&frame(&moment, f), samples / 32);
        for (pixel, sum) in mean.iter_mut().enumerate() {
            for (half, sum) in sum.iter_mut().enumerate() {
                *sum += film.half_mean(half, pixel)[0] / f64::from(moments);
            }
        }
    }
    let (mut off, mut variance, mut largest) = (0.0, 0.0, 0.0_f64);
    for (pixel, [a, b]) in mean.into_iter().enumerate() {
        let [c, d] = [0, 1].map(|half| blurred.half_mean(half, pixel)[0]);
        off += (c + d - a - b) / 2.0;
        variance += ((c - d) * (c - d) + (a - b) * (a - b)) / 4.0;
        largest = largest.max(((c + d - a - b) / 2.0).abs());
    }
    let pixels = RECT.pixels() as f64;
    // 64 moments are not all of them.
    let mean = Row::sampled(
        "mean",
        0.0,
        off / pixels,
        4.0,
        variance.sqrt() / pixels,
        5e-4,
    );
    vec![mean, Row::at_most("one pixel", 0.03, largest)]
}
