//! Paths of the REST API, one constant each, in axum's template syntax.

/// Submit (`POST`) and list (`GET`) jobs.
pub const JOBS: &str = "/v1/jobs";
/// One job: `GET`, `PATCH`, `DELETE`.
pub const JOB: &str = "/v1/jobs/{id}";
/// Stop a job: `POST`.
pub const JOB_CANCEL: &str = "/v1/jobs/{id}/cancel";
/// Hand out nothing more of a job for now: `POST`.
pub const JOB_PAUSE: &str = "/v1/jobs/{id}/pause";
/// Go on with a paused job: `POST`.
pub const JOB_RESUME: &str = "/v1/jobs/{id}/resume";
/// Try a failed job again: `POST`.
pub const JOB_RETRY: &str = "/v1/jobs/{id}/retry";
/// What happened to a job's units, newest first, by page: `GET`. Query: `page_size`,
/// `page_token`.
pub const JOB_LOG: &str = "/v1/jobs/{id}/log";
/// Add samples to a job: `POST`.
pub const JOB_SAMPLES: &str = "/v1/jobs/{id}/samples";
/// Progress as server-sent events: `GET`.
pub const JOB_EVENTS: &str = "/v1/jobs/{id}/events";
/// State, film hash and error of each frame, by page: `GET`. Query:
/// `page_size`, `page_token`.
pub const JOB_FRAMES: &str = "/v1/jobs/{id}/frames";
/// Error of a frame against time, by page: `GET`. Query: `frame`, `page_size`,
/// `page_token`.
pub const JOB_ERRORS: &str = "/v1/jobs/{id}/errors";
/// The developed picture, partial or final: `GET`. Query: `frame`, `view`, `exposure_ev`.
pub const JOB_PNG: &str = "/v1/jobs/{id}/image.png";
/// The linear picture with features: `GET`. Query: `frame`.
pub const JOB_EXR: &str = "/v1/jobs/{id}/image.exr";
/// Which of these assets are missing: `POST`.
pub const ASSETS_MISSING: &str = "/v1/assets/missing";
/// One asset by blake3: `HEAD`, `GET`, `PUT`.
pub const ASSET: &str = "/v1/assets/{hash}";
/// Workers seen lately: `GET`.
pub const WORKERS: &str = "/v1/workers";
/// Ask for work (long poll): `POST`.
pub const WORKER_LEASES: &str = "/v1/worker/leases";
/// Deliver one run's sums (binary): `POST`.
pub const WORKER_RESULTS: &str = "/v1/worker/results";
/// Keep leases alive: `POST`.
pub const WORKER_HEARTBEAT: &str = "/v1/worker/heartbeat";
/// Report that a run cannot be rendered: `POST`.
pub const WORKER_FAILURES: &str = "/v1/worker/failures";
/// Hand runs back undone: `POST`.
pub const WORKER_RELEASE: &str = "/v1/worker/release";
/// Process is alive: `GET`.
pub const HEALTHZ: &str = "/healthz";
/// Store and objects answer: `GET`.
pub const READYZ: &str = "/readyz";
/// What was counted and measured, for Prometheus: `GET`.
pub const METRICS: &str = "/metrics";
/// The API as an OpenAPI document: `GET`.
pub const OPENAPI: &str = "/openapi.json";
/// The API as a page for people: `GET`.
pub const DOCS: &str = "/docs";

/// Fill `{id}` or `{hash}` of a template.
#[must_use]
pub fn fill(template: &str, value: &str) -> String {
    match (template.find('{'), template.find('}')) {
        (Some(open), Some(close)) if open < close => {
            format!("{}{value}{}", &template[..open], &template[close + 1..])
        }
        _ => template.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn fills_the_one_parameter() {
        assert_eq!(super::fill(super::JOB_PNG, "7"), "/v1/jobs/7/image.png");
        assert_eq!(super::fill(super::JOBS, "7"), "/v1/jobs");
    }
}
