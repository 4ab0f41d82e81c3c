//! Integration tests through the public interface: one binary, so that it is linked once and its tests run in parallel.
//!
//! | file | subject |
//! |---|---|
//! | `analytic` | comparison with formulas |
//! | `compounds` | explicit rigid bodies, and the conversion between them and particles |
//! | `contacts` | slopes, bounces, and cloth on various shapes |
//! | `far` | behaviour far from the origin is the same |
//! | `impacts` | restitution of particles and bodies together |
//! | `inside` | bodies that start inside a shape are pushed out and not thrown |
//! | `limits` | limits of joints push back and never pull |
//! | `microsteps` | large cloth takes steps of its own within a substep |
//! | `pendulums` | what hangs on one or two pins keeps its energy |
//! | `poured` | a thousand boxes in a heap |
//! | `pressed` | cloth under a rigid shape |
//! | `ragdolls` | figures that fall, lie in heaps, carry loads and collide |
//! | `rest` | a world in which everything sleeps skips its substeps |
//! | `rigid_states` | compounds that move as one rigid state within a step |
//! | `robustness` | guarantees that hold for any input |
//! | `same_bits` | the same bits with any instruction set and number of threads |
//! | `segments` | ropes that collide by their segments |
//! | `sensors` | what sensors report |
//! | `settings` | solver settings of single bodies |
//! | `solver` | comparison of the solver's options |
//! | `surfaces` | edges and triangles against shapes |
//! | `ticks` | ticks of varying length |
//! | `thresholds` | where bounces end and rest begins |
//! | `tied` | cloth on ropes, and loads on cloth |
//! | `wavefronts` | large cloth solved by temporal blocking, on one or several threads |
//!
//! `threads` is a helper of these.

mod analytic;
mod compounds;
mod contacts;
mod far;
mod impacts;
mod inside;
mod limits;
mod microsteps;
mod pendulums;
mod poured;
mod pressed;
mod ragdolls;
mod rest;
mod rigid_states;
mod robustness;
mod same_bits;
mod segments;
mod sensors;
mod settings;
mod solver;
mod surfaces;
mod threads;
mod thresholds;
mod ticks;
mod tied;
mod wavefronts;
