//! Shadowing and bodies that the renderer does not offer, integrated by what
//! integrates those it does: a check of the integral.

use crate::support::quadrature::{direction, ggx_point, lattice, polar};
use crate::table::{Form, Row};

/// Lattice points of an integral.
const POINTS: u32 = 60_000;
/// What the listed values of metals are known to.
const DIGITS: f64 = 1e-4;

/// Angles and values of models that the renderer does not offer.
const FOUR_DEG: [f64; 4] = [60.0, 75.0, 85.0, 89.0];

/// What a model lets through at (alpha, cosine of view, of light): shadowing over
/// the view's own G1.
type Shadowing = fn(f64, f64, f64) -> f64;

/// A body's share, of the cosines to the half vector, the view and the light.
type Share = fn(f64, f64, f64) -> f64;

/// alpha, and values over [`FOUR_DEG`].
type Listed = (f64, [f64; 4]);

fn g1(alpha: f64, mu: f64) -> f64 {
    2.0 * mu / (mu + (mu * mu + alpha * alpha * (1.0 - mu * mu)).sqrt())
}

fn schlick_g(k: f64, mu: f64) -> f64 {
    mu / (mu * (1.0 - k) + k)
}

fn correlated(alpha: f64, o: f64, i: f64) -> f64 {
    let lambda = |mu| 1.0 / g1(alpha, mu) - 1.0;
    (1.0 + lambda(o)) / (1.0 + lambda(o) + lambda(i))
}

fn separable(alpha: f64, _: f64, i: f64) -> f64 {
    g1(alpha, i)
}

fn half_alpha(alpha: f64, o: f64, i: f64) -> f64 {
    schlick_g(0.5 * alpha, o) * schlick_g(0.5 * alpha, i) / g1(alpha, o)
}

/// The mean over visible normals of Fresnel times what the model lets through.
fn shiny(alpha: f64, degrees: f64, shadowing: Shadowing, fresnel: fn(f64) -> f64) -> f64 {
    let wo = direction(degrees);
    let sum: f64 = lattice(POINTS)
        .map(|u| {
            let (h, weight) = ggx_point(alpha, wo, u);
            let cos = wo.dot(h);
            let wi = h * (2.0 * cos) - wo;
            if wi.z > 0.0 {
                weight * fresnel(cos) * shadowing(alpha, wo.z, wi.z)
            } else {
                0.0
            }
        })
        .sum();
    sum / f64::from(POINTS)
}

fn schlick(cos: f64) -> f64 {
    let c = 1.0 - cos;
    0.04 + 0.96 * (c * c) * (c * c) * c
}

/// A white body's share under a weight of (cos half, cos view, cos light).
fn matte(degrees: f64, share: Share) -> f64 {
    let wo = direction(degrees);
    let sum: f64 = lattice(POINTS)
        .map(|u| {
            let wi = polar(
                (1.0 - u[0]).sqrt(),
                u[0].sqrt(),
                core::f64::consts::TAU * u[1],
            );
            share((wo + wi).normalize().dot(wo), wo.z, wi.z)
        })
        .sum();
    sum / f64::from(POINTS)
}

fn worst(values: impl Iterator<Item = f64>, listed: [f64; 4]) -> f64 {
    values
        .zip(listed)
        .fold(0.0, |worst: f64, (v, e)| worst.max((v - e).abs()))
}

pub(crate) fn not_offered(_: Form) -> Vec<Row> {
    let mut rows = Vec::new();
    let metals: [(&str, Shadowing, f64, [f64; 4]); 6] = [
        (
            "Smith separable",
            separable,
            0.1,
            [0.96910, 0.92326, 0.87315, 0.9123],
        ),
        (
            "Smith separable",
            separable,
            0.5,
            [0.68601, 0.72340, 0.77720, 0.8065],
        ),
        (
            "Smith separable",
            separable,
            1.0,
            [0.40914, 0.48753, 0.56451, 0.6032],
        ),
        (
            "k = alpha/2",
            half_alpha,
            0.1,
            [0.88971, 0.76925, 0.65450, 0.7458],
        ),
        (
            "k = alpha/2",
            half_alpha,
            1.0,
            [0.40914, 0.48753, 0.56451, 0.6032],
        ),
        (
            "Smith correlated",
            correlated,
            0.5,
            [0.69825, 0.76137, 0.87202, 0.9602],
        ),
    ];
    for (name, shadowing, alpha, listed) in metals {
        let values = FOUR_DEG.map(|degrees| shiny(alpha, degrees, shadowing, |_| 1.0));
        rows.push(Row::at_most(
            format!("{name}, alpha {alpha}"),
            DIGITS,
            worst(values.into_iter(), listed),
        ));
    }
    let bodies: [(&str, Share, [Listed; 3]); 3] = [
        (
            "1 - F(h)",
            |h, _, _| 1.0 - schlick(h),
            [
                (0.01, [1.025, 1.202, 1.572, 1.712]),
                (0.1, [1.025, 1.141, 1.274, 1.335]),
                (0.5, [0.993, 1.009, 1.036, 1.056]),
            ],
        ),
        (
            "1 - F(o)",
            |_, o, _| 1.0 - schlick(o),
            [
                (0.01, [1.000, 0.999, 0.985, 0.858]),
                (0.1, [1.000, 0.938, 0.687, 0.482]),
                (0.5, [0.968, 0.807, 0.449, 0.202]),
            ],
        ),
        (
            "(1 - F(o)) (1 - F(i))",
            |_, o, i| (1.0 - schlick(o)) * (1.0 - schlick(i)),
            [
                (0.01, [0.921, 0.935, 0.955, 0.851]),
                (0.1, [0.920, 0.874, 0.657, 0.475]),
                (0.5, [0.888, 0.743, 0.418, 0.195]),
            ],
        ),
    ];
    for (name, share, listed) in bodies {
        for (alpha, listed) in listed {
            let total =
                |degrees| shiny(alpha, degrees, correlated, schlick) + matte(degrees, share);
            let values = FOUR_DEG.map(total);
            rows.push(Row::at_most(
                format!("white body {name}, alpha {alpha}"),
                1e-3,
                worst(values.into_iter(), listed),
            ));
        }
    }
    rows
}
