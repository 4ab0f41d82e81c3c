//! libFuzzer's door to [`sinew_fuzz::step`]: `cargo +nightly fuzz run step`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| sinew_fuzz::step(data));
