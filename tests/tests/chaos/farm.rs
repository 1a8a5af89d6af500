//! The farm that is broken, mended and audited.

use super::dice::Dice;
use super::faults::{Breakable, ClockOff, Fault, Mending, Mendings, Site, Who, draw};
use super::line::Weather;
use crate::common::farm::{film_hash_of, right_answer, worker_for};
use crate::common::process::{Process, command, run};
use crate::common::relay::Relay;
use crate::common::stores::{Pair, Places, new_database, new_prefix, postgres_address, s3_address};
use crate::common::{http, scene, until};
use serde_json::Value;
use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Coordinators on one store, and workers, of which each has a line of its own.
const COORDINATORS: usize = 2;
const WORKERS: usize = 3;
/// Where Debian keeps the library that makes clocks wrong.
const FAKETIME: &str = "/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1";

pub(crate) struct Chaos {
    dice: Dice,
    began: Instant,
    places: Places,
    stores: Vec<Relay>,
    ports: [u16; COORDINATORS],
    coordinators: [Option<Process>; COORDINATORS],
    sites: Vec<Site>,
    mendings: Mendings,
    jobs: Vec<String>,
    scene: PathBuf,
    folder: tempfile::TempDir,
    /// Coordinators that stand still: whoever asks them waits long.
    asleep: [bool; COORDINATORS],
    faults: usize,
    tally: BTreeMap<String, usize>,
}

impl Chaos {
    /// Start all of it.
    pub(crate) fn start(pair: Pair, seed: u64) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let (places, stores) = places(pair, folder.path());
        let mut chaos = Self {
            dice: Dice(seed),
            began: Instant::now(),
            places,
            stores,
            ports: [(); COORDINATORS].map(|()| free_port()),
            coordinators: [const { None }; COORDINATORS],
            sites: Vec::new(),
            mendings: Mendings::default(),
            jobs: Vec::new(),
            scene: scene::write(&folder.path().join("scene")),
            folder,
            asleep: [false; COORDINATORS],
            faults: 0,
            tally: BTreeMap::new(),
        };
        for number in 0..COORDINATORS {
            chaos.start_coordinator(number, ClockOff::default());
        }
        chaos.sites = (0..WORKERS)
            .map(|n| Site::start(&chaos.url(n % COORDINATORS)))
            .collect();
        chaos
    }

    fn url(&self, coordinator: usize) -> String {
        format!("http://127.0.0.1:{}", self.ports[coordinator])
    }

    fn start_coordinator(&mut self, number: usize, clock: ClockOff) {
        let mut command = command(["coordinator", "--listen"]);
        command
            .arg(format!("127.0.0.1:{}", self.ports[number]))
            .args(&self.places.args)
            .envs(self.places.envs.iter().cloned());
        if clock != ClockOff::default() {
            command.env("LD_PRELOAD", FAKETIME);
            command.env("FAKETIME", format!("{:+}", clock.0));
            command.env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
        }
        self.coordinators[number] = Some(Process::start(&mut command));
        self.asleep[number] = false;
    }

    /// Submit the scene, at whichever coordinator takes it; the job's number.
    pub(crate) fn submit(&mut self) -> String {
        let scene = self.scene.to_str().expect("UTF-8").to_owned();
        let id = until("a job is submitted", || {
            self.mend_due();
            let awake = (0..COORDINATORS).find(|&n| !self.asleep[n])?;
            let url = self.url(awake);
            let ended = run(["submit", &scene, "--json", "--coordinator", &url]);
            (ended.code == Some(0)).then(|| ended.json()["id"].to_string())
        });
        self.jobs.push(id.clone());
        id
    }

    /// Faults so far.
    pub(crate) fn faults(&self) -> usize {
        self.faults
    }

    /// A number below `end`.
    pub(crate) fn roll(&mut self, end: usize) -> usize {
        self.dice.below(end)
    }

    /// Let time pass, and mend what is due.
    pub(crate) fn wait(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until {
            std::thread::sleep(Duration::from_millis(20));
            self.mend_due();
        }
    }

    fn mend_due(&mut self) {
        for mending in self.mendings.due(false) {
            self.mend(mending);
        }
    }

    /// Mend everything, now.
    pub(crate) fn mend_all(&mut self) {
        for mending in self.mendings.due(true) {
            self.mend(mending);
        }
    }

    fn mend(&mut self, mending: Mending) {
        match mending {
            Mending::Worker(n) => {
                self.sites[n].worker = Some(worker_for(&self.sites[n].line.url, 1));
            }
            Mending::Coordinator(n, clock) => self.start_coordinator(n, clock),
            Mending::Weather(n) => self.sites[n].line.weather(Weather::Clear),
            Mending::Store(n) => self.stores[n].mend(),
            Mending::Wake(who) => {
                if let Some(process) = self.process(who) {
                    process.signal("CONT");
                }
                self.fall_asleep(who, false);
            }
        }
    }

    fn fall_asleep(&mut self, who: Who, asleep: bool) {
        if let Who::Coordinator(n) = who {
            self.asleep[n] = asleep;
        }
    }

    fn process(&mut self, who: Who) -> Option<&mut Process> {
        match who {
            Who::Worker(n) => self.sites[n].worker.as_mut(),
            Who::Coordinator(n) => self.coordinators[n].as_mut(),
        }
    }

    fn can_break(&self, fault: Fault) -> bool {
        match fault {
            Fault::KillWorker(n) | Fault::StopWorker(n, _) => self.sites[n].worker.is_some(),
            Fault::KillCoordinator(n, _) | Fault::StopCoordinator(n, _) => {
                self.coordinators[n].is_some() && !self.asleep[n]
            }
            Fault::Weather(..) | Fault::Damage(..) | Fault::Store(..) => true,
        }
    }

    /// Break something, unless the dice name what is broken already.
    pub(crate) fn next_fault(&mut self) {
        let of = Breakable {
            workers: WORKERS,
            coordinators: COORDINATORS,
            stores: self.stores.len(),
            clocks: Path::new(FAKETIME).is_file(),
        };
        let fault = draw(&mut self.dice, of);
        // Who is down or stands still cannot be broken once more.
        if !self.can_break(fault) {
            return;
        }
        self.faults += 1;
        println!("{:7.1} s  {fault}", self.began.elapsed().as_secs_f64());
        let kind = format!("{fault:?}");
        let kind = kind.split('(').next().unwrap_or_default().to_owned();
        *self.tally.entry(kind).or_default() += 1;
        let again = Duration::from_millis(100 + 100 * self.dice.below(15) as u64);
        match fault {
            Fault::KillWorker(n) => {
                if let Some(worker) = self.sites[n].worker.take() {
                    worker.kill();
                    self.mendings.after(again, Mending::Worker(n));
                }
            }
            Fault::KillCoordinator(n, clock) => {
                if let Some(coordinator) = self.coordinators[n].take() {
                    coordinator.kill();
                    self.mendings.after(again, Mending::Coordinator(n, clock));
                }
            }
            Fault::StopWorker(n, time) => self.stop(Who::Worker(n), time),
            Fault::StopCoordinator(n, time) => self.stop(Who::Coordinator(n), time),
            Fault::Weather(n, weather, time) => {
                self.sites[n].line.weather(weather);
                self.mendings.after(time, Mending::Weather(n));
            }
            Fault::Damage(n, damage) => self.sites[n].line.damage(damage),
            Fault::Store(n, time) => {
                self.stores[n].cut();
                self.mendings.after(time, Mending::Store(n));
            }
        }
    }

    fn stop(&mut self, who: Who, time: Duration) {
        if let Some(process) = self.process(who) {
            process.signal("STOP");
            self.fall_asleep(who, true);
            self.mendings.after(time, Mending::Wake(who));
        }
    }

    /// Whether somebody says that the job is done.
    pub(crate) fn is_done(&mut self, id: &str) -> bool {
        self.job(id).is_some_and(|job| job["done"] == true)
    }

    // As whoever answers sees it; nobody may.
    fn job(&self, id: &str) -> Option<Value> {
        let mut awake =
            (0..COORDINATORS).filter(|&n| !self.asleep[n] && self.coordinators[n].is_some());
        awake.find_map(|n| {
            let ended = run(["status", id, "--json", "--coordinator", &self.url(n)]);
            (ended.code == Some(0)).then(|| ended.json())
        })
    }

    /// The end of a job: everything counted, once, and the right film.
    pub(crate) fn audit(&mut self, id: &str) {
        let job = until("the job is done", || {
            self.mend_due();
            self.job(id).filter(|job| job["done"] == true)
        });
        assert_eq!(job["state"], "done", "{job}");
        assert_eq!(job["units_done"], job["units_total"], "{job}");
        assert_eq!(job["unequal_results"], 0, "{job}");
        assert_eq!(film_hash_of(&job), right_answer(), "{job}");
        println!(
            "{:7.1} s  job {id} is right",
            self.began.elapsed().as_secs_f64()
        );
    }

    /// How often each kind of fault came.
    pub(crate) fn tally(&self) -> String {
        let each = self
            .tally
            .iter()
            .map(|(kind, times)| format!("{kind} {times}"));
        each.collect::<Vec<_>>().join(", ")
    }

    /// Delete every job and sweep: no row and no object stays.
    pub(crate) fn leaves_nothing(mut self) {
        for id in std::mem::take(&mut self.jobs) {
            let url = self.url(0);
            until("a job is deleted", || {
                let (status, _) = http::send(&url, "DELETE", &format!("/v1/jobs/{id}"));
                matches!(status, 204 | 404).then_some(())
            });
        }
        self.sites.clear();
        self.coordinators = [const { None }; COORDINATORS];
        let swept = self.gc();
        println!("swept at the end: {}", swept["removed"]);
        for (table, rows) in swept["rows"].as_object().expect("rows") {
            assert_eq!(rows, 0, "{table} of {swept}");
        }
        let again = self.gc();
        // Emptied folders begin to age anew: they may be among the leavings.
        for what in ["deleted_jobs", "parts", "films", "assets"] {
            assert_eq!(again["removed"][what], 0, "{what} of {again}");
        }
        drop(self.folder);
    }

    fn gc(&self) -> Value {
        let mut command = command([
            "gc",
            "--json",
            "--assets-after",
            "0",
            "--orphans-after",
            "0",
        ]);
        command
            .args(&self.places.args)
            .envs(self.places.envs.iter().cloned());
        Process::start(&mut command).end().ok().json()
    }
}

// A farm's stores, and the lines to them that can be cut.
fn places(pair: Pair, folder: &Path) -> (Places, Vec<Relay>) {
    if pair == Pair::Laptop {
        return (pair.places(folder), Vec::new());
    }
    let (database, objects) = (Relay::to(postgres_address()), Relay::to(s3_address()));
    let url = new_database().replace(&postgres_address().to_string(), &database.addr.to_string());
    let mut places = Places::servers(&url, &new_prefix());
    let url = format!("http://{}", objects.addr);
    places.envs.push(("AWS_ENDPOINT_URL".into(), url));
    (places, vec![database, objects])
}

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("address").port()
}
