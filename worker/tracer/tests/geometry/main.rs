//! Rays against geometry with known answers.

mod exact;
mod leave;
mod particles;
mod robust;
mod shapes;
mod sprites;
mod watertight;
