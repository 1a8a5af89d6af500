//! A render farm in one binary.
fn main() {}
