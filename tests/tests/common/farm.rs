//! A farm of real processes.

use super::process::{Ended, Process, command, run};
use super::stores::{Pair, Places};
use super::{http, scene, until};
use serde_json::Value;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU16, Ordering};

/// A coordinator with its store and scene; workers belong to the tests.
pub(crate) struct Farm {
    pub(crate) url: String,
    pub(crate) scene: PathBuf,
    folder: tempfile::TempDir,
    pub(crate) places: Places,
    port: u16,
    coordinator: Option<Process>,
}

/// One more coordinator on a farm's stores.
pub(crate) struct Replica {
    pub(crate) url: String,
    pub(crate) process: Process,
}

/// A free port that no outgoing connection can take while the coordinator is
/// down: below the range that the system gives to clients.
pub(crate) fn steady_port() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let start = (std::process::id() % 8_000) as u16;
    until("a free port", || {
        let step = NEXT.fetch_add(1, Ordering::Relaxed);
        let port = 21_000 + start.wrapping_add(step) % 10_000;
        TcpListener::bind(("127.0.0.1", port)).ok().map(|_| port)
    })
}

impl Farm {
    /// Start a coordinator with an empty store of a laptop.
    pub(crate) fn start() -> Self {
        Self::start_on(Pair::Laptop)
    }

    /// Start a coordinator with empty stores.
    pub(crate) fn start_on(pair: Pair) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let places = pair.places(folder.path());
        Self::start_in(folder, places)
    }

    /// Start one with more arguments.
    pub(crate) fn start_args(more: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut places = Pair::Laptop.places(folder.path());
        places.args.extend(more.iter().map(|&text| text.into()));
        Self::start_in(folder, places)
    }

    /// Start a coordinator with these stores.
    pub(crate) fn start_with(places: Places) -> Self {
        Self::start_in(tempfile::tempdir().expect("temporary folder"), places)
    }

    fn start_in(folder: tempfile::TempDir, places: Places) -> Self {
        let scene = scene::write(&folder.path().join("scene"));
        let port = steady_port();
        let mut farm = Self {
            url: format!("http://127.0.0.1:{port}"),
            scene,
            folder,
            places,
            port,
            coordinator: None,
        };
        farm.coordinator = Some(farm.coordinator_on(port));
        farm
    }

    /// Start one more coordinator on the same stores.
    pub(crate) fn replica(&self) -> Replica {
        let port = steady_port();
        Replica {
            url: format!("http://127.0.0.1:{port}"),
            process: self.coordinator_on(port),
        }
    }

    fn coordinator_on(&self, port: u16) -> Process {
        let mut process = Process::start(
            command(["coordinator", "--json", "--listen"])
                .arg(format!("127.0.0.1:{port}"))
                .args(["--webhook-allow", "127.0.0.1"])
                .args(&self.places.args)
                .envs(self.places.envs.iter().cloned()),
        );
        until("the coordinator listens", || {
            assert!(process.runs(), "the coordinator ended");
            process.stdout().contains("http://").then_some(())
        });
        process
    }

    /// Kill the coordinator as a power cut would.
    pub(crate) fn kill_coordinator(&mut self) {
        self.coordinator.take().expect("it runs").kill();
    }

    /// Start it again on the same port and store.
    pub(crate) fn restart_coordinator(&mut self) {
        assert!(self.coordinator.is_none());
        self.coordinator = Some(self.coordinator_on(self.port));
    }

    /// Start a worker.
    pub(crate) fn worker(&self, threads: u32) -> Process {
        worker_for(&self.url, threads)
    }

    /// Run a client command.
    pub(crate) fn client(&self, args: &[&str]) -> Ended {
        let url: [&str; 2] = ["--coordinator", &self.url];
        run(args.iter().chain(&url))
    }

    /// Submit the scene; the job's number.
    pub(crate) fn submit(&self, more: &[&str]) -> String {
        let scene = self.scene.to_str().expect("UTF-8");
        let args = [&["submit", scene, "--json"], more].concat();
        self.client(&args).ok().json()["id"].to_string()
    }

    /// The job as the API shows it.
    pub(crate) fn job(&self, id: &str) -> Value {
        self.client(&["status", id, "--json"]).ok().json()
    }

    /// Wait until some units of a job are done; fails when all are: then
    /// whatever the test does next comes too late.
    pub(crate) fn under_way(&self, id: &str, units: u64) {
        until("units done", || {
            let job = self.job(id);
            assert_eq!(job["done"], false, "the job was too quick");
            (job["units_done"].as_u64() >= Some(units)).then_some(())
        });
    }

    /// Wait for the end of a job; the film's hash.
    pub(crate) fn film_hash(&self, id: &str) -> String {
        let job = self.client(&["watch", id, "--json"]).ok().json();
        assert_eq!(job["units_done"], job["units_total"]);
        film_hash_of(&job)
    }

    /// Delete a job.
    pub(crate) fn delete(&self, id: &str) {
        let (status, body) = http::send(&self.url, "DELETE", &format!("/v1/jobs/{id}"));
        assert_eq!(status, 204, "{body}");
    }

    /// A folder of the test's own.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }
}

/// What `render` says on this machine, asked once.
pub(crate) fn right_answer() -> &'static str {
    static HASH: OnceLock<String> = OnceLock::new();
    HASH.get_or_init(|| {
        let folder = tempfile::tempdir().expect("temporary folder");
        render(&scene::write(folder.path()), &["--threads", "1"])
    })
}

/// The hash of a job's first film.
pub(crate) fn film_hash_of(job: &Value) -> String {
    hash_of(&job["film_hashes"][0])
}

/// Start a worker for any address.
pub(crate) fn worker_for(url: &str, threads: u32) -> Process {
    Process::start(command(["worker", "--coordinator", url, "--threads"]).arg(threads.to_string()))
}

/// `render` the scene; the film's hash.
pub(crate) fn render(scene: &Path, more: &[&str]) -> String {
    render_as(scene, more, "auto").0
}

/// `render` with one of the copies of the traversal; the film's hash and the log.
pub(crate) fn render_as(scene: &Path, more: &[&str], simd: &str) -> (String, String) {
    let out = tempfile::tempdir().expect("temporary folder");
    let mut command = command(["render", "--json", "-v", "-o"]);
    command.arg(out.path()).arg(scene).args(more);
    command.env("SHEARWATER_SIMD", simd);
    let ended = Process::start(&mut command).end().ok();
    (hash_of(&ended.json()["film_hash"]), ended.stderr)
}

/// A JSON value that must be a hash.
pub(crate) fn hash_of(value: &Value) -> String {
    let hash = value.as_str().expect("a hash");
    assert!(
        hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit()),
        "{hash}"
    );
    hash.to_owned()
}
