//! The stores of the farm, each coordinator's lines to them, and how they fail.

use super::database::Database;
use super::faults::Line;
use super::mending::Who;
use crate::common::disk::SmallDisk;
use crate::common::farm::steady_port;
use crate::common::relay::Relay;
use crate::common::stores::{Pair, Places, left_out, new_prefix, s3_address};
use std::net::Ipv4Addr;
use std::path::Path;
use std::process::Command;

/// Room for some jobs: a film and its parts are 15 MB.
const DISK_MIB: u32 = 256;

pub(crate) struct Stores {
    /// Of each coordinator.
    pub(crate) places: Vec<Places>,
    /// Of each coordinator: to the database, to the object store.
    lines: Vec<[Relay; 2]>,
    pub(crate) database: Option<Database>,
    /// Process of the object store.
    pub(crate) objects: Option<u32>,
    pub(crate) disk: Option<SmallDisk>,
    pub(crate) disk_is_full: bool,
}

impl Stores {
    /// Empty stores for coordinators that reach this machine at `gateways`.
    pub(crate) fn start(pair: Pair, folder: &Path, gateways: &[Ipv4Addr]) -> Self {
        match pair {
            Pair::Laptop => Self::laptop(folder, gateways.len()),
            Pair::Servers => Self::servers(gateways),
        }
    }

    fn laptop(folder: &Path, coordinators: usize) -> Self {
        let disk = SmallDisk::mount(DISK_MIB);
        if disk.is_none() {
            left_out("chaos: full disks", "only root can mount a small disk");
        }
        let place = disk.as_ref().map_or(folder, SmallDisk::path).join("data");
        Self {
            places: vec![Places::folder(&place); coordinators],
            lines: Vec::new(),
            database: None,
            objects: None,
            disk,
            disk_is_full: false,
        }
    }

    fn servers(gateways: &[Ipv4Addr]) -> Self {
        let database = Database::start(steady_port());
        let prefix = new_prefix();
        let pid = std::env::var("SHEARWATER_TEST_S3_PID").ok();
        let (mut places, mut lines) = (Vec::new(), Vec::new());
        for &gateway in gateways {
            let line = [
                Relay::on(gateway, database.address()),
                Relay::on(gateway, s3_address()),
            ];
            let mut place = Places::servers(&Database::url(line[0].addr), &prefix);
            let endpoint = format!("http://{}", line[1].addr);
            place.envs.push(("AWS_ENDPOINT_URL".into(), endpoint));
            places.push(place);
            lines.push(line);
        }
        Self {
            places,
            lines,
            database: Some(database),
            objects: pid.and_then(|pid| pid.parse().ok()),
            disk: None,
            disk_is_full: false,
        }
    }

    /// Kinds of stores that can be cut off.
    pub(crate) fn to_cut(&self) -> usize {
        self.lines.first().map_or(0, |line| line.len())
    }

    fn lines(&self, of: Line) -> impl Iterator<Item = &Relay> {
        let lines = self.lines.iter().enumerate();
        let meant = lines.filter(move |(n, _)| of.coordinator.is_none_or(|only| only == *n));
        meant.map(move |(_, line)| &line[of.store])
    }

    pub(crate) fn cut(&self, of: Line) {
        for line in self.lines(of) {
            if of.silent {
                line.fall_silent();
            } else {
                line.cut();
            }
        }
    }

    pub(crate) fn mend(&self, of: Line) {
        self.lines(of).for_each(Relay::mend);
    }

    /// SIGSTOP or SIGCONT to a server.
    pub(crate) fn signal(&self, who: Who, name: &str) {
        match (who, &self.database, self.objects) {
            (Who::Database, Some(database), _) => database.signal(name),
            (Who::Objects, _, Some(pid)) => {
                let mut kill = Command::new("kill");
                kill.args([&format!("-{name}"), &pid.to_string()]);
                assert!(kill.status().expect("kill").success());
            }
            _ => {}
        }
    }
}

impl Drop for Stores {
    fn drop(&mut self) {
        // It is not ours alone.
        self.signal(Who::Objects, "CONT");
    }
}
