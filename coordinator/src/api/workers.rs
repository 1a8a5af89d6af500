//! Workers seen lately.

use super::extract::query;
use super::openapi::Fails;
use super::page::{self, PageQuery};
use super::problem::ApiError;
use crate::app::{App, now_ms};
use crate::farm::QUARANTINE_MS;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use shearwater_shared::api::{WorkerId, WorkerPage, WorkerView};
use shearwater_shared::routes;
use std::sync::Arc;

/// Silence after which a worker is no longer shown.
const SHOWN_MS: i64 = 5 * 60 * 1000;

/// Workers on a page when the client does not say.
const PAGE_SIZE: u32 = 200;
/// Most workers on a page: an answer of about 300 KiB.
const PAGE_SIZE_MAX: u32 = 1000;
/// What its tokens are bound to.
const LISTING: &str = "workers";

/// A page of the workers heard of within five minutes, in order of their
/// instances; 200 when nothing is said, at most 1,000.
#[utoipa::path(
    get,
    path = routes::WORKERS,
    operation_id = "list_workers",
    tag = "workers",
    params(PageQuery),
    responses((status = 200, description = "The page", body = WorkerPage), Fails<400>, Fails<422>)
)]
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    params: Result<Query<PageQuery>, QueryRejection>,
) -> Result<Json<WorkerPage>, ApiError> {
    let params = query(params)?;
    let limit = params.page_size.unwrap_or(PAGE_SIZE);
    let limit = limit.clamp(1, PAGE_SIZE_MAX) as usize;
    let after = page::position(LISTING, params.page_token.as_deref())?;
    let now_ms = now_ms();
    let held = app.store.runs_held().await?;
    let mut workers = app.store.workers(now_ms - SHOWN_MS).await?;
    workers.sort_by(|a, b| a.instance.cmp(&b.instance));
    workers.retain(|worker| after.as_ref().is_none_or(|after| worker.instance > *after));
    let more = workers.len() > limit;
    workers.truncate(limit);
    let last = workers.last().filter(|_| more);
    let next_page_token = last.map(|worker| page::token(LISTING, &worker.instance));
    let views = workers.into_iter().map(|worker| {
        let left_ms = if worker.distrusted {
            QUARANTINE_MS
        } else {
            worker.quarantined_until_ms - now_ms
        };
        let quarantined_s = (left_ms > 0).then(|| left_ms.div_euclid(1000) + 1);
        WorkerView {
            threads: worker.threads,
            samples_per_s: worker.milli_samples_per_s as f64 / 1000.0,
            silent_ms: (now_ms - worker.seen_ms).max(0),
            runs_held: held.get(&worker.instance).copied().unwrap_or(0),
            worker: WorkerId {
                name: worker.name,
                instance: worker.instance,
            },
            quarantined_s,
            quarantine_reason: worker.quarantine_reason.filter(|_| left_ms > 0),
        }
    });
    Ok(Json(WorkerPage {
        workers: views.collect(),
        next_page_token,
    }))
}
