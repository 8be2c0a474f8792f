//! The target `mask`.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::run("mask", data));
