//! Every value out of its range is refused at its place.

mod clouds;
mod motion;
mod sampling;
mod surroundings;
mod things;
