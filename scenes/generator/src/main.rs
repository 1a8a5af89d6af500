//! Generates the models, textures and skies of the example scenes, bit for bit.
fn main() {}
