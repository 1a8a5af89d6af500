//! What a coordinator refuses because there is too much of it, and what a client says when
//! nobody answers.

mod common;
mod guarded;

use common::process::Ended;
use common::{http, until};
use guarded::{Guarded, folder_with_tokens, text};
use serde_json::{Value, json};
use shearwater_shared::hash::ContentHash;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Jobs of one client that may wait (`coordinator/src/api/submit.rs`).
const OWN_JOBS_MAX: usize = 2_000;
/// Requests that a client's token has at once, and for each second since
/// (`coordinator/src/access/rates.rs`).
const BURST: usize = 5_000;
const PER_S: usize = 500;
/// Most requests that are sent until one is refused.
const REQUESTS_MAX: usize = 60_000;

const SCENE: &str = r#"{
  "version": 1, "name": "sea", "image": {"width": 64, "height": 32},
  "camera": {"position_m": [0, 2, 8], "target_m": [0, 1, 0], "vertical_fov_deg": 40},
  "sky": {"type": "constant", "radiance": [0.5, 0.6, 0.8]}
}"#;

/// One connection that is kept: some thousand requests are to go through it.
struct Line<'a> {
    stream: TcpStream,
    token: &'a str,
    rest: Vec<u8>,
}

/// Status, head and body.
type Answer = (u16, String, String);

impl<'a> Line<'a> {
    fn to(farm: &Guarded, token: &'a str) -> Self {
        let stream = TcpStream::connect(farm.address()).expect("connect");
        let patience = Some(Duration::from_secs(60));
        stream.set_read_timeout(patience).expect("option");
        stream.set_nodelay(true).expect("option");
        let rest = Vec::new();
        Self {
            stream,
            token,
            rest,
        }
    }

    fn request(&self, method: &str, path: &str, media_type: &str, body: &str) -> String {
        format!(
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {}\r\n\
             Content-Type: {media_type}\r\nContent-Length: {}\r\n\r\n{body}",
            self.token,
            body.len()
        )
    }

    fn send(&mut self, method: &str, path: &str, media_type: &str, body: &str) -> Answer {
        let request = self.request(method, path, media_type, body);
        self.stream.write_all(request.as_bytes()).expect("send");
        self.answer()
    }

    /// The next answer; every one of ours says its length.
    fn answer(&mut self) -> Answer {
        loop {
            if let Some(end) = self.rest.windows(4).position(|four| four == b"\r\n\r\n") {
                let head = String::from_utf8_lossy(&self.rest[..end]).to_ascii_lowercase();
                let length = head.split("content-length: ").nth(1);
                let length = length.and_then(|rest| rest.split("\r\n").next());
                let length: usize = length.map_or(0, |text| text.parse().expect("length"));
                if self.rest.len() >= end + 4 + length {
                    let body = self.rest[end + 4..end + 4 + length].to_vec();
                    self.rest.drain(..end + 4 + length);
                    let status = head.split(' ').nth(1).expect("status");
                    let status = status.parse().expect("number");
                    return (status, head, String::from_utf8(body).expect("text"));
                }
            }
            let mut piece = [0; 64 << 10];
            let length = self.stream.read(&mut piece).expect("answer");
            assert!(length > 0, "the connection ended");
            self.rest.extend_from_slice(&piece[..length]);
        }
    }
}

fn problem(body: &str) -> Value {
    serde_json::from_str(body).unwrap_or_else(|e| panic!("{e}: {body}"))
}

#[test]
fn a_client_that_asks_too_often_is_told_when_to_come_again() {
    let (folder, [admin, client, _]) = folder_with_tokens();
    let farm = Guarded::start(folder, &[]);
    let mut line = Line::to(&farm, &client);
    // From then on the token is known, and counted by itself.
    assert_eq!(line.send("GET", "/v1/jobs", "text/plain", "").0, 200);
    let began = Instant::now();
    let (mut sent, mut refused) = (0, None);
    while refused.is_none() {
        assert!(sent < REQUESTS_MAX, "{sent} requests, none refused");
        let some = line
            .request("GET", "/healthz", "text/plain", "")
            .repeat(100);
        line.stream.write_all(some.as_bytes()).expect("send");
        for _ in 0..100 {
            let answer = line.answer();
            sent += 1;
            match answer.0 {
                200 => assert!(refused.is_none() || sent > BURST),
                429 => refused = refused.or(Some((sent, answer))),
                other => panic!("{other}: {answer:?}"),
            }
        }
    }
    let (at, (_, head, body)) = refused.expect("refused");
    let most = BURST + PER_S * (began.elapsed().as_secs() as usize + 2);
    assert!(
        (BURST..most).contains(&at),
        "refused at {at}, of {BURST} to {most}"
    );
    let problem = problem(&body);
    assert_eq!(problem["type"], "urn:shearwater:problem:too-many-requests");
    assert_eq!(problem["status"], 429);
    assert!(text(&problem["detail"]).contains("wait"), "{problem}");
    let wait = head.split("retry-after: ").nth(1).expect("Retry-After");
    let wait: u64 = wait
        .split("\r\n")
        .next()
        .expect("value")
        .parse()
        .expect("seconds");
    assert!((1..=10).contains(&wait), "{wait} s");
    // Nobody else pays for it.
    assert_eq!(
        Line::to(&farm, &admin)
            .send("GET", "/v1/jobs", "text/plain", "")
            .0,
        200
    );
    std::thread::sleep(Duration::from_secs(wait));
    assert_eq!(line.send("GET", "/v1/jobs", "text/plain", "").0, 200);
}

#[test]
fn a_client_whose_jobs_fill_the_queue_is_refused_and_others_are_not() {
    let (folder, [admin, client, _]) = folder_with_tokens();
    let farm = Guarded::start(folder, &[]);
    let mut line = Line::to(&farm, &client);
    let hash = ContentHash::of(SCENE.as_bytes());
    let asset = format!("/v1/assets/{hash}");
    let stored = line.send("PUT", &asset, "application/octet-stream", SCENE);
    assert_eq!(stored.0, 201, "{stored:?}");
    let job = json!({"manifest": {"scene": hash.to_string(), "files": {}}}).to_string();
    let submit = |line: &mut Line<'_>| line.send("POST", "/v1/jobs", "application/json", &job);
    for number in 0..OWN_JOBS_MAX {
        let answer = submit(&mut line);
        assert_eq!(answer.0, 201, "job {number}: {answer:?}");
    }
    let (status, _, body) = submit(&mut line);
    assert_eq!(status, 429, "{body}");
    let problem = problem(&body);
    assert_eq!(problem["type"], "urn:shearwater:problem:queue-full");
    assert!(text(&problem["detail"]).contains("2000"), "{problem}");
    let jobs = {
        let bearer = format!("Bearer {client}");
        http::ask(&farm.url, "GET", "/metrics", &[("authorization", &bearer)]).body
    };
    assert!(
        jobs.contains("shearwater_jobs{state=\"queued\"} 2000"),
        "{jobs}"
    );
    // An admin has no such limit, and a place that gets free is given again.
    assert_eq!(submit(&mut Line::to(&farm, &admin)).0, 201);
    let cancelled = line.send("POST", "/v1/jobs/1/cancel", "application/json", "");
    assert!(cancelled.0 < 300, "{cancelled:?}");
    assert_eq!(submit(&mut line).0, 201);
    assert_eq!(submit(&mut line).0, 429);
}

#[test]
fn a_frozen_coordinator_is_told_within_seconds() {
    let farm = Guarded::start(tempfile::tempdir().expect("folder"), &[]);
    let id = farm.submit("", &[]);
    farm.process.signal("STOP");
    for args in [&["status", &id][..], &["jobs"], &["workers"], &["log", &id]] {
        let began = Instant::now();
        let ended = farm.client("", args).expect_code(4);
        let took = began.elapsed();
        assert!((7..12).contains(&took.as_secs()), "{args:?}: {took:?}");
        says_it_is_silent(&ended, &farm.url);
    }
    farm.process.signal("CONT");
    until("it answers again", || {
        let job = farm.client("", &["status", &id, "--json"]);
        (job.code == Some(0)).then_some(())
    });
}

fn says_it_is_silent(ended: &Ended, url: &str) {
    assert!(
        ended.stderr.contains("has not answered for 8 s"),
        "{}",
        ended.stderr
    );
    assert!(ended.stderr.contains(url), "{}", ended.stderr);
}
