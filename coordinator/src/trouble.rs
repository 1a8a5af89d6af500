//! What is broken at the moment: the database or the object store does not answer,
//! or cannot be written. Work pauses then, `/readyz`, jobs and refusals say why,
//! and it goes on by itself.

use crate::app::{App, now_ms};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::Notify;

/// How often both are tried while all is well; a failing request makes it at once.
const TRY_EVERY: Duration = Duration::from_secs(5);
/// How often while something is wrong: so soon work goes on.
const TRY_AGAIN_EVERY: Duration = Duration::from_secs(1);
/// Longest wait for an answer: a store that takes longer holds work up anyway.
const TRY_TIMEOUT: Duration = Duration::from_secs(4);
/// Pause after a failing request's wake-up: many fail at once.
const WAKE_PAUSE: Duration = Duration::from_millis(500);
/// Longest text of a cause, in characters.
const CAUSE_CHARS_MAX: usize = 300;

/// What is broken.
#[derive(Debug, Default)]
pub(crate) struct Troubles {
    database: Mutex<Option<Trouble>>,
    objects: Mutex<Option<Trouble>>,
    wake: Notify,
}

/// Since when, and what was said.
#[derive(Clone, Debug)]
struct Trouble {
    since_ms: i64,
    why: String,
}

impl Troubles {
    /// A request failed: look at once.
    pub(crate) fn suspect(&self) {
        self.wake.notify_one();
    }

    /// Whether results cannot be stored, so that nobody should begin any.
    pub(crate) fn work_pauses(&self) -> bool {
        read(&self.database).is_some() || read(&self.objects).is_some()
    }

    /// Whether the database is away.
    pub(crate) fn database_is_away(&self) -> bool {
        read(&self.database).is_some()
    }

    /// Whether objects cannot be written.
    pub(crate) fn objects_are_away(&self) -> bool {
        read(&self.objects).is_some()
    }

    /// What is wrong, for people; `None` when nothing is.
    pub(crate) fn text(&self, now_ms: i64) -> Option<String> {
        let said = [
            ("database", &self.database),
            ("object store", &self.objects),
        ]
        .into_iter()
        .filter_map(|(what, place)| {
            let trouble = read(place)?;
            let seconds = now_ms.saturating_sub(trouble.since_ms) / 1000;
            Some(format!("the {what} fails for {seconds} s: {}", trouble.why))
        });
        let said: Vec<String> = said.collect();
        (!said.is_empty()).then(|| said.join("; "))
    }
}

fn read(place: &Mutex<Option<Trouble>>) -> Option<Trouble> {
    // A panic elsewhere leaves the value whole.
    place.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Note an answer; true when it ended a trouble.
fn note(what: &str, place: &Mutex<Option<Trouble>>, answer: Result<(), String>) -> bool {
    let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
    match (answer, &mut *place) {
        (Ok(()), None) => false,
        (Ok(()), Some(trouble)) => {
            let seconds = now_ms().saturating_sub(trouble.since_ms) / 1000;
            tracing::info!(what, seconds, "answers again; work goes on");
            *place = None;
            true
        }
        (Err(why), Some(trouble)) => {
            trouble.why = why;
            false
        }
        (Err(why), none) => {
            tracing::error!(what, why, "fails; work pauses until it answers");
            *none = Some(Trouble {
                since_ms: now_ms(),
                why,
            });
            false
        }
    }
}

/// Try both stores again and again.
pub(crate) async fn watch(app: Arc<App>) {
    loop {
        let (database, objects) = tokio::join!(
            within(app.store.try_write()),
            within(app.objects.try_write())
        );
        if database.is_ok() && app.troubles.database_is_away() {
            // Nobody could be heard while the database was away.
            let until_ms = now_ms().saturating_add_unsigned(app.lease_ttl_ms());
            if let Err(error) = app.store.prolong_all(until_ms).await {
                tracing::warn!(%error, "leases get no more time");
            }
        }
        note("database", &app.troubles.database, database);
        if note("object store", &app.troubles.objects, objects) {
            app.work_came();
        }
        if app.troubles.work_pauses() {
            tokio::time::sleep(TRY_AGAIN_EVERY).await;
        } else {
            tokio::select! {
                () = app.troubles.wake.notified() => tokio::time::sleep(WAKE_PAUSE).await,
                () = tokio::time::sleep(TRY_EVERY) => {}
            }
        }
    }
}

async fn within<E: std::fmt::Display>(
    answer: impl Future<Output = Result<(), E>>,
) -> Result<(), String> {
    let why = match tokio::time::timeout(TRY_TIMEOUT, answer).await {
        Ok(Ok(())) => return Ok(()),
        Ok(Err(error)) => error.to_string(),
        Err(_) => format!("no answer within {} s", TRY_TIMEOUT.as_secs()),
    };
    Err(why.chars().take(CAUSE_CHARS_MAX).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn troubles_are_told_until_they_end() {
        let troubles = Troubles::default();
        assert_eq!(troubles.text(0), None);
        assert!(!note("x", &troubles.objects, Err("full".into())));
        assert!(troubles.work_pauses() && !troubles.database_is_away());
        let text = troubles.text(now_ms()).expect("trouble");
        assert!(
            text.contains("object store") && text.contains("full"),
            "{text}"
        );
        assert!(!note("x", &troubles.objects, Err("still full".into())));
        assert!(note("x", &troubles.objects, Ok(())), "it ends once");
        assert!(!note("x", &troubles.objects, Ok(())));
        assert_eq!(troubles.text(0), None);
    }
}
