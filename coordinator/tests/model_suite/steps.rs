//! What can happen next.

use super::farm::{BLOCKS, Farm, Fold, LEASES, Name, Replica, Unit};

/// One step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Worker, length of the run: a lease of what is ready, rendered at once.
    Claim(usize, u8),
    /// Worker, lease: the endgame hands out again what is still open.
    Again(usize, usize),
    /// A lease is over.
    Expire(usize),
    /// A worker is killed.
    KillWorker(usize),
    /// Worker, replica: a result arrives and its sums are written.
    Arrive(usize, usize),
    /// Replica: the transaction; whether the acknowledgement reaches the worker.
    Count(usize, bool),
    /// Replica: the steps of a fold.
    ReadRows(usize),
    WriteFilm(usize),
    Swap(usize),
    DeleteOne(usize),
    /// An object that no row names is swept.
    Sweep(Name),
    /// The frame is hashed.
    Finish,
    /// A coordinator is killed.
    KillReplica(usize),
}

/// How much of a farm there is: all at once would be too many states.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    /// Workers, at most 2.
    pub(crate) workers: usize,
    /// Coordinators on one store, at most 2.
    pub(crate) replicas: usize,
    /// Whether parts are folded; else a frame is finished when all is counted.
    pub(crate) folding: bool,
}

/// A mistake that the design avoids. The exploration must find what each one breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    None,
    /// Units that are free are counted though others of the run are not.
    CountsWhatIsFree,
    /// The row comes before the object.
    RowFirst,
    /// The acknowledgement comes before the transaction.
    AcknowledgesOnArrival,
    /// A fold does not look whether the rows are still those that it read.
    SwapsBlindly,
    /// Old objects are deleted before the rows are swapped.
    DeletesFirst,
    /// The sweep does not wait until nobody can be in the middle of something.
    SweepsAtOnce,
    /// Leases never end.
    NoExpiry,
}

impl Farm {
    /// Every step that can be taken now.
    pub(crate) fn steps(&self, size: Size, flaw: Flaw) -> Vec<Step> {
        let mut steps = Vec::new();
        if self.finished.is_some() {
            return steps;
        }
        let free = self.leases.iter().any(Option::is_none);
        let ready = self.units.contains(&Unit::Ready);
        for worker in 0..size.workers {
            if self.held[worker].is_some() {
                steps.push(Step::KillWorker(worker));
                for replica in 0..size.replicas {
                    if self.replicas[replica].result.is_none() {
                        steps.push(Step::Arrive(worker, replica));
                    }
                }
            } else if free && ready {
                steps.extend((1..=BLOCKS as u8).map(|length| Step::Claim(worker, length)));
            } else if free {
                let whole = (0..LEASES).filter(|&lease| self.is_whole(lease));
                steps.extend(whole.map(|lease| Step::Again(worker, lease)));
            }
        }
        if flaw != Flaw::NoExpiry {
            let open = (0..LEASES).filter(|&lease| self.leases[lease].is_some());
            steps.extend(open.map(Step::Expire));
        }
        for replica in 0..size.replicas {
            self.steps_of(replica, size, &mut steps);
        }
        // The real sweep waits an hour: until nobody can have the object in hand.
        if flaw == Flaw::SweepsAtOnce {
            let unnamed = |name: &Name| self.named().all(|n| n != *name);
            steps.extend(
                self.objects
                    .keys()
                    .copied()
                    .filter(unnamed)
                    .map(Step::Sweep),
            );
        }
        let folded = self.parts.iter().all(|part| part.object.is_none());
        if (folded || !size.folding) && self.units.iter().all(|unit| *unit == Unit::Counted) {
            steps.push(Step::Finish);
        }
        steps
    }

    // A run that is counted in part would be refused for overlapping.
    fn is_whole(&self, lease: usize) -> bool {
        let uncounted = |block: usize| self.units[block] != Unit::Counted;
        self.leases[lease].is_some_and(|run| run.blocks().all(uncounted))
    }

    fn steps_of(&self, replica: usize, size: Size, steps: &mut Vec<Step>) {
        let Replica { result, fold } = &self.replicas[replica];
        if result.is_some() {
            steps.extend([Step::Count(replica, true), Step::Count(replica, false)]);
        }
        match fold {
            None if size.folding && self.parts.iter().any(|part| part.object.is_some()) => {
                steps.push(Step::ReadRows(replica));
            }
            None => {}
            Some(Fold::Read { .. }) => steps.push(Step::WriteFilm(replica)),
            Some(Fold::Written { .. }) => steps.push(Step::Swap(replica)),
            Some(Fold::Swapped { .. }) => steps.push(Step::DeleteOne(replica)),
        }
        if result.is_some() || fold.is_some() {
            steps.push(Step::KillReplica(replica));
        }
    }
}
