//! How far a picture lies from a reference, as numbers.
//!
//! Every sum runs over pixels in order, in `f64`.

use serde::{Deserialize, Serialize};

/// Keeps dark pixels from ruling the relative error: an error in a pixel darker
/// than 0.1 counts as if it had that radiance.
pub const RELATIVE_EPSILON: f64 = 0.01;

/// Two-sided 95 % of the normal distribution, in standard deviations.
pub const Z_95: f64 = 1.959_963_984_540_054;

/// Errors over all pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Mean of (x - r)^2.
    pub mse: f64,
    /// Mean of (x - r)^2 / (r^2 + [`RELATIVE_EPSILON`]).
    pub rel_mse: f64,
    /// Mean of x - r.
    pub mean_difference: f64,
    /// Half of the 95 % interval of `mean_difference`, from the scatter of the
    /// pixels' mean differences. It takes pixels for independent.
    pub mean_difference_95: f64,
    /// Mean of r.
    pub mean_reference: f64,
}

/// The errors of `picture` against `reference`, both of equally many pixels;
/// zero without any.
#[must_use]
pub fn metrics(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> Metrics {
    let (mut squared, mut relative, mut light) = (0.0, 0.0, 0.0);
    let (mut sum, mut sum_of_squares) = (0.0, 0.0);
    let pixels = picture.len().min(reference.len());
    for (x, r) in picture.iter().zip(reference) {
        let mut of_pixel = 0.0;
        for c in 0..3 {
            let (x, r) = (f64::from(x[c]), f64::from(r[c]));
            let d = x - r;
            squared += d * d;
            relative += d * d / (r * r + RELATIVE_EPSILON);
            light += r;
            of_pixel += d;
        }
        of_pixel /= 3.0;
        sum += of_pixel;
        sum_of_squares += of_pixel * of_pixel;
    }
    let n = pixels.max(1) as f64;
    let mean = sum / n;
    // Of the mean: the variance of one pixel over their number.
    let variance = (sum_of_squares / n - mean * mean).max(0.0) / (n - 1.0).max(1.0);
    Metrics {
        mse: squared / (3.0 * n),
        rel_mse: relative / (3.0 * n),
        mean_difference: mean,
        mean_difference_95: Z_95 * variance.sqrt(),
        mean_reference: light / (3.0 * n),
    }
}

/// One pixel of so many is left out of [`rel_mse_trimmed`].
pub const TRIMMED_PIXEL_OF: usize = 1000;

/// `rel_mse` without the worst thousandth of the pixels: where a few pixels with rare
/// bright samples decide the mean, this says more. It is smaller than the whole, also
/// without any such pixel.
#[must_use]
pub fn rel_mse_trimmed(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let of_pixel = |(x, r): (&[f32; 3], &[f32; 3])| -> f64 {
        let of_channel = |c: usize| {
            let (x, r) = (f64::from(x[c]), f64::from(r[c]));
            (x - r) * (x - r) / (r * r + RELATIVE_EPSILON)
        };
        of_channel(0) + of_channel(1) + of_channel(2)
    };
    let mut errors: Vec<f64> = picture.iter().zip(reference).map(of_pixel).collect();
    errors.sort_unstable_by(f64::total_cmp);
    errors.truncate(errors.len() - errors.len() / TRIMMED_PIXEL_OF);
    errors.iter().sum::<f64>() / (3.0 * errors.len().max(1) as f64)
}

/// Peak signal to noise ratio in dB of pictures whose largest value is 1;
/// `None` when they are equal.
#[must_use]
pub fn psnr_db(displayed_mse: f64) -> Option<f64> {
    (displayed_mse > 0.0).then(|| -10.0 * libm::log10(displayed_mse))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_difference_gives_known_errors() {
        let reference = [[1.0, 2.0, 0.0], [0.5, 0.5, 0.5]];
        let picture = [[1.5, 2.0, 0.0], [0.5, 0.25, 0.5]];
        let m = metrics(&picture, &reference);
        assert!((m.mse - (0.25 + 0.0625) / 6.0).abs() < 1e-12);
        let relative = (0.25 / 1.01 + 0.0625 / 0.26) / 6.0;
        assert!((m.rel_mse - relative).abs() < 1e-12, "{m:?}");
        assert!((m.mean_difference - 0.25 / 6.0).abs() < 1e-12);
        assert!((m.mean_reference - 4.5 / 6.0).abs() < 1e-12);
        // Of 1/6 and -1/12: deviation 1/8 each way, over the root of n - 1 = 1.
        assert!((m.mean_difference_95 - Z_95 * 0.125).abs() < 1e-12);
    }

    #[test]
    fn equal_pictures_have_no_error_and_no_ratio() {
        let picture = [[0.25, 3.0, 1e-3]; 5];
        let m = metrics(&picture, &picture);
        assert_eq!((m.mse, m.rel_mse, m.mean_difference_95), (0.0, 0.0, 0.0));
        assert_eq!(psnr_db(m.mse), None);
        assert_eq!(psnr_db(0.01), Some(20.0));
    }

    // Two of 2000 pixels are far off; without them the rest counts.
    #[test]
    fn the_worst_thousandth_is_left_out() {
        let reference = [[1.0; 3]; 2000];
        let mut picture = [[1.5; 3]; 2000];
        picture[7] = [100.0; 3];
        picture[1999] = [0.0, 50.0, 0.0];
        let rest = 0.25 / 1.01;
        let trimmed = rel_mse_trimmed(&picture, &reference);
        assert!((trimmed - rest).abs() < 1e-12, "{trimmed}");
        picture[8] = [100.0; 3];
        assert!(rel_mse_trimmed(&picture, &reference) > 1.5 * rest);
        assert!((rel_mse_trimmed(&picture[9..900], &reference[9..900]) - rest).abs() < 1e-12);
        assert_eq!(rel_mse_trimmed(&[], &[]), 0.0);
    }

    // 4000 pixels with differences of mean 0.1 and deviation 0.2: the interval is
    // 1.96 x 0.2 / sqrt(4000) on each side.
    #[test]
    fn the_interval_of_the_mean_follows_the_scatter() {
        let reference = [[1.0; 3]; 4000];
        let mut picture = reference;
        for (index, pixel) in picture.iter_mut().enumerate() {
            let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
            *pixel = [1.1 + 0.2 * sign; 3];
        }
        let m = metrics(&picture, &reference);
        assert!((m.mean_difference - 0.1).abs() < 1e-6, "{m:?}");
        let expected = Z_95 * 0.2 / 4000f64.sqrt();
        assert!(
            (m.mean_difference_95 / expected - 1.0).abs() < 1e-3,
            "{m:?}"
        );
    }
}
