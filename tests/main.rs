//! Sinew in a Bevy app with `MinimalPlugins`, without a window: one binary, so that Bevy is linked once.
//!
//! | file | the story |
//! |---|---|
//! | `phases` | the phases run in their order, substeps times a tick, and a game's own systems fit in between |
//! | `state` | all state lives in components: clone them, put them back, and everything happens again, bit for bit |
//! | `bad_input` | what is wrong is set aside with one message that names it, and nothing else notices |
//! | `bad_recipes` | bodies that cannot be built say so once |
//! | `runtime_changes` | particles, springs, constraints and bodies come, change and go while time runs |
//! | `in_use` | what is despawned while it is in use, before and after every set |
//! | `recipes` | boxes, ropes, cloth and ragdolls build themselves, are built anew when changed, and are teleported |
//! | `pictures` | meshes and transforms follow, between ticks too |
//! | `unrelated` | what has nothing to do with a body does not change a bit of it |
//! | `frame_rate` | neither does the frame rate |
//! | `models` | real meshes from outside become cloth |
//! | `scenes` | the scenes of the gallery keep what their captions promise |
//! | `schedules` | no two systems of ours race |
//!
//! `support` holds what they share.

mod bad_input;
mod bad_recipes;
mod frame_rate;
mod in_use;
mod models;
mod phases;
mod pictures;
mod recipes;
mod runtime_changes;
mod scenes;
mod schedules;
mod snapshot;
mod state;
mod support;
mod unrelated;
