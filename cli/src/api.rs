//! The public API as a client sees it.

use crate::exit::CliError;
use crate::scene_files::Bundle;
use reqwest::{ClientBuilder, RequestBuilder, Response, Url};
use serde::de::DeserializeOwned;
use shearwater_shared::api::{
    AddSamples, ChangeJob, ErrorPage, ErrorPoint, FramePage, JobPage, JobView, LogPage,
    MissingRequest, MissingResponse, Problem, SettingsOverride, SubmitRequest, WebhookRequest,
    WorkerPage,
};
use shearwater_shared::job::JobId;
use shearwater_shared::routes;
use shearwater_worker::connection::{Access, causes};
use std::time::Duration;

/// Questions. A coordinator answers them within milliseconds, a busy one within a second;
/// one that does not for so long is frozen, and whoever waits wants to know.
const ASK_TIMEOUT: Duration = Duration::from_secs(8);
/// What changes something, and may wait for a lock of the database.
const CALL_TIMEOUT: Duration = Duration::from_secs(30);
/// Silence after which the system asks whether an upload's other side is there.
const KEEPALIVE: Duration = Duration::from_secs(15);
/// Between two pieces of a picture; developing a large one takes time.
const READ_TIMEOUT: Duration = Duration::from_secs(120);

/// A connection to one coordinator.
#[derive(Clone, Debug)]
pub(crate) struct Api {
    http: reqwest::Client,
    /// Without a limit between two pieces of an answer: that of an upload comes
    /// after its last byte, which may take hours.
    uploads: reqwest::Client,
    base: Url,
}

/// Which picture of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Picture {
    /// Developed.
    Png,
    /// Linear, with features.
    Exr,
}

impl Picture {
    /// Both.
    pub(crate) const ALL: [Self; 2] = [Self::Png, Self::Exr];

    /// File name extension.
    pub(crate) const fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    const fn route(self) -> &'static str {
        match self {
            Self::Png => routes::JOB_PNG,
            Self::Exr => routes::JOB_EXR,
        }
    }
}

impl Api {
    /// Check the address and the credentials; nothing is sent yet.
    pub(crate) fn new(url: &str, access: &Access) -> Result<Self, CliError> {
        let error = |why: String| CliError::Address {
            // A part that must not be shown is cut off.
            url: url.rsplit('@').next().unwrap_or_default().to_owned(),
            why,
        };
        let client = |change: fn(ClientBuilder) -> ClientBuilder| {
            let (base, builder) = access.connect(url).map_err(|e| error(e.to_string()))?;
            let agent = concat!("shearwater/", env!("CARGO_PKG_VERSION"));
            let client = change(builder.user_agent(agent)).build();
            let client = client.map_err(|e| error(causes(&e)))?;
            Ok::<_, CliError>((base, client))
        };
        let (base, http) = client(|builder| builder.read_timeout(READ_TIMEOUT))?;
        let (_, uploads) = client(|builder| builder.tcp_keepalive(KEEPALIVE))?;
        Ok(Self {
            http,
            uploads,
            base,
        })
    }

    fn url(&self, path: &str) -> Result<Url, CliError> {
        self.base.join(path).map_err(|e| self.strange(&e))
    }

    fn strange(&self, why: &dyn std::fmt::Display) -> CliError {
        CliError::Strange {
            url: self.base.to_string(),
            why: why.to_string(),
        }
    }

    fn unreachable(&self, error: &reqwest::Error) -> CliError {
        CliError::Unreachable {
            url: self.base.to_string(),
            why: causes(error),
        }
    }

    async fn send(&self, request: RequestBuilder) -> Result<Response, CliError> {
        let response = request.send().await.map_err(|e| self.unreachable(&e))?;
        let status = response.status();
        if status.is_success() {
            return Ok(response);
        }
        let body = response.bytes().await.map_err(|e| self.unreachable(&e))?;
        match serde_json::from_slice::<Problem>(&body) {
            // Overloaded or restarting: as good as away.
            Ok(problem) if status.is_server_error() => Err(CliError::Unreachable {
                url: self.base.to_string(),
                why: problem.detail,
            }),
            Ok(problem) => Err(CliError::Refused(problem)),
            // A proxy whose coordinator is away.
            Err(_) if status.is_server_error() => Err(CliError::Unreachable {
                url: self.base.to_string(),
                why: format!("status {status}"),
            }),
            Err(_) => Err(self.strange(&format!("status {status}"))),
        }
    }

    /// The answer of a request that changes something.
    async fn json<T: DeserializeOwned>(&self, request: RequestBuilder) -> Result<T, CliError> {
        self.json_within(request, CALL_TIMEOUT).await
    }

    /// The answer of a question.
    async fn ask<T: DeserializeOwned>(&self, url: Url) -> Result<T, CliError> {
        self.json_within(self.http.get(url), ASK_TIMEOUT).await
    }

    async fn json_within<T: DeserializeOwned>(
        &self,
        request: RequestBuilder,
        timeout: Duration,
    ) -> Result<T, CliError> {
        let answer = async {
            let response = self.send(request).await?;
            response.bytes().await.map_err(|e| self.unreachable(&e))
        };
        let answer = tokio::time::timeout(timeout, answer).await;
        let bytes = answer.unwrap_or_else(|_| Err(self.silent(timeout)))?;
        serde_json::from_slice(&bytes).map_err(|e| self.strange(&e))
    }

    /// It took the connection, or should have, and said nothing.
    fn silent(&self, waited: Duration) -> CliError {
        CliError::Silent {
            url: self.base.to_string(),
            seconds: waited.as_secs(),
        }
    }

    /// One job.
    pub(crate) async fn job(&self, id: JobId) -> Result<JobView, CliError> {
        let path = routes::fill(routes::JOB, &id.to_string());
        self.ask(self.url(&path)?).await
    }

    /// One page of jobs, newest first.
    pub(crate) async fn jobs(
        &self,
        page_size: usize,
        page_token: Option<&str>,
    ) -> Result<JobPage, CliError> {
        let mut url = self.url(routes::JOBS)?;
        url.query_pairs_mut()
            .append_pair("page_size", &page_size.to_string());
        if let Some(token) = page_token {
            url.query_pairs_mut().append_pair("page_token", token);
        }
        self.ask(url).await
    }

    /// One page of a job's frames, in order.
    pub(crate) async fn frames(
        &self,
        id: JobId,
        page_token: Option<&str>,
    ) -> Result<FramePage, CliError> {
        let mut url = self.url(&routes::fill(routes::JOB_FRAMES, &id.to_string()))?;
        if let Some(token) = page_token {
            url.query_pairs_mut().append_pair("page_token", token);
        }
        self.ask(url).await
    }

    /// The error of a frame (the scene's number) against time: every point.
    pub(crate) async fn errors(&self, id: JobId, frame: u32) -> Result<Vec<ErrorPoint>, CliError> {
        let path = routes::fill(routes::JOB_ERRORS, &id.to_string());
        let mut points = Vec::new();
        let mut token: Option<String> = None;
        loop {
            let mut url = self.url(&path)?;
            url.query_pairs_mut()
                .append_pair("frame", &frame.to_string());
            if let Some(token) = &token {
                url.query_pairs_mut().append_pair("page_token", token);
            }
            let page: ErrorPage = self.ask(url).await?;
            points.extend(page.points);
            token = page.next_page_token;
            if token.is_none() {
                return Ok(points);
            }
        }
    }

    /// Stop a job.
    pub(crate) async fn cancel(&self, id: JobId) -> Result<(), CliError> {
        let path = routes::fill(routes::JOB_CANCEL, &id.to_string());
        let request = self.http.post(self.url(&path)?).timeout(CALL_TIMEOUT);
        self.send(request).await.map(drop)
    }

    /// Remove a job that has ended, with everything of it.
    pub(crate) async fn delete(&self, id: JobId) -> Result<(), CliError> {
        let path = routes::fill(routes::JOB, &id.to_string());
        let request = self.http.delete(self.url(&path)?).timeout(CALL_TIMEOUT);
        self.send(request).await.map(drop)
    }

    /// Pause, resume or retry a job: `POST` one of their routes.
    pub(crate) async fn steer(&self, route: &str, id: JobId) -> Result<JobView, CliError> {
        let path = routes::fill(route, &id.to_string());
        self.json(self.http.post(self.url(&path)?)).await
    }

    /// Change a job.
    pub(crate) async fn change(&self, id: JobId, asked: &ChangeJob) -> Result<JobView, CliError> {
        let path = routes::fill(routes::JOB, &id.to_string());
        self.json(self.http.patch(self.url(&path)?).json(asked))
            .await
    }

    /// One page of a job's log, newest first.
    pub(crate) async fn log(
        &self,
        id: JobId,
        page_size: usize,
        page_token: Option<&str>,
    ) -> Result<LogPage, CliError> {
        let mut url = self.url(&routes::fill(routes::JOB_LOG, &id.to_string()))?;
        url.query_pairs_mut()
            .append_pair("page_size", &page_size.to_string());
        if let Some(token) = page_token {
            url.query_pairs_mut().append_pair("page_token", token);
        }
        self.ask(url).await
    }

    /// One page of the workers that were heard of lately.
    pub(crate) async fn workers(&self, page_token: Option<&str>) -> Result<WorkerPage, CliError> {
        let mut url = self.url(routes::WORKERS)?;
        if let Some(token) = page_token {
            url.query_pairs_mut().append_pair("page_token", token);
        }
        self.ask(url).await
    }

    /// Add samples to a job.
    pub(crate) async fn add_samples(
        &self,
        id: JobId,
        asked: &AddSamples,
    ) -> Result<JobView, CliError> {
        let path = routes::fill(routes::JOB_SAMPLES, &id.to_string());
        self.json(self.http.post(self.url(&path)?).json(asked))
            .await
    }

    /// Upload what the coordinator lacks of a scene, then submit the job.
    pub(crate) async fn submit(
        &self,
        bundle: &Bundle,
        name: Option<String>,
        settings: SettingsOverride,
        priority: i32,
        webhook: Option<WebhookRequest>,
    ) -> Result<JobView, CliError> {
        let request = MissingRequest {
            hashes: bundle.sources.keys().copied().collect(),
        };
        let url = self.url(routes::ASSETS_MISSING)?;
        let answer: MissingResponse = self.json(self.http.post(url).json(&request)).await?;
        for hash in answer.missing {
            let Some(source) = bundle.sources.get(&hash) else {
                continue;
            };
            let path = routes::fill(routes::ASSET, &hash.to_string());
            let body = source.read().await?;
            tracing::info!(%hash, bytes = body.len(), "upload");
            self.send(self.uploads.put(self.url(&path)?).body(body))
                .await?;
        }
        let request = SubmitRequest {
            name,
            manifest: bundle.manifest.clone(),
            settings,
            priority,
            webhook,
        };
        self.json(self.http.post(self.url(routes::JOBS)?).json(&request))
            .await
    }

    /// A picture of a job, as far as it has come; `frame` is the scene's number.
    pub(crate) async fn picture(
        &self,
        id: JobId,
        picture: Picture,
        frame: u32,
    ) -> Result<Vec<u8>, CliError> {
        let path = routes::fill(picture.route(), &id.to_string());
        let mut url = self.url(&path)?;
        url.query_pairs_mut()
            .append_pair("frame", &frame.to_string());
        let response = self.send(self.http.get(url)).await?;
        let bytes = response.bytes().await.map_err(|e| self.unreachable(&e))?;
        Ok(bytes.into())
    }
}
