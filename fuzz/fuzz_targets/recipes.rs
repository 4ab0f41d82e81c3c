//! libFuzzer entry point of [`sinew_fuzz::recipes`]: `cargo +nightly fuzz run recipes`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| sinew_fuzz::recipes(data));
