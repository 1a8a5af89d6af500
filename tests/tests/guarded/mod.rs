//! A coordinator with options of its own, on a store of its own.

#![allow(dead_code, reason = "each test binary uses its own part")]

use crate::common::process::{Ended, Process, command};
use crate::common::{scene, until};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) struct Guarded {
    pub(crate) url: String,
    pub(crate) process: Process,
    pub(crate) data: PathBuf,
    pub(crate) folder: tempfile::TempDir,
}

/// A folder whose `data` holds a store with a token for each role, and the tokens.
pub(crate) fn folder_with_tokens() -> (tempfile::TempDir, [String; 3]) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let data = folder.path().join("data");
    let tokens = ["admin", "client", "worker"].map(|role| token(&data, &["--role", role]));
    (folder, tokens)
}

/// Make a token.
pub(crate) fn token(data: &Path, options: &[&str]) -> String {
    let mut command = command(["token", "create", "--json", "--data"]);
    let made = Process::start(command.arg(data).args(options)).end().ok();
    text(&made.json()["token"])
}

/// A JSON text.
pub(crate) fn text(value: &Value) -> String {
    value
        .as_str()
        .unwrap_or_else(|| panic!("{value}"))
        .to_owned()
}

impl Guarded {
    /// Start it on loopback.
    pub(crate) fn start(folder: tempfile::TempDir, options: &[&str]) -> Self {
        Self::listening(folder, "127.0.0.1:0", options)
    }

    /// Start it on an address; its port is to be 0.
    pub(crate) fn listening(folder: tempfile::TempDir, listen: &str, options: &[&str]) -> Self {
        let data = folder.path().join("data");
        let mut command = command(["coordinator", "--json", "--listen", listen, "--data"]);
        let mut process = Process::start(command.arg(&data).args(options));
        let url = until("the coordinator listens", || {
            assert!(
                process.runs(),
                "the coordinator ended: {}",
                process.stderr()
            );
            let said: Value = serde_json::from_str(&process.stdout()).ok()?;
            Some(text(&said["url"]))
        });
        let url = url.replace("0.0.0.0", "127.0.0.1");
        Self {
            url,
            process,
            data,
            folder,
        }
    }

    /// Host and port.
    pub(crate) fn address(&self) -> &str {
        self.url.split("://").nth(1).expect("a URL")
    }

    /// A client's command with a token, which comes by the variable.
    pub(crate) fn command(&self, token: &str, args: &[&str]) -> Command {
        let mut command = command(args);
        command.args(["--coordinator", &self.url]);
        command.env("SHEARWATER_TOKEN", token);
        command
    }

    /// Run it.
    pub(crate) fn client(&self, token: &str, args: &[&str]) -> Ended {
        Process::start(&mut self.command(token, args)).end()
    }

    /// Start a worker.
    pub(crate) fn worker(&self, token: &str, options: &[&str]) -> Process {
        let args = [&["worker", "--threads", "1"], options].concat();
        Process::start(&mut self.command(token, &args))
    }

    /// Submit the small scene, quick to render; the job's number.
    pub(crate) fn submit(&self, token: &str, options: &[&str]) -> String {
        let scene = scene::write(&self.folder.path().join("scene"));
        let scene = scene.to_str().expect("UTF-8");
        let quick = ["submit", scene, "--json", "--size", "64x64", "--spp", "8"];
        let ended = self.client(token, &[&quick, options].concat()).ok();
        ended.json()["id"].to_string()
    }

    /// Wait for the end of a job; its state.
    pub(crate) fn state_at_end(&self, token: &str, id: &str, options: &[&str]) -> Value {
        until("the job ends", || {
            let args = [&["status", id, "--json"], options].concat();
            let job = self.client(token, &args).ok().json();
            (job["done"] == true).then_some(job)
        })
    }
}
