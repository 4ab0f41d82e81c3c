//! Constraints other than hard rods, solved eight at a time: compliant distances, ropes and struts, and most other kinds.
//!
//! As with [rods](super::rods), constraints of one colour share no particle, so eight of them are solved at once, in any order. The formula of each kind is
//! that of its scalar twin in [`constraints`](crate::constraints), to within a few units in the last place. Softness is one formula for all kinds
//! ([`compliance`]).
//!
//! - `compliance` is the softness of eight constraints, which may all differ.
//! - `wide_constraint` projects eight constraints of one kind by their values and gradients ([`Wide`]); `wide_distance` projects eight distances.
//! - `particle_access` reads and writes the particles of eight constraints, in memory or in the lanes of an [instance batch](super::instances).
//! - This module has the lists of batches and sweeps those of a plan; `instanced` sweeps those of instance batches, `loose_distances` those in columns.

mod compliance;
mod instanced;
mod loose_distances;
mod particle_access;
#[cfg(test)]
mod tests;
mod wide_constraint;
mod wide_distance;

use core::fmt::Debug;
use core::ops::Range;
use core::slice::ChunksMut;

use crate::constraints::{
    Angles, Areas, Bends, Cones, Constraint, ConstraintKind, Distance, FromKind, Hinges,
    SubstepContext, Tetrahedra, Wide,
};
use crate::lanes::{InstructionSet, LANES, Lanes, Work, with};
use crate::particles::Places;
use compliance::{PackedCompliance, Shares};
pub(super) use instanced::{InstancedConstraints, InstancedGroup, InstancedGroups};
pub(super) use loose_distances::{LooseCounts, LooseDistances, sweep_loose};
use particle_access::{GatheredParticles, ParticleAccess};
use wide_constraint::WideConstraint;
use wide_distance::WideDistance;

/// How the particles of eight constraints are addressed.
pub(crate) trait Addressing {
    /// The addresses of the particles of eight constraints of `N` particles each.
    type Of<const N: usize>: Clone + Debug;
}

/// By rows: each lane has its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct ByRows;

impl Addressing for ByRows {
    type Of<const N: usize> = [[u32; LANES]; N];
}

/// Constraints that have wide kernels, in one list for each kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct BatchLists<A: Addressing> {
    compliances: Vec<PackedCompliance>,
    distances: Vec<Batch<A::Of<2>, WideDistance>>,
    bends: Vec<Batch<A::Of<4>, WideConstraint<Bends>>>,
    areas: Vec<Batch<A::Of<3>, WideConstraint<Areas>>>,
    tetrahedra: Vec<Batch<A::Of<4>, WideConstraint<Tetrahedra>>>,
    angles: Vec<Batch<A::Of<3>, WideConstraint<Angles>>>,
    hinges: Vec<Batch<A::Of<4>, WideConstraint<Hinges>>>,
    cones: Vec<Batch<A::Of<5>, WideConstraint<Cones>>>,
}

/// The lists of [`BatchLists`].
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

/// Evaluates an expression with one of the lists, whatever its element type; optionally another expression for the list of distances.
macro_rules! on_list {
    ($by:tt $lists:ident, $which:expr, |$list:ident| $body:expr) => {
        on_list!($by $lists, $which, |$list| $body, {
            let $list = on_list!(@ $by $lists.distances);
            $body
        })
    };
    ($by:tt $lists:ident, $which:expr, |$list:ident| $body:expr, $distances:expr) => {
        match $which {
            BatchList::Distances => $distances,
            BatchList::Bends => { let $list = on_list!(@ $by $lists.bends); $body }
            BatchList::Areas => { let $list = on_list!(@ $by $lists.areas); $body }
            BatchList::Tetrahedra => { let $list = on_list!(@ $by $lists.tetrahedra); $body }
            BatchList::Angles => { let $list = on_list!(@ $by $lists.angles); $body }
            BatchList::Hinges => { let $list = on_list!(@ $by $lists.hinges); $body }
            BatchList::Cones => { let $list = on_list!(@ $by $lists.cones); $body }
        }
    };
    (@ [$($by:tt)*] $lists:ident.$list:ident) => { $($by)* $lists.$list };
}

use on_list;

/// One to eight constraints of one kind. Unused lanes repeat the first constraint: they compute and write the same values.
#[derive(Clone, Debug)]
struct Batch<P, E> {
    /// The particles they act on.
    particles: P,
    eight: E,
    /// Index of their packed compliance.
    packed_compliance: u32,
}

/// Eight constraints of one kind with `N` particles each, without the particles.
trait WideKernel<const N: usize> {
    /// Projects them once. Returns the errors found. Without multipliers nothing is moved, and it returns the errors of the hard ones, metres, and for
    /// distances the same as shares of the rest lengths.
    fn project<L: Lanes>(
        &self,
        context: KernelContext<L>,
        particles: &mut impl ParticleAccess<N>,
        multipliers: Option<&mut [f32]>,
    ) -> (L, L);
}

/// Parameters of a wide kernel: the packed compliance, the share of each lane in a sweep, the substep in seconds, and a mask of lanes that may be written with
/// anything.
type KernelContext<'a, L> = (&'a PackedCompliance, &'a [f32; LANES], f32, L);

impl<P, E> Batch<P, E> {
    fn new(
        particles: P,
        (eight, packed_compliance): (E, PackedCompliance),
        compliances: &mut Vec<PackedCompliance>,
    ) -> Self {
        Self { particles, eight, packed_compliance: index_of(compliances, packed_compliance) }
    }
}

impl BatchList {
    /// The list for a kind; `None` if it has no wide kernel.
    fn of(kind: &ConstraintKind) -> Option<Self> {
        Some(match kind {
            ConstraintKind::Bend(_) => Self::Bends,
            ConstraintKind::Area(_) => Self::Areas,
            ConstraintKind::Tetrahedron(_) => Self::Tetrahedra,
            ConstraintKind::Angle(_) => Self::Angles,
            ConstraintKind::Hinge(_) => Self::Hinges,
            ConstraintKind::Cone(_) => Self::Cones,
            _ => return None,
        })
    }
}

/// Lengths of the lists: compliances, then each kind of constraint.
pub(crate) type BatchCounts = [usize; 8];

impl<A: Addressing> BatchLists<A> {
    pub(super) fn counts(&self) -> BatchCounts {
        let Self { compliances, distances, bends, areas, tetrahedra, angles, hinges, cones } = self;
        [
            compliances.len(),
            distances.len(),
            bends.len(),
            areas.len(),
            tetrahedra.len(),
            angles.len(),
            hinges.len(),
            cones.len(),
        ]
    }

    /// Drops everything that was added after the lists had these lengths, and keeps the memory.
    pub(super) fn truncate(&mut self, counts: &BatchCounts) {
        let Self { compliances, distances, bends, areas, tetrahedra, angles, hinges, cones } = self;
        compliances.truncate(counts[0]);
        distances.truncate(counts[1]);
        bends.truncate(counts[2]);
        areas.truncate(counts[3]);
        tetrahedra.truncate(counts[4]);
        angles.truncate(counts[5]);
        hinges.truncate(counts[6]);
        cones.truncate(counts[7]);
    }
}

/// Appends all elements, or none if one of them is `None`.
fn append<T>(list: &mut Vec<T>, all: impl Iterator<Item = Option<T>>) -> Option<Range<usize>> {
    let first = list.len();
    for one in all {
        let Some(one) = one else {
            list.truncate(first);
            return None;
        };
        list.push(one);
    }
    Some(first..list.len())
}

/// The constraints of a plan that have wide kernels.
pub(crate) type ConstraintBatches = BatchLists<ByRows>;

/// The batches that belong to one group of constraints.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BatchRange {
    list: BatchList,
    blocks: Range<usize>,
    /// How many of the group's constraints are in a batch: eight, or one if they share particles.
    each: usize,
}

impl ConstraintBatches {
    /// Adds the constraints of a group, all of one colour, in order. With `shared` the constraints share particles, and each gets a batch to itself. `None` if
    /// they have no wide kernel or differ in kind.
    pub(crate) fn add(&mut self, constraints: &[Constraint], shared: bool) -> Option<BatchRange> {
        let each = if shared { 1 } else { LANES };
        let list = BatchList::of(&constraints.first()?.kind)?;
        let compliances = &mut self.compliances;
        let blocks = on_list!(
            [&mut] self,
            list,
            |batches| {
                let all = constraints.chunks(each).map(|some| gathered(some, compliances));
                append(batches, all)?
            },
            return None
        );
        Some(BatchRange { list, blocks, each })
    }

    /// Adds the distances of a group, likewise.
    pub(crate) fn add_distances(&mut self, distances: &[Distance], shared: bool) -> BatchRange {
        let (first, each) = (self.distances.len(), if shared { 1 } else { LANES });
        for some in distances.chunks(each) {
            let eight: [&Distance; LANES] =
                core::array::from_fn(|lane| some.get(lane).unwrap_or(&some[0]));
            let rows = [eight.map(|d| d.a), eight.map(|d| d.b)];
            self.distances.push(Batch::new(rows, WideDistance::of(eight), &mut self.compliances));
        }
        BatchRange { list: BatchList::Distances, blocks: first..self.distances.len(), each }
    }

    /// Projects a group once. `all_multipliers` are those of its constraints, in order. Returns the largest error found, metres; for compliant ones the largest
    /// correction.
    pub(crate) fn sweep(
        &self,
        places: &mut Places,
        which: &BatchRange,
        all_multipliers: &mut [f32],
        substep_context: SubstepContext,
        instructions: InstructionSet,
    ) -> f32 {
        let multipliers = Some(all_multipliers.chunks_mut(which.each));
        self.pass(places, which, multipliers, substep_context, instructions)
    }

    /// The largest error of the hard constraints of a group, metres. Moves nothing.
    pub(crate) fn measure(
        &self,
        places: &mut Places,
        which: &BatchRange,
        instructions: InstructionSet,
    ) -> f32 {
        self.pass(places, which, None, MEASURING, instructions)
    }

    fn pass(
        &self,
        places: &mut Places,
        which: &BatchRange,
        multipliers: Option<ChunksMut<f32>>,
        substep_context: SubstepContext,
        instructions: InstructionSet,
    ) -> f32 {
        let (blocks, compliances) = (which.blocks.clone(), &self.compliances[..]);
        on_list!([&] self, which.list, |batches| {
            let batches = &batches[blocks];
            let sweep = SweepBatches { batches, compliances, places, multipliers, substep_context };
            with(instructions, sweep)
        })
    }
}

/// One to eight constraints of one kind; `None` if their kinds differ.
fn gathered<W: Wide<N, Kind: FromKind>, const N: usize>(
    some: &[Constraint],
    compliances: &mut Vec<PackedCompliance>,
) -> Option<Batch<[[u32; LANES]; N], WideConstraint<W>>> {
    let mut eight = [&some[0]; LANES];
    let mut rows = [[0; LANES]; N];
    for (lane, one) in eight.iter_mut().enumerate() {
        *one = some.get(lane).unwrap_or(&some[0]);
        for (to, row) in rows.iter_mut().zip(W::rows(&one.rows)) {
            to[lane] = row;
        }
    }
    Some(Batch::new(rows, WideConstraint::of(eight)?, compliances))
}

/// Projects batches once, in order. Returns the largest error found, metres; for compliant ones the largest correction. Without multipliers it measures:
/// nothing is moved, and it returns the largest error of the hard ones.
struct SweepBatches<'a, 'b, E, const N: usize> {
    batches: &'a [Batch<[[u32; LANES]; N], E>],
    compliances: &'a [PackedCompliance],
    places: &'a mut Places<'b>,
    /// One chunk for each batch.
    multipliers: Option<ChunksMut<'a, f32>>,
    substep_context: SubstepContext,
}

impl<E: WideKernel<N>, const N: usize> Work for SweepBatches<'_, '_, E, N> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { batches, compliances, places, mut multipliers, substep_context } = self;
        let mut shares = Shares::new(substep_context.sweeps);
        let mut worst = L::zero();
        for batch in batches {
            let multipliers = multipliers.as_mut().and_then(Iterator::next);
            let packed_compliance = &compliances[batch.packed_compliance as usize];
            let each = shares.of(batch.packed_compliance, packed_compliance);
            let mut buffer = [[0; LANES]; N];
            let rows = offset_rows(&batch.particles, places.first, &mut buffer);
            let (position, start) = (&mut *places.position, &*places.start);
            let mut particles = GatheredParticles { rows, position, start };
            let context = (packed_compliance, each, substep_context.h, L::zero());
            worst = batch.eight.project::<L>(context, &mut particles, multipliers).0.max(worst);
        }
        worst.largest(0.0)
    }
}

/// The context of a measurement, which does not read it.
const MEASURING: SubstepContext = SubstepContext { h: 0.0, sweeps: 1 };

/// The index of a packed compliance. Reuses the last one if it is equal, so that bodies of one softness share one, which stays in the cache.
fn index_of(compliances: &mut Vec<PackedCompliance>, packed_compliance: PackedCompliance) -> u32 {
    if compliances.last() != Some(&packed_compliance) {
        compliances.push(packed_compliance);
    }
    (compliances.len() - 1) as u32
}

/// Rows as indices into slices that begin with row `first`, written to `buffer`. If `first` is zero the rows are returned as they are, without a copy: that
/// would be loaded into a vector register and extracted from it lane by lane for addressing, which is slower.
#[inline(always)]
fn offset_rows<'a, const N: usize>(
    rows: &'a [[u32; LANES]; N],
    first: u32,
    buffer: &'a mut [[u32; LANES]; N],
) -> &'a [[u32; LANES]; N] {
    if first == 0 {
        return rows;
    }
    for (to, from) in buffer.iter_mut().zip(rows) {
        for (to, from) in to.iter_mut().zip(from) {
            *to = from.wrapping_sub(first);
        }
    }
    buffer
}

/// Repeats a block for each of up to `n` ≤ 5 particles with the number as a constant. A loop that the compiler decides not to unroll would keep all vectors in
/// memory.
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

/// The multipliers of one to eight constraints; unused lanes repeat the first. Zero if there are none.
#[inline(always)]
fn load_multipliers<L: Lanes>(multipliers: &[f32]) -> L {
    match multipliers.try_into() {
        Ok(eight) => L::load(eight),
        Err(_) if multipliers.is_empty() => L::zero(),
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
fn store_multipliers<L: Lanes>(lanes: L, multipliers: &mut [f32]) {
    if let Ok(eight) = <&mut [f32; LANES]>::try_from(&mut *multipliers) {
        lanes.store(eight);
    } else if !multipliers.is_empty() {
        for (to, from) in multipliers.iter_mut().zip(lanes.array()) {
            *to = from;
        }
    }
}
