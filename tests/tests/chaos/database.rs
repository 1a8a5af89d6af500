//! A PostgreSQL server of the run's own, which may be killed: it keeps fsync on and
//! starts again on its folder.

use crate::common::stores::{psql, variable};
use crate::common::until;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

const PASSWORD: &str = "farm-secret";

/// The server and its folder.
pub(crate) struct Database {
    server: Option<Child>,
    port: u16,
    folder: tempfile::TempDir,
}

impl Database {
    /// Make an empty one and start it.
    pub(crate) fn start(port: u16) -> Self {
        // Not in /tmp, which may be kept in memory: fsync would mean nothing there.
        let base = std::env::var_os("TMPDIR").map_or("/var/tmp".into(), PathBuf::from);
        let folder = tempfile::Builder::new()
            .prefix("shearwater-chaos")
            .tempdir_in(base);
        let folder = folder.expect("temporary folder");
        let password = folder.path().join("password");
        std::fs::write(&password, PASSWORD).expect("password");
        if is_root() {
            let mut chown = Command::new("chown");
            chown.args(["-R", user()]).arg(folder.path());
            assert!(chown.status().expect("chown").success());
        }
        let mut made = unprivileged("initdb");
        made.args(["-U", "farm", "--auth=scram-sha-256", "-E", "UTF8"]);
        made.args(["--no-locale", "-D"]).arg(data(folder.path()));
        made.arg(format!("--pwfile={}", password.display()));
        let made = made.output().expect("initdb");
        let log = String::from_utf8_lossy(&made.stderr);
        assert!(made.status.success(), "initdb: {log}");
        let mut database = Self {
            server: None,
            port,
            folder,
        };
        database.start_again();
        let server = format!("postgres://farm:{PASSWORD}@{}/postgres", database.address());
        until("the database answers", || {
            std::net::TcpStream::connect(database.address()).ok()
        });
        until("the database is ready", || {
            let mut ready = Command::new(program("pg_isready"));
            ready.args(["-q", "-d", &server]);
            ready.status().ok().filter(ExitStatus::success)
        });
        psql(&server, &["-c", "CREATE DATABASE farm"]);
        database
    }

    /// Where it listens.
    pub(crate) fn address(&self) -> SocketAddr {
        (Ipv4Addr::LOCALHOST, self.port).into()
    }

    /// The farm's database, reached by `address`.
    pub(crate) fn url(address: SocketAddr) -> String {
        format!("postgres://farm:{PASSWORD}@{address}/farm")
    }

    /// Start it on its folder, whatever state that is in.
    pub(crate) fn start_again(&mut self) {
        let log = std::fs::File::options()
            .create(true)
            .append(true)
            .open(self.folder.path().join("log"))
            .expect("log");
        let mut server = unprivileged("postgres");
        server.arg("-D").arg(data(self.folder.path()));
        for setting in [
            "listen_addresses=127.0.0.1".to_owned(),
            format!("port={}", self.port),
            format!("unix_socket_directories={}", self.folder.path().display()),
        ] {
            server.args(["-c", &setting]);
        }
        server
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log);
        self.server = Some(server.spawn().expect("postgres"));
    }

    /// Start it again if it has ended by itself.
    pub(crate) fn look_after(&mut self) -> bool {
        let ended = |child: &mut Child| child.try_wait().expect("wait").is_some();
        let ended = self.server.as_mut().is_some_and(ended);
        if ended {
            self.start_again();
        }
        ended
    }

    /// Whether it was not killed.
    pub(crate) fn is_up(&self) -> bool {
        self.server.is_some()
    }

    /// SIGKILL to the server and all its processes, as when its machine loses power (but
    /// for what the system has not written yet).
    pub(crate) fn kill(&mut self) {
        self.signal("KILL");
        if let Some(mut server) = self.server.take() {
            server.wait().expect("reaped");
        }
    }

    /// Send a signal to all its processes.
    pub(crate) fn signal(&self, name: &str) {
        let Some(server) = &self.server else { return };
        let main = server.id();
        // It starts no more of them while it stands still.
        send("STOP", &[main]);
        let mut all = children(main);
        all.push(main);
        send(name, &all);
        if name == "KILL" {
            let gone = || all.iter().all(|&id| id == main || !is_alive(id));
            until("its processes are gone", || gone().then_some(()));
        }
    }
}

impl Drop for Database {
    fn drop(&mut self) {
        self.kill();
        if std::thread::panicking() {
            let log = std::fs::read_to_string(self.folder.path().join("log")).unwrap_or_default();
            let from = log.len().saturating_sub(8_000);
            eprintln!(
                "--- end of the database's log:\n{}",
                log.get(from..).unwrap_or_default()
            );
        }
    }
}

fn data(folder: &Path) -> PathBuf {
    folder.join("data")
}

fn program(name: &str) -> PathBuf {
    Path::new(&variable("SHEARWATER_POSTGRES_BIN")).join(name)
}

fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output().expect("id");
    output.stdout.trim_ascii() == b"0"
}

fn user() -> &'static str {
    let known = Command::new("id").arg("postgres").output().expect("id");
    if known.status.success() {
        "postgres"
    } else {
        "nobody"
    }
}

/// PostgreSQL refuses to run as root.
fn unprivileged(name: &str) -> Command {
    if !is_root() {
        return Command::new(program(name));
    }
    let group = Command::new("id").args(["-g", user()]).output();
    let group = String::from_utf8(group.expect("id").stdout).expect("number");
    let mut command = Command::new("setpriv");
    command
        .args(["--reuid", user(), "--regid", group.trim()])
        .arg("--clear-groups")
        .arg(program(name))
        .current_dir("/");
    command
}

fn send(name: &str, to: &[u32]) {
    let ids = to.iter().map(u32::to_string);
    // One of them may have ended meanwhile.
    let _ = Command::new("kill")
        .arg(format!("-{name}"))
        .args(ids)
        .stderr(Stdio::null())
        .status();
}

/// State and parent of a process, while there is one.
fn look(id: u32) -> Option<(char, u32)> {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The name, in brackets, may contain anything.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace();
    let state = fields.next()?.chars().next()?;
    Some((state, fields.next()?.parse().ok()?))
}

fn is_alive(id: u32) -> bool {
    look(id).is_some_and(|(state, _)| state != 'Z')
}

fn children(of: u32) -> Vec<u32> {
    let ids = std::fs::read_dir("/proc").expect("/proc");
    ids.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
        .filter(|&id| look(id).is_some_and(|(_, parent)| parent == of))
        .collect()
}
