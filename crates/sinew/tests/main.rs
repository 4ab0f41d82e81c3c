//! The solver from outside, through its public interface alone: one binary, so that it is linked once and its tests run side by side.
//!
//! | file | the story |
//! |---|---|
//! | `analytic` | against formulas |
//! | `compounds` | explicit rigid bodies, and the swap between them and particles |
//! | `contacts` | slopes, bounces, and cloth on whatever there is |
//! | `far` | far from the origin it is as at home |
//! | `inside` | what begins inside of something is put out and not thrown |
//! | `microsteps` | large cloth takes steps of its own within a substep |
//! | `poured` | a thousand boxes in a heap |
//! | `pressed` | cloth that a rigid shape presses on |
//! | `ragdolls` | figures that fall, lie in heaps, carry and meet |
//! | `rest` | a world in which all sleep takes its steps at once |
//! | `rigid_states` | compounds that move as one rigid state within a step |
//! | `robustness` | what must not happen, whatever a caller does |
//! | `same_bits` | the same bits on any instructions and any number of threads |
//! | `segments` | ropes by their segments |
//! | `settings` | what bodies ask for themselves |
//! | `solver` | its choices against each other |
//! | `ticks` | ticks of changing length |
//! | `tied` | cloth on ropes, and what hangs on cloth |
//! | `wavefronts` | large cloth through a step in columns, and from thread to thread |
//!
//! `threads` is what they are helped by.

mod analytic;
mod compounds;
mod contacts;
mod far;
mod inside;
mod microsteps;
mod poured;
mod pressed;
mod ragdolls;
mod rest;
mod rigid_states;
mod robustness;
mod same_bits;
mod segments;
mod settings;
mod solver;
mod threads;
mod ticks;
mod tied;
mod wavefronts;
