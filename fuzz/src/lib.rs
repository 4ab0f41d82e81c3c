//! The fuzz bodies: each turns bytes into a scenario, and panics if the solver breaks a guarantee.
//!
//! | body | scenario | guarantees |
//! |---|---|---|
//! | [`step`] | operations on a world, and steps of unusual lengths | no panics, everything stays finite, refusals change nothing, the same bits twice |
//! | [`weld`] | a mesh, possibly invalid | refused for a reason that applies, or a valid cloth |
//! | [`recipes`] | specs of boxes, ropes, cloth, ragdolls | refused, or a valid blueprint that can be stepped |
//!
//! The bodies do not depend on a fuzzer. libFuzzer (nightly, guided by coverage) runs them through `fuzz_targets/`; `src/bin/smoke.rs` runs them on stable with
//! random bytes. From the root of the repository:
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

/// Runs a scenario from bytes, and panics if a guarantee is broken.
pub type Body = fn(&[u8]);

/// All bodies with their names, for runners that iterate over them.
pub const BODIES: [(&str, Body); 3] = [("step", step), ("weld", weld), ("recipes", recipes)];
