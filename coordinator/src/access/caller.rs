//! Who makes a request, as the guard found out.

use super::role::Role;
use crate::api::ApiError;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;

/// Who makes a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Caller {
    /// Public part of its token; `None` where none is demanded.
    pub(crate) token: Option<String>,
    /// What it may do.
    pub(crate) role: Role,
}

impl Caller {
    /// Whoever reaches a coordinator that demands nothing.
    pub(super) const ANYBODY: Self = Self {
        token: None,
        role: Role::Admin,
    };

    /// Whether it may change a job that was submitted with the token `owner`.
    pub(super) fn may_change(&self, owner: Option<&str>) -> bool {
        match self.role {
            Role::Admin => true,
            Role::Client => owner.is_some() && owner == self.token.as_deref(),
            Role::Worker => false,
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Caller {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        let caller = parts.extensions.get::<Self>().cloned();
        caller.ok_or_else(|| ApiError::Internal("a request came past the guard".into()))
    }
}
