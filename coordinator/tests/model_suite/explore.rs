//! Every order of events, by breadth: the shortest way to a mistake is found first.

use super::audit::audit;
use super::farm::Farm;
use super::steps::{Flaw, Size, Step};
use std::collections::HashMap;

/// States that an exploration may see: a few times those of the sizes in use, some GiB.
const STATES_MAX: usize = 4_000_000;

/// What an exploration found.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// All states are right, and the frame can be finished from each.
    Right { states: usize, steps: usize },
    /// A state is wrong: what, and the way there.
    Wrong { what: &'static str, way: Vec<Step> },
    /// The frame can never be finished from here: the way there.
    Stuck { way: Vec<Step> },
}

/// Explores everything that can happen to a farm of `size` with `flaw`.
pub(crate) fn explore(size: Size, flaw: Flaw) -> Outcome {
    let mut numbers = HashMap::from([(Farm::new(), 0usize)]);
    let mut farms = vec![Farm::new()];
    // Whence each state came first, and whence at all.
    let mut came: Vec<Option<(usize, Step)>> = vec![None];
    let mut before: Vec<Vec<u32>> = vec![Vec::new()];
    let (mut next, mut steps) = (0, 0);
    while next < farms.len() {
        assert!(farms.len() <= STATES_MAX, "more states than the limit");
        let farm = farms[next].clone();
        if let Err(what) = audit(&farm) {
            let way = way(&came, next);
            return Outcome::Wrong { what, way };
        }
        for step in farm.steps(size, flaw) {
            steps += 1;
            let after = farm.after(step, flaw);
            let number = *numbers.entry(after).or_insert_with_key(|after| {
                farms.push(after.clone());
                came.push(Some((next, step)));
                before.push(Vec::new());
                farms.len() - 1
            });
            before[number].push(next as u32);
        }
        next += 1;
    }
    match stuck(&farms, &before) {
        Some(state) => Outcome::Stuck {
            way: way(&came, state),
        },
        None => Outcome::Right {
            states: farms.len(),
            steps,
        },
    }
}

// The first state from which no finished one is reached: backwards from those.
fn stuck(farms: &[Farm], before: &[Vec<u32>]) -> Option<usize> {
    let mut ends: Vec<bool> = farms.iter().map(|farm| farm.finished.is_some()).collect();
    let mut open: Vec<usize> = (0..farms.len()).filter(|&n| ends[n]).collect();
    while let Some(state) = open.pop() {
        for &earlier in &before[state] {
            let earlier = earlier as usize;
            if !ends[earlier] {
                ends[earlier] = true;
                open.push(earlier);
            }
        }
    }
    ends.iter().position(|ends| !ends)
}

fn way(came: &[Option<(usize, Step)>], mut state: usize) -> Vec<Step> {
    let mut way = Vec::new();
    while let Some((earlier, step)) = came[state] {
        way.push(step);
        state = earlier;
    }
    way.reverse();
    way
}
