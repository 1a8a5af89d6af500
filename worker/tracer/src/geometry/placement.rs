//! Where the meshes stand: instances and the tree above them.

use glam::Vec3A;
use obvhs::aabb::Aabb;

use super::BuildError;
use super::collapse::collapse;
use super::instance::Instance;
use super::mesh::TriMesh;
use super::ray::rank;
use super::sah::{self, Splitter};
use super::wide::{LEAF, Node8, WideTree};

/// Instances placed anew in one frame, up to which their boxes come from every
/// vertex: some tenths of a second even for large meshes.
const EXACT_CHANGED_MAX: usize = 256;

/// Vertices of all instances, each instance counted by itself, up to which their
/// world boxes are exact: about a second of work.
const EXACT_VERTICES_MAX: usize = 50_000_000;

/// Instances under a tree.
pub struct Placement {
    pub(super) instances: Vec<Instance>,
    /// World box of each instance that has one.
    boxes: Vec<Option<Aabb>>,
    /// Every vertex was looked at.
    exact: bool,
    /// Leaves are instance numbers.
    pub(super) top: WideTree,
    /// The only instance, if there is but one: it needs no tree above it.
    pub(super) lone: Option<u32>,
}

impl Placement {
    /// Builds the tree.
    ///
    /// # Errors
    /// An instance of an unknown mesh, or too many instances.
    pub fn build(meshes: &[TriMesh], instances: Vec<Instance>) -> Result<Self, BuildError> {
        if instances.len() >= rank::COUNT_MAX {
            let count = instances.len();
            return Err(BuildError::TooMany {
                what: "instances",
                count,
                limit: rank::COUNT_MAX,
            });
        }
        let vertices = |i: &Instance| {
            meshes
                .get(i.mesh as usize)
                .map_or(0, |m| m.positions().len())
        };
        let exact = instances
            .iter()
            .map(vertices)
            .fold(0, usize::saturating_add)
            <= EXACT_VERTICES_MAX;
        let boxes = instances.iter().enumerate();
        let boxes = boxes.map(|(i, instance)| world_box(meshes, i, instance, exact));
        let boxes = boxes.collect::<Result<Vec<_>, _>>()?;
        Self::above(instances, boxes, exact)
    }

    /// The same with other instances in some places: only their boxes are made
    /// anew, and the tree.
    ///
    /// # Errors
    /// An instance of an unknown mesh. Numbers out of range are left out.
    pub fn with(
        &self,
        meshes: &[TriMesh],
        changed: impl IntoIterator<Item = (usize, Instance)>,
    ) -> Result<Self, BuildError> {
        let (mut instances, mut boxes) = (self.instances.clone(), self.boxes.clone());
        let changed: Vec<(usize, Instance)> = changed.into_iter().collect();
        let exact = self.exact && changed.len() <= EXACT_CHANGED_MAX;
        for (index, instance) in changed {
            if index < instances.len() {
                boxes[index] = world_box(meshes, index, &instance, exact)?;
                instances[index] = instance;
            }
        }
        Self::above(instances, boxes, self.exact)
    }

    fn above(
        instances: Vec<Instance>,
        boxes: Vec<Option<Aabb>>,
        exact: bool,
    ) -> Result<Self, BuildError> {
        let (mut solid, mut owners) = (Vec::new(), Vec::new());
        for (owner, aabb) in boxes.iter().enumerate() {
            if let Some(aabb) = aabb {
                solid.push(*aabb);
                owners.push(owner as u32);
            }
        }
        let lone = if let [only] = owners[..] {
            Some(only)
        } else {
            None
        };
        let top = match top_tree(&solid, &owners, Splitter::Sah) {
            Err(BuildError::TooDeep { .. }) => top_tree(&solid, &owners, Splitter::Median)?,
            other => other?,
        };
        Ok(Self {
            instances,
            boxes,
            exact,
            top,
            lone,
        })
    }

    /// The instances, as given.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// World box of an instance over the shutter, lower and upper corner; `None`
    /// if it has no finite vertex or does not exist.
    pub fn world_box(&self, index: usize) -> Option<(Vec3A, Vec3A)> {
        let aabb = self.boxes.get(index)?.as_ref()?;
        Some((aabb.min, aabb.max))
    }
}

fn world_box(
    meshes: &[TriMesh],
    index: usize,
    instance: &Instance,
    exact: bool,
) -> Result<Option<Aabb>, BuildError> {
    let Some(mesh) = meshes.get(instance.mesh as usize) else {
        return Err(BuildError::MeshIndex {
            instance: index,
            mesh: instance.mesh,
            meshes: meshes.len(),
        });
    };
    let bounds = instance.world_bounds(mesh, exact);
    Ok(bounds.map(|(lo, hi)| Aabb::new(Vec3A::from(lo), Vec3A::from(hi))))
}

/// A tree whose leaf codes are the instances themselves.
fn top_tree(boxes: &[Aabb], owners: &[u32], splitter: Splitter) -> Result<WideTree, BuildError> {
    let tree = collapse(&sah::build(boxes, splitter), 1, 1.0);
    let mut nodes: Vec<Node8> = tree.nodes;
    let blocks: Vec<u32> = tree
        .items
        .iter()
        .map(|&item| owners[item as usize])
        .collect();
    for node in &mut nodes {
        for child in &mut node.child {
            if *child & LEAF != 0
                && let Some(&owner) = blocks.get((*child & !LEAF) as usize)
            {
                *child = LEAF | owner;
            }
        }
    }
    WideTree::new(nodes)
}
