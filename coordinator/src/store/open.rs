//! Opening: pools, pragmas, migrations.

use super::error::{Attempt, StoreError};
use super::url::DatabaseUrl;
use crate::metrics::{StoreMeasures, Transaction as Kind};
use sqlx::any::AnyPoolOptions;
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::{Any, AnyPool, Connection, Executor, Row, SqlSafeStr, Transaction};
use std::time::Duration;

/// Reading connections of one process: progress, listings and pictures read
/// at once; more would only queue on two cores.
const READ_CONNECTIONS: u32 = 4;
/// Writing connections of one process to PostgreSQL. More only queue: results of
/// one job stand in line at its row.
const WRITE_CONNECTIONS: u32 = 6;
/// Tries at migrating: SQLite takes no lock, so processes that start at once
/// may trip over each other (measured: two tries were always enough).
const MIGRATION_TRIES: u32 = 5;
/// Pause between two of them.
const MIGRATION_PAUSE: Duration = Duration::from_millis(50);
/// Wait for a connection to SQLite: longer than its lock is waited for.
const SQLITE_ACQUIRE_TIMEOUT: Duration = Duration::from_secs(25);
/// Wait for a connection to PostgreSQL: longer than a server needs to restart a
/// session, short enough that a request says soon that the server is gone.
const POSTGRES_ACQUIRE_TIMEOUT: Duration = Duration::from_secs(8);
/// What a connection to SQLite begins with. The lock is waited for at most 20 s.
const SQLITE_BEGINS: [&str; 4] = [
    "PRAGMA busy_timeout=20000",
    "PRAGMA journal_mode=WAL",
    "PRAGMA synchronous=FULL",
    "PRAGMA foreign_keys=ON",
];
/// What a session of PostgreSQL begins with. No statement of ours takes long; a
/// coordinator that is frozen inside a transaction must not keep its locks: the
/// server ends it, and nothing of it has happened.
const POSTGRES_BEGINS: [&str; 4] = [
    "SET statement_timeout = '30s'",
    "SET lock_timeout = '15s'",
    "SET idle_in_transaction_session_timeout = '10s'",
    "SET synchronous_commit = on",
];
/// Tables of which each row is written several times within minutes: vacuumed
/// after so many dead rows instead of after a fifth of the table, which slowed
/// claims by half within half a minute.
const HOT_TABLES: [&str; 5] = ["unit", "part", "tilefold", "lease", "worker"];

/// Which database speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// A file beside the objects; one machine, any number of processes.
    Sqlite,
    /// A server; any number of machines.
    Postgres,
}

/// The open store. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Store {
    pub(super) engine: Engine,
    pub(super) read: AnyPool,
    pub(super) write: AnyPool,
    pub(crate) measures: StoreMeasures,
}

impl Store {
    /// Open (and create or migrate) the database.
    ///
    /// # Errors
    /// No connection, or tables of a later version.
    pub async fn open(url: &DatabaseUrl) -> Result<Self, StoreError> {
        sqlx::any::install_default_drivers();
        let writers = match url.engine() {
            Engine::Sqlite => 1,
            Engine::Postgres => WRITE_CONNECTIONS,
        };
        migrate(url).await?;
        let write = pool(url, writers).await?;
        let store = Self {
            engine: url.engine(),
            read: pool(url, READ_CONNECTIONS).await?,
            write,
            measures: StoreMeasures::default(),
        };
        store.vacuum_hot_tables_often().await?;
        Ok(store)
    }

    /// The engine behind it.
    #[must_use]
    pub const fn engine(&self) -> Engine {
        self.engine
    }

    /// Whether the database answers.
    ///
    /// # Errors
    /// It does not.
    pub async fn ping(&self) -> Result<(), StoreError> {
        sqlx::query("SELECT CAST(1 AS BIGINT)")
            .fetch_one(&self.read)
            .await
            .attempt("ping")?;
        Ok(())
    }

    /// Whether the database can be written.
    ///
    /// # Errors
    /// It cannot.
    pub async fn try_write(&self) -> Result<(), StoreError> {
        let _timed = self.measures.transaction(Kind::Probe);
        sqlx::query("UPDATE counter SET value = value + 1 WHERE name = 'probe'")
            .execute(&self.write)
            .await
            .attempt("try to write")?;
        Ok(())
    }

    /// Whether the tables are those of this version: another coordinator of a later
    /// one may have migrated them since this one started.
    ///
    /// # Errors
    /// The database does not answer.
    pub async fn tables_fit(&self) -> Result<bool, StoreError> {
        let row = sqlx::query(
            "SELECT CAST(coalesce(max(version), 0) AS BIGINT) AS version FROM _sqlx_migrations",
        )
        .fetch_one(&self.read)
        .await
        .attempt("read version of tables")?;
        let found: i64 = row.try_get("version").attempt("version")?;
        let ours = migrator().iter().map(|migration| migration.version).max();
        Ok(ours == Some(found))
    }

    /// Close every connection; waits for running statements.
    pub async fn close(&self) {
        self.read.close().await;
        self.write.close().await;
    }

    /// Begin a transaction that will write: SQLite must take its lock at once,
    /// since a reader that becomes a writer fails instead of waiting.
    pub(super) async fn begin(&self) -> Result<Transaction<'static, Any>, StoreError> {
        let begin = match self.engine {
            Engine::Sqlite => "BEGIN IMMEDIATE",
            Engine::Postgres => "BEGIN",
        };
        self.write.begin_with(begin).await.attempt("begin")
    }

    /// Tell PostgreSQL, once, to vacuum the tables that are written most.
    async fn vacuum_hot_tables_often(&self) -> Result<(), StoreError> {
        if self.engine == Engine::Sqlite {
            return Ok(());
        }
        for table in HOT_TABLES {
            let told = sqlx::query(
                "SELECT 1 FROM pg_class WHERE oid = to_regclass($1) AND reloptions IS NOT NULL",
            )
            .bind(table)
            .fetch_optional(&self.read)
            .await
            .attempt("look at vacuum settings")?;
            if told.is_none() {
                // The name is ours.
                let sql = format!(
                    "ALTER TABLE {table} SET (autovacuum_vacuum_scale_factor = 0.0, \
                     autovacuum_vacuum_threshold = 20000, fillfactor = 80)"
                );
                sqlx::query(sqlx::AssertSqlSafe(sql))
                    .execute(&self.write)
                    .await
                    .attempt("set vacuum settings")?;
            }
        }
        Ok(())
    }
}

/// Bring the tables to this version, over a connection that may take its time: a
/// large table needs more than a statement of ours may.
async fn migrate(url: &DatabaseUrl) -> Result<(), StoreError> {
    let begins: &'static [&'static str] = match url.engine() {
        Engine::Sqlite => &SQLITE_BEGINS,
        Engine::Postgres => &[],
    };
    let pool = pool_of(url, 1, begins).await?;
    let mut tried = 0;
    let migrated = loop {
        tried += 1;
        match migrator().run(&pool).await {
            Err(error) if tried < MIGRATION_TRIES => {
                tracing::debug!(%error, tried, "migration collided, trying again");
                tokio::time::sleep(MIGRATION_PAUSE).await;
            }
            migrated => break migrated,
        }
    };
    pool.close().await;
    Ok(migrated?)
}

fn migrator() -> Migrator {
    let simple = |version, name: &'static str, sql: &'static str| {
        let kind = MigrationType::Simple;
        Migration::new(version, name.into(), kind, sql.into_sql_str(), false)
    };
    Migrator::with_migrations(vec![
        simple(1, "init", include_str!("../../migrations/0001_init.sql")),
        simple(
            2,
            "frames",
            include_str!("../../migrations/0002_frames.sql"),
        ),
        simple(
            3,
            "animation",
            include_str!("../../migrations/0003_animation.sql"),
        ),
        simple(
            4,
            "errors",
            include_str!("../../migrations/0004_errors.sql"),
        ),
        simple(5, "stop", include_str!("../../migrations/0005_stop.sql")),
        simple(
            6,
            "stores",
            include_str!("../../migrations/0006_stores.sql"),
        ),
        simple(
            7,
            "leases",
            include_str!("../../migrations/0007_leases.sql"),
        ),
        simple(
            8,
            "tokens",
            include_str!("../../migrations/0008_tokens.sql"),
        ),
        simple(
            9,
            "webhook",
            include_str!("../../migrations/0009_webhook.sql"),
        ),
        simple(
            10,
            "job_ended",
            include_str!("../../migrations/0010_job_ended.sql"),
        ),
    ])
}

async fn pool(url: &DatabaseUrl, connections: u32) -> Result<AnyPool, StoreError> {
    let begins: &'static [&'static str] = match url.engine() {
        Engine::Sqlite => &SQLITE_BEGINS,
        Engine::Postgres => &POSTGRES_BEGINS,
    };
    pool_of(url, connections, begins).await
}

async fn pool_of(
    url: &DatabaseUrl,
    connections: u32,
    begins: &'static [&'static str],
) -> Result<AnyPool, StoreError> {
    let timeout = match url.engine() {
        Engine::Sqlite => SQLITE_ACQUIRE_TIMEOUT,
        Engine::Postgres => POSTGRES_ACQUIRE_TIMEOUT,
    };
    AnyPoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(timeout)
        .after_connect(move |connection, _| {
            Box::pin(async move {
                for statement in begins {
                    connection.execute(*statement).await?;
                }
                Ok(())
            })
        })
        // After some errors (disk full, I/O) SQLite ends a transaction by itself,
        // and the driver goes on counting it: such a connection could never
        // begin another one.
        .before_acquire(|connection, _| {
            Box::pin(async move { Ok(!connection.is_in_transaction()) })
        })
        .connect(url.secret())
        .await
        .map_err(|source| StoreError::Open {
            url: url.to_string(),
            source,
        })
}

#[cfg(test)]
mod tests {
    use super::super::claim::LEASE_UNITS;
    use super::super::commit::COUNT_UNITS;
    use super::*;

    async fn store(folder: &tempfile::TempDir) -> Store {
        let url = format!("sqlite://{}/farm.db?mode=rwc", folder.path().display());
        let url = DatabaseUrl::parse(&url).expect("URL");
        Store::open(&url).await.expect("open")
    }

    #[tokio::test]
    async fn a_transaction_that_the_engine_ended_costs_no_connection() {
        let folder = tempfile::tempdir().expect("folder");
        let store = store(&folder).await;
        let mut tx = store.begin().await.expect("begin");
        // What SQLite does by itself when the disk is full.
        sqlx::query("ROLLBACK")
            .execute(&mut *tx)
            .await
            .expect("ended");
        drop(tx);
        let tx = store.begin().await.expect("begin again");
        tx.commit().await.expect("commit");
    }

    #[tokio::test]
    async fn lists_of_runs_are_looked_up_one_by_one() {
        let folder = tempfile::tempdir().expect("folder");
        let store = store(&folder).await;
        for sql in [COUNT_UNITS, LEASE_UNITS] {
            let sql = format!("EXPLAIN QUERY PLAN {}", sql.of(Engine::Sqlite));
            let rows = sqlx::query(sqlx::AssertSqlSafe(sql)).bind("[]");
            let rows = rows.fetch_all(&store.read).await.expect("plan");
            let plan: Vec<String> = rows.iter().map(|row| row.get("detail")).collect();
            let (first, second) = (&plan[0], &plan[1]);
            assert!(first.contains("json_each"), "{plan:?}");
            assert!(
                second.contains("SEARCH unit") && second.contains("job=? AND frame=? AND tile=?"),
                "{plan:?}"
            );
        }
    }

    #[tokio::test]
    async fn ready_and_leased_units_are_found_by_their_index() {
        let folder = tempfile::tempdir().expect("folder");
        let store = store(&folder).await;
        for (condition, index) in [
            ("state = 0", "unit_ready"),
            ("state = 1", "unit_leased"),
            ("state = 1 AND lease = 7", "unit_leased"),
        ] {
            let sql = format!(
                "EXPLAIN QUERY PLAN SELECT frame, tile, block FROM unit WHERE job = 1 \
                 AND {condition} ORDER BY frame, tile, block LIMIT 9"
            );
            let rows = sqlx::query(sqlx::AssertSqlSafe(sql))
                .fetch_all(&store.read)
                .await
                .expect("plan");
            let plan: Vec<String> = rows.iter().map(|row| row.get("detail")).collect();
            let plan = plan.join("; ");
            assert!(plan.contains(index), "{plan}");
            assert!(!plan.contains("TEMP B-TREE"), "{plan}");
        }
    }
}
