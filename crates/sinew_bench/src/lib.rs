//! How fast Sinew is: the scenes P1 to P14 of the table of goals, each next to the naive way and to a rival, measured in one run.
//!
//! ```sh
//! cargo run --release -p sinew_bench -- --plot growth.png
//! cargo run --release -p sinew_bench --features peers -- --peers --only P1,P3 --json rows.json
//! cargo bench -p sinew_bench
//! ```
//!
//! A speed is a ratio, because machines are noisy: the contenders take turns in small portions, what counts is CPU time, and the median of the
//! portions is told. A speed says nothing without its price, so every row has the mean and the largest stretch of the scene after 4 s beside it.
//!
//! | file | what of it |
//! |---|---|
//! | [`scenes`] | what is measured; a file a family |
//! | [`naive`] | the reference: an array of structs, in sequence, constraints in the order given |
//! | [`peers`] | rapier3d on the same scenes, with the feature `peers`; Avian on those of a user, with `avian` |
//! | [`measure`] | taking turns, clocks, the median |
//! | [`threads`] | the one place where a scene is given threads |
//! | [`kernels`] | a table of kernels, for the micro benchmark `kernels` |
//! | [`row`], [`table`], [`growth`] | the figures, the page, the picture |

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
