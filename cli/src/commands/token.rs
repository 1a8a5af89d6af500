//! `shearwater token`: who may use a farm.

use crate::commands::coordinator::{self, Stores};
use crate::exit::CliError;
use crate::output;
use clap::{Args, Subcommand};
use serde_json::{Value, json};
use shearwater_coordinator::access::{self, NewToken, Role};
use shearwater_coordinator::store::{Store, TokenRow};
use std::net::{Ipv4Addr, SocketAddr};
use std::str::FromStr;
use std::time::{SystemTime, UNIX_EPOCH};

/// Make, list and revoke access tokens
///
/// Works on the store itself, on the coordinator's machine, so that the first
/// token can be made; a running coordinator takes notice within five seconds.
/// Once a store has had a token, its coordinators demand one with every request.
///
/// Example: shearwater token create --role client --name anna --data /var/lib/shearwater
#[derive(Args, Debug)]
pub(crate) struct Token {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand, Debug)]
enum Action {
    /// Make a token and print it: once, since the store keeps its hash alone
    Create {
        /// client: read, submit, change own jobs; worker: render; admin: everything
        #[arg(long, value_name = "client|worker|admin")]
        role: Role,
        /// Name for people
        #[arg(long, default_value = "", hide_default_value = true)]
        name: String,
        /// Time until it ends, for example 12h or 90d [default: it does not]
        #[arg(long, value_name = "TIME")]
        expires: Option<Lifetime>,
        #[command(flatten)]
        stores: Stores,
    },
    /// Print a token that no store knows yet, for `coordinator --accept-token`
    Generate,
    /// List all tokens by their public part; ended ones for 90 days
    List {
        #[command(flatten)]
        stores: Stores,
    },
    /// End a token for ever
    Revoke {
        /// Its public part: the eight digits after sw_
        id: String,
        #[command(flatten)]
        stores: Stores,
    },
}

/// A time from now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Lifetime {
    ms: i64,
}

/// Longest lifetime, in days: a century.
const DAYS_MAX: i64 = 36_525;

impl FromStr for Lifetime {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let units = [("s", 1), ("m", 60), ("h", 3_600), ("d", 86_400)];
        let time = units.iter().find_map(|&(unit, seconds)| {
            let count: i64 = text.strip_suffix(unit)?.parse().ok()?;
            let most = DAYS_MAX * 86_400 / seconds;
            (1..=most)
                .contains(&count)
                .then_some(count * seconds * 1000)
        });
        let ms = time.ok_or("expected a number with s, m, h or d, for example 90d")?;
        Ok(Self { ms })
    }
}

pub(crate) async fn run(args: &Token, json: bool) -> Result<(), CliError> {
    let (stores, create) = match &args.action {
        Action::Generate => return generate(json),
        // Only a new token may begin a new store.
        Action::Create { stores, .. } => (stores, true),
        Action::List { stores } | Action::Revoke { stores, .. } => (stores, false),
    };
    let nowhere = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let config = coordinator::config(stores, nowhere)?;
    let store = shearwater_coordinator::open_token_store(&config, create).await;
    let store = store.map_err(|e| CliError::Coordinator(e.to_string()))?;
    let done = act(&store, &args.action, json).await;
    store.close().await;
    done
}

fn generate(json: bool) -> Result<(), CliError> {
    let made = access::generate().map_err(|e| CliError::Coordinator(e.to_string()))?;
    if json {
        output::object(&json!({ "token": made }));
    } else {
        output::line(made);
    }
    Ok(())
}

async fn act(store: &Store, action: &Action, json: bool) -> Result<(), CliError> {
    let failed = |e: &dyn std::error::Error| CliError::Coordinator(e.to_string());
    let now_ms = now_ms();
    match action {
        Action::Create {
            role,
            name,
            expires,
            stores: _,
        } => {
            let new = NewToken {
                role: *role,
                name: name.clone(),
                expires_ms: expires.map(|time| now_ms.saturating_add(time.ms)),
            };
            let made = access::create(store, new, now_ms).await;
            let (row, token) = made.map_err(|e| failed(&e))?;
            if json {
                let mut value = row_json(&row, now_ms);
                value["token"] = token.into();
                output::object(&value);
            } else {
                output::line(token);
                output::note(format_args!(
                    "token {} of role {role}; it is shown this once",
                    row.id
                ));
            }
        }
        Action::Generate => {}
        Action::List { .. } => {
            let rows = store.tokens().await.map_err(|e| failed(&e))?;
            if json {
                let rows: Vec<_> = rows.iter().map(|row| row_json(row, now_ms)).collect();
                output::object(&json!({ "tokens": rows }));
            } else {
                print_table(&rows, now_ms);
            }
        }
        Action::Revoke { id, .. } => {
            let id = public_part(id);
            if !store
                .revoke_token(id, now_ms)
                .await
                .map_err(|e| failed(&e))?
            {
                return Err(CliError::Coordinator(
                    "no token has this public part; `shearwater token list` shows them".into(),
                ));
            }
            if json {
                output::object(&json!({ "id": id, "state": "revoked" }));
            } else {
                output::line(format_args!("revoked {id}"));
            }
        }
    }
    Ok(())
}

/// The eight digits, also of a whole token.
fn public_part(text: &str) -> &str {
    let text = text.strip_prefix("sw_").unwrap_or(text);
    text.split('_').next().unwrap_or_default()
}

fn state(row: &TokenRow, now_ms: i64) -> &'static str {
    if row.revoked_ms.is_some() {
        "revoked"
    } else if row.expires_ms.is_some_and(|end_ms| end_ms <= now_ms) {
        "expired"
    } else {
        "valid"
    }
}

fn row_json(row: &TokenRow, now_ms: i64) -> Value {
    json!({
        "id": row.id,
        "role": row.role.name(),
        "name": row.name,
        "state": state(row, now_ms),
        "created_ms": row.created_ms,
        "expires_ms": row.expires_ms,
        "revoked_ms": row.revoked_ms,
    })
}

fn print_table(rows: &[TokenRow], now_ms: i64) {
    let header = format!(
        "{:8}  {:6}  {:7}  {:10}  NAME",
        "ID", "ROLE", "STATE", "ENDS IN"
    );
    output::line(header);
    for row in rows {
        let left = row.expires_ms.map(|end_ms| (end_ms - now_ms).max(0) / 1000);
        let left = left.map_or_else(|| "never".to_owned(), lifetime_text);
        output::line(format_args!(
            "{:8}  {:6}  {:7}  {left:10}  {}",
            row.id,
            row.role.name(),
            state(row, now_ms),
            row.name
        ));
    }
}

fn lifetime_text(seconds: i64) -> String {
    match seconds {
        s if s >= 86_400 => format!("{} d", s / 86_400),
        s if s >= 3_600 => format!("{} h", s / 3_600),
        s => format!("{} m", s / 60),
    }
}

fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |d| i64::try_from(d.as_millis()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lifetimes() {
        let ms = |text: &str| text.parse::<Lifetime>().map(|time| time.ms).ok();
        assert_eq!(ms("2s"), Some(2_000));
        assert_eq!(ms("1m"), Some(60_000));
        assert_eq!(ms("12h"), Some(43_200_000));
        assert_eq!(ms("90d"), Some(7_776_000_000));
        for bad in [
            "",
            "d",
            "1",
            "0d",
            "-1d",
            "1.5h",
            "99999999999999999999d",
            "40000d",
            "1 d",
        ] {
            assert_eq!(ms(bad), None, "{bad}");
        }
    }

    #[test]
    fn public_parts() {
        for text in ["00c0ffee", "sw_00c0ffee", "sw_00c0ffee_secret"] {
            assert_eq!(public_part(text), "00c0ffee");
        }
    }
}
