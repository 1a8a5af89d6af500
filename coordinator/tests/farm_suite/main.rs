//! The coordinator as its clients see it: a real listener, made-up workers.

mod assets;
mod audit;
mod conditional;
mod contract;
mod errors;
mod farm;
mod frames;
mod hostile;
mod jobs;
mod leases;
mod pictures;
mod restart;
mod results;
mod steer;
mod stop;
mod webhooks;
