//! FFTW 3 in single precision through its C interface, if the machine has it.
//!
//! `unsafe` because it calls a foreign library; this is a measurement, nothing of
//! it is in the product. Signatures are those of the public header fftw3.h.
#![allow(unsafe_code)]

use libloading::Library;
use std::ffi::{c_int, c_uint, c_void};

const NAMES: [&str; 3] = ["libfftw3f.so.3", "libfftw3f.so", "libfftw3f.dylib"];
/// `FFTW_MEASURE`: plans by timing several algorithms.
const MEASURE: c_uint = 0;

/// Three transforms from half a complex spectrum to a real field.
pub(crate) struct Fftw {
    _library: Library,
    execute: unsafe extern "C" fn(*mut c_void),
    plans: Vec<*mut c_void>,
    // The plans point into these.
    _spectra: Vec<Vec<[f32; 2]>>,
    _fields: Vec<Vec<f32>>,
}

type PlanReal = unsafe extern "C" fn(c_int, c_int, *mut [f32; 2], *mut f32, c_uint) -> *mut c_void;

impl Fftw {
    /// Plans of n x n points; none if the library is not there.
    pub(crate) fn new(n: usize) -> Option<Self> {
        let side = c_int::try_from(n).ok()?;
        // SAFETY: the functions have the types of fftw3.h; the buffers are as large as
        // it asks for, n (n/2 + 1) complex and n^2 real numbers, and live as long as
        // the plans, on the heap, where moving this struct leaves them.
        unsafe {
            let library = NAMES.iter().find_map(|&name| Library::new(name).ok())?;
            let plan = *library.get::<PlanReal>(b"fftwf_plan_dft_c2r_2d").ok()?;
            let execute = *library
                .get::<unsafe extern "C" fn(*mut c_void)>(b"fftwf_execute")
                .ok()?;
            let mut spectra = vec![vec![[0.0; 2]; n * (n / 2 + 1)]; 3];
            let mut fields = vec![vec![0.0; n * n]; 3];
            let mut plans = Vec::new();
            for (from, to) in spectra.iter_mut().zip(&mut fields) {
                let plan = plan(side, side, from.as_mut_ptr(), to.as_mut_ptr(), MEASURE);
                if plan.is_null() {
                    return None;
                }
                plans.push(plan);
                from.fill([0.5, 0.25]);
            }
            Some(Self {
                _library: library,
                execute,
                plans,
                _spectra: spectra,
                _fields: fields,
            })
        }
    }

    /// All three.
    pub(crate) fn run(&mut self) {
        for &plan in &self.plans {
            // SAFETY: the plan and its buffers are alive.
            unsafe { (self.execute)(plan) }
        }
    }
}
