//! Directional albedo of a GGX interface, by quadrature and as a grid.

use glam::Vec3;
use rayon::prelude::*;

use super::microfacet::{MIRROR_ALPHA_MAX, reflect, sample_visible_normal, smith_length};

/// Rows, over alpha in [0, 1].
const ALPHA_NODES: usize = 32;
/// Columns, over mu in [0, 1].
const MU_NODES: usize = 64;

/// Lattice points per entry and the lattice's generator: two Fibonacci numbers,
/// which spread the points evenly over the square. The interpolated albedo is
/// then within 1e-3 or so for alpha >= 0.01.
const LATTICE_POINTS: u32 = 377;
const LATTICE_STEP: u32 = 144;

/// Where albedos bend so much that straight lines between nodes are looked at
/// again: the cells up to alpha 0.25 and mu 0.5.
const RAISED_ROWS: usize = 22;
const RAISED_COLUMNS: usize = 45;
/// By how much the line shall lie above the albedo where it is looked at, for the
/// places in between.
const RAISE: f32 = 1.5e-4;
/// The places of a cell that are looked at: row and column from its first node.
const PLACES: [[f32; 2]; 3] = [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]];

/// A position between two rows of a grid; depends on alpha only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AlphaRow {
    index: u16,
    blend: f32,
}

impl AlphaRow {
    /// The place of alpha in [0, 1] (clamped).
    #[inline]
    pub(super) fn new(alpha: f32) -> Self {
        let place = alpha.clamp(0.0, 1.0).sqrt().sqrt() * (ALPHA_NODES - 1) as f32;
        let index = (place as i32 as usize).min(ALPHA_NODES - 2);
        Self {
            index: index as u16,
            blend: place - index as f32,
        }
    }
}

/// The roughness of a row, or between two.
fn alpha_at(row: f32) -> f32 {
    let root = row / (ALPHA_NODES - 1) as f32;
    (root * root) * (root * root)
}

/// The cosine of a column, or between two.
fn mu_at(column: f32) -> f32 {
    let root = column / (MU_NODES - 1) as f32;
    root * root
}

/// N functions of (mu, alpha) in [0, 1]^2, and their cosine-weighted means over
/// the hemisphere. Rows are spaced evenly in alpha^(1/4) and columns in
/// sqrt(mu), because albedos change fastest where both are small.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AlbedoGrid<const N: usize> {
    values: Vec<[f32; N]>,
    averages: Vec<[f32; N]>,
}

impl<const N: usize> AlbedoGrid<N> {
    /// The albedos under N Fresnel laws at once.
    pub(super) fn fill(laws: impl Fn(f32) -> [f32; N] + Sync) -> Self {
        // Rows are independent and come back in their order.
        let rows = (0..ALPHA_NODES).into_par_iter();
        let values: Vec<[f32; N]> = rows.flat_map_iter(|row| fill_row(row, &laws)).collect();
        let values = raised(&values, &laws);
        let averages = values.chunks(MU_NODES).map(average).collect();
        Self { values, averages }
    }

    /// The values at cosine `mu`.
    #[inline]
    pub(super) fn at(&self, row: AlphaRow, mu: f32) -> [f32; N] {
        let place = mu.clamp(0.0, 1.0).sqrt() * (MU_NODES - 1) as f32;
        let column = (place as i32 as usize).min(MU_NODES - 2);
        let blend = place - column as f32;
        let start = usize::from(row.index) * MU_NODES + column;
        // Always there: index <= ALPHA_NODES - 2.
        let Some(near) = self.values.get(start..start + MU_NODES + 2) else {
            return [0.0; N];
        };
        core::array::from_fn(|k| {
            let low = near[0][k] + (near[1][k] - near[0][k]) * blend;
            let high = near[MU_NODES][k] + (near[MU_NODES + 1][k] - near[MU_NODES][k]) * blend;
            low + (high - low) * row.blend
        })
    }

    /// The cosine-weighted means.
    #[inline]
    pub(super) fn average(&self, row: AlphaRow) -> [f32; N] {
        let index = usize::from(row.index);
        let Some(near) = self.averages.get(index..index + 2) else {
            return [0.0; N];
        };
        core::array::from_fn(|k| near[0][k] + (near[1][k] - near[0][k]) * row.blend)
    }
}

fn fill_row<const N: usize>(
    row: usize,
    laws: &impl Fn(f32) -> [f32; N],
) -> impl Iterator<Item = [f32; N]> {
    let alpha = alpha_at(row as f32);
    (0..MU_NODES).map(move |column| directional_albedo(mu_at(column as f32), alpha, laws))
}

/// The values, raised where the straight line between them would lie below the
/// albedo: there the body would get light that the interface has reflected
/// already, and make more than arrives. Looked at in the middle of cells and of
/// two of their sides, where the line is farthest off; each node rises as far as
/// the worst place beside it needs.
fn raised<const N: usize>(
    values: &[[f32; N]],
    laws: &(impl Fn(f32) -> [f32; N] + Sync),
) -> Vec<[f32; N]> {
    let lacking: Vec<[[f32; N]; 3]> = (0..RAISED_ROWS * RAISED_COLUMNS)
        .into_par_iter()
        .map(|cell| {
            let (row, column) = (cell / RAISED_COLUMNS, cell % RAISED_COLUMNS);
            PLACES.map(|[y, x]| lack(values, laws, row as f32 + y, column as f32 + x))
        })
        .collect();
    let mut raised = values.to_vec();
    for (cell, places) in lacking.iter().enumerate() {
        let (row, column) = (cell / RAISED_COLUMNS, cell % RAISED_COLUMNS);
        for (&[y, x], lack) in PLACES.iter().zip(places) {
            for below in 0..=usize::from(y > 0.0) {
                for right in 0..=usize::from(x > 0.0) {
                    let node = (row + below) * MU_NODES + column + right;
                    for k in 0..N {
                        let wanted = (values[node][k] + lack[k]).min(1.0);
                        raised[node][k] = raised[node][k].max(wanted);
                    }
                }
            }
        }
    }
    raised
}

/// How far the interpolated values must rise at a place of the grid, at least 0.
fn lack<const N: usize>(
    values: &[[f32; N]],
    laws: &impl Fn(f32) -> [f32; N],
    row: f32,
    column: f32,
) -> [f32; N] {
    let exact = directional_albedo(mu_at(column), alpha_at(row), laws);
    let (y, x) = (row as usize, column as usize);
    let (fy, fx) = (row - y as f32, column - x as f32);
    let node = |row: usize, column: usize| {
        values[row.min(ALPHA_NODES - 1) * MU_NODES + column.min(MU_NODES - 1)]
    };
    let corners = [
        node(y, x),
        node(y, x + 1),
        node(y + 1, x),
        node(y + 1, x + 1),
    ];
    core::array::from_fn(|k| {
        let [a, b, c, d] = corners.map(|corner| corner[k]);
        let (low, high) = (a + (b - a) * fx, c + (d - c) * fx);
        (exact[k] + RAISE - (low + (high - low) * fy)).max(0.0)
    })
}

/// The mean over visible normals of Fresnel times G2/G1: what the interface
/// reflects of the light at cosine `mu`.
fn directional_albedo<const N: usize>(
    mu: f32,
    alpha: f32,
    laws: &impl Fn(f32) -> [f32; N],
) -> [f32; N] {
    if alpha < MIRROR_ALPHA_MAX {
        return laws(mu);
    }
    let wo = Vec3::new(((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt(), 0.0, mu);
    let length_o = smith_length(alpha, wo);
    let scale = 1.0 / LATTICE_POINTS as f32;
    let mut sums = [0.0f64; N];
    for i in 0..LATTICE_POINTS {
        // Graded towards the rim of the visible cap, where a smooth surface
        // keeps the few normals that throw light below the horizon.
        let v = 1.0 - (i as f32 + 0.5) * scale;
        let around = (((i * LATTICE_STEP) % LATTICE_POINTS) as f32 + 0.5) * scale;
        // Half the azimuths, by symmetry; they start at -45 degrees.
        let h = sample_visible_normal(alpha, wo, [1.0 - v * v * v, 0.125 + 0.5 * around]);
        let wi = reflect(wo, h);
        if wi.z > 0.0 {
            let length_i = smith_length(alpha, wi);
            let shadowing = wi.z * (wo.z + length_o) / (wo.z * length_i + wi.z * length_o);
            let weight = 3.0 * v * v * shadowing;
            for (sum, f) in sums
                .iter_mut()
                .zip(laws(wo.dot(h) / h.length_squared().sqrt()))
            {
                *sum += f64::from(weight * f);
            }
        }
    }
    sums.map(|sum| ((sum / f64::from(LATTICE_POINTS)) as f32).clamp(0.0, 1.0))
}

/// 2 * the integral of mu E(mu), exact for the interpolated E: the energy
/// balance then closes whatever the table's error. With t = sqrt(mu) it is the
/// integral of 4 t^3 E(t), E linear in each cell.
fn average<const N: usize>(row: &[[f32; N]]) -> [f32; N] {
    let last = (MU_NODES - 1) as f64;
    let fourth = |t: f64| (t * t) * (t * t);
    core::array::from_fn(|k| {
        let mut sum = 0.0f64;
        for (j, pair) in row.windows(2).enumerate() {
            let (t0, t1) = (j as f64 / last, (j + 1) as f64 / last);
            let (e0, e1) = (f64::from(pair[0][k]), f64::from(pair[1][k]));
            let slope = (e1 - e0) * last;
            let offset = e0 - slope * t0;
            sum += offset * (fourth(t1) - fourth(t0))
                + 0.8 * slope * (fourth(t1) * t1 - fourth(t0) * t0);
        }
        sum as f32
    })
}
