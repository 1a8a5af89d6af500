//! The table of the calibration, printed and written into docs/error.md.

use crate::Form;
use crate::measure::{Measured, Ratio};
use std::fmt::Write;
use std::path::Path;

const BEGIN: &str = "<!-- calibration: written by tests/calibration -->\n";
const END: &str = "<!-- end of calibration -->\n";

/// Print the table; in the full form put it into docs/error.md.
pub(crate) fn write(rows: &[(&str, Vec<Measured>)], form: &Form, keep: bool) {
    let table = table(rows, form);
    println!("{table}");
    if !keep {
        return;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/error.md");
    let text = std::fs::read_to_string(&path).expect("docs/error.md");
    let (before, rest) = text.split_once(BEGIN).expect("where the table begins");
    let (_, after) = rest.split_once(END).expect("where the table ends");
    let text = format!("{before}{BEGIN}{table}{END}{after}");
    std::fs::write(&path, text).expect("docs/error.md can be written");
}

fn table(rows: &[(&str, Vec<Measured>)], form: &Form) -> String {
    let mut text = format!(
        "{} seeds for each row, {side} x {side} pixels, reference of {} times the samples of the largest.\n\n\
         | scene | samples | true NMSE | MSE | NMSE | relMSE | mean in its interval | fireflies |\n\
         |---|---|---|---|---|---|---|---|\n",
        form.seeds,
        form.reference,
        side = crate::scenes::SIDE
    );
    let ratio = |r: &Ratio| format!("{:.3} ± {:.3}", r.value, r.error);
    for (name, measured) in rows {
        for row in measured {
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "| {name} | {} | {:.2e} | {} | {} | {} | {:.1} % | {:.2} % |",
                row.samples,
                row.true_nmse,
                ratio(&row.mse),
                ratio(&row.nmse),
                ratio(&row.relmse),
                100.0 * row.covered,
                100.0 * row.fireflies
            );
        }
    }
    text
}
