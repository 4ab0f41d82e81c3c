//! libFuzzer entry point of [`sinew_fuzz::weld`]: `cargo +nightly fuzz run weld`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| sinew_fuzz::weld(data));
