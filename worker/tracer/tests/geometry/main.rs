//! Rays against geometry with known answers.

mod coverage;
mod exact;
mod leave;
mod motion;
mod particles;
mod robust;
mod shapes;
mod sprites;
mod watertight;
