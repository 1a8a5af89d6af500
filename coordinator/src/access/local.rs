//! Web pages must not use a coordinator that demands no token.
//!
//! A browser on this machine reaches loopback, and any page that it shows may
//! send requests there. Two headers that no page can forge tell them apart.

use axum::http::{HeaderMap, header};
use std::net::IpAddr;

/// Whether a request may come from a page of another site: its browser says so,
/// or it names this machine by a name that is not its own (a page whose name was
/// made to lead here).
pub(super) fn of_a_foreign_page(headers: &HeaderMap, loopback: bool) -> bool {
    let text = |value: &axum::http::HeaderValue| value.to_str().unwrap_or("?").to_owned();
    let site = headers.get("sec-fetch-site").map(text);
    if matches!(site.as_deref(), Some("cross-site" | "same-site")) {
        return true;
    }
    let host = headers.get(header::HOST).map(text);
    loopback && host.is_some_and(|host| !names_loopback(&host))
}

/// Whether `host` (with or without a port) can mean nothing but this machine.
fn names_loopback(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next(),
        None => host.split(':').next(),
    };
    let name = name.unwrap_or_default();
    let address = name.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback());
    address || name.eq_ignore_ascii_case("localhost")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(&'static str, &'static str)]) -> HeaderMap {
        let pairs = pairs.iter().map(|&(name, value)| {
            let value = value.parse().expect("value");
            (name.parse::<header::HeaderName>().expect("name"), value)
        });
        pairs.collect()
    }

    #[test]
    fn pages_of_other_sites_and_made_up_names_are_foreign() {
        for host in [
            "127.0.0.1",
            "127.0.0.1:7788",
            "[::1]:7788",
            "localhost",
            "LOCALHOST:1",
        ] {
            assert!(
                !of_a_foreign_page(&headers(&[("host", host)]), true),
                "{host}"
            );
        }
        assert!(!of_a_foreign_page(&headers(&[]), true));
        for host in [
            "evil.example",
            "127.0.0.1.evil.example:7788",
            "10.0.0.1",
            "",
            "[",
        ] {
            assert!(
                of_a_foreign_page(&headers(&[("host", host)]), true),
                "{host}"
            );
            assert!(
                !of_a_foreign_page(&headers(&[("host", host)]), false),
                "{host}"
            );
        }
        for (site, foreign) in [
            ("cross-site", true),
            ("same-site", true),
            ("same-origin", false),
            ("none", false),
        ] {
            let headers = headers(&[("host", "localhost"), ("sec-fetch-site", site)]);
            assert_eq!(of_a_foreign_page(&headers, true), foreign, "{site}");
        }
    }
}
