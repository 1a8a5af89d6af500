//! A farm in which everything fails, by a seed: processes are killed and stopped, the
//! database server as well; cables are pulled and lose packets; results are damaged,
//! come twice, late and shuffled; clocks are wrong, stores are away, disks are full, and
//! a worker computes wrongly. Afterwards every unit of every job is counted once, every
//! film is the right one, and nothing is left over.
//!
//! `tests/chaos` runs the long form. `CHAOS_SEED`, `CHAOS_FAULTS` and `CHAOS_PAIR`
//! (`laptop`, `servers`) choose another run.

#[path = "chaos/audit.rs"]
mod audit;
#[path = "chaos/breaking.rs"]
mod breaking;
#[path = "chaos/database.rs"]
mod database;
#[path = "chaos/dice.rs"]
mod dice;
#[path = "chaos/farm.rs"]
mod farm;
#[path = "chaos/faults.rs"]
mod faults;
#[path = "chaos/lies.rs"]
mod lies;
#[path = "chaos/line.rs"]
mod line;
#[path = "chaos/mending.rs"]
mod mending;
#[path = "chaos/network.rs"]
mod network;
#[path = "chaos/stores.rs"]
mod stores;

mod common;

use common::stores::{Pair, left_out, on_both_pairs};
use farm::{Chaos, faketime};
use std::time::Duration;

/// Faults of the short form: a minute of them.
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
    if faketime().is_none() {
        left_out("chaos: wrong clocks", "no libfaketime");
    }
    let seed = number("CHAOS_SEED", 1);
    let faults = number("CHAOS_FAULTS", FAULTS as u64) as usize;
    println!("seed {seed}, {faults} faults, {pair:?}");
    let mut chaos = Chaos::start(pair, seed);
    println!("{:?}", chaos.breakable());
    let mut jobs = 0;
    let mut job = chaos.submit();
    while chaos.faults < faults {
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
        "{} faults over {} jobs in {:.0} s; {}",
        chaos.faults,
        jobs + 1,
        chaos.now_s(),
        chaos.tally()
    );
    chaos.leaves_nothing(pair);
}
