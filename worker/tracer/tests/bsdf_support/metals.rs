//! Metals and coats for tests.

use glam::Vec3;
use shearwater_tracer::bsdf::{CoatParameters, LayerParameters, MetalLaw, TableNeeds, Tables};

/// Index at 650, 550 and 450 nm, rounded (Johnson and Christy 1972).
pub const COPPER: MetalLaw = MetalLaw::Conductor {
    n: Vec3::new(0.21, 1.04, 1.17),
    k: Vec3::new(3.67, 2.59, 2.36),
};
/// Rounded from Rakic 1995.
pub const ALUMINIUM: MetalLaw = MetalLaw::Conductor {
    n: Vec3::new(1.49, 0.96, 0.60),
    k: Vec3::new(7.82, 6.69, 5.48),
};
/// Absorbs nothing: every furnace is at its brightest.
pub const LOSSLESS: MetalLaw = MetalLaw::Conductor {
    n: Vec3::ZERO,
    k: Vec3::splat(3.0),
};
pub const EDGE: MetalLaw = MetalLaw::F82 {
    tint: Vec3::new(0.8, 0.5, 0.2),
};

pub fn coat(weight: f32, alpha: f32) -> CoatParameters {
    CoatParameters {
        weight,
        alpha,
        eta: 1.5,
    }
}

/// Every law, bare and under coats from mirror to rough.
pub fn layers() -> Vec<LayerParameters> {
    let mut all = Vec::new();
    for metal in [MetalLaw::Schlick, EDGE, COPPER, LOSSLESS] {
        for coat in [
            None,
            Some(coat(1.0, 0.0)),
            Some(coat(0.5, 0.0)),
            Some(coat(1.0, 0.05)),
            Some(coat(1.0, 0.4)),
        ] {
            all.push(LayerParameters { metal, coat });
        }
    }
    all
}

/// Tables for [`layers`] and what single tests use besides.
pub fn tables() -> Tables {
    let mut layers = layers();
    for coat in [None, Some(coat(0.0, 0.2))] {
        layers.push(LayerParameters {
            metal: ALUMINIUM,
            coat,
        });
    }
    layers.push(LayerParameters {
        metal: COPPER,
        coat: Some(coat(1.0, 0.2)),
    });
    Tables::build(&TableNeeds {
        schlick: true,
        etas: vec![1.333],
        layers,
    })
    .expect("valid needs")
}
