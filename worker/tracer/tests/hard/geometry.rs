//! Rays that are aimed where traversals go wrong.

use crate::self_hits::self_hits;
use crate::shapes::{Mesh, Random, alone, ball, octahedron, soup};
use crate::table::{Case, Form, Row, Section};
use glam::{Affine3A, DVec3, Vec3};
use shearwater_tracer::geometry::{
    Ellipsoid, Geometry, HitKind, Instance, Particles, Ray, TriMesh,
};
use shearwater_tracer::uses::{NOTHING, PARTICLES};

static SECTION: Section = Section::new(
    "Geometry",
    &[
        Case {
            name: "rays that leak out of a closed body",
            note: "Aimed from inside exactly at shared corners and at points of shared edges, at the origin, at 1 km and at \
                   100 km from it (unit body). Moller and Trumbore's test loses 4 to 23 %.",
            broken_by: "the slabs of a box without their slack; an edge test of > 0 for >= 0",
            rows: leaks,
        },
        Case {
            name: "triangles of any size",
            note: "Rays at random inner points of triangles whose edges are this long: those that miss, and the hits' \
                   largest distance from the plane over the edge.",
            broken_by: "determinants below 1e-8 taken for parallel",
            rows: sizes,
        },
        Case {
            name: "hits of the surface that was left",
            note: "Octahedra of this size, as far from the origin as said (in sizes); 1.7 million rays each, a third of which graze; a \
                   tenth in the fast form.",
            broken_by: "the origin moved by 1e-4 m whatever the error",
            rows: leaving,
        },
        Case {
            name: "shadow of a plane 1 mm above another",
            note: "Both 2 km wide; level at the origin and at 1 km, and sloping by 0.3. Share of shadows lost; the slope's \
                   rounding at 1 km is 0.1 mm.",
            broken_by: "the origin moved by 256 ulp (Waechter and Binder's constants)",
            rows: contact,
        },
        Case {
            name: "a ball of 1 m far away",
            note: "Rays at the inner half of its disc. Misses, and the largest error of the hit's distance from the centre in ulp of \
                   the ray's length.",
            broken_by: "the discriminant as b^2 - 4 a c",
            rows: far_balls,
        },
        Case {
            name: "coincident faces",
            note: "Three equal bodies at one place, each ray on all three: hits that do not name the first. For single rays, packets, \
                   with AVX2 and without.",
            broken_by: "the higher of two ranks preferred",
            rows: coincident,
        },
        Case {
            name: "100,000 triangles with one centroid",
            note: "The tree ends, is walked, and the first wins.",
            broken_by: "the higher of two ranks preferred",
            rows: one_centroid,
        },
        Case {
            name: "broken faces among good ones",
            note: "Corners that are not finite, faces without area, twice the same corner: rays of 20,000 whose hit is not bit for bit \
                   that of the mesh without them.",
            broken_by: "faces with NaN kept in the tree's boxes",
            rows: broken,
        },
    ],
);

#[test]
fn geometry() {
    SECTION.check();
}

fn missed(scene: &Geometry, rays: impl Iterator<Item = Ray>) -> f64 {
    let missed = rays.filter(|ray| scene.intersect::<NOTHING>(ray, 0).is_none());
    missed.count() as f64
}

fn leaks(form: Form) -> Vec<Row> {
    let count = form.pick(100_000, 1_000_000);
    let mut rows = Vec::new();
    for offset in [0.0, 1e3, 1e5_f32] {
        let centre = Vec3::new(offset, -offset, offset);
        let body = ball(64, centre, 1.0);
        let scene = alone(&body);
        let mut r = Random(7);
        let corners = (0..count).map(|_| {
            let from = centre + r.cube() * 0.4;
            let to = body.0[r.below(body.0.len())];
            Ray::new(from, (to - from).normalize())
        });
        let at_corners = missed(&scene, corners);
        let mut r = Random(8);
        let edges = (0..count).map(|_| {
            let from = centre + r.cube() * 0.4;
            let t = body.1[r.below(body.1.len())];
            let side = r.below(3);
            let (a, b) = (body.0[t[side] as usize], body.0[t[(side + 1) % 3] as usize]);
            Ray::new(from, (a + (b - a) * r.unit() - from).normalize())
        });
        let at_edges = missed(&scene, edges);
        rows.push(Row::exact(
            format!("corners, at {offset} m"),
            0.0,
            at_corners,
        ));
        rows.push(Row::exact(format!("edges, at {offset} m"), 0.0, at_edges));
    }
    rows
}

fn sizes(form: Form) -> Vec<Row> {
    let count = form.pick(2_000, 100_000);
    let mut rows = Vec::new();
    for size in [1e-6, 1e-4, 1.0, 1e3, 1e6_f32] {
        let mut r = Random(4);
        let (mut missed, mut worst) = (0.0, 0.0_f64);
        for _ in 0..count / 20 {
            let corners = [r.cube() * size, r.cube() * size, r.cube() * size];
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let n = (b - a).cross(c - a);
            // Slivers lose digits of their own.
            if n.length() < 0.05 * f64::from(size) * f64::from(size) {
                continue;
            }
            let n = n.normalize();
            let scene = alone(&(corners.to_vec(), vec![[0, 1, 2]]));
            for _ in 0..20 {
                let (u, v) = (0.02 + 0.45 * r.unit(), 0.02 + 0.45 * r.unit());
                let p = a + (b - a) * f64::from(u) + (c - a) * f64::from(v);
                let from = (p + r.direction().as_dvec3() * f64::from(size) + n * f64::from(size))
                    .as_vec3();
                let d = (p.as_vec3() - from).normalize();
                let Some(hit) = scene.intersect::<NOTHING>(&Ray::new(from, d), 0) else {
                    missed += 1.0;
                    continue;
                };
                let (o, d) = (from.as_dvec3(), d.as_dvec3());
                let t = (a - o).dot(n) / d.dot(n);
                let off = (f64::from(hit.t) - t) * d.dot(n) / f64::from(size);
                worst = worst.max(off.abs());
            }
        }
        rows.push(Row::exact(
            format!("edges of {size:e} m, misses"),
            0.0,
            missed,
        ));
        rows.push(Row::at_most(
            format!("edges of {size:e} m, off the plane"),
            2e-6,
            worst,
        ));
    }
    rows
}

fn leaving(form: Form) -> Vec<Row> {
    let count = form.pick(170_000, 1_700_000);
    let mut rows = Vec::new();
    for size in [1.0, 1e3, 1e6_f32] {
        for offset in [0.0, 1.0, 100.0] {
            let centre = Vec3::new(offset, -offset, 0.3 * offset) * size;
            let (bad, tried) =
                self_hits::<NOTHING>(&alone(&octahedron(centre, size)), centre, size, count);
            assert!(tried * 10 > count * 5, "{tried}");
            rows.push(Row::exact(
                format!("{size} m, at {offset}"),
                0.0,
                bad as f64,
            ));
        }
    }
    rows
}

fn contact(form: Form) -> Vec<Row> {
    let count = form.pick(20_000, 200_000);
    let case = |(at, tilt): (f32, f32)| {
        let corner = |x: f32, z: f32, y: f32| Vec3::new(x, y + at + tilt * x, z + at);
        let mut mesh: Mesh = (vec![], vec![]);
        for y in [0.0, 1e-3] {
            let v = mesh.0.len() as u32;
            let square = [(-1e3, -1e3), (1e3, -1e3), (1e3, 1e3), (-1e3, 1e3)];
            mesh.0.extend(square.map(|(x, z)| corner(x, z, y)));
            mesh.1.extend([[v, v + 1, v + 2], [v, v + 2, v + 3]]);
        }
        let (below, both) = (alone(&(mesh.0.clone(), mesh.1[..2].to_vec())), alone(&mesh));
        let mut r = Random(3);
        let mut lost = 0;
        for _ in 0..count {
            let to = corner(1800.0 * r.unit() - 900.0, 1800.0 * r.unit() - 900.0, 0.0);
            let from = to + Vec3::new(r.unit() - 0.5, 1.0, r.unit() - 0.5) * 100.0;
            let ray = Ray::new(from, (to - from).normalize());
            let hit = below
                .intersect::<NOTHING>(&ray, 0)
                .expect("the lower plane");
            let w = Vec3::new(r.unit() - 0.5, 1.0, r.unit() - 0.5).normalize();
            let o = below.surface_point(&ray, &hit).origin_towards(w);
            let shadow = both.transmittance_depth::<NOTHING>(&Ray::new(o, w));
            lost += usize::from(!shadow.is_blocked());
        }
        let share = lost as f64 / count as f64;
        Row::at_most(format!("at {at} m, slope {tilt}"), 1e-3, share)
    };
    [(0.0, 0.0), (1e3, 0.0), (0.0, 0.3)].map(case).to_vec()
}

fn far_balls(form: Form) -> Vec<Row> {
    let count = form.pick(20_000, 400_000);
    let mut rows = Vec::new();
    for distance in [1e2_f32, 1e3, 1e4, 1e5] {
        let ball = Ellipsoid {
            centre: Vec3::new(0.0, 0.0, distance),
            radii: Vec3::ONE,
            opacity: 1.0,
        };
        let particles = Particles::build(&[ball]).expect("a ball");
        let scene = Geometry::build(vec![], vec![], Some(particles.into()), None).expect("a scene");
        let mut r = Random(2);
        let (mut missed, mut worst) = (0, 0.0_f64);
        for _ in 0..count {
            let p = Vec3::new(r.unit() - 0.5, r.unit() - 0.5, distance);
            let ray = Ray::new(Vec3::ZERO, p.normalize());
            match scene.intersect::<PARTICLES>(&ray, 0) {
                None => missed += 1,
                Some(hit) => {
                    let p = ray.d.as_dvec3() * f64::from(hit.t);
                    let radius = p.distance(DVec3::Z * f64::from(distance));
                    worst = worst.max((radius - 1.0).abs());
                }
            }
        }
        let ulp = f64::from(distance.next_up() - distance);
        rows.push(Row::exact(
            format!("{distance} m, misses"),
            0.0,
            f64::from(missed),
        ));
        rows.push(Row::at_most(format!("{distance} m, ulp"), 2.0, worst / ulp));
    }
    rows
}

fn coincident(form: Form) -> Vec<Row> {
    let (positions, triangles) = ball(6, Vec3::ZERO, 1.0);
    let mesh = || TriMesh::build(&positions, &triangles).expect("a mesh");
    let place = |mesh| Instance::new(mesh, Affine3A::IDENTITY).expect("a place");
    let build = || {
        let meshes = vec![mesh(), mesh(), mesh()];
        Geometry::build(meshes, vec![place(2), place(0), place(1)], None, None).expect("a scene")
    };
    let (wide, portable) = (build(), build().without_avx2());
    let mut r = Random(9);
    let (mut others, mut hits) = (0_u32, 0);
    for _ in 0..form.pick(2_000, 20_000) {
        let rays: [Ray; 8] = std::array::from_fn(|_| Ray::new(r.cube() * 0.3, r.direction()));
        let packet = wide.intersect8::<NOTHING>(&rays, &[0; 8]);
        for (ray, packed) in rays.iter().zip(packet) {
            let single = wide.intersect::<NOTHING>(ray, 0);
            for hit in [single, packed, portable.intersect::<NOTHING>(ray, 0)] {
                let named = hit.map(|hit| hit.kind);
                hits += u32::from(named.is_some());
                let first = matches!(named, None | Some(HitKind::Triangle { instance: 0, .. }));
                others += u32::from(!first || hit != single);
            }
        }
    }
    assert!(hits > 5_000, "{hits}");
    vec![Row::exact("", 0.0, f64::from(others))]
}

fn one_centroid(_: Form) -> Vec<Row> {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let scene = alone(&(corners, vec![[0, 1, 2]; 100_000]));
    let ray = Ray::new(Vec3::new(0.2, 0.2, -1.0), Vec3::Z);
    let first = match scene.intersect::<NOTHING>(&ray, 0).map(|hit| hit.kind) {
        Some(HitKind::Triangle { prim, .. }) => f64::from(prim),
        _ => f64::NAN,
    };
    vec![Row::exact("number of the one hit", 0.0, first)]
}

fn broken(_: Form) -> Vec<Row> {
    let clean = soup(300, 3);
    let mut dirty = clean.clone();
    let at = dirty.0.len() as u32;
    dirty.0.extend([
        Vec3::NAN,
        Vec3::new(0.0, f32::INFINITY, 0.0),
        Vec3::splat(0.1),
        Vec3::splat(0.2),
    ]);
    let faces = [
        [at, at + 2, at + 3],
        [at + 1, at + 2, at + 3],
        [at, at, at],
        [at + 2, at + 2, at + 2],
        [at + 2, at + 3, at + 2],
    ];
    dirty.1.extend(faces);
    let (clean, dirty) = (alone(&clean), alone(&dirty));
    let mut r = Random(5);
    let other = (0..20_000).filter(|_| {
        let ray = Ray::new(r.cube() * 2.0, r.direction());
        clean.intersect::<NOTHING>(&ray, 0) != dirty.intersect::<NOTHING>(&ray, 0)
    });
    vec![Row::exact("", 0.0, other.count() as f64)]
}
