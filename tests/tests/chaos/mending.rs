//! When what went wrong is mended.

use super::faults::{ClockOff, Line};
use std::time::{Duration, Instant};

/// What will be mended.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Mending {
    /// A killed worker comes back.
    Worker(usize),
    /// A worker that computes wrongly is replaced.
    Honest(usize),
    /// A killed coordinator comes back.
    Coordinator(usize, ClockOff),
    /// Who stands still goes on.
    Wake(Who),
    Weather(usize),
    Cable(usize),
    Store(Line),
    Database,
    Disk,
}

/// Who stands still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Who {
    Worker(usize),
    Coordinator(usize),
    Database,
    Objects,
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
