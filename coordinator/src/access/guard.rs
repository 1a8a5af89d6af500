//! Every request passes here before a handler sees it.

use super::caller::Caller;
use super::local::of_a_foreign_page;
use super::needs::{Need, need};
use super::rates::TooSoon;
use super::role::Role;
use super::token;
use crate::api::ApiError;
use crate::app::{App, now_ms};
use crate::serve::Peer;
use crate::store::TokenRow;
use axum::extract::{ConnectInfo, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;
use std::sync::Arc;

/// Let a request through if its caller may make it; the handler then knows the
/// [`Caller`].
pub(crate) async fn guard(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let (mut parts, body) = request.into_parts();
    if let Some(value) = parts.headers.get_mut(header::AUTHORIZATION) {
        // Whoever prints a request leaves it out.
        value.set_sensitive(true);
    }
    let mut response = match admitted(&app, &parts).await {
        Ok(caller) => {
            parts.extensions.insert(caller);
            next.run(Request::from_parts(parts, body)).await
        }
        Err(refusal) => refusal.into_response(),
    };
    // No browser is to make a page of what somebody uploaded.
    let nosniff = HeaderValue::from_static("nosniff");
    let headers = response.headers_mut();
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, nosniff);
    response
}

/// Packed bodies are refused: a short one may hold gigabytes.
fn check_encoding(headers: &HeaderMap) -> Result<(), ApiError> {
    let Some(value) = headers.get(header::CONTENT_ENCODING) else {
        return Ok(());
    };
    let text = String::from_utf8_lossy(value.as_bytes());
    if text.trim().is_empty() || text.trim().eq_ignore_ascii_case("identity") {
        return Ok(());
    }
    Err(ApiError::Encoding(text.chars().take(40).collect()))
}

async fn admitted(app: &App, request: &Parts) -> Result<Caller, ApiError> {
    let need = need(&request.method, request.uri.path());
    let peer = request.extensions.get::<ConnectInfo<Peer>>();
    let peer = peer.ok_or_else(|| ApiError::Internal("a request without a connection".into()))?;
    let address = peer.0.addr.ip();
    let caller = identified(app, &request.headers, need, address).await?;
    let by_certificate = app
        .config
        .tls
        .as_ref()
        .is_some_and(|tls| tls.worker_ca.is_some());
    if need == Need::Worker && by_certificate && !peer.0.is_certified() {
        tracing::info!(%address, "a worker without a certificate");
        return Err(ApiError::Forbidden(
            "workers of this farm need a certificate of its authority: --client-cert, --client-key"
                .into(),
        ));
    }
    if !need.allows(caller.role) {
        tracing::info!(%address, token = caller.token, role = %caller.role, "refused");
        let text = format!(
            "this needs {}, the token that was given is of role {}",
            need.text(),
            caller.role
        );
        return Err(ApiError::Forbidden(text));
    }
    if let Need::Change(job) = need
        && caller.role != Role::Admin
    {
        // A job that is not there is the handler's to say.
        if let Some(owner) = app.store.job_owner(job).await?
            && !caller.may_change(owner.as_deref())
        {
            let text = format!("job {job} was submitted by another; an admin may change it");
            return Err(ApiError::Forbidden(text));
        }
    }
    Ok(caller)
}

/// Who it is: by its token where one is demanded.
async fn identified(
    app: &App,
    headers: &HeaderMap,
    need: Need,
    address: IpAddr,
) -> Result<Caller, ApiError> {
    let given = bearer(headers);
    let id = given.and_then(token::id_of);
    // Whom the store knows is counted by itself; anybody else by address, and
    // before anything is looked up.
    let known = id.and_then(|id| app.tokens.known(id)).flatten();
    let counted = match (&known, given) {
        (Some(row), Some(given)) if token::is_of(given, row) => app.rates.token(&row.id, row.role),
        _ => app.rates.address(address),
    };
    counted.map_err(too_soon)?;
    check_encoding(headers)?;
    if need == Need::Nothing {
        return Ok(Caller::ANYBODY);
    }
    if app.is_open().await? {
        let loopback = app.config.listen.ip().is_loopback();
        return if of_a_foreign_page(headers, loopback) {
            Err(ApiError::Forbidden(
                "this coordinator demands no token, so it answers no web page of another site \
                 and no foreign host name. Make a token (`shearwater token create`) and send it"
                    .into(),
            ))
        } else {
            Ok(Caller::ANYBODY)
        };
    }
    let Some(given) = given else {
        return Err(ApiError::Unauthorized(
            "this coordinator demands a token: send `Authorization: Bearer sw_...`; the program takes \
             --token-file or SHEARWATER_TOKEN"
                .into(),
        ));
    };
    let row = match (known, id) {
        (Some(row), _) => Some(row),
        (None, Some(id)) => app.tokens.find(id).await?,
        (None, None) => None,
    };
    let row = row.filter(|row| token::is_of(given, row));
    let row = row.ok_or_else(|| ApiError::Unauthorized("the token is not known here".into()))?;
    check_time(&row, now_ms())?;
    Ok(Caller {
        token: Some(row.id.clone()),
        role: row.role,
    })
}

fn check_time(row: &TokenRow, now_ms: i64) -> Result<(), ApiError> {
    let text = if row.revoked_ms.is_some() {
        format!("token {} was revoked", row.id)
    } else if row
        .expires_ms
        .is_some_and(|expires_ms| expires_ms <= now_ms)
    {
        format!("token {} has expired", row.id)
    } else {
        return Ok(());
    };
    tracing::info!(text, "refused");
    Err(ApiError::Unauthorized(text))
}

const fn too_soon(TooSoon(wait): TooSoon) -> ApiError {
    ApiError::TooMany(wait.as_secs().saturating_add(1))
}

/// The token of an `Authorization: Bearer` header.
fn bearer(headers: &HeaderMap) -> Option<&str> {
    let value = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    let (scheme, token) = value.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_of_headers() {
        let with = |value: &'static str| {
            let value = HeaderValue::from_static(value);
            HeaderMap::from_iter([(header::AUTHORIZATION, value)])
        };
        for good in ["Bearer abc", "bearer abc", "BEARER  abc "] {
            assert_eq!(bearer(&with(good)), Some("abc"), "{good}");
        }
        for bad in ["abc", "Basic abc", "Bearer", ""] {
            assert_eq!(bearer(&with(bad)), None, "{bad}");
        }
        assert_eq!(bearer(&HeaderMap::new()), None);
    }

    #[test]
    fn a_token_ends_at_its_time() {
        let mut row = TokenRow {
            id: "00000000".into(),
            hash: String::new(),
            role: Role::Client,
            name: String::new(),
            created_ms: 0,
            expires_ms: Some(1000),
            revoked_ms: None,
        };
        assert!(check_time(&row, 999).is_ok());
        assert!(check_time(&row, 1000).is_err());
        row.expires_ms = None;
        assert!(check_time(&row, i64::MAX).is_ok());
        row.revoked_ms = Some(1);
        assert!(check_time(&row, 0).is_err());
    }
}
