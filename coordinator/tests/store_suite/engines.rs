//! Stores of each engine for a test, each empty and gone afterwards.

use shearwater_coordinator::store::{DatabaseUrl, Store};
use sqlx::{AnyConnection, AssertSqlSafe, Connection, Executor};
use std::io::Write;
use std::sync::atomic::{AtomicU32, Ordering};

/// An empty database.
pub(crate) struct Database {
    pub(crate) url: DatabaseUrl,
    _folder: Option<tempfile::TempDir>,
}

impl Database {
    /// A file of its own.
    pub(crate) fn sqlite() -> Self {
        let folder = tempfile::tempdir().expect("folder");
        let url = format!("sqlite://{}/farm.db", folder.path().display());
        Self {
            url: DatabaseUrl::parse(&url).expect("URL"),
            _folder: Some(folder),
        }
    }

    /// A database of its own on the server that `SHEARWATER_TEST_POSTGRES` names;
    /// `None`, said aloud, without one. The server is thrown away afterwards.
    pub(crate) async fn postgres(test: &str) -> Option<Self> {
        static SERIAL: AtomicU32 = AtomicU32::new(0);
        let Ok(server) = std::env::var("SHEARWATER_TEST_POSTGRES") else {
            left_out(test, "SHEARWATER_TEST_POSTGRES");
            return None;
        };
        sqlx::any::install_default_drivers();
        let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
        let name = format!("store_{}_{serial}", std::process::id());
        let mut connection = AnyConnection::connect(&server).await.expect("server");
        let sql = AssertSqlSafe(format!("CREATE DATABASE {name}"));
        connection.execute(sql).await.expect("create database");
        let (server, _) = server.rsplit_once('/').expect("URL with a database");
        Some(Self {
            url: DatabaseUrl::parse(&format!("{server}/{name}")).expect("URL"),
            _folder: None,
        })
    }

    pub(crate) async fn open(&self) -> Store {
        Store::open(&self.url).await.expect("open")
    }
}

/// Not through `eprintln!`, which the test harness keeps to itself.
pub(crate) fn left_out(test: &str, variable: &str) {
    let text = format!("LEFT OUT: {test}, since {variable} is not set; run it by tests/servers\n");
    let _ = std::io::stderr().write_all(text.as_bytes());
}
