//! Bounds hold wherever a ray looks, and a walk misses nothing.

use crate::common::{lumpy, rays, unit};
use glam::{UVec3, Vec3};
use shearwater_tracer::medium::{Bounds, DensityGrid, Walk};

/// Voxels along a cell.
const CELL: u32 = 8;

// A few roundings of the interpolation.
fn within(bounds: Bounds, density: f32) -> bool {
    let slack = 1e-6 * bounds.max;
    density >= bounds.min - slack && density <= bounds.max + slack
}

fn random_grid(seed: u64) -> DensityGrid {
    let side = |k| 1 + (unit(seed * 31 + k) * 27.0) as u32;
    let size = UVec3::new(side(1), side(2), side(3));
    let values = (0..u64::from(size.element_product()))
        .map(|i| (unit(seed * 1_000_003 + i) - 0.5).max(0.0) * 3.0)
        .collect();
    DensityGrid::new(size, values).expect("densities")
}

#[test]
fn no_lookup_in_a_cell_leaves_its_bounds() {
    for seed in 0..40 {
        let grid = random_grid(seed);
        let size = grid.size().as_vec3();
        for i in 0..4000_u64 {
            let k = seed * 100_000 + i * 3;
            let mut p = Vec3::new(unit(k), unit(k + 1), unit(k + 2)) * size;
            // Every other point on a wall between cells, or a rounding beside it.
            if i % 2 == 0 {
                let wall = (p.x / CELL as f32) as u32 * CELL;
                p.x = [
                    wall as f32,
                    (wall as f32).next_up(),
                    (wall as f32).next_down(),
                ][(i / 2 % 3) as usize];
            }
            let cell = (p / CELL as f32).as_uvec3().min(grid.cells() - UVec3::ONE);
            let density = grid.density(p);
            assert!(within(grid.bounds(cell), density), "{seed} {p}: {density}");
        }
    }
}

#[test]
fn densities_are_trilinear_between_voxel_centres() {
    let grid = random_grid(3);
    let at = |x: u32, y: u32, z: u32| grid.density(Vec3::new(x as f32, y as f32, z as f32) + 0.5);
    let p = Vec3::new(2.75, 1.9, 3.25);
    let f = p - 0.5 - Vec3::new(2.0, 1.0, 2.0);
    let mut expected = 0.0;
    for corner in 0..8_u32 {
        let (x, y, z) = (corner & 1, corner >> 1 & 1, corner >> 2);
        let weight = |bit: u32, f: f32| if bit == 1 { f } else { 1.0 - f };
        expected += at(2 + x, 1 + y, 2 + z) * weight(x, f.x) * weight(y, f.y) * weight(z, f.z);
    }
    assert!((grid.density(p) - expected).abs() < 1e-6);
}

#[test]
fn the_pieces_of_a_walk_cover_the_span_and_bound_it() {
    let volume = lumpy(1.0, 5);
    for ray in rays(300) {
        let Some(span) = volume.span(&ray, f32::INFINITY) else {
            continue;
        };
        let (mut t, mut count) = (span.t0, 0);
        for piece in Walk::new(&volume.density, &span) {
            assert!(piece.end >= t && piece.end <= span.t1);
            for i in 0..20 {
                let inside = t + (piece.end - t) * (i as f32 + 0.5) / 20.0;
                let density = volume.density.density(span.at(inside));
                assert!(
                    within(piece.bounds, density),
                    "{ray:?} at {inside}: {density}"
                );
            }
            t = piece.end;
            count += 1;
        }
        assert_eq!(t, span.t1, "{ray:?}");
        assert!(count <= 3 * 3, "{count}");
    }
}

#[test]
fn grids_that_are_none_are_refused() {
    let one = UVec3::ONE;
    assert!(DensityGrid::new(one, vec![]).is_none());
    assert!(DensityGrid::new(UVec3::new(0, 1, 1), vec![]).is_none());
    assert!(DensityGrid::new(one, vec![f32::NAN]).is_none());
    assert!(DensityGrid::new(one, vec![-1.0]).is_none());
    assert!(DensityGrid::new(UVec3::splat(u32::MAX), vec![1.0]).is_none());
    assert!(DensityGrid::new(one, vec![0.0]).is_some());
}
