//! The state of the simulation: which types it consists of, how it is captured and restored, and its hash.
//!
//! | file | contents |
//! |---|---|
//! | `list` | the list of all types of this crate that are state |
//! | `types` | [`StateTypes`], which has that list and the types that a game adds: [`RegisterState`] |
//! | `values` | the values of one type, copied out of a world and back |
//! | `snapshot` | [`SinewSnapshot`]: the whole state at one instant |
//! | `restore` | restoring a snapshot, in place or into another app |
//! | `hash` | the hash of the state |
//! | `size` | the memory that a snapshot takes |
//! | `file` | snapshots as RON and as bytes, with the feature `serialize` |
//! | `rollback` | rollback netcode, with the feature `ggrs` |
//! | `eased` | interpolated transforms are not state |

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

pub(crate) use eased::forget as forget_eased;
pub(crate) use hash::{FNV_START, fnv};
pub(crate) use list::add;
pub(crate) use types::add_constraint;
