//! How much light the reflection models keep: a table in Markdown of directional
//! albedos, by an integral over the hemisphere.
//!
//! `cargo bench -p shearwater-tracer --bench energy > docs/energy.md`

#![allow(clippy::print_stdout, reason = "its output is the product")]

#[path = "../tests/bsdf_support/mod.rs"]
mod support;

use glam::Vec3;
use shearwater_tracer::bsdf::{
    Bsdf, BsdfError, GgxModel, GgxParameters, Phong, TableNeeds, Tables,
};
use support::quadrature::{Narrow, direction, integrate};

const ANGLES_DEG: [f64; 5] = [0.0, 30.0, 60.0, 75.0, 85.0];
const ALPHAS: [f32; 5] = [0.01, 0.1, 0.25, 0.5, 1.0];
const EXPONENTS: [f32; 5] = [1.0, 10.0, 50.0, 1000.0, 1e6];
/// Points of the integral: four digits.
const POINTS: u32 = 200_000;

const INTRODUCTION: &str = "# Energy of the reflection models

What a surface reflects of light that is 1 from everywhere, by the angle of view: its directional albedo. Above 1 a model
makes light, below 1 (with white colours) it loses some. `corrected` and `report` are the values of a material's `model`.

Made by `cargo bench -p shearwater-tracer --bench energy > docs/energy.md` (a hemispherical integral, four digits).
";
const METAL: &str = "
## White metal: F = 1

Only the microfacets' shadowing is left. One reflection on a rough surface must lose what would be reflected again
(1 - ln 2 = 0.3069 at alpha 1 and 0 degrees); a smooth one must lose nothing. The report's
`k = (alpha + 1)^2 / 8` also darkens smooth surfaces, towards `(mu / (7 mu / 8 + 1 / 8))^2`: at 85 degrees a perfect mirror
keeps 19 %.
";
const DIELECTRIC: &str = "
## White dielectric: F0 = 0.04, white body

The interface's light and the body's together; exactly 1 would be right at every angle and every alpha. The report's body,
`1 - F(h)`, makes light at grazing angles, and its shadowing hides much of that again.
";
const PHONG: &str = "
## Modified Phong: ks = 1

For a large n the model keeps cos(theta) of the light; for a small one part of the lobe lies below the horizon besides.
";

fn main() -> Result<(), BsdfError> {
    let tables = Tables::build(&TableNeeds {
        schlick: true,
        ..TableNeeds::default()
    })?;
    print!("{INTRODUCTION}");
    for (text, metalness) in [(METAL, 1.0), (DIELECTRIC, 0.0)] {
        print!("{text}\n{}", header("alpha | model"));
        for alpha in ALPHAS {
            for (name, model) in [
                ("corrected", GgxModel::Corrected),
                ("report", GgxModel::Report),
            ] {
                let parameters = GgxParameters {
                    base_color: Vec3::ONE,
                    metalness,
                    alpha,
                    dielectric_f0: 0.04,
                };
                let bsdf = Bsdf::ggx(&tables, model, &parameters)?;
                let narrow = Narrow::Ggx(alpha.into());
                println!("| {alpha} | {name} |{}", row(&bsdf, &tables, narrow));
            }
        }
    }
    print!("{PHONG}\n{}", header("n"));
    for exponent in EXPONENTS {
        let bsdf = Bsdf::Phong(Phong::new(Vec3::ZERO, Vec3::ONE, exponent)?);
        let narrow = Narrow::Phong(exponent.into());
        println!("| {exponent} |{}", row(&bsdf, &tables, narrow));
    }
    Ok(())
}

fn header(first: &str) -> String {
    let angles: String = ANGLES_DEG.iter().map(|a| format!(" {a}° |")).collect();
    let columns = ANGLES_DEG.len() + first.split('|').count();
    format!("| {first} |{angles}\n|{}\n", "---|".repeat(columns))
}

fn row(bsdf: &Bsdf, tables: &Tables, narrow: Narrow) -> String {
    ANGLES_DEG
        .iter()
        .map(|&degrees| {
            let wo = direction(degrees);
            let albedo = integrate(bsdf, tables, wo, narrow, POINTS, |f, _| f64::from(f.y));
            format!(" {albedo:.4} |")
        })
        .collect()
}
