//! The state of the simulation: which types it is in, how it is captured and put back, and a hash of it.
//!
//! | file | what it holds |
//! |---|---|
//! | `list` | the list: every type of ours that is state |
//! | `types` | [`StateTypes`], which holds that list and what a game adds to it: [`RegisterState`] |
//! | `values` | the values of one type, taken out of a world and put back |
//! | `snapshot` | [`SinewSnapshot`]: all of it at one instant |
//! | `restore` | a snapshot put back, in place or into another app |
//! | `hash` | one number for all of it |
//! | `size` | how much memory it takes |
//! | `file` | snapshots as RON and as bytes, with the feature `serialize` |
//! | `rollback` | rollback netcode, with the feature `ggrs` |
//! | `eased` | what is drawn between two ticks is no state |

mod eased;
#[cfg(feature = "serialize")]
mod file;
mod hash;
mod list;
mod restore;
#[cfg(feature = "ggrs")]
mod rollback;
mod size;
mod snapshot;
mod types;
mod values;

#[cfg(feature = "serialize")]
pub use file::{LoadFault, SaveFault};
pub use restore::RestoreFault;
#[cfg(feature = "ggrs")]
pub use rollback::{RollbackHistory, SinewRollbackPlugin};
pub use snapshot::SinewSnapshot;
pub use types::{RegisterState, StateType, StateTypes};
pub use values::StateRole;

pub(crate) use list::add;
pub(crate) use types::add_constraint;
