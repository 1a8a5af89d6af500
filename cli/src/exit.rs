//! Exit codes and the errors behind them.

use shearwater_shared::api::{FailureKind, JobView, Problem};
use shearwater_shared::job::JobState;
use shearwater_shared::scene::SceneError;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// How the program ends. `--help` shows the same list ([`HELP`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Done.
    Ok = 0,
    /// The job failed or was cancelled, or this machine gave an error.
    Failure = 1,
    /// The scene or one of its files is wrong.
    Scene = 3,
    /// No coordinator answers.
    Unreachable = 4,
    /// The coordinator answers and says no.
    Refused = 5,
    /// Pictures differ by more than was allowed.
    Different = 6,
    /// Interrupted by a signal.
    Interrupted = 130,
}

/// The exit codes, for `--help`. 2 is clap's.
pub(crate) const HELP: &str = "\
Exit codes:
  0    done
  1    the job failed or was cancelled, or this machine gave an error
  2    wrong usage
  3    the scene or one of its files is wrong
  4    no coordinator answers
  5    the coordinator answers and says no
  6    compare: the pictures differ by more than was allowed
  130  interrupted";

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Everything that ends a command early.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// A scene or a file of it.
    #[error("{0}")]
    Scene(String),
    /// Nobody at the address.
    #[error(
        "no coordinator answers at {url}: {why}\nStart one with `shearwater coordinator`, or name another with --coordinator or SHEARWATER_COORDINATOR."
    )]
    Unreachable {
        /// Address.
        url: String,
        /// What the network said.
        why: String,
    },
    /// It is there and does not answer.
    #[error(
        "the coordinator at {url} has not answered for {seconds} s: it is frozen or overloaded, or the way to it is cut. Look at its log; what it has acknowledged is safe."
    )]
    Silent {
        /// Address.
        url: String,
        /// How long it was waited for.
        seconds: u64,
    },
    /// An address or credentials that cannot be used.
    #[error("coordinator {url}: {why}")]
    Address {
        /// Address.
        url: String,
        /// What is wrong.
        why: String,
    },
    /// The coordinator's own text.
    #[error("the coordinator refuses: {}: {}", .0.title, .0.detail)]
    Refused(Problem),
    /// Not an answer of ours.
    #[error("{url} does not answer as a Shearwater coordinator does: {why}")]
    Strange {
        /// Address.
        url: String,
        /// What came.
        why: String,
    },
    /// The job ended without a picture.
    #[error("{0}")]
    Job(String),
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The worker ended by itself.
    #[error(transparent)]
    Worker(#[from] shearwater_worker::WorkerError),
    /// The coordinator could not run.
    #[error("coordinator: {0}")]
    Coordinator(String),
    /// A picture cannot be read, or two do not fit together.
    #[error("{0}")]
    Picture(String),
    /// They do, and differ too much; what was found is printed already.
    #[error("the pictures differ: {0}")]
    Different(String),
    /// A report is written, but some variants are not in it.
    #[error("variants that could not be rendered:\n{0}")]
    Variants(String),
    /// A simulation that cannot be, or came to no end.
    #[error("simulation: {0}")]
    Simulation(String),
    /// A simulation ended, but not as it must; its report is printed already.
    #[error("the audit of the simulation found: {0}")]
    Audit(String),
    /// A signal came.
    #[error("interrupted")]
    Interrupted,
}

impl CliError {
    /// The exit code.
    pub(crate) const fn exit(&self) -> Exit {
        match self {
            Self::Scene(_) | Self::Variants(_) => Exit::Scene,
            Self::Unreachable { .. } | Self::Silent { .. } | Self::Address { .. } => {
                Exit::Unreachable
            }
            Self::Refused(_)
            | Self::Strange { .. }
            | Self::Worker(shearwater_worker::WorkerError::Refused { .. }) => Exit::Refused,
            Self::Interrupted => Exit::Interrupted,
            Self::Different(_) => Exit::Different,
            Self::Picture(_)
            | Self::Job(_)
            | Self::Io { .. }
            | Self::Simulation(_)
            | Self::Audit(_)
            | Self::Worker(_)
            | Self::Coordinator(_) => Exit::Failure,
        }
    }

    /// A stable name for programs.
    pub(crate) const fn kind(&self) -> &'static str {
        match self.exit() {
            Exit::Ok => "ok",
            Exit::Failure => "failure",
            Exit::Scene => "scene",
            Exit::Unreachable => "unreachable",
            Exit::Refused => "refused",
            Exit::Different => "different",
            Exit::Interrupted => "interrupted",
        }
    }

    /// An input or output error at `path`.
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }

    /// What an ended job means for who waited for it.
    pub(crate) fn of_job(job: &JobView) -> Result<(), Self> {
        let reason = job.failure.as_deref().unwrap_or("no reason was given");
        match job.state {
            JobState::Failed if job.failure_kind == Some(FailureKind::Scene) => {
                Err(Self::Scene(reason.to_owned()))
            }
            JobState::Failed => Err(Self::Job(format!("job {} failed: {reason}", job.id))),
            JobState::Cancelled => Err(Self::Job(format!("job {} was cancelled", job.id))),
            JobState::Queued | JobState::Running | JobState::Paused | JobState::Done => Ok(()),
        }
    }
}

impl From<SceneError> for CliError {
    fn from(error: SceneError) -> Self {
        Self::Scene(error.to_string())
    }
}
