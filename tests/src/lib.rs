//! End-to-end tests: the whole farm, real processes, real faults.
