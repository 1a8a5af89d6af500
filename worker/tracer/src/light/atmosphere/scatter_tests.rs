//! Transmittance and single scattering against what can be known otherwise.

use super::*;
use crate::light::atmosphere::medium::{SPECIES, densities};

// Columns by another rule (midpoint) in another variable (height instead of
// distance, by the radius along the ray), as fine as it takes.
fn columns_by_height(r0: f64, mu: f64) -> [f64; SPECIES] {
    let mut sum = [0.0; SPECIES];
    // ds = r dr / sqrt(r^2 - p^2), p the distance of the ray from the centre;
    // r = p cosh would be smooth, r^2 = p^2 + q^2 makes it ds = dq.
    let p2 = r0 * r0 * (1.0 - mu * mu);
    let (q0, q1) = (r0 * mu, (TOP_M * TOP_M - p2).sqrt());
    let n = 400_000;
    for i in 0..n {
        let q = q0 + (q1 - q0) * (f64::from(i) + 0.5) / f64::from(n);
        for (sum, density) in sum.iter_mut().zip(densities((p2 + q * q).sqrt())) {
            *sum += density * (q1 - q0) / f64::from(n);
        }
    }
    sum
}

#[test]
fn transmittance_is_the_exponential_of_the_optical_depth() {
    let (medium, columns) = (Medium::new(3.0), Columns::new());
    for height in [0.0, 2.0, 900.0, 7300.0, 30_000.0] {
        let r = GROUND_M + height;
        let level = horizon(r);
        for mu in [1.0, 0.6, 0.2, 0.05, 0.01, level + 0.0005] {
            let exact = columns_by_height(r, mu);
            let table = columns.at(r, mu);
            for band in [0, 4, 10] {
                let expected = libm::exp(-medium.depth(exact, band));
                let got = libm::exp(-medium.depth(table, band));
                assert!(
                    (got - expected).abs() < 0.004,
                    "{height} m, mu {mu}, band {band}: {got} against {expected}"
                );
            }
        }
    }
    // Straight up the columns are known: scale heights, and the tent's half width.
    let up = crate::light::atmosphere::medium::columns_to_top(GROUND_M, 1.0);
    for (column, expected) in up.into_iter().zip([8000.0, 1200.0, 15_000.0]) {
        assert!((column / expected - 1.0).abs() < 1e-3, "{up:?}");
    }
}

#[test]
fn turbidity_is_the_ratio_of_optical_depths() {
    for turbidity in [1.0, 2.5, 10.0] {
        let medium = Medium::new(turbidity);
        // 550 nm is the sixth band.
        let (air, haze) = (medium.air[5] * 8000.0, medium.haze_extinction[5] * 1200.0);
        assert!(((air + haze) / air - turbidity).abs() < 1e-9);
    }
}

// In the thin limit a slab scatters F p tau mu0 / (mu - mu0) (e^(-tau / mu) -
// e^(-tau / mu0)) downwards, which tends to F p tau / mu; air and haze add up.
#[test]
fn thin_air_scatters_as_a_slab() {
    let medium = Medium::new(3.0).scaled(1e-3);
    let elevation = 50.0f64.to_radians();
    let mut model = Model::new(medium, 0.0, elevation);
    // Once scattered only.
    model.multiple = Vec::new();
    let sun_cos = model.sun_cos();
    for mu in [1.0, 0.8, 0.6] {
        for cos_bearing in [1.0, 0.0, -1.0] {
            let ray = model.march(GROUND_M, mu, 200);
            let cos = towards_sun(mu, sun_cos, cos_bearing);
            let radiance = model.gather(&ray, GROUND_M, mu, cos_bearing).radiance(cos);
            for band in [0, 5, 10] {
                let air = model.medium.air[band] * 8000.0;
                let haze = model.medium.haze[band] * 1200.0;
                let tau = model.medium.depth([8000.0, 1200.0, 15_000.0], band);
                let slab = if (mu - sun_cos).abs() < 1e-9 {
                    libm::exp(-tau / mu) / mu
                } else {
                    sun_cos / (mu - sun_cos) / tau
                        * (libm::exp(-tau / mu) - libm::exp(-tau / sun_cos))
                };
                let phases = air * air_phase(cos) + haze * haze_phase(cos);
                let expected = SOLAR[band] * phases * slab;
                assert!(
                    (radiance[band] / expected - 1.0).abs() < 0.01,
                    "mu {mu}, bearing {cos_bearing}, band {band}: {} against {expected}",
                    radiance[band]
                );
            }
        }
    }
}

#[test]
fn phase_functions_are_normalised() {
    let n = 200_000;
    for phase in [air_phase, haze_phase] {
        let sum: f64 = (0..n)
            .map(|i| 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n))
            .map(|cos| 2.0 * PI * phase(cos) * 2.0 / f64::from(n))
            .sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    }
}

// Scattering again adds light, and the more the thicker the haze; the series stays
// finite.
#[test]
fn more_scatterings_add_light() {
    let zenith = |turbidity, multiple: bool| {
        let mut model = Model::new(Medium::new(turbidity), 0.3, 0.7);
        if !multiple {
            model.multiple = Vec::new();
        }
        let ray = model.march(GROUND_M, 1.0, 48);
        model
            .gather(&ray, GROUND_M, 1.0, 1.0)
            .radiance(model.sun_cos())[1]
    };
    let gain = |turbidity| zenith(turbidity, true) / zenith(turbidity, false);
    assert!(gain(2.0) > 1.05 && gain(6.0) > gain(2.0) && gain(10.0) < 10.0);
}
