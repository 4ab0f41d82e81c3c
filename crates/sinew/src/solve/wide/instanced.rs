//! The constraints of [instance batches](crate::solve::instances): each lane holds the constraint of another body, between the same local particles.

use core::ops::Range;

use super::compliance::{PackedCompliance, Shares};
use super::particle_access::ParticleAccess;
use super::wide_constraint::WideConstraint;
use super::wide_distance::WideDistance;
use super::{
    Addressing, Batch, BatchList, BatchLists, BatchRange, ConstraintBatches, MEASURING, WideKernel,
    append, on_list,
};
use crate::constraints::{Constraint, Distance, FromKind, SubstepContext, Wide};
use crate::lanes::{InstructionSet, LANES, Lanes, Work, with};
use crate::solve::lane_particles::LaneParticles;

/// By local particle numbers, which are the same in all eight bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct ByMembers;

impl Addressing for ByMembers {
    type Of<const N: usize> = [u32; N];
}

/// Constraints of instance batches.
pub(in crate::solve) type InstancedConstraints = BatchLists<ByMembers>;

/// The batches that belong to one group of constraints.
#[derive(Clone, Debug)]
pub(in crate::solve) struct InstancedGroup {
    list: BatchList,
    range: Range<usize>,
    /// Where the group's multipliers begin among those of the instance batch.
    multipliers: usize,
}

/// The same group in each of eight bodies, with the first row of each body, and the wide constraints that solve the group of the first body outside of instance
/// batches.
pub(in crate::solve) struct InstancedGroups<'a, T> {
    pub(in crate::solve) each: [&'a [T]; LANES],
    pub(in crate::solve) first: [u32; LANES],
    pub(in crate::solve) constraint_batches: &'a ConstraintBatches,
    pub(in crate::solve) which: &'a BatchRange,
    /// Where the group's multipliers begin among those of the instance batch.
    pub(in crate::solve) multipliers: usize,
}

impl InstancedConstraints {
    /// Adds distances.
    pub(in crate::solve) fn add_distances(
        &mut self,
        groups: &InstancedGroups<Distance>,
    ) -> InstancedGroup {
        let begin = self.distances.len();
        for place in 0..groups.each[0].len() {
            let (eight, own) = WideDistance::of(groups.each.map(|group| &group[place]));
            let Distance { a, b, .. } = groups.each[0][place];
            let members = [a - groups.first[0], b - groups.first[0]];
            let eight = (eight, groups.match_branches(own, place));
            self.distances.push(Batch::new(members, eight, &mut self.compliances));
        }
        groups.group(BatchList::Distances, begin..self.distances.len())
    }

    /// Adds constraints; `None` if their kinds differ.
    pub(in crate::solve) fn add(
        &mut self,
        groups: &InstancedGroups<Constraint>,
    ) -> Option<InstancedGroup> {
        let compliances = &mut self.compliances;
        let range = on_list!(
            [&mut] self,
            groups.which.list,
            |batches| {
                let places = 0..groups.each[0].len();
                append(batches, places.map(|place| instanced(groups, place, compliances)))?
            },
            return None
        );
        Some(groups.group(groups.which.list, range))
    }

    /// Projects a group once. `now` and `start` are the particles at present and at the start of the substep. `multipliers` are those of the whole instance
    /// batch, or empty if no other sweep follows. Returns the largest error found in each body, metres, or `worst` if that is larger. Bodies in the mask
    /// `inactive` are not swept any more: their lanes may be written with anything.
    pub(in crate::solve) fn sweep(
        &self,
        part: &InstancedGroup,
        (now, start, multipliers): (&mut [LaneParticles], &[LaneParticles], &mut [LaneValues]),
        substep_context: SubstepContext,
        (inactive, worst): (u32, LaneValues),
        instructions: InstructionSet,
    ) -> LaneValues {
        // With a single sweep nothing has to be accumulated.
        let from = if multipliers.is_empty() { 0 } else { part.multipliers };
        let multipliers = Some(&mut multipliers[from..]);
        let task = InstancedTask { now, start, multipliers, substep_context, inactive, worst };
        self.pass(part, task, instructions)[0]
    }

    /// The errors of a group's hard constraints in each body: the largest error, metres, and for distances the largest error as a share of the rest length.
    /// Moves nothing.
    pub(in crate::solve) fn measure(
        &self,
        part: &InstancedGroup,
        now: &mut [LaneParticles],
        instructions: InstructionSet,
    ) -> [LaneValues; 2] {
        let (start, multipliers, substep_context) = (&[][..], None, MEASURING);
        let (inactive, worst) = (0, LaneValues::default());
        let task = InstancedTask { now, start, multipliers, substep_context, inactive, worst };
        self.pass(part, task, instructions)
    }

    fn pass(
        &self,
        part: &InstancedGroup,
        task: InstancedTask,
        instructions: InstructionSet,
    ) -> [LaneValues; 2] {
        let (range, compliances) = (part.range.clone(), &self.compliances[..]);
        on_list!([&] self, part.list, |batches| {
            with(instructions, SweepInstanced { batches: &batches[range], compliances, task })
        })
    }
}

impl ConstraintBatches {
    /// The packed compliance that a constraint of a group has outside of instance batches.
    fn packed_compliance(&self, which: &BatchRange, place: usize) -> &PackedCompliance {
        let block = which.blocks.start + place / which.each;
        let number = on_list!([&] self, which.list, |batches| batches[block].packed_compliance);
        &self.compliances[number as usize]
    }
}

impl InstancedGroup {
    /// Appends the next group if both are in the same list and adjacent there, so that they are swept as one. Returns whether it did.
    pub(in crate::solve) fn append(&mut self, next: &Self) -> bool {
        let (end, multipliers) = (self.range.end, self.multipliers + self.range.len());
        let joins =
            self.list == next.list && end == next.range.start && multipliers == next.multipliers;
        if joins {
            self.range.end = next.range.end;
        }
        joins
    }
}

impl<T> InstancedGroups<'_, T> {
    /// `own`, computed by the same branches as the first body's constraint at that place outside of instance batches.
    fn match_branches(&self, own: PackedCompliance, place: usize) -> PackedCompliance {
        own.with_branches_of(self.constraint_batches.packed_compliance(self.which, place))
    }

    fn group(&self, list: BatchList, range: Range<usize>) -> InstancedGroup {
        InstancedGroup { list, range, multipliers: self.multipliers }
    }
}

/// The constraints of eight bodies at one place of their groups; `None` if their kinds differ.
fn instanced<W: Wide<N, Kind: FromKind>, const N: usize>(
    groups: &InstancedGroups<Constraint>,
    place: usize,
    compliances: &mut Vec<PackedCompliance>,
) -> Option<Batch<[u32; N], WideConstraint<W>>> {
    let (eight, own) = WideConstraint::of(groups.each.map(|group| &group[place]))?;
    let members = W::rows(&groups.each[0][place].rows).map(|row| row - groups.first[0]);
    Some(Batch::new(members, (eight, groups.match_branches(own, place)), compliances))
}

impl BatchRange {
    /// Whether another group has constraints of the same kind, batched in the same way.
    pub(in crate::solve) fn has_same_layout(&self, other: &Self) -> bool {
        self.list == other.list && self.each == other.each
    }
}

/// One number for each of eight bodies.
type LaneValues = [f32; LANES];

/// Projects the constraints of eight bodies once, or measures them if there are no multipliers.
struct InstancedTask<'a> {
    now: &'a mut [LaneParticles],
    /// Positions at the start of the substep.
    start: &'a [LaneParticles],
    multipliers: Option<&'a mut [LaneValues]>,
    substep_context: SubstepContext,
    /// Mask of the bodies that are not swept any more.
    inactive: u32,
    /// The largest errors found before, metres.
    worst: LaneValues,
}

/// A task on one list. Returns the largest errors, metres, and shares of rest lengths.
struct SweepInstanced<'a, E, const N: usize> {
    batches: &'a [Batch<[u32; N], E>],
    compliances: &'a [PackedCompliance],
    task: InstancedTask<'a>,
}

impl<E: WideKernel<N>, const N: usize> Work for SweepInstanced<'_, E, N> {
    type Output = [LaneValues; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [LaneValues; 2] {
        let Self { batches, compliances, task } = self;
        let InstancedTask { now, start, multipliers, substep_context, inactive, worst } = task;
        let mut shares = Shares::new(substep_context.sweeps);
        let (inactive, mut worst) = (L::mask(inactive), (L::load(&worst), L::zero()));
        let measures = multipliers.is_none();
        let mut multipliers = multipliers.unwrap_or_default().iter_mut();
        for own in batches {
            let packed_compliance = &compliances[own.packed_compliance as usize];
            if measures && !packed_compliance.some_hard {
                continue;
            }
            let each = shares.of(own.packed_compliance, packed_compliance);
            let own_sums = match multipliers.next() {
                Some(sums) => &mut sums[..],
                None => &mut [],
            };
            let sums = if measures { None } else { Some(own_sums) };
            let mut particles = InstancedParticles { at: &own.particles, now, start };
            let context = (packed_compliance, each, substep_context.h, inactive);
            let (error, share) = own.eight.project::<L>(context, &mut particles, sums);
            worst = (error.max(worst.0), share.max(worst.1));
        }
        [worst.0.array(), worst.1.array()]
    }
}

/// The particles of one constraint in each of eight bodies.
struct InstancedParticles<'a, const N: usize> {
    at: &'a [u32; N],
    now: &'a mut [LaneParticles],
    start: &'a [LaneParticles],
}

impl<const N: usize> ParticleAccess<N> for InstancedParticles<'_, N> {
    #[inline(always)]
    fn now<L: Lanes>(&self, i: usize) -> [L; 4] {
        self.now[self.at[i] as usize].load()
    }

    #[inline(always)]
    fn start<L: Lanes>(&self, i: usize) -> [L; 4] {
        self.start[self.at[i] as usize].load()
    }

    #[inline(always)]
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]) {
        self.now[self.at[i] as usize].put(eight);
    }
}
