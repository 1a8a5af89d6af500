//! The farm as a state machine: one tile of a few blocks, workers that render and
//! vanish, replicas of the coordinator that count, fold, sweep and are killed.
//!
//! What is one step here is one step there: a statement or transaction of the store, a
//! write or a deletion of one object. Everything between two steps may be interrupted
//! by any other step, and by a kill. Names of objects are taken again only when
//! nobody remembers them, as if they had a nonce; an object that no row names and
//! nobody remembers is litter, and is forgotten at once, since nothing can depend on
//! when it is swept.

use std::collections::BTreeMap;

/// Blocks of the tile.
pub(crate) const BLOCKS: usize = 2;
const WORKERS: usize = 2;
const REPLICAS: usize = 2;
/// Leases that are open at once: the endgame hands a run out twice.
pub(crate) const LEASES: usize = 2;

/// How often each block is in a sum. Right is at most once.
pub(crate) type Sum = [u8; BLOCKS];
/// The name of an object.
pub(crate) type Name = u8;

/// Blocks `first..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Run {
    pub(crate) first: u8,
    pub(crate) end: u8,
}

impl Run {
    pub(crate) fn blocks(self) -> std::ops::Range<usize> {
        usize::from(self.first)..usize::from(self.end)
    }

    pub(crate) fn sum(self) -> Sum {
        let mut sum = [0; BLOCKS];
        for block in self.blocks() {
            sum[block] = 1;
        }
        sum
    }
}

/// A row of `unit`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Unit {
    /// Nobody renders it.
    Ready,
    /// Handed out under this lease, the newest.
    Leased(u8),
    /// In a part.
    Counted,
}

/// A row of `part`: a counted run, and its sums until they are folded.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Part {
    pub(crate) run: Run,
    pub(crate) object: Option<Name>,
}

/// The row of `tilefold`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Tile {
    pub(crate) version: u8,
    pub(crate) object: Option<Name>,
}

/// A fold that a replica is in the middle of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Fold {
    /// Rows are read.
    Read { seen: Tile, parts: Vec<Part> },
    /// The new film is written, the rows not yet swapped.
    Written {
        seen: Tile,
        parts: Vec<Part>,
        film: Name,
    },
    /// The rows are swapped, these objects are still there.
    Swapped { old: Vec<Name> },
}

/// What one coordinator holds in memory. A kill takes it all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Replica {
    /// A result whose sums are written and that is not counted yet: from whom, what, where.
    pub(crate) result: Option<(u8, Run, Name)>,
    pub(crate) fold: Option<Fold>,
}

/// The whole farm.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Farm {
    pub(crate) units: [Unit; BLOCKS],
    pub(crate) leases: [Option<Run>; LEASES],
    /// A rendered run that the worker keeps until it is acknowledged.
    pub(crate) held: [Option<Run>; WORKERS],
    pub(crate) parts: Vec<Part>,
    pub(crate) tile: Tile,
    /// The finished frame: the sum that was hashed.
    pub(crate) finished: Option<Sum>,
    pub(crate) objects: BTreeMap<Name, Sum>,
    pub(crate) replicas: [Replica; REPLICAS],
    /// A run was acknowledged that is not counted.
    pub(crate) false_word: bool,
}

impl Farm {
    /// A submitted job.
    pub(crate) fn new() -> Self {
        Self {
            units: [Unit::Ready; BLOCKS],
            leases: [None; LEASES],
            held: [None; WORKERS],
            parts: Vec::new(),
            tile: Tile::default(),
            finished: None,
            objects: BTreeMap::new(),
            replicas: std::array::from_fn(|_| Replica::default()),
            false_word: false,
        }
    }

    /// Objects that rows name.
    pub(crate) fn named(&self) -> impl Iterator<Item = Name> + '_ {
        let parts = self.parts.iter().filter_map(|part| part.object);
        parts.chain(self.tile.object)
    }

    /// Objects that some replica is about to name or to read.
    pub(crate) fn in_hand(&self, name: Name) -> bool {
        self.replicas.iter().any(|replica| {
            let result = replica.result.is_some_and(|(.., object)| object == name);
            result
                || match &replica.fold {
                    None => false,
                    Some(Fold::Swapped { old }) => old.contains(&name),
                    Some(Fold::Written { film, parts, seen }) => {
                        *film == name || read_by(seen, parts, name)
                    }
                    Some(Fold::Read { seen, parts }) => read_by(seen, parts, name),
                }
        })
    }

    pub(crate) fn fresh_name(&self) -> Name {
        let taken = |name: &Name| {
            self.objects.contains_key(name)
                || self.named().any(|n| n == *name)
                || self.in_hand(*name)
        };
        (0..).find(|name| !taken(name)).unwrap_or(Name::MAX)
    }

    pub(crate) fn forget_litter(&mut self) {
        let names: Vec<Name> = self.objects.keys().copied().collect();
        for name in names {
            if !self.in_hand(name) && self.named().all(|n| n != name) {
                self.objects.remove(&name);
            }
        }
    }

    // Names say nothing: farms that differ in them alone are one state.
    pub(crate) fn rename(&mut self) {
        let mut new = BTreeMap::new();
        let mut rename = |name: &mut Name| {
            let next = new.len() as Name;
            *name = *new.entry(*name).or_insert(next);
        };
        let of_parts = |parts: &mut Vec<Part>, rename: &mut dyn FnMut(&mut Name)| {
            parts
                .iter_mut()
                .filter_map(|part| part.object.as_mut())
                .for_each(rename);
        };
        of_parts(&mut self.parts, &mut rename);
        self.tile.object.as_mut().map(&mut rename);
        for replica in &mut self.replicas {
            if let Some((.., name)) = &mut replica.result {
                rename(name);
            }
            match &mut replica.fold {
                None => {}
                Some(Fold::Swapped { old }) => old.iter_mut().for_each(&mut rename),
                Some(Fold::Read { seen, parts }) => {
                    of_parts(parts, &mut rename);
                    seen.object.as_mut().map(&mut rename);
                }
                Some(Fold::Written { seen, parts, film }) => {
                    of_parts(parts, &mut rename);
                    seen.object.as_mut().map(&mut rename);
                    rename(film);
                }
            }
        }
        let objects = std::mem::take(&mut self.objects);
        let renamed = |(name, sum): (Name, Sum)| Some((*new.get(&name)?, sum));
        self.objects = objects.into_iter().filter_map(renamed).collect();
    }
}

fn read_by(seen: &Tile, parts: &[Part], name: Name) -> bool {
    seen.object == Some(name) || parts.iter().any(|part| part.object == Some(name))
}
