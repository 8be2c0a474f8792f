//! The target `exr`.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::run("exr", data));
