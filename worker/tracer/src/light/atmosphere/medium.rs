//! The clear atmosphere: what stands in a cubic metre at each height, and how much
//! of it lies along a ray to space.

use super::spectrum::{BANDS, OZONE_M2, Spectrum, wavelength_nm};
use rayon::prelude::*;

/// Radius of the earth in metres.
pub(super) const GROUND_M: f64 = 6_371_000.0;
/// Radius of the top of the atmosphere: twilight is light from up to here.
pub(super) const TOP_M: f64 = GROUND_M + 100_000.0;

/// Height over which air thins to 1/e (Bruneton and Neyret 2008, section 2.1).
pub(super) const AIR_SCALE_M: f64 = 8000.0;
/// The same for haze.
pub(super) const HAZE_SCALE_M: f64 = 1200.0;
/// Middle and half width of the ozone layer, a tent (Bruneton 2017).
const OZONE_MIDDLE_M: f64 = 25_000.0;
const OZONE_HALF_M: f64 = 15_000.0;
/// Ozone molecules per cubic metre in its middle: a column of 300 Dobson units of
/// 2.687e20 molecules per square metre.
const OZONE_PER_M3: f64 = 300.0 * 2.687e20 / OZONE_HALF_M;

/// Rayleigh scattering of air at sea level is this times the wavelength in
/// micrometres to the power of -4, per metre (Bruneton and Neyret 2008: 13.5e-6
/// at 550 nm).
const RAYLEIGH: f64 = 1.240_62e-6;
/// How haze depends on the wavelength (Angstrom's exponent; Preetham, Shirley and
/// Smits 1999, appendix 1).
const ANGSTROM: f64 = 1.3;
/// Share of what haze takes out of a ray that it scatters (Bruneton and Neyret
/// 2008).
const HAZE_ALBEDO: f64 = 0.9;

/// Kinds of stuff: air, haze, ozone.
pub(super) const SPECIES: usize = 3;

/// Coefficients at the reference density of each kind, per metre.
#[derive(Clone, Debug)]
pub(super) struct Medium {
    /// Scattering of air, which absorbs nothing.
    pub(super) air: Spectrum,
    /// Scattering of haze.
    pub(super) haze: Spectrum,
    /// Scattering and absorption of haze.
    pub(super) haze_extinction: Spectrum,
    /// Absorption of ozone.
    pub(super) ozone: Spectrum,
}

impl Medium {
    /// Air, ozone, and as much haze as makes the vertical optical depth of both at
    /// 550 nm `turbidity` times that of air (Preetham, Shirley and Smits 1999).
    pub(super) fn new(turbidity: f64) -> Self {
        let per_band = |f: &dyn Fn(f64) -> f64| {
            let mut spectrum = [0.0; BANDS];
            for (band, value) in spectrum.iter_mut().enumerate() {
                *value = f(wavelength_nm(band) * 1e-3);
            }
            spectrum
        };
        let rayleigh = |um: f64| RAYLEIGH / (um * um * um * um);
        let haze_550 = (turbidity - 1.0).max(0.0) * rayleigh(0.55) * AIR_SCALE_M / HAZE_SCALE_M;
        let haze_extinction = per_band(&|um| haze_550 * libm::pow(um / 0.55, -ANGSTROM));
        Self {
            air: per_band(&rayleigh),
            haze: haze_extinction.map(|v| v * HAZE_ALBEDO),
            haze_extinction,
            ozone: OZONE_M2.map(|v| v * OZONE_PER_M3),
        }
    }

    /// All coefficients times `factor`.
    #[cfg(test)]
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let scale = |s: &Spectrum| s.map(|v| v * factor);
        Self {
            air: scale(&self.air),
            haze: scale(&self.haze),
            haze_extinction: scale(&self.haze_extinction),
            ozone: scale(&self.ozone),
        }
    }

    /// Optical depth of columns (metres at the reference density) in one band.
    #[inline]
    pub(super) fn depth(&self, columns: [f64; SPECIES], band: usize) -> f64 {
        columns[0] * self.air[band]
            + columns[1] * self.haze_extinction[band]
            + columns[2] * self.ozone[band]
    }
}

/// Density of each kind at the distance `r` from the earth's centre, over its
/// reference.
pub(super) fn densities(r: f64) -> [f64; SPECIES] {
    let height = (r - GROUND_M).max(0.0);
    let tent = 1.0 - (height - OZONE_MIDDLE_M).abs() / OZONE_HALF_M;
    [
        libm::exp(-height / AIR_SCALE_M),
        libm::exp(-height / HAZE_SCALE_M),
        tent.max(0.0),
    ]
}

/// Distance from `r` along a ray of vertical cosine `mu` to the top.
pub(super) fn to_top(r: f64, mu: f64) -> f64 {
    let rest = r * r * (mu * mu - 1.0) + TOP_M * TOP_M;
    (rest.max(0.0).sqrt() - r * mu).max(0.0)
}

/// Distance to the ground, for a ray that meets it.
pub(super) fn to_ground(r: f64, mu: f64) -> Option<f64> {
    let rest = r * r * (mu * mu - 1.0) + GROUND_M * GROUND_M;
    (mu < 0.0 && rest >= 0.0).then(|| (-r * mu - rest.sqrt()).max(0.0))
}

/// The vertical cosine of the horizon at `r`, not positive.
pub(super) fn horizon(r: f64) -> f64 {
    let sin = (GROUND_M / r).min(1.0);
    -(1.0 - sin * sin).sqrt()
}

/// Columns of each kind along the ray from `r` to the top: metres at the reference
/// density. Simpson's rule.
pub(super) fn columns_to_top(r: f64, mu: f64) -> [f64; SPECIES] {
    /// Pairs of steps: 500 m straight up, where haze is 1200 m deep.
    const PAIRS: usize = 100;
    let length = to_top(r, mu);
    let step = length / (2 * PAIRS) as f64;
    let mut sum = [0.0; SPECIES];
    for i in 0..=2 * PAIRS {
        let weight = match i {
            0 => 1.0,
            _ if i == 2 * PAIRS => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let s = step * i as f64;
        let here = densities((r * r + s * s + 2.0 * r * mu * s).sqrt());
        for (sum, density) in sum.iter_mut().zip(here) {
            *sum += weight * density;
        }
    }
    sum.map(|v| v * step / 3.0)
}

/// [`columns_to_top`] for every ray that misses the ground, as a table.
///
/// Rows and columns by distances instead of heights and angles, which puts the
/// nodes where the horizon needs them (Bruneton and Neyret 2008, section 4).
pub(super) struct Columns {
    nodes: Vec<[f64; SPECIES]>,
}

/// Rows: by distance to the horizon. Columns: by distance to the top.
const ROWS: usize = 80;
const COLUMNS: usize = 96;

/// Distance from the ground's horizon to the top.
fn longest() -> f64 {
    (TOP_M * TOP_M - GROUND_M * GROUND_M).sqrt()
}

impl Columns {
    pub(super) fn new() -> Self {
        let longest = longest();
        let row_of = |row: usize| {
            let rho = longest * row as f64 / (ROWS - 1) as f64;
            let r = (rho * rho + GROUND_M * GROUND_M).sqrt();
            let (least, most) = (TOP_M - r, rho + longest);
            (0..COLUMNS).map(move |column| {
                let d = least + (most - least) * column as f64 / (COLUMNS - 1) as f64;
                let mu = if d > 0.0 {
                    (longest * longest - rho * rho - d * d) / (2.0 * r * d)
                } else {
                    1.0
                };
                columns_to_top(r, mu.clamp(-1.0, 1.0))
            })
        };
        let rows: Vec<Vec<_>> = (0..ROWS)
            .into_par_iter()
            .map(|row| row_of(row).collect())
            .collect();
        Self {
            nodes: rows.concat(),
        }
    }

    /// Columns from `r` to the top; below the horizon those at the horizon.
    pub(super) fn at(&self, r: f64, mu: f64) -> [f64; SPECIES] {
        let longest = longest();
        let r = r.clamp(GROUND_M, TOP_M);
        let rho = (r * r - GROUND_M * GROUND_M).max(0.0).sqrt();
        let (least, most) = (TOP_M - r, rho + longest);
        let d = to_top(r, mu);
        let x = ((d - least) / (most - least)).clamp(0.0, 1.0) * (COLUMNS - 1) as f64;
        let y = (rho / longest).clamp(0.0, 1.0) * (ROWS - 1) as f64;
        let (column, row) = ((x as usize).min(COLUMNS - 2), (y as usize).min(ROWS - 2));
        let (fx, fy) = (x - column as f64, y - row as f64);
        let node = |i: usize, j: usize| self.nodes[j * COLUMNS + i];
        let (a, b) = (node(column, row), node(column + 1, row));
        let (c, d) = (node(column, row + 1), node(column + 1, row + 1));
        std::array::from_fn(|k| {
            let low = a[k] + (b[k] - a[k]) * fx;
            low + (c[k] + (d[k] - c[k]) * fx - low) * fy
        })
    }
}
