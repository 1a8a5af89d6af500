//! Mrays/s of the traversal beside Embree and the stock tree of obvhs: one process,
//! the same rays, alternating rounds, medians. Run it on one core that is quiet:
//! `taskset -c 1 cargo bench -p shearwater-tracer --bench traversal`.
//!
//! `ROUNDS=n` sets the rounds (default 5), `SCENE=bridge` picks one scene, `QUICK=1`
//! leaves out the references. A small criterion group follows for comparison with
//! earlier runs of one's own.

mod embree;
mod rays;
mod scenes;

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};
use glam::{Affine3A, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use shearwater_tracer::geometry::{Geometry, Instance, Ray, TriMesh};
use shearwater_tracer::uses::NOTHING;

use embree::Embree;
use rays::{COUNT, Rays};
use scenes::Scene;

/// One way to answer the queries. Each pass returns a number that depends on all
/// its answers.
enum Tracer {
    Single(Geometry),
    Packets(Geometry),
    Embree(Box<Embree>),
    Stock(Box<CwBvh>, Vec<RtTriangle>),
}

impl Tracer {
    fn closest(&self, rays: &[Ray]) -> usize {
        match self {
            Self::Single(g) => rays
                .iter()
                .filter(|r| g.intersect::<NOTHING>(r, 0).is_some())
                .count(),
            Self::Packets(g) => packets(rays)
                .map(|p| g.intersect8::<NOTHING>(p, &[0; 8]).iter().flatten().count())
                .sum(),
            Self::Embree(e) => rays.iter().filter(|r| e.closest(r) < f32::INFINITY).count(),
            Self::Stock(bvh, tris) => rays
                .iter()
                .filter(|r| stock_closest(bvh, tris, r) < f32::INFINITY)
                .count(),
        }
    }

    fn occluded(&self, rays: &[Ray]) -> usize {
        match self {
            Self::Single(g) => rays
                .iter()
                .filter(|r| g.transmittance_depth::<NOTHING>(r).is_blocked())
                .count(),
            Self::Packets(g) => packets(rays)
                .map(|p| {
                    g.transmittance_depth8::<NOTHING>(p)
                        .iter()
                        .filter(|o| o.is_blocked())
                        .count()
                })
                .sum(),
            Self::Embree(e) => rays.iter().filter(|r| e.is_occluded(r)).count(),
            Self::Stock(bvh, tris) => rays
                .iter()
                .filter(|r| !bvh.ray_traverse_miss(stock_ray(r), |ray, id| tris[id].intersect(ray)))
                .count(),
        }
    }
}

fn packets(rays: &[Ray]) -> impl Iterator<Item = &[Ray; 8]> {
    rays.as_chunks::<8>().0.iter()
}

fn stock_ray(r: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(r.o.into(), r.d.into(), 0.0, r.t_max)
}

fn stock_closest(bvh: &CwBvh, tris: &[RtTriangle], r: &Ray) -> f32 {
    let mut hit = RayHit::none();
    bvh.ray_traverse(stock_ray(r), &mut hit, |ray, id| tris[id].intersect(ray));
    hit.t
}

fn own(scene: &Scene) -> Geometry {
    let built = TriMesh::build(&scene.positions, &scene.triangles).and_then(|mesh| {
        Geometry::build(
            vec![mesh],
            vec![Instance::new(0, Affine3A::IDENTITY)?],
            None,
            None,
        )
    });
    match built {
        Ok(geometry) => geometry,
        Err(error) => panic!("{}: {error}", scene.name),
    }
}

fn stock(scene: &Scene, params: BvhBuildParams) -> Tracer {
    let corner = |i: u32| Vec3A::from(scene.positions[i as usize]);
    let tris: Vec<_> = scene
        .triangles
        .iter()
        .map(|t| Triangle {
            v0: corner(t[0]),
            v1: corner(t[1]),
            v2: corner(t[2]),
        })
        .collect();
    let bvh = build_cwbvh_from_tris(&tris, params, &mut Duration::default());
    let permuted = bvh
        .primitive_indices
        .iter()
        .map(|&i| RtTriangle::from(&tris[i as usize]))
        .collect();
    Tracer::Stock(Box::new(bvh), permuted)
}

fn timed<T>(name: &str, build: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let built = build();
    println!(
        "  build {name}: {:.0} ms",
        started.elapsed().as_secs_f64() * 1e3
    );
    built
}

fn tracers(scene: &Scene) -> Vec<(&'static str, Tracer)> {
    let mut all = vec![
        ("own, single", Tracer::Single(timed("own", || own(scene)))),
        ("own, packets of 8", Tracer::Packets(own(scene))),
    ];
    if std::env::var_os("QUICK").is_some() {
        return all;
    }
    all.push((
        "own, without AVX2",
        Tracer::Single(own(scene).without_avx2()),
    ));
    for (name, robust) in [("Embree robust", true), ("Embree high", false)] {
        match timed(name, || Embree::build(scene, robust)) {
            Some(e) => all.push((name, Tracer::Embree(Box::new(e)))),
            None => println!("  {name}: libembree3 not found, left out"),
        }
    }
    all.push((
        "CwBvh medium",
        timed("CwBvh medium", || {
            stock(scene, BvhBuildParams::medium_build())
        }),
    ));
    all.push((
        "CwBvh slow",
        timed("CwBvh slow", || stock(scene, BvhBuildParams::slow_build())),
    ));
    all
}

/// Hit or miss and distance, ours beside Embree's robust mode.
fn compare(own: &Geometry, embree: &Embree, rays: &Rays) {
    for (kind, rays) in [("primary", &rays.primary), ("diffuse", &rays.diffuse)] {
        let (mut missed, mut extra, mut off) = (0, 0, 0);
        for ray in rays {
            let theirs = embree.closest(ray);
            let ours = own
                .intersect::<NOTHING>(ray, 0)
                .map_or(f32::INFINITY, |h| h.t);
            missed += usize::from(ours > theirs && ours == f32::INFINITY);
            extra += usize::from(ours < theirs && theirs == f32::INFINITY);
            let both = ours < f32::INFINITY && theirs < f32::INFINITY;
            off += usize::from(both && (ours - theirs).abs() > 1e-4 * (1.0 + theirs));
        }
        println!(
            "  {kind}: hit only by Embree {missed}, only by us {extra}, distance differs {off} (of {COUNT})"
        );
    }
    let differ =
        |r: &&Ray| embree.is_occluded(r) != own.transmittance_depth::<NOTHING>(r).is_blocked();
    println!(
        "  shadow: {} differ",
        rays.shadow.iter().filter(differ).count()
    );
}

/// Mrays/s of every tracer and kind, the median of the rounds.
fn measure(tracers: &[(&'static str, Tracer)], rays: &Rays, rounds: usize) -> Vec<[f64; 3]> {
    let mut times = vec![[const { Vec::new() }; 3]; tracers.len()];
    for round in 0..=rounds {
        for kind in 0..3 {
            for (times, (_, tracer)) in times.iter_mut().zip(tracers) {
                let started = Instant::now();
                black_box(match kind {
                    0 => tracer.closest(&rays.primary),
                    1 => tracer.closest(&rays.diffuse),
                    _ => tracer.occluded(&rays.shadow),
                });
                // The first round warms up.
                if round > 0 {
                    times[kind].push(started.elapsed().as_secs_f64());
                }
            }
        }
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        COUNT as f64 / times[times.len() / 2] / 1e6
    };
    times
        .iter_mut()
        .map(|kinds| [0, 1, 2].map(|k| median(&mut kinds[k])))
        .collect()
}

fn report(tracers: &[(&'static str, Tracer)], rates: &[[f64; 3]]) {
    println!(
        "  {:20}{:>10}{:>10}{:>10}   own/this",
        "Mrays/s", "primary", "diffuse", "shadow"
    );
    for ((name, _), rate) in tracers.iter().zip(rates) {
        let ratio: Vec<_> = (0..3)
            .map(|k| format!("{:.2}", rates[0][k] / rate[k]))
            .collect();
        println!(
            "  {name:20}{:10.2}{:10.2}{:10.2}   {}",
            rate[0],
            rate[1],
            rate[2],
            ratio.join(" ")
        );
    }
}

fn main() {
    let rounds = std::env::var("ROUNDS")
        .ok()
        .and_then(|r| r.parse().ok())
        .unwrap_or(5_usize)
        .max(1);
    let wanted = std::env::var("SCENE").ok();
    let mut criterion = Criterion::default().sample_size(10).configure_from_args();
    for scene in scenes::all()
        .iter()
        .filter(|s| wanted.as_deref().is_none_or(|w| w == s.name))
    {
        println!("\n{}: {} triangles", scene.name, scene.triangles.len());
        let tracers = tracers(scene);
        let Tracer::Single(geometry) = &tracers[0].1 else {
            return;
        };
        let rays = rays::shoot(scene, geometry);
        println!("  {:.0} % of the camera rays hit", rays.covered * 100.0);
        for (name, tracer) in &tracers {
            if let (&"Embree robust", Tracer::Embree(embree)) = (name, tracer) {
                compare(geometry, embree, &rays);
            }
        }
        report(&tracers, &measure(&tracers, &rays, rounds));
        if std::env::var_os("QUICK").is_none() {
            let mut group = criterion.benchmark_group(scene.name);
            group.throughput(Throughput::Elements(COUNT as u64));
            group.bench_function("primary", |b| {
                b.iter(|| tracers[1].1.closest(&rays.primary));
            });
            group.bench_function("diffuse", |b| {
                b.iter(|| tracers[0].1.closest(&rays.diffuse));
            });
            group.bench_function("shadow", |b| {
                b.iter(|| tracers[1].1.occluded(&rays.shadow));
            });
            group.finish();
        }
    }
    criterion.final_summary();
}
