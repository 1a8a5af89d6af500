//! Colour spaces of FLIP, all for white D65.

/// Linear Rec. 709 to XYZ, exact rationals of the primaries (2020, section 4.1).
const XYZ_OF_RGB: [[f32; 3]; 3] = [
    [0.412_386_564, 0.357_591_494, 0.180_450_492],
    [0.212_636_825, 0.715_182_988, 0.072_180_197],
    [0.019_330_618, 0.119_197_164, 0.950_372_581],
];

/// Its inverse, as the authors round it.
const RGB_OF_XYZ: [[f32; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];

/// XYZ of white.
const WHITE: [f32; 3] = [0.950_428_545, 1.0, 1.088_900_371];

fn times(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|row| {
        let m = matrix[row];
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2]
    })
}

fn relative_xyz(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = times(&XYZ_OF_RGB, rgb);
    [0, 1, 2].map(|c| xyz[c] / WHITE[c])
}

/// Opponent space in which the eye's contrast sensitivity is modelled: linear, so
/// that filtering in it is filtering of light.
pub(super) fn ycxcz_of_linear(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Back to linear RGB.
pub(super) fn linear_of_ycxcz([luma, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (luma + 16.0) / 116.0;
    let xyz = [y + cx / 500.0, y, y - cz / 200.0];
    times(&RGB_OF_XYZ, [0, 1, 2].map(|c| xyz[c] * WHITE[c]))
}

/// CIE L*a*b* (CIE 15) with chroma scaled by luminance after Hunt (2020, equation 3).
pub(super) fn hunt_lab_of_linear(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = relative_xyz(rgb).map(|t| {
        if t > DELTA * DELTA * DELTA {
            libm::cbrtf(t)
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// Distance for large colour differences: city block in lightness, Euclidean in
/// chroma (HyAB; 2020, equation 4).
pub(super) fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, u, v] = [0, 1, 2].map(|c| a[c] - b[c]);
    l.abs() + (u * u + v * v).sqrt()
}
