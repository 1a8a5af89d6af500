//! TLS with given certificates, and certificates of workers.

use super::connection::Connection;
use super::limits::HANDSHAKE_TIMEOUT;
use axum_server::accept::Accept;
use axum_server::tls_rustls::{RustlsAcceptor, RustlsConfig};
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::{NoServerSessionStorage, VerifierBuilderError, WebPkiClientVerifier};
use rustls::{RootCertStore, ServerConfig};
use std::io;
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::Arc;

/// Largest file of certificates or of a key.
const FILE_BYTES_MAX: u64 = 1 << 20;

/// Files (PEM) that a TLS server needs.
#[derive(Clone, Debug)]
pub struct TlsFiles {
    /// Certificate chain of this coordinator, its own first.
    pub certificate: PathBuf,
    /// Private key of the certificate.
    pub key: PathBuf,
    /// Authorities of workers: the worker protocol then needs a certificate that
    /// one of them signed.
    pub worker_ca: Option<PathBuf>,
}

/// Why there is no TLS. No text holds a key.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file.
    #[error("{path}: {source}")]
    Read {
        /// Which.
        path: PathBuf,
        /// The system's words.
        source: io::Error,
    },
    /// A file without what it should hold.
    #[error("{path}: no {expected} in PEM: {detail}")]
    Pem {
        /// Which.
        path: PathBuf,
        /// What it should hold.
        expected: &'static str,
        /// What is wrong.
        detail: String,
    },
    /// Certificate and key do not fit together, or cannot be used.
    #[error("the certificate and its key cannot be used: {0}")]
    Rejected(#[from] rustls::Error),
    /// The authorities of workers cannot be used.
    #[error("the workers' authorities cannot be used: {0}")]
    Authorities(#[from] VerifierBuilderError),
}

/// TLS as new connections find it; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Tls {
    files: TlsFiles,
    config: RustlsConfig,
}

impl Tls {
    /// Read the files.
    pub(crate) fn load(files: TlsFiles) -> Result<Self, TlsError> {
        let config = RustlsConfig::from_config(Arc::new(server_config(&files)?));
        Ok(Self { files, config })
    }

    /// Read them again for further connections; what cannot be read or used
    /// changes nothing.
    pub(crate) fn reload(&self) -> Result<(), TlsError> {
        let config = server_config(&self.files)?;
        self.config.reload_from_config(Arc::new(config));
        Ok(())
    }

    pub(super) fn acceptor(&self) -> Acceptor {
        let tls = RustlsAcceptor::new(self.config.clone());
        Acceptor {
            tls: tls.handshake_timeout(HANDSHAKE_TIMEOUT),
        }
    }
}

fn server_config(files: &TlsFiles) -> Result<ServerConfig, TlsError> {
    let provider = Arc::new(ring::default_provider());
    let builder = ServerConfig::builder_with_provider(Arc::clone(&provider))
        .with_safe_default_protocol_versions()?;
    let builder = match &files.worker_ca {
        None => builder.with_no_client_auth(),
        Some(authorities) => {
            let mut roots = RootCertStore::empty();
            for certificate in certificates(authorities)? {
                roots.add(certificate)?;
            }
            // Clients of other routes have none; the guard asks by route.
            let verifier = WebPkiClientVerifier::builder_with_provider(roots.into(), provider)
                .allow_unauthenticated()
                .build()?;
            builder.with_client_cert_verifier(verifier)
        }
    };
    let key = PrivateKeyDer::from_pem_slice(&read(&files.key)?).map_err(|e| TlsError::Pem {
        path: files.key.clone(),
        expected: "private key",
        detail: e.to_string(),
    })?;
    let mut config = builder.with_single_cert(certificates(&files.certificate)?, key)?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    if files.worker_ca.is_some() {
        // A resumed session would outlive the certificate that it began with.
        config.session_storage = Arc::new(NoServerSessionStorage {});
        config.send_tls13_tickets = 0;
    }
    Ok(config)
}

fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, TlsError> {
    let wrong = |detail: String| TlsError::Pem {
        path: path.to_owned(),
        expected: "certificate",
        detail,
    };
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&read(path)?).collect();
    let found = found.map_err(|e| wrong(e.to_string()))?;
    if found.is_empty() {
        return Err(wrong("the file holds none".into()));
    }
    Ok(found)
}

fn read(path: &Path) -> Result<Vec<u8>, TlsError> {
    let failed = |source| TlsError::Read {
        path: path.to_owned(),
        source,
    };
    let length = std::fs::metadata(path).map_err(failed)?.len();
    if length > FILE_BYTES_MAX {
        let text = format!("{length} bytes, at most {FILE_BYTES_MAX} are expected");
        return Err(failed(io::Error::other(text)));
    }
    std::fs::read(path).map_err(failed)
}

/// Makes TLS of connections, and notes who showed a certificate.
#[derive(Clone, Debug)]
pub(super) struct Acceptor {
    tls: RustlsAcceptor,
}

impl<S: Send + 'static> Accept<Connection, S> for Acceptor {
    type Stream = <RustlsAcceptor as Accept<Connection, S>>::Stream;
    type Service = S;
    type Future = Pin<Box<dyn Future<Output = io::Result<(Self::Stream, S)>> + Send>>;

    fn accept(&self, connection: Connection, service: S) -> Self::Future {
        let peer = connection.peer();
        let accepting = self.tls.accept(connection, service);
        Box::pin(async move {
            let accepted = accepting.await;
            let (stream, service) = accepted.inspect_err(|error| {
                tracing::debug!(addr = %peer.addr, %error, "no TLS");
            })?;
            if stream.get_ref().1.peer_certificates().is_some() {
                peer.certify();
            }
            Ok((stream, service))
        })
    }
}
