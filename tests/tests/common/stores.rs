//! The two pairs of stores that every farm must run on, each farm on its own.

use std::io::Write;
use std::net::SocketAddr;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

/// A database and an object store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pair {
    /// SQLite and a folder: what a laptop has.
    Laptop,
    /// PostgreSQL and S3, those of `tests/servers`.
    Servers,
}

/// Where one farm's data are, as arguments and environment of a coordinator.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    pub(crate) args: Vec<String>,
    pub(crate) envs: Vec<(String, String)>,
}

impl Pair {
    /// Whether it is there; says so aloud if not.
    pub(crate) fn there(self, test: &str) -> bool {
        let there = self == Self::Laptop || std::env::var_os("SHEARWATER_TEST_POSTGRES").is_some();
        if !there {
            left_out(test, "no PostgreSQL and S3; run it by tests/servers");
        }
        there
    }

    /// Empty stores of a farm's own.
    pub(crate) fn places(self, folder: &Path) -> Places {
        match self {
            Self::Laptop => Places::folder(&folder.join("data")),
            Self::Servers => Places::servers(&new_database(), &new_prefix()),
        }
    }
}

impl Places {
    /// Everything in a folder.
    pub(crate) fn folder(folder: &Path) -> Self {
        let folder = folder.to_str().expect("UTF-8").to_owned();
        Self {
            args: vec!["--data".into(), folder],
            envs: Vec::new(),
        }
    }

    /// Two URLs; that of the database with its password through the environment.
    pub(crate) fn servers(database: &str, objects: &str) -> Self {
        Self {
            args: vec!["--objects".into(), objects.into()],
            envs: vec![("SHEARWATER_DATABASE".into(), database.into())],
        }
    }
}

/// The address of the PostgreSQL server.
pub(crate) fn postgres_address() -> SocketAddr {
    let url = variable("SHEARWATER_TEST_POSTGRES");
    let place = url.rsplit_once('@').expect("URL with a password").1;
    address(place.split('/').next().expect("host"))
}

/// The address of the S3 server.
pub(crate) fn s3_address() -> SocketAddr {
    let url = variable("AWS_ENDPOINT_URL");
    address(url.trim_start_matches("http://").trim_end_matches('/'))
}

fn address(text: &str) -> SocketAddr {
    text.parse().expect("address and port")
}

/// A database of a farm's own; its URL.
pub(crate) fn new_database() -> String {
    let server = variable("SHEARWATER_TEST_POSTGRES");
    let name = format!("farm_{}", serial());
    psql(&server, &["-c", &format!("CREATE DATABASE {name}")]);
    let (server, _) = server.rsplit_once('/').expect("URL with a database");
    format!("{server}/{name}")
}

/// A place in the bucket of a farm's own; its URL.
pub(crate) fn new_prefix() -> String {
    format!("{}/farm-{}", variable("SHEARWATER_TEST_S3"), serial())
}

/// Run PostgreSQL's client.
pub(crate) fn psql(url: &str, args: &[&str]) {
    postgres_program(
        "psql",
        &[&["-q", "-v", "ON_ERROR_STOP=1", url], args].concat(),
    );
}

/// Run one of PostgreSQL's programs.
pub(crate) fn postgres_program(name: &str, args: &[&str]) {
    let program = Path::new(&variable("SHEARWATER_POSTGRES_BIN")).join(name);
    let output = Command::new(&program).args(args).output();
    let output = output.expect("a program of PostgreSQL");
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}: {log}");
}

pub(crate) fn variable(name: &str) -> String {
    std::env::var(name).unwrap_or_else(|_| panic!("{name} is not set: run it by tests/servers"))
}

fn serial() -> String {
    static SERIAL: AtomicU32 = AtomicU32::new(0);
    let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
    format!("{}_{serial}", std::process::id())
}

/// Said aloud: the test harness keeps what goes through `eprintln!`.
pub(crate) fn left_out(test: &str, why: &str) {
    let _ = std::io::stderr().write_all(format!("LEFT OUT: {test}: {why}\n").as_bytes());
}

/// Each test, a function of a pair, as one test for each pair.
#[allow(unused_macros, reason = "each test binary uses its own part")]
macro_rules! on_both_pairs {
    ($($name:ident;)*) => {$(
        mod $name {
            use $crate::common::stores::Pair;

            #[test]
            fn laptop() {
                super::$name(Pair::Laptop);
            }

            #[test]
            fn servers() {
                if Pair::Servers.there(module_path!()) {
                    super::$name(Pair::Servers);
                }
            }
        }
    )*};
}

#[allow(unused_imports, reason = "each test binary uses its own part")]
pub(crate) use on_both_pairs;
