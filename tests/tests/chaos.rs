//! A farm in which everything fails, by a seed: processes are killed and stopped,
//! lines are cut, slow and damaged, results come twice, late and shuffled, clocks are
//! wrong, stores are away. Afterwards every unit of every job is counted once, every
//! film is the right one, and nothing is left over.
//!
//! `tests/chaos` runs the long form. `CHAOS_SEED`, `CHAOS_FAULTS` and `CHAOS_PAIR`
//! (`laptop`, `servers`) choose another run.

#[path = "chaos/dice.rs"]
mod dice;
#[path = "chaos/farm.rs"]
mod farm;
#[path = "chaos/faults.rs"]
mod faults;
#[path = "chaos/line.rs"]
mod line;

mod common;

use common::stores::{Pair, on_both_pairs};
use farm::Chaos;
use std::time::Duration;

/// Faults of the short form: half a minute of them.
const FAULTS: usize = 25;

on_both_pairs! {
    nothing_is_lost_and_nothing_is_left;
}

fn number(name: &str, usual: u64) -> u64 {
    let text = std::env::var(name).ok();
    text.map_or(usual, |text| text.parse().expect("a number"))
}

fn nothing_is_lost_and_nothing_is_left(pair: Pair) {
    let only = std::env::var("CHAOS_PAIR").unwrap_or_default();
    if !only.is_empty() && only != format!("{pair:?}").to_lowercase() {
        return;
    }
    let seed = number("CHAOS_SEED", 1);
    let faults = number("CHAOS_FAULTS", FAULTS as u64) as usize;
    println!("seed {seed}, {faults} faults, {pair:?}");
    let mut chaos = Chaos::start(pair, seed);
    let mut jobs = 0;
    let mut job = chaos.submit();
    while chaos.faults() < faults {
        let pause_ms = 200 + 100 * chaos.roll(12) as u64;
        chaos.wait(Duration::from_millis(pause_ms));
        chaos.next_fault();
        if chaos.is_done(&job) {
            chaos.audit(&job);
            jobs += 1;
            job = chaos.submit();
        }
    }
    chaos.mend_all();
    chaos.audit(&job);
    println!(
        "{} faults over {} jobs; {}",
        chaos.faults(),
        jobs + 1,
        chaos.tally()
    );
    chaos.leaves_nothing();
}
