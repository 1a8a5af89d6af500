//! Ways of sampling against the default: error and time, scene by scene.
//!
//! `cargo bench --bench sampling -- [--scenes a,b] [--variants text] [--size 128x64]
//! [--spp 16,64] [--samples 256] [--reference 4096]` prints Markdown tables, the
//! figures of docs/sampling.md. Each way is rendered in turn with the default, tile
//! by tile on one thread, with seeds of its own, so what else the machine does hits
//! both. Time is that of the thread on a core.

mod measure;
mod scenes;
mod variants;

use measure::{Measured, Reference, measure_pair, reference};
use serde_json::Value;
use shearwater_tracer::Stage;

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
    let mut head = String::from("| sampling | time |");
    for spp in &options.spp {
        head += &format!(" relMSE at {spp} | without the worst 0.1 % |");
    }
    println!("{head} efficiency |");
    println!("|{}", "---|".repeat(3 + 2 * options.spp.len()));
    let mut seed = 1;
    for variant in variants::all() {
        if !variant.to_string().contains(&options.variants) {
            continue;
        }
        let stage = scenes::stage(case, &variant)?;
        row(&base, &stage, &variant, &reference, options, &mut seed)?;
    }
    Ok(())
}

fn row(
    base: &Stage,
    stage: &Stage,
    variant: &Value,
    reference: &Reference,
    options: &Options,
    seed: &mut u64,
) -> Result<(), String> {
    let mut cells = String::new();
    let (mut time, mut efficiency) = ([0.0f64; 2], String::new());
    for &spp in &options.spp {
        let mut both = [Measured::default(), Measured::default()];
        for _ in 0..(options.samples / spp).max(1) {
            measure_pair(
                [base, stage],
                options.size,
                spp,
                *seed,
                reference,
                &mut both,
            )?;
            *seed += 2;
        }
        let ratio = measure::ratio(&both[1].squares, &both[0].squares);
        let trimmed = both[1].trimmed() / both[0].trimmed();
        cells += &format!(
            " {:.3e}, {:.3} ± {:.3} | {trimmed:.3} |",
            both[1].rel_mse(),
            ratio.0,
            ratio.1
        );
        for (sum, measured) in time.iter_mut().zip(&both) {
            *sum += measured.seconds;
        }
        efficiency = format!(
            "{:.3}",
            both[0].seconds / both[1].seconds / ratio.0.max(f64::MIN_POSITIVE)
        );
    }
    let name = variant["sampling"].to_string().replace('"', "");
    println!(
        "| {name} | {:.3} |{cells} {efficiency} |",
        time[1] / time[0]
    );
    Ok(())
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
