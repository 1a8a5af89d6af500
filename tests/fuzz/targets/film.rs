#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| shearwater_fuzz::film(data));
