//! Clouds as formations of semi-opaque ellipsoids or of soft discs. What comes out
//! is a function of the description (and a picture's bytes) alone.

#[cfg(test)]
mod chi_square;
mod draws;
mod image;
mod radial;

pub(crate) use image::{Pixels, PlacedImage};

use crate::geometry::{Ellipsoid, Sprite};
use draws::Draws;
use glam::{DVec3, Vec3};
use shearwater_shared::scene::{ParticleCloud, RadialFormation, SpriteCloud};

/// Where the parts of a cloud are, ready to be drawn from.
pub(crate) enum Places<'a> {
    /// Around a core.
    Radial(&'a RadialFormation),
    /// By a picture.
    Image(PlacedImage<'a>),
}

/// One part of a cloud.
struct Place {
    /// Its centre, in the scene.
    centre_m: DVec3,
    /// Share of the way from the smallest to the largest size, 0 to 1.
    size: f64,
    /// The same for opacity.
    opacity: f64,
}

impl Places<'_> {
    fn draw(&self, draw: &mut Draws) -> Place {
        match self {
            Self::Radial(radial) => radial::place(radial, draw),
            Self::Image(image) => image.place(draw),
        }
    }
}

/// The particles of a cloud, relative to `origin_m`.
pub(crate) fn particles(
    cloud: &ParticleCloud,
    places: &Places<'_>,
    origin_m: DVec3,
) -> impl Iterator<Item = Ellipsoid> {
    (0..cloud.count).map(move |index| {
        let mut draw = Draws::new(cloud.seed, index);
        let place = places.draw(&mut draw);
        let radius = between(cloud.particle_radius_m, place.size);
        let stretch = between(cloud.stretch_x, draw.next());
        Ellipsoid {
            centre: (place.centre_m - origin_m).as_vec3(),
            radii: Vec3::new((radius * stretch) as f32, radius as f32, radius as f32),
            opacity: opacity(cloud.opacity, place.opacity),
        }
    })
}

/// The sprites of a cloud, relative to `origin_m`.
pub(crate) fn sprites(
    cloud: &SpriteCloud,
    places: &Places<'_>,
    origin_m: DVec3,
) -> impl Iterator<Item = Sprite> {
    (0..cloud.count).map(move |index| {
        let mut draw = Draws::new(cloud.seed, index);
        let place = places.draw(&mut draw);
        Sprite {
            centre: (place.centre_m - origin_m).as_vec3(),
            radius: between(cloud.sprite_radius_m, place.size) as f32,
            opacity: opacity(cloud.opacity, place.opacity),
            softness: cloud.softness as f32,
        }
    })
}

fn between([least, most]: [f64; 2], share: f64) -> f64 {
    least + (most - least) * share
}

fn opacity([least, most]: [f32; 2], share: f64) -> f32 {
    // From the larger bound, which a share of 1 gives exactly.
    (most + (least - most) * (1.0 - share) as f32).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::scene::Formation;

    fn radial(radius_m: f64, length_m: f64) -> RadialFormation {
        RadialFormation {
            centre_m: [5.0, 0.0, -3.0],
            radii_m: [radius_m; 3],
            direction: [0.0, 0.0, 2.0],
            length_m,
        }
    }

    fn cloud() -> ParticleCloud {
        ParticleCloud {
            formation: Formation::Radial(radial(1.0, 0.0)),
            count: 20_000,
            particle_radius_m: [0.1, 0.3],
            stretch_x: [1.0, 2.0],
            opacity: [0.2, 0.8],
            albedo: [0.9; 3],
            seed: 3,
        }
    }

    #[test]
    fn particles_keep_their_bounds_and_thin_out() {
        let spread = radial(0.01, 50.0);
        let all: Vec<_> = particles(&cloud(), &Places::Radial(&spread), DVec3::ZERO).collect();
        for p in &all {
            assert!((0.1..=0.3001).contains(&p.radii.y) && p.radii.y == p.radii.z);
            assert!((0.999..=2.001).contains(&(p.radii.x / p.radii.y)));
            assert!((0.2..=0.8).contains(&p.opacity));
        }
        let reach = |p: &Ellipsoid| (p.centre - Vec3::new(5.0, 0.0, -3.0)).length();
        let (near, far): (Vec<&Ellipsoid>, Vec<&Ellipsoid>) =
            all.iter().partition(|p| reach(p) < 25.0);
        let opacity =
            |of: &[&Ellipsoid]| of.iter().map(|p| p.opacity).sum::<f32>() / of.len() as f32;
        assert!(opacity(&near) > opacity(&far) + 0.2);
        assert!(
            all.iter().all(|p| (p.centre.z + 3.0) > -0.02),
            "spreads along +z only"
        );
    }

    #[test]
    fn sprites_keep_their_bounds() {
        let cloud = SpriteCloud {
            formation: Formation::Radial(radial(0.01, 50.0)),
            count: 5_000,
            sprite_radius_m: [2.0, 6.0],
            opacity: [0.1, 0.7],
            softness: 0.5,
            albedo: [0.9; 3],
            g: 0.0,
            seed: 8,
        };
        let spread = radial(0.01, 50.0);
        let all: Vec<_> = sprites(&cloud, &Places::Radial(&spread), DVec3::ZERO).collect();
        assert_eq!(all.len(), 5_000);
        for s in &all {
            assert!((2.0..=6.0).contains(&s.radius) && (0.1..=0.7).contains(&s.opacity));
            assert_eq!(s.softness, 0.5);
        }
        for least in [false, true] {
            let edge = |s: &&Sprite| {
                if least {
                    s.radius < 2.1
                } else {
                    s.radius > 5.9
                }
            };
            assert!(all.iter().find(edge).is_some(), "{least}");
        }
    }

    #[test]
    fn the_same_description_gives_the_same_cloud() {
        let core = radial(1.0, 0.0);
        let of = |cloud: &ParticleCloud| -> Vec<_> {
            particles(cloud, &Places::Radial(&core), DVec3::ONE)
                .flat_map(|p| [p.centre.to_array(), p.radii.to_array(), [p.opacity; 3]])
                .map(|a| a.map(f32::to_bits))
                .collect()
        };
        assert_eq!(of(&cloud()), of(&cloud()));
        assert_ne!(of(&cloud()), of(&ParticleCloud { seed: 4, ..cloud() }));
    }
}
