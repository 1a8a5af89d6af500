//! A farm that strangers can reach: slow clients, tokens, foreign pages.

mod common;
mod guarded;
mod slow;

use common::process::{Process, command};
use guarded::{Guarded, folder_with_tokens, text, token};
use slow::{ask, ask_and_sleep, drip};
use std::time::{Duration, Instant};

fn open_farm() -> Guarded {
    Guarded::start(tempfile::tempdir().expect("temporary folder"), &[])
}

fn seconds(range: std::ops::Range<u64>, time: Duration) {
    assert!(
        range.contains(&time.as_secs()),
        "{time:?} is not in {range:?} s"
    );
}

#[test]
fn slow_clients_are_cut_and_others_are_served_meanwhile() {
    let farm = open_farm();
    let address = farm.address();
    // More than the buffers of two kernels.
    let body = vec![7u8; 64 << 20];
    let asset = format!(
        "/v1/assets/{}",
        shearwater_shared::hash::ContentHash::of(&body)
    );
    let head = format!(
        "PUT {asset} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\ncontent-length: {}\r\n\r\n",
        body.len()
    );
    let stored = ask(address, &[head.as_bytes(), &body].concat());
    assert!(stored.starts_with("HTTP/1.1 201"), "{stored}");
    let waiting = std::thread::scope(|scope| {
        let header =
            scope.spawn(|| drip(address, "GET /healthz HTTP/1.1\r\nhost: localhost\r\nx: "));
        let first_line = scope.spawn(|| drip(address, ""));
        let json = scope.spawn(|| {
            let head = "POST /v1/jobs HTTP/1.1\r\nhost: localhost\r\n\
                        content-type: application/json\r\ncontent-length: 1000\r\n\r\n";
            drip(address, head)
        });
        let upload = scope.spawn(|| {
            let head =
                format!("PUT {asset} HTTP/1.1\r\nhost: localhost\r\ncontent-length: 1000\r\n\r\n");
            drip(address, &head)
        });
        let reader = scope.spawn(|| {
            let head = format!("GET {asset} HTTP/1.1\r\nhost: localhost\r\n\r\n");
            ask_and_sleep(address, &head, Duration::from_secs(40))
        });
        let mut longest = Duration::ZERO;
        while ![&header, &first_line, &json, &upload]
            .iter()
            .all(|t| t.is_finished())
        {
            let began = Instant::now();
            let answer = ask(
                address,
                b"GET /v1/jobs HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n",
            );
            assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
            longest = longest.max(began.elapsed());
            std::thread::sleep(Duration::from_millis(200));
        }
        for head in [header, first_line] {
            seconds(14..25, head.join().expect("client").after);
        }
        for body in [json, upload] {
            let cut = body.join().expect("client");
            seconds(29..45, cut.after);
            assert!(cut.answer.starts_with("HTTP/1.1 408"), "{cut:?}");
            assert!(
                cut.answer.contains("urn:shearwater:problem:timeout"),
                "{cut:?}"
            );
        }
        let taken = reader.join().expect("client");
        assert!(taken < body.len(), "all {taken} bytes came");
        longest
    });
    seconds(0..2, waiting);
}

/// Revoked and new tokens count within five seconds; a slow machine gets more.
const EFFECT: Duration = Duration::from_secs(8);

/// The status code of a request.
fn status(farm: &Guarded, token: &str, method: &str, path: &str, more: &str) -> u16 {
    let authorization = match token {
        "" => String::new(),
        token => format!("authorization: Bearer {token}\r\n"),
    };
    let request = format!(
        "{method} {path} HTTP/1.1\r\nhost: localhost\r\n{authorization}{more}connection: close\r\n\r\n"
    );
    let answer = ask(farm.address(), request.as_bytes());
    let code = answer
        .strip_prefix("HTTP/1.1 ")
        .and_then(|rest| rest.get(..3));
    code.and_then(|code| code.parse().ok())
        .unwrap_or_else(|| panic!("{answer}"))
}

/// Wait until a request has this status; never longer than [`EFFECT`].
fn becomes(farm: &Guarded, token: &str, expected: u16) {
    let began = Instant::now();
    loop {
        let found = status(farm, token, "GET", "/v1/jobs", "");
        if found == expected {
            return;
        }
        assert!(began.elapsed() < EFFECT, "still {found}, not {expected}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn a_first_token_closes_a_farm_for_ever_on_every_coordinator() {
    let farm = open_farm();
    let data = farm.data.to_str().expect("UTF-8");
    let twin_folder = tempfile::tempdir().expect("temporary folder");
    // A second coordinator on the same store.
    std::os::unix::fs::symlink(data, twin_folder.path().join("data")).expect("link");
    let twin = Guarded::start(twin_folder, &[]);
    for farm in [&farm, &twin] {
        assert_eq!(status(farm, "", "GET", "/v1/jobs", ""), 200);
        // No web page may use what is open to this machine.
        let foreign = "sec-fetch-site: cross-site\r\n";
        assert_eq!(status(farm, "", "GET", "/v1/jobs", foreign), 403);
    }
    let anna = token(&farm.data, &["--role", "client", "--name", "anna"]);
    let brief = token(&farm.data, &["--role", "client", "--expires", "2s"]);
    for farm in [&farm, &twin] {
        becomes(farm, "", 401);
        becomes(farm, &anna, 200);
        becomes(farm, &brief, 401);
        let healthz = status(farm, "", "GET", "/healthz", "");
        assert_eq!(healthz, 200, "probes need no token");
    }
    let list = ["token", "list", "--json", "--data", data];
    let listed = common::process::run(list).ok();
    let secret = anna.rsplit('_').next().expect("secret");
    assert!(!listed.stdout.contains(secret), "{}", listed.stdout);
    let first = &listed.json()["tokens"][0];
    assert_eq!(
        (text(&first["name"]), text(&first["state"])),
        ("anna".into(), "valid".into())
    );
    common::process::run(["token", "revoke", &text(&first["id"]), "--data", data]).ok();
    for farm in [&farm, &twin] {
        becomes(farm, &anna, 401);
        assert_eq!(
            status(farm, "", "GET", "/v1/jobs", ""),
            401,
            "it opens never again"
        );
    }
    // The database, as a thief would read it.
    for file in std::fs::read_dir(&farm.data).expect("folder").flatten() {
        let bytes = std::fs::read(file.path()).unwrap_or_default();
        let found = bytes.windows(secret.len()).any(|w| w == secret.as_bytes());
        assert!(!found, "{}", file.path().display());
    }
}

#[test]
fn each_role_may_do_its_own() {
    let (folder, [admin, client, worker]) = folder_with_tokens();
    let farm = Guarded::start(folder, &[]);
    let stranger = format!("sw_00c0ffee_{}", "5".repeat(64));
    let wrong = format!(
        "{}{}",
        &client[..client.len() - 1],
        if client.ends_with('0') { '1' } else { '0' }
    );
    let asset = format!("/v1/assets/{}", "0".repeat(64));
    let json = "content-type: application/json\r\ncontent-length: 2\r\n";
    // Status for admin, client, worker; everybody else gets 401.
    let cases = [
        ("GET", "/v1/jobs", "", [200, 200, 403]),
        ("GET", "/v1/workers", "", [200, 200, 403]),
        ("GET", "/nothing", "", [404, 404, 403]),
        ("GET", asset.as_str(), "", [404, 404, 404]),
        (
            "PUT",
            asset.as_str(),
            "content-length: 0\r\n",
            [422, 422, 403],
        ),
        ("DELETE", "/v1/jobs/99", "", [404, 404, 403]),
        ("POST", "/v1/worker/leases", json, [400, 403, 400]),
        ("POST", "/v1/worker/results", json, [415, 403, 415]),
        ("POST", "/v1/worker/release", json, [400, 403, 400]),
    ];
    for (method, path, more, expected) in cases {
        let body = if more == json {
            "content-type: application/json\r\ncontent-length: 0\r\n"
        } else {
            more
        };
        let found =
            [&admin, &client, &worker].map(|token| status(&farm, token, method, path, body));
        assert_eq!(found, expected, "{method} {path}");
        for token in ["", "x", &stranger, &wrong, "sw_"] {
            assert_eq!(
                status(&farm, token, method, path, body),
                401,
                "{method} {path} {token}"
            );
        }
    }
    let refused = ask(
        farm.address(),
        b"GET /v1/jobs HTTP/1.0\r\nhost: localhost\r\n\r\n",
    );
    let refused = refused.to_ascii_lowercase();
    assert!(refused.contains("www-authenticate: bearer"), "{refused}");
    assert!(refused.contains("application/problem+json"), "{refused}");
}

#[test]
fn a_job_belongs_to_who_submitted_it() {
    let (folder, [admin, client, _]) = folder_with_tokens();
    let farm = Guarded::start(folder, &[]);
    let other = token(&farm.data, &["--role", "client"]);
    let id = farm.submit(&client, &[]);
    let refused = farm.client(&other, &["cancel", &id]).expect_code(5);
    assert!(
        refused.stderr.contains("submitted by another"),
        "{}",
        refused.stderr
    );
    farm.client(&other, &["status", &id]).ok();
    farm.client(&client, &["cancel", &id]).ok();
    let path = format!("/v1/jobs/{id}");
    assert_eq!(status(&farm, &other, "DELETE", &path, ""), 403);
    // The same number, written so that it has to be read twice.
    let escaped: String = id.bytes().map(|digit| format!("%{digit:02X}")).collect();
    let escaped = format!("/v1/jobs/{escaped}");
    assert_eq!(status(&farm, &other, "DELETE", &escaped, ""), 403);
    assert_eq!(status(&farm, &admin, "DELETE", &path, ""), 204);
}

#[test]
fn public_addresses_demand_tokens_to_begin_with() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let data = folder.path().join("data");
    let start = |more: &[&str]| {
        let mut command = command(["coordinator", "--listen", "0.0.0.0:0", "--data"]);
        Process::start(command.arg(&data).args(more))
    };
    let refused = start(&[]).end().expect_code(1);
    assert!(
        refused.stderr.contains("token create"),
        "{}",
        refused.stderr
    );
    let admin = token(&data, &["--role", "admin"]);
    // The permission to do without is worth nothing once there is one.
    let farm = Guarded::listening(folder, "0.0.0.0:0", &["--allow-public"]);
    assert_eq!(status(&farm, "", "GET", "/v1/jobs", ""), 401);
    assert_eq!(status(&farm, &admin, "GET", "/v1/jobs", ""), 200);
    let folder = tempfile::tempdir().expect("temporary folder");
    let open = Guarded::listening(folder, "0.0.0.0:0", &["--allow-public"]);
    assert_eq!(status(&open, "", "GET", "/v1/jobs", ""), 200);
    let log = open.process.stderr();
    assert!(log.contains("everybody who reaches this address"), "{log}");
}

#[test]
fn a_farm_of_tokens_renders_and_logs_none_of_them() {
    let (folder, [admin, client, worker]) = folder_with_tokens();
    let mut command = command(["coordinator", "--json", "--listen", "127.0.0.1:0", "--data"]);
    command
        .arg(folder.path().join("data"))
        .env("RUST_LOG", "trace");
    let coordinator = Process::start(&mut command);
    let url = common::until("the coordinator listens", || {
        let said: serde_json::Value = serde_json::from_str(&coordinator.stdout()).ok()?;
        Some(text(&said["url"]))
    });
    let data = folder.path().join("data");
    let farm = Guarded {
        url,
        process: coordinator,
        data,
        folder,
    };
    let refused = farm.worker(&client, &[]).end().expect_code(5);
    let file = farm.folder.path().join("token");
    std::fs::write(&file, format!("{worker}\n")).expect("file");
    let file = file.to_str().expect("UTF-8");
    let args = ["worker", "--threads", "1", "--token-file", file];
    let mut renders = farm.command("nonsense", &args);
    let renders = Process::start(renders.env("RUST_LOG", "trace"));
    let id = farm.submit(&client, &["-v", "-v"]);
    let job = farm.state_at_end(&client, &id, &[]);
    assert_eq!(job["state"], "done", "{job}");
    let seen = farm.client(&admin, &["jobs", "-vv", "--json"]).ok();
    renders.signal("TERM");
    let rendered = renders.end().ok();
    farm.process.signal("TERM");
    let served = farm.process.end().ok();
    for token in [admin, client, worker] {
        let secret = token.rsplit('_').next().expect("secret");
        for ended in [&refused, &seen, &rendered, &served] {
            assert!(!ended.stderr.contains(secret), "{}", ended.stderr);
            assert!(!ended.stdout.contains(secret), "{}", ended.stdout);
        }
    }
}

#[test]
fn a_token_follows_no_redirect_and_stands_in_no_error() {
    let elsewhere = std::net::TcpListener::bind("127.0.0.1:0").expect("port");
    elsewhere.set_nonblocking(true).expect("option");
    let away = elsewhere.local_addr().expect("address");
    let lying = std::net::TcpListener::bind("127.0.0.1:0").expect("port");
    let url = format!("http://{}", lying.local_addr().expect("address"));
    std::thread::spawn(move || {
        for stream in lying.incoming().flatten() {
            use std::io::{Read, Write};
            let mut stream = stream;
            let _ = stream.read(&mut [0; 4096]);
            let _ = write!(
                stream,
                "HTTP/1.1 307 -\r\nlocation: http://{away}/v1/jobs\r\ncontent-length: 0\r\n\
                 connection: close\r\n\r\n"
            );
        }
    });
    let token = "sw_00c0ffee_secret";
    let run = |args: &[&str], token: &str| {
        let mut command = command(args);
        Process::start(command.env("SHEARWATER_TOKEN", token)).end()
    };
    let refused = run(&["jobs", "-vv", "--coordinator", &url], token);
    assert_ne!(refused.code, Some(0));
    assert!(!refused.stderr.contains("secret"), "{}", refused.stderr);
    let nobody = elsewhere.accept();
    assert!(nobody.is_err(), "the token went to another address");
    let bad = run(&["jobs", "--coordinator", "http://farm"], "two words");
    assert!(!bad.stderr.contains("two words"), "{}", bad.stderr);
    let help = run(&["jobs", "--help"], token);
    assert!(!help.stdout.contains("secret"), "{}", help.stdout);
}
