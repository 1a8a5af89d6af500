//! `shearwater simulate` against a real coordinator: what it says must be true.

mod common;

use common::farm::Farm;
use common::http;
use common::process::run;
use serde_json::Value;

fn number(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number at {path} of {value}"))
}

/// Times of a distribution rise with their share.
fn in_order(report: &Value, what: &str) {
    let at = |name: &str| number(report, &format!("/{what}/{name}"));
    let times = ["p50_ms", "p90_ms", "p99_ms", "max_ms"].map(at);
    assert!(times.is_sorted(), "{what}: {times:?}");
}

/// Workers fail and vanish; in the end every unit is counted once, and every film has
/// the hash that its sums must give.
#[test]
fn every_unit_counts_once_whatever_the_workers_do() {
    let args = "simulate --json --workers 50 --units 2000 --unit-ms 40 --failure-rate 0.03 \
                --vanish-rate 0.02 --slow 0.1 --threads 2 --audit 0.05 --seed 7";
    let report = run(args.split_whitespace()).ok().json();
    let at = |path: &str| number(&report, path);
    assert_eq!(report["audit"]["faults"], Value::Array(Vec::new()));
    assert_eq!(
        (at("/audit/units_done"), at("/audit/units_total")),
        (2000.0, 2000.0)
    );
    assert_eq!(
        (at("/audit/films_checked"), at("/audit/films_wrong")),
        (20.0, 0.0)
    );
    assert_eq!(at("/audit/units_counted_twice"), 0.0);
    assert_eq!(report["audit"]["done"], true);
    assert_eq!(report["cut_short"], false);
    assert_eq!((at("/units"), at("/workers_connected")), (2000.0, 50.0));
    assert!(at("/failures") > 0.0 && at("/vanished") > 0.0, "{report}");
    // What failed or was lost was given again, and no unit was counted that was not.
    assert!(at("/units_given_again") >= at("/failures"), "{report}");
    assert!(at("/units_counted") <= 2000.0 && at("/units_counted") > 1000.0);
    assert!(at("/units_per_s") > 0.0 && at("/work_s") > 0.0);
    assert!(at("/lease_wait/count") <= at("/leases"), "{report}");
    for times in ["lease_wait", "lease_wait_cut", "result_wait"] {
        in_order(&report, times);
    }
    assert!(
        at("/efficiency") > 0.0 && at("/efficiency") <= 1.0,
        "{report}"
    );
    assert!(at("/bytes_sent_per_unit") > 100.0 && at("/calls_per_unit") > 0.1);
    if cfg!(target_os = "linux") {
        let quarters = report["coordinator"]["rss_quarters_bytes"].as_array();
        let most = at("/coordinator/rss_max_bytes");
        assert_eq!(quarters.map(Vec::len), Some(4));
        assert!(
            most > 1e6
                && quarters
                    .into_iter()
                    .flatten()
                    .all(|q| q.as_f64() <= Some(most))
        );
        assert!(at("/coordinator/cpu_s") > 0.0 && at("/coordinator/files_max") > 50.0);
    }
}

/// On a farm that is there: not beside other jobs, and nothing stays behind.
#[test]
fn a_running_farm_is_left_as_it_was() {
    let farm = Farm::start();
    let args = ["simulate", "--json", "--workers", "4", "--units", "100000"];
    let other = farm.submit(&[]);
    let refused = farm.client(&args).expect_code(1).json();
    let text = refused["error"]["message"].to_string();
    assert!(text.contains(&format!("job {other} ")), "{text}");
    farm.client(&["cancel", &other]).ok();
    let bounded = [&args[..], &["--unit-ms", "50", "--seconds", "4"]].concat();
    let report = farm.client(&bounded).ok().json();
    assert_eq!(report["cut_short"], true);
    assert_eq!(report["coordinator"], Value::Null);
    assert!(number(&report, "/audit/units_done") > 0.0, "{report}");
    let (status, jobs) = http::get(&farm.url, "/v1/jobs");
    assert_eq!(status, 200);
    let jobs: Value = serde_json::from_str(&jobs).expect("JSON");
    let left = jobs["jobs"].as_array().map(Vec::len);
    assert_eq!(left, Some(1), "{jobs}");
}
