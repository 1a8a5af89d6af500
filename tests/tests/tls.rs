//! TLS with given certificates, and certificates of workers; real processes.

mod authority;
mod common;
mod guarded;

use authority::{Authority, Files, Use};
use common::process::{Process, command};
use common::until;
use guarded::{Guarded, folder_with_tokens};
use std::path::Path;
use std::time::{Duration, Instant};

fn serve(folder: tempfile::TempDir, server: &Files, more: &[&str]) -> Guarded {
    let tls = ["--tls-cert", &server.certificate, "--tls-key", &server.key];
    Guarded::start(folder, &[&tls, more].concat())
}

/// Two authorities in folders of their own.
fn authorities(folder: &Path) -> [Authority; 2] {
    ["farm", "stranger"].map(|name| Authority::new(&folder.join(name)))
}

#[test]
fn clients_trust_the_authority_that_they_are_given() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let [farm, stranger] = authorities(folder.path());
    let (ca, foreign) = (farm.file(), stranger.file());
    let served = serve(folder, &farm.sign("server", Use::Server), &[]);
    assert!(served.url.starts_with("https://"), "{}", served.url);
    served.client("", &["jobs", "--ca", &ca]).ok();
    // Another authority, none that the system knows, and no TLS at all.
    for more in [&["--ca", foreign.as_str()][..], &[]] {
        let refused = served
            .client("", &[&["jobs"], more].concat())
            .expect_code(4);
        assert!(refused.stderr.contains("certificate"), "{}", refused.stderr);
    }
    let plain = served.url.replace("https", "http");
    common::process::run(["jobs", "--coordinator", &plain]).expect_code(4);
    let useless = ["jobs", "--coordinator", &plain, "--ca", &ca];
    let refused = common::process::run(useless).expect_code(4);
    assert!(refused.stderr.contains("https://"), "{}", refused.stderr);

    let id = served.submit("", &["--ca", &ca]);
    let mut stranger = served.worker("", &["--ca", &foreign]);
    until("a warning about the certificate", || {
        stranger.stderr().contains("certificate").then_some(())
    });
    assert!(stranger.runs(), "it may be right again later");
    let _worker = served.worker("", &["--ca", &ca]);
    let job = served.state_at_end("", &id, &["--ca", &ca]);
    assert_eq!(job["state"], "done", "{job}");
}

#[test]
fn certificates_expire_and_are_renewed_without_a_restart() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let [farm, _] = authorities(folder.path());
    let ca = farm.file();
    let files = farm.sign("server", Use::ExpiredServer);
    let served = serve(folder, &files, &[]);
    let refused = served.client("", &["jobs", "--ca", &ca]).expect_code(4);
    assert!(refused.stderr.contains("expired"), "{}", refused.stderr);
    // What cannot be read changes nothing and ends nothing.
    std::fs::write(&files.certificate, "nonsense").expect("file");
    served.process.signal("HUP");
    until("a complaint", || {
        served
            .process
            .stderr()
            .contains("stay as they were")
            .then_some(())
    });
    farm.sign("server", Use::Server);
    served.process.signal("HUP");
    until("the new certificate", || {
        (served.client("", &["jobs", "--ca", &ca]).code == Some(0)).then_some(())
    });
}

#[test]
fn wrong_files_are_named_before_anything_runs() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let [farm, other] = authorities(folder.path());
    let (server, client) = (
        farm.sign("server", Use::Server),
        other.sign("x", Use::Client),
    );
    let start = |certificate: &str, key: &str| {
        let mut command = command(["coordinator", "--listen", "127.0.0.1:0", "--data"]);
        command.arg(folder.path().join("data"));
        command.args(["--tls-cert", certificate, "--tls-key", key]);
        Process::start(&mut command).end().expect_code(1).stderr
    };
    assert!(start("/nowhere", &server.key).contains("/nowhere"));
    assert!(start(&server.key, &server.key).contains("no certificate"));
    assert!(start(&server.certificate, &server.certificate).contains("no private key"));
    assert!(start(&server.certificate, &client.key).contains("cannot be used"));
    let mut lone = command(["coordinator", "--tls-cert", &server.certificate]);
    Process::start(&mut lone).end().expect_code(2);
}

#[test]
fn workers_need_a_certificate_of_their_authority_and_clients_do_not() {
    let (folder, [_, client, worker]) = folder_with_tokens();
    let [farm, stranger] = authorities(folder.path());
    let ca = farm.file();
    let [right, expired] = [("right", Use::Client), ("expired", Use::ExpiredClient)]
        .map(|(name, what)| farm.sign(name, what));
    let foreign = stranger.sign("foreign", Use::Client);
    let served = serve(
        folder,
        &farm.sign("server", Use::Server),
        &["--tls-worker-ca", &ca],
    );
    let start = |files: &Files| {
        let options = [
            "--ca",
            &ca,
            "--client-cert",
            &files.certificate,
            "--client-key",
            &files.key,
        ];
        served.worker(&worker, &options)
    };
    let id = served.submit(&client, &["--ca", &ca]);
    // None: said aloud, and the worker ends. A token alone does not do.
    let refused = served.worker(&worker, &["--ca", &ca]).end().expect_code(5);
    assert!(
        refused.stderr.contains("--client-cert"),
        "{}",
        refused.stderr
    );
    // A wrong one: no connection at all; tried again for ever, and nothing is done.
    for files in [&foreign, &expired] {
        let mut wrong = start(files);
        until("a refusal", || {
            let log = wrong.stderr().to_ascii_lowercase();
            assert!(wrong.runs(), "{log}");
            ["unknownca", "certificateexpired", "unknown_ca", "alert"]
                .iter()
                .any(|word| log.contains(word))
                .then_some(())
        });
        let job = served
            .client(&client, &["status", &id, "--json", "--ca", &ca])
            .ok()
            .json();
        assert_eq!(job["units_done"], 0, "{job}");
    }
    // A right certificate does not replace the token.
    let options = [
        "--ca",
        &ca,
        "--client-cert",
        &right.certificate,
        "--client-key",
        &right.key,
    ];
    served.worker(&client, &options).end().expect_code(5);
    let _worker = start(&right);
    let job = served.state_at_end(&client, &id, &["--ca", &ca]);
    assert_eq!(job["state"], "done", "{job}");
}

#[test]
fn who_begins_no_handshake_is_cut() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let [farm, _] = authorities(folder.path());
    let served = serve(folder, &farm.sign("server", Use::Server), &[]);
    let began = Instant::now();
    let mut stream = std::net::TcpStream::connect(served.address()).expect("connect");
    stream
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("option");
    let end = std::io::Read::read(&mut stream, &mut [0; 1]);
    assert!(matches!(end, Ok(0) | Err(_)), "{end:?}");
    let seconds = began.elapsed().as_secs();
    assert!((9..20).contains(&seconds), "{seconds} s");
}
