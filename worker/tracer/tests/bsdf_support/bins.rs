//! Chi-square bins that follow a lobe: polar coordinates about an axis, the
//! angle on a logarithmic scale, so that a lobe of 0.1 degrees and a diffuse
//! floor both fill many bins.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3};
use shearwater_tracer::bsdf::{Bsdf, Tables};

use super::{chi_square_p, uniform3};

/// Bins in the angle and in the azimuth.
pub const GRID: [usize; 2] = [80, 160];
/// Points per side of a bin at which the density is evaluated.
const SUBDIVISION: usize = 4;
const SUBDIVISION_AT_JUMPS: usize = 24;
/// The sum over all bins gives the integral of the density to this.
pub const INTEGRAL_TOLERANCE: f64 = 5e-4;

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

/// Draws `samples` directions and compares their counts with the density.
/// Absorbed samples and a perfect mirror have a bin each.
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
    let (mut counts, mut mirrored) = (vec![0u32; bins + 2], 0.0);
    for i in 0..samples {
        match bsdf.sample(tables, wo, uniform3(seed, i)) {
            None => counts[bins] += 1,
            Some(sample) if sample.delta => {
                counts[bins + 1] += 1;
                mirrored = f64::from(sample.pdf);
            }
            Some(sample) => counts[chart.bin(wide, sample.wi.as_dvec3())] += 1,
        }
    }
    let mut expected = vec![0.0; bins + 2];
    let mut integral = mirrored;
    for (bin, expect) in expected.iter_mut().take(bins).enumerate() {
        *expect = bin_probability(bsdf, tables, wo, chart, bin);
        integral += *expect;
        *expect *= samples as f64;
    }
    expected[bins] = (1.0 - integral).max(0.0) * samples as f64;
    expected[bins + 1] = mirrored * samples as f64;
    let accepted = 1.0 - f64::from(counts[bins]) / samples as f64;
    Outcome {
        p: chi_square_p(&counts, &expected),
        integral,
        accepted,
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

/// The integral of the pdf over one bin, by midpoints: more of them where it
/// jumps inside, at the horizon or at the rim of a lobe.
fn bin_probability(bsdf: &Bsdf, tables: &Tables, wo: Vec3, chart: Chart, bin: usize) -> f64 {
    let corner = [bin / GRID[1], bin % GRID[1]];
    let place = |x: f64, y: f64| {
        [
            (corner[0] as f64 + x) / GRID[0] as f64,
            (corner[1] as f64 + y) / GRID[1] as f64,
        ]
    };
    let edge = 1e-6;
    let corners = [
        (edge, edge),
        (edge, 1.0 - edge),
        (1.0 - edge, edge),
        (1.0 - edge, 1.0 - edge),
        (0.5, 0.5),
    ]
    .map(|(x, y)| density(bsdf, tables, wo, chart, place(x, y)).0);
    let low = corners.into_iter().fold(f64::INFINITY, f64::min);
    let high = corners.into_iter().fold(0.0, f64::max);
    let points = if low < 0.4 * high {
        SUBDIVISION_AT_JUMPS
    } else {
        SUBDIVISION
    };
    let mut sum = 0.0;
    for i in 0..points {
        for j in 0..points {
            let [x, y] = [i, j].map(|k| (k as f64 + 0.5) / points as f64);
            let (pdf, area) = density(bsdf, tables, wo, chart, place(x, y));
            sum += pdf * area;
        }
    }
    sum / (points * points * GRID[0] * GRID[1]) as f64
}
