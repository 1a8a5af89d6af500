//! Volumes: what passes, what is scattered, and how wrong marching is.

use crate::common::{WHITE_SKY, mean_and_error, scene};
use crate::table::{Case, Form, Row, Section};
use crate::volumes::{ball, cube, depth, lumpy, mean, passes, rays, survives, unit};
use glam::{UVec3, Vec3};
use shearwater_tracer::BuildOptions;
use shearwater_tracer::geometry::Ray;
use shearwater_tracer::math::hash::mix64;
use shearwater_tracer::medium::{Media, Method, Volume, Walk};

static SECTION: Section = Section::new(
    "Participating media",
    &[
        Case {
            name: "Beer and Lambert",
            note: "Relative error of what an even volume passes over 1 m, without noise, from a point inside (from 7 m away the \
                   32-bit distance adds 5e-7 sigma).",
            broken_by: "an extinction of 1.00001 sigma",
            rows: beer,
        },
        Case {
            name: "black ball, mean over its disc",
            note: "2/tau^2 (1 - (1 + tau) exp(-tau)), tau along a diameter; 400,000 rings of equal area.",
            broken_by: "an extinction of 1.001 sigma; the ball's box instead of the ball",
            rows: black_ball,
        },
        Case {
            name: "slab, scattered once",
            note: "Even phase function, optical thickness 1, irradiance pi along the view: (1/8)(1 - exp(-2)) comes back, exp(-1)/4 \
                   goes on.",
            broken_by: "collisions at the middle of what a free path is drawn for",
            rows: slab,
        },
        Case {
            name: "white cloud in a white furnace",
            note: "Albedo 1, noise, two lobes and a marched volume in one: every path ends in the sky with all its weight, so there is \
                   no noise either.",
            broken_by: "an albedo of 0.9999",
            rows: furnace,
        },
        Case {
            name: "thick white cloud from inside",
            note: "A hundred free paths across: thousands of scatterings, of which none is cut off.",
            broken_by: "paths cut at 512 scatterings",
            rows: thick,
        },
        Case {
            name: "tracking",
            note: "Delta tracking (paths) and ratio tracking (shadow rays) of optical depths about 3, through lumps and through cells that \
                   are dense and thin by turns, mean over 40 rays; the exact value from 20,000 midpoints.",
            broken_by: "majorants of 0.9 of the bound",
            rows: lumps,
        },
        Case {
            name: "densities beyond the bounds of their cell",
            note: "Lookups of 20,000 along random rays: one would be a silent bias. The chessboard has dense and thin cells by turns, so \
                   that each reaches into its neighbours.",
            broken_by: "bounds without the neighbouring voxels",
            rows: bounds,
        },
        Case {
            name: "marching past a jump, relative bias",
            note: "n jittered steps over optical depth 2, the density jumps at 37 % of a step: (f + (1 - f) e^-a) e^(a (1 - f)) - 1, \
                   f = .37, a = 2/n. The model departs from the truth, upwards (Jensen) and as 1/n^2; the method is the scene's choice.",
            broken_by: "the jitter fixed at the middles of steps",
            rows: marching,
        },
        Case {
            name: "tracking past the same jump, relative bias",
            note: "",
            broken_by: "an extinction of 1.001 sigma",
            rows: tracking,
        },
    ],
);

#[test]
fn media() {
    SECTION.check();
}

fn only(volume: Volume) -> Media {
    Media::new(vec![volume])
}

fn beer(_: Form) -> Vec<Row> {
    let row = |sigma: f32| {
        let even = only(cube(UVec3::new(20, 9, 33), vec![1.0; 20 * 9 * 33], sigma));
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let worst = (0..20)
            .map(|key| passes(&even, &ray, key) / libm::exp(-f64::from(sigma)) - 1.0)
            .fold(
                0.0,
                |worst: f64, e| if e.abs() > worst.abs() { e } else { worst },
            );
        Row::near(format!("sigma {sigma}"), 0.0, worst, 1e-6)
    };
    [0.01, 0.1, 1.0, 3.0, 5.0].map(row).to_vec()
}

fn black_ball(_: Form) -> Vec<Row> {
    let row = |tau: f64| {
        let ball = only(ball(tau as f32 / 2.0));
        let n = 400_000;
        let sum: f64 = (0..n)
            .map(|i| ((f64::from(i) + 0.5) / f64::from(n)).sqrt())
            .map(|r| Ray::new(Vec3::new(0.6 * r as f32, 0.8 * r as f32, 7.0), Vec3::NEG_Z))
            .map(|ray| passes(&ball, &ray, 1))
            .sum();
        let exact = 2.0 / (tau * tau) * (1.0 - (1.0 + tau) * libm::exp(-tau));
        let tolerance = 2e-5 * exact;
        Row::near(format!("tau {tau}"), exact, sum / f64::from(n), tolerance)
    };
    [0.1, 1.0, 2.0, 5.0, 20.0].map(row).to_vec()
}

fn slab(form: Form) -> Vec<Row> {
    let mut slab = cube(UVec3::new(4, 4, 40), vec![1.0; 640], 0.5);
    slab.voxels_from_world.x_axis.x = 2e-5;
    slab.voxels_from_world.y_axis.y = 2e-5;
    let media = only(slab);
    let ray = Ray::new(Vec3::new(100.0, -20.0, 7.0), Vec3::NEG_Z);
    let row = |(what, to_light, exact): (&str, Vec3, f64)| {
        let (found, error) = mean(form.pick(200_000, 1_000_000), |key| {
            let met = media.collide(&ray, f32::INFINITY, key).expect("few steps");
            met.map_or(0.0, |c| {
                let shadow = Ray::new(ray.at(c.t), to_light);
                let phase = f64::from(c.phase.pdf(-ray.d, to_light));
                std::f64::consts::PI * phase * passes(&media, &shadow, !key)
            })
        });
        Row::sampled(what, exact, found, 4.0, error, 1e-6)
    };
    let back = (1.0 - libm::exp(-2.0)) / 8.0;
    let on = libm::exp(-1.0) / 4.0;
    [
        ("reflected", Vec3::Z, back),
        ("transmitted", Vec3::NEG_Z, on),
    ]
    .map(row)
    .to_vec()
}

const LUMPY: &str = r#""edge":0.5,"resolution":32,"noise":{"scale_m":1.3,"seed":4}"#;

fn white(radii: [f64; 3], more: &str, last: &str) -> String {
    format!(
        r#"{{"type":"volume","shape":{{"type":"ellipsoid","centre_m":[0,0,0],"radii_m":{radii:?}{more}}},{last}}}"#
    )
}

fn seen(clouds: &str, eye: [f64; 3]) -> shearwater_tracer::Scene {
    let body = format!(r#""clouds":[{clouds}],{WHITE_SKY}"#);
    scene(&body, eye, [0.0; 3], 30.0, 21, BuildOptions::default())
}

fn furnace(form: Form) -> Vec<Row> {
    let noise = format!(",{LUMPY}");
    let front = white([2.0, 1.0, 1.5], &noise, r#""sigma_t_per_m":6,"g":0.7"#);
    let back = white([1.0, 2.0, 1.5], &noise, r#""sigma_t_per_m":6,"g":-0.4"#);
    let marched = white(
        [1.0; 3],
        &noise,
        r#""sigma_t_per_m":2,"method":{"type":"march","step_m":0.3}"#,
    );
    let scene = seen(&format!("{front},{back},{marched}"), [0.0, 0.0, 6.0]);
    vec![Row::near(
        "",
        1.0,
        mean_and_error(&scene, form.pick(32, 256)).0,
        1e-5,
    )]
}

fn thick(form: Form) -> Vec<Row> {
    let scene = seen(
        &white([1.0; 3], "", r#""sigma_t_per_m":50"#),
        [0.0, 0.0, 0.2],
    );
    let (found, error) = mean_and_error(&scene, form.pick(16, 128));
    vec![Row::sampled("", 1.0, found, 5.0, error, 1e-4)]
}

// Dense and thin cells by turns, as a chessboard: a dense cell is nearly as dense as its
// bound everywhere, and a thin one only where a neighbour's voxels reach into it.
fn chequered(sigma_t_per_m: f32) -> Volume {
    let values = (0..24 * 24 * 24_u64)
        .map(|i| {
            let (x, y, z) = (i % 24, i / 24 % 24, i / 576);
            let dense = (x / 8 + y / 8 + z / 8) % 2 == 1;
            0.1 * unit(i) + if dense { 0.9 } else { 0.0 }
        })
        .collect();
    cube(UVec3::splat(24), values, sigma_t_per_m)
}

fn lumps(form: Form) -> Vec<Row> {
    let keys = form.pick(4_000, 40_000);
    let rows = |(name, volume): (&str, Volume)| {
        let media = only(volume.clone());
        let (mut paths, mut shadows, mut exact) = ((0.0, 0.0), (0.0, 0.0), 0.0);
        for (number, ray) in (0_u64..).zip(rays(40)) {
            // Each ray by draws of its own, or their errors would add.
            let key = |key: u64| key ^ mix64(number);
            exact += libm::exp(-depth(&volume, &ray, f32::INFINITY)) / 40.0;
            for (sums, (m, e)) in [
                (
                    &mut paths,
                    mean(keys, |k| survives(&media, &ray, f32::INFINITY, key(k))),
                ),
                (&mut shadows, mean(keys, |k| passes(&media, &ray, key(k)))),
            ] {
                *sums = (sums.0 + m / 40.0, sums.1 + e * e / 1600.0);
            }
        }
        let row = |what: &str, (m, e2): (f64, f64)| {
            Row::sampled(format!("{name}, {what}"), exact, m, 4.0, e2.sqrt(), 1e-6)
        };
        [row("paths", paths), row("shadow rays", shadows)]
    };
    [("lumps", lumpy(20.0, 3)), ("chessboard", chequered(2.0))]
        .into_iter()
        .flat_map(rows)
        .collect()
}

fn bounds(_: Form) -> Vec<Row> {
    [("lumps", lumpy(1.0, 5)), ("chessboard", chequered(1.0))]
        .map(|(name, volume)| Row::exact(name, 0.0, f64::from(outside_bounds(&volume))))
        .to_vec()
}

// Lookups along random rays that lie above or below the bounds of their cell.
fn outside_bounds(volume: &Volume) -> u32 {
    let mut outside = 0;
    for ray in rays(1000) {
        let Some(span) = volume.span(&ray, f32::INFINITY) else {
            continue;
        };
        let mut t = span.t0;
        for piece in Walk::new(&volume.density, &span) {
            for i in 0..20 {
                let inside = t + (piece.end - t) * (i as f32 + 0.5) / 20.0;
                let density = volume.density.density(span.at(inside));
                // A few roundings of the interpolation.
                let slack = 1e-6 * piece.bounds.max;
                outside += u32::from(
                    density > piece.bounds.max + slack || density < piece.bounds.min - slack,
                );
            }
            t = piece.end;
        }
    }
    outside
}

const JUMP: f64 = 0.37;

// A density that jumps from 0 to 1 at JUMP of one of n steps; its exact light.
fn jump(n: u32) -> (Volume, f64) {
    let voxels = 2000;
    let at = (f64::from(n / 3) + JUMP) / f64::from(n);
    let values = (0..voxels)
        .map(|i| f32::from(u8::from((f64::from(i) + 0.5) / f64::from(voxels) > at)))
        .collect();
    let volume = cube(UVec3::new(voxels, 1, 1), values, 1.0);
    let exact = libm::exp(-depth(&volume, &across(), f32::INFINITY));
    (volume, exact)
}

fn across() -> Ray {
    Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X)
}

const STEPS: [u32; 5] = [1, 4, 8, 16, 64];

fn marching(form: Form) -> Vec<Row> {
    let row = |n: u32| {
        let (volume, exact) = jump(n);
        // A hair more than the n-th part, or roundings make one step more.
        let step_m = 2.0 / n as f32 * 1.000_001;
        let marched = only(Volume {
            method: Method::March { step_m },
            ..volume
        });
        let (passed, error) = mean(form.pick(100_000, 1_000_000), |key| {
            passes(&marched, &across(), key)
        });
        let a = 2.0 / f64::from(n);
        let bias = (JUMP + (1.0 - JUMP) * libm::exp(-a)) * libm::exp(a * (1.0 - JUMP)) - 1.0;
        // 1e-3: the jump is one voxel of 2000 wide.
        Row::sampled(
            format!("{n} steps"),
            bias,
            passed / exact - 1.0,
            4.0,
            error / exact,
            1e-3,
        )
    };
    STEPS.map(row).to_vec()
}

fn tracking(form: Form) -> Vec<Row> {
    let row = |n: u32| {
        let (volume, exact) = jump(n);
        let media = only(volume);
        let (passed, error) = mean(form.pick(100_000, 1_000_000), |key| {
            passes(&media, &across(), key)
        });
        Row::sampled(
            format!("at {n}"),
            0.0,
            passed / exact - 1.0,
            4.0,
            error / exact,
            1e-5,
        )
    };
    STEPS.map(row).to_vec()
}
