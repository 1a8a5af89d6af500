//! One page that needs no other file.

use super::Heading;
use super::base64::base64;
use super::numbers::short;
use super::plot::{Curve, mark, plot};
use super::rows::{COLUMNS, VERDICT, comparison, legend};
use crate::study::{Point, SceneStudy, Study, fit};
use std::fmt::Write;

const STYLE: &str = "\
:root{color-scheme:light}\
body{margin:0 auto;max-width:1240px;padding:24px 28px 60px;background:#fff;color:#1d2125;\
font:15px/1.5 system-ui,sans-serif}\
h1{font-size:26px;margin:0 0 4px}h2{font-size:20px;margin:44px 0 10px;padding-top:14px;\
border-top:1px solid #dfe3e6}h3{font-size:15px;margin:24px 0 8px}\
.about{color:#5a636b;margin:2px 0}code{background:#f3f5f6;padding:1px 5px;border-radius:4px;\
font-size:13px;overflow-wrap:anywhere}\
.key{display:flex;flex-wrap:wrap;gap:4px 18px;margin:8px 0 12px;padding:0;list-style:none}\
.key svg{width:12px;height:12px;margin-right:6px;display:inline-block;vertical-align:-1px}\
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(370px,1fr));gap:16px}\
figure{margin:0}figcaption{font-weight:600;margin-bottom:2px}svg{width:100%;height:auto;\
display:block}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:13.5px;\
font-variant-numeric:tabular-nums;margin:6px 0}\
th{text-align:right;font-weight:600;color:#48525a;border-bottom:2px solid #c9d0d5;\
padding:6px 9px;vertical-align:bottom;max-width:110px}td{text-align:right;padding:5px 9px;\
border-bottom:1px solid #eceff1;white-space:nowrap}\
th:first-child,td:first-child{text-align:left}tr.base td{background:#f4f8fb}\
td.bad{color:#b3261e;font-weight:600;white-space:normal;min-width:170px}\
.note{color:#5a636b;font-size:13.5px;max-width:105ch;margin:6px 0}\
.pictures{display:grid;align-items:start;grid-template-columns:repeat(auto-fill,minmax(256px,1fr));gap:14px}\
.pictures figcaption{font-weight:400;font-size:13.5px;margin:0 0 3px;white-space:nowrap;overflow:hidden;text-overflow:ellipsis}\
.pictures img{width:100%;display:block;image-rendering:pixelated;border-radius:3px}\
.pictures img+img{margin-top:3px}details summary{cursor:pointer;color:#48525a;margin:14px 0 4px}";

/// One of the errors of a point.
type Error = fn(&Point) -> Option<f64>;

/// The page of a study.
#[must_use]
pub fn html(study: &Study, heading: &Heading) -> String {
    let title = escaped(&heading.title);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{title}</title>\n\
         <style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"about\">{}</p>\n<p class=\"about\"><code>{}</code></p>\n",
        escaped(&heading.machine),
        escaped(&heading.command)
    );
    for scene in &study.scenes {
        scene_section(&mut out, study, scene);
    }
    out.push_str("</body></html>\n");
    out
}

/// Text between tags or in an attribute.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

fn scene_section(out: &mut String, study: &Study, scene: &SceneStudy) {
    let (name, width, height) = (escaped(&scene.name), scene.width, scene.height);
    let _ = writeln!(out, "<h2>{name}, {width}×{height}</h2>\n<ul class=\"key\">");
    for (number, variant) in scene.variants.iter().enumerate() {
        let _ = writeln!(
            out,
            "<li>{}{}</li>",
            mark(number),
            escaped(&variant.variant.name)
        );
    }
    out.push_str("</ul>\n<div class=\"plots\">\n");
    let errors: [(&str, Error); 3] = [
        ("relMSE", |p| Some(p.rel_mse)),
        ("MSE", |p| Some(p.mse)),
        ("FLIP-HDR", |p| p.flip_hdr),
    ];
    for (name, error) in errors {
        let curves: Vec<Curve> = scene
            .variants
            .iter()
            .map(|variant| Curve {
                name: variant.variant.name.clone(),
                points: variant.curve(error),
            })
            .collect();
        let _ = writeln!(
            out,
            "<figure><figcaption>{name} against core seconds</figcaption>{}</figure>",
            plot(name, &curves)
        );
    }
    out.push_str("</div>\n<h3>Comparison</h3>\n");
    comparison_table(out, study, scene);
    for text in legend(scene, &study.baseline, study.seeds) {
        let _ = writeln!(out, "<p class=\"note\">{}</p>", escaped(&text));
    }
    pictures(out, scene);
    points_table(out, scene);
}

fn comparison_table(out: &mut String, study: &Study, scene: &SceneStudy) {
    out.push_str("<div class=\"wide\"><table><tr>");
    for column in COLUMNS {
        let _ = write!(out, "<th>{column}</th>");
    }
    out.push_str("</tr>\n");
    for row in comparison(scene, &study.baseline) {
        let base = row[0] == study.baseline;
        out.push_str(if base { "<tr class=\"base\">" } else { "<tr>" });
        for (column, cell) in row.iter().enumerate() {
            let bad =
                column == VERDICT && (cell.starts_with("failed") || cell.starts_with("BIASED"));
            let class = if bad { " class=\"bad\"" } else { "" };
            let _ = write!(out, "<td{class}>{}</td>", escaped(cell));
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</table></div>\n");
}

fn pictures(out: &mut String, scene: &SceneStudy) {
    out.push_str("<h3>Pictures</h3>\n<div class=\"pictures\">\n");
    let image = |png: &[u8], alt: &str| {
        format!(
            "<img alt=\"{}\" src=\"data:image/png;base64,{}\">",
            escaped(alt),
            base64(png)
        )
    };
    if !scene.reference_png.is_empty() {
        let picture = image(&scene.reference_png, "reference");
        let _ = writeln!(
            out,
            "<figure><figcaption>reference</figcaption>{picture}</figure>"
        );
    }
    for variant in &scene.variants {
        let (Some((picture, flip)), Some(last)) = (&variant.pictures, variant.points.last()) else {
            continue;
        };
        let name = &variant.variant.name;
        let flip_text = last
            .flip_hdr
            .map_or_else(String::new, |f| format!(", FLIP-HDR {}", short(f)));
        let _ = writeln!(
            out,
            "<figure><figcaption>{}, {} spp{flip_text}</figcaption>{}{}</figure>",
            escaped(name),
            last.spp,
            image(picture, name),
            if flip.is_empty() {
                String::new()
            } else {
                image(flip, "FLIP")
            }
        );
    }
    out.push_str(
        "</div>\n<p class=\"note\">One exposure for all, ACES curve; below each its FLIP-HDR map, \
         black 0 to pale yellow 1.</p>\n",
    );
}

fn points_table(out: &mut String, scene: &SceneStudy) {
    out.push_str(
        "<details><summary>All points and slopes</summary><div class=\"wide\"><table><tr>",
    );
    let names = [
        "variant",
        "spp",
        "core s",
        "s",
        "MSE",
        "relMSE",
        "FLIP-HDR",
        "MSE from halves",
        "slope MSE",
        "slope relMSE",
        "slope FLIP",
    ];
    for name in names {
        let _ = write!(out, "<th>{name}</th>");
    }
    out.push_str("</tr>\n");
    for variant in &scene.variants {
        let slope = |error: fn(&Point) -> Option<f64>| {
            fit(&variant.curve(error)).map_or_else(|| "-".to_owned(), |f| format!("{:.2}", f.slope))
        };
        let slopes = [
            slope(|p| Some(p.mse)),
            slope(|p| Some(p.rel_mse)),
            slope(|p| p.flip_hdr),
        ];
        for (number, p) in variant.points.iter().enumerate() {
            let first = number == 0;
            let cells = [
                escaped(&variant.variant.name),
                p.spp.to_string(),
                short(p.core_s),
                short(p.wall_s),
                short(p.mse),
                short(p.rel_mse),
                p.flip_hdr.map_or_else(|| "-".to_owned(), short),
                short(p.own_mse),
            ];
            let slopes = slopes
                .iter()
                .map(|s| if first { s.clone() } else { String::new() });
            out.push_str("<tr>");
            for cell in cells.into_iter().chain(slopes) {
                let _ = write!(out, "<td>{cell}</td>");
            }
            out.push_str("</tr>\n");
        }
    }
    out.push_str("</table></div></details>\n");
}
