//! What the fuzz targets do with an input, and what must be true of the outcome.
//!
//! One file for each target. A target panics where the product does, and where an
//! outcome is wrong: then libFuzzer keeps the input, and so does the replay
//! (`tests/tests/fuzz_corpus.rs`), which includes this file.

// Each of the two that include it uses only a part.
#![allow(dead_code, unreachable_pub)]

mod farm;
mod film;
mod images;
mod obj_mtl;
mod pixel;
mod query;
mod request;
mod scene;
mod wire;

pub use film::film;
pub use images::images;
pub use obj_mtl::obj_mtl;
pub use query::{end, query};
pub use scene::scene;
pub use wire::wire;

/// A target: what it does with one input.
pub type Target = fn(&[u8]);

/// Every target by name, for the replay.
pub const TARGETS: [(&str, Target); 6] = [
    ("wire", wire),
    ("film", film),
    ("scene", scene),
    ("obj_mtl", obj_mtl),
    ("images", images),
    ("query", query),
];
