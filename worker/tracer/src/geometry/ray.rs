//! Rays, what they hit, and what dims them.

use glam::Vec3;

/// A half line, cut at `t_max`. Hits lie at `0 < t < t_max`: whoever spawns a ray
/// from a surface moves the origin off it first (`offset_origin`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, world space, metres.
    pub o: Vec3,
    /// Unit direction, world space.
    pub d: Vec3,
    /// End of the ray, metres along `d`; may be infinite.
    pub t_max: f32,
    /// Seconds after the shutter opens: when moving things are looked at.
    pub time_s: f32,
}

impl Ray {
    /// A ray without end, when the shutter opens.
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self::at_time(o, d, 0.0)
    }

    /// A ray without end, `time_s` seconds after the shutter opens.
    #[inline]
    pub fn at_time(o: Vec3, d: Vec3, time_s: f32) -> Self {
        Self {
            o,
            d,
            t_max: f32::INFINITY,
            time_s,
        }
    }

    /// The point at distance `t`, metres.
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }

    /// False for a ray with a NaN or infinite origin or direction; such a ray
    /// hits nothing.
    #[inline(always)]
    pub(super) fn is_finite(&self) -> bool {
        self.o.is_finite() && self.d.is_finite()
    }
}

/// The closest thing on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, metres, `0 < t < t_max`.
    pub t: f32,
    /// What was hit.
    pub kind: HitKind,
}

/// What a ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HitKind {
    /// The water plane.
    Water,
    /// A triangle of an instance; the point is `(1-u-v) v0 + u v1 + v v2`.
    Triangle {
        /// Index of the instance, as given to `Geometry::build`.
        instance: u32,
        /// Index of the triangle, as given to `TriMesh::build`.
        prim: u32,
        /// Weight of the second vertex, 0 to 1.
        u: f32,
        /// Weight of the third vertex, 0 to 1.
        v: f32,
    },
    /// A particle that did not let the ray pass.
    Particle {
        /// Index of the ellipsoid, as given to `Particles::build`.
        prim: u32,
        /// True if the ray was inside and met the far wall.
        inside: bool,
    },
    /// A sprite that did not let the ray pass.
    Sprite {
        /// Index of the sprite, as given to `Sprites::build`.
        prim: u32,
    },
}

/// Fixed-point scale of optical depths: depth 1.0 (transmittance 1/e) is this
/// many units. Integers, so that a sum does not depend on the order of visits. 2^24:
/// a thousand roundings still change the transmittance by less than 1e-4.
pub const OPTICAL_DEPTH_SCALE: f32 = 16_777_216.0;

/// Depths above this (transmittance below 2^-26, less than the film's last bit
/// of a bright sample) count as blocked: `floor(26 ln 2 * 2^24)`.
pub const BLOCKING_DEPTH: u32 = 302_356_079;

/// What lies between a ray's origin and its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occlusion {
    depth: u32,
}

impl Occlusion {
    /// Nothing in between.
    pub const CLEAR: Self = Self { depth: 0 };
    /// Something opaque, or too much that is not.
    pub const BLOCKED: Self = Self { depth: u32::MAX };

    /// From a sum of optical depths in units of 1 / `OPTICAL_DEPTH_SCALE`.
    pub(super) fn from_depth(depth: u32) -> Self {
        if depth > BLOCKING_DEPTH {
            Self::BLOCKED
        } else {
            Self { depth }
        }
    }

    /// No light passes.
    pub fn is_blocked(self) -> bool {
        self.depth > BLOCKING_DEPTH
    }

    /// The optical depth in units of 1 / `OPTICAL_DEPTH_SCALE`; the transmittance
    /// is `exp(-depth / OPTICAL_DEPTH_SCALE)`. `u32::MAX` when blocked.
    pub fn depth(self) -> u32 {
        self.depth
    }
}

/// Order of things at equal `t`: water, then triangles by (instance, prim), then
/// particles by (prim, crossing), then sprites. The lower wins, whatever the order of visits.
pub(super) mod rank {
    /// Nothing was hit yet; loses against everything.
    pub(crate) const NOTHING: u64 = u64::MAX;
    /// The water plane.
    pub(crate) const WATER: u64 = 0;
    const TRIANGLES: u64 = 1 << 62;
    const PARTICLES: u64 = 2 << 62;

    /// Above the walls of all particles.
    const SPRITES: u64 = PARTICLES | 1 << 40;

    /// Instances, particles and sprites are fewer than this, so that ranks do not overlap.
    pub(crate) const COUNT_MAX: usize = 1 << 30;

    /// Rank of a triangle.
    #[inline(always)]
    pub(crate) fn triangle(instance: u32, prim: u32) -> u64 {
        TRIANGLES | u64::from(instance) << 32 | u64::from(prim)
    }

    /// Rank of a particle's near (0) or far (1) wall.
    #[inline(always)]
    pub(crate) fn particle(prim: u32, crossing: u32) -> u64 {
        PARTICLES | u64::from(prim) << 1 | u64::from(crossing)
    }

    /// Rank of a sprite.
    #[inline(always)]
    pub(crate) fn sprite(prim: u32) -> u64 {
        SPRITES | u64::from(prim)
    }

    /// What is crossed, of the rank of a particle's wall or of a sprite: a number
    /// of its own for each.
    #[inline(always)]
    pub(crate) fn wall(rank: u64) -> u64 {
        rank & !PARTICLES
    }

    /// A rank taken apart again.
    pub(crate) enum Winner {
        Nothing,
        Water,
        Triangle { instance: u32, prim: u32 },
        Particle { prim: u32, inside: bool },
        Sprite { prim: u32 },
    }

    /// The inverse of the functions above.
    #[inline(always)]
    pub(crate) fn winner(rank: u64) -> Winner {
        match rank >> 62 {
            0 => Winner::Water,
            1 => Winner::Triangle {
                instance: (rank >> 32) as u32 & 0x3fff_ffff,
                prim: rank as u32,
            },
            2 if rank & SPRITES == SPRITES => Winner::Sprite { prim: rank as u32 },
            2 => Winner::Particle {
                prim: (rank >> 1) as u32,
                inside: rank & 1 == 1,
            },
            _ => Winner::Nothing,
        }
    }
}
