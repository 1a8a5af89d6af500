//! `shearwater report`.

use crate::args::{Size, parse_spp};
use crate::exit::CliError;
use crate::{machine, output, scene_files, signals};
use clap::Args;
use serde_json::json;
use shearwater_report::output::{Heading, csv, html, markdown};
use shearwater_report::picture::Picture;
use shearwater_report::study::{
    COUNTS_MAX, Load, Loaded, Options, REFERENCE_FACTOR, SEEDS_MAX, SceneFile, Store, Study,
    StudyError, Told, run_study,
};
use shearwater_report::variants::{Variant, parse_variants};
use shearwater_shared::limits;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Measure speed against error
///
/// Renders each scene, and each variant of it, to rising numbers of samples, and holds the
/// pictures against a reference: report.html (plots, tables, pictures in one file),
/// report.csv, report.md. What is finished is kept in DIR/data, so that a run that was
/// interrupted, or gets more samples, goes on where it was.
///
/// Variants are a JSON list: `[{"name": "independent", "scene": {"sampling": {"sampler":
/// "independent"}}}]`, where `scene` is a merge patch (RFC 7396); `set` takes JSON pointers
/// in which `*` stands for every element; `threads`, `tile`, `block` say how to render;
/// `own_reference` is for variants that show another picture on purpose.
///
/// Example: shearwater report scenes/golden-gate --against scenes/variants/sampling.json --size 256x128 -o out
#[derive(Args, Debug, Clone)]
pub(crate) struct Report {
    /// scene.json, or the folder that holds it
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// JSON list of variants [default: the scene alone]
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
    /// Variant that others are compared with [default: the scene as it is]
    #[arg(long, value_name = "NAME")]
    baseline: Option<String>,
    /// Folder to write to; made if need be
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    /// Samples per pixel, rising
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', value_parser = parse_spp, default_values_t = [16, 64, 256])]
    spp: Vec<u32>,
    /// Size of the pictures [default: the scene's]
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    size: Option<Size>,
    /// A reference of your own, for one scene [default: rendered with another seed]
    #[arg(long, value_name = "FILE.exr")]
    reference: Option<PathBuf>,
    /// Samples per pixel of rendered references [default: 64 times the most of --spp]
    #[arg(long, value_name = "N", value_parser = parse_spp)]
    reference_spp: Option<u32>,
    /// Seeds that are averaged
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(SEEDS_MAX)))]
    seeds: u32,
    /// Threads that render, where a variant names none [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Title of the page
    #[arg(long, value_name = "TEXT", default_value = "Speed against error")]
    title: String,
}

pub(crate) async fn run(args: &Report, json: bool) -> Result<(), CliError> {
    let interrupted = signals::asked_to_end();
    let options = options(args)?;
    std::fs::create_dir_all(&args.output).map_err(CliError::io(&args.output))?;
    let cancel = Arc::new(AtomicBool::new(false));
    let mut work = tokio::task::spawn_blocking({
        let (cancel, data) = (cancel.clone(), args.output.join("data"));
        let files: Vec<PathBuf> = args
            .scenes
            .iter()
            .map(|s| scene_files::scene_file(s))
            .collect();
        move || study(&options, &files, &data, &cancel)
    });
    let ended = tokio::select! {
        ended = &mut work => ended,
        () = interrupted => {
            cancel.store(true, Ordering::Relaxed);
            work.await
        }
    };
    let study = match ended {
        Ok(Ok(study)) => study,
        Ok(Err(CliError::Interrupted)) => {
            let data = args.output.join("data");
            output::note(format_args!(
                "what is finished is kept in {}; the same command goes on from there",
                data.display()
            ));
            return Err(CliError::Interrupted);
        }
        Ok(Err(error)) => return Err(error),
        Err(panic) => return Err(CliError::Job(format!("the report failed: {panic}"))),
    };
    let files = write(args, &study)?;
    if json {
        output::object(&json!({ "study": study, "files": files }));
    } else {
        for file in files {
            output::line(file.display());
        }
    }
    failures(&study)
}

/// What the command line asks for.
fn options(args: &Report) -> Result<Options, CliError> {
    let wrong = |text: String| Err(CliError::Scene(text));
    let mut counts = args.spp.clone();
    counts.sort_unstable();
    counts.dedup();
    if counts.len() > COUNTS_MAX {
        return wrong(format!(
            "--spp: {} numbers: at most {COUNTS_MAX}",
            counts.len()
        ));
    }
    let most = counts.last().copied().unwrap_or(2);
    let reference_spp = args.reference_spp.unwrap_or_else(|| {
        most.saturating_mul(REFERENCE_FACTOR)
            .min(limits::SAMPLES_MAX)
    });
    if args.reference.is_some() && args.scenes.len() > 1 {
        return wrong("--reference is for one scene".to_owned());
    }
    let mut scenes = Vec::new();
    for path in &args.scenes {
        let file = scene_files::scene_file(path);
        scenes.push(SceneFile {
            file: file.display().to_string(),
            bytes: scene_files::read_scene(&file)?,
        });
    }
    let (variants, baseline) = variants(args)?;
    let reference = args.reference.as_ref().map(|path| {
        let picture = Picture::read(path).map_err(|e| CliError::Picture(e.to_string()));
        picture.map(|picture| (path.display().to_string(), picture))
    });
    Ok(Options {
        scenes,
        variants,
        baseline,
        size: args.size.map(|size| (size.width, size.height)),
        counts,
        seeds: args.seeds,
        threads: args.threads.unwrap_or_else(cores),
        reference_spp,
        reference: reference.transpose()?,
    })
}

fn cores() -> u16 {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    u16::try_from(cores).unwrap_or(u16::MAX).min(1024)
}

/// The list, and the name of the baseline; the unchanged scene goes before the rest where
/// nobody names one.
fn variants(args: &Report) -> Result<(Vec<Variant>, String), CliError> {
    const AS_IT_IS: &str = "as it is";
    let mut list = match &args.against {
        Some(path) => {
            let bytes = std::fs::read(path).map_err(CliError::io(path))?;
            parse_variants(&path.display().to_string(), &bytes)
                .map_err(|e| CliError::Scene(e.to_string()))?
        }
        None => Vec::new(),
    };
    if let Some(name) = &args.baseline {
        if list.iter().any(|variant| variant.name == *name) {
            return Ok((list, name.clone()));
        }
        let message = format!("--baseline: no variant is called `{name}`");
        return Err(CliError::Scene(message));
    }
    let unchanged = |variant: &&Variant| {
        let named = Variant {
            name: variant.name.clone(),
            ..Variant::default()
        };
        **variant == named
    };
    if let Some(variant) = list.iter().find(unchanged) {
        let name = variant.name.clone();
        return Ok((list, name));
    }
    let name = AS_IT_IS.to_owned();
    list.insert(
        0,
        Variant {
            name: name.clone(),
            ..Variant::default()
        },
    );
    Ok((list, name))
}

fn study(
    options: &Options,
    files: &[PathBuf],
    data: &Path,
    cancel: &AtomicBool,
) -> Result<Study, CliError> {
    let store = Store::open(data).map_err(|e| CliError::Job(e.to_string()))?;
    let load: &Load<'_> = &|number, bytes| {
        let file = files.get(number).ok_or("no such scene")?;
        let bundle = scene_files::collect_bytes(bytes, file).map_err(|e| e.to_string())?;
        let assets = bundle.assets().map_err(|e| e.to_string())?;
        Ok(Loaded {
            description: bundle.description,
            assets,
        })
    };
    run_study(options, load, &store, cancel, &mut tell).map_err(|error| match error {
        StudyError::Cancelled => CliError::Interrupted,
        StudyError::Scene(text) => CliError::Scene(text),
        StudyError::Store(error) => CliError::Job(error.to_string()),
    })
}

/// One line for what is finished; on a terminal a last line that changes.
fn tell(told: &Told<'_>) {
    let mut stderr = std::io::stderr();
    let terminal = stderr.is_terminal();
    if !told.milestone && !terminal {
        return;
    }
    let left = told.left_s.map_or_else(String::new, |left| {
        format!(", {} left", output::duration(left))
    });
    let percent = 100.0 * told.share;
    let (clear, end) = match (terminal, told.milestone) {
        (true, true) => ("\r\x1b[2K", "\n"),
        (true, false) => ("\r\x1b[2K", ""),
        (false, _) => ("", "\n"),
    };
    // Nobody who reads it is no reason to stop.
    let _ = write!(stderr, "{clear}[{percent:3.0} %{left}] {}{end}", told.text);
    let _ = stderr.flush();
}

fn write(args: &Report, study: &Study) -> Result<Vec<PathBuf>, CliError> {
    let heading = Heading {
        title: args.title.clone(),
        command: command(),
        machine: machine::machine(),
    };
    let mut files = Vec::new();
    for (name, text) in [
        ("report.html", html(study, &heading)),
        ("report.csv", csv(study)),
        ("report.md", markdown(study, &heading)),
    ] {
        let path = args.output.join(name);
        std::fs::write(&path, text).map_err(CliError::io(&path))?;
        files.push(path);
    }
    Ok(files)
}

/// The command as it was given, with the program's bare name.
fn command() -> String {
    let quoted = |arg: String| {
        let plain = |c: char| c.is_alphanumeric() || "-_./,=:".contains(c);
        if arg.chars().all(plain) && !arg.is_empty() {
            arg
        } else {
            format!("'{}'", arg.replace('\'', "'\\''"))
        }
    };
    let args = std::env::args_os().skip(1);
    let args = args.map(|arg| quoted(arg.to_string_lossy().into_owned()));
    let words: Vec<String> = std::iter::once("shearwater".to_owned())
        .chain(args)
        .collect();
    words.join(" ")
}

fn failures(study: &Study) -> Result<(), CliError> {
    let mut lines = Vec::new();
    for scene in &study.scenes {
        for variant in &scene.variants {
            if let Some(failure) = &variant.failure {
                lines.push(format!(
                    "{} / {}: {failure}",
                    scene.name, variant.variant.name
                ));
            }
        }
    }
    if lines.is_empty() {
        return Ok(());
    }
    Err(CliError::Variants(lines.join("\n")))
}
