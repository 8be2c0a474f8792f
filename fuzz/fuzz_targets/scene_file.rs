//! The target `scene_file`.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::run("scene_file", data));
