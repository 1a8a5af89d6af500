//! What a coordinator is told at its start, and why it may refuse.

use crate::objects::{ObjectError, ObjectsUrl};
use crate::store::{DatabaseUrl, StoreError};
use crate::webhook::{CallerError, Secret};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Settings of one coordinator.
#[derive(Clone, Debug)]
pub struct Config {
    /// Folder of the database and the objects, as far as `database` and `objects`
    /// do not name others; made when it is missing. On a local disk: SQLite does
    /// not work on network file systems.
    pub data_dir: PathBuf,
    /// The database; `None`: `farm.db` in the data folder.
    pub database: Option<DatabaseUrl>,
    /// The objects; `None`: `objects` in the data folder.
    pub objects: Option<ObjectsUrl>,
    /// Address to listen on; port 0 takes any free one.
    pub listen: SocketAddr,
    /// Allow addresses that other machines reach, without any protection.
    pub allow_public: bool,
    /// Numeric build of the farm: workers of another build are refused.
    pub build: String,
    /// How long a lease should take its worker, in milliseconds.
    pub lease_target_ms: u64,
    /// How often workers should be heard of, in milliseconds.
    pub heartbeat_ms: u64,
    /// How long a lease lives without a heartbeat, in milliseconds.
    pub lease_ttl_ms: u64,
    /// How often a waiting worker's question is asked again although nothing
    /// happened here, in milliseconds: the endgame depends on the time alone,
    /// and other coordinators may have got jobs.
    pub ask_again_ms: u64,
    /// Age at which an object that no row names is removed, in milliseconds:
    /// longer than any upload lasts.
    pub orphan_grace_ms: u64,
    /// Age since its last use at which an asset that no job needs is removed, in
    /// milliseconds: people submit a scene again within days.
    pub asset_grace_ms: u64,
    /// Hosts that webhooks may call although their addresses are not public; `*` is
    /// any.
    pub webhook_allow: Vec<String>,
    /// Signs webhooks of jobs without a secret of their own.
    pub webhook_secret: Option<Secret>,
}

impl Config {
    /// The defaults for a farm of `build`.
    #[must_use]
    pub const fn new(data_dir: PathBuf, listen: SocketAddr, build: String) -> Self {
        Self {
            data_dir,
            database: None,
            objects: None,
            listen,
            allow_public: false,
            build,
            lease_target_ms: 10_000,
            heartbeat_ms: 3_000,
            lease_ttl_ms: 15_000,
            ask_again_ms: 1_000,
            orphan_grace_ms: 3_600_000,
            asset_grace_ms: 7 * 24 * 3_600_000,
            webhook_allow: Vec::new(),
            webhook_secret: None,
        }
    }

    pub(crate) fn check(&self) -> Result<(), StartError> {
        if !self.listen.ip().is_loopback() && !self.allow_public {
            return Err(StartError::Public(self.listen));
        }
        if self.lease_ttl_ms < 2 * self.heartbeat_ms || self.heartbeat_ms == 0 {
            return Err(StartError::Heartbeat {
                heartbeat_ms: self.heartbeat_ms,
                lease_ttl_ms: self.lease_ttl_ms,
            });
        }
        Ok(())
    }
}

/// Why a coordinator does not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Would be open to everybody.
    #[error(
        "refusing to listen on {0}: other machines reach this address, and access tokens are not \
         available yet. Listen on 127.0.0.1, or allow public access explicitly if the network \
         itself keeps strangers out"
    )]
    Public(SocketAddr),
    /// A worker that misses one heartbeat would lose its lease.
    #[error(
        "heartbeat of {heartbeat_ms} ms with a lease of {lease_ttl_ms} ms: the lease must last at \
         least two heartbeats, and a heartbeat at least 1 ms"
    )]
    Heartbeat {
        /// Configured.
        heartbeat_ms: u64,
        /// Configured.
        lease_ttl_ms: u64,
    },
    /// The folder cannot be made or used.
    #[error("data folder {path}: {source}")]
    DataDir {
        /// Which folder.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// The description of the API: a fault of the program.
    #[error("the description of the API cannot be written: {0}")]
    Document(#[from] serde_json::Error),
    /// Webhooks.
    #[error(transparent)]
    Webhooks(#[from] CallerError),
    /// The database.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The objects.
    #[error(transparent)]
    Objects(#[from] ObjectError),
    /// The address.
    #[error("cannot listen on {listen}: {source}; is another coordinator running there?")]
    Listen {
        /// Which address.
        listen: SocketAddr,
        /// The system's words.
        source: std::io::Error,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(listen: &str) -> Config {
        let listen = listen.parse().expect("address");
        Config::new(PathBuf::new(), listen, "b".into())
    }

    #[test]
    fn public_addresses_need_permission() {
        assert!(config("127.0.0.1:0").check().is_ok());
        assert!(config("[::1]:80").check().is_ok());
        for public in ["0.0.0.0:80", "192.168.1.4:80", "[::]:80"] {
            let mut config = config(public);
            let refusal = config.check().expect_err("public");
            assert!(refusal.to_string().contains("tokens"), "{refusal}");
            config.allow_public = true;
            assert!(config.check().is_ok());
        }
    }

    #[test]
    fn a_lease_outlives_two_heartbeats() {
        let mut config = config("127.0.0.1:0");
        config.lease_ttl_ms = config.heartbeat_ms;
        assert!(config.check().is_err());
    }
}
