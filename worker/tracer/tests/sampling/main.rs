//! Every way to sample paths gives the same light, and the ways differ in noise as
//! theory says.

mod common;
mod means;
mod variances;
