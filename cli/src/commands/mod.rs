//! One file for each subcommand.

pub(crate) mod add;
pub(crate) mod cancel;
pub(crate) mod compare;
pub(crate) mod coordinator;
pub(crate) mod download;
pub(crate) mod export;
pub(crate) mod gc;
pub(crate) mod jobs;
pub(crate) mod log;
pub(crate) mod pause;
pub(crate) mod priority;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod resume;
pub(crate) mod retry;
pub(crate) mod simulate;
pub(crate) mod status;
pub(crate) mod submit;
pub(crate) mod token;
pub(crate) mod watch;
pub(crate) mod water;
pub(crate) mod worker;
pub(crate) mod workers;

use crate::args::{Cli, Command};
use crate::exit::CliError;
use crate::output;

/// Do what the command line says.
pub(crate) async fn run(cli: &Cli) -> Result<(), CliError> {
    let json = cli.global.json;
    match &cli.command {
        Command::Render(args) => render::run(args, json).await,
        Command::Coordinator(args) => coordinator::run(args, json).await,
        Command::Worker(args) => worker::run(args, json).await,
        Command::Submit(args) => submit::run(args, json).await,
        Command::Status(args) => status::run(args, json).await,
        Command::Watch(args) => watch::run(args, json).await,
        Command::Add(args) => add::run(args, json).await,
        Command::Download(args) => download::run(args, json).await,
        Command::Cancel(args) => cancel::run(args, json).await,
        Command::Jobs(args) => jobs::run(args, json).await,
        Command::Token(args) => token::run(args, json).await,
        Command::Pause(args) => pause::run(args, json).await,
        Command::Resume(args) => resume::run(args, json).await,
        Command::Retry(args) => retry::run(args, json).await,
        Command::Priority(args) => priority::run(args, json).await,
        Command::Log(args) => log::run(args, json).await,
        Command::Workers(args) => workers::run(args, json).await,
        Command::Compare(args) => compare::run(args, json),
        Command::Report(args) => report::run(args, json).await,
        Command::Water(args) => water::run(args, json),
        Command::Export(args) => export::run(args, json).await,
        Command::Gc(args) => gc::run(args, json).await,
        Command::Simulate(args) => simulate::run(args, json).await,
        Command::Schema => {
            output::line(shearwater_shared::scene::schema_json().trim_end());
            Ok(())
        }
    }
}
