//! Many things that each let most light through.

use crate::shapes::Random;
use crate::table::{Case, Form, Row, Section};
use glam::Vec3;
use shearwater_tracer::geometry::{Ellipsoid, Geometry, OPTICAL_DEPTH_SCALE, Particles, Ray};
use shearwater_tracer::uses::PARTICLES;

static SECTION: Section = Section::new(
    "Transparency",
    &[
        Case {
            name: "light through k layers of opacity a",
            note: "(1 - a)^k for nested shells seen from their middle, each crossed once. Relative error; integer optical depths \
                   round each layer to 2^-24. A cut after 64 layers would give .7256 for the first.",
            broken_by: "walks that end after 64 walls",
            rows: layers,
        },
        Case {
            name: "shells seen from outside, 0.1 mm apart",
            note: "Opacity belongs to each crossing of a wall, so a shell takes (1 - a)^2. Relative error.",
            broken_by: "the wall by which a shell is left not counted",
            rows: outside,
        },
        Case {
            name: "paths that pass k layers",
            note: "The share of hashed decisions that let a path through. No layer costs path depth.",
            broken_by: "one hash for all walls",
            rows: stochastic,
        },
        Case {
            name: "100,000 layers on a stack of 128 KiB",
            note: "Nothing recurses. Relative error of exp(-10); rounding of the depths explains 0.0013.",
            broken_by: "walks that end after 64 walls; one hash for all walls",
            rows: deep,
        },
    ],
);

#[test]
fn layers_of_little() {
    SECTION.check();
}

fn shells(count: u32, opacity: f32, gap: f32) -> Geometry {
    let shell = |i: u32| Ellipsoid {
        centre: Vec3::ZERO,
        radii: Vec3::splat(1.0 + i as f32 * gap),
        opacity,
    };
    let all: Vec<_> = (0..count).map(shell).collect();
    let particles = Particles::build(&all).expect("shells");
    Geometry::build(vec![], vec![], Some(particles.into()), None).expect("a scene")
}

fn passed(scene: &Geometry, ray: &Ray) -> f64 {
    let depth = scene.transmittance_depth::<PARTICLES>(ray).depth();
    libm::exp(-f64::from(depth) / f64::from(OPTICAL_DEPTH_SCALE))
}

fn outwards() -> Ray {
    Ray::new(Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8))
}

fn through(count: u32, opacity: f32) -> f64 {
    libm::pow(1.0 - f64::from(opacity), f64::from(count))
}

fn layers(_: Form) -> Vec<Row> {
    let row = |(count, opacity): (u32, f32)| {
        let found = passed(&shells(count, opacity, 1e-4), &outwards());
        let error = found / through(count, opacity) - 1.0;
        Row::near(format!("k = {count}, a = {opacity}"), 0.0, error, 5e-5)
    };
    [(1000, 0.005), (100, 0.1), (10, 0.8), (1, 0.999)]
        .map(row)
        .to_vec()
}

fn outside(_: Form) -> Vec<Row> {
    let scene = shells(1000, 0.003, 1e-4);
    let found = passed(&scene, &Ray::new(Vec3::Z * -4.0, Vec3::Z));
    vec![Row::near(
        "k = 1000, a = 0.003",
        0.0,
        found / through(2000, 0.003) - 1.0,
        1e-4,
    )]
}

fn stochastic(form: Form) -> Vec<Row> {
    let rays = form.pick(100_000, 2_000_000);
    let row = |(count, opacity): (u32, f32)| {
        let scene = shells(count, opacity, 1e-4);
        let mut r = Random(6);
        let ray = outwards();
        let passed = (0..rays).filter(|_| scene.intersect::<PARTICLES>(&ray, r.next()).is_none());
        let share = passed.count() as f64 / f64::from(rays);
        let exact = through(count, opacity);
        let error = (exact * (1.0 - exact) / f64::from(rays)).sqrt();
        Row::sampled(
            format!("k = {count}, a = {opacity}"),
            exact,
            share,
            4.0,
            error,
            0.0,
        )
    };
    [(1000, 0.005), (10, 0.2), (1, 0.5)].map(row).to_vec()
}

fn deep(_: Form) -> Vec<Row> {
    let scene = shells(100_000, 1e-4, 1e-5);
    let exact = through(100_000, 1e-4);
    let walk = || {
        let found = passed(&scene, &outwards());
        let hits: u32 = (0..64)
            .map(|key| u32::from(scene.intersect::<PARTICLES>(&outwards(), key).is_some()))
            .sum();
        (found, hits)
    };
    let (found, hits) = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(128 * 1024);
        let handle = thread.spawn_scoped(scope, walk).expect("a thread");
        handle.join().expect("no overflow")
    });
    vec![
        Row::near("light", 0.0, found / exact - 1.0, 2e-3),
        Row::exact("paths of 64 that meet one", 64.0, f64::from(hits)),
    ]
}
