//! What a route demands. Whatever is not named here demands a client.

use super::role::Role;
use axum::http::Method;
use shearwater_shared::job::JobId;
use shearwater_shared::routes;

/// What a request demands of its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// Nothing: says no more than that a coordinator is here, and what it speaks.
    Nothing,
    /// The worker protocol.
    Worker,
    /// What workers and clients read.
    WorkerOrClient,
    /// To read and to submit.
    Client,
    /// What nobody else may.
    Admin,
    /// To change this job: its submitter, or an admin.
    Change(JobId),
}

/// Everything below it is the worker protocol.
const WORKER_PROTOCOL: &str = "/v1/worker/";
/// Files of the page that describes the API.
const PAGE: &str = "/docs/";
const JOBS: &str = "/v1/jobs/";
const ASSETS: &str = "/v1/assets/";

/// What a request demands.
pub(super) fn need(method: &Method, path: &str) -> Need {
    let reads = matches!(*method, Method::GET | Method::HEAD);
    // The documents are the same everywhere.
    let documents = matches!(path, routes::OPENAPI | routes::DOCS) || path.starts_with(PAGE);
    if matches!(path, routes::HEALTHZ | routes::READYZ) || documents {
        return Need::Nothing;
    }
    if path.starts_with(WORKER_PROTOCOL) {
        return Need::Worker;
    }
    if reads && path.starts_with(ASSETS) {
        return Need::WorkerOrClient;
    }
    match path.strip_prefix(JOBS) {
        // A number may be written with escapes, which handlers undo: no client does
        // so, and nobody passes by it.
        Some(rest) if !reads && rest.contains('%') => Need::Admin,
        Some(rest) if !reads => changed_job(rest).map_or(Need::Client, Need::Change),
        _ => Need::Client,
    }
}

/// The job of `7`, `7/cancel` and so on; a handler says what is wrong with
/// anything else.
fn changed_job(rest: &str) -> Option<JobId> {
    let digits = rest.split('/').next()?;
    digits.parse().ok().map(JobId)
}

impl Need {
    /// Whether a role has this right; of a job the owner is asked besides.
    pub(super) const fn allows(self, role: Role) -> bool {
        match (self, role) {
            (Self::Nothing | Self::WorkerOrClient, _) | (_, Role::Admin) => true,
            (Self::Admin, _) => false,
            (Self::Worker, role) => matches!(role, Role::Worker),
            (Self::Client | Self::Change(_), role) => matches!(role, Role::Client),
        }
    }

    /// Words for a refusal.
    pub(super) const fn text(self) -> &'static str {
        match self {
            Self::Nothing => "no token",
            Self::Worker => "a token of role worker",
            Self::WorkerOrClient => "a token",
            Self::Admin => "a token of role admin",
            Self::Client | Self::Change(_) => "a token of role client or admin",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_route_has_its_need() {
        let cases = [
            (Method::GET, routes::HEALTHZ, Need::Nothing),
            (Method::GET, routes::READYZ, Need::Nothing),
            (Method::GET, routes::OPENAPI, Need::Nothing),
            (Method::GET, "/docs/index.html", Need::Nothing),
            (Method::GET, "/v1/jobs", Need::Client),
            (Method::POST, "/v1/jobs", Need::Client),
            (Method::GET, "/v1/jobs/7/image.png", Need::Client),
            (Method::DELETE, "/v1/jobs/7", Need::Change(JobId(7))),
            (Method::POST, "/v1/jobs/7/cancel", Need::Change(JobId(7))),
            (Method::PATCH, "/v1/jobs/7", Need::Change(JobId(7))),
            (Method::POST, "/v1/jobs/%37/cancel", Need::Admin),
            (Method::DELETE, "/v1/jobs/x", Need::Client),
            (Method::GET, "/v1/assets/00", Need::WorkerOrClient),
            (Method::HEAD, "/v1/assets/00", Need::WorkerOrClient),
            (Method::PUT, "/v1/assets/00", Need::Client),
            (Method::POST, routes::ASSETS_MISSING, Need::Client),
            (Method::GET, routes::WORKERS, Need::Client),
            (Method::POST, routes::WORKER_LEASES, Need::Worker),
            (Method::POST, routes::WORKER_RESULTS, Need::Worker),
            (Method::POST, routes::WORKER_HEARTBEAT, Need::Worker),
            (Method::POST, routes::WORKER_FAILURES, Need::Worker),
            (Method::POST, routes::WORKER_RELEASE, Need::Worker),
            (Method::GET, routes::METRICS, Need::Client),
            (Method::GET, "/anything/else", Need::Client),
            (Method::GET, "", Need::Client),
        ];
        for (method, path, expected) in cases {
            assert_eq!(need(&method, path), expected, "{method} {path}");
        }
    }

    #[test]
    fn a_worker_reads_assets_and_nothing_else() {
        for (need, worker, client) in [
            (Need::Worker, true, false),
            (Need::WorkerOrClient, true, true),
            (Need::Client, false, true),
            (Need::Change(JobId(1)), false, true),
            (Need::Admin, false, false),
        ] {
            assert_eq!(need.allows(Role::Worker), worker, "{need:?}");
            assert_eq!(need.allows(Role::Client), client, "{need:?}");
            assert!(need.allows(Role::Admin), "{need:?}");
        }
    }
}
