//! What more samples will give: the squared error falls as one over their number.

use shearwater_shared::film::ErrorEstimate;

/// The NMSE of a frame once every pixel has `samples` samples; `None` without
/// samples so far or for errors of before they were counted. Scrambled points
/// converge as fast as independent ones or faster, so it is rather too large.
#[must_use]
pub fn nmse_at(error: &ErrorEstimate, samples: u32) -> Option<f64> {
    let detail = error.detail.filter(|detail| detail.samples > 0)?;
    let present = detail.samples as f64 / detail.pixels as f64;
    (samples > 0).then(|| error.nmse * present / f64::from(samples))
}

/// Samples, over all of a frame's `pixels`, after which its relative MSE is
/// `target`; what the pixels without samples need is that of the others.
#[must_use]
pub fn samples_to_error(error: &ErrorEstimate, pixels: u64, target: f64) -> Option<f64> {
    let detail = error.detail.filter(|detail| detail.samples > 0)?;
    let present = detail.samples as f64 / detail.pixels as f64;
    (target > 0.0).then(|| pixels as f64 * present * detail.relmse / target)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_error_takes_twice_the_samples() {
        let error = ErrorEstimate {
            detail: Some(ErrorDetail {
                relmse: 0.02,
                pixels: 50,
                samples: 800,
                ..ErrorDetail::default()
            }),
            ..ErrorEstimate::default()
        };
        // Half of the picture has 16 samples each; 32 are needed, everywhere.
        assert_eq!(samples_to_error(&error, 100, 0.01), Some(3200.0));
        assert_eq!(samples_to_error(&error, 100, 0.0), None);
        assert_eq!(samples_to_error(&ErrorEstimate::default(), 100, 0.01), None);
    }
    use shearwater_shared::film::ErrorDetail;

    #[test]
    fn four_times_the_samples_are_a_quarter_of_the_error() {
        let mut error = ErrorEstimate {
            nmse: 0.08,
            detail: Some(ErrorDetail {
                pixels: 100,
                samples: 6400,
                ..ErrorDetail::default()
            }),
            ..ErrorEstimate::default()
        };
        assert_eq!(nmse_at(&error, 256), Some(0.02));
        assert_eq!(nmse_at(&error, 0), None);
        error.detail = None;
        assert_eq!(nmse_at(&error, 256), None);
    }
}
