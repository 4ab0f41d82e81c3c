//! Compounds as solids: boxes of eight particles, hulls of four, bones of two or three, that collide by a shape instead of particle by particle.
//!
//! A solid is a set of particles and a shape in their common frame. Nothing of it moves by itself: in each substep its pose is extracted from where
//! the particles were predicted, contacts correct that pose, and the particles are displaced as the pose was. What is between (what the particles do
//! to each other) is the business of constraints.
//!
//! | file | what it is |
//! |---|---|
//! | `groups` | eight solids at a time, and particles that several share; `weights`: what one weighs, pinned particles, rods |
//! | `guess` | how they are turned, from nowhere; `read`: poses out of particles |
//! | `write` | and back, with momentum |
//! | `bodies` | what contacts know of a solid, or of what stands: columns |
//! | `stands` | colliders, planes and boxes |
//! | `way` | where a solid goes in a step |
//! | `find` | what may come to touch what in it; `astray`: and what does that has left its way |
//! | `meet` | where two of those touch: remembered, or found afresh |
//! | `again` | the same for a pair that has turned |
//! | `found` | colours and packs of manifolds |
//! | `memory` | what is remembered from one step to the next |
//! | `pack` | eight manifolds of one colour |
//! | `mass_ratio` | which of those are pressed more than once in a substep |
//! | `contact` | pressing them apart; `hold`: their friction, with `slip`; `block` solves the few unknowns of one |
//! | `bounce` | restitution, as one problem; `drag`: the lectures' friction |
//! | `loose` | solids and single particles |
//! | `rest_overlap` | parts of one body that overlap at rest, and never touch |
//! | `lost` | what of that does not reach solids that share particles |
//! | `segment` | ropes by their segments |
//! | `told` | for the report |
//! | `turn` | rotations and symmetric matrices of eight solids |

mod again;
mod astray;
mod block;
mod bodies;
mod bounce;
mod contact;
mod drag;
mod find;
mod found;
mod groups;
mod guess;
mod hold;
mod loose;
mod lost;
mod mass_ratio;
mod meet;
mod memory;
mod pack;
mod read;
mod rest_overlap;
mod segment;
mod slip;
mod stands;
#[cfg(test)]
mod tests;
mod told;
mod turn;
mod way;
mod weights;
mod write;

use std::sync::Arc;

use glam::Vec3;

use super::manifold::{Clusters, Scratch};
use super::nearby::Nearby;
use super::{Kept, Shape, World};
use crate::lanes::{InstructionSet, LANES, with};
use crate::particles::Particles;
use astray::Late;
use bodies::Bodies;
use bounce::Impacts;
use contact::Press;
use found::{Found, Sensed};
use groups::Groups;
use hold::{Expect, Hold};
use loose::Loose;
use memory::{Grasp, Memory};
use pack::Pack;
use read::{Gathered, Lifts, Read, Sums};
use rest_overlap::RestOverlaps;
use stands::Stand;
use told::Told;
use way::{Seen, Ways};
use write::{Shared, Write};

pub use memory::{ContactMemory, Remembered};

/// How much overlap is recovered in a substep: so many times what gravity adds to it, and what this speed is, m/s. A tower of so many boxes needs
/// that much, since a sweep hands a push on by one; more at once would be seen as a jump.
const RECOVERED: (f32, f32) = (200.0, 2.0);
/// How much of that may turn into speed.
const POPS: (f32, f32) = (20.0, 0.1);

/// Particles that collide as one, by a shape.
///
/// Where it is and how it is turned follows from where its particles are; they must be held together by constraints. Two particles do not say how it
/// is turned about their line; give such a solid a shape that is round about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Rows of its particles. Several solids may share some; those never touch each other if they are of one body.
    pub rows: Vec<u32>,
    /// Where each of them is in the solid's own frame, metres; as many as `rows`. Shared by solids of the same shape.
    pub rest: Arc<[Vec3]>,
    /// Its shape, in its own frame: anything without dents.
    pub shape: Shape,
    /// What names it where contacts are remembered ([`ContactMemory`]): ascending in the list of solids, whatever comes and goes.
    pub id: u64,
}

/// Why a solid takes part in no contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SolidFault {
    /// It has no rows, or another number of rest positions.
    #[error("it has no particles, or not as many rest positions")]
    Count,
    /// One of its rows is no particle.
    #[error("one of its particles does not exist")]
    MissingParticle,
    /// One of its rows is there twice.
    #[error("one of its particles is there twice")]
    SameParticle,
    /// A rest position is not finite.
    #[error("a rest position is not finite")]
    Number,
    /// A half-space, a mesh or a heightfield: those are for what stands still.
    #[error("a half-space, a mesh or a heightfield cannot move")]
    Shape,
}

/// Contacts of solids in a step. Scratch: nothing of it lasts from one step to the next but what follows from solids and masses alone, and the
/// memory, which is lent for a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solids {
    /// Which instructions its kernels use. It never changes a result.
    pub(crate) instructions: InstructionSet,
    groups: Groups,
    overlaps: RestOverlaps,
    lifts: Lifts,
    bodies: Bodies,
    sums: Vec<Sums>,
    ways: Vec<Ways>,
    gathered: Vec<Gathered>,
    stands: Vec<Stand>,
    floor: Option<Shape>,
    seen: Vec<Seen>,
    near: Kept<Clusters>,
    scratch: Kept<Scratch>,
    bounds: Vec<(Vec3, Vec3)>,
    /// Who has left his way in this substep.
    astray: Vec<u32>,
    late: Late,
    nearby: Vec<[u32; 2]>,
    pairs: Vec<[u32; 2]>,
    found: Vec<Found>,
    sensed: Vec<Sensed>,
    packs: Vec<Pack>,
    memory: Memory,
    loose: Loose,
    shared: Shared,
    told: Vec<Told>,
    used: Vec<u64>,
    order: Vec<u32>,
    begins: Vec<u32>,
    loads: Vec<f32>,
    impacts: Impacts,
    /// Whether contacts were looked for since the last substep.
    fresh: bool,
    /// Length of the last substep, seconds.
    h: f32,
}

impl Solids {
    /// Notes which rows belong to which solids. Faulty ones are left out.
    pub(crate) fn compile(&mut self, solids: &[Solid], particles: &Particles) {
        self.groups.compile(solids, particles);
        self.overlaps.forget();
        self.packs.clear();
        self.found.clear();
        self.loose.clear();
    }

    /// For each row whether it belongs to a solid.
    pub(crate) fn rows(&self) -> &[bool] {
        &self.groups.solid
    }

    /// Whether there are no solids.
    pub(crate) fn is_empty(&self) -> bool {
        self.groups.parts.is_empty()
    }

    /// Between the constraints of a substep of `h` seconds and its velocities: moves solids out of what they ran into.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        (world, nearby): (&World, &Nearby),
        h: f32,
        substep: u32,
    ) {
        if self.is_empty() || self.seen.len() != self.groups.parts.len() {
            return;
        }
        self.h = h;
        let share = |number: u32| number as f32 / world.substeps.max(1) as f32;
        let (from, to) = (share(substep), share(substep + 1));
        self.read(particles, to * world.dt);
        if !self.astray.is_empty() {
            self.look_after(particles, world, nearby, from);
        }
        if self.packs.is_empty() && self.loose.is_empty() {
            return;
        }
        self.place_stands(world, from, to);
        self.compare_again(world, from);
        self.follow_stands(world, from);
        let most = |(falls, speed): (f32, f32)| falls * world.gravity * h * h + speed * h;
        let (recover, pop) = (most(RECOVERED), most(POPS));
        let elastic_pop = POPS.0 * world.gravity * h * h;
        let Self { packs, bodies, instructions, fresh, .. } = self;
        if core::mem::take(fresh) {
            with(*instructions, Expect { packs, bodies });
        }
        with(*instructions, Hold { packs, after: false, most: pop, bodies });
        let pops = [pop, elastic_pop];
        let sweeps = packs.iter().map(|pack| pack.sweeps).max().unwrap_or(0);
        for sweep in 0..sweeps {
            with(*instructions, Press { packs, bodies, h, recover, pops, sweep });
        }
        with(*instructions, Hold { packs, after: true, most: pop, bodies });
        self.loose.project(particles, &self.groups, &mut self.bodies, world, h);
        self.write(particles);
        self.lose(particles);
    }

    /// At the end of a step: what is to be remembered of it.
    pub(crate) fn keep(&mut self, memory: &mut ContactMemory) {
        self.note_grasps(self.h);
        self.memory.give(memory);
    }

    /// Notes what friction holds, after a substep of `h` seconds.
    fn note_grasps(&mut self, h: f32) {
        let Self { packs, found, memory, .. } = self;
        for pack in &*packs {
            for (lane, number) in pack.number.iter().enumerate() {
                if let Some(one) = found.get(*number as usize) {
                    memory.now[one.memory as usize].grasp = Grasp::of(pack, lane, h);
                }
            }
        }
    }

    /// Poses as predicted, and how they got there, so many seconds after the step began; and who has left his way.
    fn read(&mut self, particles: &Particles, time: f32) {
        let Self { groups, lifts, bodies, sums, ways, gathered, astray, instructions, .. } = self;
        astray.clear();
        for (number, group) in groups.groups.iter().enumerate() {
            let read = Read {
                group,
                slots: &groups.slots[group.slots.clone()],
                lifts: lifts.of(group),
                position: &particles.position,
                other: &particles.start,
                fresh: false,
                bodies,
                first: number * LANES,
                sums: &mut sums[number],
                ways: Some((&ways[number], time)),
                gathered,
            };
            let left = with(*instructions, read);
            if left != 0 {
                let lanes = (0..LANES).filter(|lane| left >> lane & 1 == 1);
                let solids = lanes.filter_map(|lane| groups.sound_in(number, lane));
                astray.extend(solids.map(|number| number as u32));
            }
        }
    }

    /// Displaces the particles as their solids were.
    fn write(&mut self, particles: &mut Particles) {
        let Self { groups, lifts, bodies, sums, instructions, shared, .. } = self;
        shared.clear();
        for (number, group) in groups.groups.iter().enumerate() {
            let write = Write {
                group,
                slots: &groups.slots[group.slots.clone()],
                lifts: lifts.of(group),
                position: &mut particles.position,
                velocity: None,
                bodies,
                first: number * LANES,
                sums: &sums[number],
                shared,
            };
            with(*instructions, write);
        }
        for (row, by) in shared.iter() {
            particles.position[row as usize] += by;
        }
    }
}
