//! One frame of a stage: what its time decides.

use super::motion::Exposure;
use super::stage::geometry_error;
use super::{Scene, Stage};
use crate::camera::Camera;
use crate::geometry::Geometry;
use glam::DVec3;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::SceneError;
use std::sync::Arc;

impl Stage {
    /// The point of the scene that is (0, 0, 0) for the tracer, metres.
    pub(crate) fn anchor_m(&self) -> DVec3 {
        self.anchor_m
    }

    /// Frame `frame` of the scene: camera, instances and sea at its time.
    ///
    /// # Errors
    /// Instances that cannot be placed, a camera that looks nowhere.
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
        let exposure = Exposure::of(description, frame);
        let (placement, instances) = self.instances_at(exposure)?;
        let camera = Camera::new(
            &description.camera,
            anchor_m,
            exposure,
            (settings.width, settings.height),
        )
        .map_err(|e| SceneError::new("scene.json", "camera", e.to_string()))?;
        let water_y = sea.as_ref().map(|sea| (sea.height_m - anchor_m.y) as f32);
        let geometry = Geometry::assemble(
            Arc::clone(&self.trees),
            placement,
            self.particles.clone(),
            water_y,
        )
        .map_err(|e| geometry_error(".", &e))?;
        let geometry = match &self.sprites {
            Some(sprites) => geometry.with_sprites(Arc::clone(sprites), camera.eye_m()),
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
            camera,
            seed: settings.seed,
            frame,
            instances,
            sea,
        })
    }
}
