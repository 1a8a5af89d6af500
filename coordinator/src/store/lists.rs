//! One statement for many rows: they are given as one JSON list of lists, `$1`.
//!
//! Both engines read a column of a row as `value ->> n`; only the function that makes
//! rows of a list has another name. The statement is the same for any length, so it is
//! prepared once.

use super::error::{StoreError, corrupt};
use super::open::Engine;
use serde::Serialize;

/// One statement in the words of either engine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Listed {
    pub(super) sqlite: &'static str,
    pub(super) postgres: &'static str,
}

impl Listed {
    /// The statement for `engine`.
    pub(super) const fn of(self, engine: Engine) -> &'static str {
        match engine {
            Engine::Sqlite => self.sqlite,
            Engine::Postgres => self.postgres,
        }
    }
}

/// `listed!("SELECT … FROM ", " …")`: the rows of `$1` stand between the two texts.
macro_rules! listed {
    ($head:expr, $tail:expr) => {
        $crate::store::lists::Listed {
            sqlite: concat!($head, "json_each($1)", $tail),
            postgres: concat!($head, "jsonb_array_elements(CAST($1 AS jsonb))", $tail),
        }
    };
}
pub(super) use listed;

/// The rows as `$1`.
pub(super) fn list<T: Serialize>(rows: &[T]) -> Result<String, StoreError> {
    serde_json::to_string(rows).map_err(|e| corrupt("list of rows", e))
}
