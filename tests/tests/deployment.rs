//! What stands in `deploy/` fits the program: dashboard, rules and documentation name what
//! is exported, and Prometheus takes its configuration and its alerts.

mod common;
mod scrape;

use common::farm::Farm;
use scrape::{Scrape, promtool, repository};
use serde_json::Value;
use std::collections::BTreeSet;

/// Names of series in a text.
fn named(text: &str) -> BTreeSet<&str> {
    let is_of_a_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
    let words = text.split(|c: char| !is_of_a_name(c));
    words
        .filter(|word| {
            let ours = word.starts_with("shearwater_") || word.starts_with("process_");
            ours && !word.ends_with('_')
        })
        .collect()
}

fn read(path: &str) -> String {
    let path = repository(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn dashboard_rules_and_documentation_name_what_is_exported() {
    let farm = Farm::start();
    // Requests are known from the second scrape on.
    Scrape::of(&farm.url);
    let scrape = Scrape::of(&farm.url);
    let exported = scrape.bare_names();
    for path in [
        "deploy/grafana/shearwater.json",
        "deploy/prometheus/shearwater.rules.yml",
        "deploy/kubernetes-keda/scaledobject.yaml",
        "tests/alerts.yml",
    ] {
        let text = read(path);
        let wanted = named(&text);
        assert!(
            path.contains("keda") || wanted.len() > 5,
            "{path}: {wanted:?}"
        );
        let lacking: Vec<_> = wanted.difference(&exported).collect();
        assert!(
            lacking.is_empty(),
            "{path} names what is not there: {lacking:?}"
        );
    }
    // The page names histograms by what stands before _bucket, _sum and _count.
    let documentation = read("docs/metrics.md");
    let documented = named(&documentation);
    let families: BTreeSet<&str> = scrape
        .text
        .lines()
        .filter_map(|line| line.strip_prefix("# TYPE ")?.split(' ').next())
        .collect();
    let lacking: Vec<_> = families.difference(&documented).collect();
    assert!(lacking.is_empty(), "docs/metrics.md lacks {lacking:?}");
    let unknown: Vec<_> = documented
        .iter()
        .filter(|name| !families.contains(*name) && !exported.contains(*name))
        .collect();
    assert!(
        unknown.is_empty(),
        "docs/metrics.md names {unknown:?}, which is not there"
    );
}

#[test]
fn prometheus_takes_configuration_rules_and_alerts() {
    let path = |path| repository(path).to_str().expect("UTF-8").to_owned();
    promtool(
        &["check", "config", &path("deploy/prometheus/prometheus.yml")],
        "",
    );
    promtool(
        &[
            "check",
            "rules",
            &path("deploy/prometheus/shearwater.rules.yml"),
        ],
        "",
    );
    promtool(&["test", "rules", &path("tests/alerts.yml")], "");
}

#[test]
fn every_panel_of_the_dashboard_asks_for_something() {
    let dashboard: Value =
        serde_json::from_str(&read("deploy/grafana/shearwater.json")).expect("JSON");
    let panels = dashboard["panels"].as_array().expect("panels");
    let mut ids = BTreeSet::new();
    let mut asked = 0;
    for panel in panels {
        assert!(ids.insert(panel["id"].as_u64().expect("id")), "{panel}");
        if panel["type"] == "row" {
            continue;
        }
        let targets = panel["targets"].as_array().expect("targets");
        assert!(!targets.is_empty(), "{}", panel["title"]);
        for target in targets {
            let expr = target["expr"].as_str().expect("expr");
            assert!(expr.contains("job=~\"$job\""), "of every farm: {expr}");
            asked += 1;
        }
        let place = &panel["gridPos"];
        let right = place["x"].as_u64().zip(place["w"].as_u64());
        assert!(
            right.is_some_and(|(x, w)| x + w <= 24),
            "{}",
            panel["title"]
        );
    }
    assert!(asked > 30, "{asked}");
}

#[test]
fn what_the_dashboard_asks_is_promql() {
    let dashboard: Value =
        serde_json::from_str(&read("deploy/grafana/shearwater.json")).expect("JSON");
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("dashboard.rules.yml");
    let mut rules = "groups:\n  - name: dashboard\n    rules:\n".to_owned();
    let panels = dashboard["panels"].as_array().expect("panels");
    let targets = panels
        .iter()
        .filter_map(|panel| panel["targets"].as_array());
    for (number, target) in targets.flatten().enumerate() {
        let expr = target["expr"].as_str().expect("expr");
        let expr = expr.replace("$__rate_interval", "5m").replace("$job", ".*");
        let expr = serde_json::to_string(&expr).expect("text");
        rules.push_str(&format!(
            "      - record: panel:number{number}\n        expr: {expr}\n"
        ));
    }
    std::fs::write(&file, rules).expect("file");
    promtool(&["check", "rules", file.to_str().expect("UTF-8")], "");
}
