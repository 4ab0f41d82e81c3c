//! Benchmarks of Sinew: the scenes P1 to P14 of the table of goals, each also in a naive reference and in other physics engines, measured in one run.
//!
//! ```sh
//! cargo run --release -p sinew_bench -- --plot growth.png
//! cargo run --release -p sinew_bench --features peers -- --peers --only P1,P3 --json rows.json
//! cargo bench -p sinew_bench
//! ```
//!
//! Speeds are compared as ratios, because machines are noisy: the contenders take turns in small portions, CPU time is measured, and the median of the portions
//! is reported. A speed says little without the quality, so every row also has the mean and the largest stretch of the scene after 4 s.
//!
//! | module | content |
//! |---|---|
//! | [`scenes`] | the scenes, one file for each family |
//! | [`naive`] | the reference: an array of structs, sequential, constraints in the given order |
//! | [`peers`] | rapier3d on the same scenes, with the feature `peers`; Avian on the user scenes, with `avian` |
//! | [`measure`] | taking turns, clocks, medians |
//! | [`threads`] | the only place that sets the number of threads of a scene |
//! | [`kernels`] | a table of kernels, for the micro benchmark `kernels` |
//! | [`row`], [`table`], [`growth`] | the figures, the table, the plot |

pub mod growth;
pub mod kernels;
pub mod measure;
pub mod naive;
pub mod peers;
pub(crate) mod places;
pub mod row;
pub mod scenes;
pub mod table;
pub mod threads;
