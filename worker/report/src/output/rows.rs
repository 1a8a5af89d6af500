//! The table that compares the variants of one scene, as cells of text.

use super::numbers::{scaled, short, signed};
use crate::study::{Point, Reached, SceneStudy, VariantStudy, fit, seconds_to};

/// Relative errors that are asked for.
const TARGETS: [f64; 2] = [1e-2, 1e-3];

/// What the columns say.
pub(super) const COLUMNS: [&str; 11] = [
    "variant",
    "threads",
    "core s to relMSE 1e-2",
    "core s to relMSE 1e-3",
    "efficiency (relMSE)",
    "efficiency (MSE)",
    "slope",
    "samples per core s",
    "samples per s",
    "mean difference",
    "bias test",
];

/// Cells of each variant; the first is its name.
pub(super) fn comparison(scene: &SceneStudy, baseline: &str) -> Vec<[String; 11]> {
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

fn row(scene: &SceneStudy, study: &VariantStudy, base: Option<&VariantStudy>) -> [String; 11] {
    let mut cells: [String; 11] = std::array::from_fn(|_| "-".to_owned());
    cells[0].clone_from(&study.variant.name);
    if let Some(failure) = &study.failure {
        cells[10] = format!("failed: {failure}");
        return cells;
    }
    let curve = study.curve(|p| Some(p.rel_mse));
    cells[1] = study.threads.to_string();
    for (cell, target) in cells[2..4].iter_mut().zip(TARGETS) {
        *cell = seconds_to(target, &curve).map_or_else(|| "never".to_owned(), reached);
    }
    cells[4] = efficiency(study, base, |p| p.rel_mse);
    cells[5] = efficiency(study, base, |p| p.mse);
    if let Some(line) = fit(&curve) {
        cells[6] = format!("{:.2}", line.slope);
    }
    if let Some(last) = study.points.last() {
        let samples = f64::from(last.spp) * f64::from(scene.width) * f64::from(scene.height);
        cells[7] = scaled(samples / last.core_s.max(1e-9));
        cells[8] = scaled(samples / last.wall_s.max(1e-9));
    }
    if let Some(bias) = &study.bias {
        cells[9] = format!(
            "{} ± {}",
            signed(bias.mean_difference),
            short(bias.interval)
        );
        let verdict = if bias.passed { "passes" } else { "BIASED" };
        cells[10] = format!("{verdict} (z {})", signed(bias.z));
    }
    if study.own_reference.is_some() {
        cells[0].push_str(" *");
    }
    cells
}

fn reached(reached: Reached) -> String {
    let mark = if reached.extrapolated {
        " (extrapolated)"
    } else {
        ""
    };
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
         points (log-log), whose slope is given; -1 is that of independent samples. Efficiency \
         is 1 / (error x core seconds), geometric mean over all points, relative to `{baseline}`."
    ));
    lines.push(format!(
        "Bias test: the mean of picture - reference at the most samples, with the interval in \
         which an unbiased one lies (deviation from the halves of both); over all tests of the \
         report together {} % false alarms (Sidak).",
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
