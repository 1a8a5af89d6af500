//! The AVX2 backend, and the switch to it. The only file with `unsafe`.
//!
//! Why it is sound:
//! - The intrinsics run only inside functions marked `#[target_feature]`, which are
//!   entered only through a `Path` that holds the proof of detection (`Avx2Proof`,
//!   made by `Path::detect` alone). The traversal is generic and always inlined,
//!   so it is compiled a second time with AVX2 inside them.
//! - Loads and stores take references to whole arrays.
//! - The stack writes an entry before it reads it, and masks every index.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;
use std::mem::MaybeUninit;
#[cfg(target_arch = "x86_64")]
use std::ops::{Add, Div, Mul, Sub};

#[cfg(target_arch = "x86_64")]
use super::best8::Best8;
#[cfg(target_arch = "x86_64")]
use super::kernels::Best;
use super::lanes::Portable;
#[cfg(target_arch = "x86_64")]
use super::lanes::{Backend, Floats, LaneMask};
#[cfg(target_arch = "x86_64")]
use super::mesh::TriMesh;
use super::packet;
#[cfg(target_arch = "x86_64")]
use super::packet::PacketRay;
#[cfg(target_arch = "x86_64")]
use super::packet_leaves::{Clouds8, Triangles8};
#[cfg(target_arch = "x86_64")]
use super::particles::Particles;
use super::ray::{Hit, Occlusion, Ray};
use super::scene::Geometry;
use super::single;
#[cfg(target_arch = "x86_64")]
use super::sprite_leaves::Discs8;
#[cfg(target_arch = "x86_64")]
use super::sprites::FacingSprites;
use super::wide::STACK_ENTRIES;

/// Which copy of the traversal runs.
#[derive(Clone, Copy, Debug)]
pub(super) enum Path {
    /// Arrays and loops.
    Portable,
    /// Eight lanes in one register.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2Proof),
}

/// The machine has AVX2, BMI1, BMI2, LZCNT and POPCNT.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2Proof(());

impl Path {
    /// The best this machine can do.
    pub(super) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
        {
            return Self::Avx2(Avx2Proof(()));
        }
        Self::Portable
    }
}

/// Entries that wait during a walk. Not initialised: clearing 2 KiB per ray would
/// cost as much as a short walk.
pub(super) struct Stack {
    entries: [MaybeUninit<u64>; STACK_ENTRIES],
    len: usize,
}

impl Stack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self {
            entries: [const { MaybeUninit::uninit() }; STACK_ENTRIES],
            len: 0,
        }
    }

    /// Adds an entry. `WideTree::new` made sure that there is room; were it not so,
    /// the mask would overwrite the oldest entry rather than foreign memory.
    #[inline(always)]
    pub(super) fn push(&mut self, entry: u64) {
        debug_assert!(self.len < STACK_ENTRIES);
        self.entries[self.len & (STACK_ENTRIES - 1)].write(entry);
        self.len += 1;
    }

    /// Takes the newest entry.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<u64> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: every index below `len` was written by `push` (masked alike).
        Some(unsafe { self.entries[self.len & (STACK_ENTRIES - 1)].assume_init() })
    }

    /// Adds an entry below all of the newest `count` that are smaller, which keeps
    /// these in descending order: the smallest is popped first.
    #[inline(always)]
    pub(super) fn push_sorted(&mut self, entry: u64, count: usize) {
        let mut at = self.len;
        self.push(entry);
        for _ in 0..count {
            // SAFETY: `count` entries below were written by earlier pushes.
            let below = unsafe { self.entries[(at - 1) & (STACK_ENTRIES - 1)].assume_init() };
            if below > entry {
                break;
            }
            self.entries[at & (STACK_ENTRIES - 1)].write(below);
            at -= 1;
        }
        self.entries[at & (STACK_ENTRIES - 1)].write(entry);
    }
}

/// One function per query that picks the copy to run, and the AVX2 copy.
macro_rules! entry_points {
    ($($name:ident, $wide:ident, <$(const $flag:ident),*>, ($($arg:ident: $type:ty),*) -> $ret:ty, $body:path;)*) => {$(
        /// Runs the query on the path of `geometry`.
        #[inline]
        pub(super) fn $name<$(const $flag: u8),*>(geometry: &Geometry, $($arg: $type),*) -> $ret {
            use $body as body;
            match geometry.path {
                // SAFETY: the proof says that the features were detected.
                #[cfg(target_arch = "x86_64")]
                Path::Avx2(_) => unsafe { $wide::<$($flag),*>(geometry, $($arg),*) },
                Path::Portable => body::<Portable, $($flag),*>(geometry, $($arg),*),
            }
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn $wide<$(const $flag: u8),*>(geometry: &Geometry, $($arg: $type),*) -> $ret {
            use $body as body;
            body::<Avx2, $($flag),*>(geometry, $($arg),*)
        }
    )*};
}

entry_points! {
    intersect, intersect_avx2, <const USES>, (ray: &Ray, key: u64) -> Option<Hit>, single::intersect;
    transmittance, transmittance_avx2, <const USES>, (ray: &Ray) -> Occlusion, single::transmittance;
    intersect8, intersect8_avx2, <const USES>, (rays: &[Ray; 8], keys: &[u64; 8]) -> [Option<Hit>; 8],
        packet::intersect8;
    transmittance8, transmittance8_avx2, <const USES>, (rays: &[Ray; 8]) -> [Occlusion; 8],
        packet::transmittance8;
}

/// 256-bit registers for eight lanes, 128-bit ones for four.
#[cfg(target_arch = "x86_64")]
pub(super) struct Avx2;

/// Each walk as a function of its own, compiled with AVX2.
#[cfg(target_arch = "x86_64")]
macro_rules! walks {
    ($($name:ident, $wide:ident, ($($arg:ident: $type:ty),*) -> $ret:ty, $body:path;)*) => {
        impl Backend for Avx2 {
            type F4 = Sse4;
            type F8 = Avx8;
            $(
                #[inline(always)]
                fn $name($($arg: $type),*) -> $ret {
                    // SAFETY: an `Avx2` walk is only entered from the entry points
                    // above, so the features were detected.
                    unsafe { $wide($($arg),*) }
                }
            )*
        }
        $(
            #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
            #[inline(never)]
            fn $wide($($arg: $type),*) -> $ret {
                use $body as body;
                body::<Avx2>($($arg),*)
            }
        )*
    };
}

#[cfg(target_arch = "x86_64")]
walks! {
    mesh_closest, mesh_closest_avx2,
        (mesh: &TriMesh, o: [f32; 3], d: [f32; 3], instance: u32, best: &mut Best) -> (), single::mesh_closest;
    mesh_dim, mesh_dim_avx2,
        (mesh: &TriMesh, o: [f32; 3], d: [f32; 3], t_max: f32) -> bool, single::mesh_dim;
    particles_closest, particles_closest_avx2,
        (particles: &Particles, o: [f32; 3], d: [f32; 3], key: u64, best: &mut Best) -> (),
        single::particles_closest;
    particles_dim, particles_dim_avx2,
        (particles: &Particles, o: [f32; 3], d: [f32; 3], t_max: f32, depth: &mut u32) -> (),
        single::particles_dim;
    mesh_closest8, mesh_closest8_avx2,
        (packet: &PacketRay<Avx2>, leaf: &Triangles8<'_, Avx2>, best: &mut Best8) -> (), packet::mesh_closest8;
    mesh_dim8, mesh_dim8_avx2,
        (packet: &PacketRay<Avx2>, leaf: &Triangles8<'_, Avx2>, best: &mut Best8, depth: &mut [u32; 8]) -> (),
        packet::mesh_dim8;
    particles_closest8, particles_closest8_avx2,
        (packet: &PacketRay<Avx2>, leaf: &Clouds8<'_, Avx2>, best: &mut Best8) -> (), packet::particles_closest8;
    particles_dim8, particles_dim8_avx2,
        (packet: &PacketRay<Avx2>, leaf: &Clouds8<'_, Avx2>, best: &mut Best8, depth: &mut [u32; 8]) -> (),
        packet::particles_dim8;
    sprites_closest, sprites_closest_avx2,
        (sprites: &FacingSprites, o: [f32; 3], d: [f32; 3], key: u64, best: &mut Best) -> (),
        single::sprites_closest;
    sprites_dim, sprites_dim_avx2,
        (sprites: &FacingSprites, o: [f32; 3], d: [f32; 3], t_max: f32, depth: &mut u32) -> (),
        single::sprites_dim;
    sprites_closest8, sprites_closest8_avx2,
        (packet: &PacketRay<Avx2>, leaf: &Discs8<'_, Avx2>, best: &mut Best8) -> (), packet::sprites_closest8;
    sprites_dim8, sprites_dim8_avx2,
        (packet: &PacketRay<Avx2>, leaf: &Discs8<'_, Avx2>, best: &mut Best8, depth: &mut [u32; 8]) -> (),
        packet::sprites_dim8;
}

/// A vector type over a register, its mask type, and their operations.
#[cfg(target_arch = "x86_64")]
macro_rules! register {
    ($name:ident, $mask:ident, $register:ty, $lanes:literal, $splat:ident, $load:ident, $store:ident, $add:ident,
     $sub:ident, $mul:ident, $div:ident, $sqrt:ident, $min:ident, $max:ident, $and:ident, $or:ident, $bits:ident,
     $le:expr, $lt:expr) => {
        #[derive(Clone, Copy)]
        pub(super) struct $name($register);

        #[derive(Clone, Copy)]
        pub(super) struct $mask($register);

        register!(@operator $name, Add, add, $add);
        register!(@operator $name, Sub, sub, $sub);
        register!(@operator $name, Mul, mul, $mul);
        register!(@operator $name, Div, div, $div);

        // SAFETY, for every block below: see the head of this file.
        impl Floats<$lanes> for $name {
            type Mask = $mask;
            #[inline(always)]
            fn splat(x: f32) -> Self {
                Self(unsafe { $splat(x) })
            }
            #[inline(always)]
            fn load(a: &[f32; $lanes]) -> Self {
                Self(unsafe { $load(a.as_ptr()) })
            }
            #[inline(always)]
            fn store(self) -> [f32; $lanes] {
                let mut a = [0.0; $lanes];
                unsafe { $store(a.as_mut_ptr(), self.0) };
                a
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(unsafe { $max(self.0, other.0) })
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                $mask(unsafe { $le(self.0, other.0) })
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                $mask(unsafe { $lt(self.0, other.0) })
            }
        }

        impl LaneMask for $mask {
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                Self(unsafe { $and(self.0, other.0) })
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                Self(unsafe { $or(self.0, other.0) })
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                unsafe { $bits(self.0) as u32 }
            }
        }
    };
    (@operator $name:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: see the head of this file.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
register!(
    Avx8,
    AvxMask,
    __m256,
    8,
    _mm256_set1_ps,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_sqrt_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    _mm256_and_ps,
    _mm256_or_ps,
    _mm256_movemask_ps,
    _mm256_cmp_ps::<_CMP_LE_OQ>,
    _mm256_cmp_ps::<_CMP_LT_OQ>
);
#[cfg(target_arch = "x86_64")]
register!(
    Sse4,
    SseMask,
    __m128,
    4,
    _mm_set1_ps,
    _mm_loadu_ps,
    _mm_storeu_ps,
    _mm_add_ps,
    _mm_sub_ps,
    _mm_mul_ps,
    _mm_div_ps,
    _mm_sqrt_ps,
    _mm_min_ps,
    _mm_max_ps,
    _mm_and_ps,
    _mm_or_ps,
    _mm_movemask_ps,
    _mm_cmple_ps,
    _mm_cmplt_ps
);
