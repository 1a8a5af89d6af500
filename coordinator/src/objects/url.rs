//! Which object store: a folder or an S3 bucket, by URL.

use super::{ObjectError, Objects};
use object_store::aws::AmazonS3Builder;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::prefix::PrefixStore;
use object_store::{BackoffConfig, ClientOptions, RetryConfig};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Longest that one S3 request may take: half a megabyte, or five of an asset.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(20);
/// Longest wait for a connection: a server that takes longer is not there.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(4);
/// After this time no failed request is repeated here: whoever asked keeps what
/// it holds and comes again, and is told why meanwhile.
const RETRY_TIMEOUT: Duration = Duration::from_secs(5);
/// Repetitions within that time.
const RETRIES_MAX: usize = 4;
/// First and longest pause between them.
const RETRY_PAUSES: (Duration, Duration) = (Duration::from_millis(100), Duration::from_secs(2));

/// Where objects are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ObjectsUrl {
    /// `file:///folder`, made when it is missing.
    Folder(PathBuf),
    /// `s3://bucket/prefix`; endpoint, region and keys are those of the usual
    /// `AWS_*` environment variables.
    S3 {
        /// The bucket, which must exist.
        bucket: String,
        /// Where in it; may be empty.
        prefix: String,
    },
}

/// A URL names no object store.
#[derive(Debug, thiserror::Error)]
#[error("objects URL `{0}`: expected file:///absolute/folder or s3://bucket/prefix")]
pub struct ObjectsUrlError(String);

impl ObjectsUrl {
    /// `file:///folder` or `s3://bucket/prefix`.
    ///
    /// # Errors
    /// It is neither.
    pub fn parse(url: &str) -> Result<Self, ObjectsUrlError> {
        let wrong = || ObjectsUrlError(url.chars().take(200).collect());
        if let Some(path) = url.strip_prefix("file://") {
            let path = percent_decoded(path).filter(|path| path.starts_with('/'));
            return path.map(|path| Self::Folder(path.into())).ok_or_else(wrong);
        }
        let rest = url.strip_prefix("s3://").ok_or_else(wrong)?;
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        if bucket.is_empty() || bucket.contains(['@', ':', '?', '#']) {
            return Err(wrong());
        }
        let prefix = prefix.trim_end_matches('/');
        // The store would spell such parts in another way than they were meant.
        if !prefix.is_empty() && Path::parse(prefix).is_err() {
            return Err(wrong());
        }
        Ok(Self::S3 {
            bucket: bucket.to_owned(),
            prefix: prefix.to_owned(),
        })
    }

    /// Open the object store. A folder must exist.
    ///
    /// # Errors
    /// The folder cannot be used, or a setting of S3 is wrong.
    pub fn open(&self) -> Result<Objects, ObjectError> {
        let failed = |source| ObjectError {
            name: self.to_string(),
            source,
        };
        Ok(match self {
            Self::Folder(folder) => {
                let store = LocalFileSystem::new_with_prefix(folder).map_err(failed)?;
                Objects::new(Arc::new(store.with_fsync(true)), Some(folder.clone()))
            }
            Self::S3 { bucket, prefix } => {
                let store = s3_builder(bucket).build().map_err(failed)?;
                Objects::new(Arc::new(PrefixStore::new(store, prefix.as_str())), None)
            }
        })
    }
}

impl std::fmt::Display for ObjectsUrl {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Folder(folder) => write!(f, "file://{}", folder.display()),
            Self::S3 { bucket, prefix } => write!(f, "s3://{bucket}/{prefix}"),
        }
    }
}

fn s3_builder(bucket: &str) -> AmazonS3Builder {
    let endpoint = ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"]
        .iter()
        .find_map(|name| std::env::var(name).ok())
        .unwrap_or_default();
    let client = ClientOptions::new()
        // Plain HTTP only for an endpoint that says so itself.
        .with_allow_http(endpoint.starts_with("http://"))
        .with_timeout(REQUEST_TIMEOUT)
        .with_connect_timeout(CONNECT_TIMEOUT);
    AmazonS3Builder::from_env()
        .with_bucket_name(bucket)
        .with_client_options(client)
        .with_retry(RetryConfig {
            backoff: BackoffConfig {
                init_backoff: RETRY_PAUSES.0,
                max_backoff: RETRY_PAUSES.1,
                base: 2.0,
            },
            max_retries: RETRIES_MAX,
            retry_timeout: RETRY_TIMEOUT,
        })
}

/// The text with `%41` as `A`; `None` when an escape is cut short or the bytes
/// are no text.
fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let digits = [rest.next()?, rest.next()?];
            let digits = std::str::from_utf8(&digits).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_are_read() {
        let s3 = |bucket: &str, prefix: &str| ObjectsUrl::S3 {
            bucket: bucket.into(),
            prefix: prefix.into(),
        };
        for (url, place) in [
            ("file:///srv/a%20b", ObjectsUrl::Folder("/srv/a b".into())),
            ("s3://farm", s3("farm", "")),
            ("s3://farm/", s3("farm", "")),
            ("s3://farm/a/b/", s3("farm", "a/b")),
        ] {
            assert_eq!(ObjectsUrl::parse(url).expect("known"), place, "{url}");
        }
        for url in [
            "",
            "/srv/farm",
            "file://relative",
            "file:///a%2",
            "s3://",
            "s3:///prefix",
            "s3://key:secret@farm",
            "s3://farm/a//b",
            "s3://farm/../b",
            "gs://farm",
        ] {
            assert!(ObjectsUrl::parse(url).is_err(), "{url}");
        }
    }
}
