//! Every point as a line of comma-separated values (RFC 4180).

use crate::study::{Point, SceneStudy, Study, VariantStudy};

const HEADER: &str = "scene,variant,threads,seeds,width,height,spp,core_s,wall_s,mse,rel_mse,\
    flip_hdr,own_mse,mean_difference,weighted_difference,weighted_sigma,bad_samples,failure";

/// One line for each scene, variant and number of samples; variants that failed have one
/// line that says why.
#[must_use]
pub fn csv(study: &Study) -> String {
    let mut out = format!("{HEADER}\r\n");
    for scene in &study.scenes {
        for variant in &scene.variants {
            let head = head(study, scene, variant);
            for point in &variant.points {
                out.push_str(&format!("{head}{},\r\n", values(point)));
            }
            if let Some(failure) = &variant.failure {
                out.push_str(&format!("{head},,,,,,,,,,,{}\r\n", quoted(failure)));
            }
        }
    }
    out
}

fn head(study: &Study, scene: &SceneStudy, variant: &VariantStudy) -> String {
    format!(
        "{},{},{},{},{},{},",
        quoted(&scene.name),
        quoted(&variant.variant.name),
        variant.threads,
        study.seeds,
        scene.width,
        scene.height
    )
}

fn values(p: &Point) -> String {
    let flip = p.flip_hdr.map_or_else(String::new, |flip| flip.to_string());
    format!(
        "{},{},{},{},{},{flip},{},{},{},{},{}",
        p.spp,
        p.core_s,
        p.wall_s,
        p.mse,
        p.rel_mse,
        p.own_mse,
        p.mean_difference,
        p.weighted.mean,
        p.weighted.variance.sqrt(),
        p.bad
    )
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
