//! Faults happen, and are mended.

use super::database::Database;
use super::farm::{COORDINATORS, Chaos, WORKERS, faketime};
use super::faults::{Breakable, ClockOff, Fault, draw};
use super::line::Weather;
use super::mending::{Mending, Who};
use super::network::Cable;
use std::time::Duration;

/// Until a process that ended by itself is started again, as a service manager would.
const AGAIN: Duration = Duration::from_secs(1);

impl Chaos {
    fn can_break(&self, fault: Fault) -> bool {
        let awake = |who| !self.asleep.contains(&who);
        let database = self.stores.database.as_ref();
        let database_is_up = database.is_some_and(Database::is_up) && awake(Who::Database);
        match fault {
            Fault::KillWorker(n) => self.sites[n].worker.is_some(),
            Fault::StopWorker(n, _) => self.sites[n].worker.is_some() && awake(Who::Worker(n)),
            // One at a time: an audit believes two.
            Fault::Lie(n, _) => self.sites[n].worker.is_some() && self.liar.is_none(),
            Fault::KillCoordinator(n, _) | Fault::StopCoordinator(n, _) => {
                self.coordinators[n].is_some() && awake(Who::Coordinator(n))
            }
            Fault::KillDatabase | Fault::StopDatabase(_) => database_is_up,
            Fault::StopObjects(_) => self.stores.objects.is_some() && awake(Who::Objects),
            Fault::FullDisk(_) => self.stores.disk.is_some() && !self.stores.disk_is_full,
            Fault::Weather(..) | Fault::Damage(..) | Fault::Cable(..) | Fault::Store(..) => true,
        }
    }

    /// What of a farm this machine can break; says aloud what it cannot.
    pub(crate) fn breakable(&self) -> Breakable {
        Breakable {
            workers: WORKERS,
            coordinators: COORDINATORS,
            stores: self.stores.to_cut(),
            servers: self.stores.database.is_some(),
            disk: self.stores.disk.is_some(),
            rooms: !self.rooms.is_empty(),
            clocks: faketime().is_some(),
        }
    }

    /// Break something, unless the dice name what is broken already.
    pub(crate) fn next_fault(&mut self) {
        let of = self.breakable();
        let fault = draw(&mut self.dice, of);
        if !self.can_break(fault) {
            return;
        }
        self.faults += 1;
        println!("{:7.1} s  {fault}", self.now_s());
        *self.tally.entry(fault.kind()).or_default() += 1;
        self.happen(fault);
    }

    fn happen(&mut self, fault: Fault) {
        let again = Duration::from_millis(100 + 100 * self.dice.below(15) as u64);
        match fault {
            Fault::KillWorker(n) => {
                self.take(Who::Worker(n));
                self.mendings.after(again, Mending::Worker(n));
            }
            Fault::KillCoordinator(n, clock) => {
                self.take(Who::Coordinator(n));
                self.mendings.after(again, Mending::Coordinator(n, clock));
            }
            Fault::StopWorker(n, time) => self.stop(Who::Worker(n), time),
            Fault::StopCoordinator(n, time) => self.stop(Who::Coordinator(n), time),
            Fault::StopDatabase(time) => self.stop(Who::Database, time),
            Fault::StopObjects(time) => self.stop(Who::Objects, time),
            Fault::Weather(n, weather, time) => {
                self.sites[n].line.weather(weather);
                self.mendings.after(time, Mending::Weather(n));
            }
            Fault::Damage(n, damage) => self.sites[n].line.damage(damage),
            Fault::Lie(n, time) => {
                self.liar = Some(n);
                self.sites[n].line.lie(true);
                self.mendings.after(time, Mending::Honest(n));
            }
            Fault::Cable(n, state, time) => {
                self.rooms[n].becomes(state).expect("a cable");
                self.mendings.after(time, Mending::Cable(n));
            }
            Fault::Store(line, time) => {
                self.stores.cut(line);
                self.mendings.after(time, Mending::Store(line));
            }
            Fault::KillDatabase => {
                if let Some(database) = &mut self.stores.database {
                    database.kill();
                }
                self.mendings.after(again, Mending::Database);
            }
            Fault::FullDisk(time) => {
                if let Some(disk) = &self.stores.disk {
                    disk.fill();
                }
                self.stores.disk_is_full = true;
                self.mendings.after(time, Mending::Disk);
            }
        }
    }

    fn stop(&mut self, who: Who, time: Duration) {
        self.signal(who, "STOP");
        self.asleep.push(who);
        self.mendings.after(time, Mending::Wake(who));
    }

    fn signal(&mut self, who: Who, name: &str) {
        match self.process(who) {
            Some(process) => process.signal(name),
            None => self.stores.signal(who, name),
        }
    }

    /// Mend what is due, and start again what ended by itself.
    pub(crate) fn mend_due(&mut self) {
        for mending in self.mendings.due(false) {
            self.mend(mending);
        }
        let workers = (0..WORKERS).map(Who::Worker);
        for who in workers.chain((0..COORDINATORS).map(Who::Coordinator)) {
            self.look_after(who);
        }
        if self
            .stores
            .database
            .as_mut()
            .is_some_and(Database::look_after)
        {
            println!("{:7.1} s  the database ended by itself", self.now_s());
        }
    }

    fn look_after(&mut self, who: Who) {
        let Some(process) = self.process(who) else {
            return;
        };
        if process.runs() {
            return;
        }
        let log = process.stderr();
        let why = log.lines().last().unwrap_or_default();
        println!("{:7.1} s  {who:?} ended by itself: {why}", self.now_s());
        *self.events.entry("ended by itself".into()).or_default() += 1;
        self.take(who);
        match who {
            Who::Worker(n) => self.mendings.after(AGAIN, Mending::Worker(n)),
            Who::Coordinator(n) => {
                let clock = ClockOff::default();
                self.mendings.after(AGAIN, Mending::Coordinator(n, clock));
            }
            Who::Database | Who::Objects => {}
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
                if self.sites[n].worker.is_none() {
                    self.start_worker(n);
                }
            }
            Mending::Honest(n) => {
                self.liar = None;
                self.sites[n].line.lie(false);
                // Who is down comes back honest.
                if self.take(Who::Worker(n)) {
                    self.start_worker(n);
                }
            }
            Mending::Coordinator(n, clock) => {
                if self.coordinators[n].is_none() {
                    self.start_coordinator(n, clock);
                }
            }
            Mending::Weather(n) => self.sites[n].line.weather(Weather::Clear),
            Mending::Cable(n) => self.rooms[n].becomes(Cable::Good).expect("a cable"),
            Mending::Store(line) => self.stores.mend(line),
            Mending::Database => {
                if let Some(database) = &mut self.stores.database {
                    database.start_again();
                }
            }
            Mending::Disk => {
                if let Some(disk) = &self.stores.disk {
                    disk.free();
                }
                self.stores.disk_is_full = false;
            }
            Mending::Wake(who) => {
                self.signal(who, "CONT");
                self.asleep.retain(|asleep| *asleep != who);
            }
        }
    }
}
