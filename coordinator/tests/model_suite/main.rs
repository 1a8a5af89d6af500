//! The state machine of the farm, explored in every order of events for small sizes.

mod apply;
mod audit;
mod explore;
mod farm;
mod steps;

use explore::{Outcome, explore};
use steps::{Flaw, Size};

/// Two workers and two coordinators race to count.
const COUNTING: Size = Size {
    workers: 2,
    replicas: 2,
    folding: false,
};
/// Two coordinators fold what one worker sends.
const FOLDING: Size = Size {
    workers: 1,
    replicas: 2,
    folding: true,
};
/// Two workers send what one coordinator folds.
const SENDING: Size = Size {
    workers: 2,
    replicas: 1,
    folding: true,
};

/// All of it: 12 s of an optimised build.
const WHOLE: Size = Size {
    workers: 2,
    replicas: 2,
    folding: true,
};

// The long form, of the whole, by `MODEL=full cargo test -p shearwater-coordinator --test model_suite`.
fn sizes() -> Vec<Size> {
    match std::env::var("MODEL").as_deref() {
        Ok("full") => vec![WHOLE],
        _ => vec![COUNTING, FOLDING, SENDING],
    }
}

// Workers and coordinators may be killed between any two steps, acknowledgements may
// be lost, leases may end at any moment, results may come twice and late.
#[test]
fn in_every_order_each_block_is_counted_once_and_the_frame_can_be_finished() {
    for size in sizes() {
        match explore(size, Flaw::None) {
            Outcome::Right { states, steps } => {
                println!("{size:?}: {states} states, {steps} steps");
                assert!(states > 1_000, "the model became trivial: {states} states");
            }
            Outcome::Wrong { what, way } => panic!("{size:?}: {what} after {way:#?}"),
            Outcome::Stuck { way } => panic!("{size:?}: stuck for ever after {way:#?}"),
        }
    }
}

// A check that finds nothing proves nothing: every mistake that the design avoids
// must be found.
#[test]
fn every_flaw_is_found() {
    for (size, flaw) in [
        (COUNTING, Flaw::CountsWhatIsFree),
        (COUNTING, Flaw::RowFirst),
        (COUNTING, Flaw::AcknowledgesOnArrival),
        (COUNTING, Flaw::NoExpiry),
        (COUNTING, Flaw::SweepsAtOnce),
        (FOLDING, Flaw::SwapsBlindly),
        (FOLDING, Flaw::DeletesFirst),
        (FOLDING, Flaw::SweepsAtOnce),
    ] {
        match explore(size, flaw) {
            Outcome::Wrong { what, way } => println!("{flaw:?}: {what} after {way:?}"),
            Outcome::Stuck { way } => println!("{flaw:?}: stuck for ever after {way:?}"),
            Outcome::Right { .. } => panic!("{flaw:?} is not found"),
        }
    }
}
