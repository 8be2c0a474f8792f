//! The target `sphere_set`.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::run("sphere_set", data));
