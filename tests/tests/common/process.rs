//! Processes of the built program that never outlive their test.

use super::{PATIENCE, until};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// The program, built beside the tests by `cargo build -p shearwater`.
pub(crate) fn program() -> PathBuf {
    let test = std::env::current_exe().expect("own path");
    let profile = test.ancestors().nth(2).expect("target/<profile>/deps/test");
    let program = profile.join(format!("shearwater{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.is_file(),
        "{} is not there: build it first with `cargo build -p shearwater`",
        program.display()
    );
    program
}

/// A running process; killed when dropped.
pub(crate) struct Process {
    child: Child,
    // Files, not pipes: nobody has to empty them.
    out: tempfile::TempDir,
}

/// How a process ended.
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// A command without the settings of whoever runs the tests.
pub(crate) fn command<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(program());
    for name in [
        "SHEARWATER_COORDINATOR",
        "SHEARWATER_DATABASE",
        "SHEARWATER_OBJECTS",
        "SHEARWATER_TOKEN",
        "SHEARWATER_CA",
        "SHEARWATER_SIMD",
        "SHEARWATER_LOG_FORMAT",
        "RUST_LOG",
    ] {
        command.env_remove(name);
    }
    command.args(args);
    command
}

impl Process {
    /// Start a command.
    pub(crate) fn start(command: &mut Command) -> Self {
        let out = tempfile::tempdir().expect("temporary folder");
        let file = |name: &str| File::create(out.path().join(name)).expect("output file");
        let child = command
            .stdin(Stdio::null())
            .stdout(file("stdout"))
            .stderr(file("stderr"))
            .spawn()
            .expect("the program starts");
        Self { child, out }
    }

    /// What it has printed so far.
    pub(crate) fn stdout(&self) -> String {
        self.text("stdout")
    }

    /// What it has logged so far.
    pub(crate) fn stderr(&self) -> String {
        self.text("stderr")
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.out.path().join(name)).expect("output")
    }

    /// Kill it as a power cut would.
    pub(crate) fn kill(mut self) {
        self.child.kill().expect("SIGKILL");
        self.child.wait().expect("reaped");
    }

    /// Its number.
    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether it still runs.
    pub(crate) fn runs(&mut self) -> bool {
        self.child.try_wait().expect("wait").is_none()
    }

    /// Ask it to end.
    pub(crate) fn signal(&self, name: &str) {
        let status = Command::new("kill")
            .args([&format!("-{name}"), &self.child.id().to_string()])
            .status()
            .expect("kill");
        assert!(status.success());
    }

    /// Wait for its end.
    pub(crate) fn end(mut self) -> Ended {
        let started = Instant::now();
        let status = until("the process ends", || {
            let status = self.child.try_wait().expect("wait");
            assert!(
                status.is_some() || started.elapsed() < PATIENCE,
                "still runs; its log:\n{}",
                self.text("stderr")
            );
            status
        });
        Ended {
            code: status.code(),
            stdout: self.stdout(),
            stderr: self.text("stderr"),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- log of a process:\n{}", self.text("stderr"));
        }
    }
}

impl Ended {
    /// Assert success.
    pub(crate) fn ok(self) -> Self {
        self.expect_code(0)
    }

    /// Assert an exit code.
    pub(crate) fn expect_code(self, code: i32) -> Self {
        assert_eq!(
            self.code,
            Some(code),
            "stdout:\n{}\nstderr:\n{}",
            self.stdout,
            self.stderr
        );
        self
    }

    /// Its one JSON object.
    pub(crate) fn json(&self) -> Value {
        let value: Value = serde_json::from_str(&self.stdout)
            .unwrap_or_else(|e| panic!("not one JSON object ({e}):\n{}", self.stdout));
        assert!(value.is_object(), "{value}");
        value
    }
}

/// Run a command to its end.
pub(crate) fn run<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> Ended {
    Process::start(&mut command(args)).end()
}
