//! What is fuzzed: each body takes bytes, makes a scenario of them, and panics if a promise of the solver is broken.
//!
//! | body | bytes become | promises |
//! |---|---|---|
//! | [`step`] | operations on a world, and steps of odd lengths | nothing panics, all stays finite, refusals change nothing, same bits twice |
//! | [`weld`] | a mesh, as broken as can be | refused for a reason that is there, or a cloth in order |
//! | [`recipes`] | specs of boxes, ropes, cloth, ragdolls | refused, or a blueprint in order that can be stepped |
//!
//! The bodies know no fuzzer. libFuzzer (nightly, guided by coverage) runs them through `fuzz_targets/`; `src/bin/smoke.rs` runs
//! them on stable with bytes by chance. From the root of the repository:
//!
//! ```text
//! cargo +nightly fuzz run step                                    until something is found
//! cargo +nightly fuzz run step fuzz/artifacts/step/crash-...       a finding again, with its backtrace
//! cargo run --release --manifest-path fuzz/Cargo.toml --no-default-features --bin smoke -- --seconds 20
//! ```
//!
//! A finding becomes a test in the crate that it concerns, named after what went wrong; inputs are not kept.

mod constraints;
mod contacts;
mod input;
mod recipes;
mod step;
mod weld;

pub use recipes::recipes;
pub use step::step;
pub use weld::weld;

/// A scenario out of bytes, which panics if a promise is broken.
pub type Body = fn(&[u8]);

/// All bodies with their names, for runners that take them in turn.
pub const BODIES: [(&str, Body); 3] = [("step", step), ("weld", weld), ("recipes", recipes)];
