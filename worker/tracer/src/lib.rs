//! The path tracer: scene in, exact sums out.
