//! Vectors of floats as the kernels see them: a trait with the few operations
//! they need, and the portable implementation over arrays.
//!
//! Every operation is one IEEE 754 operation per lane, correctly rounded, never
//! fused. Two backends that keep to that give the same bits, so the kernels are
//! written once (`kernels`) and the wide copy lives in `simd`.

use std::ops::{Add, Div, Mul, Sub};

use super::best8::Best8;
use super::kernels::Best;
use super::mesh::TriMesh;
use super::packet::{self, PacketRay};
use super::packet_leaves::{Clouds8, Triangles8};
use super::particles::Particles;
use super::single;
use super::sprite_leaves::Discs8;
use super::sprites::FacingSprites;

/// `N` floats that are worked on together.
pub(super) trait Floats<const N: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The answer of a comparison, lane by lane.
    type Mask: LaneMask;

    /// The same value in every lane.
    fn splat(x: f32) -> Self;
    /// Lane `i` is `a[i]`.
    fn load(a: &[f32; N]) -> Self;
    /// The lanes as an array.
    fn store(self) -> [f32; N];
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// `self < other ? self : other`: a NaN on either side gives `other`.
    fn min(self, other: Self) -> Self;
    /// `self > other ? self : other`: a NaN on either side gives `other`.
    fn max(self, other: Self) -> Self;
    /// `self <= other`, false for NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `self < other`, false for NaN.
    fn lt(self, other: Self) -> Self::Mask;
}

/// One truth value per lane.
pub(super) trait LaneMask: Copy {
    /// Lane-wise and.
    fn and(self, other: Self) -> Self;
    /// Lane-wise or.
    fn or(self, other: Self) -> Self;
    /// Bit `i` is lane `i`.
    fn bits(self) -> u32;
}

/// A pair of vector types; the traversal is generic over it.
///
/// The walks of one tree are methods, because the wide backend makes each a
/// function of its own: inlined into each other, they fight for registers.
pub(super) trait Backend: Sized {
    /// Four lanes: a leaf's triangles.
    type F4: Floats<4>;
    /// Eight lanes: a node's children, a leaf's particles, a packet's rays.
    type F8: Floats<8>;

    /// `single::mesh_closest`.
    fn mesh_closest(mesh: &TriMesh, o: [f32; 3], d: [f32; 3], instance: u32, best: &mut Best);
    /// `single::mesh_dim`.
    fn mesh_dim(mesh: &TriMesh, o: [f32; 3], d: [f32; 3], t_max: f32) -> bool;
    /// `single::particles_closest`.
    fn particles_closest(
        particles: &Particles,
        o: [f32; 3],
        d: [f32; 3],
        key: u64,
        best: &mut Best,
    );
    /// `single::particles_dim`.
    fn particles_dim(particles: &Particles, o: [f32; 3], d: [f32; 3], t_max: f32, depth: &mut u32);
    /// `packet::mesh_closest8`.
    fn mesh_closest8(packet: &PacketRay<Self>, leaf: &Triangles8<'_, Self>, best: &mut Best8);
    /// `packet::mesh_dim8`.
    fn mesh_dim8(
        packet: &PacketRay<Self>,
        leaf: &Triangles8<'_, Self>,
        best: &mut Best8,
        depth: &mut [u32; 8],
    );
    /// `packet::particles_closest8`.
    fn particles_closest8(packet: &PacketRay<Self>, leaf: &Clouds8<'_, Self>, best: &mut Best8);
    /// `packet::particles_dim8`.
    fn particles_dim8(
        packet: &PacketRay<Self>,
        leaf: &Clouds8<'_, Self>,
        best: &mut Best8,
        depth: &mut [u32; 8],
    );
    /// `single::sprites_closest`.
    fn sprites_closest(
        sprites: &FacingSprites,
        o: [f32; 3],
        d: [f32; 3],
        key: u64,
        best: &mut Best,
    );
    /// `single::sprites_dim`.
    fn sprites_dim(sprites: &FacingSprites, o: [f32; 3], d: [f32; 3], t_max: f32, depth: &mut u32);
    /// `packet::sprites_closest8`.
    fn sprites_closest8(packet: &PacketRay<Self>, leaf: &Discs8<'_, Self>, best: &mut Best8);
    /// `packet::sprites_dim8`.
    fn sprites_dim8(
        packet: &PacketRay<Self>,
        leaf: &Discs8<'_, Self>,
        best: &mut Best8,
        depth: &mut [u32; 8],
    );
}

/// Arrays and plain loops: any machine.
pub(super) struct Portable;

impl Backend for Portable {
    type F4 = Array<4>;
    type F8 = Array<8>;

    fn mesh_closest(mesh: &TriMesh, o: [f32; 3], d: [f32; 3], instance: u32, best: &mut Best) {
        single::mesh_closest::<Self>(mesh, o, d, instance, best);
    }
    fn mesh_dim(mesh: &TriMesh, o: [f32; 3], d: [f32; 3], t_max: f32) -> bool {
        single::mesh_dim::<Self>(mesh, o, d, t_max)
    }
    fn particles_closest(
        particles: &Particles,
        o: [f32; 3],
        d: [f32; 3],
        key: u64,
        best: &mut Best,
    ) {
        single::particles_closest::<Self>(particles, o, d, key, best);
    }
    fn particles_dim(particles: &Particles, o: [f32; 3], d: [f32; 3], t_max: f32, depth: &mut u32) {
        single::particles_dim::<Self>(particles, o, d, t_max, depth);
    }
    fn mesh_closest8(packet: &PacketRay<Self>, leaf: &Triangles8<'_, Self>, best: &mut Best8) {
        packet::mesh_closest8(packet, leaf, best);
    }
    fn mesh_dim8(
        packet: &PacketRay<Self>,
        leaf: &Triangles8<'_, Self>,
        best: &mut Best8,
        depth: &mut [u32; 8],
    ) {
        packet::mesh_dim8(packet, leaf, best, depth);
    }
    fn particles_closest8(packet: &PacketRay<Self>, leaf: &Clouds8<'_, Self>, best: &mut Best8) {
        packet::particles_closest8(packet, leaf, best);
    }
    fn particles_dim8(
        packet: &PacketRay<Self>,
        leaf: &Clouds8<'_, Self>,
        best: &mut Best8,
        depth: &mut [u32; 8],
    ) {
        packet::particles_dim8(packet, leaf, best, depth);
    }
    fn sprites_closest(
        sprites: &FacingSprites,
        o: [f32; 3],
        d: [f32; 3],
        key: u64,
        best: &mut Best,
    ) {
        single::sprites_closest::<Self>(sprites, o, d, key, best);
    }
    fn sprites_dim(sprites: &FacingSprites, o: [f32; 3], d: [f32; 3], t_max: f32, depth: &mut u32) {
        single::sprites_dim::<Self>(sprites, o, d, t_max, depth);
    }
    fn sprites_closest8(packet: &PacketRay<Self>, leaf: &Discs8<'_, Self>, best: &mut Best8) {
        packet::sprites_closest8(packet, leaf, best);
    }
    fn sprites_dim8(
        packet: &PacketRay<Self>,
        leaf: &Discs8<'_, Self>,
        best: &mut Best8,
        depth: &mut [u32; 8],
    ) {
        packet::sprites_dim8(packet, leaf, best, depth);
    }
}

/// The portable vector.
#[derive(Clone, Copy)]
pub(super) struct Array<const N: usize>([f32; N]);

/// The portable mask, one bit per lane.
#[derive(Clone, Copy)]
pub(super) struct Bits(u32);

impl LaneMask for Bits {
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
    }
}

macro_rules! array_operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize> $trait for Array<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for (a, b) in self.0.iter_mut().zip(other.0) {
                    *a $op b;
                }
                self
            }
        }
    };
}
array_operator!(Add, add, +=);
array_operator!(Sub, sub, -=);
array_operator!(Mul, mul, *=);
array_operator!(Div, div, /=);

impl<const N: usize> Floats<N> for Array<N> {
    type Mask = Bits;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn load(a: &[f32; N]) -> Self {
        Self(*a)
    }
    #[inline(always)]
    fn store(self) -> [f32; N] {
        self.0
    }
    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for a in &mut self.0 {
            *a = a.sqrt();
        }
        self
    }
    #[inline(always)]
    fn min(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = if *a < b { *a } else { b };
        }
        self
    }
    #[inline(always)]
    fn max(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = if *a > b { *a } else { b };
        }
        self
    }
    #[inline(always)]
    fn le(self, other: Self) -> Bits {
        let mut bits = 0;
        for i in 0..N {
            bits |= u32::from(self.0[i] <= other.0[i]) << i;
        }
        Bits(bits)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Bits {
        let mut bits = 0;
        for i in 0..N {
            bits |= u32::from(self.0[i] < other.0[i]) << i;
        }
        Bits(bits)
    }
}
