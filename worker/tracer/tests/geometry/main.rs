//! Rays against geometry with known answers.

mod blades;
mod coverage;
mod exact;
mod joints;
mod leave;
mod motion;
mod particles;
mod robust;
mod self_hits;
mod shapes;
mod sprites;
mod watertight;
