//! Logs, on standard error.

use std::io::IsTerminal;
use tracing_subscriber::EnvFilter;

/// Start logging. `RUST_LOG` overrides everything.
pub(crate) fn start(verbose: u8, service: bool) {
    let level = match (verbose, service) {
        (0, false) => "warn",
        (0, true) | (1, false) => "info",
        (1, true) | (2, false) => "debug",
        _ => "trace",
    };
    let own = ["shearwater", "shearwater_worker", "shearwater_coordinator"];
    let directives: Vec<_> = own.iter().map(|own| format!("{own}={level}")).collect();
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
