//! The table that compares the variants of one scene, as cells of text.

use super::numbers::{scaled, short, signed};
use crate::study::{Point, Reached, SceneStudy, VariantStudy, fit, seconds_to};

/// Relative errors that are asked for.
const TARGETS: [f64; 2] = [1e-2, 1e-3];

/// Number of columns.
pub(super) const WIDTH: usize = 9;

/// What the columns say.
pub(super) const COLUMNS: [&str; WIDTH] = [
    "variant",
    "core s to relMSE 1e-2",
    "core s to relMSE 1e-3",
    "efficiency, relMSE",
    "efficiency, MSE",
    "slope",
    "samples per core s",
    "samples per s",
    "bias test",
];

/// The column that holds the bias test, or why a variant failed.
pub(super) const VERDICT: usize = WIDTH - 1;

/// Cells of each variant; the first is its name.
pub(super) fn comparison(scene: &SceneStudy, baseline: &str) -> Vec<[String; WIDTH]> {
    let base = scene
        .variants
        .iter()
        .find(|v| v.variant.name == baseline && v.failure.is_none());
    scene
        .variants
        .iter()
        .map(|variant| row(scene, variant, base))
        .collect()
}

fn row(scene: &SceneStudy, study: &VariantStudy, base: Option<&VariantStudy>) -> [String; WIDTH] {
    let mut cells: [String; WIDTH] = std::array::from_fn(|_| "-".to_owned());
    cells[0].clone_from(&study.variant.name);
    if let Some(failure) = &study.failure {
        cells[VERDICT] = format!("failed: {failure}");
        return cells;
    }
    let curve = study.curve(|p| Some(p.rel_mse));
    for (cell, target) in cells[1..3].iter_mut().zip(TARGETS) {
        *cell = seconds_to(target, &curve).map_or_else(|| "never".to_owned(), reached);
    }
    cells[3] = efficiency(study, base, |p| p.rel_mse);
    cells[4] = efficiency(study, base, |p| p.mse);
    if let Some(line) = fit(&curve) {
        cells[5] = format!("{:.2}", line.slope);
    }
    if let Some(last) = study.points.last() {
        let samples = f64::from(last.spp) * f64::from(scene.width) * f64::from(scene.height);
        cells[6] = scaled(samples / last.core_s.max(1e-9));
        cells[7] = scaled(samples / last.wall_s.max(1e-9));
    }
    if let Some(bias) = &study.bias {
        let verdict = if bias.passed { "passes" } else { "BIASED" };
        let (mean, interval) = (signed(bias.mean), short(bias.interval));
        cells[VERDICT] = format!("{verdict}: {mean} ± {interval}");
    }
    if study.own_reference.is_some() {
        cells[0].push_str(" *");
    }
    cells
}

fn reached(reached: Reached) -> String {
    let mark = if reached.extrapolated { " (ext.)" } else { "" };
    format!("{}{mark}", short(reached.seconds))
}

fn efficiency(
    study: &VariantStudy,
    base: Option<&VariantStudy>,
    error: fn(&Point) -> f64,
) -> String {
    let ratio = || Some(study.efficiency(error)? / base?.efficiency(error)?);
    ratio().map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.2} x"))
}

/// Lines that say what the numbers mean.
pub(super) fn legend(scene: &SceneStudy, baseline: &str, seeds: u32) -> Vec<String> {
    let mut lines = vec![reference_text(scene)];
    if scene.variants.iter().any(|v| v.own_reference.is_some()) {
        lines.push(
            "* shows another picture on purpose and is held against a reference of its own."
                .to_owned(),
        );
    }
    lines.push(format!(
        "Errors are means over {seeds} seed(s); core seconds are CPU time of the render threads, \
         without building the scene. Seconds to an error lie on the line fitted through all \
         points (log-log), whose slope is given; -1 is that of independent samples; (ext.): \
         extrapolated beyond what was measured. Efficiency is 1 / (error x core seconds), \
         geometric mean over all points, relative to \"{baseline}\"."
    ));
    lines.push(format!(
        "Bias test: mean of (picture - reference) / (reference + 0.1) at the most samples, with \
         the interval in which an unbiased one lies (scatter from the halves of both, Student's \
         t); over all tests of the report together {} % false alarms (Sidak). Rare bright \
         samples that have not come yet look like a bias to it.",
        100.0 * crate::study::FALSE_ALARM_RATE
    ));
    lines
}

fn reference_text(scene: &SceneStudy) -> String {
    let Some(reference) = &scene.reference else {
        return "No reference.".to_owned();
    };
    match (
        &reference.file,
        reference.spp,
        reference.mse,
        reference.rel_mse,
    ) {
        (Some(file), ..) => {
            format!("Reference: {file}; its own error is not known and stands in every error here.")
        }
        (_, Some(spp), Some(mse), Some(rel)) => format!(
            "Reference: {spp} spp with another seed; its own error, from its halves: MSE {}, \
             relMSE {}.",
            short(mse),
            short(rel)
        ),
        _ => "Reference: of unknown origin.".to_owned(),
    }
}
