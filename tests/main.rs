//! Tests of Sinew in a Bevy app with `MinimalPlugins`, without a window. They are one binary, so that Bevy is linked once.
//!
//! | file | what it tests |
//! |---|---|
//! | `allocations` | a warm tick allocates nothing |
//! | `attach` | attachments to bones, ends of ropes, vertices and corners: built, kept, released |
//! | `bad_commands` | commands that cannot be carried out are refused, and nothing changes |
//! | `bad_input` | bad input is set aside with one message that names it, and affects nothing else |
//! | `bad_recipes` | bodies that cannot be built are refused once |
//! | `bevy_version` | what Bevy names differently from version to version |
//! | `breaking` | constraints and attachments break at the load that statics predicts |
//! | `character` | move and slide: a game's own character on grounds, against walls and bodies |
//! | `colliders` | colliders hold, carry and let through; bodies collide by their shape or their particles |
//! | `colliders_live` | colliders are added, removed, moved, broken and rolled back while they are in use |
//! | `columns` | the columns equal the components, though a warm tick copies little |
//! | `commands` | impulses, velocities, teleports and reversal of bodies have their documented effect, or none |
//! | `constraints` | every constraint of the solver as a component |
//! | `contact_events` | contact events, spatial queries, sleeping bodies |
//! | `contacts_by_default` | what collides with what by default, and what changes it |
//! | `contacts_state` | contacts are rolled back like everything else |
//! | `controls` | control forces accelerate by F/m and τ/I |
//! | `disabled` | what a game disables leaves the simulation, and comes back |
//! | `every_setting` | integrators, orders, gradients, steps of any length, phases with conditions, surfaces for a wind |
//! | `files` | snapshots are written to RON and to bytes and read back; broken or foreign files are refused |
//! | `first_minutes` | what a new user tries first, with nothing configured |
//! | `forces` | every force of the solver as a component or a resource agrees with physics |
//! | `forces_live` | forces edited, broken and rolled back while they are in use |
//! | `frame_rate` | the frame rate changes no bit |
//! | `gameplay` | impulses of every tick, shape casts, the weight of what a game moves |
//! | `grounds` | a ground and a bounding box are colliders like others |
//! | `hierarchy` | bodies, colliders and regions are where their parents put them |
//! | `in_use` | despawning what is in use, before and after every set |
//! | `internals` | internal pieces of the plugin |
//! | `message_order` | messages of a tick arrive in the order of creation |
//! | `models` | real meshes from outside become cloth |
//! | `motion` | velocities, forces and impulses are read and written; properties of a body are shared out onto its particles |
//! | `mouse` | what a pointer grabs, how it holds it, and what it ignores |
//! | `own_constraints` | a game's own constraints: one registration, one order, one state |
//! | `phases` | the phases run in their order, substeps times a tick, and a game's own systems fit in between |
//! | `pictures` | meshes and transforms follow, between ticks too |
//! | `pinned_inside` | what is pinned inside of something that it collides with stays calm |
//! | `prelude` | the prelude is short and shares no name with Bevy's |
//! | `recipes` | boxes, ropes, cloth and ragdolls build themselves, are built anew when changed, and are teleported |
//! | `recipes_soft` | solids of any shape, soft bodies and articulated bodies build themselves |
//! | `representation` | a body swaps between particles and a rigid body in any tick, without a jump |
//! | `rollback` | each frame rolled back and simulated again is the same, through `bevy_ggrs` (with the feature `ggrs`, the default) |
//! | `rollback_game` | the game of `rollback` and `sync_test` |
//! | `runtime_changes` | particles, springs, constraints and bodies are added, changed and removed while time runs |
//! | `saved` | the whole state is captured and restored, in place and into a fresh app, and goes on bit for bit |
//! | `scenes` | the scenes of the gallery keep what their captions promise |
//! | `schedules` | no two systems of Sinew race |
//! | `segments` | ropes collide by their segments |
//! | `solver` | settings and reports of worlds and bodies; worlds five kilometres from the origin |
//! | `state` | all state is in components: cloned and restored, everything happens again, bit for bit |
//! | `state_list` | every component and resource is in the list of state |
//! | `statics` | bodies and worlds are brought to rest at once |
//! | `sync_test` | the same as `rollback` by snapshots alone (without that feature) |
//! | `threads` | the number of threads changes no bit |
//! | `time` | the simulation's own speed and pause |
//! | `torn` | what is added, removed or changed one by one among thousands is updated incrementally |
//! | `triangles` | bodies collide by their triangles |
//! | `unrelated` | what has nothing to do with a body does not change a bit of it |
//! | `wakes` | a sleeping body wakes when a game does something to it, and nothing else does |
//!
//! `support` and `snapshot` hold what they share; `pointer`, which tests of other crates use too, is in the library (`lib.rs`).

mod allocations;
mod attach;
mod bad_commands;
mod bad_input;
mod bad_recipes;
mod bevy_version;
mod breaking;
mod character;
mod colliders;
mod colliders_live;
mod columns;
mod commands;
mod constraints;
mod contact_events;
mod contacts_by_default;
mod contacts_state;
mod controls;
mod disabled;
mod every_setting;
mod files;
mod first_minutes;
mod forces;
mod forces_live;
mod frame_rate;
mod gameplay;
mod grounds;
mod hierarchy;
mod in_use;
mod internals;
mod message_order;
mod models;
mod motion;
mod mouse;
mod own_constraints;
mod phases;
mod pictures;
mod pinned_inside;
mod prelude;
mod recipes;
mod recipes_soft;
mod representation;
#[cfg(feature = "ggrs")]
mod rollback;
mod rollback_game;
mod runtime_changes;
mod saved;
mod scenes;
mod schedules;
mod segments;
mod snapshot;
mod solver;
mod state;
mod state_list;
mod statics;
mod support;
#[cfg(not(feature = "ggrs"))]
mod sync_test;
mod threads;
mod time;
mod torn;
mod triangles;
mod unrelated;
mod wakes;
