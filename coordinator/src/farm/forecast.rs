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

#[cfg(test)]
mod tests {
    use super::*;
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
