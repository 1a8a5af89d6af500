//! Render threads and the queue that feeds them.

use crate::cpu_time::thread_cpu_seconds;
use crate::held::HeldLease;
use crate::scenes::panic_text;
use crate::speed::Meter;
use crate::unit_log;
use crate::upload::{Outcome, Settled};
use shearwater_shared::film::TileSums;
use shearwater_shared::plan::{Run, TileRect};
use shearwater_shared::wire::{self, PartUpload};
use shearwater_tracer::{Scene, render_run};
use std::collections::VecDeque;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Instant;
use tokio::sync::{Notify, mpsc};

/// One run, ready to be rendered.
pub(crate) struct Task {
    pub(crate) lease: Arc<HeldLease>,
    pub(crate) run: Run,
    pub(crate) rect: TileRect,
    pub(crate) samples: Range<u32>,
    pub(crate) scene: Arc<Scene>,
}

#[derive(Default)]
struct Inner {
    tasks: VecDeque<Task>,
    closed: bool,
}

/// Runs that wait for a thread. Bounded by the lease loop: it waits for
/// [`Queue::at_most`] before it asks for another lease.
#[derive(Default)]
pub(crate) struct Queue {
    inner: Mutex<Inner>,
    ready: Condvar,
    taken: Notify,
}

impl Queue {
    fn inner(&self) -> std::sync::MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Add a run; lost when the queue is closed (its lease is then released).
    pub(crate) fn push(&self, task: Task) {
        let mut inner = self.inner();
        if !inner.closed {
            inner.tasks.push_back(task);
            self.ready.notify_one();
        }
    }

    /// The next run; waits for one; `None` when the queue is closed.
    fn pop(&self) -> Option<Task> {
        let mut inner = self.inner();
        loop {
            if inner.closed {
                return None;
            }
            if let Some(task) = inner.tasks.pop_front() {
                self.taken.notify_one();
                return Some(task);
            }
            inner = self
                .ready
                .wait(inner)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Wait until at most `tasks` runs wait.
    pub(crate) async fn at_most(&self, tasks: usize) {
        while self.inner().tasks.len() > tasks {
            // A take between the look and the wait leaves its permit behind.
            self.taken.notified().await;
        }
    }

    /// Hand out nothing more.
    pub(crate) fn close(&self) {
        let mut inner = self.inner();
        inner.closed = true;
        inner.tasks.clear();
        self.ready.notify_all();
    }
}

/// Who renders: what a part says about its origin.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    /// Worker's instance.
    pub(crate) worker: String,
    /// Numeric build.
    pub(crate) build: String,
}

/// The life of one render thread.
pub(crate) fn render_thread(
    queue: &Queue,
    meter: &Meter,
    origin: &Origin,
    finished: &mpsc::Sender<Settled>,
) {
    let mut free_since: Option<Instant> = None;
    while let Some(task) = queue.pop() {
        if let Some(since) = free_since {
            let waited_s = since.elapsed().as_secs_f64();
            meter.count(|summary| summary.idle_s += waited_s);
        }
        let outcome = render(&task, meter, origin);
        let settled = Settled {
            lease: task.lease,
            run: task.run,
            outcome,
        };
        // Waits while too many results are undelivered: no farm needs a worker
        // that renders ahead of a coordinator that is away.
        if finished.blocking_send(settled).is_err() {
            return;
        }
        free_since = Some(Instant::now());
    }
}

fn render(task: &Task, meter: &Meter, origin: &Origin) -> Outcome {
    if task.lease.is_cancelled() {
        return Outcome::Unwanted;
    }
    let (started, on_core_from) = (Instant::now(), thread_cpu_seconds());
    let sums = catch_unwind(AssertUnwindSafe(|| {
        render_run(
            &task.scene,
            &task.rect,
            task.samples.clone(),
            &task.lease.cancel,
        )
    }));
    let seconds = started.elapsed().as_secs_f64();
    let core_seconds = thread_cpu_seconds() - on_core_from;
    match sums {
        Err(panic) => Outcome::Failed(format!("rendering: {}", panic_text(&*panic))),
        Ok(None) => Outcome::Unwanted,
        Ok(Some(sums)) => {
            let per_pixel = 2 * u64::from(task.samples.end - task.samples.start);
            meter.rendered(task.rect.pixels() as u64 * per_pixel, seconds);
            let (ms, core_ms) = (seconds * 1e3, core_seconds * 1e3);
            unit_log::span(&task.lease, &task.run)
                .in_scope(|| tracing::debug!(ms, core_ms, "rendered"));
            encode(task, origin, core_seconds, sums)
        }
    }
}

fn encode(task: &Task, origin: &Origin, core_seconds: f64, sums: TileSums) -> Outcome {
    let part = PartUpload {
        job: task.lease.job,
        run: task.run,
        lease: task.lease.id,
        worker: origin.worker.clone(),
        build: origin.build.clone(),
        core_us: (core_seconds * 1e6) as u64,
        sums,
    };
    match wire::encode_part(&part) {
        Ok(body) => Outcome::Part(body),
        Err(error) => Outcome::Failed(error.to_string()),
    }
}
