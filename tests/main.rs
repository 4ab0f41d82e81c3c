//! Sinew in a Bevy app with `MinimalPlugins`, without a window: one binary, so that Bevy is linked once.
//!
//! | file | the story |
//! |---|---|
//! | `allocations` | a warm tick asks for no memory |
//! | `attach` | what is tied by saying so: bones, ends of ropes, vertices, corners; built, kept, let go |
//! | `breaking` | what breaks does so under the weight that physics says |
//! | `phases` | the phases run in their order, substeps times a tick, and a game's own systems fit in between |
//! | `state` | all state lives in components: clone them, put them back, and everything happens again, bit for bit |
//! | `bevy_version` | what Bevy names differently from version to version |
//! | `saved` | the whole state is captured and put back, in place and into a fresh app: all goes on bit for bit |
//! | `files` | snapshots go to RON and to bytes and back; what is broken or foreign is refused |
//! | `rollback_game` | the game of the next two |
//! | `rollback` | each frame rolled back and simulated again is the same, through `bevy_ggrs` (with the feature `ggrs`, as by default) |
//! | `sync_test` | the same by snapshots alone (without that feature) |
//! | `state_list` | every component and resource of ours is in the list of what is state |
//! | `bad_input` | what is wrong is set aside with one message that names it, and nothing else notices |
//! | `bad_commands` | what cannot be done to a body is refused, and nothing changes |
//! | `bad_recipes` | bodies that cannot be built say so once |
//! | `columns` | the columns are what the components say, though little is copied in a warm tick |
//! | `runtime_changes` | particles, springs, constraints and bodies come, change and go while time runs |
//! | `every_setting` | integrators, orders, gradients, steps of any length, phases with conditions, surfaces for a wind |
//! | `gameplay` | impulses of every tick, shapes on their way, the weight of what a game moves |
//! | `grounds` | a ground and a room are colliders like others |
//! | `character` | move and slide: a character of a game's own on grounds, against walls and bodies |
//! | `first_minutes` | what a new user meets with nothing configured |
//! | `hierarchy` | bodies, colliders and regions stand where their parents put them |
//! | `motion` | velocities, forces and impulses go both ways; what a body says is shared out onto its particles |
//! | `contacts_by_default` | who meets whom where nobody says so |
//! | `colliders` | colliders hold, carry and let through; bodies collide by their shape or their particles |
//! | `colliders_live` | colliders come, go, move, break and are rolled back while they are in use |
//! | `constraints` | every law of the solver is a component that does what it says |
//! | `own_constraints` | a game's own constraints: one door, one order, one state |
//! | `commands` | impulses, velocities, teleports and reversal of bodies do what they say, or nothing |
//! | `controls` | control forces accelerate what they act on |
//! | `in_use` | what is despawned while it is in use, before and after every set |
//! | `mouse` | what a pointer catches, how it is held, and what is left alone |
//! | `internals` | pieces of the plugin that no game can see |
//! | `recipes` | boxes, ropes, cloth and ragdolls build themselves, are built anew when changed, and are teleported |
//! | `recipes_soft` | solids of any shape, soft bodies and articulated ones build themselves |
//! | `representation` | a body swaps between particles and a rigid body in any tick, and nothing jumps |
//! | `solver` | settings and reports of worlds and bodies; five kilometres from the origin it is as at home |
//! | `pictures` | meshes and transforms follow, between ticks too |
//! | `pinned_inside` | what is held inside of something that it collides with stays in peace |
//! | `unrelated` | what has nothing to do with a body does not change a bit of it |
//! | `forces` | every force of the solver is a component or a resource that does what physics asks |
//! | `forces_live` | forces edited, broken and rolled back while they are in use |
//! | `frame_rate` | neither does the frame rate |
//! | `message_order` | what a game hears of in a tick comes in the order of creation |
//! | `models` | real meshes from outside become cloth |
//! | `scenes` | the scenes of the gallery keep what their captions promise |
//! | `schedules` | no two systems of ours race |
//! | `statics` | bodies and worlds are brought to rest at once |
//! | `time` | a speed and a pause of the simulation's own |
//! | `segments` | ropes collide by their segments where they ask for it |
//! | `threads` | neither does the number of threads |
//! | `torn` | what comes, goes or changes one by one among thousands is mended into them |
//! | `wakes` | what sleeps wakes when a game does something to it, and nothing else does |
//! | `triangles` | bodies collide by their triangles where they ask for it |
//!
//! `support` holds what they share.

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
