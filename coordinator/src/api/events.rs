//! Progress of a job as server-sent events.

use super::extract::{Segment, job_id, no_job};
use super::openapi::Fails;
use super::problem::ApiError;
use super::view::job_view;
use crate::app::App;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream::{self, Stream};
use shearwater_shared::api::JobView;
use shearwater_shared::job::JobId;
use shearwater_shared::routes;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, watch};
use utoipa::ToSchema;

/// Pause between two events: people see no more, and hundreds of watchers cost
/// little.
const EVENT_EVERY: Duration = Duration::from_millis(250);
/// How often the revision is read when nothing happens here: changes that
/// another coordinator made.
const POLL_EVERY: Duration = Duration::from_millis(500);
/// Comment that keeps the connection open through proxies.
const COMMENT_EVERY: Duration = Duration::from_secs(15);
/// How long a client waits before it connects again: a coordinator that restarts
/// is back by then.
const RETRY_AFTER: Duration = Duration::from_secs(2);
/// Header by which a client that connects again says what it saw last.
const LAST_EVENT_ID: &str = "last-event-id";

/// The job's view at once and after each change, as server-sent events whose id
/// is the job's revision; ends with the job, its deletion, or the process.
///
/// Who connects again gets the present state whatever was missed, or 204 when the
/// job has ended and the last event was seen: then there is nothing more to wait for.
#[utoipa::path(
    get,
    path = routes::JOB_EVENTS,
    operation_id = "watch_job",
    tag = "jobs",
    params(
        ("id" = i64, Path, description = "the job's number", minimum = 1),
        ("Last-Event-ID" = Option<String>, Header, description = "`id` of the last event that was seen")
    ),
    responses(
        (status = 200, description = "Events; each one's data is a job", content_type = "text/event-stream",
            body = JobEvent),
        (status = 204, description = "The job has ended, and its last event was seen"),
        Fails<404>
    )
)]
pub(crate) async fn events(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let id = job_id(&id)?;
    let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    let seen = headers.get(LAST_EVENT_ID).and_then(|v| v.to_str().ok());
    if row.finished_ms.is_some() && seen == Some(row.rev.to_string().as_str()) {
        // What tells browsers not to come back.
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let events = job_events(app, id)?;
    let keep_alive = KeepAlive::new().interval(COMMENT_EVERY);
    let unbuffered = [(HeaderName::from_static("x-accel-buffering"), "no")];
    Ok((unbuffered, Sse::new(events).keep_alive(keep_alive)).into_response())
}

struct Watcher {
    _permit: OwnedSemaphorePermit,
    app: Arc<App>,
    id: JobId,
    sent_rev: i64,
    last: bool,
    changes: watch::Receiver<u64>,
    stopping: watch::Receiver<bool>,
}

fn job_events(
    app: Arc<App>,
    id: JobId,
) -> Result<impl Stream<Item = Result<Event, Infallible>>, ApiError> {
    let waiters = Arc::clone(&app.waiters);
    let watcher = Watcher {
        _permit: waiters.try_acquire_owned().map_err(|_| ApiError::Busy)?,
        id,
        sent_rev: -1,
        last: false,
        changes: app.change.subscribe(),
        stopping: app.stopping.subscribe(),
        app,
    };
    Ok(stream::unfold(watcher, |mut watcher| async move {
        let event = watcher.next_event().await?;
        Some((Ok(event), watcher))
    }))
}

impl Watcher {
    /// The next event; `None` ends the stream.
    async fn next_event(&mut self) -> Option<Event> {
        if self.last {
            return None;
        }
        if self.sent_rev >= 0 && !self.pause(EVENT_EVERY).await {
            return None;
        }
        loop {
            self.changes.borrow_and_update();
            // A store that fails for a moment must not end the stream.
            match self.app.store.job_rev(self.id).await {
                Ok(None) => return None,
                Ok(Some(rev)) if rev != self.sent_rev => {
                    if let Some(event) = self.event().await {
                        return Some(event);
                    }
                }
                Ok(Some(_)) => {}
                Err(error) => tracing::warn!(%error, "event stream"),
            }
            tokio::select! {
                changed = self.changes.changed() => { changed.ok()?; }
                stop = self.stopping.wait_for(|stop| *stop) => { let _ = stop; return None; }
                () = tokio::time::sleep(POLL_EVERY) => {}
            }
        }
    }

    async fn event(&mut self) -> Option<Event> {
        let row = self.app.store.job(self.id).await.ok()??;
        let view = job_view(&self.app, row).await.ok()?;
        let event = told(&view, self.sent_rev < 0)?;
        self.sent_rev = view.rev;
        self.last = view.done;
        Some(event)
    }

    /// False when the process ends meanwhile.
    async fn pause(&mut self, time: Duration) -> bool {
        tokio::select! {
            _ = self.stopping.wait_for(|stop| *stop) => false,
            () = tokio::time::sleep(time) => true,
        }
    }
}

/// One event, for the document.
#[derive(Debug, ToSchema)]
#[allow(dead_code)]
struct JobEvent {
    /// The job's `rev`.
    id: String,
    /// The job, as JSON.
    data: String,
    /// Milliseconds before a client connects again; in the first event.
    retry: Option<u64>,
}

fn told(view: &JobView, first: bool) -> Option<Event> {
    let data = serde_json::to_string(view).ok()?;
    let event = Event::default().id(view.rev.to_string()).data(data);
    Some(if first {
        event.retry(RETRY_AFTER)
    } else {
        event
    })
}
