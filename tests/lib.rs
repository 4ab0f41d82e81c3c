//! The suites that run Sinew in a Bevy app with `MinimalPlugins`. They are one test binary, `app`: see `main.rs`. This library holds what tests of other crates
//! use, too.

pub mod pointer;
