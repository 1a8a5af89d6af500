//! Listings come in pages. Where the next one begins is a token: a key of the
//! listing's order, so that rows that come and go in between shift nothing.

use super::problem::ApiError;
use serde::Deserialize;
use shearwater_shared::hash::ContentHash;
use std::fmt::Write;
use utoipa::IntoParams;

/// Digits at a token's end that bind it to its listing.
const CHECK_DIGITS: usize = 8;
/// Longest position in a token, in bytes: the longest name of a worker's instance.
const POSITION_BYTES_MAX: usize = 200;

/// Query of a listing without filters.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(crate) struct PageQuery {
    /// How many at most; the listing has its own limit.
    #[param(nullable = false)]
    pub(crate) page_size: Option<u32>,
    /// `next_page_token` of the page before.
    #[param(nullable = false, pattern = "^(([0-9a-f]{2}){5,204})?$")]
    pub(crate) page_token: Option<String>,
}

/// The token for the page of `listing` that begins after `position`.
pub(crate) fn token(listing: &str, position: &str) -> String {
    let mut token = String::new();
    for byte in position.bytes() {
        // Writing to a String cannot fail.
        let _ = write!(token, "{byte:02x}");
    }
    token.push_str(&check(listing, position));
    token
}

/// The position that a token of `listing` names; `None` for the first page.
pub(crate) fn position(listing: &str, token: Option<&str>) -> Result<Option<String>, ApiError> {
    match token {
        None | Some("") => Ok(None),
        Some(token) => read(listing, token).map(Some),
    }
}

/// The same, of a listing that is ordered by numbers.
pub(crate) fn number<T: std::str::FromStr>(
    listing: &str,
    token: Option<&str>,
) -> Result<Option<T>, ApiError> {
    let position = position(listing, token)?;
    let number = position.map(|text| text.parse().map_err(|_| foreign()));
    number.transpose()
}

fn foreign() -> ApiError {
    ApiError::Invalid(
        "query: page_token is not of this listing; pass the next_page_token of the last answer, \
         with the same filters"
            .into(),
    )
}

fn read(listing: &str, token: &str) -> Result<String, ApiError> {
    let garbled =
        || ApiError::BadRequest("query: page_token is not one that this API gives".into());
    let digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
    let at = token.len().checked_sub(CHECK_DIGITS).ok_or_else(garbled)?;
    let fits = (2..=2 * POSITION_BYTES_MAX).contains(&at) && at.is_multiple_of(2);
    if !fits || !token.bytes().all(digit) {
        return Err(garbled());
    }
    let (digits, given) = token.split_at(at);
    let bytes: Option<Vec<u8>> = digits
        .as_bytes()
        .chunks(2)
        .map(|pair| {
            let pair = std::str::from_utf8(pair).ok()?;
            u8::from_str_radix(pair, 16).ok()
        })
        .collect();
    let position = bytes.and_then(|bytes| String::from_utf8(bytes).ok());
    position
        .filter(|position| check(listing, position) == given)
        .ok_or_else(foreign)
}

/// Not a secret: it tells tokens of one listing from those of another, and from
/// what somebody made up.
fn check(listing: &str, position: &str) -> String {
    let text = format!("page {listing}\n{position}");
    let hash = ContentHash::of(text.as_bytes()).to_string();
    hash.chars().take(CHECK_DIGITS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_first_page_needs_no_token() {
        assert!(matches!(position("jobs", None), Ok(None)));
        assert!(matches!(position("jobs", Some("")), Ok(None)));
    }

    #[test]
    fn a_token_belongs_to_its_listing() {
        let of_jobs = token("jobs", "17");
        assert!(matches!(
            number::<i64>("jobs", Some(&of_jobs)),
            Ok(Some(17))
        ));
        for (listing, token) in [
            ("frames 1", of_jobs.clone()),
            ("jobs", token("jobs", "x")),
            ("jobs", format!("ff{of_jobs}")),
        ] {
            let read = number::<i64>(listing, Some(&token));
            assert!(matches!(read, Err(ApiError::Invalid(_))), "{token}");
        }
        for token in [
            of_jobs.to_uppercase(),
            of_jobs[1..].to_owned(),
            "17".to_owned(),
            "00".repeat(4),
            "00".repeat(205),
            "\u{e9}".repeat(20),
        ] {
            let read = number::<i64>("jobs", Some(&token));
            assert!(matches!(read, Err(ApiError::BadRequest(_))), "{token}");
        }
    }

    proptest! {
        #[test]
        fn positions_come_back(text in "\\PC{1,50}") {
            let token = token("workers", &text);
            let back = position("workers", Some(&token)).expect("ours");
            prop_assert_eq!(back, Some(text));
        }

        #[test]
        fn no_token_is_a_panic(text in "\\PC*") {
            let _ = position("workers", Some(&text));
        }
    }
}
