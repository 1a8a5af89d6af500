//! Write-once objects: assets, parts and films.
//!
//! Every object is durable (in a folder: synced, with its directory) before `put` returns,
//! and its content never changes afterwards: names of parts and films carry a nonce, so
//! no two writers ever meet and a row names either the whole object or nothing.

mod leavings;
mod upload;
mod url;

pub use upload::Upload;
pub use url::{ObjectsUrl, ObjectsUrlError};

use crate::metrics::{ObjectMeasures, Operation};
use axum::body::Bytes;
use futures_util::stream::{BoxStream, StreamExt, TryStreamExt};
use object_store::path::Path;
use object_store::{
    Error, GetOptions, GetRange, GetResult, ObjectMeta, ObjectStore, ObjectStoreExt, PutMode,
    PutOptions, PutPayload,
};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// Prefix of parts: `part/<job>/<frame>/<tile>/<block0>-<block1>-<nonce>`.
pub const PARTS: &str = "part";
/// Prefix of films: `film/<job>/<frame>/<tile>-<nonce>`.
pub const FILMS: &str = "film";
/// Prefix of assets: `asset/<hash>`.
pub const ASSETS: &str = "asset";
/// Prefix of objects that only try whether objects can be written.
pub const PROBES: &str = "probe";

/// An object could not be written, read or removed.
#[derive(Debug, thiserror::Error)]
#[error("object `{name}`: {source}")]
pub struct ObjectError {
    /// Which object.
    pub name: String,
    /// The store's words.
    pub source: Error,
}

impl ObjectError {
    /// There is no such object.
    #[must_use]
    pub const fn is_missing(&self) -> bool {
        matches!(self.source, Error::NotFound { .. })
    }
}

/// The object store of one coordinator. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Objects {
    store: Arc<dyn ObjectStore>,
    /// Where they are, if in a folder.
    folder: Option<std::path::PathBuf>,
    /// Random enough for one process: time and process number.
    process: u64,
    serial: Arc<AtomicU64>,
    pub(crate) measures: ObjectMeasures,
}

impl Objects {
    /// Objects in a folder, which must exist.
    ///
    /// # Errors
    /// The folder cannot be used.
    pub fn local(folder: &std::path::Path) -> Result<Self, ObjectError> {
        ObjectsUrl::Folder(folder.to_owned()).open()
    }

    fn new(store: Arc<dyn ObjectStore>, folder: Option<std::path::PathBuf>) -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let mut hasher = blake3::Hasher::new();
        hasher.update(&since.map_or(0, |d| d.as_nanos()).to_le_bytes());
        hasher.update(&std::process::id().to_le_bytes());
        let mut process = [0; 8];
        hasher.finalize_xof().fill(&mut process);
        Self {
            store,
            folder,
            process: u64::from_le_bytes(process),
            serial: Arc::new(AtomicU64::new(0)),
            measures: ObjectMeasures::default(),
        }
    }

    fn nonce(&self) -> String {
        let serial = self.serial.fetch_add(1, Ordering::Relaxed);
        format!("{:016x}{serial:x}", self.process)
    }

    /// A name for a part, never used before.
    #[must_use]
    pub fn part_name(&self, job: JobId, run: &Run) -> String {
        format!(
            "{PARTS}/{job}/{}/{}/{}-{}-{}",
            run.frame,
            run.tile,
            run.block0,
            run.block1,
            self.nonce()
        )
    }

    /// A name for a tile's film, never used before.
    #[must_use]
    pub fn film_name(&self, job: JobId, frame: u32, tile: u32) -> String {
        format!("{FILMS}/{job}/{frame}/{tile}-{}", self.nonce())
    }

    /// A name for an object that only tries whether objects can be written.
    fn probe_name(&self) -> String {
        format!("{PROBES}/{}", self.nonce())
    }

    /// Whether objects can be written.
    ///
    /// # Errors
    /// They cannot.
    pub async fn try_write(&self) -> Result<(), ObjectError> {
        let name = self.probe_name();
        self.put(&name, b"probe".to_vec()).await?;
        self.delete(&name).await
    }

    /// What the store's clock says, milliseconds since 1970: ages of objects are told by
    /// it, since a coordinator whose clock is ahead would take new ones for old. Some stores
    /// tell whole seconds; this is the end of the present one.
    ///
    /// # Errors
    /// Objects cannot be written.
    pub async fn clock_ms(&self) -> Result<i64, ObjectError> {
        let name = self.probe_name();
        self.put(&name, b"probe".to_vec()).await?;
        let meta = self.store.head(&Path::from(name.as_str())).await;
        let written_ms = meta.map(|meta| meta.last_modified.timestamp_millis());
        self.delete(&name).await?;
        let written_ms = written_ms.map_err(|source| failed(&name, source))?;
        Ok(written_ms.saturating_add(1000))
    }

    /// The name of an asset.
    #[must_use]
    pub fn asset_name(hash: &ContentHash) -> String {
        format!("{ASSETS}/{hash}")
    }

    /// Write a new object; durable when this returns.
    ///
    /// # Errors
    /// The store failed, or the name is taken by other content.
    pub async fn put(&self, name: &str, bytes: Vec<u8>) -> Result<(), ObjectError> {
        let bytes = Bytes::from(bytes);
        let _timed = self.measures.operation(Operation::Put);
        let options = PutOptions::from(PutMode::Create);
        let payload = PutPayload::from_bytes(bytes.clone());
        let path = Path::from(name);
        match self.store.put_opts(&path, payload, options).await {
            Ok(_) => Ok(()),
            // A repetition of our own, whose first answer was lost on the way.
            Err(Error::AlreadyExists { .. }) if self.get(name).await? == bytes => Ok(()),
            Err(source) => Err(self.failed(name, source)),
        }
    }

    /// A whole object.
    ///
    /// # Errors
    /// The store failed, or there is no such object.
    pub async fn get(&self, name: &str) -> Result<Bytes, ObjectError> {
        let _timed = self.measures.operation(Operation::Get);
        let opened = self.store.get(&Path::from(name)).await;
        let opened = opened.map_err(|source| self.failed(name, source))?;
        let bytes = opened.bytes().await;
        bytes.map_err(|source| self.failed(name, source))
    }

    /// An object to be read in pieces.
    ///
    /// # Errors
    /// The store failed, or there is no such object.
    pub async fn open(&self, name: &str) -> Result<GetResult, ObjectError> {
        self.open_range(name, None).await
    }

    /// An object, or a range of its bytes, to be read in pieces.
    ///
    /// # Errors
    /// The store failed, there is no such object, or it ends before the range begins.
    pub async fn open_range(
        &self,
        name: &str,
        range: Option<std::ops::Range<u64>>,
    ) -> Result<GetResult, ObjectError> {
        let options = GetOptions {
            range: range.map(GetRange::Bounded),
            ..GetOptions::default()
        };
        let _timed = self.measures.operation(Operation::Open);
        let opened = self.store.get_opts(&Path::from(name), options).await;
        opened.map_err(|source| self.failed(name, source))
    }

    /// The length of an object; `None` when there is no such object.
    ///
    /// # Errors
    /// The store failed.
    pub async fn size(&self, name: &str) -> Result<Option<u64>, ObjectError> {
        match self.store.head(&Path::from(name)).await {
            Ok(meta) => Ok(Some(meta.size)),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(source) => Err(self.failed(name, source)),
        }
    }

    /// Remove an object; one that is gone already is fine.
    ///
    /// # Errors
    /// The store failed.
    pub async fn delete(&self, name: &str) -> Result<(), ObjectError> {
        let _timed = self.measures.operation(Operation::Delete);
        match self.store.delete(&Path::from(name)).await {
            Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
            Err(source) => Err(self.failed(name, source)),
        }
    }

    /// The folder they are in, if it is one of this machine.
    pub(crate) fn folder(&self) -> Option<&std::path::Path> {
        self.folder.as_deref()
    }

    /// An operation failed; that there is no such object may be the answer.
    fn failed(&self, name: &str, source: Error) -> ObjectError {
        if !matches!(source, Error::NotFound { .. }) {
            self.measures.failed();
        }
        failed(name, source)
    }

    /// Objects below a prefix, in no order.
    #[must_use]
    pub fn list(&self, prefix: &str) -> BoxStream<'static, Result<ObjectMeta, ObjectError>> {
        let name = prefix.to_owned();
        self.store
            .list(Some(&Path::from(prefix)))
            .map_err(move |source| failed(&name, source))
            .boxed()
    }
}

fn failed(name: &str, source: Error) -> ObjectError {
    ObjectError {
        name: name.to_owned(),
        source,
    }
}
