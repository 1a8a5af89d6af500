//! Rays against the scene: what is hit first, and how much light passes.
//!
//! Meshes are eight-wide trees with blocks of four triangles (`TriMesh`), placed
//! by `Instance`s under a tree of the same kind; `Particles` are semi-opaque
//! ellipsoids in a tree of their own, `Sprites` soft discs in another; the water is one plane. `Geometry` holds
//! them all and answers queries.
//!
//! Results do not depend on the order in which a walk meets things, nor on the
//! instruction set: every path does the same correctly rounded operations, and
//! ties go by a fixed rank. So single rays and packets, the AVX2 path and the
//! portable one, agree bit for bit.

mod best8;
mod collapse;
mod ellipsoid;
mod instance;
mod kernels;
mod lanes;
mod leaves;
mod mesh;
mod motion;
mod offset;
mod packet;
mod packet_leaves;
mod particles;
mod placement;
mod ray;
mod sah;
mod scene;
mod simd;
mod single;
mod sprite_leaves;
mod sprites;
mod surface;
mod sweep;
mod wide;

pub use instance::Instance;
pub use mesh::TriMesh;
pub use motion::{Joint, Keyed, PIECES, Turn};
pub use offset::offset_origin;
pub use particles::{Ellipsoid, Particles};
pub use placement::Placement;
pub use ray::{BLOCKING_DEPTH, Hit, HitKind, OPTICAL_DEPTH_SCALE, Occlusion, Ray};
pub use scene::Geometry;
pub use sprites::{Sprite, Sprites};
pub use surface::SurfacePoint;

/// Why geometry could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A triangle names a vertex that does not exist.
    #[error(
        "triangle {triangle} names vertex {vertex}, but the mesh has only {vertices}; fix its indices"
    )]
    VertexIndex {
        /// Index of the triangle.
        triangle: usize,
        /// The index it holds.
        vertex: u32,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// More things than an index holds.
    #[error("{count} {what} are more than the limit of {limit}; split or thin them out")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// The tree could overflow the traversal stack, even when built by halving.
    #[error("the tree needs {entries} stack entries, the limit is {limit}; split the mesh")]
    TooDeep {
        /// Entries a walk may need.
        entries: usize,
        /// Entries the stack has.
        limit: usize,
    },
    /// An instance of a mesh that does not exist.
    #[error("instance {instance} places mesh {mesh}, but there are only {meshes} meshes")]
    MeshIndex {
        /// Index of the instance.
        instance: usize,
        /// The mesh it names.
        mesh: u32,
        /// Meshes there are.
        meshes: usize,
    },
    /// A transform that cannot be undone.
    #[error(
        "the transform of an instance of mesh {mesh} is singular or not finite; no scale may be zero"
    )]
    SingularTransform {
        /// The mesh to be placed.
        mesh: u32,
    },
    /// An ellipsoid with a radius that is not positive or a value that is not finite.
    #[error("ellipsoid {index} needs finite values, positive radii and an opacity from 0 to 1")]
    Ellipsoid {
        /// Index of the ellipsoid.
        index: usize,
    },
    /// A sprite with a value that is not finite or out of its range.
    #[error(
        "sprite {index} needs finite values, a radius whose square is a normal float, an opacity from 0 to 1 and a softness above 0, at most 1"
    )]
    Sprite {
        /// Index of the sprite.
        index: usize,
    },
    /// A water height that is not finite.
    #[error("the height of the water plane must be finite")]
    WaterHeight,
}
