//! Logs, on standard error.

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

/// Start logging. `RUST_LOG` overrides everything.
pub(crate) fn start(verbose: u8, kind: Kind) {
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
    let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    // Fails only when a log is installed already; then there is nothing to do.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(colour)
        .with_writer(std::io::stderr)
        .try_init();
}
