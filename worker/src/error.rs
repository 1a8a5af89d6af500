//! Why a worker ends, other than being told to.

/// An error that no retry can mend.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The coordinator's address is no usable URL.
    #[error("coordinator URL `{url}`: {message}")]
    Url {
        /// As given.
        url: String,
        /// What is wrong with it.
        message: String,
    },
    /// A setting is out of range.
    #[error("worker setting {field}: expected {expected}")]
    Config {
        /// Which one.
        field: &'static str,
        /// What it may be.
        expected: String,
    },
    /// The coordinator wants nothing to do with this worker: another numeric
    /// build, another protocol; quarantine, if the worker is to leave then.
    #[error("the coordinator refuses this worker: {title}: {detail}")]
    Refused {
        /// Kind of refusal.
        title: String,
        /// What to do about it.
        detail: String,
    },
    /// The operating system gives no thread.
    #[error("cannot start a render thread: {0}")]
    Thread(std::io::Error),
}
