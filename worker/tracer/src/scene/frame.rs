//! One frame of a stage: what its time decides.

use super::meshes::place;
use super::stage::geometry_error;
use super::{Scene, Stage};
use crate::camera::Camera;
use crate::geometry::Geometry;
use glam::DVec3;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::SceneError;
use std::sync::Arc;

impl Stage {
    /// Frame `frame` of the scene: camera, instances and sea at its time.
    ///
    /// # Errors
    /// Instances that cannot be placed.
    pub fn frame(&self, settings: &RenderSettings, frame: u32) -> Result<Scene, SceneError> {
        let description = &self.description;
        let anchor_m = self.anchor_m;
        let sea = self.sea.as_ref().map(|sea| {
            let shutter_s = description.camera.shutter_s;
            sea.at(
                description.frame_time_s(frame),
                shutter_s,
                anchor_m.to_array(),
            )
        });
        let (placed, instances) = place(description, &self.materials, anchor_m)?;
        let water_y = sea.as_ref().map(|sea| (sea.height_m - anchor_m.y) as f32);
        let geometry = Geometry::build(
            Arc::clone(&self.trees),
            placed,
            self.particles.clone(),
            water_y,
        )
        .map_err(|e| geometry_error(".", &e))?;
        let geometry = match &self.sprites {
            Some(sprites) => {
                // The eye when the shutter opens.
                let eye_m = DVec3::from_array(description.camera.position_m) - anchor_m;
                geometry.with_sprites(Arc::clone(sprites), eye_m.as_vec3())
            }
            None => geometry,
        };
        let geometry = if self.options.portable_simd {
            geometry.without_avx2()
        } else {
            geometry
        };
        Ok(Scene {
            common: Arc::clone(&self.common),
            geometry,
            camera: Camera::new(&description.camera, settings.width, settings.height),
            seed: settings.seed,
            frame,
            instances,
            sea,
        })
    }
}
