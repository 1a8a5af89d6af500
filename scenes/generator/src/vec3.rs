//! Three-component vectors in double precision; every operation is a plain
//! IEEE one or a call to `libm`, so the bits are the same everywhere.

use std::ops::{Add, Mul, Neg, Sub};

/// A point or a direction; metres where it is a point.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Vec3 {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate (up).
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
}

/// Shorthand for `Vec3 { x, y, z }`.
#[must_use]
pub const fn vec3(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    /// Scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product, right-handed.
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// Euclidean length.
    #[must_use]
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Unit vector of the same direction; the zero vector stays zero.
    #[must_use]
    pub fn normalized(self) -> Self {
        let length = self.length();
        if length > 0.0 {
            self * (1.0 / length)
        } else {
            self
        }
    }

    /// Point at `amount` of the way from `self` to `other`.
    #[must_use]
    pub fn lerp(self, other: Self, amount: f64) -> Self {
        self + (other - self) * amount
    }

    /// Turned about +x by `angle` radians, right-handed.
    #[must_use]
    pub fn rotated_x(self, angle: f64) -> Self {
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        vec3(self.x, c * self.y - s * self.z, s * self.y + c * self.z)
    }

    /// Turned about +y by `angle` radians, right-handed.
    #[must_use]
    pub fn rotated_y(self, angle: f64) -> Self {
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        vec3(c * self.x + s * self.z, self.y, c * self.z - s * self.x)
    }

    /// Turned about +z by `angle` radians, right-handed.
    #[must_use]
    pub fn rotated_z(self, angle: f64) -> Self {
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        vec3(c * self.x - s * self.y, s * self.x + c * self.y, self.z)
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        vec3(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        vec3(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        vec3(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        vec3(-self.x, -self.y, -self.z)
    }
}
