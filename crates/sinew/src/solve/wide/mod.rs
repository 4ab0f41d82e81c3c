//! Constraints other than hard rods, eight side by side: soft distances, ropes and struts, and most other kinds.
//!
//! As [rods](super::rods) are: those of one colour share no particle, so eight of them go at once, in any order. The formula of each is that of its
//! scalar twin in [`constraints`](crate::constraints), to a few units in the last place; how hard it is, is one formula for all ([`compliance`]).
//!
//! - `compliance` is the softness of eight constraints, whatever each one's is;
//! - `constraint_batch` projects eight constraints of one kind, by their values and gradients ([`Wide`](crate::constraints::Wide));
//! - `distance_batch` projects eight distances;
//! - `particle_access` is where the particles of eight are, in memory or in the lanes of an [instance batch](super::instances); `instanced` are the
//!   constraints of those.

mod compliance;
mod constraint_batch;
mod distance_batch;
mod instanced;
mod particle_access;
#[cfg(test)]
mod tests;

use core::ops::Range;
use core::slice::ChunksMut;

use crate::constraints::{
    Angles, Areas, Bends, Cones, Constraint, ConstraintKind, Distance, Hinges, SubstepContext,
    Tetrahedra, Wide,
};
use crate::lanes::{InstructionSet, LANES, Lanes, with};
use crate::particles::Places;
use compliance::PackedCompliance;
use constraint_batch::ConstraintBatch;
use distance_batch::DistanceBatch;
pub(super) use instanced::{InstancedConstraints, InstancedGroup, InstancedGroups};

/// The constraints of a plan that have wide kernels.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConstraintBatches {
    compliances: Vec<PackedCompliance>,
    distances: Vec<DistanceBatch>,
    bends: Vec<ConstraintBatch<Bends, 4>>,
    areas: Vec<ConstraintBatch<Areas, 3>>,
    tetrahedra: Vec<ConstraintBatch<Tetrahedra, 4>>,
    angles: Vec<ConstraintBatch<Angles, 3>>,
    hinges: Vec<ConstraintBatch<Hinges, 4>>,
    cones: Vec<ConstraintBatch<Cones, 5>>,
}

/// Which of them a group has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Which {
    list: BatchList,
    blocks: Range<usize>,
    /// How many of the group's constraints are in a block: eight, or one where they share particles.
    each: usize,
}

/// The lists that there are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BatchList {
    Distances,
    Bends,
    Areas,
    Tetrahedra,
    Angles,
    Hinges,
    Cones,
}

impl ConstraintBatches {
    /// Forgets all, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        let Self { compliances, distances, bends, areas, tetrahedra, angles, hinges, cones } = self;
        compliances.clear();
        distances.clear();
        bends.clear();
        areas.clear();
        tetrahedra.clear();
        angles.clear();
        hinges.clear();
        cones.clear();
    }

    /// Takes the constraints of a group, all of one colour, in their order; `alone` those that share particles: each has a block to itself. `None`
    /// where there is no wide kernel for them, or not the same one for all.
    pub(crate) fn add(&mut self, constraints: &[Constraint], alone: bool) -> Option<Which> {
        let each = if alone { 1 } else { LANES };
        let Self { compliances, bends, areas, tetrahedra, angles, hinges, cones, .. } = self;
        let (list, blocks) = match &constraints.first()?.kind {
            ConstraintKind::Bend(_) => {
                (BatchList::Bends, take(bends, compliances, constraints, each)?)
            }
            ConstraintKind::Area(_) => {
                (BatchList::Areas, take(areas, compliances, constraints, each)?)
            }
            ConstraintKind::Tetrahedron(_) => {
                (BatchList::Tetrahedra, take(tetrahedra, compliances, constraints, each)?)
            }
            ConstraintKind::Angle(_) => {
                (BatchList::Angles, take(angles, compliances, constraints, each)?)
            }
            ConstraintKind::Hinge(_) => {
                (BatchList::Hinges, take(hinges, compliances, constraints, each)?)
            }
            ConstraintKind::Cone(_) => {
                (BatchList::Cones, take(cones, compliances, constraints, each)?)
            }
            _ => return None,
        };
        Some(Which { list, blocks, each })
    }

    /// Takes distances, likewise.
    pub(crate) fn add_distances(&mut self, distances: &[Distance], alone: bool) -> Which {
        let (first, each) = (self.distances.len(), if alone { 1 } else { LANES });
        for eight in distances.chunks(each) {
            self.distances.push(DistanceBatch::of(eight, &mut self.compliances));
        }
        Which { list: BatchList::Distances, blocks: first..self.distances.len(), each }
    }

    /// Projects a group once; `all_multipliers` are what its constraints have summed up, in their order. Returns the largest error found, metres; of
    /// soft ones, how far they moved.
    pub(crate) fn sweep(
        &self,
        places: &mut Places,
        which: &Which,
        all_multipliers: &mut [f32],
        substep_context: SubstepContext,
        instructions: InstructionSet,
    ) -> f32 {
        let multipliers = Some(all_multipliers.chunks_mut(which.each));
        self.pass(places, which, multipliers, substep_context, instructions)
    }

    /// How far the hard ones of a group are from being kept, metres, the largest; moves nothing.
    pub(crate) fn measure(
        &self,
        places: &mut Places,
        which: &Which,
        instructions: InstructionSet,
    ) -> f32 {
        self.pass(places, which, None, MEASURING, instructions)
    }

    fn pass(
        &self,
        places: &mut Places,
        which: &Which,
        multipliers: Option<ChunksMut<f32>>,
        substep_context: SubstepContext,
        instructions: InstructionSet,
    ) -> f32 {
        let range = which.blocks.clone();
        let Self { compliances, distances, bends, areas, tetrahedra, angles, hinges, cones } = self;
        macro_rules! pass {
            ($kernel:ident of $list:ident) => {{
                let blocks = &$list[range];
                with(
                    instructions,
                    $kernel::SweepBatch {
                        blocks,
                        compliances,
                        places,
                        multipliers,
                        substep_context,
                    },
                )
            }};
        }
        match which.list {
            BatchList::Distances => pass!(distance_batch of distances),
            BatchList::Bends => pass!(constraint_batch of bends),
            BatchList::Areas => pass!(constraint_batch of areas),
            BatchList::Tetrahedra => pass!(constraint_batch of tetrahedra),
            BatchList::Angles => pass!(constraint_batch of angles),
            BatchList::Hinges => pass!(constraint_batch of hinges),
            BatchList::Cones => pass!(constraint_batch of cones),
        }
    }
}

/// What is measured has no substep: nothing of it is read.
const MEASURING: SubstepContext = SubstepContext { h: 0.0, sweeps: 1 };

/// Appends blocks of `each` constraints, or nothing if not all of them fit.
fn take<W: Wide<N>, const N: usize>(
    blocks: &mut Vec<ConstraintBatch<W, N>>,
    compliances: &mut Vec<PackedCompliance>,
    constraints: &[Constraint],
    each: usize,
) -> Option<Range<usize>> {
    let first = blocks.len();
    for some in constraints.chunks(each) {
        let Some(block) = ConstraintBatch::of(some, compliances) else {
            blocks.truncate(first);
            return None;
        };
        blocks.push(block);
    }
    Some(first..blocks.len())
}

/// The number of a packed compliance, which is the last one's if they are the same: so bodies of one softness have one, which stays in the cache.
fn number(compliances: &mut Vec<PackedCompliance>, packed_compliance: PackedCompliance) -> u32 {
    if compliances.last() != Some(&packed_compliance) {
        compliances.push(packed_compliance);
    }
    (compliances.len() - 1) as u32
}

/// Rows as places in slices that begin with the row `first`; in `room` if they are others. Those in memory are left there: a copy would go into a
/// register, and from there, more slowly, lane by lane to where addresses are made.
#[inline(always)]
fn less<'a, const N: usize>(
    rows: &'a [[u32; LANES]; N],
    first: u32,
    room: &'a mut [[u32; LANES]; N],
) -> &'a [[u32; LANES]; N] {
    if first == 0 {
        return rows;
    }
    for (to, from) in room.iter_mut().zip(rows) {
        for (to, from) in to.iter_mut().zip(from) {
            *to = from.wrapping_sub(first);
        }
    }
    room
}

/// Does something for each of up to five particles, with its number a constant: a loop that the compiler may choose not to unroll keeps all vectors
/// in memory.
macro_rules! each {
    ($i:ident of $n:ident $body:block) => {
        each!(@ $i $n $body 0 1 2 3 4)
    };
    ($i:ident of $n:ident backwards $body:block) => {
        each!(@ $i $n $body 4 3 2 1 0)
    };
    (@ $i:ident $n:ident $body:block $($number:literal)*) => {
        $(if $number < $n {
            let $i = $number;
            $body
        })*
    };
}

use each;

/// What one to eight constraints have summed up; the first one's again where there are fewer.
#[inline(always)]
fn load_sums<L: Lanes>(multipliers: &[f32]) -> L {
    match multipliers.try_into() {
        Ok(eight) => L::load(eight),
        Err(_) => {
            let mut eight = [multipliers.first().copied().unwrap_or(0.0); LANES];
            for (to, from) in eight.iter_mut().zip(multipliers) {
                *to = *from;
            }
            L::load(&eight)
        }
    }
}

/// Writes them back.
#[inline(always)]
fn store_sums<L: Lanes>(lanes: L, multipliers: &mut [f32]) {
    if let Ok(eight) = <&mut [f32; LANES]>::try_from(&mut *multipliers) {
        lanes.store(eight);
    } else {
        for (to, from) in multipliers.iter_mut().zip(lanes.array()) {
            *to = from;
        }
    }
}
