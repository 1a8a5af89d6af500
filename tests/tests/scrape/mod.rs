//! What a coordinator exports, as Prometheus reads it.

#![allow(dead_code, reason = "each test binary uses its own part")]

use crate::common::http;
use crate::common::stores::left_out;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Prometheus' own checker.
const PROMTOOL: &str = "promtool";

/// One scrape: every sample by its whole name, labels as they were written.
pub(crate) struct Scrape {
    pub(crate) text: String,
    samples: BTreeMap<String, f64>,
}

impl Scrape {
    /// Ask a coordinator.
    pub(crate) fn of(url: &str) -> Self {
        let (status, text) = http::get(url, "/metrics");
        assert_eq!(status, 200, "{text}");
        Self::read(text)
    }

    /// Read the older format.
    pub(crate) fn read(text: String) -> Self {
        let mut samples = BTreeMap::new();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let (name, value) = line.rsplit_once(' ').expect("name and value");
            let value = value.parse().expect("number");
            let twice = samples.insert(name.to_owned(), value);
            assert!(twice.is_none(), "{name} stands twice");
        }
        Self { text, samples }
    }

    /// A sample that must be there.
    pub(crate) fn value(&self, name: &str) -> f64 {
        let value = self.samples.get(name);
        *value.unwrap_or_else(|| panic!("{name} is not there:\n{}", self.text))
    }

    /// A sample, if it is there.
    pub(crate) fn get(&self, name: &str) -> Option<f64> {
        self.samples.get(name).copied()
    }

    /// The sum of all samples of a name with any labels.
    pub(crate) fn sum(&self, name: &str) -> f64 {
        let with = format!("{name}{{");
        let all = self.samples.iter();
        all.filter(|(of, _)| of.as_str() == name || of.starts_with(&with))
            .map(|(_, value)| value)
            .sum()
    }

    /// Whole names that begin so.
    pub(crate) fn names(&self, prefix: &str) -> Vec<&str> {
        let all = self.samples.keys().map(String::as_str);
        all.filter(|name| name.starts_with(prefix)).collect()
    }

    /// Names without labels.
    pub(crate) fn bare_names(&self) -> BTreeSet<&str> {
        let all = self.samples.keys();
        all.filter_map(|name| name.split('{').next()).collect()
    }

    /// Have Prometheus' own checker look at it: not even a warning.
    pub(crate) fn is_clean(&self) {
        promtool(&["check", "metrics"], &self.text);
    }
}

/// Run Prometheus' checker; what it says against `input` fails the test.
pub(crate) fn promtool(args: &[&str], input: &str) {
    let started = Command::new(PROMTOOL)
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let Ok(mut child) = started else {
        left_out("promtool", "not installed: apt-get install prometheus");
        return;
    };
    let mut stdin = child.stdin.take().expect("stdin");
    stdin.write_all(input.as_bytes()).expect("input");
    drop(stdin);
    let ended = child.wait_with_output().expect("promtool");
    let said = [ended.stdout, ended.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert!(ended.status.success(), "{args:?}: {said}\n{input}");
    assert!(
        args.get(1) != Some(&"metrics") || said.is_empty(),
        "{args:?}: {said}"
    );
}

/// A file of the repository.
pub(crate) fn repository(path: &str) -> std::path::PathBuf {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    top.expect("top of the repository").join(path)
}
