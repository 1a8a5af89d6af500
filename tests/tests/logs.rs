//! Logs that programs read: a unit is found in the coordinator's and in its worker's, a
//! request by its name, and no secret in either.

mod common;
mod guarded;

use common::http;
use common::process::Process;
use guarded::{Guarded, folder_with_tokens, text};
use serde_json::Value;

/// Every line of a log, which must be JSON objects with the usual fields.
fn lines(log: &str) -> Vec<Value> {
    let lines: Vec<Value> = log
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}")))
        .collect();
    for line in &lines {
        for field in ["timestamp", "level", "target", "message"] {
            assert!(line[field].is_string(), "no {field}: {line}");
        }
    }
    lines
}

/// A field of a line, or of what the line belongs to.
fn field<'a>(line: &'a Value, name: &str) -> &'a Value {
    let spans = line["spans"].as_array().map_or(&[][..], Vec::as_slice);
    let inner = spans.iter().rev().map(|span| &span[name]);
    let mut all = std::iter::once(&line[name]).chain(inner);
    all.find(|value| !value.is_null()).unwrap_or(&Value::Null)
}

/// What names a unit and its lease.
fn unit(line: &Value) -> Vec<i64> {
    ["job", "lease", "frame", "tile", "block0", "block1"]
        .map(|name| {
            let value = field(line, name);
            value.as_i64().unwrap_or_else(|| panic!("{name}: {line}"))
        })
        .into()
}

fn with_message<'a>(lines: &'a [Value], message: &str) -> Vec<&'a Value> {
    let all = lines.iter();
    all.filter(|line| line["message"] == message).collect()
}

#[test]
fn a_unit_is_found_in_both_logs_and_a_secret_in_none() {
    let (folder, [admin, client, worker]) = folder_with_tokens();
    let options = ["--log-format", "json", "-v"];
    let farm = Guarded::start(folder, &options);
    let id = farm.submit(&client, &[]);
    let renderer = farm.worker(&worker, &options);
    assert_eq!(farm.state_at_end(&client, &id, &[])["state"], "done");
    let bearer = format!("Bearer {client}");
    let credentials = ("authorization", bearer.as_str());
    let named = |id: &str| {
        let headers = [credentials, ("x-request-id", id)];
        let answer = http::ask(&farm.url, "GET", "/v1/jobs/1?secret=of-the-query", &headers);
        answer.header("x-request-id").expect("a name").to_owned()
    };
    assert_eq!(named("my-request.7"), "my-request.7");
    let replaced = named(&client);
    assert_ne!(replaced, client, "a token is no name");
    http::ask(
        &farm.url,
        "GET",
        "/metrics",
        &[("authorization", "Bearer sw_00000000_wrong")],
    );
    renderer.signal("TERM");
    let renderer = renderer.end().ok();
    farm.process.signal("TERM");
    let coordinator = farm.process.end().ok();

    for log in [&coordinator.stderr, &renderer.stderr] {
        for secret in [&admin, &client, &worker] {
            // Its public part may stand there.
            let secret = secret.rsplit('_').next().expect("secret part");
            assert!(!log.contains(secret), "{log}");
        }
        assert!(
            !log.contains("of-the-query") && !log.contains("_wrong"),
            "{log}"
        );
    }
    let (coordinator, renderer) = (lines(&coordinator.stderr), lines(&renderer.stderr));

    let counted = with_message(&coordinator, "result");
    let delivered = with_message(&renderer, "delivered");
    assert!(!delivered.is_empty());
    let job: i64 = id.parse().expect("number");
    for line in &delivered {
        let unit = unit(line);
        assert_eq!(unit[0], job);
        for (log, message) in [
            (&coordinator, "leased"),
            (&renderer, "leased"),
            (&renderer, "rendered"),
        ] {
            let there = with_message(log, message);
            assert!(
                there.iter().any(|line| self::unit(line) == unit),
                "{message}: {unit:?}"
            );
        }
        let result = counted.iter().find(|line| self::unit(line) == unit);
        let result = result.unwrap_or_else(|| panic!("{unit:?} is not in the coordinator's log"));
        assert!(text(&result["outcome"]).contains("Counted"), "{result}");
        assert!(field(result, "id").is_string(), "of no request: {result}");
    }

    let answered = with_message(&coordinator, "answered");
    let by_id = |id: &str| {
        let all = answered.iter();
        let mut of: Vec<_> = all.filter(|line| field(line, "id") == id).collect();
        assert_eq!(of.len(), 1, "{id}");
        of.remove(0)
    };
    for id in ["my-request.7", &replaced] {
        let line = by_id(id);
        assert_eq!(line["route"], "/v1/jobs/{id}");
        assert_eq!(
            (&line["method"], &line["status"]),
            (&"GET".into(), &200.into())
        );
        assert!(line["ms"].as_f64().is_some_and(|ms| ms > 0.0));
    }
    assert!(
        answered
            .iter()
            .any(|line| line["status"] == 401 && line["route"] == "/metrics")
    );
}

#[test]
fn logs_are_text_when_nobody_says_otherwise() {
    let farm = Guarded::start(tempfile::tempdir().expect("folder"), &[]);
    http::get(&farm.url, "/healthz");
    let log = farm.process.stderr();
    assert!(log.contains("coordinator listens"), "{log}");
    let first = log.lines().next().expect("a line");
    assert!(serde_json::from_str::<Value>(first).is_err(), "{first}");
    assert!(
        !log.contains("answered"),
        "requests are told to who asks: {log}"
    );
    farm.process.signal("TERM");
    farm.process.end().ok();
}

#[test]
fn the_format_may_come_from_the_environment() {
    let mut command = common::process::command(["worker", "--coordinator", "http://127.0.0.1:9"]);
    let worker = Process::start(command.env("SHEARWATER_LOG_FORMAT", "json"));
    common::until("it has said something", || {
        worker.stderr().contains("worker starts").then_some(())
    });
    worker.signal("TERM");
    lines(&worker.end().stderr);
}
