//! Ready units are shared out among the workers that ask at the same time.

use super::runs::Unit;
use std::collections::{BTreeMap, VecDeque};

/// One worker's part of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wish {
    /// Worker (instance).
    pub worker: String,
    /// Units at most.
    pub units_max: usize,
    /// Its threads.
    pub threads: u32,
}

/// Which workers failed on a unit.
pub type Failed = BTreeMap<Unit, Vec<String>>;

/// The units of each wish, in the order of `ready`: as many as it wants, first come
/// first served. A unit on which a worker failed is left to the others, until all
/// `present` workers have failed on it; 0 present is a worker that is alone.
#[must_use]
pub fn share_out(
    ready: Vec<Unit>,
    wishes: &[Wish],
    failed: &Failed,
    present: u64,
) -> Vec<Vec<Unit>> {
    let mut left: VecDeque<Unit> = ready.into();
    let withheld = |unit: &Unit, worker: &String| {
        present > 0
            && failed
                .get(unit)
                .is_some_and(|by| by.contains(worker) && (by.len() as u64) < present)
    };
    let mut shares = Vec::with_capacity(wishes.len());
    for wish in wishes {
        let mut share = Vec::new();
        let mut skipped = Vec::new();
        while share.len() < wish.units_max
            && let Some(unit) = left.pop_front()
        {
            if withheld(&unit, &wish.worker) {
                skipped.push(unit);
            } else {
                share.push(unit);
            }
        }
        for unit in skipped.into_iter().rev() {
            left.push_front(unit);
        }
        shares.push(share);
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit(block: u32) -> Unit {
        Unit {
            frame: 0,
            tile: 0,
            block,
        }
    }

    fn wish(worker: &str, units_max: usize) -> Wish {
        Wish {
            worker: worker.into(),
            units_max,
            threads: 1,
        }
    }

    #[test]
    fn first_come_first_served_and_failures_go_to_others() {
        let ready: Vec<Unit> = (0..6).map(unit).collect();
        let failed = Failed::from([(unit(0), vec!["a".into()])]);
        let wishes = [wish("a", 2), wish("b", 3), wish("c", 9)];
        let shares = share_out(ready.clone(), &wishes, &failed, 3);
        let blocks: Vec<Vec<u32>> = shares
            .iter()
            .map(|share| share.iter().map(|unit| unit.block).collect())
            .collect();
        assert_eq!(blocks, [vec![1, 2], vec![0, 3, 4], vec![5]]);
        // Alone, or when everybody has failed: whoever asks tries again.
        assert_eq!(share_out(ready.clone(), &wishes, &failed, 0)[0][0], unit(0));
        assert_eq!(share_out(ready, &wishes, &failed, 1)[0][0], unit(0));
    }

    proptest! {
        #[test]
        fn no_unit_twice_and_none_while_somebody_may_have_it(
            units in 0u32..40,
            sizes in proptest::collection::vec(1usize..12, 0..8),
            failing in proptest::collection::btree_map(0u32..40, 0usize..8, 0..10),
        ) {
            let ready: Vec<Unit> = (0..units).map(unit).collect();
            let wishes: Vec<Wish> = sizes
                .iter()
                .enumerate()
                .map(|(at, &size)| wish(&at.to_string(), size))
                .collect();
            let failed: Failed = failing
                .iter()
                .map(|(block, by)| (unit(*block), vec![by.to_string()]))
                .collect();
            let shares = share_out(ready, &wishes, &failed, 99);
            let mut given: Vec<Unit> = shares.iter().flatten().copied().collect();
            let count = given.len();
            given.sort_unstable();
            given.dedup();
            prop_assert_eq!(given.len(), count);
            for (wish, share) in wishes.iter().zip(&shares) {
                prop_assert!(share.len() <= wish.units_max);
                let own = |unit: &&Unit| failed.get(unit).is_some_and(|by| by.contains(&wish.worker));
                prop_assert_eq!(share.iter().filter(own).count(), 0);
                // Who got less than wanted left only what it may not have or others took later.
                if share.len() < wish.units_max {
                    let left = (0..units).map(unit).filter(|u| !given.contains(u));
                    prop_assert!(left.into_iter().all(|u| own(&&u)));
                }
            }
        }
    }
}
