//! The clouds of a scene.

use super::stage::{Assets, BuildReport, geometry_error};
use super::transform::rotation;
use crate::cloud::{self, Pixels, PlacedImage, Places};
use crate::geometry::{Ellipsoid, Particles, Sprite, Sprites};
use crate::load::load_cloud_image;
use glam::{DVec3, Vec3};
use shearwater_shared::limits::{CLOUD_PIXELS_ALL_MAX, PARTICLES_MAX};
use shearwater_shared::scene::{Cloud, Formation, SceneDescription, SceneError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Clouds that are made of parts.
#[derive(Default)]
pub(super) struct Clouds {
    pub(super) particles: Option<Arc<Particles>>,
    pub(super) sprites: Option<Arc<Sprites>>,
    pub(super) shading: CloudShading,
}

/// What shading needs of clouds.
#[derive(Default)]
pub(super) struct CloudShading {
    /// By cloud.
    pub(super) albedo: Vec<Vec3>,
    /// Asymmetry of the phase function, by cloud.
    pub(super) g: Vec<f32>,
    /// The cloud of each particle and of each sprite.
    pub(super) of_particle: Vec<u16>,
    pub(super) of_sprite: Vec<u16>,
}

/// Parts wholly under the water can be neither seen nor shadow anything.
pub(super) fn build_clouds(
    description: &SceneDescription,
    assets: &Assets,
    origin: DVec3,
    report: &mut BuildReport,
) -> Result<Clouds, SceneError> {
    let pictures = load_pictures(description, assets, report)?;
    let floor = description
        .water
        .as_ref()
        .map(|water| (water.look().height_m - origin.y) as f32);
    let is_seen = |top: f32| floor.is_none_or(|y| top > y);
    let mut ellipsoids: Vec<Ellipsoid> = Vec::new();
    let mut discs: Vec<Sprite> = Vec::new();
    let mut shading = CloudShading::default();
    for (number, cloud) in description.clouds.iter().enumerate() {
        let path = format!("clouds[{number}]");
        let owner = u16::try_from(number)
            .map_err(|_| SceneError::new("scene.json", &*path, "at most 65536 clouds"))?;
        let (albedo, g) = match cloud {
            Cloud::Particles(cloud) => (cloud.albedo, 0.0),
            Cloud::Sprites(cloud) => (cloud.albedo, cloud.g as f32),
            // Built apart: it has no parts.
            Cloud::Volume(cloud) => (cloud.albedo, cloud.g),
        };
        shading.albedo.push(Vec3::from_array(albedo));
        shading.g.push(g);
        let Some(places) = cloud.formation().and_then(|f| places(f, &pictures)) else {
            continue;
        };
        match cloud {
            Cloud::Particles(cloud) => {
                let all = cloud::particles(cloud, &places, origin);
                ellipsoids.extend(all.filter(|p| is_seen(p.centre.y + p.radii.y)));
            }
            Cloud::Sprites(cloud) => {
                let all = cloud::sprites(cloud, &places, origin);
                discs.extend(all.filter(|s| is_seen(s.centre.y + s.radius)));
            }
            Cloud::Volume(_) => {}
        }
        shading.of_particle.resize(ellipsoids.len(), owner);
        shading.of_sprite.resize(discs.len(), owner);
        if ellipsoids.len() + discs.len() > PARTICLES_MAX {
            let message = format!("more than {PARTICLES_MAX} particles and sprites in all");
            return Err(SceneError::new("scene.json", path, message));
        }
    }
    report.particles = ellipsoids.len();
    report.sprites = discs.len();
    let failed = |e| geometry_error("clouds", &e);
    let particles = (!ellipsoids.is_empty()).then(|| Particles::build(&ellipsoids));
    let sprites = (!discs.is_empty()).then(|| Sprites::build(discs));
    Ok(Clouds {
        particles: particles.transpose().map_err(failed)?.map(Arc::new),
        sprites: sprites.transpose().map_err(failed)?.map(Arc::new),
        shading,
    })
}

/// The pictures that clouds are formed by, each read once.
fn load_pictures<'a>(
    description: &'a SceneDescription,
    assets: &Assets,
    report: &mut BuildReport,
) -> Result<BTreeMap<&'a str, Pixels>, SceneError> {
    let mut pictures = BTreeMap::new();
    let mut pixels_all = 0;
    for (number, cloud) in description.clouds.iter().enumerate() {
        let Some(Formation::Image(image)) = cloud.formation() else {
            continue;
        };
        let file = image.file.as_str();
        if pictures.contains_key(file) {
            continue;
        }
        let place = format!("clouds[{number}].formation.file");
        let bytes = assets.get(file).ok_or_else(|| {
            SceneError::new(file, &*place, "the file was not supplied with the scene")
        })?;
        let picture = load_cloud_image(file, bytes)?;
        pixels_all += u64::from(picture.width) * u64::from(picture.height);
        if pixels_all > CLOUD_PIXELS_ALL_MAX {
            let message = format!(
                "with this picture the clouds' pictures have {pixels_all} pixels: at most \
                 {CLOUD_PIXELS_ALL_MAX} in all"
            );
            return Err(SceneError::new(file, place, message));
        }
        if picture.bad_texels > 0 {
            let bad = picture.bad_texels;
            report.notes.push(format!(
                "cloud {file}: {bad} texels that are no density are black"
            ));
        }
        let pixels = Pixels::new(&picture).ok_or_else(|| {
            let message = "black or transparent everywhere: expected a picture whose bright \
                           places say where the cloud is";
            SceneError::new(file, place, message)
        })?;
        pictures.insert(file, pixels);
    }
    Ok(pictures)
}

fn places<'a>(
    formation: &'a Formation,
    pictures: &'a BTreeMap<&str, Pixels>,
) -> Option<Places<'a>> {
    Some(match formation {
        Formation::Radial(radial) => Places::Radial(radial),
        Formation::Image(image) => {
            let pixels = pictures.get(image.file.as_str())?;
            Places::Image(PlacedImage::new(image, pixels, rotation(image.rotate_deg)))
        }
    })
}
