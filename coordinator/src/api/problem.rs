//! Every error of the API, and the only place that maps them to HTTP (RFC 9457).

use crate::app::CutOff;
use crate::develop::DevelopError;
use crate::fold::FoldError;
use crate::objects::ObjectError;
use crate::store::StoreError;
use axum::body::Body;
use axum::http::{HeaderValue, Response, StatusCode, header};
use axum::response::IntoResponse;
use shearwater_shared::api::Problem;

/// Content type of every error.
const PROBLEM_JSON: HeaderValue = HeaderValue::from_static("application/problem+json");
/// Longest text about an error, in bytes: some quote the request.
const DETAIL_BYTES_MAX: usize = 2000;

/// What a request can meet instead of success. The texts go to the client.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ApiError {
    #[error("no such path; the API lives below /v1")]
    NoRoute,
    #[error("this path does not know this method; see the Allow header")]
    Method,
    #[error("{0}")]
    NotFound(String),
    #[error("{0}")]
    BadRequest(String),
    #[error("Content-Type must be {0}")]
    MediaType(&'static str),
    #[error("the body is larger than {0} bytes, the limit of this request")]
    TooLarge(u64),
    #[error("the body did not arrive in time; send it again over a faster connection")]
    Timeout,
    #[error("{0}")]
    Invalid(String),
    #[error("the Idempotency-Key was used for job {0} with another body; take a new key")]
    KeyReused(i64),
    #[error(
        "this farm renders with build `{farm}` (Shearwater {version}), the worker has `{worker}`: \
         their pixels would differ. Install Shearwater {version} on the worker"
    )]
    Build {
        farm: String,
        worker: String,
        version: &'static str,
    },
    #[error(
        "job {job} was begun with build `{first}`, this is build `{build}`: their pixels would \
         differ. Submit the job again, or finish it with the Shearwater that began it"
    )]
    JobBuild {
        job: i64,
        first: String,
        build: String,
    },
    #[error("job {0} was {1}: nothing can be added to it; submit it again")]
    NotDone(i64, &'static str),
    #[error(
        "this coordinator (Shearwater {version}) speaks protocol {ours}, the worker {theirs}. \
         Install Shearwater {version} on the worker"
    )]
    Protocol {
        ours: u16,
        theirs: u16,
        version: &'static str,
    },
    #[error(
        "the worker failed on different units in a row and gets no work for {0} s; look at its \
         log, then restart it"
    )]
    Quarantined(i64),
    #[error("job {0} has ended; drop what you hold of it")]
    Ended(i64),
    #[error(
        "this run was counted before with other sums: one of two machines computes wrongly. The \
         alarm is in the coordinator's log; do not send the result again"
    )]
    Unequal,
    #[error("too many requests wait already; try again in a few seconds")]
    Busy,
    #[error("not ready: {0}")]
    NotReady(String),
    #[error(
        "the {what} fails at the moment, so work pauses; /readyz says why. Nothing that was \
         acknowledged is lost. Try again"
    )]
    Unavailable { what: &'static str, cause: String },
    #[error("the coordinator cannot do this now; its log says why. Try again")]
    Internal(String),
}

impl ApiError {
    /// Status, stable name and short text of the kind of error.
    const fn kind(&self) -> (StatusCode, &'static str, &'static str) {
        match self {
            Self::NoRoute => (StatusCode::NOT_FOUND, "no-route", "No such path"),
            Self::Method => (
                StatusCode::METHOD_NOT_ALLOWED,
                "method",
                "Method not allowed",
            ),
            Self::NotFound(_) => (StatusCode::NOT_FOUND, "not-found", "Not found"),
            Self::BadRequest(_) => (StatusCode::BAD_REQUEST, "bad-request", "Bad request"),
            Self::MediaType(_) => (
                StatusCode::UNSUPPORTED_MEDIA_TYPE,
                "media-type",
                "Unsupported media type",
            ),
            Self::TooLarge(_) => (StatusCode::PAYLOAD_TOO_LARGE, "too-large", "Body too large"),
            Self::Timeout => (StatusCode::REQUEST_TIMEOUT, "timeout", "Body too slow"),
            Self::Invalid(_) => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "invalid",
                "Invalid content",
            ),
            Self::KeyReused(_) => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "idempotency-key-reused",
                "Idempotency key reused",
            ),
            Self::Build { .. } => (StatusCode::CONFLICT, "build", "Another numeric build"),
            Self::JobBuild { .. } => (StatusCode::CONFLICT, "job-build", "Another numeric build"),
            Self::NotDone(..) => (StatusCode::CONFLICT, "job-ended-early", "Job has ended"),
            Self::Protocol { .. } => (StatusCode::CONFLICT, "protocol", "Another protocol"),
            Self::Quarantined(_) => (StatusCode::FORBIDDEN, "quarantined", "Worker quarantined"),
            Self::Ended(_) => (StatusCode::GONE, "job-ended", "Job has ended"),
            Self::Unequal => (StatusCode::CONFLICT, "unequal-result", "Unequal result"),
            Self::Busy => (StatusCode::SERVICE_UNAVAILABLE, "busy", "Busy"),
            Self::NotReady(_) => (StatusCode::SERVICE_UNAVAILABLE, "not-ready", "Not ready"),
            Self::Unavailable { .. } => (
                StatusCode::SERVICE_UNAVAILABLE,
                "store-unavailable",
                "Store unavailable",
            ),
            Self::Internal(_) => (
                StatusCode::INTERNAL_SERVER_ERROR,
                "internal",
                "Internal error",
            ),
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response<Body> {
        if let Self::Internal(cause) = &self {
            // The cause may name files; it is for the log alone.
            tracing::error!(cause, "a request failed");
        }
        if let Self::Unavailable { what, cause } = &self {
            tracing::warn!(what, cause, "a request has to come again");
        }
        let (status, name, title) = self.kind();
        problem(status, name, title, self.to_string())
    }
}

fn problem(status: StatusCode, name: &str, title: &str, mut detail: String) -> Response<Body> {
    if detail.len() > DETAIL_BYTES_MAX {
        let end = (0..=DETAIL_BYTES_MAX).rfind(|&at| detail.is_char_boundary(at));
        detail.truncate(end.unwrap_or(0));
        detail.push_str(" ...");
    }
    let problem = Problem {
        kind: format!("urn:shearwater:problem:{name}"),
        title: title.to_owned(),
        status: status.as_u16(),
        detail,
    };
    let body = serde_json::to_vec(&problem).unwrap_or_default();
    let mut response = Response::new(Body::from(body));
    *response.status_mut() = status;
    response
        .headers_mut()
        .insert(header::CONTENT_TYPE, PROBLEM_JSON);
    response
}

/// The answer to a request whose handler panicked: a fault of the program.
// The layer hands the cause over by value.
#[allow(clippy::needless_pass_by_value)]
pub(crate) fn panicked(cause: Box<dyn std::any::Any + Send + 'static>) -> Response<Body> {
    let text = cause
        .downcast_ref::<String>()
        .cloned()
        .or_else(|| cause.downcast_ref::<&str>().map(|&s| s.to_owned()));
    ApiError::Internal(format!("panic: {}", text.unwrap_or_default())).into_response()
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        let cause = error.to_string();
        match error {
            StoreError::Sql { .. } => Self::Unavailable {
                what: "database",
                cause,
            },
            _ => Self::Internal(cause),
        }
    }
}

impl From<ObjectError> for ApiError {
    fn from(error: ObjectError) -> Self {
        let cause = error.to_string();
        if error.is_missing() {
            return Self::Internal(cause);
        }
        Self::Unavailable {
            what: "object store",
            cause,
        }
    }
}

impl From<CutOff> for ApiError {
    fn from(error: CutOff) -> Self {
        Self::Internal(error.to_string())
    }
}

impl From<FoldError> for ApiError {
    fn from(error: FoldError) -> Self {
        Self::Internal(error.to_string())
    }
}

impl From<DevelopError> for ApiError {
    fn from(error: DevelopError) -> Self {
        match error {
            DevelopError::Setting { .. } => Self::BadRequest(error.to_string()),
            other => Self::Internal(other.to_string()),
        }
    }
}
