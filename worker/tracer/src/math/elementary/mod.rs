//! Elementary functions in f32 whose bits depend on nothing but the argument.
//!
//! The platform's `sin`, `exp`, `pow`, ... pick other code on other processors
//! and change with the C library's version. These use `+ - * /`, `sqrt`,
//! comparisons, integer bit operations and literal tables only. All of those
//! are exactly rounded by IEEE 754, and the compiler neither contracts nor
//! reorders them, so every x86-64 processor gives the same bits.
//!
//! Most work in f64 inside: one rounding at the end then leaves about half a
//! unit in the last place, and f64 has room for every f32, subnormals included.
//!
//! | function | max error, ulp | range |
//! |---|---|---|
//! | [`sin`], [`cos`], [`sin_cos`] | 0.51 | below 1000; absolute 6e-8 below 1e6, 3e-7 below 1e9 |
//! | [`sin_cos_quarter`] | 1.5 | below pi/4 |
//! | [`sin_cos_turns`] | absolute 3e-11, in f64 | below 2^40 turns |
//! | [`reduce_quarters`], then [`sin_cos_reduced`] | 1.5 + the f32 angle's | below 2^50 quarter turns |
//! | [`exp`], [`expm1`] | 0.51 | all |
//! | [`ln`], [`log1p`] | 0.51 | all |
//! | [`powf`] | 0.52 | `x >= 0` |
//! | [`atan2`], [`acos`], [`asin`] | 0.51 | all |
//!
//! NaN in gives NaN out. `tests/math_elementary.rs` measures the table and
//! holds a hash of the output bits.

mod exponential;
mod inverse_trig;
mod trig;

pub use exponential::{exp, expm1, ln, log1p, powf};
pub use inverse_trig::{acos, asin, atan2};
pub use trig::{
    cos, reduce_quarters, sin, sin_cos, sin_cos_quarter, sin_cos_reduced, sin_cos_turns,
};
