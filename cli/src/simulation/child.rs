//! A coordinator of the simulation's own, in a process of its own: what it needs is
//! measured apart from what the workers need.

use crate::exit::CliError;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};

/// A coordinator opens its stores and makes its tables within this time.
const START_TIMEOUT: Duration = Duration::from_secs(60);
/// It ends by itself within ten seconds of being told.
const END_TIMEOUT: Duration = Duration::from_secs(20);
/// Bytes of its log that are shown when it fails.
const LOG_SHOWN_BYTES: usize = 2000;

/// A coordinator that ends with the simulation.
#[derive(Debug)]
pub(crate) struct OwnCoordinator {
    child: Child,
    log: PathBuf,
    /// Where it listens.
    pub(crate) url: String,
    /// Number of its process.
    pub(crate) pid: u32,
}

/// What the coordinator is started with.
#[derive(Debug)]
pub(crate) struct Start<'a> {
    /// Its data folder.
    pub(crate) data: &'a Path,
    /// Its database; through the environment, since it may hold a password.
    pub(crate) database: Option<&'a str>,
    /// Its object store.
    pub(crate) objects: Option<&'a str>,
    /// Another build of this program; none is this one.
    pub(crate) program: Option<&'a Path>,
    /// Share of the runs that are rendered again.
    pub(crate) audit: Option<f64>,
}

impl OwnCoordinator {
    /// Start a coordinator on a free local port. Its log goes to a file in its folder.
    pub(crate) async fn start(start: Start<'_>) -> Result<Self, CliError> {
        let failed = |why: String| CliError::Coordinator(why);
        let program = match start.program {
            Some(program) => Ok(program.to_owned()),
            None => std::env::current_exe(),
        };
        let program = program.map_err(|e| failed(e.to_string()))?;
        std::fs::create_dir_all(start.data).map_err(CliError::io(start.data))?;
        let log_path = start.data.join("coordinator.log");
        let log = std::fs::File::create(&log_path).map_err(CliError::io(&log_path))?;
        let mut command = Command::new(program);
        command
            .args(["coordinator", "--json", "--listen", "127.0.0.1:0", "--data"])
            .arg(start.data)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(log)
            .kill_on_drop(true);
        if let Some(database) = start.database {
            command.env("SHEARWATER_DATABASE", database);
        }
        if let Some(objects) = start.objects {
            command.args(["--objects", objects]);
        }
        if let Some(audit) = start.audit {
            command.args(["--audit", &audit.to_string()]);
        }
        let mut child = command.spawn().map_err(|e| failed(e.to_string()))?;
        let url = tokio::time::timeout(START_TIMEOUT, url_of(&mut child)).await;
        let url = url.unwrap_or_else(|_| Err("it does not say where it listens".to_owned()));
        let url = url.map_err(|why| failed(format!("{why}\n{}", end_of(&log_path))))?;
        let pid = child.id().ok_or_else(|| failed("it has ended".into()))?;
        Ok(Self {
            child,
            log: log_path,
            url,
            pid,
        })
    }

    /// Fails when it has ended by itself.
    pub(crate) fn check(&mut self) -> Result<(), CliError> {
        match self.child.try_wait() {
            Ok(Some(status)) => Err(CliError::Coordinator(format!(
                "it ended by itself ({status})\n{}",
                end_of(&self.log)
            ))),
            _ => Ok(()),
        }
    }

    /// Ask it to end, and wait.
    pub(crate) async fn end(mut self) {
        let pid = i32::try_from(self.pid).ok().and_then(Pid::from_raw);
        if let Some(pid) = pid {
            // It may have ended.
            let _ = kill_process(pid, Signal::TERM);
        }
        if tokio::time::timeout(END_TIMEOUT, self.child.wait())
            .await
            .is_err()
        {
            let _ = self.child.kill().await;
        }
    }
}

/// The address in the first line of its output.
async fn url_of(child: &mut Child) -> Result<String, String> {
    let output = child.stdout.take().ok_or("it has no output")?;
    let mut line = String::new();
    let read = BufReader::new(output).read_line(&mut line).await;
    read.map_err(|e| e.to_string())?;
    let said: Value = serde_json::from_str(&line).map_err(|_| "it does not start".to_owned())?;
    let url = said["url"].as_str().ok_or("it does not start")?;
    Ok(url.to_owned())
}

fn end_of(log: &Path) -> String {
    let text = std::fs::read(log).unwrap_or_default();
    let from = text.len().saturating_sub(LOG_SHOWN_BYTES);
    String::from_utf8_lossy(text.get(from..).unwrap_or_default()).into_owned()
}
