//! What each step does.

use super::farm::{BLOCKS, Farm, Fold, LEASES, Name, Part, Replica, Run, Sum, Tile, Unit};
use super::steps::{Flaw, Step};

impl Farm {
    /// The farm after a step.
    pub(crate) fn after(&self, step: Step, flaw: Flaw) -> Self {
        let mut farm = self.clone();
        match step {
            Step::Claim(worker, length) => farm.claim(worker, length),
            Step::Again(worker, lease) => farm.again(worker, lease),
            Step::Expire(lease) => farm.expire(lease),
            Step::KillWorker(worker) => farm.held[worker] = None,
            Step::Arrive(worker, replica) => farm.arrive(worker, replica, flaw),
            Step::Count(replica, heard) => farm.count(replica, heard, flaw),
            Step::ReadRows(replica) => farm.read_rows(replica),
            Step::WriteFilm(replica) => farm.write_film(replica, flaw),
            Step::Swap(replica) => farm.swap(replica, flaw),
            Step::DeleteOne(replica) => farm.delete_one(replica),
            Step::Sweep(name) => drop(farm.objects.remove(&name)),
            Step::Finish => {
                let named: Vec<Name> = farm.named().collect();
                let mut sum = [0; BLOCKS];
                for object in named.iter().filter_map(|name| farm.objects.get(name)) {
                    add(&mut sum, object);
                }
                farm.finished = Some(sum);
            }
            Step::KillReplica(replica) => farm.replicas[replica] = Replica::default(),
        }
        farm.forget_litter();
        farm.rename();
        farm
    }

    // `store/claim`: the first run of ready units, one transaction.
    fn claim(&mut self, worker: usize, length: u8) {
        let Some(lease) = self.leases.iter().position(Option::is_none) else {
            return;
        };
        let Some(first) = self.units.iter().position(|unit| *unit == Unit::Ready) else {
            return;
        };
        let mut end = first;
        while end < BLOCKS && end - first < usize::from(length) && self.units[end] == Unit::Ready {
            self.units[end] = Unit::Leased(lease as u8);
            end += 1;
        }
        let run = Run {
            first: first as u8,
            end: end as u8,
        };
        self.leases[lease] = Some(run);
        self.held[worker] = Some(run);
    }

    // `store/claim::reissue`: another lease on the same run.
    fn again(&mut self, worker: usize, lease: usize) {
        let (Some(run), Some(other)) = (
            self.leases[lease],
            self.leases.iter().position(Option::is_none),
        ) else {
            return;
        };
        for block in run.blocks() {
            self.units[block] = Unit::Leased(other as u8);
        }
        self.leases[other] = Some(run);
        self.held[worker] = Some(run);
    }

    // `store/leases::expire`: only stops waiting. The worker may still come.
    fn expire(&mut self, lease: usize) {
        self.leases[lease] = None;
        for unit in &mut self.units {
            if *unit == Unit::Leased(lease as u8) {
                *unit = Unit::Ready;
            }
        }
    }

    fn arrive(&mut self, worker: usize, replica: usize, flaw: Flaw) {
        let Some(run) = self.held[worker] else {
            return;
        };
        let name = self.fresh_name();
        self.replicas[replica].result = Some((worker as u8, run, name));
        match flaw {
            // The object will be written by whoever finds the row.
            Flaw::RowFirst => {}
            _ => drop(self.objects.insert(name, run.sum())),
        }
        if flaw == Flaw::AcknowledgesOnArrival {
            self.acknowledge(worker, run);
        }
    }

    // `store/commit`: all units of the run are counted, or none.
    fn count(&mut self, replica: usize, heard: bool, flaw: Flaw) {
        let Some((worker, run, object)) = self.replicas[replica].result.take() else {
            return;
        };
        let uncounted = |block: usize| self.units[block] != Unit::Counted;
        let all = run.blocks().all(uncounted);
        let any = run.blocks().any(uncounted);
        if all || (flaw == Flaw::CountsWhatIsFree && any) {
            for block in run.blocks() {
                self.units[block] = Unit::Counted;
            }
            let object = Some(object);
            self.parts.push(Part { run, object });
            self.parts.sort_by_key(|part| part.run);
        } else {
            // A repetition, or in part counted by others: its free units go back.
            self.objects.remove(&object);
            for block in run.blocks() {
                if self.units[block] != Unit::Counted {
                    self.units[block] = Unit::Ready;
                }
            }
        }
        self.close_leases();
        if heard && self.held[usize::from(worker)] == Some(run) {
            // What overlaps is refused: the worker is told to drop it, not that it counts.
            if self.parts.iter().any(|part| part.run == run) {
                self.acknowledge(usize::from(worker), run);
            }
            self.held[usize::from(worker)] = None;
        }
    }

    fn acknowledge(&mut self, worker: usize, run: Run) {
        self.false_word |= self.parts.iter().all(|part| part.run != run);
        self.held[worker] = None;
    }

    // A lease without a unit of its own has ended.
    fn close_leases(&mut self) {
        for lease in 0..LEASES {
            let own = Unit::Leased(lease as u8);
            if !self.units.contains(&own) {
                self.leases[lease] = None;
            }
        }
    }

    fn read_rows(&mut self, replica: usize) {
        let open = self.parts.iter().filter(|part| part.object.is_some());
        self.replicas[replica].fold = Some(Fold::Read {
            seen: self.tile.clone(),
            parts: open.cloned().collect(),
        });
    }

    fn write_film(&mut self, replica: usize, flaw: Flaw) {
        let Some(Fold::Read { seen, parts }) = self.replicas[replica].fold.take() else {
            return;
        };
        let names = parts
            .iter()
            .filter_map(|part| part.object)
            .chain(seen.object);
        let names: Vec<Name> = names.collect();
        let mut film = [0; BLOCKS];
        for name in &names {
            // Another replica was faster and has deleted it: from the beginning.
            let Some(sum) = self.objects.get(name) else {
                return;
            };
            add(&mut film, sum);
        }
        let name = self.fresh_name();
        self.objects.insert(name, film);
        if flaw == Flaw::DeletesFirst {
            for name in names {
                self.objects.remove(&name);
            }
        }
        self.replicas[replica].fold = Some(Fold::Written {
            seen,
            parts,
            film: name,
        });
    }

    // `store/folds::swap_film`: compare and exchange.
    fn swap(&mut self, replica: usize, flaw: Flaw) {
        let Some(Fold::Written { seen, parts, film }) = self.replicas[replica].fold.take() else {
            return;
        };
        if self.tile.version != seen.version && flaw != Flaw::SwapsBlindly {
            self.objects.remove(&film);
            return;
        }
        let old = parts
            .iter()
            .filter_map(|part| part.object)
            .chain(seen.object);
        self.replicas[replica].fold = Some(Fold::Swapped { old: old.collect() });
        self.tile = Tile {
            version: seen.version + 1,
            object: Some(film),
        };
        for row in &mut self.parts {
            if parts.contains(row) {
                row.object = None;
            }
        }
    }

    fn delete_one(&mut self, replica: usize) {
        let Some(Fold::Swapped { old }) = &mut self.replicas[replica].fold else {
            return;
        };
        if let Some(name) = old.pop() {
            self.objects.remove(&name);
        }
        if old.is_empty() {
            self.replicas[replica].fold = None;
        }
    }
}

fn add(total: &mut Sum, part: &Sum) {
    for (total, part) in total.iter_mut().zip(part) {
        *total += part;
    }
}
