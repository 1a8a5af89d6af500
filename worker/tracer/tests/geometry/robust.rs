//! Input that no modeller meant: it neither panics nor hangs nor changes others.

use glam::{Affine3A, Mat3A, Vec3};
use shearwater_tracer::geometry::{BuildError, Geometry, Instance, Ray, TriMesh};
use shearwater_tracer::uses::{NOTHING, PARTICLES};

use super::exact::crowd;
use super::shapes::{Random, alone, soup};

#[test]
fn empty_and_tiny_meshes() {
    let ray = Ray::new(Vec3::new(0.2, 0.2, -1.0), Vec3::Z);
    assert!(
        alone(&(vec![], vec![]))
            .intersect::<NOTHING>(&ray, 0)
            .is_none()
    );
    let nothing = Geometry::build(vec![], vec![], None, None).unwrap();
    assert!(nothing.intersect::<PARTICLES>(&ray, 0).is_none());
    let one = alone(&(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]));
    assert_eq!(one.intersect::<NOTHING>(&ray, 0).unwrap().t, 1.0);
    // Edges from a micrometre to a thousand kilometres, hit all the same.
    for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let s = |v: Vec3| v * scale;
        let mesh = (vec![s(Vec3::ZERO), s(Vec3::X), s(Vec3::Y)], vec![[0, 1, 2]]);
        let ray = Ray::new(s(ray.o), ray.d);
        assert!((alone(&mesh).intersect::<NOTHING>(&ray, 0).unwrap().t / scale - 1.0).abs() < 1e-6);
    }
}

#[test]
fn huge_and_widely_spread_coordinates() {
    let mut mesh = soup(200, 8);
    let mut r = Random(2);
    for (i, p) in mesh.0.iter_mut().enumerate() {
        *p *= [1e-20, 1.0, 1e10, 1e20, 1e30, 3e38][i / 3 % 6];
    }
    let scene = alone(&mesh);
    for _ in 0..2000 {
        let ray = Ray::new(r.cube(), r.direction());
        let _ = scene.intersect::<NOTHING>(&ray, 0);
        let _ = scene.transmittance_depth::<NOTHING>(&ray);
    }
    // Each triangle ten times the size of the one before: a lopsided tree.
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut size = 1e-18_f32;
    for i in 0..2000_u32 {
        positions.extend([Vec3::ZERO, Vec3::X, Vec3::Y].map(|v| (v + 0.1) * size));
        triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        size *= 1.04;
    }
    let scene = alone(&(positions, triangles));
    assert!(
        scene
            .intersect::<NOTHING>(&Ray::new(Vec3::new(0.3, 0.3, -1.0), Vec3::Z), 0)
            .is_some()
    );
}

#[test]
fn odd_rays_end() {
    for scene in [crowd(), crowd().without_avx2()] {
        let odd = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            0.0,
            -0.0,
            1e-40,
            1e38,
            -1.0,
        ];
        let mut r = Random(1);
        for _ in 0..20_000 {
            let mut pick = || odd[r.below(odd.len())];
            let ray = Ray {
                o: Vec3::new(pick(), pick(), pick()),
                d: Vec3::new(pick(), pick(), pick()),
                t_max: pick(),
                time_s: 0.0,
            };
            if let Some(hit) = scene.intersect::<PARTICLES>(&ray, 1) {
                assert!(hit.t > 0.0 && hit.t < ray.t_max, "{ray:?} {hit:?}");
            }
            let _ = scene.transmittance_depth::<PARTICLES>(&ray);
        }
    }
}

#[test]
fn wrong_indices_and_transforms_are_refused() {
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let refused = TriMesh::build(&one, &[[0, 1, 2], [0, 1, 3]]).err();
    assert_eq!(
        refused,
        Some(BuildError::VertexIndex {
            triangle: 1,
            vertex: 3,
            vertices: 3
        })
    );
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    assert_eq!(
        Instance::new(0, flat).err(),
        Some(BuildError::SingularTransform { mesh: 0 })
    );
    let mut nan = Affine3A::IDENTITY;
    nan.matrix3 = Mat3A::from_diagonal(Vec3::new(f32::NAN, 1.0, 1.0));
    assert!(Instance::new(0, nan).is_err());
    let lost = Instance::new(7, Affine3A::IDENTITY).unwrap();
    let refused = Geometry::build(vec![], vec![lost], None, None).err();
    assert_eq!(
        refused,
        Some(BuildError::MeshIndex {
            instance: 0,
            mesh: 7,
            meshes: 0
        })
    );
    assert_eq!(
        Geometry::build(vec![], vec![], None, Some(f32::NAN)).err(),
        Some(BuildError::WaterHeight)
    );
}
