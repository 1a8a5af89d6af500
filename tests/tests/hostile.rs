//! Hostile scenes and files fail their job only: the same coordinator and the same
//! worker render what comes next.

mod bombs;
mod common;
mod guarded;
mod slow;

use common::{scene, until};
use guarded::Guarded;
use shearwater_shared::hash::ContentHash;
use std::path::{Path, PathBuf};

/// Most memory that a worker may have taken after all bombs, in KiB.
const PEAK_KIB_MAX: u64 = 700 << 10;

/// What a scene of its own is changed to.
type Change = fn(&Path);

fn texture(folder: &Path, name: &str, bytes: &[u8]) {
    std::fs::write(folder.join("models").join(name), bytes).expect("texture");
    let paint = format!("newmtl paint\nKd 1 1 1\nmap_Kd {name}\n");
    std::fs::write(folder.join("models/cube.mtl"), paint).expect("mtl");
    let cube = folder.join("models/cube.obj");
    let text = std::fs::read_to_string(&cube).expect("cube");
    std::fs::write(&cube, text.replace("usemtl paint", "vt 0 0\nusemtl paint")).expect("cube");
    for face in [
        "1 4 3 2", "5 6 7 8", "1 2 6 5", "3 4 8 7", "2 3 7 6", "1 5 8 4",
    ] {
        let textured: Vec<_> = face.split(' ').map(|v| format!("{v}/1")).collect();
        scene::edit(
            &cube,
            &format!("f {face}"),
            &format!("f {}", textured.join(" ")),
        );
    }
}

fn obj(folder: &Path, text: &str) {
    std::fs::write(folder.join("models/cube.obj"), text).expect("obj");
}

const BOMBS: [(&str, Change); 7] = [
    ("a PNG of 1.6 GB", |folder| {
        texture(folder, "p.png", &bombs::png(20_000));
    }),
    ("a PNG cut short", |folder| {
        let png = bombs::png(64);
        texture(folder, "p.png", &png[..png.len() / 2]);
    }),
    ("an EXR of 2^60 pixels", |folder| {
        texture(folder, "p.exr", &bombs::exr());
    }),
    ("gzip that calls itself PNG", |folder| {
        let mut gzip = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3];
        gzip.resize(1 << 16, 0x55);
        texture(folder, "p.png", &gzip);
    }),
    ("a vertex of a huge number", |folder| {
        obj(
            folder,
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n",
        );
    }),
    ("a face of a million corners at one place", |folder| {
        let corners = " 1".repeat(1_000_000);
        obj(folder, &format!("v 0 0 0\nf{corners}\nf 1 2 3\n"));
    }),
    ("numbers that are none", |folder| {
        obj(folder, "v nan inf 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n");
    }),
];

#[test]
fn bombs_fail_their_job_and_nothing_else() {
    let mut farm = Guarded::start(tempfile::tempdir().expect("temporary folder"), &[]);
    let mut worker = farm.worker("", &[]);
    for (number, (what, change)) in BOMBS.iter().enumerate() {
        let folder = farm.folder.path().join(format!("bomb{number}"));
        let path = scene::write(&folder);
        change(&folder);
        let path = path.to_str().expect("UTF-8");
        let submitted = farm.client(
            "",
            &["submit", path, "--json", "--size", "64x64", "--spp", "8"],
        );
        // Some are seen by the client itself; then nobody else has to.
        if submitted.code == Some(3) {
            continue;
        }
        let id = submitted.ok().json()["id"].to_string();
        let job = farm.state_at_end("", &id, &[]);
        assert_eq!(job["state"], "failed", "{what}: {job}");
        assert_eq!(job["failure_kind"], "scene", "{what}: {job}");
        assert!(worker.runs() && farm.process.runs(), "{what}");
    }
    let id = farm.submit("", &[]);
    let job = farm.state_at_end("", &id, &[]);
    assert_eq!(job["state"], "done", "{job}");
    let peak = peak_kib(&worker);
    assert!(peak < PEAK_KIB_MAX, "the worker took {} MiB", peak >> 10);
}

fn peak_kib(process: &common::process::Process) -> u64 {
    let status = PathBuf::from(format!("/proc/{}/status", process.id()));
    let status = std::fs::read_to_string(status).expect("status");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
    kib.expect("peak memory")
}

#[test]
fn bodies_that_are_deep_or_packed_are_refused() {
    let mut farm = Guarded::start(tempfile::tempdir().expect("temporary folder"), &[]);
    let address = farm.address().to_owned();
    let send = |method: &str, path: &str, more: &str, body: &[u8]| {
        let head = format!(
            "{method} {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n{more}\
             content-length: {}\r\n\r\n",
            body.len()
        );
        slow::ask(&address, &[head.as_bytes(), body].concat())
    };
    let json = "content-type: application/json\r\n";
    let deep = "[".repeat(900_000);
    let answer = send("POST", "/v1/jobs", json, deep.as_bytes());
    assert!(answer.starts_with("HTTP/1.1 400"), "{answer}");
    let packed = send(
        "POST",
        "/v1/jobs",
        &format!("{json}content-encoding: gzip\r\n"),
        b"\x1f\x8b",
    );
    assert!(packed.starts_with("HTTP/1.1 415"), "{packed}");
    assert!(packed.contains("problem:content-encoding"), "{packed}");
    // Scenes are parsed by the coordinator: one that is deep all the way down.
    for scene in [
        "[".repeat(30 << 20),
        format!("{{\"version\":1,\"camera\":{}", "{\"a\":".repeat(1 << 20)),
    ] {
        let hash = ContentHash::of(scene.as_bytes());
        let stored = send("PUT", &format!("/v1/assets/{hash}"), "", scene.as_bytes());
        assert!(stored.starts_with("HTTP/1.1 201"), "{stored}");
        let body = format!("{{\"manifest\":{{\"scene\":\"{hash}\",\"files\":{{}}}}}}");
        let refused = send("POST", "/v1/jobs", json, body.as_bytes());
        assert!(refused.starts_with("HTTP/1.1 422"), "{refused}");
    }
    let long_head = send(
        "GET",
        "/healthz",
        &format!("x: {}\r\n", "y".repeat(1 << 20)),
        b"",
    );
    assert!(!long_head.starts_with("HTTP/1.1 200"), "{long_head}");
    let many = "x: y\r\n".repeat(1_000);
    let many_heads = send("GET", "/healthz", &many, b"");
    assert!(!many_heads.starts_with("HTTP/1.1 200"), "{many_heads}");
    assert!(farm.process.runs());
    let healthy = send("GET", "/healthz", "", b"");
    assert!(healthy.starts_with("HTTP/1.1 200"), "{healthy}");
    until("it is ready", || {
        send("GET", "/readyz", "", b"")
            .starts_with("HTTP/1.1 200")
            .then_some(())
    });
}
