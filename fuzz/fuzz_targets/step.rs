//! libFuzzer entry point of [`sinew_fuzz::step`]: `cargo +nightly fuzz run step`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| sinew_fuzz::step(data));
