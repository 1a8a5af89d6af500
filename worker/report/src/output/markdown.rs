//! The comparison of each scene as Markdown.

use super::Heading;
use super::numbers::short;
use super::rows::{COLUMNS, comparison, legend};
use crate::study::{SceneStudy, Study};

/// A document with one table for each scene, and one of all points.
#[must_use]
pub fn markdown(study: &Study, heading: &Heading) -> String {
    let mut out = format!("# {}\n", heading.title);
    for line in [&heading.machine, &format!("`{}`", heading.command)] {
        out.push_str(&format!("\n{line}\n"));
    }
    for scene in &study.scenes {
        out.push_str(&scene_text(study, scene));
    }
    out
}

fn scene_text(study: &Study, scene: &SceneStudy) -> String {
    let (name, width, height) = (&scene.name, scene.width, scene.height);
    let mut out = format!("\n## {name}, {width}x{height}\n\n");
    out.push_str(&line(&COLUMNS.map(str::to_owned)));
    out.push_str(&line(&COLUMNS.map(|_| "---".to_owned())));
    for row in comparison(scene, &study.baseline) {
        out.push_str(&line(&row));
    }
    for text in legend(scene, &study.baseline, study.seeds) {
        out.push_str(&format!("\n{text}\n"));
    }
    out.push('\n');
    let names = ["variant", "spp", "core s", "s", "MSE", "relMSE", "FLIP-HDR"];
    out.push_str(&line(&names.map(str::to_owned)));
    out.push_str(&line(&names.map(|_| "---".to_owned())));
    for variant in &scene.variants {
        for p in &variant.points {
            out.push_str(&line(&[
                variant.variant.name.clone(),
                p.spp.to_string(),
                short(p.core_s),
                short(p.wall_s),
                short(p.mse),
                short(p.rel_mse),
                p.flip_hdr.map_or_else(|| "-".to_owned(), short),
            ]));
        }
    }
    out
}

fn line(cells: &[String]) -> String {
    let cells: Vec<String> = cells
        .iter()
        .map(|cell| cell.replace('|', "\\|").replace(['\n', '\r'], " "))
        .collect();
    format!("| {} |\n", cells.join(" | "))
}
