//! What `simulate` is made of: a coordinator beside it, gauges on it, an audit, a
//! report.

pub(crate) mod audit;
pub(crate) mod child;
pub(crate) mod gauge;
pub(crate) mod report;
pub(crate) mod running;
pub(crate) mod work;
