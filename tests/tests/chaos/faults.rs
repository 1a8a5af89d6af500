//! What goes wrong.

use super::dice::Dice;
use super::line::{Damage, Weather};
use super::network::Cable;
use std::fmt;
use std::time::Duration;

/// One thing that goes wrong. Workers, coordinators and stores have numbers.
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
    /// A worker computes wrongly, until it is replaced.
    Lie(usize, Duration),
    /// A bad cable, of a worker or (behind them) a coordinator.
    Cable(usize, Cable, Duration),
    /// The line of one coordinator, or of all, to a store is cut or falls silent.
    Store(Line, Duration),
    /// SIGKILL of the database server with all its processes.
    KillDatabase,
    /// SIGSTOP of them all.
    StopDatabase(Duration),
    /// SIGSTOP of the object store.
    StopObjects(Duration),
    /// The disk is full.
    FullDisk(Duration),
}

/// Lines from coordinators to a store.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Which store: 0 is the database.
    pub(crate) store: usize,
    /// Only this one's.
    pub(crate) coordinator: Option<usize>,
    /// Connections stay, but nothing comes through.
    pub(crate) silent: bool,
}

/// By how much a coordinator's clock is wrong, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ClockOff(pub(crate) i32);

impl Fault {
    /// Its name in the tally.
    pub(crate) fn kind(&self) -> String {
        let text = format!("{self:?}");
        let kind = |text: &str| text.split(['(', ' ']).next().unwrap_or_default().to_owned();
        match self {
            Self::KillCoordinator(_, off) if off.0 != 0 => "KillCoordinator+clock".to_owned(),
            Self::Weather(_, weather, _) => kind(&format!("{weather:?}")),
            Self::Damage(_, damage) => kind(&format!("{damage:?}")),
            Self::Cable(_, cable, _) => format!("Cable{}", kind(&format!("{cable:?}"))),
            _ => kind(&text),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::KillWorker(n) => write!(f, "worker {n} is killed"),
            Self::StopWorker(n, t) => write!(f, "worker {n} stands still for {t:?}"),
            Self::KillCoordinator(n, off) => {
                let off = off.0;
                write!(
                    f,
                    "coordinator {n} is killed, its clock then off by {off} s"
                )
            }
            Self::StopCoordinator(n, t) => write!(f, "coordinator {n} stands still for {t:?}"),
            Self::Weather(n, weather, t) => write!(f, "line {n}: {weather:?} for {t:?}"),
            Self::Damage(n, damage) => write!(f, "line {n}: the next result is {damage:?}"),
            Self::Lie(n, t) => write!(f, "worker {n} computes wrongly for {t:?}"),
            Self::Cable(n, cable, t) => write!(f, "cable {n}: {cable:?} for {t:?}"),
            Self::Store(line, t) => write!(f, "{line:?} is cut off for {t:?}"),
            Self::KillDatabase => write!(f, "the database server is killed"),
            Self::StopDatabase(t) => write!(f, "the database server stands still for {t:?}"),
            Self::StopObjects(t) => write!(f, "the object store stands still for {t:?}"),
            Self::FullDisk(t) => write!(f, "the disk is full for {t:?}"),
        }
    }
}

/// What there is to break.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Breakable {
    pub(crate) workers: usize,
    pub(crate) coordinators: usize,
    /// Lines to stores; none on a laptop.
    pub(crate) stores: usize,
    /// Servers that may be killed or stand still.
    pub(crate) servers: bool,
    /// A small disk.
    pub(crate) disk: bool,
    /// Cables.
    pub(crate) rooms: bool,
    /// Clocks can be wrong.
    pub(crate) clocks: bool,
}

/// The kinds, as often as they come.
#[derive(Clone, Copy)]
enum Kind {
    KillWorker,
    StopWorker,
    KillCoordinator,
    StopCoordinator,
    Damage,
    Weather,
    Lie,
    Cable,
    Store,
    KillDatabase,
    StopServer,
    FullDisk,
}

fn kinds(of: Breakable) -> Vec<Kind> {
    use Kind::*;
    let mut kinds = vec![
        KillWorker,
        KillWorker,
        StopWorker,
        KillCoordinator,
        KillCoordinator,
        StopCoordinator,
        Damage,
        Damage,
        Weather,
        Weather,
        Lie,
    ];
    if of.rooms {
        kinds.extend([Cable, Cable]);
    }
    if of.stores > 0 {
        kinds.extend([Store, Store]);
    }
    if of.servers {
        kinds.extend([KillDatabase, KillDatabase, StopServer]);
    }
    if of.disk {
        kinds.extend([FullDisk, FullDisk]);
    }
    kinds
}

/// The next fault.
pub(crate) fn draw(dice: &mut Dice, of: Breakable) -> Fault {
    let kind = dice.one_of(&kinds(of));
    let worker = dice.below(of.workers);
    let coordinator = dice.below(of.coordinators);
    let short = Duration::from_millis(300 + dice.below(3_000) as u64);
    match kind {
        Kind::KillWorker => Fault::KillWorker(worker),
        // Now and then longer than a lease lives.
        Kind::StopWorker if dice.below(4) == 0 => {
            Fault::StopWorker(worker, Duration::from_secs(17))
        }
        Kind::StopWorker => Fault::StopWorker(worker, short),
        Kind::KillCoordinator => {
            let offs: &[i32] = if of.clocks {
                &[0, 0, 600, -600, 86_400]
            } else {
                &[0]
            };
            Fault::KillCoordinator(coordinator, ClockOff(dice.one_of(offs)))
        }
        Kind::StopCoordinator => Fault::StopCoordinator(coordinator, short),
        Kind::Damage => {
            let flipped = Damage::Flipped(dice.below(1 << 20));
            Fault::Damage(worker, dice.one_of(&[Damage::Truncated, flipped]))
        }
        Kind::Weather => Fault::Weather(worker, weather(dice), short),
        // Long enough for a result or two.
        Kind::Lie => Fault::Lie(worker, Duration::from_secs(3) + short),
        Kind::Cable => {
            let whose = dice.below(of.workers + of.coordinators);
            Fault::Cable(whose, cable(dice), short)
        }
        Kind::Store => Fault::Store(line(dice, of), short),
        Kind::KillDatabase => Fault::KillDatabase,
        Kind::StopServer => dice.one_of(&[Fault::StopDatabase(short), Fault::StopObjects(short)]),
        Kind::FullDisk => Fault::FullDisk(short),
    }
}

fn weather(dice: &mut Dice) -> Weather {
    let ms = 50 + dice.below(400) as u64;
    dice.one_of(&[
        Weather::Parted,
        Weather::Slow { ms },
        Weather::Twice,
        Weather::Shuffled,
        Weather::Deaf,
    ])
}

fn cable(dice: &mut Dice) -> Cable {
    let one_in = 3 + dice.below(10) as u32;
    let kbit_s = 200 + dice.below(4_000) as u32;
    dice.one_of(&[
        Cable::Pulled,
        Cable::Lossy { one_in },
        Cable::Narrow { kbit_s },
    ])
}

fn line(dice: &mut Dice, of: Breakable) -> Line {
    let whose = dice.below(of.coordinators + 1);
    Line {
        store: dice.below(of.stores),
        coordinator: (whose < of.coordinators).then_some(whose),
        silent: dice.below(3) == 0,
    }
}
