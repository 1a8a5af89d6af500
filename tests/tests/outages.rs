//! A database or an object store that is away: work pauses, says why, and goes on
//! by itself; what was acknowledged is there.

mod common;

use common::disk::SmallDisk;
use common::farm::{Farm, right_answer};
use common::relay::Relay;
use common::stores::{Pair, Places, left_out, new_database, new_prefix};
use common::stores::{postgres_address, s3_address};
use common::{http, until};
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

/// How long the short outages last: longer than it takes to notice them, and than a
/// heartbeat.
const OUTAGE: Duration = Duration::from_secs(5);

#[test]
fn the_database_server_is_gone() {
    database_server("the database server is gone", Relay::cut);
}

#[test]
fn the_database_server_falls_silent() {
    database_server("the database server falls silent", Relay::fall_silent);
}

fn database_server(test: &str, fails: fn(&Relay)) {
    if !Pair::Servers.there(test) {
        return;
    }
    let line = Relay::to(postgres_address());
    let database = new_database();
    let place = postgres_address().to_string();
    let places = Places::servers(
        &database.replace(&place, &line.addr.to_string()),
        &new_prefix(),
    );
    let farm = Farm::start_with(places);
    goes_on_after(&farm, "database", || fails(&line), || line.mend());
}

#[test]
fn the_object_store_is_gone() {
    object_store("the object store is gone", Relay::cut);
}

#[test]
fn the_object_store_falls_silent() {
    object_store("the object store falls silent", Relay::fall_silent);
}

fn object_store(test: &str, fails: fn(&Relay)) {
    if !Pair::Servers.there(test) {
        return;
    }
    let line = Relay::to(s3_address());
    let mut places = Places::servers(&new_database(), &new_prefix());
    let url = format!("http://{}", line.addr);
    places.envs.push(("AWS_ENDPOINT_URL".into(), url));
    let farm = Farm::start_with(places);
    goes_on_after(&farm, "object store", || fails(&line), || line.mend());
}

#[test]
fn another_process_holds_the_database_file() {
    let farm = Farm::start_on(Pair::Laptop);
    let file = farm.folder().join("data/farm.db");
    let mut holder = None;
    goes_on_after(&farm, "database", || holder = Some(hold(&file)), || {});
    drop(holder);
}

/// A process that holds SQLite's write lock, longer than a try at writing waits.
fn hold(file: &Path) -> Child {
    const PROGRAM: &str = "import sqlite3, sys, time\n\
        c = sqlite3.connect(sys.argv[1], isolation_level=None, timeout=30)\n\
        c.execute('BEGIN IMMEDIATE')\n\
        time.sleep(16)\n";
    let held = Command::new("python3")
        .args(["-c", PROGRAM])
        .arg(file)
        .spawn();
    held.expect("python3")
}

#[test]
fn the_disk_is_full() {
    let Some(disk) = SmallDisk::mount(32) else {
        left_out("the disk is full", "only root can mount a small disk");
        return;
    };
    let farm = Farm::start_with(Places::folder(&disk.path().join("data")));
    goes_on_after(&farm, "fails", || disk.fill(), || disk.free());
}

/// A job under way, an outage, and the right film all the same.
fn goes_on_after(farm: &Farm, said: &str, fail: impl FnOnce(), mend: impl FnOnce()) {
    assert_eq!(http::get(&farm.url, "/readyz").0, 200);
    let id = farm.submit(&[]);
    let mut worker = farm.worker(1);
    farm.under_way(&id, 2);
    let counted = farm.job(&id)["units_done"].as_u64();
    fail();
    let why = until("the coordinator says that it is not ready", || {
        let (status, body) = http::get(&farm.url, "/readyz");
        (status == 503 && body.contains(said)).then_some(body)
    });
    assert!(!why.contains("farm-secret"), "{why}");
    let (status, body) = http::get(&farm.url, &format!("/v1/jobs/{id}"));
    match status {
        200 => assert!(body.contains("paused: "), "{body}"),
        503 => assert!(body.contains("database"), "{body}"),
        other => panic!("{other}: {body}"),
    }
    std::thread::sleep(OUTAGE);
    assert!(worker.runs(), "the worker waits");
    mend();
    until("the coordinator is ready again", || {
        (http::get(&farm.url, "/readyz").0 == 200).then_some(())
    });
    assert!(
        farm.job(&id)["units_done"].as_u64() >= counted,
        "nothing is lost"
    );
    assert_eq!(farm.film_hash(&id), right_answer());
    let job = farm.job(&id);
    assert_eq!(
        (&job["state"], &job["note"]),
        (&"done".into(), &serde_json::Value::Null)
    );
}
