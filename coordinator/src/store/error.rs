//! What can go wrong in the store.

use std::sync::Arc;

/// The store could not do what it was asked; nothing of it was done.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The database refused or failed.
    #[error("database, {what}: {source}")]
    Sql {
        /// What was attempted.
        what: &'static str,
        /// The database's words.
        source: sqlx::Error,
    },
    /// No connection.
    #[error("cannot open the database {url}: {source}; does it run, and may this user use it?")]
    Open {
        /// Which one, without its password.
        url: String,
        /// The database's words.
        source: sqlx::Error,
    },
    /// The tables could not be brought to this version.
    #[error(
        "database migration failed: {0}; is the database of another program or a later version?"
    )]
    Migrate(#[from] sqlx::migrate::MigrateError),
    /// A stored text does not read back.
    #[error(
        "database row of {what} cannot be read: {detail}; the database is damaged or of another version"
    )]
    Corrupt {
        /// Which row.
        what: &'static str,
        /// What is wrong with it.
        detail: String,
    },
    /// Another transaction was in between; asked once more, it will do.
    #[error("database: the {0} was changed at the same moment; try again")]
    Changed(&'static str),
    /// The failure of a transaction that many shared, told to each of them.
    #[error(transparent)]
    Shared(#[from] Arc<Self>),
    /// The URL is of no engine of this build.
    #[error(
        "database URL of scheme `{0}`: expected sqlite:///folder/farm.db or \
         postgres://user:password@host:5432/database"
    )]
    Engine(String),
}

impl StoreError {
    /// Whether the database failed or refused: it may do what is asked later.
    #[must_use]
    pub fn is_of_database(&self) -> bool {
        match self {
            Self::Sql { .. } | Self::Changed(_) => true,
            Self::Shared(error) => error.is_of_database(),
            _ => false,
        }
    }
}

/// Name the attempt in a database error.
pub(super) trait Attempt<T> {
    /// `what` was attempted.
    fn attempt(self, what: &'static str) -> Result<T, StoreError>;
}

impl<T> Attempt<T> for Result<T, sqlx::Error> {
    fn attempt(self, what: &'static str) -> Result<T, StoreError> {
        self.map_err(|source| StoreError::Sql { what, source })
    }
}

/// A stored text that does not read back.
pub(super) fn corrupt(what: &'static str, detail: impl std::fmt::Display) -> StoreError {
    StoreError::Corrupt {
        what,
        detail: detail.to_string(),
    }
}
