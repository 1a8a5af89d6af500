//! Which database: a URL, and how it may be shown.

use super::error::StoreError;
use super::open::Engine;
use std::fmt;

/// The URL of a database. Shown without its password and without its
/// parameters, which may hold one.
#[derive(Clone, PartialEq, Eq)]
pub struct DatabaseUrl {
    engine: Engine,
    url: String,
}

impl DatabaseUrl {
    /// `sqlite:///folder/farm.db` (made when it is missing) or
    /// `postgres://user:password@host:5432/database`.
    ///
    /// # Errors
    /// No engine of this build.
    pub fn parse(url: &str) -> Result<Self, StoreError> {
        let scheme = url.split_once(':').map_or("", |(scheme, _)| scheme);
        let engine = match scheme {
            "sqlite" => Engine::Sqlite,
            "postgres" | "postgresql" => Engine::Postgres,
            // What follows the scheme may be a password.
            _ => return Err(StoreError::Engine(scheme.chars().take(20).collect())),
        };
        let mut url = url.to_owned();
        if engine == Engine::Sqlite && !url.contains('?') {
            url.push_str("?mode=rwc");
        }
        Ok(Self { engine, url })
    }

    /// The engine that it names.
    #[must_use]
    pub const fn engine(&self) -> Engine {
        self.engine
    }

    /// All of it, with its password.
    pub(super) fn secret(&self) -> &str {
        &self.url
    }
}

impl fmt::Display for DatabaseUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = self.url.split(['?', '#']).next().unwrap_or_default();
        // A password may hold an unescaped `@`: the last one ends it.
        match (shown.split_once("://"), shown.rsplit_once('@')) {
            (Some((scheme, rest)), Some((_, place))) => {
                let user = rest.split([':', '@']).next().unwrap_or_default();
                write!(f, "{scheme}://{user}@{place}")
            }
            _ => f.write_str(shown),
        }
    }
}

impl fmt::Debug for DatabaseUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DatabaseUrl({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passwords_are_never_shown() {
        for (url, shown) in [
            (
                "postgres://farm:secret@db.example:5432/farm?sslmode=require&password=secret",
                "postgres://farm@db.example:5432/farm",
            ),
            ("postgres://farm:se@cret@db/farm", "postgres://farm@db/farm"),
            ("postgresql://db/farm", "postgresql://db/farm"),
            ("sqlite:///a%20b/farm.db", "sqlite:///a%20b/farm.db"),
        ] {
            let url = DatabaseUrl::parse(url).expect("known engine");
            assert_eq!(url.to_string(), shown);
            assert!(!format!("{url:?}").contains("cret"));
        }
        let error = DatabaseUrl::parse("mysql://u:secret@h/d").expect_err("no such engine");
        assert!(!error.to_string().contains("secret"), "{error}");
        assert!(error.to_string().contains("mysql"), "{error}");
    }

    #[test]
    fn a_database_file_is_made_when_it_is_missing() {
        let url = DatabaseUrl::parse("sqlite:///a/farm.db").expect("sqlite");
        assert_eq!(url.secret(), "sqlite:///a/farm.db?mode=rwc");
        let url = DatabaseUrl::parse("sqlite:///a/farm.db?mode=rw").expect("sqlite");
        assert_eq!(url.secret(), "sqlite:///a/farm.db?mode=rw");
    }
}
