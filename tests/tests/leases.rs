//! Leases at scale, with real processes: pauses, priorities, workers that vanish or lie.

mod common;
mod liar;

use common::farm::{Farm, render, worker_for};
use common::{scene, until};
use liar::Liar;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// What `render` says on this machine, asked once.
fn right_answer() -> &'static str {
    static HASH: OnceLock<String> = OnceLock::new();
    HASH.get_or_init(|| {
        let folder = tempfile::tempdir().expect("temporary folder");
        render(&scene::write(folder.path()), &["--threads", "1"])
    })
}

fn units_done(farm: &Farm, id: &str) -> u64 {
    farm.job(id)["units_done"].as_u64().expect("units")
}

#[test]
fn a_paused_job_rests_and_goes_on_to_the_same_film() {
    let farm = Farm::start();
    let id = farm.submit(&[]);
    let _worker = farm.worker(1);
    farm.under_way(&id, 1);
    farm.client(&["pause", &id]).ok();
    // What was leased comes; then nothing more.
    let job = until("nothing is leased", || {
        let events = farm
            .client(&["log", &id, "--json", "--limit", "1000"])
            .ok()
            .json();
        let runs = |kind: &str| -> usize {
            let events = events["events"].as_array().expect("events").iter();
            let of_kind = events.filter(|event| event["kind"] == kind);
            of_kind
                .map(|e| e["runs"].as_array().map_or(0, Vec::len))
                .sum()
        };
        (runs("counted") == runs("leased")).then(|| farm.job(&id))
    });
    // All of it may have been leased by then: its frame ends.
    if job["done"] == false && job["units_done"] != job["units_total"] {
        assert_eq!(job["state"], "paused");
        std::thread::sleep(Duration::from_secs(3));
        let later = farm.job(&id);
        assert_eq!(later["units_done"], job["units_done"]);
        assert_eq!(later["elapsed_s"], job["elapsed_s"]);
    }
    let resumed = farm.client(&["resume", &id, "--json"]).ok().json();
    assert_ne!(resumed["state"], "paused");
    assert_eq!(farm.film_hash(&id), right_answer());
}

#[test]
fn jobs_of_equal_priority_share_and_a_raised_one_overtakes() {
    let farm = Farm::start();
    let more = ["--spp", "1024"];
    let ids = [farm.submit(&more), farm.submit(&more), farm.submit(&more)];
    let _worker = farm.worker(1);
    // Each gets something before any is done.
    until("all have begun", || {
        let jobs = ids.each_ref().map(|id| farm.job(id));
        assert!(
            jobs.iter().all(|job| job["done"] == false),
            "one was served alone"
        );
        jobs.iter()
            .all(|job| job["units_done"].as_u64() > Some(0))
            .then_some(())
    });
    let raised = farm.client(&["priority", &ids[2], "5", "--json"]).ok();
    assert_eq!(raised.json()["priority"], 5);
    until("the raised one is done", || {
        let job = farm.job(&ids[2]);
        (job["done"] == true).then_some(())
    });
    for id in &ids[..2] {
        let job = farm.job(id);
        assert_eq!(job["done"], false, "{job}");
        farm.client(&["cancel", id]).ok();
    }
    farm.client(&["priority", &ids[0], "1001"]).expect_code(2);
    farm.client(&["retry", &ids[0]]).expect_code(5);
}

#[test]
fn a_worker_that_stands_still_and_comes_back_changes_nothing() {
    let farm = Farm::start();
    let id = farm.submit(&[]);
    let mut late = farm.worker(1);
    farm.under_way(&id, 1);
    late.signal("STOP");
    let _other = farm.worker(1);
    assert_eq!(farm.film_hash(&id), right_answer());
    late.signal("CONT");
    // What it had in hand is counted already; it goes on with another job.
    let second = farm.submit(&["--seed", "9"]);
    farm.film_hash(&second);
    assert!(late.runs());
    let job = farm.job(&id);
    assert_eq!(job["film_hashes"][0], right_answer());
    assert_eq!(job["unequal_results"], 0);
    assert_eq!(job["units_done"], job["units_total"]);
}

#[test]
fn a_late_result_of_a_worker_that_stood_still_is_taken() {
    let farm = Farm::start();
    let id = farm.submit(&[]);
    let late = farm.worker(1);
    farm.under_way(&id, 1);
    late.signal("STOP");
    let before = units_done(&farm, &id);
    // Nobody else is there: its lease expires.
    until("its lease expires", || {
        let log = farm.client(&["log", &id]).ok().stdout;
        log.contains("expired").then_some(())
    });
    late.signal("CONT");
    until("it goes on", || {
        (units_done(&farm, &id) > before).then_some(())
    });
    assert_eq!(farm.film_hash(&id), right_answer());
}

#[test]
fn a_worker_that_drains_ends_in_time_and_leaves_nothing_behind() {
    let farm = Farm::start();
    let id = farm.submit(&["--spp", "4096"]);
    let leaving = farm.worker(2);
    farm.under_way(&id, 1);
    let told = Instant::now();
    leaving.signal("TERM");
    leaving.end().ok();
    assert!(
        told.elapsed() < Duration::from_secs(20),
        "{:?}",
        told.elapsed()
    );
    let log = farm.client(&["log", &id, "--limit", "1000"]).ok().stdout;
    assert!(
        log.contains("released"),
        "handed back, not left to expire:\n{log}"
    );
    farm.client(&["cancel", &id]).ok();
}

#[test]
fn a_lying_worker_is_found_and_the_film_is_right() {
    let farm = Farm::start_args(&["--audit", "1"]);
    let liar = Liar::start(&farm.url);
    let id = farm.submit(&["--spp", "1024"]);
    let wrong = worker_for(liar.url(), 1);
    farm.under_way(&id, 1);
    let _honest = [farm.worker(1), farm.worker(1)];
    let job = farm.client(&["watch", &id, "--json"]).ok().json();
    let folder = tempfile::tempdir().expect("temporary folder");
    let alone = render(&scene::write(folder.path()), &["--spp", "1024"]);
    assert_eq!(job["film_hashes"][0], *alone);
    assert_eq!(job["units_done"], job["units_total"]);
    assert!(job["audits"]["unequal"].as_u64() >= Some(1), "{job}");
    assert!(liar.lies() > 0);
    let workers = farm.client(&["workers", "--json"]).ok().json();
    let workers = workers["workers"].as_array().expect("workers").iter();
    let away: Vec<_> = workers
        .filter(|worker| !worker["quarantined_s"].is_null())
        .collect();
    assert_eq!(away.len(), 1, "{away:?}");
    assert!(
        away[0]["quarantine_reason"]
            .as_str()
            .expect("text")
            .contains("differ")
    );
    drop(wrong);
}
