//! Log-log plots as SVG.

use super::numbers::short;
use crate::study::fit;
use std::fmt::Write;

/// One curve: name and points (seconds, error).
pub(super) struct Curve {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
}

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;

/// Okabe and Ito's colours, which colour-blind people tell apart; yellow is left out,
/// since it is invisible on white.
const COLOURS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#222222",
];

/// The colour of curve `number`.
const fn colour(number: usize) -> &'static str {
    COLOURS[number % COLOURS.len()]
}

/// Range of an axis in powers of ten.
struct Axis {
    low: f64,
    high: f64,
    /// Pixel of `low` and of `high`.
    at: (f64, f64),
}

impl Axis {
    /// Around `values`, with a little room; at least a third of a decade.
    fn around(values: impl Iterator<Item = f64>, at: (f64, f64)) -> Option<Self> {
        let logs: Vec<f64> = values.filter(|v| *v > 0.0).map(libm::log10).collect();
        let low = logs.iter().copied().reduce(f64::min)?;
        let high = logs.iter().copied().reduce(f64::max)?;
        let room = (0.06 * (high - low)).max(0.17);
        Some(Self {
            low: low - room,
            high: high + room,
            at,
        })
    }

    fn pixel(&self, value: f64) -> f64 {
        let share = (libm::log10(value) - self.low) / (self.high - self.low);
        self.at.0 + share * (self.at.1 - self.at.0)
    }

    /// Values with a line, and whether they have a number too.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let few = self.high - self.low < 2.2;
        let mut ticks = Vec::new();
        for power in self.low.floor() as i32..=self.high.ceil() as i32 {
            let decade = libm::exp10(power.into());
            for step in 1..10 {
                let value = decade * f64::from(step);
                let log = libm::log10(value);
                if (self.low..=self.high).contains(&log) {
                    ticks.push((value, step == 1 || few && matches!(step, 2 | 5)));
                }
            }
        }
        ticks
    }
}

/// A plot of `curves`; `y` names the vertical axis. Each curve has its fitted line,
/// dashed. Empty when there is nothing to draw.
pub(super) fn plot(y: &str, curves: &[Curve]) -> String {
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let x_axis = Axis::around(all().map(|p| p.0), (LEFT, WIDTH - RIGHT));
    let y_axis = Axis::around(all().map(|p| p.1), (HEIGHT - BOTTOM, TOP));
    let (Some(x_axis), Some(y_axis)) = (x_axis, y_axis) else {
        return String::new();
    };
    let mut out = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{y} against core \
         seconds\" xmlns=\"http://www.w3.org/2000/svg\" font-family=\"system-ui, sans-serif\" \
         font-size=\"14\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n"
    );
    grid(&mut out, &x_axis, &y_axis);
    let middle = (LEFT + WIDTH - RIGHT) / 2.0;
    let half = (TOP + HEIGHT - BOTTOM) / 2.0;
    let _ = write!(
        out,
        "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\" fill=\"#333\">core seconds</text>\n\
         <text transform=\"translate(14 {half}) rotate(-90)\" text-anchor=\"middle\" \
         fill=\"#333\">{y}</text>\n",
        HEIGHT - 8.0
    );
    for (number, curve) in curves.iter().enumerate() {
        draw(&mut out, &x_axis, &y_axis, curve, number);
    }
    out.push_str("</svg>\n");
    out
}

fn grid(out: &mut String, x: &Axis, y: &Axis) {
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    let colour = |value: f64| {
        let log = libm::log10(value);
        if (log - libm::round(log)).abs() < 1e-9 {
            "#c4c8cc"
        } else {
            "#eceef0"
        }
    };
    for (value, named) in x.ticks() {
        let at = x.pixel(value);
        let _ = writeln!(
            out,
            "<path d=\"M{at:.1} {TOP}V{bottom}\" stroke=\"{}\"/>",
            colour(value)
        );
        if named {
            let _ = writeln!(
                out,
                "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\" fill=\"#555\">{}</text>",
                bottom + 16.0,
                tick(value)
            );
        }
    }
    for (value, named) in y.ticks() {
        let at = y.pixel(value);
        let _ = writeln!(
            out,
            "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"{}\"/>",
            colour(value)
        );
        if named {
            let _ = writeln!(
                out,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#555\">{}</text>",
                LEFT - 6.0,
                at + 4.0,
                tick(value)
            );
        }
    }
    let _ = writeln!(
        out,
        "<path d=\"M{LEFT} {TOP}V{bottom}H{right}\" fill=\"none\" stroke=\"#888\"/>"
    );
}

/// A number at an axis, as short as it can be.
fn tick(value: f64) -> String {
    if (0.0099..10_000.0).contains(&value) {
        format!("{}", libm::round(value * 1e6) / 1e6)
    } else {
        format!("{value:.0e}")
    }
}

fn draw(out: &mut String, x: &Axis, y: &Axis, curve: &Curve, number: usize) {
    let usable = curve.points.iter().filter(|p| p.0 > 0.0 && p.1 > 0.0);
    let at: Vec<(f64, f64)> = usable.map(|p| (x.pixel(p.0), y.pixel(p.1))).collect();
    let colour = colour(number);
    let path: Vec<String> = at.iter().map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
    let _ = writeln!(
        out,
        "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\"/>",
        path.join("L")
    );
    if let Some(line) = fit(&curve.points) {
        let value = |seconds: f64| libm::exp(line.intercept + line.slope * libm::log(seconds));
        let ends = [curve.points.first(), curve.points.last()].map(|p| p.map_or(1.0, |p| p.0));
        let [a, b] = ends.map(|seconds| (x.pixel(seconds), y.pixel(value(seconds))));
        let _ = writeln!(
            out,
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"{colour}\" stroke-dasharray=\"3 4\" \
             opacity=\"0.6\"/>",
            a.0, a.1, b.0, b.1
        );
    }
    let _ = writeln!(out, "<g fill=\"{colour}\" stroke=\"#fff\">");
    for ((px, py), (seconds, error)) in at.iter().zip(&curve.points) {
        let _ = writeln!(
            out,
            "{}<title>{}: {} core s, {}</title>{}",
            opening(number, *px, *py),
            super::html::escaped(&curve.name),
            short(*seconds),
            short(*error),
            closing(number)
        );
    }
    out.push_str("</g>\n");
}

/// The mark of curve `number`, for a key.
pub(super) fn mark(number: usize) -> String {
    format!(
        "<svg viewBox=\"0 0 12 12\" fill=\"{}\">{}{}</svg>",
        colour(number),
        opening(number, 6.0, 6.0),
        closing(number)
    )
}

/// Another shape for each round of colours.
fn opening(number: usize, x: f64, y: f64) -> String {
    match number / COLOURS.len() {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\">"),
        1 => format!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"8\" height=\"8\">",
            x - 4.0,
            y - 4.0
        ),
        _ => format!("<path d=\"M{x:.1} {:.1}l5 9h-10z\">", y - 5.0),
    }
}

const fn closing(number: usize) -> &'static str {
    match number / COLOURS.len() {
        0 => "</circle>",
        1 => "</rect>",
        _ => "</path>",
    }
}
