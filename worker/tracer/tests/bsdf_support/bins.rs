//! Chi-square bins that follow a lobe: polar coordinates about an axis, the
//! angle on a logarithmic scale, so that a lobe of 0.1 degrees and a diffuse
//! floor both fill many bins.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3};
use shearwater_tracer::bsdf::{Bsdf, Tables};

use super::{chi_square_p, uniform3};

/// Bins in the angle and in the azimuth.
pub const GRID: [usize; 2] = [80, 160];
/// Parts of a bin are halved at most so often, at the horizon or the rim of a lobe.
const DEPTH_MAX: u32 = 4;
/// Part of a bin whose two sums lie this close counts as integrated: absolute, and
/// in proportion, where the finer sum is right to about the square of it.
const CLOSE: f64 = 2e-10;
const CLOSE_RELATIVE: f64 = 1e-3;
/// The sum over all bins gives the integral of the density to this.
pub const INTEGRAL_TOLERANCE: f64 = 5e-5;

/// What the polar coordinates describe.
#[derive(Clone, Copy)]
pub enum Chart {
    /// The half vector about the normal, in units of this alpha.
    Half(f64),
    /// `wi` about the mirror direction, in units of this width.
    Mirror(f64),
}

/// Orthonormal axes around `z`.
fn axes(z: DVec3) -> [DVec3; 3] {
    let x = z.any_orthonormal_vector();
    [x, z.cross(x), z]
}

impl Chart {
    fn width(self) -> f64 {
        match self {
            Self::Half(width) | Self::Mirror(width) => width,
        }
    }

    fn limit(self) -> f64 {
        match self {
            Self::Half(_) => FRAC_PI_2,
            Self::Mirror(_) => PI,
        }
    }

    fn axis(self, wo: DVec3) -> DVec3 {
        match self {
            Self::Half(_) => DVec3::Z,
            Self::Mirror(_) => DVec3::new(-wo.x, -wo.y, wo.z),
        }
    }

    fn scale(self) -> f64 {
        libm::log1p(self.limit() / self.width())
    }

    /// The bin of `wi`.
    fn bin(self, wo: DVec3, wi: DVec3) -> usize {
        let v = match self {
            Self::Half(_) => (wo + wi).normalize(),
            Self::Mirror(_) => wi,
        };
        let [x, y, z] = axes(self.axis(wo)).map(|axis| v.dot(axis));
        let angle = libm::atan2((x * x + y * y).sqrt(), z);
        let radial = libm::log1p(angle / self.width()) / self.scale();
        let turn = libm::atan2(y, x) / TAU + 0.5;
        let cell = |v: f64, n: usize| ((v * n as f64) as usize).min(n - 1);
        cell(radial, GRID[0]) * GRID[1] + cell(turn, GRID[1])
    }

    /// The direction at chart coordinates in the unit square, and the solid
    /// angle of `wi` per unit of area there; `None` where no `wi` lies.
    fn direction(self, wo: DVec3, place: [f64; 2]) -> Option<(DVec3, f64)> {
        let angle = self.width() * libm::expm1(place[0] * self.scale());
        let stretch = self.scale() * (self.width() + angle);
        let phi = TAU * (place[1] - 0.5);
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let [x, y, z] = axes(self.axis(wo));
        let v = x * (sin * libm::cos(phi)) + y * (sin * libm::sin(phi)) + z * cos;
        let area = stretch * sin * TAU;
        match self {
            Self::Mirror(_) => Some((v, area)),
            Self::Half(_) => {
                let c = wo.dot(v);
                (c > 0.0).then(|| (v * (2.0 * c) - wo, area * 4.0 * c))
            }
        }
    }
}

/// What one chi-square test found.
pub struct Outcome {
    /// The chance of so bad a fit if the density is right.
    pub p: f64,
    /// Integral of the pdf over the hemisphere, and the mirror's probability.
    pub integral: f64,
    /// Share of samples that were not absorbed.
    pub accepted: f64,
}

/// Draws `samples` directions and compares their counts with the density. A
/// perfect mirror has a bin of its own. How many were absorbed is left to
/// [`Outcome::accepted`], which must be the integral: as a bin it would hold one
/// less the integral, whose error of a hundred-thousandth is many times the
/// deviation of a count of three.
pub fn chi_square(
    bsdf: &Bsdf,
    tables: &Tables,
    wo: Vec3,
    chart: Chart,
    samples: u64,
    seed: u64,
) -> Outcome {
    let wide = wo.as_dvec3();
    let bins = GRID[0] * GRID[1];
    let (mut counts, mut mirrored, mut accepted) = (vec![0u32; bins + 1], 0.0, 0u64);
    for i in 0..samples {
        let Some(sample) = bsdf.sample(tables, wo, uniform3(seed, i)) else {
            continue;
        };
        accepted += 1;
        if sample.delta {
            counts[bins] += 1;
            mirrored = f64::from(sample.pdf);
        } else {
            counts[chart.bin(wide, sample.wi.as_dvec3())] += 1;
        }
    }
    let mut expected: Vec<f64> = (0..bins)
        .map(|bin| bin_probability(bsdf, tables, wo, chart, bin))
        .collect();
    expected.push(mirrored);
    let integral: f64 = expected.iter().sum();
    for expect in &mut expected {
        *expect *= accepted as f64 / integral;
    }
    Outcome {
        p: chi_square_p(&counts, &expected),
        integral,
        accepted: accepted as f64 / samples as f64,
    }
}

/// The pdf at a place of the chart, and the solid angle per unit of area.
fn density(bsdf: &Bsdf, tables: &Tables, wo: Vec3, chart: Chart, place: [f64; 2]) -> (f64, f64) {
    chart
        .direction(wo.as_dvec3(), place)
        .map_or((0.0, 0.0), |(wi, area)| {
            (f64::from(bsdf.eval_pdf(tables, wo, wi.as_vec3()).1), area)
        })
}

/// Nodes and weights of Gauss and Legendre on (0, 1), of two and of four points.
const TWO: [(f64, f64); 2] = [
    (0.211_324_865_405_187_1, 0.5),
    (0.788_675_134_594_812_9, 0.5),
];
const FOUR: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_13, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The integral of the pdf over one bin.
fn bin_probability(bsdf: &Bsdf, tables: &Tables, wo: Vec3, chart: Chart, bin: usize) -> f64 {
    let corner = [bin / GRID[1], bin % GRID[1]];
    let low = [0, 1].map(|axis| corner[axis] as f64 / GRID[axis] as f64);
    let size = GRID.map(|n| 1.0 / n as f64);
    let at = |place: [f64; 2]| {
        let (pdf, area) = density(bsdf, tables, wo, chart, place);
        pdf * area
    };
    adaptive(&at, low, size, DEPTH_MAX)
}

/// The integral over a rectangle: by 16 points if 4 say nearly the same, or else by quarters.
fn adaptive(f: &impl Fn([f64; 2]) -> f64, low: [f64; 2], size: [f64; 2], depth: u32) -> f64 {
    let (coarse, fine) = (product(f, low, size, &TWO), product(f, low, size, &FOUR));
    let off = (fine - coarse).abs();
    let close = off <= CLOSE || off <= CLOSE_RELATIVE * fine;
    if depth == 0 || close && !ends_inside(f, low, size, fine > 0.0) {
        return fine;
    }
    let half = size.map(|s| 0.5 * s);
    let quarters = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let sum = |[x, y]: [f64; 2]| {
        let low = [low[0] + x * half[0], low[1] + y * half[1]];
        adaptive(f, low, half, depth - 1)
    };
    quarters.into_iter().map(sum).sum()
}

/// Whether the density is zero in some corners and not in others (or not where it was
/// summed): an edge that may have passed between the points of both sums.
fn ends_inside(f: &impl Fn([f64; 2]) -> f64, low: [f64; 2], size: [f64; 2], within: bool) -> bool {
    let inset = [1e-6, 1.0 - 1e-6];
    let lit = |x: f64, y: f64| f([low[0] + x * size[0], low[1] + y * size[1]]) > 0.0;
    inset
        .into_iter()
        .any(|x| inset.into_iter().any(|y| lit(x, y) != within))
}

fn product(
    f: &impl Fn([f64; 2]) -> f64,
    low: [f64; 2],
    size: [f64; 2],
    rule: &[(f64, f64)],
) -> f64 {
    let mut sum = 0.0;
    for &(x, a) in rule {
        for &(y, b) in rule {
            sum += a * b * f([low[0] + x * size[0], low[1] + y * size[1]]);
        }
    }
    sum * size[0] * size[1]
}
