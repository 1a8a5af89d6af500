//! What requests and background tasks share.

use crate::access::{Rates, Tokens};
use crate::beats;
use crate::config::{Config, StartError};
use crate::counting;
use crate::dispatch::{self, Question};
use crate::farm;
use crate::gather::{Gathered, Gatherer, gather};
use crate::known::Known;
use crate::metrics::{About, Metrics};
use crate::objects::{Objects, ObjectsUrl};
use crate::presence::{self, Presence};
use crate::store::{Beat, DatabaseUrl, Engine, PartRecord, Store, StoreError, WorkerRow};
use crate::trouble::Troubles;
use crate::webhook::Caller;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::{Notify, Semaphore, watch};

/// Results in memory at once: a body of 2 MiB and what is decoded from it are
/// about 6 MiB, so 400 MiB at worst.
const RESULTS_MAX: usize = 64;
/// Assets that stream in at once.
const UPLOADS_MAX: usize = 16;
/// Pictures developed at once: the largest need 8 GiB.
const DEVELOPS_MAX: usize = 2;
/// Requests that wait for an event (lease polls and event streams): each holds
/// a connection and little else.
const WAITERS_MAX: usize = 10_000;
/// Heartbeats that stand in line: one of each worker that may wait.
const BEATS_MAX: usize = 10_000;

/// The state of a running coordinator; nothing in it outlives the process.
#[derive(Debug)]
pub(crate) struct App {
    pub(crate) config: Config,
    pub(crate) store: Store,
    pub(crate) objects: Objects,
    pub(crate) webhooks: Caller,
    pub(crate) tokens: Tokens,
    pub(crate) rates: Rates,
    /// Jobs as they were a moment ago.
    pub(crate) known: Known,
    /// Which workers are there.
    pub(crate) presence: Presence,
    /// Workers' questions for work.
    pub(crate) questions: Gatherer<Question, dispatch::Answer>,
    /// Results to be counted.
    pub(crate) results: Gatherer<PartRecord, counting::Answer>,
    /// Heartbeats.
    pub(crate) beats: Gatherer<Vec<Beat>, beats::Answer>,
    /// Counts up when units become ready.
    pub(crate) work: watch::Sender<u64>,
    /// Counts up when a job changes.
    pub(crate) change: watch::Sender<u64>,
    /// A job was deleted: its rows and objects are to go.
    pub(crate) deleted: Notify,
    /// What is broken at the moment.
    pub(crate) troubles: Troubles,
    /// What was counted and measured.
    pub(crate) metrics: Metrics,
    /// True once the process is to end.
    pub(crate) stopping: watch::Sender<bool>,
    pub(crate) cpu: Arc<Semaphore>,
    pub(crate) results_under_way: Semaphore,
    pub(crate) uploads: Semaphore,
    pub(crate) develops: Arc<Semaphore>,
    pub(crate) waiters: Arc<Semaphore>,
}

/// A queue with a bound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places {
    /// What it is called.
    pub(crate) name: &'static str,
    /// How many are in it.
    pub(crate) used: usize,
    /// How many may be.
    pub(crate) most: usize,
}

/// The other ends of what is gathered, for the tasks that answer.
#[derive(Debug)]
pub(crate) struct Lines {
    pub(crate) newcomers: Gathered<WorkerRow, presence::Answer>,
    pub(crate) questions: Gathered<Question, dispatch::Answer>,
    pub(crate) results: Gathered<PartRecord, counting::Answer>,
    pub(crate) beats: Gathered<Vec<Beat>, beats::Answer>,
}

/// A computation did not come to its end: it panicked, or the process ends.
#[derive(Debug, thiserror::Error)]
#[error("a computation was cut off: {0}")]
pub struct CutOff(String);

impl App {
    pub(crate) async fn open(config: Config) -> Result<(Self, Lines), StartError> {
        let objects = open_objects(&config)?;
        let store = open_store(&config).await?;
        // Workers could not be heard while nobody listened.
        let until_ms = now_ms().saturating_add_unsigned(config.lease_ttl_ms);
        store.prolong_all(until_ms).await?;
        let webhooks = Caller::new(&config)?;
        let metrics = Metrics::new(&about(&config, &store), &store.measures, &objects.measures);
        let (newcomers, came) = gather(WAITERS_MAX);
        let presence = Presence::new(newcomers);
        presence.refresh(&store, now_ms()).await?;
        let (questions, asked) = gather(WAITERS_MAX);
        let (results, delivered) = gather(RESULTS_MAX);
        let (beats, heard) = gather(BEATS_MAX);
        let lines = Lines {
            newcomers: came,
            questions: asked,
            results: delivered,
            beats: heard,
        };
        let app = Self {
            tokens: Tokens::new(store.clone()),
            rates: Rates::default(),
            config,
            store,
            objects,
            webhooks,
            work: watch::Sender::new(0),
            change: watch::Sender::new(0),
            deleted: Notify::new(),
            troubles: Troubles::default(),
            metrics,
            stopping: watch::Sender::new(false),
            cpu: Arc::new(Semaphore::new(cpu_places())),
            results_under_way: Semaphore::new(RESULTS_MAX),
            uploads: Semaphore::new(UPLOADS_MAX),
            develops: Arc::new(Semaphore::new(DEVELOPS_MAX)),
            waiters: Arc::new(Semaphore::new(WAITERS_MAX)),
            known: Known::default(),
            presence,
            questions,
            results,
            beats,
        };
        Ok((app, lines))
    }

    /// Whether everybody who reaches this coordinator may use it: its store never
    /// had a token, and nobody but this machine reaches it, or its owner says so.
    pub(crate) async fn is_open(&self) -> Result<bool, StoreError> {
        let may_be = self.config.listen.ip().is_loopback() || self.config.allow_public;
        Ok(may_be && !self.tokens.any().await?)
    }

    /// Its queues, as they are now.
    pub(crate) fn places(&self) -> [Places; 5] {
        [
            ("waiters", &*self.waiters, WAITERS_MAX),
            ("results", &self.results_under_way, RESULTS_MAX),
            ("uploads", &self.uploads, UPLOADS_MAX),
            ("develops", &*self.develops, DEVELOPS_MAX),
            ("computations", &*self.cpu, cpu_places()),
        ]
        .map(|(name, places, most)| Places {
            name,
            used: most.saturating_sub(places.available_permits()),
            most,
        })
    }

    /// Stores that are folders of this machine.
    pub(crate) fn folders(&self) -> Vec<(&'static str, &Path)> {
        let database = self.config.database.is_none();
        let database = database.then_some(("database", self.config.data_dir.as_path()));
        let objects = self.objects.folder().map(|folder| ("objects", folder));
        database.into_iter().chain(objects).collect()
    }

    /// Run a computation off the async threads; as many at once as the machine
    /// has threads. Whoever waits may go away; the work and its place stay
    /// until it ends.
    pub(crate) async fn compute<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, CutOff> {
        let permit = Arc::clone(&self.cpu)
            .acquire_owned()
            .await
            .map_err(|e| CutOff(e.to_string()))?;
        let work = move || {
            let done = work();
            drop(permit);
            done
        };
        tokio::task::spawn_blocking(work)
            .await
            .map_err(|e| CutOff(e.to_string()))
    }

    /// Milliseconds between heartbeats, for the workers that are there.
    pub(crate) fn heartbeat_ms(&self) -> u64 {
        let workers = self.presence.present().len();
        farm::heartbeat_ms(self.config.heartbeat_ms, workers)
    }

    /// Milliseconds that a lease lives without one.
    pub(crate) fn lease_ttl_ms(&self) -> u64 {
        farm::lease_ttl_ms(self.config.lease_ttl_ms, self.heartbeat_ms())
    }

    /// Wake those who wait for work.
    pub(crate) fn work_came(&self) {
        self.work
            .send_modify(|count| *count = count.wrapping_add(1));
        self.job_changed();
    }

    /// Wake those who watch jobs.
    pub(crate) fn job_changed(&self) {
        self.change
            .send_modify(|count| *count = count.wrapping_add(1));
    }
}

/// Computations at once: one for each thread of the machine, two at least.
fn cpu_places() -> usize {
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    threads.max(2)
}

fn about(config: &Config, store: &Store) -> About {
    let folder = matches!(config.objects, None | Some(ObjectsUrl::Folder(_)));
    About {
        build: config.build.clone(),
        database: match store.engine() {
            Engine::Sqlite => "sqlite",
            Engine::Postgres => "postgres",
        },
        objects: if folder { "folder" } else { "s3" },
    }
}

/// Milliseconds since 1970. Skew between coordinators changes when a lease is
/// repeated, never a picture.
pub(crate) fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |d| i64::try_from(d.as_millis()).unwrap_or(i64::MAX))
}

/// The objects of a coordinator with these settings.
pub(crate) fn open_objects(config: &Config) -> Result<Objects, StartError> {
    let url = match &config.objects {
        Some(url) => url.clone(),
        None => ObjectsUrl::Folder(config.data_dir.join("objects")),
    };
    let url = match url {
        ObjectsUrl::Folder(folder) => ObjectsUrl::Folder(make_folder(&folder)?),
        s3 @ ObjectsUrl::S3 { .. } => s3,
    };
    tracing::info!(%url, "objects");
    Ok(url.open()?)
}

/// The store of a coordinator with these settings.
pub(crate) async fn open_store(config: &Config) -> Result<Store, StartError> {
    let url = match &config.database {
        Some(url) => url.clone(),
        None => {
            let folder = make_folder(&config.data_dir)?;
            DatabaseUrl::parse(&sqlite_url(&folder.join("farm.db")))?
        }
    };
    tracing::info!(%url, "database");
    Ok(Store::open(&url).await?)
}

/// The store of a coordinator with these settings, without a coordinator: for
/// [`crate::access`]. A file is made only if `create` says so.
///
/// # Errors
/// There is none, or it cannot be opened.
pub async fn open_token_store(config: &Config, create: bool) -> Result<Store, StartError> {
    let file = config.data_dir.join("farm.db");
    if !create && config.database.is_none() && !file.is_file() {
        return Err(StartError::NoStore(config.data_dir.clone()));
    }
    open_store(config).await
}

fn make_folder(path: &Path) -> Result<std::path::PathBuf, StartError> {
    let failed = |source| StartError::DataDir {
        path: path.to_owned(),
        source,
    };
    std::fs::create_dir_all(path).map_err(failed)?;
    path.canonicalize().map_err(failed)
}

/// The URL of a database file; every unusual byte is escaped, since `?`, `#`
/// and `%` mean something in a URL.
fn sqlite_url(path: &Path) -> String {
    let mut url = String::from("sqlite://");
    for &byte in path.as_os_str().as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"/._-".contains(&byte) {
            url.push(char::from(byte));
        } else {
            // Writing to a String cannot fail.
            let _ = write!(url, "%{byte:02X}");
        }
    }
    url.push_str("?mode=rwc");
    url
}

#[cfg(test)]
mod tests {
    #[test]
    fn urls_are_escaped() {
        let url = super::sqlite_url(std::path::Path::new("/a b/50%?#/farm.db"));
        assert_eq!(url, "sqlite:///a%20b/50%25%3F%23/farm.db?mode=rwc");
    }
}
