//! Orthonormal frames around a normal.

use glam::Vec3;

/// A right-handed orthonormal frame; local z is the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x in world space, unit.
    pub tangent: Vec3,
    /// Local y in world space, unit.
    pub bitangent: Vec3,
    /// Local z in world space, unit.
    pub normal: Vec3,
}

impl Frame {
    /// A frame around the unit vector `normal`, continuous but at z = 0
    /// (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
    #[inline]
    #[must_use]
    pub fn from_normal(normal: Vec3) -> Self {
        let sign = 1.0f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(
                1.0 + sign * normal.x * normal.x * a,
                sign * b,
                -sign * normal.x,
            ),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// The components of a world vector in this frame.
    #[inline]
    #[must_use]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(
            v.dot(self.tangent),
            v.dot(self.bitangent),
            v.dot(self.normal),
        )
    }

    /// The world vector of local components.
    #[inline]
    #[must_use]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}
