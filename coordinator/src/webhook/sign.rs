//! How a receiver knows that a message is the farm's.

use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use std::fmt::{self, Write};

/// What signs; never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl Secret {
    /// Length in bytes.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// Nothing at all.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl From<String> for Secret {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(..)")
    }
}

/// The value of the signature's header: `v1=` and the HMAC-SHA256, in hexadecimal
/// digits, of the timestamp, a full stop and the body.
pub(super) fn signature(secret: &Secret, timestamp_s: i64, body: &[u8]) -> Option<String> {
    // HMAC takes keys of any length; the type does not say so.
    let mut mac = Hmac::<Sha256>::new_from_slice(secret.0.as_bytes()).ok()?;
    mac.update(timestamp_s.to_string().as_bytes());
    mac.update(b".");
    mac.update(body);
    let mut text = String::from("v1=");
    for byte in mac.finalize().into_bytes() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signature_is_what_another_program_computes() {
        // openssl dgst -sha256 -hmac "Jefe", of `1.{"a":1}`.
        let secret = Secret::from("Jefe".to_owned());
        assert_eq!(
            signature(&secret, 1, br#"{"a":1}"#).as_deref(),
            Some("v1=2e2d701f53fb22a845c526ab056ea5fb34cb46954814a35e088dd20c67b7d1ff")
        );
        assert_eq!(format!("{secret:?}"), "Secret(..)");
    }
}
