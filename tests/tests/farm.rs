//! One right answer: the film has the same hash however the farm got there.

mod common;
mod meddler;

use common::farm::{Farm, render, render_as, right_answer, worker_for};
use common::stores::{Pair, on_both_pairs};
use common::{scene, until};
use meddler::Meddler;

on_both_pairs! {
    one_worker_of_two_threads;
    three_workers;
    a_worker_killed_in_its_lease;
    a_worker_told_to_end_hands_its_runs_back;
    a_coordinator_killed_twice;
    results_twice_and_shuffled;
}

#[test]
fn render_with_two_threads() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = scene::write(folder.path());
    assert_eq!(render(&scene, &["--threads", "2"]), right_answer());
}

#[test]
fn render_without_avx2() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = scene::write(folder.path());
    let (hash, log) = render_as(&scene, &[], "portable");
    assert!(log.contains("portable_simd=true"), "{log}");
    assert_eq!(hash, right_answer());
}

#[test]
fn another_seed_sample_count_or_scene_is_another_film() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = scene::write(folder.path());
    let quick = ["--spp", "8", "--seed"];
    let hash = |seed: &str| render(&path, &[&quick[..], &[seed]].concat());
    let first = hash("1");
    assert_eq!(hash("1"), first);
    assert_ne!(hash("2"), first);
    assert_ne!(render(&path, &["--spp", "16", "--seed", "1"]), first);
    scene::edit(&path, "\"radiance\": [0.4,", "\"radiance\": [0.5,");
    assert_ne!(hash("1"), first);
}

#[test]
fn one_worker_of_one_thread() {
    let farm = Farm::start();
    let id = farm.submit(&[]);
    let _worker = farm.worker(1);
    assert_eq!(farm.film_hash(&id), right_answer());
}

fn one_worker_of_two_threads(pair: Pair) {
    let farm = Farm::start_on(pair);
    let _worker = farm.worker(2);
    let id = farm.submit(&[]);
    assert_eq!(farm.film_hash(&id), right_answer());
}

fn three_workers(pair: Pair) {
    let farm = Farm::start_on(pair);
    let _workers = [farm.worker(1), farm.worker(2), farm.worker(1)];
    let id = farm.submit(&[]);
    assert_eq!(farm.film_hash(&id), right_answer());
}

fn a_worker_killed_in_its_lease(pair: Pair) {
    let farm = Farm::start_on(pair);
    let id = farm.submit(&[]);
    let doomed = farm.worker(1);
    farm.under_way(&id, 1);
    doomed.kill();
    let before = farm.job(&id);
    assert_eq!(before["done"], false);
    let _heir = farm.worker(1);
    assert_eq!(farm.film_hash(&id), right_answer());
}

fn a_worker_told_to_end_hands_its_runs_back(pair: Pair) {
    let farm = Farm::start_on(pair);
    let id = farm.submit(&[]);
    let leaving = farm.worker(1);
    farm.under_way(&id, 1);
    leaving.signal("TERM");
    leaving.end().ok();
    let _heir = farm.worker(1);
    assert_eq!(farm.film_hash(&id), right_answer());
}

fn a_coordinator_killed_twice(pair: Pair) {
    let mut farm = Farm::start_on(pair);
    let id = farm.submit(&[]);
    let mut worker = farm.worker(1);
    for units in [1, 8] {
        farm.under_way(&id, units);
        farm.kill_coordinator();
        std::thread::sleep(std::time::Duration::from_millis(300));
        farm.restart_coordinator();
        let kept = farm.job(&id)["units_done"].as_u64();
        assert!(kept >= Some(units), "{kept:?} of {units} units kept");
    }
    assert_eq!(farm.film_hash(&id), right_answer());
    assert!(worker.runs(), "the worker survives its coordinator");
}

fn results_twice_and_shuffled(pair: Pair) {
    let farm = Farm::start_on(pair);
    let meddler = Meddler::start(&farm.url);
    let id = farm.submit(&[]);
    let _worker = worker_for(meddler.url(), 2);
    assert_eq!(farm.film_hash(&id), right_answer());
    until("every result", || {
        let seen = meddler.seen();
        (seen.results > 0 && seen.duplicates >= seen.results).then_some(())
    });
    assert!(meddler.seen().shuffled > 0, "{:?}", meddler.seen());
    // Late, after the end, again, in another order; and one with another bit.
    meddler.send_all_again();
    meddler.send_one_altered();
    let job = farm.job(&id);
    assert_eq!(job["film_hashes"][0], right_answer());
    assert_eq!(job["state"], "done");
    assert!(job["unequal_results"].as_u64() >= Some(1), "{job}");
}
