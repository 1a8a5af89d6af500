//! Rays against geometry with known answers.

mod exact;
mod leave;
mod motion;
mod particles;
mod robust;
mod shapes;
mod sprites;
mod watertight;
