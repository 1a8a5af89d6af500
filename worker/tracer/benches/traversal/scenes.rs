//! What the rays are shot at: the golden-gate meshes if they are there, meshes of
//! their kind if not, and a terrain of a million triangles.

use std::path::Path;

use glam::Vec3;

/// A mesh and a camera that sees it.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) eye: Vec3,
    pub(crate) target: Vec3,
    /// Half the width of the picture at distance one.
    pub(crate) half_width: f32,
}

pub(crate) fn all() -> Vec<Scene> {
    let (positions, triangles) = load("bridge.obj").unwrap_or_else(bridge);
    let bridge = framed(
        "bridge",
        positions,
        triangles,
        Vec3::new(0.12, 0.03, 0.09),
        0.9,
    );
    let (positions, triangles) = load("plane.obj").unwrap_or_else(plane);
    let plane = framed(
        "plane",
        positions,
        triangles,
        Vec3::new(0.4, 0.25, 0.45),
        0.7,
    );
    let (positions, triangles) = terrain();
    let terrain = framed(
        "terrain",
        positions,
        triangles,
        Vec3::new(0.1, 0.25, 0.55),
        1.0,
    );
    vec![bridge, plane, terrain]
}

/// The eye at the centre plus `from` times the largest extent.
fn framed(
    name: &'static str,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    from: Vec3,
    half_width: f32,
) -> Scene {
    let lo = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let hi = positions
        .iter()
        .copied()
        .fold(Vec3::NEG_INFINITY, Vec3::max);
    let target = (lo + hi) * 0.5;
    let eye = target + from * (hi - lo).max_element();
    Scene {
        name,
        positions,
        triangles,
        eye,
        target,
        half_width,
    }
}

type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

fn load(file: &str) -> Option<Mesh> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../scenes/golden-gate/assets")
        .join(file);
    let options = tobj::LoadOptions {
        triangulate: true,
        ..Default::default()
    };
    let (models, _) = tobj::load_obj(&path, &options).ok()?;
    let mut mesh: Mesh = Default::default();
    for model in models {
        let first = mesh.0.len() as u32;
        mesh.0
            .extend(model.mesh.positions.chunks_exact(3).map(Vec3::from_slice));
        mesh.1.extend(
            model
                .mesh
                .indices
                .chunks_exact(3)
                .map(|t| [first + t[0], first + t[1], first + t[2]]),
        );
    }
    println!("{file}: {} triangles", mesh.1.len());
    Some(mesh)
}

/// A box along the line from `a` to `b`, `thickness` wide.
fn beam(mesh: &mut Mesh, a: Vec3, b: Vec3, thickness: f32) {
    let along = (b - a).normalize_or(Vec3::X);
    let (side, up) = along.any_orthonormal_pair();
    let v = mesh.0.len() as u32;
    for end in [a, b] {
        for (s, u) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            mesh.0.push(end + (side * s + up * u) * thickness);
        }
    }
    for i in 0..4 {
        let j = (i + 1) % 4;
        mesh.1
            .extend([[v + i, v + j, v + 4 + j], [v + i, v + 4 + j, v + 4 + i]]);
    }
    mesh.1.extend([
        [v, v + 2, v + 1],
        [v, v + 3, v + 2],
        [v + 4, v + 5, v + 6],
        [v + 4, v + 6, v + 7],
    ]);
}

/// A suspension bridge of 138 thousand triangles: truss, cables, hangers, long stays.
fn bridge() -> Mesh {
    let mut mesh = Mesh::default();
    let bays = 680;
    let x_of = |i: i32| (i as f32 / bays as f32 - 0.5) * 1280.0;
    let cable = |x: f32| 12.0 + 140.0 * (x / 640.0) * (x / 640.0);
    for i in 0..bays {
        let (x0, x1) = (x_of(i), x_of(i + 1));
        for z in [-13.5, 13.5] {
            let p = |x: f32, y: f32| Vec3::new(x, y, z);
            beam(&mut mesh, p(x0, 0.0), p(x1, 0.0), 0.8);
            beam(&mut mesh, p(x0, -7.6), p(x1, -7.6), 0.8);
            beam(&mut mesh, p(x0, 0.0), p(x0, -7.6), 0.3);
            beam(&mut mesh, p(x0, 0.0), p(x1, -7.6), 0.3);
            beam(&mut mesh, p(x0, cable(x0)), p(x1, cable(x1)), 0.9);
            beam(&mut mesh, p(x0, 0.0), p(x0, cable(x0)), 0.1);
        }
        let across = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        beam(
            &mut mesh,
            across(x0, 0.2, -13.5),
            across(x0, 0.2, 13.5),
            0.4,
        );
        beam(
            &mut mesh,
            across(x0, -7.6, -13.5),
            across(x1, -7.6, 13.5),
            0.3,
        );
        beam(
            &mut mesh,
            across(x0, -7.6, 13.5),
            across(x1, -7.6, -13.5),
            0.3,
        );
        if i % 6 == 0 {
            let tower = if x0 < 0.0 { -640.0 } else { 640.0 };
            for z in [-13.5, 13.5] {
                beam(&mut mesh, across(tower, 150.0, z), across(x0, 0.0, z), 0.15);
            }
        }
    }
    for x in [-640.0, 640.0] {
        for z in [-13.5, 13.5] {
            beam(
                &mut mesh,
                Vec3::new(x, -70.0, z),
                Vec3::new(x, 155.0, z),
                8.0,
            );
        }
        for y in [10.0, 50.0, 90.0, 130.0] {
            beam(
                &mut mesh,
                Vec3::new(x, y, -13.5),
                Vec3::new(x, y, 13.5),
                6.0,
            );
        }
    }
    mesh
}

/// A closed tube along `axis` whose radii follow `radius(s)` for s from 0 to 1.
fn loft(mesh: &mut Mesh, rings: u32, sides: u32, point: impl Fn(f32, f32) -> Vec3) {
    let first = mesh.0.len() as u32;
    for i in 0..=rings {
        for j in 0..sides {
            mesh.0
                .push(point(i as f32 / rings as f32, j as f32 / sides as f32));
        }
    }
    for i in 0..rings {
        for j in 0..sides {
            let at = |i: u32, j: u32| first + i * sides + j % sides;
            mesh.1.extend([
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ]);
        }
    }
}

/// A body, wings, a tail and engines of 58 thousand triangles.
fn plane() -> Mesh {
    let mut mesh = Mesh::default();
    let circle = |a: f32| {
        (
            libm::cosf(a * std::f32::consts::TAU),
            libm::sinf(a * std::f32::consts::TAU),
        )
    };
    let thickness = |s: f32| (4.0 * s * (1.0 - s)).max(0.0).sqrt();
    loft(&mut mesh, 120, 80, |s, a| {
        let (c, n) = circle(a);
        Vec3::new(
            14.0 * s - 5.0,
            c * 0.9 * thickness(s),
            n * 0.8 * thickness(s),
        )
    });
    for (x, y, span, chord) in [(0.0, 0.2, 10.0, 2.4), (7.5, 0.5, 3.5, 1.2)] {
        loft(&mut mesh, 160, 40, |s, a| {
            let (c, n) = circle(a);
            let z = (2.0 * s - 1.0) * span;
            let taper = 1.0 - 0.6 * (2.0 * s - 1.0).abs();
            Vec3::new(
                x + 0.5 * chord * taper * c,
                y + 0.08 * chord * taper * n + 0.05 * z.abs(),
                z,
            )
        });
    }
    for z in [-3.0, 3.0] {
        loft(&mut mesh, 60, 64, |s, a| {
            let (c, n) = circle(a);
            Vec3::new(
                3.5 * s - 2.5,
                0.3 + 0.5 * c * thickness(s),
                z + 0.5 * n * thickness(s),
            )
        });
    }
    mesh
}

/// Hills of 512 by 1024 squares.
fn terrain() -> Mesh {
    let (nx, nz) = (512_u32, 1024_u32);
    let mut mesh = Mesh::default();
    for i in 0..=nx {
        for j in 0..=nz {
            let (x, z) = (i as f32 * 2.0, j as f32);
            let mut y = 0.0;
            let (mut size, mut turn) = (200.0_f32, 0.3_f32);
            for _ in 0..8 {
                let (c, s) = (libm::cosf(turn), libm::sinf(turn));
                y += 0.12
                    * size
                    * libm::sinf((x * c + z * s) / size * 4.0)
                    * libm::cosf((x * s - z * c) / size * 3.0);
                size *= 0.5;
                turn += 1.3;
            }
            mesh.0.push(Vec3::new(x, y, z));
        }
    }
    for i in 0..nx {
        for j in 0..nz {
            let a = i * (nz + 1) + j;
            let b = a + nz + 1;
            mesh.1.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    mesh
}
