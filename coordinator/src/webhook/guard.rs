//! Where webhooks may go. Whoever may submit a job chooses an address that the
//! coordinator then calls: without a rule that would open services of the farm's own
//! network to them. Public addresses are allowed, all others only if whoever runs the
//! farm named their host. What counts is the address that is connected to, not what a
//! name said earlier; redirects are not followed, and proxies not asked.

use reqwest::Url;
use reqwest::dns::{Addrs, Name, Resolve, Resolving};
use shearwater_shared::limits::WEBHOOK_URL_BYTES_MAX;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;

/// Why a webhook is not called.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Forbidden {
    /// Not an address that can be called.
    #[error(
        "webhook.url: expected http:// or https:// and a host, at most {WEBHOOK_URL_BYTES_MAX} \
         bytes, without user and password"
    )]
    Address,
    /// Within some private network.
    #[error(
        "webhook: {0} has no public address; whoever runs the farm can allow it \
         (--webhook-allow {0})"
    )]
    Private(String),
}

/// Which hosts may be called although their addresses are private; `*` is any.
#[derive(Clone, Debug)]
pub(super) struct Guard {
    allowed: Arc<[String]>,
}

impl Guard {
    pub(super) fn new(allowed: &[String]) -> Self {
        Self {
            allowed: allowed.iter().map(|host| host.to_lowercase()).collect(),
        }
    }

    fn allows(&self, host: &str) -> bool {
        self.allowed.iter().any(|name| name == "*" || name == host)
    }

    /// Check an address as far as that is possible without asking for the host.
    pub(super) fn check(&self, url: &str) -> Result<Url, Forbidden> {
        if url.len() > WEBHOOK_URL_BYTES_MAX {
            return Err(Forbidden::Address);
        }
        let url = Url::parse(url).map_err(|_| Forbidden::Address)?;
        let plain = url.username().is_empty() && url.password().is_none();
        let host = url.host_str().filter(|host| !host.is_empty());
        let (Some(host), true, "http" | "https") = (host, plain, url.scheme()) else {
            return Err(Forbidden::Address);
        };
        // Names are resolved when they are called.
        let literal = host.trim_start_matches('[').trim_end_matches(']').parse();
        if let Ok(ip) = literal
            && !is_public(ip)
            && !self.allows(host)
        {
            return Err(Forbidden::Private(host.to_owned()));
        }
        Ok(url)
    }
}

impl Resolve for Guard {
    fn resolve(&self, name: Name) -> Resolving {
        let guard = self.clone();
        Box::pin(async move {
            let host = name.as_str().to_lowercase();
            let free = guard.allows(&host);
            let found = tokio::net::lookup_host((host.as_str(), 0)).await?;
            let may: Vec<SocketAddr> = found.filter(|at| free || is_public(at.ip())).collect();
            if may.is_empty() {
                return Err(Forbidden::Private(host).into());
            }
            Ok(Box::new(may.into_iter()) as Addrs)
        })
    }
}

/// Whether an address is one of the public internet (the registries of special
/// addresses, RFC 6890 and its successors).
fn is_public(ip: IpAddr) -> bool {
    match ip {
        IpAddr::V4(ip) => is_public_v4(ip),
        IpAddr::V6(ip) => is_public_v6(ip),
    }
}

fn is_public_v4(ip: Ipv4Addr) -> bool {
    let [a, b, c, _] = ip.octets();
    !(ip.is_loopback()
        || ip.is_private()
        || ip.is_link_local()
        || ip.is_documentation()
        || ip.is_multicast()
        || a == 0
        // Between providers and their customers.
        || (a == 100 && (64..128).contains(&b))
        || (a == 192 && b == 0 && c == 0)
        || (a == 192 && b == 88 && c == 99)
        // For measurements.
        || (a == 198 && (18..20).contains(&b))
        || a >= 240)
}

fn is_public_v6(ip: Ipv6Addr) -> bool {
    let s = ip.segments();
    let v4 = |high: u16, low: u16| {
        let ([a, b], [c, d]) = (high.to_be_bytes(), low.to_be_bytes());
        is_public_v4(Ipv4Addr::new(a, b, c, d))
    };
    match s {
        // IPv4 in other clothes: mapped, translated, 6to4.
        [0, 0, 0, 0, 0, 0xffff, high, low] | [0x64, 0xff9b, 0, 0, 0, 0, high, low] => v4(high, low),
        [0x2002, high, low, ..] => v4(high, low),
        // Teredo, documentation, and other special ones below 2001::/23.
        [0x2001, second, ..] if second < 0x200 || second == 0xdb8 => false,
        [0x3fff, second, ..] if second < 0x1000 => false,
        // Only 2000::/3 is given out.
        [first, ..] => first & 0xe000 == 0x2000,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn private_addresses_are_private_in_every_spelling() {
        let guard = Guard::new(&[]);
        for url in [
            "http://127.0.0.1/",
            "http://127.1:8080/x",
            "http://0x7f000001/",
            "http://2130706433/",
            "http://0/",
            "http://10.1.2.3/",
            "http://172.31.0.1/",
            "http://192.168.0.1/",
            "http://169.254.169.254/latest/meta-data",
            "http://100.100.0.1/",
            "http://198.18.0.1/",
            "http://224.0.0.1/",
            "http://255.255.255.255/",
            "http://[::1]/",
            "http://[::]/",
            "http://[::ffff:127.0.0.1]/",
            "http://[64:ff9b::10.0.0.1]/",
            "http://[2002:7f00:1::]/",
            "http://[fe80::1]/",
            "http://[fd00::1]/",
            "http://[ff02::1]/",
            "http://[2001:db8::1]/",
        ] {
            let refused = guard.check(url);
            assert!(matches!(refused, Err(Forbidden::Private(_))), "{url}");
        }
        for url in [
            "https://93.184.215.14/x?y=1",
            "http://[2a00:1450::1]/",
            "https://farm.example/",
        ] {
            assert!(guard.check(url).is_ok(), "{url}");
        }
    }

    #[test]
    fn other_addresses_are_none() {
        let guard = Guard::new(&["*".into()]);
        let long = format!("http://a/{}", "x".repeat(WEBHOOK_URL_BYTES_MAX));
        for url in [
            "",
            "x",
            "ftp://a/",
            "file:///etc/passwd",
            "http://",
            "http://u:p@a/",
            "http://u@a/",
            &long,
        ] {
            assert!(matches!(guard.check(url), Err(Forbidden::Address)), "{url}");
        }
        assert!(guard.check("http://127.0.0.1/").is_ok());
        let named = Guard::new(&["127.0.0.1".into()]);
        assert!(named.check("http://127.0.0.1:9/").is_ok());
        assert!(named.check("http://127.0.0.2:9/").is_err());
    }

    #[tokio::test]
    async fn a_name_of_a_private_address_is_refused_when_it_is_called() {
        let call = async |allowed: &[String]| {
            let guard = Guard::new(allowed);
            let name: Name = "localhost".parse().expect("name");
            guard.resolve(name).await.map(Iterator::count)
        };
        let refused = call(&[]).await.expect_err("private");
        assert!(
            refused.to_string().contains("--webhook-allow localhost"),
            "{refused}"
        );
        assert!(call(&["LOCALHOST".into()]).await.expect("allowed") > 0);
    }
}
