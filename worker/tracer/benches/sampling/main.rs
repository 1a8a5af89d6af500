//! Ways of sampling against the default: error and time, scene by scene.
//!
//! `cargo bench --bench sampling -- [--scenes a,b] [--variants text] [--size 128x64]
//! [--spp 16,64] [--samples 256] [--reference 4096]` prints Markdown tables, the
//! figures of docs/sampling.md. Groups of ways are rendered in turn with the
//! default, tile by tile on one thread, with seeds of their own, so what else the
//! machine does hits all. Time is that of the thread on a core.

mod measure;
mod scenes;
mod variants;

use measure::{Measured, measure_together, reference};
use serde_json::Value;
use shearwater_tracer::Stage;

/// Ways that are measured together with one run of the default.
const GROUP: usize = 5;

struct Options {
    scenes: Vec<String>,
    variants: String,
    size: (u32, u32),
    spp: Vec<u32>,
    /// Samples per pixel over all pictures of one count.
    samples: u32,
    reference: u32,
}

fn main() {
    let options = match options() {
        Ok(options) => options,
        Err(why) => {
            eprintln!("error: {why}");
            std::process::exit(1);
        }
    };
    for case in scenes::all() {
        if !options.scenes.is_empty() && !options.scenes.iter().any(|s| s == case.name) {
            continue;
        }
        if let Err(why) = run(&case, &options) {
            eprintln!("error: {}: {why}", case.name);
            std::process::exit(1);
        }
    }
}

fn run(case: &scenes::Case, options: &Options) -> Result<(), String> {
    let base = scenes::stage(case, &Value::Null)?;
    let reference = reference(&base, options.size, options.reference)?;
    println!(
        "\n### {}\n\n{}x{}, reference of {} samples (its own relMSE {:.2e})\n",
        case.name, options.size.0, options.size.1, options.reference, reference.rel_mse
    );
    let wanted: Vec<Value> = variants::all()
        .into_iter()
        .filter(|variant| variant.to_string().contains(&options.variants))
        .collect();
    // The default's errors, of all groups together: by count of samples.
    let mut pooled: Vec<Vec<f64>> = vec![Vec::new(); options.spp.len()];
    let (mut rows, mut seed) = (Vec::new(), 1);
    for group in wanted.chunks(GROUP) {
        let built: Vec<Stage> = group
            .iter()
            .map(|variant| scenes::stage(case, variant))
            .collect::<Result<_, _>>()?;
        let stages: Vec<&Stage> = std::iter::once(&base).chain(&built).collect();
        let mut results: Vec<Vec<(f64, Vec<f64>)>> = vec![Vec::new(); group.len()];
        for (&spp, pooled) in options.spp.iter().zip(&mut pooled) {
            let mut found: Vec<Measured> = stages.iter().map(|_| Measured::default()).collect();
            for _ in 0..(options.samples / spp).max(1) {
                measure_together(&stages, options.size, spp, seed, &reference, &mut found)?;
                seed += stages.len() as u64;
            }
            let of_base = found.remove(0);
            for (result, found) in results.iter_mut().zip(found) {
                result.push((found.seconds / of_base.seconds, found.squares));
            }
            pooled.extend(of_base.squares);
        }
        let names = group
            .iter()
            .map(|variant| variant["sampling"].to_string().replace('"', ""));
        rows.extend(names.zip(results));
        eprintln!("{}: {} of {}", case.name, rows.len(), wanted.len());
    }
    print_table(&options.spp, &pooled, &rows);
    Ok(())
}

/// A way of sampling: for each count of samples its time over the default's, and
/// its squared errors.
type Row = (String, Vec<(f64, Vec<f64>)>);

// Every figure is a ratio to the default's: time, error, error without the worst
// pixels. Efficiency is 1 / (error x time) at the largest count.
fn print_table(spp: &[u32], pooled: &[Vec<f64>], rows: &[Row]) {
    let mut head = String::from("| sampling | time |");
    let mut first = String::from("| default | 1 |");
    for (spp, squares) in spp.iter().zip(pooled) {
        head += &format!(" relMSE at {spp} | without the worst 0.1 % |");
        first += &format!(
            " {:.3e} | {:.3e} |",
            measure::mean(squares),
            measure::trimmed(squares)
        );
    }
    println!("{head} efficiency |\n|{}", "---|".repeat(3 + 2 * spp.len()));
    println!("{first} 1 |");
    for (name, row) in rows {
        let times: f64 = row.iter().map(|(time, _)| time).sum();
        let time = times / row.len() as f64;
        let (mut cells, mut efficiency) = (String::new(), 0.0);
        for ((_, squares), base) in row.iter().zip(pooled) {
            let (ratio, error) = measure::ratio(squares, base);
            let trimmed = measure::trimmed(squares) / measure::trimmed(base);
            cells += &format!(" {ratio:.3} ± {error:.3} | {trimmed:.3} |");
            efficiency = 1.0 / (time * ratio);
        }
        println!("| `{name}` | {time:.3} |{cells} {efficiency:.2} |");
    }
}

fn options() -> Result<Options, String> {
    let mut options = Options {
        scenes: Vec::new(),
        variants: String::new(),
        size: (128, 64),
        spp: vec![16, 64],
        samples: 256,
        reference: 4096,
    };
    let mut args = std::env::args().skip(1).filter(|arg| arg != "--bench");
    while let Some(arg) = args.next() {
        let value = args.next().ok_or(format!("{arg} needs a value"))?;
        let number = |text: &str| {
            text.parse::<u32>()
                .map_err(|e| format!("{arg} {text}: {e}"))
        };
        match arg.as_str() {
            "--scenes" => options.scenes = value.split(',').map(str::to_owned).collect(),
            "--variants" => options.variants = value,
            "--size" => {
                let (w, h) = value.split_once('x').ok_or("--size WIDTHxHEIGHT")?;
                options.size = (number(w)?, number(h)?);
            }
            "--spp" => options.spp = value.split(',').map(number).collect::<Result<_, _>>()?,
            "--samples" => options.samples = number(&value)?,
            "--reference" => options.reference = number(&value)?,
            _ => return Err(format!("unknown option {arg}")),
        }
    }
    Ok(options)
}
