//! `/metrics`: Prometheus' own checker, a farm whose numbers are known, stores that are
//! away, and whatever clients invent.

mod common;
mod guarded;
mod scrape;

use common::farm::Farm;
use common::relay::Relay;
use common::stores::{Pair, Places, new_database, new_prefix, on_both_pairs};
use common::stores::{postgres_address, s3_address};
use common::{http, until};
use guarded::{Guarded, folder_with_tokens};
use scrape::Scrape;
use std::time::Duration;

on_both_pairs! {
    a_job_is_told_from_its_beginning_to_its_end;
}

fn a_job_is_told_from_its_beginning_to_its_end(pair: Pair) {
    let farm = Farm::start_on(pair);
    let before = Scrape::of(&farm.url);
    before.is_clean();
    for state in ["queued", "running", "paused", "done", "cancelled", "failed"] {
        let name = format!("shearwater_jobs{{state=\"{state}\"}}");
        assert_eq!(before.value(&name), 0.0, "{name}");
    }
    assert_eq!(before.value("shearwater_workers{state=\"present\"}"), 0.0);
    assert_eq!(before.value("shearwater_samples_total"), 0.0);

    let id = farm.submit(&[]);
    let units = farm.job(&id)["units_total"].as_f64().expect("units");
    until("the job is counted", || {
        let now = Scrape::of(&farm.url);
        // A census may be a second old.
        (now.sum("shearwater_jobs") == 1.0).then(|| {
            assert_eq!(now.value("shearwater_units{state=\"pending\"}"), units);
        })
    });
    let workers = [farm.worker(1), farm.worker(2)];
    until("both workers are seen at work", || {
        let now = Scrape::of(&farm.url);
        let leased = now.value("shearwater_units{state=\"leased\"}");
        if now.value("shearwater_jobs{state=\"running\"}") == 1.0 {
            assert_eq!(now.sum("shearwater_units"), units, "{}", now.text);
        }
        now.is_clean();
        let both = now.value("shearwater_workers{state=\"present\"}") == 2.0;
        (both && leased > 0.0 && now.value("shearwater_worker_threads") == 3.0).then_some(())
    });
    farm.film_hash(&id);
    let job = farm.job(&id);
    // A census may be a second old.
    let after = until("the end is counted", || {
        let now = Scrape::of(&farm.url);
        (now.value("shearwater_jobs{state=\"done\"}") == 1.0).then_some(now)
    });
    after.is_clean();
    for (name, field) in [
        ("shearwater_units_counted_total", "units_done"),
        ("shearwater_samples_total", "samples_done"),
        ("shearwater_bad_samples_total", "bad_samples"),
        ("shearwater_frames_finished_total", "frames_done"),
    ] {
        assert_eq!(Some(after.value(name)), job[field].as_f64(), "{name}");
    }
    let core_s = job["core_s"].as_f64().expect("core seconds");
    let told_s = after.value("shearwater_render_core_seconds_total");
    assert!((told_s - core_s).abs() < 0.01, "{told_s} s, {core_s} s");
    assert_eq!(after.sum("shearwater_units"), 0.0, "of live jobs");
    let results = after.sum("shearwater_results_total");
    let counted = after.value("shearwater_results_total{outcome=\"counted\"}");
    assert!(counted > 0.0 && counted <= units);
    assert_eq!(
        results,
        after.value("shearwater_result_handling_seconds_count")
    );
    let commits = "shearwater_database_transaction_seconds_count{transaction=\"commit\"}";
    let commits = after.value(commits);
    assert!(commits >= 1.0, "results that come together share one");
    assert!(after.value("shearwater_result_received_bytes_total") > 1000.0 * counted);
    let granted = after.sum("shearwater_leases_granted_total");
    assert_eq!(granted, after.value("shearwater_lease_wait_seconds_count"));
    assert!(after.value("shearwater_leases_granted_total{kind=\"fresh\"}") >= 2.0);
    let puts = "shearwater_object_operation_seconds_count{operation=\"put\"}";
    assert!(after.value(puts) > counted, "parts and films");
    assert!(after.value("shearwater_fold_seconds_count") >= 8.0, "tiles");
    let posted = "shearwater_http_requests_total{method=\"POST\",\
                  route=\"/v1/worker/results\",status=\"2xx\"}";
    assert!(after.value(posted) >= counted);
    assert!(after.value("process_resident_memory_bytes") > 1e6);
    assert!(after.value("process_cpu_seconds_total") > before.value("process_cpu_seconds_total"));
    assert_eq!(
        after.value("shearwater_store_trouble{store=\"database\"}"),
        0.0
    );
    drop(workers);
}

#[test]
fn openmetrics_is_given_to_who_asks() {
    let farm = Farm::start();
    let openmetrics = http::ask(
        &farm.url,
        "GET",
        "/metrics",
        &[("accept", "application/openmetrics-text; version=1.0.0")],
    );
    let media_type = openmetrics.header("content-type").expect("type");
    assert!(media_type.starts_with("application/openmetrics-text"));
    assert!(openmetrics.body.ends_with("# EOF\n"));
    let plain = http::ask(&farm.url, "GET", "/metrics", &[]);
    let media_type = plain.header("content-type").expect("type");
    assert!(media_type.starts_with("text/plain; version=0.0.4"));
    let names = |text: &str| -> std::collections::BTreeSet<String> {
        let lines = text.lines().filter(|line| line.starts_with("shearwater_"));
        lines
            .map(|line| line.rsplit_once(' ').expect("value").0.to_owned())
            .filter(|name| !name.contains("http_request"))
            .collect()
    };
    assert_eq!(names(&openmetrics.body), names(&plain.body));
}

#[test]
fn a_database_that_is_away_is_told_as_trouble() {
    if !Pair::Servers.there("a database that is away is told as trouble") {
        return;
    }
    let line = Relay::to(postgres_address());
    let place = postgres_address().to_string();
    let database = new_database().replace(&place, &line.addr.to_string());
    let farm = Farm::start_with(Places::servers(&database, &new_prefix()));
    told_as_trouble(&farm, "database", || line.cut(), || line.mend());
}

#[test]
fn an_object_store_that_is_away_is_told_as_trouble() {
    if !Pair::Servers.there("an object store that is away is told as trouble") {
        return;
    }
    let line = Relay::to(s3_address());
    let mut places = Places::servers(&new_database(), &new_prefix());
    let url = format!("http://{}", line.addr);
    places.envs.push(("AWS_ENDPOINT_URL".into(), url));
    let farm = Farm::start_with(places);
    told_as_trouble(&farm, "objects", || line.cut(), || line.mend());
}

fn told_as_trouble(farm: &Farm, store: &str, fails: impl FnOnce(), mends: impl FnOnce()) {
    let name = format!("shearwater_store_trouble{{store=\"{store}\"}}");
    assert_eq!(Scrape::of(&farm.url).value(&name), 0.0);
    fails();
    let broken = until("the trouble is told", || {
        let now = Scrape::of(&farm.url);
        (now.value(&name) == 1.0).then_some(now)
    });
    broken.is_clean();
    if store == "database" {
        // No old number passes for one of now.
        until("the farm is not known", || {
            let now = Scrape::of(&farm.url);
            let jobs = now.get("shearwater_jobs{state=\"queued\"}");
            (now.value("shearwater_farm_known") == 0.0 && jobs.is_none()).then_some(())
        });
    }
    mends();
    until("the trouble ends", || {
        let now = Scrape::of(&farm.url);
        let over = now.value(&name) == 0.0 && now.value("shearwater_farm_known") == 1.0;
        over.then_some(())
    });
}

#[test]
fn what_clients_invent_makes_no_series() {
    let farm = Farm::start();
    let ask_all = || {
        for number in 0..40 {
            http::send(&farm.url, "GET", &format!("/v1/jobs/{number}"));
            http::send(&farm.url, "GET", &format!("/invented/{number}"));
            http::send(&farm.url, &format!("BREW{number}"), "/v1/jobs");
            let id = format!("invented-{number}");
            http::ask(&farm.url, "GET", "/healthz", &[("x-request-id", &id)]);
        }
    };
    ask_all();
    let once = Scrape::of(&farm.url);
    ask_all();
    let twice = Scrape::of(&farm.url);
    let names = |scrape: &Scrape| scrape.names("").len();
    // The first scrape itself is a route that the second knows.
    let scrape_itself = twice
        .names("")
        .iter()
        .filter(|name| name.contains("\"/metrics\""))
        .count();
    assert_eq!(names(&once), names(&twice) - scrape_itself);
    let unmatched =
        "shearwater_http_requests_total{method=\"GET\",route=\"unmatched\",status=\"4xx\"}";
    assert_eq!(twice.value(unmatched), 80.0);
    let strange =
        "shearwater_http_requests_total{method=\"other\",route=\"/v1/jobs\",status=\"4xx\"}";
    assert_eq!(twice.value(strange), 80.0);
    assert!(!twice.text.contains("invented"), "{}", twice.text);
    let by_template =
        twice.names("shearwater_http_requests_total{method=\"GET\",route=\"/v1/jobs/{id}\"");
    assert_eq!(by_template.len(), 1, "{by_template:?}");
}

#[test]
fn a_crowd_of_scrapers_costs_one_census_a_second() {
    let farm = Farm::start();
    let began = std::time::Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| (0..25).for_each(|_| drop(Scrape::of(&farm.url))));
        }
    });
    let took = began.elapsed();
    // Nothing holds a scrape up: two hundred within a few seconds on a busy machine.
    assert!(took < Duration::from_secs(20), "{took:?}");
    let id = farm.submit(&[]);
    until("a new census", || {
        let now = Scrape::of(&farm.url);
        (now.value("shearwater_jobs{state=\"queued\"}") == 1.0).then_some(())
    });
    farm.delete(&id);
}

#[test]
fn a_client_may_read_them_and_a_worker_may_not() {
    let (folder, [admin, client, worker]) = folder_with_tokens();
    let farm = Guarded::start(folder, &[]);
    let ask = |token: &str| {
        let bearer = format!("Bearer {token}");
        http::ask(&farm.url, "GET", "/metrics", &[("authorization", &bearer)])
    };
    assert_eq!(http::get(&farm.url, "/metrics").0, 401);
    assert_eq!(ask(&worker).status, 403);
    assert_eq!(ask(&admin).status, 200);
    let answer = ask(&client);
    assert_eq!(answer.status, 200);
    let scrape = Scrape::read(answer.body);
    scrape.is_clean();
    let refused =
        "shearwater_http_requests_total{method=\"GET\",route=\"/metrics\",status=\"4xx\"}";
    assert_eq!(scrape.value(refused), 2.0);
    for token in [&admin, &client, &worker] {
        assert!(!scrape.text.contains(token.as_str()));
    }
}
