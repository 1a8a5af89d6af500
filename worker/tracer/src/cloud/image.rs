//! The formation by a picture.

use super::{Draws, Place};
use crate::load::CloudImage;
use glam::{DMat3, DVec3};
use shearwater_shared::scene::ImageFormation;

/// Share of chance in a particle's size; the rest is the picture's.
const SIZE_JITTER: f64 = 0.3;

/// Steps of the weight of the brightest pixel. With 2^24 pixels the sum of all
/// stays below 2^57.
const WEIGHT_STEPS: f64 = 4_294_967_296.0;

/// A picture as a distribution of its pixels.
pub(crate) struct Pixels {
    width: u32,
    height: u32,
    /// Density over the largest, rows from the top.
    brightness: Vec<f32>,
    /// Sum of the weights up to and with a pixel. Integers: exact and in no need
    /// of an order.
    sums: Vec<u64>,
}

impl Pixels {
    /// None if the picture is black everywhere.
    pub(crate) fn new(image: &CloudImage) -> Option<Self> {
        let most = image.density.iter().fold(0.0_f32, |a, &b| a.max(b));
        if most <= 0.0 {
            return None;
        }
        let brightness: Vec<f32> = image.density.iter().map(|&d| d / most).collect();
        let mut sum = 0;
        let sums = brightness
            .iter()
            .map(|&b| {
                // What is not black has some chance, however faint.
                let weight = (f64::from(b) * WEIGHT_STEPS) as u64;
                sum += weight.max(u64::from(b > 0.0));
                sum
            })
            .collect();
        Some(Self {
            width: image.width,
            height: image.height,
            brightness,
            sums,
        })
    }

    /// A pixel with the chance of its weight, from 64 random bits.
    fn draw(&self, bits: u64) -> usize {
        let total = self.sums.last().copied().unwrap_or(0);
        // The product's high half is uniform below `total` to 2^-7 of a step.
        let at = ((u128::from(bits) * u128::from(total)) >> 64) as u64;
        self.sums.partition_point(|&sum| sum <= at)
    }
}

/// A picture, placed in the scene.
pub(crate) struct PlacedImage<'a> {
    pixels: &'a Pixels,
    centre_m: DVec3,
    /// Of one pixel, to the right and upwards.
    right_m: DVec3,
    up_m: DVec3,
    depth_m: DVec3,
}

impl<'a> PlacedImage<'a> {
    /// The formation of `pixels`, turned by `rotation`.
    pub(crate) fn new(image: &ImageFormation, pixels: &'a Pixels, rotation: DMat3) -> Self {
        let (columns, rows) = (f64::from(pixels.width), f64::from(pixels.height));
        let height_m = image.height_m.unwrap_or(image.width_m * rows / columns);
        Self {
            pixels,
            centre_m: DVec3::from_array(image.centre_m),
            right_m: rotation.x_axis * (image.width_m / columns),
            up_m: rotation.y_axis * (height_m / rows),
            depth_m: rotation.z_axis * image.depth_m,
        }
    }

    /// Uniform in a pixel drawn by its weight, and across the cloud's thickness
    /// there.
    pub(super) fn place(&self, draw: &mut Draws) -> Place {
        let pixel = self.pixels.draw(draw.bits());
        let width = self.pixels.width as usize;
        let (column, row) = ((pixel % width) as f64, (pixel / width) as f64);
        let brightness = f64::from(self.pixels.brightness.get(pixel).copied().unwrap_or(0.0));
        let x = column + draw.next() - 0.5 * f64::from(self.pixels.width);
        let y = 0.5 * f64::from(self.pixels.height) - (row + draw.next());
        // A picture that fades linearly to its rim gives a round rim.
        let z = libm::sqrt(brightness) * (draw.next() - 0.5);
        Place {
            centre_m: self.centre_m + self.right_m * x + self.up_m * y + self.depth_m * z,
            size: (1.0 - SIZE_JITTER) * brightness + SIZE_JITTER * draw.next(),
            opacity: brightness,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::chi_square::assert_counts;

    fn image(width: u32, density: &[f32]) -> CloudImage {
        CloudImage {
            width,
            height: density.len() as u32 / width,
            density: density.to_vec(),
            bad_texels: 0,
        }
    }

    fn formation() -> ImageFormation {
        ImageFormation {
            file: "cloud.png".into(),
            centre_m: [10.0, 20.0, -5.0],
            width_m: 8.0,
            height_m: None,
            depth_m: 2.0,
            rotate_deg: [0.0; 3],
        }
    }

    // Four cells in each pixel: positions follow the picture, and are uniform
    // within a pixel. Black pixels stay empty.
    #[test]
    fn positions_follow_the_picture() {
        let density: Vec<f32> = (0..96)
            .map(|i| {
                if i % 7 == 0 {
                    0.0
                } else {
                    (1 + i * i % 31) as f32 * 0.37
                }
            })
            .collect();
        let pixels = Pixels::new(&image(12, &density)).expect("not black");
        let placed = PlacedImage::new(&formation(), &pixels, DMat3::IDENTITY);
        let mut counts = vec![0; 24 * 16];
        let sum: f64 = density.iter().map(|&d| f64::from(d)).sum();
        for i in 0..400_000 {
            let p = placed.place(&mut Draws::new(1, i)).centre_m - DVec3::new(10.0, 20.0, -5.0);
            // Pixels are square: 12 x 8 over 8 m x 5.33 m.
            let (x, y) = ((p.x / 8.0 + 0.5) * 24.0, (0.5 - p.y * 12.0 / 64.0) * 16.0);
            assert!((0.0..24.0).contains(&x) && (0.0..16.0).contains(&y), "{p}");
            counts[y as usize * 24 + x as usize] += 1;
        }
        let shares: Vec<f64> = (0..counts.len())
            .map(|cell| f64::from(density[cell / 48 * 12 + cell % 24 / 2]) / (4.0 * sum))
            .collect();
        assert_counts("picture", &counts, &shares);
    }

    #[test]
    fn bright_places_are_thicker_larger_and_denser() {
        let pixels = Pixels::new(&image(2, &[0.25, 1.0])).expect("not black");
        let turned = DMat3::from_cols(DVec3::NEG_Z, DVec3::Y, DVec3::X);
        let placed = PlacedImage::new(&formation(), &pixels, turned);
        let (mut dim, mut bright) = ([0.0_f64; 2], [0.0_f64; 2]);
        for i in 0..20_000 {
            let place = placed.place(&mut Draws::new(2, i));
            let p = place.centre_m - DVec3::new(10.0, 20.0, -5.0);
            // Turned: columns grow towards -z, depth lies along x.
            let (seen, thickness, sizes) = if p.z > 0.0 {
                (&mut dim, 0.5, 0.175..0.475)
            } else {
                (&mut bright, 1.0, 0.7..1.0)
            };
            assert!(sizes.contains(&(place.size + 1e-12)), "{}", place.size);
            assert_eq!(place.opacity, if thickness < 1.0 { 0.25 } else { 1.0 });
            *seen = [seen[0].max(p.x.abs()), seen[1] + 1.0];
            assert!(p.x.abs() <= thickness && p.y.abs() <= 2.0, "{p}");
        }
        assert!(dim[0] > 0.499 && bright[0] > 0.999, "{dim:?} {bright:?}");
        // 1 to 4, 5 sigma of a binomial.
        assert!((dim[1] - 4000.0).abs() < 5.0 * 56.6, "{dim:?}");
    }

    #[test]
    fn faint_pixels_have_their_chance_and_black_pictures_are_refused() {
        let pixels = Pixels::new(&image(3, &[0.0, 1e-30, 1.0])).expect("not black");
        assert_eq!(pixels.draw(0), 1);
        assert_eq!(pixels.draw(u64::MAX), 2);
        assert_eq!(pixels.draw(1 << 33), 2);
        assert!(Pixels::new(&image(2, &[0.0, 0.0])).is_none());
        let lone = Pixels::new(&image(1, &[f32::MAX])).expect("not black");
        assert_eq!((lone.draw(0), lone.draw(u64::MAX)), (0, 0));
    }
}
