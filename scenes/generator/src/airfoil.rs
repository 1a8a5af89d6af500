//! NACA four-digit sections (Jacobs, Ward & Pinkerton, NACA report 460, 1933).

use std::f64::consts::PI;

/// A section of unit chord: maximum camber, its place, and thickness, as
/// fractions of the chord.
#[derive(Clone, Copy, Debug)]
pub struct Airfoil {
    /// Maximum camber (first digit / 100).
    pub camber: f64,
    /// Chordwise place of the maximum camber (second digit / 10).
    pub camber_at: f64,
    /// Thickness (last two digits / 100).
    pub thickness: f64,
}

impl Airfoil {
    /// Upper and lower ordinate at chord fraction `x`.
    ///
    /// The last coefficient is -0.1036 instead of -0.1015, the usual change
    /// that closes the trailing edge.
    #[must_use]
    pub fn ordinates(&self, x: f64) -> (f64, f64) {
        let half = 5.0
            * self.thickness
            * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x * x * x
                - 0.1036 * x * x * x * x);
        let (m, p) = (self.camber, self.camber_at);
        let line = if m == 0.0 {
            0.0
        } else if x < p {
            m / (p * p) * (2.0 * p * x - x * x)
        } else {
            m / ((1.0 - p) * (1.0 - p)) * ((1.0 - 2.0 * p) + 2.0 * p * x - x * x)
        };
        (line + half, line - half)
    }

    /// Closed loop of `2 * half` points (chord fraction, ordinate): the
    /// trailing edge, the upper side forward, the leading edge (at index
    /// `half`), the lower side back. Points crowd towards both edges.
    #[must_use]
    pub fn outline(&self, half: usize) -> Vec<(f64, f64)> {
        (0..2 * half)
            .map(|i| {
                let steps = if i <= half { i } else { 2 * half - i };
                let x = 0.5 * (1.0 + libm::cos(PI * steps as f64 / half as f64));
                let (upper, lower) = self.ordinates(x.clamp(0.0, 1.0));
                (x, if i <= half { upper } else { lower })
            })
            .collect()
    }
}
