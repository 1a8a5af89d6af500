//! Which job needs which asset, and which assets nobody needs.

use super::error::corrupt;
use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::{int, json, text};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{JobId, Manifest};
use sqlx::{Any, AssertSqlSafe, Row, Transaction};
use std::collections::BTreeSet;

/// Hashes of one statement; a manifest has up to 10,000.
const HASHES_PER_STATEMENT: usize = 100;
/// Manifests of jobs of before that are read together: 1 MiB each at most.
const MANIFESTS_PER_STEP: i64 = 16;
/// Assets that one sweep dooms at once.
const DOOMED_MAX: i64 = 1000;
/// A use is noted again after this time only: a farm asks often.
const USE_NOTED_MS: i64 = 3_600_000;

impl Store {
    /// Note that somebody means to use these assets: none of them goes before the
    /// grace time has passed again.
    ///
    /// # Errors
    /// The database failed.
    pub async fn use_asset(&self, hash: &ContentHash, now_ms: i64) -> Result<(), StoreError> {
        sqlx::query(
            "UPDATE asset SET used_ms = $2 WHERE hash = $1 AND doomed = 0 AND used_ms < $3",
        )
        .bind(hash.to_string())
        .bind(now_ms)
        .bind(now_ms.saturating_sub(USE_NOTED_MS))
        .execute(&self.write)
        .await
        .attempt("note use of asset")?;
        Ok(())
    }

    /// Note the assets of jobs that are older than such notes; how many jobs. With
    /// 0 every job is noted.
    ///
    /// # Errors
    /// The database failed.
    pub async fn note_old_manifests(&self, now_ms: i64) -> Result<usize, StoreError> {
        let rows = sqlx::query("SELECT id, manifest FROM job WHERE assets_noted = 0 LIMIT $1")
            .bind(MANIFESTS_PER_STEP)
            .fetch_all(&self.read)
            .await
            .attempt("read manifests")?;
        for row in &rows {
            let job = JobId(int(row, "id")?);
            let mut tx = self.begin().await?;
            // What is missing was lost before: nobody is served by an error here.
            note_assets(&mut tx, job, &json(row, "manifest")?, now_ms).await?;
            sqlx::query("UPDATE job SET assets_noted = 1 WHERE id = $1")
                .bind(job.0)
                .execute(&mut *tx)
                .await
                .attempt("note manifest")?;
            tx.commit().await.attempt("commit manifest")?;
        }
        Ok(rows.len())
    }

    /// Doom assets that no job needs and nobody has used since `before_ms`: from
    /// now on they are not stored, for whoever asks. Returns all that are doomed,
    /// those of an earlier sweep that was cut off too, at most a thousand.
    ///
    /// # Errors
    /// The database failed.
    pub async fn doom_assets(&self, before_ms: i64) -> Result<Vec<ContentHash>, StoreError> {
        // A submission takes the rows of its assets, so one of both comes first.
        sqlx::query(
            "UPDATE asset SET doomed = 1 WHERE doomed = 0 AND used_ms < $1 \
             AND hash IN (SELECT a.hash FROM asset a WHERE a.doomed = 0 AND a.used_ms < $1 \
             AND NOT EXISTS (SELECT 1 FROM job_asset j WHERE j.hash = a.hash) LIMIT $2)",
        )
        .bind(before_ms)
        .bind(DOOMED_MAX)
        .execute(&self.write)
        .await
        .attempt("doom assets")?;
        sqlx::query("SELECT hash FROM asset WHERE doomed = 1 ORDER BY hash LIMIT $1")
            .bind(DOOMED_MAX)
            .fetch_all(&self.read)
            .await
            .attempt("read doomed assets")?
            .iter()
            .map(|row| text(row, "hash")?.parse().map_err(|e| corrupt("asset", e)))
            .collect()
    }

    /// Doom an asset's object that has no row; false when it has one.
    ///
    /// # Errors
    /// The database failed.
    pub async fn doom_nameless(&self, hash: &ContentHash) -> Result<bool, StoreError> {
        let done = sqlx::query(
            "INSERT INTO asset (hash, size, created_ms, used_ms, doomed) VALUES ($1, 0, 0, 0, 1) \
             ON CONFLICT DO NOTHING",
        )
        .bind(hash.to_string())
        .execute(&self.write)
        .await
        .attempt("doom asset")?;
        Ok(done.rows_affected() == 1)
    }

    /// A doomed asset's object is gone.
    ///
    /// # Errors
    /// The database failed.
    pub async fn forget_asset(&self, hash: &ContentHash) -> Result<(), StoreError> {
        sqlx::query("DELETE FROM asset WHERE hash = $1 AND doomed = 1")
            .bind(hash.to_string())
            .execute(&self.write)
            .await
            .attempt("forget asset")?;
        Ok(())
    }
}

/// Note which assets `job` needs; false when one of them is not stored (any more).
pub(super) async fn note_assets(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    manifest: &Manifest,
    now_ms: i64,
) -> Result<bool, StoreError> {
    let files = manifest.files.values().map(|file| file.hash.to_string());
    let mut hashes: BTreeSet<String> = files.collect();
    hashes.insert(manifest.scene.to_string());
    let hashes: Vec<String> = hashes.into_iter().collect();
    let mut found = 0;
    for some in hashes.chunks(HASHES_PER_STATEMENT) {
        let places: Vec<String> = (2..some.len() + 2).map(|n| format!("${n}")).collect();
        let places = places.join(", ");
        // First the rows themselves, so that no sweep can doom them meanwhile.
        let take = format!("UPDATE asset SET used_ms = $1 WHERE doomed = 0 AND hash IN ({places})");
        found += bound(&take, now_ms, some)
            .execute(&mut **tx)
            .await
            .attempt("take assets")?
            .rows_affected();
        let note = format!(
            "INSERT INTO job_asset (hash, job) SELECT hash, $1 FROM asset \
             WHERE doomed = 0 AND hash IN ({places}) ON CONFLICT DO NOTHING"
        );
        bound(&note, job.0, some)
            .execute(&mut **tx)
            .await
            .attempt("note assets")?;
    }
    Ok(found == hashes.len() as u64)
}

// The text holds our own words and numbered places only.
fn bound<'q>(
    sql: &str,
    first: i64,
    hashes: &[String],
) -> sqlx::query::Query<'q, Any, sqlx::any::AnyArguments> {
    let mut query = sqlx::query(AssertSqlSafe(sql.to_owned())).bind(first);
    for hash in hashes {
        query = query.bind(hash.clone());
    }
    query
}

/// Rows of each table, for statements about growth.
pub const COUNTED_TABLES: [&str; 11] = [
    "job",
    "frame",
    "unit",
    "part",
    "tilefold",
    "lease",
    "asset",
    "job_asset",
    "audit",
    "distrust",
    "job_log",
];

impl Store {
    /// How many rows each of [`COUNTED_TABLES`] has; reads them all.
    ///
    /// # Errors
    /// The database failed.
    pub async fn row_counts(&self) -> Result<Vec<(&'static str, u64)>, StoreError> {
        let mut counts = Vec::with_capacity(COUNTED_TABLES.len());
        for table in COUNTED_TABLES {
            let sql = format!("SELECT count(*) AS rows FROM {table}");
            let row = sqlx::query(AssertSqlSafe(sql))
                .fetch_one(&self.read)
                .await
                .attempt("count rows")?;
            let rows: i64 = row.try_get("rows").attempt("rows")?;
            counts.push((table, u64::try_from(rows).unwrap_or(0)));
        }
        Ok(counts)
    }
}
