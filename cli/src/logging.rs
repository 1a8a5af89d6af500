//! Logs, on standard error.

use clap::ValueEnum;
use std::io::IsTerminal;
use tracing_subscriber::EnvFilter;

/// What a command has to log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Little: its output says the rest.
    Client,
    /// It runs until it is stopped, so that its log is what it has to say.
    Service,
    /// A client with thousands of workers, each of which would say the same.
    Crowd,
}

/// How a line of the log looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogFormat {
    /// For people.
    #[default]
    Text,
    /// One JSON object in a line, for programs.
    Json,
}

/// Start logging. `RUST_LOG` overrides everything but the format.
pub(crate) fn start(verbose: u8, kind: Kind, format: LogFormat) {
    let service = kind == Kind::Service;
    let level = match (verbose, service) {
        (0, false) => "warn",
        (0, true) | (1, false) => "info",
        (1, true) | (2, false) => "debug",
        _ => "trace",
    };
    let own = ["shearwater", "shearwater_worker", "shearwater_coordinator"];
    let mut directives: Vec<_> = own.iter().map(|own| format!("{own}={level}")).collect();
    if kind == Kind::Crowd && verbose < 2 {
        // Of equal directives the last one counts.
        directives.push("shearwater_worker=error".to_owned());
    }
    let filter = EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| EnvFilter::new(format!("warn,{}", directives.join(","))));
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr);
    // Fails only when a log is installed already; then there is nothing to do.
    let _ = match format {
        LogFormat::Text => {
            let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            log.with_ansi(colour).try_init()
        }
        // Fields beside level and message; those of what a line belongs to (request, unit)
        // in the list `spans`, outermost first.
        LogFormat::Json => log
            .json()
            .flatten_event(true)
            .with_current_span(false)
            .with_span_list(true)
            .try_init(),
    };
}
