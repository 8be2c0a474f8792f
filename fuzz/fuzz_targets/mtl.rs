//! The target `mtl`.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::run("mtl", data));
