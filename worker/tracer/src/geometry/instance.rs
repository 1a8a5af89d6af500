//! A mesh placed in the world.

use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3, Vec3};

use super::BuildError;
use super::mesh::TriMesh;
use super::motion::{Joint, Motion, narrow};
use super::sweep::swept_bounds;

/// World boxes are widened by this part of their largest coordinate, so that the
/// roundings of the ray's way into mesh space cannot lose a triangle at the rim.
const BOX_PAD: f64 = 1e-6;

/// A mesh and where it stands: any invertible affine transform, mirrored or
/// scaled unevenly too.
#[derive(Clone, Debug)]
pub struct Instance {
    pub(super) mesh: u32,
    pub(super) world_from_local: Affine3A,
    pub(super) local_from_world: Affine3A,
    /// What it does while the shutter is open; the transforms above are those of
    /// its opening.
    pub(super) motion: Option<Box<Motion>>,
}

impl Instance {
    /// Places mesh number `mesh`.
    ///
    /// # Errors
    /// A transform that is singular or not finite.
    pub fn new(mesh: u32, world_from_local: Affine3A) -> Result<Self, BuildError> {
        let wide = widen(&world_from_local);
        let inverse = wide.inverse();
        let local_from_world = Affine3A {
            matrix3: inverse.matrix3.as_mat3().into(),
            translation: inverse.translation.as_vec3().into(),
        };
        let det = wide.matrix3.determinant();
        if !world_from_local.is_finite() || !local_from_world.is_finite() || det == 0.0 {
            return Err(BuildError::SingularTransform { mesh });
        }
        Ok(Self {
            mesh,
            world_from_local,
            local_from_world,
            motion: None,
        })
    }

    /// Places mesh number `mesh` by joints from the world down to the mesh. The
    /// shutter is open from 0 to `shutter_s`, and no ray may have another time.
    /// Motion is seen by queries with [`MOTION`](crate::uses::MOTION) alone.
    ///
    /// # Errors
    /// A joint that is singular or not finite, at the shutter's opening or while
    /// it is open.
    pub fn moving(mesh: u32, joints: Vec<Joint>, shutter_s: f32) -> Result<Self, BuildError> {
        let motion = Motion::new(joints, shutter_s);
        let opening = narrow(&motion.world_from_local(0.0));
        let mut instance = Self::new(mesh, opening)?;
        if motion.is_fixed() {
            return Ok(instance);
        }
        let (forth, back) = motion.both_ways(shutter_s);
        if !(forth.is_finite() && back.is_finite()) {
            return Err(BuildError::SingularTransform { mesh });
        }
        instance.motion = Some(Box::new(motion));
        Ok(instance)
    }

    /// It does not stand still while the shutter is open.
    pub fn is_moving(&self) -> bool {
        self.motion.is_some()
    }

    /// Takes normals from mesh to world space, `time_s` seconds after the shutter
    /// opens: the inverse transpose. Not normalised.
    pub fn normal_from_local(&self, time_s: f32) -> Mat3 {
        match &self.motion {
            Some(motion) => motion.normal_from_local(time_s),
            None => Mat3::from(self.local_from_world.matrix3).transpose(),
        }
    }

    /// Number of the mesh that is placed.
    pub fn mesh(&self) -> u32 {
        self.mesh
    }

    /// Mesh space to world space.
    pub fn world_from_local(&self) -> &Affine3A {
        &self.world_from_local
    }

    /// World space to mesh space.
    pub fn local_from_world(&self) -> &Affine3A {
        &self.local_from_world
    }

    /// World bounds of the mesh's finite vertices, a little wide; `None` if there
    /// are none.
    ///
    /// `exact` looks at every vertex; otherwise the boxes below the root of the
    /// mesh's tree stand for them, which is looser but takes no time.
    pub(super) fn world_bounds(&self, mesh: &TriMesh, exact: bool) -> Option<(Vec3, Vec3)> {
        if let Some(motion) = &self.motion {
            let offset = |time_s| motion.world_from_local(time_s).translation.abs();
            let origin = offset(0.0).max(offset(motion.shutter_s)).max_element();
            let swept = swept_bounds(motion, mesh, exact);
            return swept.map(|(lo, hi)| padded(lo, hi, origin));
        }
        let transform = widen(&self.world_from_local);
        let mut lo = DVec3::INFINITY;
        let mut hi = DVec3::NEG_INFINITY;
        let mut extend = |p: DVec3| {
            let p = transform.transform_point3(p);
            lo = lo.min(p);
            hi = hi.max(p);
        };
        if exact {
            let finite = mesh.positions().iter().filter(|p| p.is_finite());
            finite.for_each(|p| extend(p.as_dvec3()));
        } else {
            mesh.root_corners().for_each(extend);
        }
        if !lo.cmple(hi).all() {
            return None;
        }
        let origin = transform.translation.abs().max_element();
        Some(padded(lo, hi, origin))
    }
}

/// Bounds widened by `BOX_PAD`; `origin` is the size of the transform's offset.
fn padded(lo: DVec3, hi: DVec3, origin: f64) -> (Vec3, Vec3) {
    let pad = DVec3::splat(lo.abs().max(hi.abs()).max_element().max(origin) * BOX_PAD);
    let largest = DVec3::splat(f64::from(f32::MAX));
    let (lo, hi) = ((lo - pad).max(-largest), (hi + pad).min(largest));
    (lo.as_vec3(), hi.as_vec3())
}

fn widen(a: &Affine3A) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(
            a.matrix3.x_axis.as_dvec3(),
            a.matrix3.y_axis.as_dvec3(),
            a.matrix3.z_axis.as_dvec3(),
        ),
        translation: a.translation.as_dvec3(),
    }
}
