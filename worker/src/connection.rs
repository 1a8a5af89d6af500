//! How to reach a coordinator, and with what right: for workers and for the
//! command line.

use reqwest::header::{AUTHORIZATION, HeaderMap, HeaderValue};
use reqwest::{Certificate, ClientBuilder, Identity, Url, redirect};
use std::fmt;
use std::time::Duration;

/// A coordinator on the same continent connects far sooner.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// Rest of a connection before it is closed: below the coordinator's 15 seconds,
/// so that no request runs into a closing one.
const IDLE_TIMEOUT: Duration = Duration::from_secs(10);
/// Longest token, in bytes; ours have 76.
const TOKEN_BYTES_MAX: usize = 200;

/// Something that must not be shown: its debug text is empty.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl From<String> for Secret {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl From<&str> for Secret {
    fn from(text: &str) -> Self {
        Self(text.to_owned())
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

/// What a coordinator may ask of whoever connects, and how to know it.
#[derive(Clone, Debug, Default)]
pub struct Access {
    /// Access token.
    pub token: Option<Secret>,
    /// PEM certificates of the only authorities to trust; without it those of
    /// the system. For `https://` alone.
    pub ca: Option<String>,
    /// PEM certificate chain of this client, and its private key. For
    /// `https://` alone.
    pub identity: Option<Secret>,
}

/// Why no connection can be tried. No text holds a secret.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// Not the address of a coordinator.
    #[error("expected http://host:port or https://host:port ({0})")]
    Url(String),
    /// Would be shown in logs and lists of processes.
    #[error("a URL holds no user name or password; give a token instead")]
    UserInfo,
    /// A certificate or authority for a connection without TLS.
    #[error("certificates are given, but http:// uses none; write https://")]
    Plain,
    /// Not a token of ours.
    #[error("the token is not one: expected 1 to {TOKEN_BYTES_MAX} visible ASCII characters")]
    Token,
    /// Not a file of certificates.
    #[error("the authorities' certificates are not PEM: {0}")]
    Ca(String),
    /// Not a certificate with its key.
    #[error("the client certificate and its key are not PEM, or do not belong together: {0}")]
    Identity(String),
}

impl Access {
    /// The address of a coordinator, and clients that connect to it alone: a
    /// token is never sent elsewhere, since redirects are not followed.
    ///
    /// # Errors
    /// See [`AccessError`].
    pub fn connect(&self, url: &str) -> Result<(Url, ClientBuilder), AccessError> {
        let base = Url::parse(url).map_err(|e| AccessError::Url(e.to_string()))?;
        let tls = match base.scheme() {
            "https" => true,
            "http" => false,
            other => return Err(AccessError::Url(format!("not {other}://"))),
        };
        let Some(host) = base.host_str() else {
            return Err(AccessError::Url("no host".into()));
        };
        if !base.username().is_empty() || base.password().is_some() {
            return Err(AccessError::UserInfo);
        }
        // The program does so itself at its start; others that use this crate need
        // not know. A second time changes nothing.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let local = matches!(host, "127.0.0.1" | "[::1]" | "localhost");
        let mut builder = ClientBuilder::new()
            .connect_timeout(CONNECT_TIMEOUT)
            .pool_idle_timeout(IDLE_TIMEOUT)
            .redirect(redirect::Policy::none());
        if local {
            builder = builder.no_proxy();
        }
        builder = if tls {
            self.with_tls(builder)?
        } else if self.ca.is_some() || self.identity.is_some() {
            return Err(AccessError::Plain);
        } else {
            // No authorities: a system without any must do for plain HTTP.
            builder.tls_certs_only([])
        };
        if let Some(token) = &self.token {
            if !tls && !local {
                tracing::warn!(
                    "the token travels unencrypted to {host}: whoever listens on the way can use it. \
                     Serve the coordinator by TLS and write https://"
                );
            }
            builder = builder.default_headers(authorization(token)?);
        }
        Ok((base, builder))
    }

    fn with_tls(&self, mut builder: ClientBuilder) -> Result<ClientBuilder, AccessError> {
        if let Some(ca) = &self.ca {
            let certificates = Certificate::from_pem_bundle(ca.as_bytes())
                .map_err(|e| AccessError::Ca(e.to_string()))?;
            if certificates.is_empty() {
                return Err(AccessError::Ca("no certificate in it".into()));
            }
            builder = builder.tls_certs_only(certificates);
        }
        if let Some(Secret(pem)) = &self.identity {
            let identity = Identity::from_pem(pem.as_bytes())
                .map_err(|e| AccessError::Identity(e.to_string()))?;
            builder = builder.identity(identity);
        }
        Ok(builder)
    }
}

fn authorization(Secret(token): &Secret) -> Result<HeaderMap, AccessError> {
    let visible = token.bytes().all(|byte| byte.is_ascii_graphic());
    if !visible || !(1..=TOKEN_BYTES_MAX).contains(&token.len()) {
        return Err(AccessError::Token);
    }
    let mut value =
        HeaderValue::from_str(&format!("Bearer {token}")).map_err(|_| AccessError::Token)?;
    // Logs of the HTTP library leave it out.
    value.set_sensitive(true);
    Ok(HeaderMap::from_iter([(AUTHORIZATION, value)]))
}

/// An error with its causes: the outermost text alone says only "error sending
/// request".
#[must_use]
pub fn causes(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOKEN: &str = "sw_0123456789_secret";

    fn refusal(access: &Access, url: &str) -> String {
        let error = access.connect(url).expect_err(url);
        format!("{error} {error:?}")
    }

    #[test]
    fn addresses() {
        let access = Access::default();
        for good in ["http://farm:7788", "https://[::1]:7788", "http://127.0.0.1"] {
            assert!(access.connect(good).is_ok(), "{good}");
        }
        for bad in ["", "farm", "ftp://farm", "file:///etc/passwd", "http:///"] {
            refusal(&access, bad);
        }
        let text = refusal(&access, "http://user:hunter2@farm");
        assert!(
            text.contains("token") && !text.contains("hunter2"),
            "{text}"
        );
    }

    #[test]
    fn no_text_shows_a_secret() {
        let access = Access {
            token: Some(TOKEN.into()),
            identity: Some("-----BEGIN PRIVATE KEY-----\nc2VjcmV0\n".into()),
            ca: None,
        };
        assert!(!format!("{access:?}").contains("secret"), "{access:?}");
        assert!(!format!("{access:?}").contains("PRIVATE"), "{access:?}");
        let text = refusal(&access, "https://farm");
        assert!(!text.contains("c2VjcmV0"), "{text}");
        assert!(refusal(&access, "http://farm").contains("https://"));
        for bad in ["", "two words", "line\nbreak", "\u{e9}", &"x".repeat(201)] {
            let access = Access {
                token: Some(bad.into()),
                ..Access::default()
            };
            let text = refusal(&access, "http://farm");
            assert!(text.contains("visible ASCII"), "{text}");
            assert!(bad.len() < 2 || !text.contains(bad), "{text}");
        }
        let access = Access {
            token: Some(TOKEN.into()),
            ..Access::default()
        };
        let (_, builder) = access.connect("http://127.0.0.1").expect("fine");
        let mut text = format!("{builder:?}");
        text.push_str(&format!("{:?}", builder.build()));
        assert!(!text.contains(TOKEN), "{text}");
    }
}
