//! Stop rules and added samples, with real processes.

mod common;

use common::farm::{Farm, hash_of, render};
use common::scene;

#[test]
fn an_error_stop_is_one_film_for_one_worker_and_for_three_of_which_one_dies() {
    const RULE: [&str; 4] = ["--error", "0.0005", "--spp", "512"];
    let folder = tempfile::tempdir().expect("temporary folder");
    let alone = render(&scene::write(folder.path()), &RULE);
    let farm = Farm::start();
    let id = farm.submit(&RULE);
    let doomed = farm.worker(1);
    farm.under_way(&id, 9); // The first pass has 8 units.
    doomed.kill();
    let _heirs = [farm.worker(1), farm.worker(1)];
    assert_eq!(farm.film_hash(&id), alone);
    let job = farm.job(&id);
    assert!(
        job["samples_min"].as_u64() < job["samples_max"].as_u64(),
        "{job}"
    );
}

#[test]
fn half_the_samples_and_the_other_half_are_the_film_of_all() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let whole = render(&scene::write(folder.path()), &["--spp", "256"]);
    let farm = Farm::start();
    let _worker = farm.worker(2);
    for first in ["128", "100"] {
        let id = farm.submit(&["--spp", first]);
        assert_ne!(farm.film_hash(&id), whole);
        let more = farm.client(&["add", &id, "--spp", "256", "--json"]).ok();
        assert_eq!(more.json()["done"], false);
        assert_eq!(farm.film_hash(&id), whole);
    }
}

#[test]
fn a_time_stop_ends_and_goes_on_to_the_whole_film() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let whole = render(&scene::write(folder.path()), &["--spp", "256"]);
    let farm = Farm::start();
    let _worker = farm.worker(1);
    let id = farm.submit(&["--spp", "4096", "--seconds", "1"]);
    hash_of(&farm.client(&["watch", &id, "--json"]).ok().json()["film_hashes"][0]);
    assert_eq!(farm.job(&id)["stopped_by"], "seconds");
    let id = farm.submit(&["--spp", "256", "--seconds", "1"]);
    farm.film_hash(&id);
    farm.client(&["add", &id, "--spp", "256", "--json"]).ok();
    assert_eq!(farm.film_hash(&id), whole);
}
