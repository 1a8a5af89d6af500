//! `GET /v1/jobs/{id}/frames`: each frame's state, film hash and error.

use super::conditional::tagged_json;
use super::extract::{Segment, job_id, no_job, query};
use super::openapi::Fails;
use super::page::{self, PageQuery};
use super::problem::ApiError;
use super::view::so_far;
use crate::app::App;
use crate::store::{FrameRow, JobRow};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::HeaderMap;
use axum::response::Response;
use shearwater_shared::api::{FramePage, FrameState, FrameView};
use shearwater_shared::routes;
use std::sync::Arc;

/// Frames on a page when the client does not say.
const PAGE_SIZE: u32 = 100;
/// Most frames on a page: an answer of about 300 KiB.
const PAGE_SIZE_MAX: u32 = 1000;

/// A page of a job's frames in order, whether they have begun or not; 100 when
/// nothing is said, at most 1,000.
#[utoipa::path(
    get,
    path = routes::JOB_FRAMES,
    operation_id = "list_frames",
    tag = "jobs",
    params(
        ("id" = i64, Path, description = "the job's number", minimum = 1),
        PageQuery,
        ("If-None-Match" = Option<String>, Header, description = "an `ETag`")
    ),
    responses(
        (status = 200, description = "The page", body = FramePage, headers(("ETag" = String))),
        (status = 304, description = "The page is the same"),
        Fails<400>,
        Fails<404>,
        Fails<422>
    )
)]
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    params: Result<Query<PageQuery>, QueryRejection>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let params = query(params)?;
    let id = job_id(&id)?;
    let job = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    let limit = params
        .page_size
        .unwrap_or(PAGE_SIZE)
        .clamp(1, PAGE_SIZE_MAX);
    let listing = format!("frames {id}");
    let from: u32 = page::number(&listing, params.page_token.as_deref())?.unwrap_or(0);
    let end = from.saturating_add(limit).min(job.settings.frames);
    let mut rows = app
        .store
        .frames(id, from, limit)
        .await?
        .into_iter()
        .peekable();
    let mut frames = Vec::new();
    for frame in from..end {
        let row = rows.next_if(|row| row.frame == frame);
        frames.push(view(&app, &job, frame, row).await?);
    }
    let more = end < job.settings.frames;
    let page = FramePage {
        frames,
        next_page_token: more.then(|| page::token(&listing, &end.to_string())),
    };
    tagged_json(&headers, &page, &page)
}

async fn view(
    app: &App,
    job: &JobRow,
    frame: u32,
    row: Option<FrameRow>,
) -> Result<FrameView, ApiError> {
    let row = row.unwrap_or(FrameRow {
        frame,
        units_done: 0,
        units_due: job.plan().first_units(&job.settings.stop),
        film_hash: None,
        error: None,
    });
    let state = match (&row.film_hash, row.units_done) {
        (Some(_), _) => FrameState::Done,
        (None, 0) => FrameState::Waiting,
        (None, _) => FrameState::Running,
    };
    // Few frames run at a time; finished ones keep their error.
    let error = match row.error {
        None if row.units_done > 0 => so_far(app, job.id, frame).await?,
        known => known,
    };
    Ok(FrameView {
        frame: job.settings.absolute_frame(frame),
        state,
        units_done: row.units_done,
        units_total: row.units_due,
        film_hash: row.film_hash,
        error,
    })
}
