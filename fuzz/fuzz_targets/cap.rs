//! The target `cap`.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz::run("cap", data));
