//! Radiance by direction as an equirectangular map, sampled by importance.

use super::cells::CellTables;
use crate::math::elementary::{atan2, sin_cos};
use glam::Vec3;
use std::f32::consts::PI;

/// An equirectangular map, with sampling tables if they pay.
#[derive(Clone, Debug)]
pub struct SkyMap {
    width: usize,
    height: usize,
    rgb: Vec<[f32; 3]>,
    /// Turn about the vertical, as a share of a full turn.
    turn: f32,
    mean: f32,
    tables: Option<CellTables>,
}

/// Which sampling tables a map gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MapTables {
    /// Any map gets them, not only one so uneven that its bright places would be
    /// hit by luck.
    pub any_contrast: bool,
    /// In proportion to what lies above the mean radiance (Karlik et al. 2019, "MIS
    /// Compensation"); the rest of the map has density 0, and a map without
    /// anything above its mean has no tables.
    pub compensated: bool,
}

/// A direction of a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapSample {
    /// Unit direction.
    pub(super) d: Vec3,
    /// Radiance from there.
    pub(super) radiance: Vec3,
    /// Density per solid angle.
    pub(super) pdf: f32,
}

/// From this contrast on (mean square over square of the mean, 1 for a constant
/// sky) a map is sampled by importance beside the surfaces' own directions. A sky
/// without its sun has 1.5 to 3; a lamp or a sun in the map has hundreds.
const CONTRAST_MIN: f64 = 4.0;

impl SkyMap {
    /// A map of linear radiance, rows from the zenith down, turned clockwise
    /// (seen from above) by `rotation_deg`. Pixel values must be finite and not
    /// negative, and there must be `width * height` of them, at least one.
    #[must_use]
    pub fn new(
        width: usize,
        height: usize,
        rgb: Vec<[f32; 3]>,
        rotation_deg: f64,
        wanted: MapTables,
    ) -> Self {
        let turn = rotation_deg / 360.0;
        let turn = (turn - libm::floor(turn)) as f32;
        let (mean, contrast) = mean_and_contrast(width, height, &rgb);
        let tables = if wanted.any_contrast || contrast > CONTRAST_MIN {
            let below = if wanted.compensated { mean } else { 0.0 };
            CellTables::new(width, height, &rgb, below)
        } else {
            None
        };
        Self {
            width,
            height,
            rgb,
            turn,
            mean: mean as f32,
            tables,
        }
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Whether it has sampling tables.
    #[must_use]
    pub fn is_sampled(&self) -> bool {
        self.tables.is_some()
    }

    /// Mean radiance over all directions, of the brightest channel.
    #[must_use]
    pub fn mean(&self) -> f32 {
        self.mean
    }

    /// Radiance from the unit direction `d`.
    #[inline]
    #[must_use]
    pub fn radiance(&self, d: Vec3) -> Vec3 {
        self.lookup(self.uv(d))
    }

    /// Radiance from `d`, and the density of `sample` there.
    #[inline]
    #[must_use]
    pub fn radiance_and_pdf(&self, d: Vec3) -> (Vec3, f32) {
        let uv = self.uv(d);
        let sin_theta = (1.0 - d.y * d.y).max(0.0).sqrt();
        let pdf = |tables: &CellTables| tables.pdf(uv, sin_theta);
        (self.lookup(uv), self.tables.as_ref().map_or(0.0, pdf))
    }

    // u = 0.5 + azimuth from -z towards +x, v = angle from the zenith.
    #[inline]
    fn uv(&self, d: Vec3) -> [f32; 2] {
        let u = 0.5 + atan2(d.x, -d.z) * (0.5 / PI) - self.turn;
        let u = if u < 0.0 { u + 1.0 } else { u };
        // By atan2, not acos: it keeps its digits near the poles.
        let theta = atan2((d.x * d.x + d.z * d.z).sqrt(), d.y);
        [if u < 1.0 { u } else { 0.0 }, theta * (1.0 / PI)]
    }

    #[inline]
    fn lookup(&self, uv: [f32; 2]) -> Vec3 {
        let x = uv[0] * self.width as f32 - 0.5;
        let y = (uv[1] * self.height as f32 - 0.5).clamp(0.0, (self.height - 1) as f32);
        // x is at least -0.5: shifted by one it truncates downwards.
        let (column, row) = ((x + 1.0) as u32 as usize, y as u32 as usize);
        let (fx, fy) = (x + 1.0 - column as f32, y - row as f32);
        // `column` is the right neighbour here; the left one is before it.
        let left = if column == 0 {
            self.width - 1
        } else {
            (column - 1).min(self.width - 1)
        };
        let right = if column >= self.width { 0 } else { column };
        let below = (row + 1).min(self.height - 1);
        let texel = |x: usize, y: usize| Vec3::from_array(self.rgb[y * self.width + x]);
        let top = texel(left, row) * (1.0 - fx) + texel(right, row) * fx;
        let bottom = texel(left, below) * (1.0 - fx) + texel(right, below) * fx;
        top * (1.0 - fy) + bottom * fy
    }

    /// A direction with density roughly proportional to radiance; `None` from a
    /// black map or one without tables.
    #[inline]
    pub(super) fn sample(&self, u: [f32; 2]) -> Option<MapSample> {
        let (uv, density) = self.tables.as_ref()?.sample(u)?;
        let (sin_theta, cos_theta) = sin_cos(PI * uv[1]);
        let turned = uv[0] + self.turn;
        let turned = if turned >= 1.0 { turned - 1.0 } else { turned };
        let (sin_phi, cos_phi) = sin_cos(2.0 * PI * (turned - 0.5));
        let d = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
        if sin_theta <= 0.0 {
            return None;
        }
        Some(MapSample {
            d,
            radiance: self.lookup(uv),
            pdf: density / (2.0 * PI * PI * sin_theta),
        })
    }
}

fn mean_and_contrast(width: usize, height: usize, rgb: &[[f32; 3]]) -> (f64, f64) {
    let (mut weight, mut sum, mut squares) = (0.0f64, 0.0f64, 0.0f64);
    for (y, row) in rgb.chunks(width).enumerate() {
        let sin_theta = libm::sin(std::f64::consts::PI * (y as f64 + 0.5) / height as f64);
        for texel in row {
            let light = f64::from(texel[0].max(texel[1]).max(texel[2]));
            weight += sin_theta;
            sum += sin_theta * light;
            squares += sin_theta * light * light;
        }
    }
    let mean = sum / weight;
    (
        mean,
        if mean > 0.0 {
            squares / weight / (mean * mean)
        } else {
            1.0
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::u32_to_unit;
    use crate::sampler::sobol4_owen;

    const ANY: MapTables = MapTables {
        any_contrast: true,
        compensated: false,
    };

    fn draws(n: u32) -> impl Iterator<Item = [f32; 2]> {
        (0..n)
            .map(|i| sobol4_owen(i, 11, 12).map(u32_to_unit))
            .map(|u| [u[0], u[1]])
    }

    // Irradiance on a plane that faces up, by sampling the sky.
    fn irradiance(sky: &SkyMap, n: u32) -> f64 {
        let light = |u| {
            sky.sample(u)
                .map_or(0.0, |s| f64::from(s.radiance.x * s.d.y.max(0.0) / s.pdf))
        };
        draws(n).map(light).sum::<f64>() / f64::from(n)
    }

    #[test]
    fn constant_map_gives_pi() {
        let map = SkyMap::new(64, 32, vec![[1.0; 3]; 64 * 32], 0.0, ANY);
        assert!((irradiance(&map, 1 << 16) / std::f64::consts::PI - 1.0).abs() < 1e-3);
    }

    // One texel of a 4096 x 2048 map: E = L Omega cos, found from the first
    // sample on by next event estimation alone, though the lookup is bilinear.
    #[test]
    fn a_single_hot_texel_is_found() {
        let (width, height, row) = (4096usize, 2048usize, 512usize);
        let mut rgb = vec![[0.0f32; 3]; width * height];
        rgb[row * width + 1000] = [1e6; 3];
        let theta = std::f64::consts::PI * (row as f64 + 0.5) / height as f64;
        let omega = 2.0 * std::f64::consts::PI / width as f64
            * (std::f64::consts::PI / height as f64)
            * libm::sin(theta);
        let sky = SkyMap::new(width, height, rgb, 123.0, ANY);
        let measured = irradiance(&sky, 1 << 18);
        let expected = 1e6 * omega * libm::cos(theta);
        assert!(
            (measured / expected - 1.0).abs() < 0.01,
            "{measured} against {expected}"
        );
    }

    // Sizes without a common divisor: one cell for each texel.
    #[test]
    fn any_size_of_map_can_be_sampled() {
        for (width, height) in [(1025, 513), (1, 1), (3, 1), (4000, 2001)] {
            let mut rgb = vec![[0.0; 3]; width * height];
            rgb[width * (height / 2)] = [1e6; 3];
            let sky = SkyMap::new(width, height, rgb, 0.0, ANY);
            assert!(
                draws(64).all(|u| sky.sample(u).is_some_and(|s| s.pdf > 0.0)),
                "{width} x {height}"
            );
        }
    }

    #[test]
    fn only_an_uneven_sky_is_sampled() {
        let mut rgb = vec![[1.0; 3]; 32];
        assert!(!SkyMap::new(8, 4, rgb.clone(), 0.0, MapTables::default()).is_sampled());
        rgb[12] = [1000.0; 3];
        assert!(SkyMap::new(8, 4, rgb, 0.0, MapTables::default()).is_sampled());
    }

    #[test]
    fn a_black_map_is_never_sampled() {
        let sky = SkyMap::new(8, 4, vec![[0.0; 3]; 32], 0.0, ANY);
        assert!(draws(64).all(|u| sky.sample(u).is_none()));
        let (radiance, pdf) = sky.radiance_and_pdf(Vec3::Y);
        assert_eq!((radiance, pdf), (Vec3::ZERO, 0.0));
    }

    // The density that `sample` states is the one that `radiance_and_pdf` gives
    // for the same direction, and the directions agree with the map's layout.
    #[test]
    fn sample_and_pdf_agree() {
        let (width, height) = (32usize, 16usize);
        let rgb: Vec<[f32; 3]> = (0..width * height)
            .map(|i| [0.1 + (i * 37 % 101) as f32; 3])
            .collect();
        let sky = SkyMap::new(width, height, rgb, 77.0, ANY);
        let mut agreed = 0;
        for u in draws(4096) {
            let s = sky.sample(u).expect("light everywhere");
            let (radiance, pdf) = sky.radiance_and_pdf(s.d);
            // On the border of two cells rounding may choose the other one.
            agreed += u32::from(
                (pdf / s.pdf - 1.0).abs() < 1e-3
                    && (radiance - s.radiance).abs().max_element() < 0.05,
            );
        }
        assert!(agreed > 4070, "{agreed} of 4096");
    }

    // Chi-square of the sampled cells against pdf times solid angle, at 0.001.
    #[test]
    fn sampled_directions_follow_the_density() {
        let (width, height) = (16usize, 8usize);
        let rgb: Vec<[f32; 3]> = (0..width * height)
            .map(|i| [if i % 7 == 0 { 20.0 } else { 0.2 }; 3])
            .collect();
        let sky = SkyMap::new(width, height, rgb, 0.0, ANY);
        let (n, mut counts) = (1u32 << 18, vec![0u32; width * height]);
        for i in 0..n {
            let u = [
                crate::math::hash::mix32(2 * i),
                crate::math::hash::mix32(2 * i + 1),
            ]
            .map(u32_to_unit);
            let uv = sky.uv(sky.sample(u).expect("light").d);
            let cell = |v: f32, n: usize| ((v * n as f32) as usize).min(n - 1);
            counts[cell(uv[1], height) * width + cell(uv[0], width)] += 1;
        }
        let chi: f64 = counts
            .iter()
            .zip(&sky.tables.as_ref().expect("tables").density)
            .map(|(&count, &density)| {
                let expected = f64::from(density) / 128.0 * f64::from(n);
                (f64::from(count) - expected) * (f64::from(count) - expected) / expected
            })
            .sum();
        // 127 degrees of freedom: mean 127, the 0.999 quantile is 181.
        assert!(chi < 181.0, "{chi}");
    }

    #[test]
    fn the_middle_column_looks_along_minus_z_and_columns_grow_to_plus_x() {
        let (width, height) = (64usize, 32usize);
        let rgb: Vec<[f32; 3]> = (0..width * height)
            .map(|i| [(i % width) as f32, (i / width) as f32, 0.0])
            .collect();
        let sky = SkyMap::new(width, height, rgb, 0.0, ANY);
        let ahead = sky.radiance(Vec3::NEG_Z);
        assert!(
            (ahead.x - 31.5).abs() < 1e-3 && (ahead.y - 15.5).abs() < 1e-3,
            "{ahead}"
        );
        assert!(sky.radiance(Vec3::new(0.5, 0.0, -1.0).normalize()).x > 32.0);
        assert!(sky.radiance(Vec3::new(0.0, 0.5, -1.0).normalize()).y < 15.0);
    }
}
