//! Light by wavelength: the sun's, and how wavelengths become linear RGB.
//!
//! Eleven bands of 30 nm from 385 to 715 nm. Three wavelengths would do for noon;
//! at sunset the optical depth of a band spans a factor of ten across the visible,
//! and the violet of twilight comes from ozone's broad absorption in the orange,
//! which no three wavelengths hold.

/// Bands.
pub(super) const BANDS: usize = 11;

/// A value for each band.
pub(super) type Spectrum = [f64; BANDS];

/// Middle of the first band and width of each, in nanometres.
const FIRST_NM: f64 = 400.0;
const STEP_NM: f64 = 30.0;

/// Solar irradiance outside the atmosphere in W / (m^2 nm): means of ASTM G173-03
/// (extraterrestrial column) over the bands.
pub(super) const SOLAR: Spectrum = [
    1.535, 1.738, 2.026, 1.936, 1.864, 1.845, 1.810, 1.711, 1.591, 1.514, 1.409,
];

/// Absorption cross-section of ozone in m^2 per molecule: means over the bands of
/// what Serdyuchenko et al. 2014 measured at 233 K.
pub(super) const OZONE_M2: Spectrum = [
    1.65e-27, 9.93e-27, 3.64e-26, 1.052e-25, 2.165e-25, 3.619e-25, 4.590e-25, 4.355e-25, 2.705e-25,
    1.511e-25, 7.81e-26,
];

/// Lumens per watt at 555 nm, over the candelas per square metre that one unit of
/// radiance stands for.
const UNITS_PER_WATT: f64 = 683.0 / super::CANDELA_PER_UNIT;

/// The middle of a band in nanometres.
pub(super) fn wavelength_nm(band: usize) -> f64 {
    FIRST_NM + STEP_NM * band as f64
}

/// Spectral radiance in W / (m^2 sr nm), or irradiance, as linear Rec. 709 in the
/// units of [`super::CANDELA_PER_UNIT`]. A colour outside that gamut is mixed with
/// grey of its luminance until it lies on the border.
pub(super) fn to_rgb(spectrum: &Spectrum, matching: &[[f64; 3]; BANDS]) -> [f64; 3] {
    let mut rgb = [0.0; 3];
    for (value, weights) in spectrum.iter().zip(matching) {
        for (sum, weight) in rgb.iter_mut().zip(weights) {
            *sum += value * weight;
        }
    }
    rgb
}

/// Mix a colour with grey of its luminance until no channel is negative.
pub(super) fn into_gamut(rgb: [f64; 3]) -> [f64; 3] {
    let least = rgb[0].min(rgb[1]).min(rgb[2]);
    if least >= 0.0 {
        return rgb;
    }
    let luminance = luminance(rgb).max(0.0);
    let keep = luminance / (luminance - least);
    rgb.map(|v| (luminance + (v - luminance) * keep).max(0.0))
}

/// Luminance of linear Rec. 709.
pub(super) fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// What one W / nm of each band adds to linear Rec. 709.
pub(super) fn matching_rgb() -> [[f64; 3]; BANDS] {
    std::array::from_fn(|band| {
        let mut xyz = [0.0; 3];
        for offset in [-10.0, 0.0, 10.0] {
            let at = observer(wavelength_nm(band) + offset);
            for (sum, v) in xyz.iter_mut().zip(at) {
                *sum += v * (STEP_NM / 3.0 * UNITS_PER_WATT);
            }
        }
        let [x, y, z] = xyz;
        // IEC 61966-2-1.
        [
            3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
            -0.969_266_0 * x + 1.876_010_8 * y + 0.041_556_0 * z,
            0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
        ]
    })
}

// The CIE 1931 standard observer by sums of Gaussian lobes (Wyman, Sloan and
// Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching
// Functions", section 2.2).
fn observer(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, middle: f64, below: f64, above: f64| {
        let t = (nm - middle) * if nm < middle { below } else { above };
        height * libm::exp(-0.5 * t * t)
    };
    [
        lobe(0.362, 442.0, 0.0624, 0.0374)
            + lobe(1.056, 599.8, 0.0264, 0.0323)
            + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ]
}
