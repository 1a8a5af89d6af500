//! Embree 3 through its C interface, if the machine has it (Debian: libembree3-3).
//!
//! `unsafe` because it calls a foreign library; this is a measurement, nothing of
//! it is in the product. The layouts are those of Embree 3's public headers.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_void};
use std::ptr::null;

use libloading::Library;
use shearwater_tracer::geometry::Ray;

use super::scenes::Scene;

const NAMES: [&str; 3] = ["libembree3.so.3", "libembree3.so", "libembree3.dylib"];
const GEOMETRY_TRIANGLE: i32 = 0;
const BUFFER_INDEX: i32 = 0;
const BUFFER_VERTEX: i32 = 1;
const FORMAT_UINT3: i32 = 0x5003;
const FORMAT_FLOAT3: i32 = 0x9003;
const FLAG_ROBUST: i32 = 1 << 2;
const QUALITY_HIGH: i32 = 2;
const NOTHING: u32 = u32::MAX;

#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RayHit {
    o: [f32; 3],
    tnear: f32,
    d: [f32; 3],
    time: f32,
    tfar: f32,
    mask: u32,
    id: u32,
    flags: u32,
    ng: [f32; 3],
    u: f32,
    v: f32,
    prim: u32,
    geometry: u32,
    instance: u32,
}

#[repr(C)]
struct Context {
    flags: u32,
    filter: *const c_void,
    instance: [u32; 8],
}

type Handle = *mut c_void;
type Query = unsafe extern "C" fn(Handle, *mut Context, *mut RayHit);

/// A committed scene.
pub(crate) struct Embree {
    _library: Library,
    scene: Handle,
    intersect1: Query,
    occluded1: Query,
}

impl Embree {
    /// None if the library is not there or lacks a function.
    pub(crate) fn build(mesh: &Scene, robust: bool) -> Option<Self> {
        // SAFETY: the functions have the types of the public headers; buffers are
        // filled with as many items as were asked for. Handles live on with the
        // process: a bench may leak them.
        unsafe {
            let library = NAMES.iter().find_map(|&name| Library::new(name).ok())?;
            macro_rules! call {
                ($name:literal, fn($($t:ty),*) $(-> $r:ty)?, $($arg:expr),*) => {
                    (*library.get::<unsafe extern "C" fn($($t),*) $(-> $r)?>($name).ok()?)($($arg),*)
                };
            }
            let config = c"threads=1".as_ptr();
            let device = call!(b"rtcNewDevice", fn(*const c_char) -> Handle, config);
            let scene = call!(b"rtcNewScene", fn(Handle) -> Handle, device);
            call!(
                b"rtcSetSceneFlags",
                fn(Handle, i32),
                scene,
                if robust { FLAG_ROBUST } else { 0 }
            );
            call!(
                b"rtcSetSceneBuildQuality",
                fn(Handle, i32),
                scene,
                QUALITY_HIGH
            );
            let geometry = call!(
                b"rtcNewGeometry",
                fn(Handle, i32) -> Handle,
                device,
                GEOMETRY_TRIANGLE
            );
            for (slot, format, count) in [
                (BUFFER_VERTEX, FORMAT_FLOAT3, mesh.positions.len()),
                (BUFFER_INDEX, FORMAT_UINT3, mesh.triangles.len()),
            ] {
                let buffer = call!(
                    b"rtcSetNewGeometryBuffer",
                    fn(Handle, i32, u32, i32, usize, usize) -> *mut u8,
                    geometry,
                    slot,
                    0,
                    format,
                    12,
                    count
                );
                let source = if slot == BUFFER_VERTEX {
                    mesh.positions.as_ptr().cast::<u8>()
                } else {
                    mesh.triangles.as_ptr().cast::<u8>()
                };
                std::ptr::copy_nonoverlapping(source, buffer, 12 * count);
            }
            call!(b"rtcCommitGeometry", fn(Handle), geometry);
            call!(
                b"rtcAttachGeometry",
                fn(Handle, Handle) -> u32,
                scene,
                geometry
            );
            call!(b"rtcCommitScene", fn(Handle), scene);
            let intersect1 = *library.get::<Query>(b"rtcIntersect1").ok()?;
            let occluded1 = *library.get::<Query>(b"rtcOccluded1").ok()?;
            Some(Self {
                _library: library,
                scene,
                intersect1,
                occluded1,
            })
        }
    }

    /// Distance of the closest hit, infinite for none.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> f32 {
        let hit = self.query(self.intersect1, ray);
        if hit.geometry == NOTHING {
            f32::INFINITY
        } else {
            hit.tfar
        }
    }

    /// Embree marks an occluded ray by a negative `tfar`.
    #[inline]
    pub(crate) fn is_occluded(&self, ray: &Ray) -> bool {
        self.query(self.occluded1, ray).tfar < 0.0
    }

    #[inline]
    fn query(&self, query: Query, ray: &Ray) -> RayHit {
        let mut context = Context {
            flags: 0,
            filter: null(),
            instance: [NOTHING; 8],
        };
        let mut hit = RayHit {
            o: ray.o.to_array(),
            tnear: 0.0,
            d: ray.d.to_array(),
            time: 0.0,
            tfar: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            ng: [0.0; 3],
            u: 0.0,
            v: 0.0,
            prim: NOTHING,
            geometry: NOTHING,
            instance: NOTHING,
        };
        // SAFETY: `hit` has the layout of RTCRayHit, of which RTCRay is the front.
        unsafe { query(self.scene, &raw mut context, &raw mut hit) };
        hit
    }
}
