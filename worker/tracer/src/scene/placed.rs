//! The instances of a stage, and those of a frame.

use super::meshes::{Materials, Placed, place};
use super::motion::{Exposure, chains, moves};
use super::stage::geometry_error;
use super::{InstanceShading, Stage};
use crate::geometry::{Placement, TriMesh};
use glam::DVec3;
use shearwater_shared::scene::{SceneDescription, SceneError};
use std::sync::Arc;

/// What frames share of the instances: all of them as the first frame has them, and
/// which of them another frame must place anew.
pub(super) struct Standing {
    placement: Arc<Placement>,
    shading: Arc<[InstanceShading]>,
    /// Number, and the chain of instances that it is placed in.
    animated: Vec<(usize, Vec<u32>)>,
}

impl Standing {
    pub(super) fn build(
        description: &SceneDescription,
        materials: &Materials,
        trees: &[TriMesh],
        anchor_m: DVec3,
    ) -> Result<Self, SceneError> {
        let all = &description.instances;
        let exposure = Exposure::of(description, 0);
        let (mut instances, mut shading, mut animated) = (Vec::new(), Vec::new(), Vec::new());
        for (number, chain) in chains(all).into_iter().enumerate() {
            let (placed, shaded) =
                place(description, materials, anchor_m, number, &chain, exposure)?;
            instances.push(placed);
            shading.push(shaded);
            if chain.iter().any(|&above| moves(&all[above as usize])) {
                animated.push((number, chain));
            }
        }
        let placement =
            Placement::build(trees, instances).map_err(|e| geometry_error("instances", &e))?;
        Ok(Self {
            placement: Arc::new(placement),
            shading: shading.into(),
            animated,
        })
    }
}

impl Stage {
    /// The instances of one exposure.
    pub(super) fn instances_at(
        &self,
        exposure: Exposure,
    ) -> Result<(Arc<Placement>, Arc<[InstanceShading]>), SceneError> {
        let standing = &self.standing;
        if standing.animated.is_empty() {
            let shading = Arc::clone(&standing.shading);
            return Ok((Arc::clone(&standing.placement), shading));
        }
        let mut shading = standing.shading.to_vec();
        let mut changed = Vec::with_capacity(standing.animated.len());
        for (number, chain) in &standing.animated {
            let (description, materials) = (&self.description, &self.materials);
            let (instance, shaded): Placed = place(
                description,
                materials,
                self.anchor_m,
                *number,
                chain,
                exposure,
            )?;
            shading[*number] = shaded;
            changed.push((*number, instance));
        }
        let placement = standing
            .placement
            .with(&self.trees, changed)
            .map_err(|e| geometry_error("instances", &e))?;
        Ok((Arc::new(placement), shading.into()))
    }
}
