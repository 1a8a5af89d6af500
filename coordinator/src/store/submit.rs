//! A job enters the store.

use super::asset_use::note_assets;
use super::error::{Attempt, StoreError, corrupt};
use super::idem::{self, IdempotencyKey, Repetition};
use super::open::Store;
use super::rows::{big, int};
use super::webhooks::{self, NewWebhook};
use shearwater_shared::job::{JobId, Manifest, RenderSettings};
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::scene::Post;
use sqlx::{Any, Transaction};

/// A checked job, ready to be stored.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// Name for people.
    pub name: String,
    /// Scene and files; all of them are stored already.
    pub manifest: Manifest,
    /// What is rendered.
    pub settings: RenderSettings,
    /// The scene's way from radiance to a picture.
    pub post: Post,
    /// Frames of the scene's animation per second.
    pub fps: Option<f64>,
    /// Frames of the scene's animation.
    pub animation_frames: Option<u32>,
    /// Higher is served first.
    pub priority: i32,
    /// Public part of the token that submits it.
    pub owner: Option<String>,
    /// Random: decides which runs are audited.
    pub audit_salt: i64,
    /// Whom to tell its end.
    pub webhook: Option<NewWebhook>,
    /// The client's idempotency key.
    pub idempotency: Option<IdempotencyKey>,
}

/// What became of a submission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Submitted {
    /// A new job.
    New(JobId),
    /// The job that an equal submission with this key made before.
    Same(JobId),
    /// The key was used with another body.
    OtherBody(JobId),
    /// An asset of the manifest is not stored (any more).
    AssetMissing,
}

impl Store {
    /// Store a job. Its units follow frame by frame, when they are claimed.
    ///
    /// # Errors
    /// The database failed; no job was made.
    pub async fn submit(&self, new: &NewJob, now_ms: i64) -> Result<Submitted, StoreError> {
        let mut tx = self.begin().await?;
        // The counter's row is locked first: two submissions with one key
        // stand in line here, on both engines.
        let id = next_id(&mut tx, "job").await?;
        if let Some(key) = &new.idempotency {
            match idem::known(&mut tx, key).await? {
                Some(Repetition::Same(job)) => return Ok(Submitted::Same(job)),
                Some(Repetition::OtherBody(job)) => return Ok(Submitted::OtherBody(job)),
                None => idem::remember(&mut tx, key, JobId(id), now_ms).await?,
            }
        }
        insert_job(&mut tx, id, new, now_ms).await?;
        if !note_assets(&mut tx, JobId(id), &new.manifest, now_ms).await? {
            return Ok(Submitted::AssetMissing);
        }
        if let Some(webhook) = &new.webhook {
            webhooks::insert(&mut tx, JobId(id), webhook).await?;
        }
        tx.commit().await.attempt("commit submission")?;
        Ok(Submitted::New(JobId(id)))
    }
}

async fn insert_job(
    tx: &mut Transaction<'static, Any>,
    id: i64,
    new: &NewJob,
    now_ms: i64,
) -> Result<(), StoreError> {
    let plan = Plan::new(&new.settings);
    let frames = u64::from(new.settings.frames);
    let blocks = plan.first_blocks(&new.settings.stop);
    let first_samples: u64 = (0..plan.tiles())
        .map(|tile| {
            plan.run_samples(&Run {
                frame: 0,
                tile,
                block0: 0,
                block1: blocks,
            })
        })
        .sum();
    let samples_total = first_samples.saturating_mul(frames);
    let units_due = plan.first_units(&new.settings.stop).saturating_mul(frames);
    let text = |what, value: Result<String, serde_json::Error>| value.map_err(|e| corrupt(what, e));
    let fps = new.fps.as_ref().map(serde_json::to_string);
    let fps = fps.map(|fps| text("fps", fps)).transpose()?;
    sqlx::query(
        "INSERT INTO job (id, name, manifest, scene_hash, settings, post, priority, frames, \
         tiles, blocks, samples_total, submitted_ms, fps, animation_frames, units_due, stop_s, \
         owner, audit_salt, assets_noted) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, 1)",
    )
    .bind(id)
    .bind(&new.name)
    .bind(text("manifest", serde_json::to_string(&new.manifest))?)
    .bind(new.manifest.scene.to_string())
    .bind(text("settings", serde_json::to_string(&new.settings))?)
    .bind(text("post", serde_json::to_string(&new.post))?)
    .bind(i64::from(new.priority))
    .bind(big(frames))
    .bind(i64::from(plan.tiles()))
    .bind(i64::from(blocks))
    .bind(big(samples_total))
    .bind(now_ms)
    .bind(fps)
    .bind(new.animation_frames.map(i64::from))
    .bind(big(units_due))
    .bind(new.settings.stop.seconds.map(i64::from))
    .bind(&new.owner)
    .bind(new.audit_salt)
    .execute(&mut **tx)
    .await
    .attempt("insert job")?;
    Ok(())
}

/// The next number of `name`, unique for ever.
pub(super) async fn next_id(
    tx: &mut Transaction<'static, Any>,
    name: &'static str,
) -> Result<i64, StoreError> {
    next_ids(tx, name, 1).await
}

/// The first of the next `count` numbers of `name`, unique for ever.
pub(super) async fn next_ids(
    tx: &mut Transaction<'static, Any>,
    name: &'static str,
    count: usize,
) -> Result<i64, StoreError> {
    let count = i64::try_from(count).unwrap_or(i64::MAX);
    let row = sqlx::query("UPDATE counter SET value = value + $2 WHERE name = $1 RETURNING value")
        .bind(name)
        .bind(count)
        .fetch_one(&mut **tx)
        .await
        .attempt("count up")?;
    Ok(int(&row, "value")? - count + 1)
}
