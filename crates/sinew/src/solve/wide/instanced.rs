//! The constraints of [instance batches](crate::solve::instances): each lane has that of another body, between particles of the same numbers there.

use core::ops::Range;

use super::compliance::{PackedCompliance, Shares};
use super::constraint_batch::{self, WideConstraint};
use super::distance_batch::{self, WideDistance};
use super::particle_access::ParticleAccess;
use super::{BatchList, ConstraintBatches, MEASURING, Which, number};
use crate::constraints::{
    Angles, Areas, Bends, Cones, Constraint, Distance, Hinges, SubstepContext, Tetrahedra, Wide,
};
use crate::lanes::{InstructionSet, LANES, Lanes, Work, with};
use crate::solve::instances::{LaneParticles, LaneStorage};

/// Constraints of instance batches, kind by kind.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct InstancedConstraints {
    compliances: Vec<PackedCompliance>,
    distances: Vec<InstancedConstraint<WideDistance, 2>>,
    bends: Vec<InstancedConstraint<WideConstraint<Bends>, 4>>,
    areas: Vec<InstancedConstraint<WideConstraint<Areas>, 3>>,
    tetrahedra: Vec<InstancedConstraint<WideConstraint<Tetrahedra>, 4>>,
    angles: Vec<InstancedConstraint<WideConstraint<Angles>, 3>>,
    hinges: Vec<InstancedConstraint<WideConstraint<Hinges>, 4>>,
    cones: Vec<InstancedConstraint<WideConstraint<Cones>, 5>>,
}

/// One constraint of each of eight bodies.
#[derive(Clone, Debug)]
struct InstancedConstraint<E, const N: usize> {
    /// Numbers of its particles in the body.
    at: [u32; N],
    eight: E,
}

/// Which of them stand for a group.
#[derive(Clone, Debug)]
pub(in crate::solve) struct InstancedGroup {
    list: BatchList,
    range: Range<usize>,
    /// Where their sums begin among the batch's.
    multipliers: usize,
}

/// The same group in each of eight bodies, of which the first rows are given, and what it is solved by in the first of them alone.
pub(in crate::solve) struct InstancedGroups<'a, T> {
    pub(in crate::solve) each: [&'a [T]; LANES],
    pub(in crate::solve) first: [u32; LANES],
    pub(in crate::solve) constraint_batches: &'a ConstraintBatches,
    pub(in crate::solve) which: &'a Which,
    /// Where the sums begin among the batch's.
    pub(in crate::solve) multipliers: usize,
}

impl InstancedConstraints {
    /// Forgets all, and keeps the memory.
    pub(in crate::solve) fn clear(&mut self) {
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

    /// Takes distances.
    pub(in crate::solve) fn add_distances(
        &mut self,
        groups: &InstancedGroups<Distance>,
    ) -> InstancedGroup {
        let InstancedGroups { each, first, constraint_batches, which, multipliers } = groups;
        let begin = self.distances.len();
        for place in 0..each[0].len() {
            let (mut eight, packed_compliance) = WideDistance::of(each.map(|group| &group[place]));
            let packed_compliance =
                packed_compliance.asked_as(constraint_batches.packed_compliance(which, place));
            eight.packed_compliance = number(&mut self.compliances, packed_compliance);
            let Distance { a, b, .. } = each[0][place];
            self.distances.push(InstancedConstraint { at: [a - first[0], b - first[0]], eight });
        }
        InstancedGroup {
            list: BatchList::Distances,
            range: begin..self.distances.len(),
            multipliers: *multipliers,
        }
    }

    /// Takes constraints; `None` if their kinds are not the same after all.
    pub(in crate::solve) fn add(
        &mut self,
        groups: &InstancedGroups<Constraint>,
    ) -> Option<InstancedGroup> {
        let Self { compliances, bends, areas, tetrahedra, angles, hinges, cones, .. } = self;
        let range = match groups.which.list {
            BatchList::Distances => return None,
            BatchList::Bends => take(bends, compliances, groups)?,
            BatchList::Areas => take(areas, compliances, groups)?,
            BatchList::Tetrahedra => take(tetrahedra, compliances, groups)?,
            BatchList::Angles => take(angles, compliances, groups)?,
            BatchList::Hinges => take(hinges, compliances, groups)?,
            BatchList::Cones => take(cones, compliances, groups)?,
        };
        Some(InstancedGroup { list: groups.which.list, range, multipliers: groups.multipliers })
    }

    /// Projects a group once; returns the largest error found in each body, metres, or what it was before. Nothing is asked of bodies of the mask
    /// `aside`: what becomes of them does not matter.
    pub(in crate::solve) fn sweep(
        &self,
        part: &InstancedGroup,
        storage: &mut LaneStorage,
        substep_context: SubstepContext,
        (aside, worst): (u32, LaneValues),
        instructions: InstructionSet,
    ) -> LaneValues {
        let LaneStorage { now, start, multipliers, .. } = storage;
        let multipliers = Some(&mut multipliers[part.multipliers..]);
        let task = Task { now, start, multipliers, substep_context, aside, worst };
        self.pass(part, task, instructions)[0]
    }

    /// How far the hard ones of a group are from being kept in each body: the largest error, metres, and of distances the largest share of a rest
    /// length. Moves nothing.
    pub(in crate::solve) fn measure(
        &self,
        part: &InstancedGroup,
        now: &mut [LaneParticles],
        instructions: InstructionSet,
    ) -> [LaneValues; 2] {
        let (start, multipliers, substep_context) = (&[][..], None, MEASURING);
        let (aside, worst) = (0, LaneValues::default());
        let task = Task { now, start, multipliers, substep_context, aside, worst };
        self.pass(part, task, instructions)
    }

    fn pass(
        &self,
        part: &InstancedGroup,
        task: Task,
        instructions: InstructionSet,
    ) -> [LaneValues; 2] {
        let Self { compliances, distances, bends, areas, tetrahedra, angles, hinges, cones } = self;
        let range = part.range.clone();
        macro_rules! pass {
            ($list:ident) => {
                with(instructions, SweepInstanced { list: &$list[range], compliances, task })
            };
        }
        match part.list {
            BatchList::Distances => pass!(distances),
            BatchList::Bends => pass!(bends),
            BatchList::Areas => pass!(areas),
            BatchList::Tetrahedra => pass!(tetrahedra),
            BatchList::Angles => pass!(angles),
            BatchList::Hinges => pass!(hinges),
            BatchList::Cones => pass!(cones),
        }
    }
}

impl ConstraintBatches {
    /// How hard the block is that a constraint of a group is in.
    fn packed_compliance(&self, which: &Which, place: usize) -> &PackedCompliance {
        let block = which.blocks.start + place / which.each;
        let packed_compliance = match which.list {
            BatchList::Distances => self.distances[block].eight.packed_compliance,
            BatchList::Bends => self.bends[block].eight.packed_compliance,
            BatchList::Areas => self.areas[block].eight.packed_compliance,
            BatchList::Tetrahedra => self.tetrahedra[block].eight.packed_compliance,
            BatchList::Angles => self.angles[block].eight.packed_compliance,
            BatchList::Hinges => self.hinges[block].eight.packed_compliance,
            BatchList::Cones => self.cones[block].eight.packed_compliance,
        };
        &self.compliances[packed_compliance as usize]
    }
}

impl Which {
    /// Whether another group is of the same kind, and is cut in the same way.
    pub(in crate::solve) fn is_like(&self, other: &Self) -> bool {
        self.list == other.list && self.each == other.each
    }
}

/// Appends them, or nothing.
fn take<W: Wide<N>, const N: usize>(
    list: &mut Vec<InstancedConstraint<WideConstraint<W>, N>>,
    compliances: &mut Vec<PackedCompliance>,
    groups: &InstancedGroups<Constraint>,
) -> Option<Range<usize>> {
    let InstancedGroups { each, first, constraint_batches, which, .. } = groups;
    let begin = list.len();
    for place in 0..each[0].len() {
        let Some((mut eight, packed_compliance)) =
            WideConstraint::of(each.map(|group| &group[place]))
        else {
            list.truncate(begin);
            return None;
        };
        let packed_compliance =
            packed_compliance.asked_as(constraint_batches.packed_compliance(which, place));
        eight.packed_compliance = number(compliances, packed_compliance);
        let at = W::rows(&each[0][place]).map(|row| row - first[0]);
        list.push(InstancedConstraint { at, eight });
    }
    Some(begin..list.len())
}

/// A number of each of eight bodies.
type LaneValues = [f32; LANES];

/// What is to be done with the constraints of eight bodies: to project them once, or without multipliers to measure them.
struct Task<'a> {
    now: &'a mut [LaneParticles],
    /// Where they were when the substep began.
    start: &'a [LaneParticles],
    multipliers: Option<&'a mut [LaneValues]>,
    substep_context: SubstepContext,
    /// A mask of bodies of which nothing is asked.
    aside: u32,
    /// The largest error that was found before, metres.
    worst: LaneValues,
}

/// One constraint of each of eight bodies.
trait InstancedKernel<const N: usize> {
    /// Which packed compliance they have.
    fn packed_compliance(&self) -> u32;
    /// As [`constraint_batch::project`] has it, and what of distances is measured as a share of their rest lengths.
    fn project<L: Lanes>(
        &self,
        context: (&PackedCompliance, &LaneValues, f32, L),
        particles: &mut InstancedParticles<N>,
        multipliers: Option<&mut [f32]>,
    ) -> (L, L);
}

impl<W: Wide<N>, const N: usize> InstancedKernel<N> for WideConstraint<W> {
    fn packed_compliance(&self) -> u32 {
        self.packed_compliance
    }

    #[inline(always)]
    fn project<L: Lanes>(
        &self,
        context: (&PackedCompliance, &LaneValues, f32, L),
        particles: &mut InstancedParticles<N>,
        multipliers: Option<&mut [f32]>,
    ) -> (L, L) {
        (constraint_batch::project::<L, W, N>(self, context, particles, multipliers), L::zero())
    }
}

impl InstancedKernel<2> for WideDistance {
    fn packed_compliance(&self) -> u32 {
        self.packed_compliance
    }

    #[inline(always)]
    fn project<L: Lanes>(
        &self,
        context: (&PackedCompliance, &LaneValues, f32, L),
        particles: &mut InstancedParticles<2>,
        multipliers: Option<&mut [f32]>,
    ) -> (L, L) {
        distance_batch::project::<L>(self, context, particles, multipliers)
    }
}

/// A task for one list: the largest errors, metres, and shares of rest lengths.
struct SweepInstanced<'a, E, const N: usize> {
    list: &'a [InstancedConstraint<E, N>],
    compliances: &'a [PackedCompliance],
    task: Task<'a>,
}

impl<E: InstancedKernel<N>, const N: usize> Work for SweepInstanced<'_, E, N> {
    type Output = [LaneValues; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [LaneValues; 2] {
        let Self { list, compliances, task } = self;
        let Task { now, start, multipliers, substep_context, aside, worst } = task;
        let mut shares = Shares::new(substep_context.sweeps);
        let (aside, mut worst) = (L::mask(aside), (L::load(&worst), L::zero()));
        let mut multipliers = multipliers.map(|all| all.iter_mut());
        for own in list {
            let number = own.eight.packed_compliance();
            let packed_compliance = &compliances[number as usize];
            let each = shares.of(number, packed_compliance);
            let sums = multipliers.as_mut().and_then(Iterator::next).map(|sums| &mut sums[..]);
            let mut particles = InstancedParticles { at: &own.at, now, start };
            let context = (packed_compliance, each, substep_context.h, aside);
            let (error, share) = own.eight.project::<L>(context, &mut particles, sums);
            worst = (error.max(worst.0), share.max(worst.1));
        }
        [worst.0.array(), worst.1.array()]
    }
}

/// The particles of one constraint of each of eight bodies.
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
