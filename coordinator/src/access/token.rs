//! Tokens: `sw_`, eight digits that name one, `_`, and 32 random bytes.

use super::role::Role;
use crate::store::{Store, StoreError, TokenRow};
use rustls::crypto::ring;
use shearwater_shared::limits::NAME_BYTES_MAX;
use std::fmt::Write;

/// What every token begins with, so that people and scanners know one.
const PREFIX: &str = "sw_";
/// Random bytes of the public part.
const ID_BYTES: usize = 4;
/// Random bytes of the secret part: nobody guesses one of 2^256.
const SECRET_BYTES: usize = 32;
/// Tries at a public part that no other token has.
const TRIES_MAX: u32 = 8;

/// Why no token was made.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// A label that does not fit.
    #[error("name: at most {NAME_BYTES_MAX} bytes")]
    Name,
    /// The store has too many.
    #[error("the store holds as many tokens as it may; revoke some, they go after 90 days")]
    Many,
    /// Not a token.
    #[error("not a token; `shearwater token generate` prints one")]
    Form,
    /// Was ended here.
    #[error("token {0} was revoked in this store; generate another")]
    Revoked(String),
    /// Known as something else.
    #[error("token {0} is stored with another role or secret; generate another")]
    Other(String),
    /// The system gives no random numbers.
    #[error("the system gives no random numbers; nothing was made")]
    Random,
    /// The database.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// What a token shall be.
#[derive(Clone, Debug)]
pub struct NewToken {
    /// What it is for.
    pub role: Role,
    /// Name for people; may be empty.
    pub name: String,
    /// When it ends, in milliseconds since 1970.
    pub expires_ms: Option<i64>,
}

/// Make a token: its row, and its text, which is kept nowhere.
///
/// # Errors
/// See [`TokenError`]; no token was made.
pub async fn create(
    store: &Store,
    new: NewToken,
    now_ms: i64,
) -> Result<(TokenRow, String), TokenError> {
    let NewToken {
        role,
        name,
        expires_ms,
    } = new;
    if name.len() > NAME_BYTES_MAX {
        return Err(TokenError::Name);
    }
    for _ in 0..TRIES_MAX {
        let token = generate()?;
        let new = NewToken {
            role,
            name: name.clone(),
            expires_ms,
        };
        let row = row_of(&token, new, now_ms).ok_or(TokenError::Form)?;
        if store.add_token(&row).await? {
            return Ok((row, token));
        }
    }
    Err(TokenError::Many)
}

/// A token that no store knows yet; see [`adopt`].
///
/// # Errors
/// The system gives no random numbers.
pub fn generate() -> Result<String, TokenError> {
    let (id, secret) = (random::<ID_BYTES>()?, random::<SECRET_BYTES>()?);
    Ok(format!("{PREFIX}{}_{}", hex(&id), hex(&secret)))
}

/// Take a token that was made elsewhere, as a secret of a deployment; one that is
/// stored already stays as it is.
///
/// # Errors
/// It has not the form of a token, was revoked here, or is stored with another
/// role.
pub async fn adopt(
    store: &Store,
    token: &str,
    new: NewToken,
    now_ms: i64,
) -> Result<(), TokenError> {
    let role = new.role;
    let row = row_of(token, new, now_ms).ok_or(TokenError::Form)?;
    if store.add_token(&row).await? {
        return Ok(());
    }
    match store.token(&row.id).await? {
        None => Err(TokenError::Many),
        Some(stored) if stored.revoked_ms.is_some() => Err(TokenError::Revoked(row.id)),
        Some(stored) if is_of(token, &stored) && stored.role == role => Ok(()),
        Some(_) => Err(TokenError::Other(row.id)),
    }
}

fn row_of(token: &str, new: NewToken, now_ms: i64) -> Option<TokenRow> {
    Some(TokenRow {
        id: id_of(token)?.to_owned(),
        hash: hash(token).to_hex().to_string(),
        role: new.role,
        name: new.name,
        created_ms: now_ms,
        expires_ms: new.expires_ms,
        revoked_ms: None,
    })
}

/// The public part of a token, if it has the form of one.
pub(super) fn id_of(token: &str) -> Option<&str> {
    let (id, secret) = token.strip_prefix(PREFIX)?.split_once('_')?;
    let digits = |text: &str, bytes: usize| {
        let lower = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
        text.len() == 2 * bytes && text.bytes().all(lower)
    };
    (digits(id, ID_BYTES) && digits(secret, SECRET_BYTES)).then_some(id)
}

/// Whether `token` is the one of `row`, in a time that does not tell how much of
/// it is right: blake3 compares hashes so.
pub(super) fn is_of(token: &str, row: &TokenRow) -> bool {
    blake3::Hash::from_hex(&row.hash).is_ok_and(|stored| stored == hash(token))
}

fn hash(token: &str) -> blake3::Hash {
    blake3::hash(token.as_bytes())
}

fn random<const N: usize>() -> Result<[u8; N], TokenError> {
    let mut bytes = [0; N];
    let source = ring::default_provider().secure_random;
    source.fill(&mut bytes).map_err(|_| TokenError::Random)?;
    Ok(bytes)
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_token_names_its_row_and_opens_no_other() {
        let secret = "0123456789abcdef".repeat(4);
        let token = format!("sw_00c0ffee_{secret}");
        assert_eq!(id_of(&token), Some("00c0ffee"));
        let row = TokenRow {
            id: "00c0ffee".into(),
            hash: hash(&token).to_hex().to_string(),
            role: Role::Client,
            name: String::new(),
            created_ms: 0,
            expires_ms: None,
            revoked_ms: None,
        };
        assert!(is_of(&token, &row));
        assert!(!is_of(&token.replace("00c0ffee", "00c0ffef"), &row));
        assert!(!is_of(&token.replace("ef", "ee"), &row));
        let damaged = TokenRow {
            hash: "x".into(),
            ..row
        };
        assert!(!is_of(&token, &damaged) && !is_of("", &damaged));
    }

    proptest! {
        #[test]
        fn anything_else_is_no_token(text in "\\PC*") {
            prop_assert_eq!(id_of(&text), None);
        }

        #[test]
        fn one_character_more_or_less_is_none(at in 0usize..76, more in any::<char>()) {
            let good = format!("sw_00c0ffee_{}", "5".repeat(64));
            let mut longer = good.clone();
            longer.insert(at, more);
            prop_assert_eq!(id_of(&longer), None);
            let mut shorter = good;
            shorter.remove(at);
            prop_assert_eq!(id_of(&shorter), None);
        }
    }
}
