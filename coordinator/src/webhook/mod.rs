//! Telling the end of a job: signed, repeated until somebody takes it, by whichever
//! coordinator comes first.
//!
//! That an end is to be told follows from the job's row, so no crash loses it. Each try
//! is claimed in the store before it is made; a claim that a crash leaves behind
//! runs out. So a message comes at least once, and twice only when a coordinator dies
//! between the receiver's answer and its own note of it.

mod guard;
mod sign;

pub use sign::Secret;

pub(crate) use guard::Forbidden;

use crate::api::job_view;
use crate::app::{App, now_ms};
use crate::config::Config;
use crate::farm::{TRY_MS, pause_ms};
use crate::store::DueWebhook;
use guard::Guard;
use shearwater_shared::api::{WebhookEvent, WebhookEventKind};
use shearwater_shared::job::JobState;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinSet;

/// Header with the message's name, the same for every repetition.
const EVENT_ID: &str = "shearwater-event-id";
/// Header with the seconds since 1970 that are signed.
const TIMESTAMP: &str = "shearwater-timestamp";
/// Header with the signature.
const SIGNATURE: &str = "shearwater-signature";
/// Calls at once: a slow receiver must not hold up the others.
const CALLS_MAX: usize = 16;
/// Longest wait between two looks: ends that another coordinator caused, and tries
/// whose pause is over.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Shortest wait: a busy farm has a change every millisecond.
const LOOK_PAUSE: Duration = Duration::from_millis(250);
/// Longest text about a failure that is kept, in characters.
const ERROR_CHARS_MAX: usize = 300;

/// Calls receivers.
#[derive(Clone, Debug)]
pub(crate) struct Caller {
    http: reqwest::Client,
    guard: Guard,
}

/// The client for webhooks cannot be made.
#[derive(Debug, thiserror::Error)]
#[error("webhooks: {0}")]
pub struct CallerError(#[from] reqwest::Error);

impl Caller {
    /// For a farm with these settings.
    pub(crate) fn new(config: &Config) -> Result<Self, CallerError> {
        // A second one is refused, which is fine: the first serves as well.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let guard = Guard::new(&config.webhook_allow);
        let http = match client(&guard).build() {
            Ok(http) => http,
            // A machine without certificates of authorities is no reason to refuse work.
            Err(error) => {
                tracing::warn!(%error, "webhooks cannot use https on this machine");
                client(&guard).tls_certs_only([]).build()?
            }
        };
        Ok(Self { http, guard })
    }

    /// An address as it is called, if that could be allowed.
    pub(crate) fn check(&self, url: &str) -> Result<String, Forbidden> {
        self.guard.check(url).map(String::from)
    }
}

fn client(guard: &Guard) -> reqwest::ClientBuilder {
    reqwest::Client::builder()
        .dns_resolver(Arc::new(guard.clone()))
        .redirect(reqwest::redirect::Policy::none())
        .no_proxy()
        .timeout(Duration::from_millis(TRY_MS.unsigned_abs()))
        .pool_max_idle_per_host(1)
        .user_agent(concat!("shearwater/", env!("CARGO_PKG_VERSION")))
}

/// Tell every end, until the coordinator stops.
pub(crate) async fn tell_all(app: Arc<App>) {
    let mut changes = app.change.subscribe();
    let mut calls = JoinSet::new();
    loop {
        changes.borrow_and_update();
        while calls.try_join_next().is_some() {}
        if let Err(error) = look(&app, &mut calls).await {
            tracing::error!(%error, "webhooks");
        }
        tokio::time::sleep(LOOK_PAUSE).await;
        // A closed channel means that the coordinator is gone.
        let wait = tokio::time::timeout(LOOK_EVERY, changes.changed()).await;
        if matches!(wait, Ok(Err(_))) {
            return;
        }
    }
}

/// Begin as many calls as are due and as there is room for.
async fn look(app: &Arc<App>, calls: &mut JoinSet<()>) -> Result<(), crate::store::StoreError> {
    let room = CALLS_MAX.saturating_sub(calls.len());
    if room == 0 {
        return Ok(());
    }
    for due in app.store.due_webhooks(now_ms(), room as u32).await? {
        let next_ms = now_ms() + TRY_MS + pause_ms(due.attempt());
        if app.store.claim_webhook(&due, next_ms).await? {
            calls.spawn(tell(Arc::clone(app), due));
        }
    }
    Ok(())
}

/// One try, and what became of it.
async fn tell(app: Arc<App>, due: DueWebhook) {
    let noted = match call(&app, &due).await {
        Ok(status) => {
            tracing::info!(job = due.job.0, status, "webhook taken");
            app.store.webhook_taken(&due, status, now_ms()).await
        }
        Err((status, why)) => {
            let why: String = why.chars().take(ERROR_CHARS_MAX).collect();
            tracing::warn!(
                job = due.job.0,
                attempt = due.attempt(),
                why,
                "webhook failed"
            );
            let next_ms = now_ms() + pause_ms(due.attempt());
            let failed = app.store.webhook_failed(&due, status, &why, next_ms);
            failed.await
        }
    };
    if let Err(error) = noted {
        tracing::error!(%error, job = due.job.0, "webhook");
    }
    app.job_changed();
}

/// Send the message; the receiver's status, or why it was not taken.
async fn call(app: &App, due: &DueWebhook) -> Result<u16, (Option<u16>, String)> {
    let failed = |why: String| (None, why);
    // Again: what is allowed may have changed since the submission.
    let url = app.webhooks.guard.check(&due.url);
    let url = url.map_err(|e| failed(e.to_string()))?;
    let own = due.secret.clone().map(Secret::from);
    let secret = own.or_else(|| app.config.webhook_secret.clone());
    let secret = secret.ok_or_else(|| failed("the farm has no secret any more".into()))?;
    let id = format!("job-{}-{}", due.job, due.finished_ms);
    let body = body(app, due, &id).await.map_err(failed)?;
    let timestamp_s = now_ms() / 1000;
    let signature = sign::signature(&secret, timestamp_s, &body);
    let signature = signature.ok_or_else(|| failed("it cannot be signed".into()))?;
    let answer = app
        .webhooks
        .http
        .post(url)
        .header("content-type", "application/json")
        .header(EVENT_ID, id)
        .header(TIMESTAMP, timestamp_s.to_string())
        .header(SIGNATURE, signature)
        .body(body)
        .send()
        .await
        .map_err(|e| failed(causes(&e.without_url())))?;
    // What it says beside that is not read.
    let status = answer.status();
    if status.is_success() {
        Ok(status.as_u16())
    } else {
        let why = format!("the receiver answered {status}");
        Err((Some(status.as_u16()), why))
    }
}

async fn body(app: &App, due: &DueWebhook, id: &str) -> Result<Vec<u8>, String> {
    let row = app.store.job(due.job).await.map_err(|e| e.to_string())?;
    let row = row.ok_or("the job was deleted")?;
    if row.finished_ms != Some(due.finished_ms) {
        return Err("the job went on before its end was told".into());
    }
    let job = job_view(app, row).await.map_err(|e| e.to_string())?;
    let event = WebhookEvent {
        id: id.to_owned(),
        kind: match job.state {
            JobState::Cancelled => WebhookEventKind::Cancelled,
            JobState::Failed => WebhookEventKind::Failed,
            _ => WebhookEventKind::Done,
        },
        at_ms: due.finished_ms,
        job,
    };
    serde_json::to_vec(&event).map_err(|e| e.to_string())
}

/// An error with its causes.
fn causes(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    text
}
