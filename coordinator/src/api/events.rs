//! Progress of a job as server-sent events.

use super::extract::{Segment, job_id, no_job};
use super::problem::ApiError;
use super::view::job_view;
use crate::app::App;
use axum::extract::State;
use axum::http::HeaderName;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream::{self, Stream};
use shearwater_shared::job::JobId;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, watch};

/// Pause between two events: people see no more, and hundreds of watchers cost
/// little.
const EVENT_EVERY: Duration = Duration::from_millis(250);
/// How often the revision is read when nothing happens here: changes that
/// another coordinator made.
const POLL_EVERY: Duration = Duration::from_millis(500);
/// Comment that keeps the connection open through proxies.
const COMMENT_EVERY: Duration = Duration::from_secs(15);

/// The job's view at once and after each change, with its revision as the
/// event's id; ends with the job, the job's deletion or the process.
pub(crate) async fn events(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<Response, ApiError> {
    let id = job_id(&id)?;
    app.store.job_rev(id).await?.ok_or_else(|| no_job(id))?;
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
        self.sent_rev = view.rev;
        self.last = view.done;
        let data = serde_json::to_string(&view).ok()?;
        Some(Event::default().id(view.rev.to_string()).data(data))
    }

    /// False when the process ends meanwhile.
    async fn pause(&mut self, time: Duration) -> bool {
        tokio::select! {
            _ = self.stopping.wait_for(|stop| *stop) => false,
            () = tokio::time::sleep(time) => true,
        }
    }
}
