//! The farm: coordinators on one store and workers, each with a line of its own.

use super::dice::Dice;
use super::faults::ClockOff;
use super::lies::Liars;
use super::line::Line;
use super::mending::{Mendings, Who};
use super::network::{Room, rooms};
use super::stores::Stores;
use crate::common::farm::steady_port;
use crate::common::process::{Ended, Process, command};
use crate::common::stores::{Pair, left_out};
use crate::common::{scene, until};
use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

pub(crate) const COORDINATORS: usize = 2;
/// One may compute wrongly: two others find it out.
pub(crate) const WORKERS: usize = 3;
/// Longest that a client may take: whoever it asks may stand still.
const CLIENT_MAX: Duration = Duration::from_secs(20);

/// All of it. Processes end before what they stand on.
pub(crate) struct Chaos {
    pub(crate) sites: Vec<Site>,
    pub(crate) coordinators: [Option<Process>; COORDINATORS],
    pub(crate) stores: Stores,
    /// Of the workers, then of the coordinators; or none at all.
    pub(crate) rooms: Vec<Room>,
    pub(crate) dice: Dice,
    pub(crate) began: Instant,
    ports: [u16; COORDINATORS],
    /// Whom a client asks next.
    turn: usize,
    pub(crate) mendings: Mendings,
    pub(crate) liars: Liars,
    /// Who computes wrongly now.
    pub(crate) liar: Option<usize>,
    pub(crate) asleep: Vec<Who>,
    pub(crate) faults: usize,
    pub(crate) tally: BTreeMap<String, usize>,
    pub(crate) events: BTreeMap<String, usize>,
    scene: PathBuf,
    _folder: tempfile::TempDir,
}

/// A worker behind a line of its own.
pub(crate) struct Site {
    pub(crate) line: Line,
    pub(crate) worker: Option<Process>,
}

impl Chaos {
    /// Start all of it.
    pub(crate) fn start(pair: Pair, seed: u64) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let rooms = rooms(WORKERS + COORDINATORS).unwrap_or_else(|why| {
            left_out("chaos: network namespaces; lines are relays", &why);
            Vec::new()
        });
        let gateway = |n| {
            rooms
                .get(n)
                .map_or(Ipv4Addr::LOCALHOST, |room: &Room| room.gateway)
        };
        let gateways: Vec<_> = (0..COORDINATORS).map(|n| gateway(WORKERS + n)).collect();
        let mut chaos = Self {
            sites: Vec::new(),
            coordinators: [const { None }; COORDINATORS],
            stores: Stores::start(pair, folder.path(), &gateways),
            rooms,
            dice: Dice(seed),
            began: Instant::now(),
            ports: [(); COORDINATORS].map(|()| steady_port()),
            turn: 0,
            mendings: Mendings::default(),
            liars: Liars::default(),
            liar: None,
            asleep: Vec::new(),
            faults: 0,
            tally: BTreeMap::new(),
            events: BTreeMap::new(),
            scene: scene::write(&folder.path().join("scene")),
            _folder: folder,
        };
        for number in 0..COORDINATORS {
            chaos.start_coordinator(number, ClockOff::default());
        }
        for number in 0..WORKERS {
            let from = chaos.rooms.get(number);
            let from = from.map_or(Ipv4Addr::LOCALHOST, |room| room.gateway);
            let line = Line::to(&chaos.url(number % COORDINATORS), from, &chaos.liars);
            chaos.sites.push(Site { line, worker: None });
            chaos.start_worker(number);
        }
        chaos
    }

    fn room(&self, who: Who) -> Option<&Room> {
        match who {
            Who::Worker(n) => self.rooms.get(n),
            Who::Coordinator(n) => self.rooms.get(WORKERS + n),
            Who::Database | Who::Objects => None,
        }
    }

    fn spawn(&self, who: Who, command: &mut Command) -> Process {
        match self.room(who) {
            Some(room) => Process::start(&mut room.command(command)),
            None => Process::start(command),
        }
    }

    fn address(&self, coordinator: usize) -> String {
        let room = self.room(Who::Coordinator(coordinator));
        let ip = room.map_or(Ipv4Addr::LOCALHOST, |room| room.address);
        format!("{ip}:{}", self.ports[coordinator])
    }

    pub(crate) fn url(&self, coordinator: usize) -> String {
        format!("http://{}", self.address(coordinator))
    }

    pub(crate) fn start_worker(&mut self, number: usize) {
        let url = self.sites[number].line.url.clone();
        let mut command = command(["worker", "--threads", "1", "--coordinator", &url]);
        let worker = self.spawn(Who::Worker(number), &mut command);
        self.sites[number].worker = Some(worker);
    }

    pub(crate) fn start_coordinator(&mut self, number: usize, clock: ClockOff) {
        let mut command = command(["coordinator", "--audit", "1", "--allow-public", "--listen"]);
        let places = &self.stores.places[number];
        command
            .arg(self.address(number))
            .args(&places.args)
            .envs(places.envs.iter().cloned());
        if let Some(library) = faketime().filter(|_| clock != ClockOff::default()) {
            command.env("LD_PRELOAD", library);
            command.env("FAKETIME", format!("{:+}", clock.0));
            command.env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
        }
        self.coordinators[number] = Some(self.spawn(Who::Coordinator(number), &mut command));
    }

    /// A process, unless it is down.
    pub(crate) fn process(&mut self, who: Who) -> Option<&mut Process> {
        match who {
            Who::Worker(n) => self.sites[n].worker.as_mut(),
            Who::Coordinator(n) => self.coordinators[n].as_mut(),
            Who::Database | Who::Objects => None,
        }
    }

    /// Take a process out of service: killed, and not for a mistake of its own.
    pub(crate) fn take(&mut self, who: Who) -> bool {
        let process = match who {
            Who::Worker(n) => self.sites[n].worker.take(),
            Who::Coordinator(n) => self.coordinators[n].take(),
            Who::Database | Who::Objects => None,
        };
        self.asleep.retain(|asleep| *asleep != who);
        let there = process.is_some();
        if let Some(process) = process {
            let log = process.stderr();
            process.kill();
            assert!(!log.contains("panicked"), "{who:?}:\n{log}");
        }
        there
    }

    /// Seconds since the start.
    pub(crate) fn now_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Run a client at whoever is there; `None` when it got nowhere.
    pub(crate) fn client(&mut self, args: &[&str]) -> Option<Ended> {
        let whom = self.whom()?;
        let url = self.url(whom);
        let mut client = Process::start(&mut command(args.iter().chain(&["--coordinator", &url])));
        let started = Instant::now();
        while client.runs() {
            if started.elapsed() > CLIENT_MAX {
                client.kill();
                return None;
            }
            std::thread::sleep(Duration::from_millis(20));
            self.mend_due();
        }
        Some(client.end()).filter(|ended| ended.code == Some(0))
    }

    /// Another coordinator each time, of those that are awake.
    pub(crate) fn whom(&mut self) -> Option<usize> {
        self.turn += 1;
        let mut order = (0..COORDINATORS).map(|n| (n + self.turn) % COORDINATORS);
        order.find(|&n| {
            self.coordinators[n].is_some() && !self.asleep.contains(&Who::Coordinator(n))
        })
    }

    /// Submit the scene, at whichever coordinator takes it; the job's number.
    pub(crate) fn submit(&mut self) -> String {
        let scene = self.scene.to_str().expect("UTF-8").to_owned();
        until("a job is submitted", || {
            self.mend_due();
            let ended = self.client(&["submit", &scene, "--json"])?;
            Some(ended.json()["id"].to_string())
        })
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
}

/// The library that makes clocks wrong, where Debian keeps it.
pub(crate) fn faketime() -> Option<PathBuf> {
    let machines = std::fs::read_dir("/usr/lib").ok()?;
    let paths = machines.filter_map(|machine| Some(machine.ok()?.path()));
    paths
        .map(|path| path.join("faketime/libfaketime.so.1"))
        .find(|path| path.is_file())
}
