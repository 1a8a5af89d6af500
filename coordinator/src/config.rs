//! What a coordinator is told at its start, and why it may refuse.

use crate::access::{Role, TokenError};
use crate::farm::WHOLE_PPM;
use crate::objects::{ObjectError, ObjectsUrl};
use crate::serve::{TlsError, TlsFiles};
use crate::store::{DatabaseUrl, StoreError};
use crate::webhook::{CallerError, Secret};
use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Share of runs that are audited when nobody says otherwise, in millionths: a worker
/// that is always wrong is found after some hundred runs, for half a percent of the work.
const AUDIT_PPM: u32 = 5_000;

/// A token that was made elsewhere. Its debug text leaves it out.
#[derive(Clone)]
pub struct GivenToken {
    /// What it is for.
    pub role: Role,
    /// The whole token.
    pub token: String,
}

impl fmt::Debug for GivenToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "GivenToken({})", self.role)
    }
}

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
    /// Answer everybody, also where other machines reach this one, until the store
    /// has its first token. Without it such an address needs a token to begin
    /// with.
    pub allow_public: bool,
    /// Serve by TLS.
    pub tls: Option<TlsFiles>,
    /// Tokens that were made elsewhere, to be known to the store from the start on.
    pub tokens: Vec<GivenToken>,
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
    /// Share of runs that another worker renders again, in millionths.
    pub audit_ppm: u32,
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
            tls: None,
            tokens: Vec::new(),
            build,
            lease_target_ms: 10_000,
            heartbeat_ms: 3_000,
            lease_ttl_ms: 15_000,
            ask_again_ms: 1_000,
            audit_ppm: AUDIT_PPM,
            orphan_grace_ms: 3_600_000,
            asset_grace_ms: 7 * 24 * 3_600_000,
            webhook_allow: Vec::new(),
            webhook_secret: None,
        }
    }

    pub(crate) fn check(&self) -> Result<(), StartError> {
        if self.lease_ttl_ms < 2 * self.heartbeat_ms || self.heartbeat_ms == 0 {
            return Err(StartError::Heartbeat {
                heartbeat_ms: self.heartbeat_ms,
                lease_ttl_ms: self.lease_ttl_ms,
            });
        }
        if self.audit_ppm > WHOLE_PPM {
            return Err(StartError::Audit(self.audit_ppm));
        }
        Ok(())
    }
}

/// Why a coordinator does not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Would be open to everybody.
    #[error(
        "refusing to listen on {0}: other machines reach this address, and the store has no access \
         token yet. Make one with `shearwater token create --role admin` on the same store, or \
         listen on 127.0.0.1"
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
    /// More than all.
    #[error("audit of {0} millionths of all runs: at most a million, which is all of them")]
    Audit(u32),
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
    /// No database in the folder.
    #[error("{0} holds no store; name the coordinator's folder with --data")]
    NoStore(PathBuf),
    /// The database.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The objects.
    #[error(transparent)]
    Objects(#[from] ObjectError),
    /// A token that was given.
    #[error("a given token: {0}")]
    Token(#[from] TokenError),
    /// The certificates.
    #[error("TLS: {0}")]
    Tls(#[from] TlsError),
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
    fn a_lease_outlives_two_heartbeats() {
        let mut config = config("127.0.0.1:0");
        config.lease_ttl_ms = config.heartbeat_ms;
        assert!(config.check().is_err());
    }
}
