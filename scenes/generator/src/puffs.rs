//! A cumulus as a grid of densities: a heap of puffs on a flat base, frayed by
//! noise, in the `.vol` format.

use crate::noise::{fbm, hash3, unit};

/// Voxels along x, y, z.
const SIZE: [usize; 3] = [88, 40, 56];
/// Edges of a voxel, in units of the grid's height.
const VOXEL: f64 = 1.0 / 40.0;
const PUFFS: i32 = 70;
/// Height of the flat base.
const BASE: f64 = 0.12;
/// How thick the rim of a puff is, as a share of its radius, and how far noise frays
/// it.
const RIM: f64 = 0.3;
const FRAY: f64 = 1.1;

struct Puff {
    centre: [f64; 3],
    radius: f64,
}

/// The file: header, then densities of 0 to 1 with x fastest.
#[must_use]
pub fn vol() -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    let sides = SIZE.map(|n| n as i32);
    for v in [1, sides[0], sides[1], sides[2], 1] {
        bytes.extend(v.to_le_bytes());
    }
    let extent = SIZE.map(|n| (n as f64 * VOXEL) as f32);
    for v in [0.0, 0.0, 0.0, extent[0], extent[1], extent[2]] {
        bytes.extend(v.to_le_bytes());
    }
    let puffs = puffs();
    for z in 0..SIZE[2] {
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let rim = [x, y, z]
                    .iter()
                    .zip(SIZE)
                    .any(|(&i, n)| i == 0 || i + 1 == n);
                let p = [x, y, z].map(|i| (i as f64 + 0.5) * VOXEL);
                let density = if rim { 0.0 } else { density(&puffs, p) };
                bytes.extend((density as f32).to_le_bytes());
            }
        }
    }
    bytes
}

// The higher, the smaller and the nearer to the middle.
fn puffs() -> Vec<Puff> {
    let middle = [0, 2].map(|axis| SIZE[axis] as f64 * VOXEL * 0.5);
    let draw = |puff: i32, what: i32| unit(hash3(puff, what, 0, 11));
    (0..PUFFS)
        .map(|i| {
            let height = draw(i, 0) * draw(i, 1);
            let spread = 1.0 - 0.75 * height;
            let across = |what, reach: f64| (2.0 * draw(i, what) - 1.0) * reach * spread;
            let radius = (0.1 + 0.12 * draw(i, 4)) * (1.0 - 0.4 * height);
            Puff {
                centre: [
                    middle[0] + across(2, middle[0] - 0.25),
                    BASE + 0.04 + height * 0.62,
                    middle[1] + across(3, middle[1] - 0.25),
                ],
                radius,
            }
        })
        .collect()
}

fn density(puffs: &[Puff], p: [f64; 3]) -> f64 {
    let inside = puffs
        .iter()
        .map(|puff| {
            let d2: f64 = p
                .iter()
                .zip(puff.centre)
                .map(|(a, b)| (a - b) * (a - b))
                .sum();
            (1.0 - d2.sqrt() / puff.radius) / RIM
        })
        .fold(f64::NEG_INFINITY, f64::max);
    let above_base = (p[1] - BASE) / (3.0 * VOXEL);
    let frayed = inside.min(above_base) + FRAY * fbm(p[0] * 9.0, p[1] * 9.0, p[2] * 9.0, 4, 0.5, 5);
    frayed.clamp(0.0, 1.0)
}
