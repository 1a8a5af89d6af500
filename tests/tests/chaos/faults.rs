//! What goes wrong, and when it is mended.

use super::dice::Dice;
use super::line::{Damage, Line, Weather};
use crate::common::farm::worker_for;
use crate::common::process::Process;
use std::fmt;
use std::time::{Duration, Instant};

/// One thing that goes wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Fault {
    /// SIGKILL, and a new process after a while.
    KillWorker(usize),
    /// SIGSTOP; longer than a lease, its results come late.
    StopWorker(usize, Duration),
    /// SIGKILL, and a new process with a clock that is off.
    KillCoordinator(usize, ClockOff),
    /// SIGSTOP of a coordinator.
    StopCoordinator(usize, Duration),
    /// Bad weather on the line of a worker.
    Weather(usize, Weather, Duration),
    /// A result that arrives damaged.
    Damage(usize, Damage),
    /// The line of all coordinators to the database or the object store is cut.
    Store(usize, Duration),
}

/// By how much a coordinator's clock is wrong, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ClockOff(pub(crate) i32);

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::KillWorker(n) => write!(f, "worker {n} is killed"),
            Self::StopWorker(n, t) => write!(f, "worker {n} stands still for {t:?}"),
            Self::KillCoordinator(n, off) => {
                write!(
                    f,
                    "coordinator {n} is killed, its clock then off by {} s",
                    off.0
                )
            }
            Self::StopCoordinator(n, t) => write!(f, "coordinator {n} stands still for {t:?}"),
            Self::Weather(n, weather, t) => write!(f, "line {n}: {weather:?} for {t:?}"),
            Self::Damage(n, damage) => write!(f, "line {n}: the next result is {damage:?}"),
            Self::Store(n, t) => write!(f, "store {n} is cut off for {t:?}"),
        }
    }
}

/// How many of each there are to break.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Breakable {
    pub(crate) workers: usize,
    pub(crate) coordinators: usize,
    pub(crate) stores: usize,
    pub(crate) clocks: bool,
}

/// The next fault.
pub(crate) fn draw(dice: &mut Dice, of: Breakable) -> Fault {
    let worker = dice.below(of.workers);
    let coordinator = dice.below(of.coordinators);
    let mut short = || Duration::from_millis(300 + dice.below(3_000) as u64);
    let (pause, outage) = (short(), short());
    match dice.below(if of.stores > 0 { 11 } else { 10 }) {
        0 | 1 => Fault::KillWorker(worker),
        // Now and then longer than a lease lives.
        2 if dice.below(4) == 0 => Fault::StopWorker(worker, Duration::from_secs(17)),
        2 => Fault::StopWorker(worker, pause),
        3 | 4 => {
            let off = if of.clocks {
                dice.one_of(&[0, 600, -600, 86_400])
            } else {
                0
            };
            Fault::KillCoordinator(coordinator, ClockOff(off))
        }
        5 => Fault::StopCoordinator(coordinator, pause),
        6 => Fault::Damage(worker, Damage::Truncated),
        7 => Fault::Damage(worker, Damage::Flipped(dice.below(1 << 20))),
        8 | 9 => {
            let ms = 50 + dice.below(400) as u64;
            let weather = dice.one_of(&[
                Weather::Parted,
                Weather::Slow { ms },
                Weather::Twice,
                Weather::Shuffled,
                Weather::Deaf,
            ]);
            Fault::Weather(worker, weather, outage)
        }
        _ => Fault::Store(dice.below(of.stores), outage),
    }
}

/// A worker behind a line of its own.
pub(crate) struct Site {
    pub(crate) line: Line,
    pub(crate) worker: Option<Process>,
}

impl Site {
    /// Start a worker of one thread.
    pub(crate) fn start(coordinator: &str) -> Self {
        let line = Line::to(coordinator);
        let worker = Some(worker_for(&line.url, 1));
        Self { line, worker }
    }
}

/// What will be mended, and when.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Mending {
    Worker(usize),
    Wake(Who),
    Coordinator(usize, ClockOff),
    Weather(usize),
    Store(usize),
}

/// Who stands still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Who {
    Worker(usize),
    Coordinator(usize),
}

/// Mendings by their time.
#[derive(Default)]
pub(crate) struct Mendings(Vec<(Instant, Mending)>);

impl Mendings {
    pub(crate) fn after(&mut self, wait: Duration, mending: Mending) {
        self.0.push((Instant::now() + wait, mending));
    }

    /// Those whose time has come; with `all` the others as well.
    pub(crate) fn due(&mut self, all: bool) -> Vec<Mending> {
        let now = Instant::now();
        let (due, later) = std::mem::take(&mut self.0)
            .into_iter()
            .partition(|(at, _)| all || *at <= now);
        self.0 = later;
        due.into_iter().map(|(_, mending)| mending).collect()
    }
}
