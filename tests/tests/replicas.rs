//! Several coordinators on one store: any of them answers anything, and one that
//! is killed is missed by nobody.

mod common;

use common::farm::{Farm, film_hash_of, render, right_answer, worker_for};
use common::process::{Process, command, run};
use common::scene;
use common::stores::{Pair, on_both_pairs};

on_both_pairs! {
    one_of_two_is_killed;
    an_error_stop_on_two;
    deleted_at_one_gone_at_the_other;
}

fn one_of_two_is_killed(pair: Pair) {
    let mut farm = Farm::start_on(pair);
    let other = farm.replica();
    let id = farm.submit(&[]);
    // A client that follows the events of the one that stays.
    let watcher = Process::start(&mut command([
        "watch",
        &id,
        "--json",
        "--coordinator",
        &other.url,
    ]));
    let _workers = [farm.worker(1), worker_for(&other.url, 1)];
    farm.under_way(&id, 3);
    farm.kill_coordinator();
    let job = watcher.end().ok().json();
    assert_eq!(job["units_done"], job["units_total"]);
    assert_eq!(film_hash_of(&job), right_answer());
    assert_eq!(job["unequal_results"], 0);

    let out = tempfile::tempdir().expect("temporary folder");
    let folder = out.path().to_str().expect("UTF-8");
    run(["download", &id, "-o", folder, "--coordinator", &other.url]).ok();
    let files = std::fs::read_dir(out.path()).expect("folder").count();
    assert_eq!(files, 2, "PNG and EXR from the other one");

    farm.restart_coordinator();
    assert_eq!(film_hash_of(&farm.job(&id)), right_answer());
}

fn an_error_stop_on_two(pair: Pair) {
    const RULE: [&str; 4] = ["--error", "0.0005", "--spp", "512"];
    let folder = tempfile::tempdir().expect("temporary folder");
    let alone = render(&scene::write(folder.path()), &RULE);
    let farm = Farm::start_on(pair);
    let other = farm.replica();
    let id = farm.submit(&RULE);
    let _workers = [farm.worker(1), worker_for(&other.url, 1)];
    assert_eq!(farm.film_hash(&id), alone);
    let job = farm.job(&id);
    let (least, most) = (job["samples_min"].as_u64(), job["samples_max"].as_u64());
    assert!(least < most, "{job}");
}

fn deleted_at_one_gone_at_the_other(pair: Pair) {
    let farm = Farm::start_on(pair);
    let other = farm.replica();
    let id = farm.submit(&["--spp", "16"]);
    let _worker = worker_for(&other.url, 1);
    farm.film_hash(&id);
    farm.delete(&id);
    let status = run(["status", &id, "--json", "--coordinator", &other.url]);
    assert_ne!(status.code, Some(0), "{}", status.stdout);
}
