//! Still water with a picture on it, which drifts.

use crate::load::Texture;
use glam::{Vec2, Vec3};
use shearwater_shared::scene::FlatWater;

/// What all frames share.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlatStage {
    /// Number of the texture and metres of a side of it.
    texture: Option<(u32, f64)>,
}

/// The water of one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlatSea {
    texture: Option<Placed>,
}

#[derive(Clone, Copy, Debug)]
struct Placed {
    number: u32,
    per_metre: f32,
    /// Texture coordinates of the render origin, in [0, 1).
    origin: Vec2,
}

impl FlatStage {
    /// `texture` is the number of the texture, if the water names one.
    pub(super) fn new(sea: &FlatWater, texture: Option<u32>) -> Self {
        Self {
            texture: texture.map(|number| (number, sea.texture_size_m)),
        }
    }

    /// `origin_m` is the point of the undrifted picture that lies at the render
    /// origin when the shutter opens.
    pub(super) fn at(&self, origin_m: [f64; 2]) -> FlatSea {
        let place = |(number, size_m): (u32, f64)| {
            let wrap = |v: f64| {
                let sides = v / size_m;
                (sides - libm::floor(sides)) as f32
            };
            Placed {
                number,
                per_metre: (1.0 / size_m) as f32,
                origin: Vec2::from_array(origin_m.map(wrap)),
            }
        };
        FlatSea {
            texture: self.texture.map(place),
        }
    }
}

impl FlatSea {
    /// Colour of the texture at `p` metres from the render origin; its right is +x and its
    /// top is -z. White without a texture.
    #[inline]
    pub(super) fn color(&self, p: Vec2, textures: &[Texture]) -> Vec3 {
        let Some(placed) = &self.texture else {
            return Vec3::ONE;
        };
        let uv = p * placed.per_metre + placed.origin;
        match textures.get(placed.number as usize) {
            Some(texture) => Vec3::from_array(texture.rgb(uv.x, -uv.y)),
            None => Vec3::ONE,
        }
    }
}
