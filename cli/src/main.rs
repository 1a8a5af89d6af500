//! `shearwater`: a render farm in one binary.
//!
//! Nothing is decided here: every subcommand joins coordinator, worker and the
//! public API, and shows what they say. [`exit`] lists the exit codes.

mod access;
mod api;
mod args;
mod commands;
mod error_text;
mod exit;
mod follow;
mod frames;
mod json_paths;
mod logging;
mod machine;
mod memory;
mod open_files;
mod output;
mod scene_files;
mod signals;
mod simulation;
mod video;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = args::Cli::parse();
    logging::start(
        cli.global.verbose,
        cli.command.log_kind(),
        cli.global.log_format,
    );
    // The one cryptography of every TLS connection; refused only when it is set already.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let runtime = match tokio::runtime::Runtime::new() {
        Ok(runtime) => runtime,
        Err(error) => {
            eprintln!("error: cannot start: {error}");
            return exit::Exit::Failure.into();
        }
    };
    let result = runtime.block_on(commands::run(&cli));
    // A scene that is still being built is nobody's concern any more.
    runtime.shutdown_background();
    match result {
        Ok(()) => exit::Exit::Ok.into(),
        Err(error) => {
            output::error(&error, cli.global.json);
            error.exit().into()
        }
    }
}
