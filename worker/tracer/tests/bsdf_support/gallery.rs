//! Materials that several tests look at.

use glam::Vec3;
use shearwater_tracer::bsdf::microfacet::MIRROR_ALPHA_MAX;
use shearwater_tracer::bsdf::{
    Bsdf, GgxModel, GgxParameters, Layered, Phong, TableNeeds, Tables, Water,
};

use super::metals::layers;

/// Tables for everything here but layers.
pub fn plain_tables() -> Tables {
    Tables::build(&TableNeeds {
        schlick: true,
        etas: vec![ETA],
        ..TableNeeds::default()
    })
    .expect("valid needs")
}

/// Water's index.
pub const ETA: f32 = 1.333;

pub fn metal(alpha: f32) -> GgxParameters {
    GgxParameters {
        base_color: Vec3::ONE,
        metalness: 1.0,
        alpha,
        dielectric_f0: 0.04,
    }
}

pub fn white_dielectric(alpha: f32) -> GgxParameters {
    GgxParameters {
        metalness: 0.0,
        ..metal(alpha)
    }
}

pub fn ggx(tables: &Tables, model: GgxModel, parameters: &GgxParameters) -> Bsdf {
    Bsdf::ggx(tables, model, parameters).expect("valid parameters")
}

pub fn phong(kd: f32, ks: f32, exponent: f32) -> Bsdf {
    Bsdf::Phong(Phong::new(Vec3::splat(kd), Vec3::splat(ks), exponent).expect("valid parameters"))
}

pub fn water(tables: &Tables, color: Vec3, alpha: f32) -> Bsdf {
    Bsdf::Water(Water::new(tables, ETA, color, alpha).expect("valid parameters"))
}

/// One of each kind, narrow and wide, white and coloured.
pub fn gallery(tables: &Tables) -> Vec<(String, Bsdf)> {
    let color = Vec3::new(0.9, 0.5, 0.1);
    let mut all = vec![
        ("lambert".to_owned(), Bsdf::Lambert { albedo: color }),
        ("phong 0".to_owned(), phong(0.3, 0.7, 0.0)),
        ("phong 40".to_owned(), phong(0.3, 0.7, 40.0)),
        ("phong 1e6".to_owned(), phong(0.0, 1.0, 1e6)),
    ];
    for alpha in [0.0, MIRROR_ALPHA_MAX, 0.03, 0.3, 1.0] {
        all.push((format!("water {alpha}"), water(tables, color, alpha)));
        for model in [GgxModel::Corrected, GgxModel::Report] {
            for metalness in [0.0, 0.6, 1.0] {
                let name = format!("{model:?} metal {metalness} alpha {alpha}");
                let parameters = GgxParameters {
                    base_color: color,
                    metalness,
                    ..metal(alpha)
                };
                all.push((name, ggx(tables, model, &parameters)));
            }
        }
    }
    for (i, layer) in layers().into_iter().enumerate() {
        for (metalness, alpha) in [(1.0, 0.0), (1.0, 0.3), (0.5, 0.05)] {
            let parameters = GgxParameters {
                base_color: color,
                metalness,
                alpha,
                dielectric_f0: 0.04,
            };
            let metal = Layered::new(tables, &parameters, &layer).expect("valid parameters");
            let name = format!("layer {i} metal {metalness} alpha {alpha}");
            all.push((name, Bsdf::Layered(metal)));
        }
    }
    all
}
