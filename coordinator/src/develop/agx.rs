//! The AgX picture formation (Troy Sobotka, 2022), written from its definition.
//!
//! 1. *Inset*: every primary moves a fifth of the way to the white point in the
//!    xy chromaticity diagram, so that no channel of a saturated light is zero.
//! 2. Logarithm: 16.5 stops around mid grey, from 0.18 * 2^-10 to 0.18 * 2^6.5
//!    (log2 -12.47393 to 4.026069), become [0, 1].
//! 3. S-curve through mid grey (10/16.5, 0.5) with slope 2, a toe of power 3 and
//!    a shoulder of power 3.25, through (0, 0) and (1, 1).
//! 4. *Outset*: the inverse of the inset, and clamp.
//!
//! What comes out is the code value of an sRGB display, no further curve is
//! applied: mid grey 0.18 gives 0.5, black 0, and 0.18 * 2^6.5 (16.29) or more 1.
//!
//! Steps 2 and 3 are one function of light and are tabulated as such.

use super::octave_table::OctaveTable;

/// Chromaticities (x, y) of the Rec. 709 primaries, red, green, blue.
const PRIMARIES_XY: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];
/// Chromaticity of D65, the white of Rec. 709.
const WHITE_XY: [f64; 2] = [0.3127, 0.3290];
/// How far the inset moves the primaries to white.
const INSET: f64 = 0.2;

/// The scene value that becomes 0: ten stops below mid grey.
const BLACK: f64 = 0.18 / 1024.0;
/// Stops from 0 to 1.
const STOPS: f64 = 16.5;
/// Octaves of the table: [`STOPS`], rounded up.
const OCTAVES: u8 = 17;

/// Mid grey on the curve, across and up; both also bound the curve's halves.
const PIVOT_X: f64 = 10.0 / STOPS;
const PIVOT_Y: f64 = 0.5;
/// Slope at the pivot.
const SLOPE: f64 = 2.0;

/// Shares of the primaries in white: the barycentric coordinates of the white
/// point in the triangle of the primaries.
///
/// Mixing in the xy diagram weighs by X + Y + Z, and these are the shares of
/// X + Y + Z that the primaries have in white. So the whole inset is one mix
/// with one weighted mean, and grey stays grey exactly.
const WHITE_SHARES: [f64; 3] = {
    let [[xr, yr], [xg, yg], [xb, yb]] = PRIMARIES_XY;
    let [x, y] = WHITE_XY;
    let area = (yg - yb) * (xr - xb) + (xb - xg) * (yr - yb);
    let red = ((yg - yb) * (x - xb) + (xb - xg) * (y - yb)) / area;
    let green = ((yb - yr) * (x - xb) + (xr - xb) * (y - yb)) / area;
    [red, green, 1.0 - red - green]
};

/// AgX, ready to be applied to many pixels.
pub(super) struct Agx {
    /// The S-curve over light in units of [`BLACK`].
    table: OctaveTable,
}

impl Agx {
    /// Tabulates the curve, a matter of milliseconds.
    pub(super) fn new() -> Self {
        // Above the top the curve simply goes on, so that no interval of the
        // table has a kink; `formed` cuts there.
        let curve_of_light = |light| curve(libm::log2(light) / STOPS);
        Self {
            table: OctaveTable::new(OCTAVES, curve_of_light),
        }
    }

    /// Display code values in [0, 1] of exposed linear Rec. 709 light.
    ///
    /// `rgb` must be finite and at least 0.
    pub(super) fn codes(&self, rgb: [f64; 3]) -> [f64; 3] {
        let mean = white_mean(rgb);
        let formed = rgb.map(|value| self.formed((1.0 - INSET) * value + INSET * mean));
        let mean = white_mean(formed);
        formed.map(|value| ((value - INSET * mean) / (1.0 - INSET)).clamp(0.0, 1.0))
    }

    /// The curve at a linear value, in [0, 1].
    fn formed(&self, value: f64) -> f64 {
        let light = (value / BLACK) as f32;
        self.table.at(light).clamp(0.0, 1.0)
    }
}

fn white_mean(rgb: [f64; 3]) -> f64 {
    rgb[0] * WHITE_SHARES[0] + rgb[1] * WHITE_SHARES[1] + rgb[2] * WHITE_SHARES[2]
}

/// The S-curve: `y = PIVOT_Y + SLOPE d / (1 + a |d|^p)^(1/p)` for `d = x -
/// PIVOT_X`. The steepness a follows from the end of each half: with w and h
/// its extent across and up, `a = (SLOPE / h)^p - w^-p` (the curve reaches h at
/// w); h is 0.5 in both halves.
fn curve(x: f64) -> f64 {
    let d = x - PIVOT_X;
    if d < 0.0 {
        // p = 3: 4^3 - (33/20)^3.
        const A: f64 = 64.0 - 1.65 * 1.65 * 1.65;
        PIVOT_Y + SLOPE * d / libm::cbrt(1.0 - A * d * d * d)
    } else {
        // p = 13/4: 4^3.25 - (33/13)^3.25.
        const A: f64 = 69.86278913545539;
        const P: f64 = 3.25;
        let d_to_p = d * d * d * libm::sqrt(libm::sqrt(d));
        PIVOT_Y + SLOPE * d * libm::pow(1.0 + A * d_to_p, -1.0 / P)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_put_the_primaries_together_to_white() {
        for axis in 0..2 {
            let sum: f64 = (0..3)
                .map(|i| WHITE_SHARES[i] * PRIMARIES_XY[i][axis])
                .sum();
            assert!((sum - WHITE_XY[axis]).abs() < 1e-15);
        }
        // Off-diagonal entries of the published inset matrix, whose white point
        // has other digits after the fourth.
        let published = [0.042_401, 0.078_437, 0.079_162];
        for (share, entry) in WHITE_SHARES.iter().zip(published) {
            assert!((share * INSET - entry).abs() < 1e-5);
        }
    }

    #[test]
    fn curve_meets_its_end_points_pivot_and_slope() {
        assert!((libm::log2(BLACK) + 12.473_931_188_332_4).abs() < 1e-12);
        assert!((libm::log2(BLACK) + STOPS - 4.026_068_811_667_6).abs() < 1e-12);
        assert!(curve(0.0).abs() < 1e-14);
        assert!((curve(1.0) - 1.0).abs() < 1e-14);
        assert!((curve(PIVOT_X) - 0.5).abs() < 1e-14);
        for step in [-1e-6, 1e-6] {
            let slope = (curve(PIVOT_X + step) - curve(PIVOT_X)) / step;
            assert!((slope - SLOPE).abs() < 1e-5);
        }
        let shoulder = libm::pow(4.0, 3.25) - libm::pow(33.0 / 13.0, 3.25);
        assert!((shoulder - 69.862_789_135_455_39).abs() < 1e-12);
    }

    #[test]
    fn table_follows_the_curve() {
        let agx = Agx::new();
        for step in 0..=33_000 {
            let x = f64::from(step) / 32_000.0 - 0.01;
            let value = BLACK * libm::exp2(x * STOPS);
            let expected = curve(x.clamp(0.0, 1.0));
            assert!((agx.formed(value) - expected).abs() < 3e-8, "{x}");
        }
    }

    #[test]
    fn outset_undoes_the_inset() {
        let rgb = [0.7, 0.2, 0.05];
        let mean = white_mean(rgb);
        let inset = rgb.map(|value| (1.0 - INSET) * value + INSET * mean);
        let mean = white_mean(inset);
        for (value, inset) in rgb.into_iter().zip(inset) {
            assert!(((inset - INSET * mean) / (1.0 - INSET) - value).abs() < 1e-15);
        }
    }
}
