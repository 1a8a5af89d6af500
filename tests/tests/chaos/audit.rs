//! What must be true after a job, and at the end.

use super::farm::{COORDINATORS, Chaos, WORKERS};
use super::mending::Who;
use crate::common::farm::{film_hash_of, right_answer};
use crate::common::http;
use crate::common::process::{Process, command};
use crate::common::stores::{Pair, variable};
use crate::common::until;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// How long one question to a coordinator may take.
const ANSWER: Duration = Duration::from_secs(5);

/// A block of a tile of a frame.
type Unit = (u64, u64, u64);

/// Who counts for each unit, by a job's log.
#[derive(Debug, Default)]
struct Counted {
    owners: BTreeMap<Unit, String>,
    distrusted: BTreeSet<String>,
}

impl Counted {
    /// Follow the events from the first to the last.
    fn of(events: &[Value]) -> Self {
        let mut counted = Self::default();
        let mut events: Vec<&Value> = events.iter().collect();
        events.sort_by_key(|event| event["seq"].as_i64());
        for event in events {
            let worker = event["worker"].as_str().unwrap_or_default();
            match event["kind"].as_str().expect("kind") {
                "counted" => {
                    for unit in units(event) {
                        let before = counted.owners.insert(unit, worker.to_owned());
                        assert_eq!(before, None, "{unit:?} is counted twice: {event}");
                    }
                }
                "withdrawn" => {
                    for unit in units(event) {
                        let before = counted.owners.remove(&unit);
                        assert!(before.is_some(), "{unit:?} was not counted: {event}");
                    }
                }
                "distrusted" => drop(counted.distrusted.insert(worker.to_owned())),
                _ => {}
            }
        }
        counted
    }
}

fn units(event: &Value) -> Vec<Unit> {
    let number = |value: &Value| value.as_u64().expect("number");
    let runs = event["runs"].as_array().expect("runs").iter();
    let blocks = runs.flat_map(|run| {
        let (frame, tile) = (number(&run["frame"]), number(&run["tile"]));
        (number(&run["block0"])..number(&run["block1"])).map(move |block| (frame, tile, block))
    });
    blocks.collect()
}

impl Chaos {
    fn job(&mut self, id: &str) -> Option<Value> {
        Some(self.client(&["status", id, "--json"])?.json())
    }

    /// Whether somebody says that the job is done.
    pub(crate) fn is_done(&mut self, id: &str) -> bool {
        self.job(id).is_some_and(|job| job["done"] == true)
    }

    /// The end of a job: everything counted once, the right film, and whoever computed
    /// wrongly found out. Then it is deleted.
    pub(crate) fn audit(&mut self, id: &str) {
        let job = until("the job is done", || {
            self.mend_due();
            self.job(id).filter(|job| job["done"] == true)
        });
        let log = until("the job's log", || {
            self.mend_due();
            let log = self.client(&["log", id, "--json", "--limit", "20000"])?;
            Some(log.json())
        });
        let events = log["events"].as_array().expect("events");
        self.judge(&job, events);
        for event in events {
            let kind = event["kind"].as_str().expect("kind");
            *self.events.entry(kind.to_owned()).or_default() += 1;
        }
        println!("{:7.1} s  job {id} is right", self.now_s());
        self.delete(id);
    }

    fn judge(&self, job: &Value, events: &[Value]) {
        assert_eq!(job["state"], "done", "{job}");
        assert_eq!(job["units_done"], job["units_total"], "{job}");
        assert_eq!(job["audits"]["open"], 0, "{job}");
        let counted = Counted::of(events);
        let units = Some(counted.owners.len() as u64);
        assert_eq!(units, job["units_total"].as_u64(), "{job}: {counted:?}");
        let liars: BTreeSet<String> = self.liars.all().into_iter().collect();
        for worker in &counted.distrusted {
            assert!(
                liars.contains(worker),
                "{worker} computed rightly: {events:?}"
            );
        }
        for (unit, owner) in &counted.owners {
            assert!(!counted.distrusted.contains(owner), "{unit:?} of {owner}");
        }
        let touched = events.iter().filter_map(|event| event["worker"].as_str());
        if !touched.into_iter().any(|worker| liars.contains(worker)) {
            assert_eq!(job["unequal_results"], 0, "{job}");
        }
        // The promise of an audit of all runs: what two workers had agrees. Where no
        // second one could be asked (it says so), the first is kept.
        if film_hash_of(job) != right_answer() {
            let lies = counted.owners.values().any(|owner| liars.contains(owner));
            let skipped = job["audits"]["skipped"].as_u64() > Some(0);
            assert!(lies && skipped, "a wrong film: {job}\n{events:?}");
            println!("a lie stays where its audit was given up: {job}");
        }
    }

    /// Delete a job.
    fn delete(&mut self, id: &str) {
        until("a job is deleted", || {
            self.mend_due();
            let whom = self.whom()?;
            let path = format!("/v1/jobs/{id}");
            let answer = http::try_ask(&self.url(whom), "DELETE", &path, &[], ANSWER);
            let status = answer.ok()?.status;
            matches!(status, 204 | 404).then_some(())
        });
    }

    /// How often each kind of fault came, and each kind of event.
    pub(crate) fn tally(&self) -> String {
        let list = |of: &BTreeMap<String, usize>| {
            let each: Vec<_> = of.iter().map(|(kind, n)| format!("{kind} {n}")).collect();
            each.join(", ")
        };
        format!(
            "{}\nevents: {}\nliars: {}",
            list(&self.tally),
            list(&self.events),
            self.liars.all().len()
        )
    }

    /// Nobody is stuck; with all jobs deleted and a sweep, no row and no object stays.
    pub(crate) fn leaves_nothing(mut self, pair: Pair) {
        for number in 0..COORDINATORS {
            until("a coordinator is ready", || {
                self.mend_due();
                let answer = http::try_ask(&self.url(number), "GET", "/readyz", &[], ANSWER);
                (answer.ok()?.status == 200).then_some(())
            });
        }
        for number in 0..WORKERS {
            let worker = self.process(Who::Worker(number));
            assert!(worker.is_some_and(Process::runs), "worker {number}");
        }
        // One may have been taken from a client that was told nothing.
        let jobs = until("the list of jobs", || {
            self.client(&["jobs", "--json", "--limit", "1000"])
        });
        for job in jobs.json()["jobs"].as_array().expect("jobs") {
            self.delete(&job["id"].to_string());
        }
        self.sites.clear();
        self.coordinators = [const { None }; COORDINATORS];
        let swept = self.gc();
        println!(
            "swept at the end: {}; rows {}",
            swept["removed"], swept["rows"]
        );
        for (table, rows) in swept["rows"].as_object().expect("rows") {
            // Who lied is remembered, longer than it may come back.
            let most = match table.as_str() {
                "distrust" => self.liars.all().len() as u64,
                _ => 0,
            };
            assert!(rows.as_u64() <= Some(most), "{table} of {swept}");
        }
        let again = self.gc();
        // Emptied folders begin to age anew: they may be among the leavings.
        for what in ["deleted_jobs", "parts", "films", "assets"] {
            assert_eq!(again["removed"][what], 0, "{what} of {again}");
        }
        let left = self.objects(pair);
        assert_eq!(left, Vec::<String>::new(), "objects");
    }

    fn gc(&self) -> Value {
        let all = ["--assets-after", "0", "--orphans-after", "0"];
        let mut command = command(["gc", "--json"].iter().chain(&all));
        let places = &self.stores.places[0];
        command.args(&places.args).envs(places.envs.iter().cloned());
        Process::start(&mut command).end().ok().json()
    }

    /// All objects that there are, whatever the program says.
    fn objects(&self, pair: Pair) -> Vec<String> {
        let args = &self.stores.places[0].args;
        match pair {
            Pair::Laptop => files(&Path::new(&args[1]).join("objects")),
            Pair::Servers => bucket(&args[1]),
        }
    }
}

fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("folder") {
        let path = entry.expect("entry").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path.display().to_string());
        }
    }
    found
}

fn bucket(url: &str) -> Vec<String> {
    const PROGRAM: &str = "import boto3, os, sys\n\
        bucket, prefix = sys.argv[1].removeprefix('s3://').split('/', 1)\n\
        s3 = boto3.client('s3', endpoint_url=os.environ['AWS_ENDPOINT_URL'],\n\
            region_name=os.environ['AWS_REGION'])\n\
        pages = s3.get_paginator('list_objects_v2').paginate(Bucket=bucket, Prefix=prefix + '/')\n\
        for page in pages:\n\
        \x20   for o in page.get('Contents', []): print(o['Key'])\n";
    let python = variable("SHEARWATER_TEST_PYTHON");
    let listed = Command::new(python).args(["-c", PROGRAM, url]).output();
    let listed = listed.expect("python");
    let log = String::from_utf8_lossy(&listed.stderr);
    assert!(listed.status.success(), "{log}");
    let keys = String::from_utf8_lossy(&listed.stdout).into_owned();
    keys.lines().map(str::to_owned).collect()
}
