//! The volumes of a scene.

use super::stage::Assets;
use crate::load::load_grid;
use crate::medium::{DensityGrid, Media, Method, Outline, Phase, Volume, bake_ellipsoid};
use glam::{DMat3, DVec3, Vec3};
use shearwater_shared::limits::{OPTICAL_THICKNESS_MAX, VOXELS_MAX};
use shearwater_shared::scene::{
    GridVolume, SceneDescription, SceneError, VolumeCloud, VolumeMethod, VolumeShape,
};

/// The media around `origin_m`. Volumes that hold nothing are left out: a scene of
/// nothing else pays for none.
pub(super) fn build_media(
    description: &SceneDescription,
    assets: &Assets,
    origin_m: DVec3,
) -> Result<Media, SceneError> {
    let mut volumes = Vec::new();
    let mut voxels = 0_usize;
    for (number, cloud) in description.volumes() {
        let path = format!("clouds[{number}]");
        let density = density(cloud, assets, &path)?;
        voxels += density.size().as_u64vec3().element_product() as usize;
        if voxels > VOXELS_MAX {
            let message = format!("{voxels} voxels so far: expected at most {VOXELS_MAX}");
            return Err(SceneError::new("scene.json", path, message));
        }
        let most = cloud.sigma_t_per_m * f64::from(density.max());
        let thickness = most * cloud.shape.longest_m();
        if thickness > OPTICAL_THICKNESS_MAX {
            let message = format!(
                "with densities up to {} the volume is {thickness:.0} mean free paths thick: \
                 expected at most {OPTICAL_THICKNESS_MAX}",
                density.max()
            );
            let path = format!("{path}.sigma_t_per_m");
            return Err(SceneError::new("scene.json", path, message));
        }
        if most > 0.0 {
            volumes.push(place(cloud, density, origin_m));
        }
    }
    Ok(Media::new(volumes))
}

fn density(cloud: &VolumeCloud, assets: &Assets, path: &str) -> Result<DensityGrid, SceneError> {
    match &cloud.shape {
        VolumeShape::Ellipsoid(shape) => bake_ellipsoid(shape).ok_or_else(|| {
            let message = "the noise of this shape leaves the numbers: expected a larger scale_m";
            SceneError::new("scene.json", format!("{path}.shape"), message)
        }),
        VolumeShape::Grid(GridVolume { file, .. }) => {
            let path = format!("{path}.shape.file");
            let Some(bytes) = assets.get(file) else {
                let message = "the file was not supplied with the scene";
                return Err(SceneError::new(file, path, message));
            };
            load_grid(file, &path, bytes)
        }
    }
}

// Placed in f64, so that a far origin costs nothing.
fn place(cloud: &VolumeCloud, density: DensityGrid, origin_m: DVec3) -> Volume {
    let (centre_m, size_m, turn_deg, outline) = match &cloud.shape {
        VolumeShape::Ellipsoid(shape) => {
            let size = DVec3::from_array(shape.radii_m) * 2.0;
            (shape.centre_m, size, 0.0, Outline::Ellipsoid)
        }
        VolumeShape::Grid(shape) => {
            let size = DVec3::from_array(shape.size_m);
            (shape.centre_m, size, shape.rotate_y_deg, Outline::Box)
        }
    };
    let turn = turn_deg.to_radians();
    let (sin, cos) = (libm::sin(turn), libm::cos(turn));
    // Turned back about +y, then counted in voxels.
    let turned_back = DMat3::from_cols(
        DVec3::new(cos, 0.0, sin),
        DVec3::Y,
        DVec3::new(-sin, 0.0, cos),
    );
    let to_voxels = DMat3::from_diagonal(density.size().as_dvec3() / size_m);
    Volume {
        density,
        sigma_t_per_m: cloud.sigma_t_per_m as f32,
        phase: Phase {
            albedo: Vec3::from_array(cloud.albedo),
            g: cloud.g,
        },
        method: match cloud.method {
            VolumeMethod::Tracking(_) => Method::Tracking,
            VolumeMethod::March(march) => Method::March {
                step_m: march.step_m as f32,
            },
        },
        outline,
        centre: (DVec3::from_array(centre_m) - origin_m).as_vec3(),
        voxels_from_world: (to_voxels * turned_back).as_mat3(),
    }
}
