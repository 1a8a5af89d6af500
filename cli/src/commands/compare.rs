//! `shearwater compare`.

use crate::exit::CliError;
use crate::output;
use clap::Args;
use serde_json::json;
use shearwater_report::compare::{Comparison, DifferencePictures, compare};
use shearwater_report::groups::{Group, groups, own_rel_mse};
use shearwater_report::picture::{Picture, Range};
use std::path::{Path, PathBuf};

/// Compare a picture with a reference: squared errors, PSNR and FLIP
///
/// Two EXR files of any program are compared as linear light; two PNG files as what a
/// screen shows, without relative errors and FLIP-HDR. PSNR and FLIP-LDR take linear
/// light clamped to 0..1 (sRGB), without any tone curve; FLIP-HDR chooses its exposures
/// by the reference and uses the ACES curve. Exit code 6 says that a limit is exceeded.
/// A picture whose pixels have different numbers of samples (channel `sampleCount`) gets a row
/// for each number, with the mean difference and its z: is what ended early right on average?
///
/// Example: shearwater compare out/small.exr reference.exr --max-relmse 0.01 -o out
#[derive(Args, Debug)]
pub(crate) struct Compare {
    /// The picture to be judged, EXR or PNG
    picture: PathBuf,
    /// What it should look like, of the same size and kind
    reference: PathBuf,
    /// Most mean squared error that passes
    #[arg(long, value_name = "X", value_parser = limit)]
    max_mse: Option<f64>,
    /// Most relative mean squared error that passes: mean of (x-r)^2 / (r^2 + 0.01)
    #[arg(long, value_name = "X", value_parser = limit)]
    max_relmse: Option<f64>,
    /// Most mean FLIP that passes, 0 to 1: FLIP-HDR for EXR, FLIP-LDR for PNG
    #[arg(long, value_name = "X", value_parser = limit)]
    max_flip: Option<f64>,
    /// Folder for difference.png, flip-ldr.png and flip-hdr.png; made if need be
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

fn limit(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|value| value.is_finite() && *value >= 0.0)
        .ok_or_else(|| "expected a number, 0 or more".to_owned())
}

pub(crate) fn run(args: &Compare, json: bool) -> Result<(), CliError> {
    let read = |path: &Path| Picture::read(path).map_err(|e| CliError::Picture(e.to_string()));
    let (picture, reference) = (read(&args.picture)?, read(&args.reference)?);
    if args.max_relmse.is_some() && reference.range == Range::Display {
        let message = "--max-relmse is for EXR: PNG files hold no linear light";
        return Err(CliError::Picture(message.to_owned()));
    }
    let (found, pictures) =
        compare(&picture, &reference).map_err(|e| CliError::Picture(e.to_string()))?;
    let files = match &args.output {
        Some(folder) => write(folder, &pictures)?,
        None => Vec::new(),
    };
    let exceeded = exceeded(args, &found);
    let own = own_rel_mse(&reference);
    let groups = groups(&picture, &reference);
    if json {
        let samples = json!({ "reference_rel_mse": own, "groups": groups });
        print_json(&found, reference.range, samples, &files, &exceeded);
    } else {
        output::line(text(&found, reference.range, own));
        if !groups.is_empty() {
            output::line(groups_text(&groups));
        }
        for file in &files {
            output::line(file.display());
        }
    }
    if exceeded.is_empty() {
        Ok(())
    } else {
        Err(CliError::Different(exceeded.join("; ")))
    }
}

/// What goes beyond its limit.
fn exceeded(args: &Compare, found: &Comparison) -> Vec<String> {
    let flip = found.flip_hdr.unwrap_or(found.flip_ldr);
    [
        ("MSE", found.metrics.mse, args.max_mse),
        ("relMSE", found.metrics.rel_mse, args.max_relmse),
        ("FLIP", flip, args.max_flip),
    ]
    .into_iter()
    .filter_map(|(name, value, most)| {
        let most = most?;
        (value > most).then(|| format!("{name} is {value:.6e}: at most {most:.6e} was asked for"))
    })
    .collect()
}

fn write(folder: &Path, pictures: &DifferencePictures) -> Result<Vec<PathBuf>, CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::io(folder))?;
    let mut files = Vec::new();
    for (name, bytes) in [
        ("difference.png", Some(&pictures.difference)),
        ("flip-ldr.png", Some(&pictures.flip_ldr)),
        ("flip-hdr.png", pictures.flip_hdr.as_ref()),
    ] {
        let Some(bytes) = bytes else { continue };
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(CliError::io(&path))?;
        files.push(path);
    }
    Ok(files)
}

fn print_json(
    found: &Comparison,
    range: Range,
    samples: serde_json::Value,
    files: &[PathBuf],
    exceeded: &[String],
) {
    let mut value = serde_json::to_value(found).unwrap_or_else(|e| json!({"error": e.to_string()}));
    if let Some(fields) = value.as_object_mut() {
        if let serde_json::Value::Object(samples) = samples {
            fields.extend(samples);
        }
        if range == Range::Display {
            fields.insert("rel_mse".to_owned(), json!(null));
            fields.insert("rel_mse_trimmed".to_owned(), json!(null));
        }
        fields.insert("files".to_owned(), json!(files));
        fields.insert("exceeded".to_owned(), json!(exceeded));
    }
    output::object(&value);
}

fn text(found: &Comparison, range: Range, own: Option<f64>) -> String {
    let m = &found.metrics;
    let mut rows = vec![
        ("size", format!("{}x{}", found.width, found.height)),
        ("MSE", format!("{:.6e}", m.mse)),
    ];
    if range == Range::Linear {
        let own = own.map_or_else(String::new, |own| {
            format!(" (of it {own:.2e} the reference's own noise)")
        });
        rows.push(("relMSE", format!("{:.6e}{own}", m.rel_mse)));
        let trimmed = format!(
            "{:.6e} without the worst 0.1 % of pixels",
            found.rel_mse_trimmed
        );
        rows.push(("trimmed", trimmed));
    }
    let psnr = found.psnr_db.map_or_else(
        || "equal as a screen shows them".to_owned(),
        |db| format!("{db:.2} dB (clamped to sRGB)"),
    );
    rows.push(("PSNR", psnr));
    let flip_ldr = format!("{:.6} (clamped to sRGB)", found.flip_ldr);
    rows.push(("FLIP-LDR", flip_ldr));
    match (found.flip_hdr, found.exposures) {
        (Some(flip), Some(e)) => rows.push((
            "FLIP-HDR",
            format!(
                "{flip:.6} ({} exposures, {:+.2} to {:+.2} stops, ACES)",
                e.count, e.start, e.stop
            ),
        )),
        _ if range == Range::Linear => {
            rows.push(("FLIP-HDR", "not defined: the reference is black".to_owned()));
        }
        _ => {}
    }
    rows.push((
        "mean",
        format!(
            "{:+.6e} +- {:.2e} (95 %) beside {:.6e}",
            m.mean_difference, m.mean_difference_95, m.mean_reference
        ),
    ));
    output::table(&rows)
}

/// One row for each number of samples.
fn groups_text(groups: &[Group]) -> String {
    let mut rows = vec![
        [
            "samples",
            "pixels",
            "tiles",
            "mean difference (95 %)",
            "z",
            "relative (95 %)",
            "z",
            "MSE",
            "relMSE",
            "the reference's",
        ]
        .map(str::to_owned),
    ];
    for group in groups {
        let samples = match (group.samples_min, group.samples_max) {
            (least, most) if least == most => least.to_string(),
            (least, most) => format!("{least}-{most}"),
        };
        let (mean, relative) = (&group.difference, &group.relative_difference);
        rows.push([
            samples,
            group.pixels.to_string(),
            group.tiles.to_string(),
            format!("{:+.3e} +- {:.1e}", mean.mean, mean.interval_95),
            format!("{:+.2}", mean.z),
            format!("{:+.3e} +- {:.1e}", relative.mean, relative.interval_95),
            format!("{:+.2}", relative.z),
            format!("{:.3e}", group.mse),
            format!("{:.3e}", group.rel_mse),
            group
                .reference_rel_mse
                .map_or_else(|| "-".to_owned(), |own| format!("{own:.2e}")),
        ]);
    }
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths: [usize; 10] = std::array::from_fn(width);
    rows.iter()
        .map(|row| {
            let cells = row
                .iter()
                .zip(widths)
                .map(|(cell, w)| format!("{cell:>w$}"));
            cells.collect::<Vec<_>>().join("  ")
        })
        .collect::<Vec<_>>()
        .join("\n")
}
