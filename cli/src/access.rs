//! With what right the command line speaks to a coordinator, and whom it trusts.

use crate::exit::CliError;
use clap::Args;
use shearwater_worker::connection::{Access, Secret};
use std::path::{Path, PathBuf};

/// Where a token is looked for when no option gives one.
pub(crate) const TOKEN_VARIABLE: &str = "SHEARWATER_TOKEN";
/// Largest file of a token or of certificates: a system's whole bundle of
/// authorities has a quarter of this.
const FILE_BYTES_MAX: u64 = 1 << 20;

/// Options of every command that speaks to a coordinator.
#[derive(Args, Debug)]
pub(crate) struct AccessArgs {
    /// Access token; others on this machine see it in the list of processes, unlike the variable or a file
    #[arg(long, value_name = "TOKEN", env = TOKEN_VARIABLE, hide_env_values = true)]
    token: Option<Secret>,
    /// File that holds the access token; goes before --token
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Certificates (PEM) of the only authorities to trust for https:// [default: the system's]
    #[arg(long, value_name = "FILE", env = "SHEARWATER_CA")]
    ca: Option<PathBuf>,
}

impl AccessArgs {
    /// Read the files.
    pub(crate) fn read(&self) -> Result<Access, CliError> {
        let token = match &self.token_file {
            Some(file) => Some(read(file)?.trim().into()),
            // An empty variable is one that is not set.
            None => self.token.clone().filter(|token| *token != "".into()),
        };
        let ca = self.ca.as_deref().map(read).transpose()?;
        Ok(Access {
            token,
            ca,
            identity: None,
        })
    }
}

/// The certificate of a worker, for coordinators that demand one.
#[derive(Args, Debug)]
pub(crate) struct IdentityArgs {
    /// Certificate chain (PEM) of this worker, for coordinators that demand one
    #[arg(long, value_name = "FILE", requires = "client_key")]
    client_cert: Option<PathBuf>,
    /// Private key (PEM) of the certificate
    #[arg(long, value_name = "FILE", requires = "client_cert")]
    client_key: Option<PathBuf>,
}

impl IdentityArgs {
    /// Read the files: certificates, then the key.
    pub(crate) fn read(&self) -> Result<Option<Secret>, CliError> {
        let (Some(certificate), Some(key)) = (&self.client_cert, &self.client_key) else {
            return Ok(None);
        };
        let pem = format!("{}\n{}", read(certificate)?, read(key)?);
        Ok(Some(pem.into()))
    }
}

/// A small text file, whole.
pub(crate) fn read(file: &Path) -> Result<String, CliError> {
    let length = std::fs::metadata(file).map_err(CliError::io(file))?.len();
    if length > FILE_BYTES_MAX {
        let text = format!("{length} bytes, at most {FILE_BYTES_MAX} are expected");
        return Err(CliError::io(file)(std::io::Error::other(text)));
    }
    std::fs::read_to_string(file).map_err(CliError::io(file))
}
