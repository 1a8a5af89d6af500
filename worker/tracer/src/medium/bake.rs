//! The density of an ellipsoid of noise, computed once.

use super::density::DensityGrid;
use super::noise::Fbm;
use glam::{DVec3, UVec3};
use rayon::prelude::*;
use shearwater_shared::scene::{EllipsoidVolume, VolumeNoise};

/// How much of its deviation the noise shows: beyond about two deviations it is cut
/// off.
const CONTRAST: f64 = 0.5;

/// The density in an ellipsoid, 0 to 1, on the grid of its bounding box.
///
/// From the rim inwards the shape rises from 0 to 1 over `edge` of the radius; noise
/// then eats into it: `(shape - eaten) / (1 - eaten)`, `eaten` being at most the
/// amplitude (the remapping of Schneider and Vos 2015, "The real-time volumetric
/// cloudscapes of Horizon: Zero Dawn"). So the density is 0 at the rim whatever the
/// noise, and without noise and edge it is 1 everywhere: one voxel says it all.
#[must_use]
pub fn bake_ellipsoid(shape: &EllipsoidVolume) -> Option<DensityGrid> {
    let noise = shape.noise.as_ref().filter(|n| n.amplitude > 0.0);
    if shape.edge == 0.0 && noise.is_none() {
        return DensityGrid::new(UVec3::ONE, vec![1.0]);
    }
    let size = voxels(shape);
    let radii = DVec3::from_array(shape.radii_m);
    let (width, slice) = (size.x as usize, size.x as usize * size.y as usize);
    let mut values = vec![0.0f32; slice * size.z as usize];
    // Each voxel is a function of its place alone: threads leave no trace.
    values
        .par_chunks_mut(slice)
        .zip(0..size.z)
        .for_each(|(values, z)| {
            for (i, value) in values.iter_mut().enumerate() {
                let voxel = UVec3::new((i % width) as u32, (i / width) as u32, z);
                let in_ball = (voxel.as_dvec3() + 0.5) / size.as_dvec3() * 2.0 - 1.0;
                *value = density(shape, noise, in_ball, in_ball * radii) as f32;
            }
        });
    DensityGrid::new(size, values)
}

fn voxels(shape: &EllipsoidVolume) -> UVec3 {
    let longest = shape.radii_m.into_iter().fold(0.0, f64::max);
    let along = |r: f64| libm::ceil(f64::from(shape.resolution) * r / longest).max(1.0) as u32;
    UVec3::from_array(shape.radii_m.map(along))
}

fn density(
    shape: &EllipsoidVolume,
    noise: Option<&VolumeNoise>,
    in_ball: DVec3,
    p_m: DVec3,
) -> f64 {
    let depth = 1.0 - in_ball.length();
    let solid = if shape.edge > 0.0 {
        (depth / shape.edge).clamp(0.0, 1.0)
    } else {
        1.0
    };
    let Some(noise) = noise.filter(|_| solid > 0.0) else {
        return solid;
    };
    let fbm = Fbm {
        octaves: noise.octaves,
        lacunarity: noise.lacunarity,
        gain: noise.gain,
        seed: noise.seed,
    };
    let n = fbm.at(p_m / noise.scale_m) * CONTRAST;
    let eaten = noise.amplitude * (0.5 * (1.0 - n) + 0.5 - noise.coverage).clamp(0.0, 1.0);
    if solid > eaten {
        // Above 0, because `solid` is at most 1.
        (solid - eaten) / (1.0 - eaten)
    } else {
        0.0
    }
}
