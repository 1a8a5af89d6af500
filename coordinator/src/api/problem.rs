//! Every error of the API, and the only place that maps them to HTTP (RFC 9457).

use super::kinds::{Kind, PREFIX};
use crate::app::CutOff;
use crate::develop::DevelopError;
use crate::fold::FoldError;
use crate::objects::ObjectError;
use crate::store::StoreError;
use crate::webhook::Forbidden;
use axum::body::Body;
use axum::http::{HeaderValue, Response, StatusCode, header};
use axum::response::IntoResponse;
use shearwater_shared::api::Problem;

/// Content type of every error.
pub(crate) const PROBLEM_JSON: HeaderValue = HeaderValue::from_static("application/problem+json");
/// What a client without a valid token is asked for.
const BEARER: HeaderValue = HeaderValue::from_static("Bearer realm=\"shearwater\"");
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
    #[error("the range begins behind the end: there are {0} bytes")]
    Range(u64),
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
    #[error("job {0} {1}: only a job that has failed can be tried again; submit it once more")]
    NotFailed(i64, &'static str),
    #[error(
        "this coordinator (Shearwater {version}) speaks protocol {ours}, the worker {theirs}. \
         Install Shearwater {version} on the worker"
    )]
    Protocol {
        ours: u16,
        theirs: u16,
        version: &'static str,
    },
    #[error("this worker gets no work for {0} s: {1}; look at its log, then restart it")]
    Quarantined(i64, String),
    #[error("job {0} has ended; drop what you hold of it")]
    Ended(i64),
    #[error(
        "this run was counted before with other sums: one of two machines computes wrongly. The \
         alarm is in the coordinator's log; do not send the result again"
    )]
    Unequal,
    #[error(
        "Content-Encoding {0:?} is not understood; send the content as it is, so that its length \
         says how much it is"
    )]
    Encoding(String),
    #[error("{0}")]
    QueueFull(String),
    #[error("{0}")]
    Unauthorized(String),
    #[error("{0}")]
    Forbidden(String),
    #[error("more requests than this coordinator takes from one token or address; wait {0} s")]
    TooMany(u64),
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
    /// Whether it is this side's: the same request may succeed later.
    pub(crate) const fn is_ours(&self) -> bool {
        self.kind().status() >= 500
    }

    /// The kind of error: status, type and title.
    const fn kind(&self) -> Kind {
        match self {
            Self::NoRoute => Kind::NoRoute,
            Self::Method => Kind::Method,
            Self::NotFound(_) => Kind::NotFound,
            Self::BadRequest(_) => Kind::BadRequest,
            Self::MediaType(_) => Kind::MediaType,
            Self::TooLarge(_) => Kind::TooLarge,
            Self::Timeout => Kind::Timeout,
            Self::Range(_) => Kind::Range,
            Self::Invalid(_) => Kind::Invalid,
            Self::KeyReused(_) => Kind::KeyReused,
            Self::Build { .. } => Kind::Build,
            Self::JobBuild { .. } => Kind::JobBuild,
            Self::NotDone(..) => Kind::JobEndedEarly,
            Self::NotFailed(..) => Kind::JobNotFailed,
            Self::Protocol { .. } => Kind::Protocol,
            Self::Quarantined(..) => Kind::Quarantined,
            Self::Ended(_) => Kind::JobEnded,
            Self::Unequal => Kind::UnequalResult,
            Self::Encoding(_) => Kind::Encoding,
            Self::QueueFull(_) => Kind::QueueFull,
            Self::Unauthorized(_) => Kind::Unauthorized,
            Self::Forbidden(_) => Kind::Forbidden,
            Self::TooMany(_) => Kind::TooMany,
            Self::Busy => Kind::Busy,
            Self::NotReady(_) => Kind::NotReady,
            Self::Unavailable { .. } => Kind::StoreUnavailable,
            Self::Internal(_) => Kind::Internal,
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
        let mut response = problem(self.kind(), self.to_string());
        let headers = response.headers_mut();
        match self {
            Self::Range(length) => {
                if let Ok(value) = HeaderValue::try_from(format!("bytes */{length}")) {
                    headers.insert(header::CONTENT_RANGE, value);
                }
            }
            Self::Unauthorized(_) => {
                headers.insert(header::WWW_AUTHENTICATE, BEARER);
            }
            Self::TooMany(seconds) => {
                headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
            }
            _ => {}
        }
        response
    }
}

fn problem(kind: Kind, mut detail: String) -> Response<Body> {
    if detail.len() > DETAIL_BYTES_MAX {
        let end = (0..=DETAIL_BYTES_MAX).rfind(|&at| detail.is_char_boundary(at));
        detail.truncate(end.unwrap_or(0));
        detail.push_str(" ...");
    }
    let problem = Problem {
        kind: format!("{PREFIX}{}", kind.name()),
        title: kind.title().to_owned(),
        status: kind.status(),
        detail,
    };
    let body = serde_json::to_vec(&problem).unwrap_or_default();
    let mut response = Response::new(Body::from(body));
    let status = StatusCode::from_u16(kind.status());
    *response.status_mut() = status.unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
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
        if error.is_of_database() {
            let what = "database";
            return Self::Unavailable { what, cause };
        }
        Self::Internal(cause)
    }
}

impl From<Forbidden> for ApiError {
    fn from(error: Forbidden) -> Self {
        Self::Invalid(error.to_string())
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
