//! From workers' questions to leases: snapshot, decision, transition.
//!
//! One task answers all of them, in batches: a farm of thousands asks hundreds of times
//! a second, and what each answer needs (who is there, which jobs are live, a
//! transaction) is the same for all that ask at one moment. Who gets nothing waits here
//! until something changes.

mod endgame;
mod pass;
mod snapshot;

use crate::app::App;
use crate::gather::{Asked, Gathered};
use crate::store::StoreError;
use shearwater_shared::api::{Lease, LeaseRequest};
use shearwater_shared::limits::LEASE_WAIT_MS_MAX;
use snapshot::Snapshot;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;

/// Most often that waiting questions are looked at again unasked, whatever the
/// configuration says.
const ASK_AGAIN_MIN: Duration = Duration::from_millis(10);
/// Workers served by one transaction.
const BATCH_MAX: usize = 64;
/// How exactly the end of a wait is kept.
const WAIT_STEP: Duration = Duration::from_millis(50);

/// What a worker gets.
#[derive(Debug)]
pub(crate) enum Dispatch {
    /// Work.
    Lease(Box<Lease>),
    /// Nothing within its wait.
    Nothing,
    /// Nothing until this time, and why.
    Quarantined(i64, String),
}

/// A worker asks.
#[derive(Debug)]
pub(crate) struct Question {
    /// What it says; checked.
    pub(crate) request: LeaseRequest,
    /// Until when it waits.
    pub(crate) deadline: Instant,
}

/// What it is told.
pub(crate) type Answer = Result<Dispatch, StoreError>;
type Waiting = Asked<Question, Answer>;

/// Answer workers until none asks any more.
pub(crate) async fn answer_all(app: Arc<App>, mut questions: Gathered<Question, Answer>) {
    let ask_again = Duration::from_millis(app.config.ask_again_ms.min(LEASE_WAIT_MS_MAX));
    let ask_again = ask_again.max(ASK_AGAIN_MIN);
    let mut work = app.work.subscribe();
    let mut snapshot = Snapshot::default();
    // To be looked at, in order; and those that got nothing.
    let mut asking: VecDeque<Waiting> = VecDeque::new();
    let mut idle: Vec<Waiting> = Vec::new();
    let mut looked = Instant::now();
    loop {
        let mut changed = false;
        if asking.is_empty() {
            let step = WAIT_STEP.min(ask_again);
            tokio::select! {
                asked = questions.next() => match asked {
                    Some(asked) => asking.push_back(asked),
                    None => return,
                },
                news = work.changed() => {
                    if news.is_err() {
                        return;
                    }
                    changed = true;
                }
                () = tokio::time::sleep(step), if !idle.is_empty() => {}
            }
        }
        let mut more = Vec::new();
        questions.take_more(&mut more, BATCH_MAX);
        asking.extend(more);
        // Whatever changed before a question was asked is known to its answer.
        changed |= work.has_changed().unwrap_or(false);
        if changed {
            work.borrow_and_update();
            snapshot.forget();
        }
        if changed || looked.elapsed() >= ask_again {
            looked = Instant::now();
            wake(&mut asking, &mut idle);
        }
        let count = asking.len().min(BATCH_MAX);
        let batch: Vec<Waiting> = asking.drain(..count).filter(is_heard).collect();
        if !batch.is_empty() {
            idle.extend(pass::pass(&app, &mut snapshot, batch).await);
        }
        end_waits(&mut idle);
    }
}

/// All that wait are looked at again, before those that ask only now.
fn wake(asking: &mut VecDeque<Waiting>, idle: &mut Vec<Waiting>) {
    for waiting in idle.drain(..).rev() {
        asking.push_front(waiting);
    }
}

/// Whether somebody still waits for the answer.
fn is_heard(waiting: &Waiting) -> bool {
    !waiting.answer.is_closed()
}

fn end_waits(idle: &mut Vec<Waiting>) {
    let now = Instant::now();
    let (over, wait): (Vec<Waiting>, Vec<Waiting>) = idle
        .drain(..)
        .filter(is_heard)
        .partition(|waiting| waiting.item.deadline <= now);
    *idle = wait;
    for waiting in over {
        let _ = waiting.answer.send(Ok(Dispatch::Nothing));
    }
}
