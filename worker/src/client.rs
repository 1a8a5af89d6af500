//! The worker protocol over HTTP, one call at a time; no retries here.

use crate::connection::{Access, causes};
use crate::error::WorkerError;
use crate::traffic::Traffic;
use reqwest::{Response, StatusCode, Url, header};
use serde::{Serialize, de::DeserializeOwned};
use shearwater_shared::api::{
    FailureReport, HeartbeatRequest, HeartbeatResponse, Lease, LeaseRequest, Problem,
    ReleaseRequest, ResultResponse,
};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::{routes, wire};
use std::sync::Arc;
use std::time::Duration;

/// Small JSON calls.
const CALL_TIMEOUT: Duration = Duration::from_secs(15);
/// A heartbeat: the next one is due by then, and a lease outlives several.
const HEARTBEAT_TIMEOUT: Duration = Duration::from_secs(3);
/// A part of half a megabyte over a slow line, and a durable write.
const RESULT_TIMEOUT: Duration = Duration::from_secs(60);
/// Between two pieces of an asset; its whole length may take hours.
const CHUNK_TIMEOUT: Duration = Duration::from_secs(30);
/// Every kind of problem of ours begins with this.
const OUR_PROBLEMS: &str = "urn:shearwater:";
/// Largest text of an error that is worth reading.
const PROBLEM_BYTES_MAX: usize = 64 << 10;
/// Largest answer in JSON: a lease with a manifest of the largest size.
const ANSWER_BYTES_MAX: usize = shearwater_shared::limits::SUBMIT_BODY_BYTES_MAX + (1 << 20);

/// Why a call brought no answer.
#[derive(Debug)]
pub(crate) enum CallError {
    /// Nobody there, overloaded, or not our coordinator: try again later.
    Unavailable(String),
    /// The content is not what was asked for: damaged on the way, or where it
    /// is stored.
    Damaged(String),
    /// The coordinator said no.
    Refused(Problem),
}

/// A connection to one coordinator.
#[derive(Clone, Debug)]
pub(crate) struct Client {
    http: reqwest::Client,
    base: Url,
    traffic: Arc<Traffic>,
}

impl Client {
    /// Check the address and the credentials; nothing is sent yet.
    pub(crate) fn new(url: &str, access: &Access) -> Result<Self, WorkerError> {
        let error = |message: String| WorkerError::Url {
            // A part that must not be shown is cut off.
            url: url.rsplit('@').next().unwrap_or_default().to_owned(),
            message,
        };
        let (base, builder) = access.connect(url).map_err(|e| error(e.to_string()))?;
        let http = builder
            .user_agent(concat!("shearwater-worker/", env!("CARGO_PKG_VERSION")))
            .build()
            .map_err(|e| error(causes(&e)))?;
        Ok(Self {
            http,
            base,
            traffic: Arc::default(),
        })
    }

    /// The same, counted together with others.
    pub(crate) fn counted_in(self, traffic: Arc<Traffic>) -> Self {
        Self { traffic, ..self }
    }

    fn url(&self, path: &str) -> Result<Url, CallError> {
        self.base
            .join(path)
            .map_err(|e| CallError::Unavailable(e.to_string()))
    }

    async fn post_json(
        &self,
        path: &str,
        body: &impl Serialize,
        timeout: Duration,
    ) -> Result<Response, CallError> {
        let body = serde_json::to_vec(body).map_err(|e| CallError::Unavailable(e.to_string()))?;
        self.traffic.sends(body.len());
        let request = self
            .http
            .post(self.url(path)?)
            .header(header::CONTENT_TYPE, "application/json")
            .body(body)
            .timeout(timeout);
        self.accepted(request.send().await).await
    }

    /// Ask for work; `None` when there is none within the request's wait.
    pub(crate) async fn lease(&self, request: &LeaseRequest) -> Result<Option<Lease>, CallError> {
        let timeout = Duration::from_millis(request.wait_ms) + CALL_TIMEOUT;
        let response = self
            .post_json(routes::WORKER_LEASES, request, timeout)
            .await?;
        if response.status() == StatusCode::NO_CONTENT {
            return Ok(None);
        }
        self.json(response).await.map(Some)
    }

    /// Deliver the message of one part.
    pub(crate) async fn result(&self, body: Vec<u8>) -> Result<ResultResponse, CallError> {
        self.traffic.sends(body.len());
        let request = self
            .http
            .post(self.url(routes::WORKER_RESULTS)?)
            .header(header::CONTENT_TYPE, wire::CONTENT_TYPE)
            .body(body)
            .timeout(RESULT_TIMEOUT);
        let response = self.accepted(request.send().await).await?;
        self.json(response).await
    }

    /// Keep leases alive.
    pub(crate) async fn heartbeat(
        &self,
        request: &HeartbeatRequest,
    ) -> Result<HeartbeatResponse, CallError> {
        let response = self.post_json(routes::WORKER_HEARTBEAT, request, HEARTBEAT_TIMEOUT);
        self.json(response.await?).await
    }

    /// Say that a run cannot be rendered.
    pub(crate) async fn failure(&self, report: &FailureReport) -> Result<(), CallError> {
        let response = self.post_json(routes::WORKER_FAILURES, report, CALL_TIMEOUT);
        response.await.map(drop)
    }

    /// Hand leases back.
    pub(crate) async fn release(&self, request: &ReleaseRequest) -> Result<(), CallError> {
        let response = self.post_json(routes::WORKER_RELEASE, request, CALL_TIMEOUT);
        response.await.map(drop)
    }

    /// The bytes of one asset behind those in `have`, at most `bytes_max` in all,
    /// unverified. What has come stays in `have` when the line breaks.
    pub(crate) async fn asset(
        &self,
        hash: &ContentHash,
        bytes_max: u64,
        have: &mut Vec<u8>,
    ) -> Result<(), CallError> {
        let path = routes::fill(routes::ASSET, &hash.to_string());
        let mut request = self.http.get(self.url(&path)?);
        if !have.is_empty() {
            request = request.header(header::RANGE, format!("bytes={}-", have.len()));
        }
        let answer = tokio::time::timeout(CHUNK_TIMEOUT, request.send())
            .await
            .map_err(|_| CallError::Unavailable(format!("asset {hash}: no answer")))?;
        let is_rest = answer.as_ref().is_ok_and(|r| begins_at(r, have.len()));
        if !is_rest {
            // From the start: whoever answers does not know ranges, or not this one.
            have.clear();
        }
        self.traffic.sends(0);
        read_into(self.accepted(answer).await?, bytes_max, have).await
    }

    /// The answer, if it is one of success.
    async fn accepted(
        &self,
        answer: Result<Response, reqwest::Error>,
    ) -> Result<Response, CallError> {
        match &answer {
            Ok(response) if response.status().is_success() => {}
            Ok(response) => self.traffic.fails(response.status().as_str()),
            Err(error) if error.is_timeout() => self.traffic.fails("timeout"),
            Err(_) => self.traffic.fails("connection"),
        }
        accepted(answer).await
    }

    async fn json<T: DeserializeOwned>(&self, response: Response) -> Result<T, CallError> {
        let bytes = read_bounded(response, ANSWER_BYTES_MAX as u64).await?;
        self.traffic.receives(bytes.len());
        serde_json::from_slice(&bytes)
            .map_err(|e| CallError::Unavailable(format!("answer is not the expected JSON: {e}")))
    }
}

/// Whether an answer is a part that begins at byte `start`.
fn begins_at(response: &Response, start: usize) -> bool {
    let range = response.headers().get(header::CONTENT_RANGE);
    let range = range.and_then(|value| value.to_str().ok());
    response.status() == StatusCode::PARTIAL_CONTENT
        && range.is_some_and(|range| range.starts_with(&format!("bytes {start}-")))
}

/// The answer, if it is one of success.
async fn accepted(answer: Result<Response, reqwest::Error>) -> Result<Response, CallError> {
    let response = answer.map_err(|e| CallError::Unavailable(causes(&e)))?;
    let status = response.status();
    if status.is_success() {
        return Ok(response);
    }
    let body = read_bounded(response, PROBLEM_BYTES_MAX as u64)
        .await
        .unwrap_or_default();
    let later = status.is_server_error()
        || matches!(
            status,
            StatusCode::REQUEST_TIMEOUT | StatusCode::TOO_EARLY | StatusCode::TOO_MANY_REQUESTS
        );
    match serde_json::from_slice::<Problem>(&body) {
        Ok(problem) if !later && problem.kind.starts_with(OUR_PROBLEMS) => {
            Err(CallError::Refused(problem))
        }
        Ok(problem) => Err(CallError::Unavailable(format!(
            "{status}: {}",
            problem.detail
        ))),
        // Some proxy or another server: the coordinator itself speaks problem+json.
        Err(_) => Err(CallError::Unavailable(format!("status {status}"))),
    }
}

async fn read_bounded(response: Response, bytes_max: u64) -> Result<Vec<u8>, CallError> {
    let mut bytes = Vec::new();
    read_into(response, bytes_max, &mut bytes).await?;
    Ok(bytes)
}

/// Add an answer to `bytes`, which then has at most `bytes_max`.
async fn read_into(
    mut response: Response,
    bytes_max: u64,
    bytes: &mut Vec<u8>,
) -> Result<(), CallError> {
    loop {
        let chunk = tokio::time::timeout(CHUNK_TIMEOUT, response.chunk())
            .await
            .map_err(|_| CallError::Unavailable("the answer stalls".into()))?
            .map_err(|e| CallError::Unavailable(causes(&e)))?;
        let Some(chunk) = chunk else {
            return Ok(());
        };
        if bytes.len() as u64 + chunk.len() as u64 > bytes_max {
            return Err(CallError::Damaged(format!(
                "the answer is longer than {bytes_max} bytes"
            )));
        }
        bytes.extend_from_slice(&chunk);
    }
}
