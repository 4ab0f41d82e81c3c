//! Pressed cloth: where a collider of another body presses on large cloth, contacts and rods are solved alternately.
//!
//! A particle of cloth has next to no mass compared with a crate. A contact between the two moves the particle, and hardly the crate: it decelerates the crate
//! by as much as one particle weighs, however taut the cloth is, since it does not include the rods. These pull the particle back in the next substep, and the
//! crate pushes it out again. This is Gauss–Seidel with a large mass on small ones, which converges by `1 - m/M` in each iteration: a crate of mass `M` on
//! particles of total mass `m` is stopped by taut cloth within about `M/m` substeps, and stretches it meanwhile by as far as it moves; at rest the cloth
//! is pushed by `g h² M/m` in each substep, 3 mm on a flat bottom, and 9 cm on a corner. More sweeps of the rods do not help, since the contacts come
//! last. What counts is how much mass is pushed, and how often contacts and rods alternate.
//!
//! So a contact pushes not a particle but a piece of cloth: the particles around it, ring by ring of rods, with shares that decrease outwards, until they weigh
//! a given share of the pressing mass ([`Aggregate`](crate::collide::Aggregate)). This corresponds to (smoothed) aggregation in a multigrid method: errors that
//! take a sweep many substeps are corrected on a coarse level, which here has one unknown, and is needed only at contacts. An impulse on an aggregate conserves
//! momentum as one on a particle does. It stretches each rod by one ring's share of the push, instead of the first rod by all of it.
//!
//! In addition, contacts of particles with shapes are solved several times in a substep, and in between the particles that they moved are constrained by their
//! [tethers](super::tethers), and by the rods around them that exceed the [strain limit](super::strain_limit), for a few rings of rods. This moves positions
//! before velocities are derived: it is part of solving, and conserves momentum as rods do.

use core::ops::Range;

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::context::{SolveContext, SubstepParameters};
use super::plan::Plan;
use super::rod_graph::RodGraph;
use super::strain_limit::StrainScratch;
use crate::collide::{
    Aggregate, NormalImpulse, NormalImpulses, ParticleContacts, PressedCloth, Push, ring_share,
};
use crate::particles::{Particles, Places};
use crate::pose::symmetric;
use crate::threads::ExecutionContext;

/// Number of rings of rods around a pressed particle over which one iteration propagates a push. In the two scenes of `TURNS` (`body_contact`), 2, 4 and 8
/// rings give strains of 3.7, 3.3 and 3.0 % in 2.4, 2.4 and 2.7 ms; and 5.0, 4.2 and 4.3 % in 3.2, 3.4 and 3.8 ms.
const RINGS: usize = 4;

/// Strain that a push may cause; the number of rings of an aggregate is chosen accordingly. Particles that are not pressed on, and are moved along although
/// hardly needed, are thrown a little in each substep: particles of a sheet on nine crates change velocity by 233, 2 and 5 mm/s (root mean square) from tick to
/// tick in the eighth second with 1, 2 and 4 %.
const STRAIN: f32 = 0.02;

/// Most rings of rods of an aggregate: about 900 particles of grid cloth. With 8 and 12, measured before some pushes were taken back, a crate in slack cloth
/// stretched it by half as much again.
const MAX_RINGS: u32 = 16;

/// Cloth pressed by contacts in a substep, with the constraints that hold it.
pub(crate) struct HeldCloth<'a> {
    plan: &'a Plan,
    substep: SubstepParameters,
    execution: ExecutionContext<'a>,
    scratch: &'a mut PressedScratch,
}

/// Scratch of pressed cloth, valid within one step.
#[derive(Clone, Debug, Default)]
pub(crate) struct PressedScratch {
    strain: StrainScratch,
    /// Set of listed rows.
    listed: Marks,
    /// For each row the index of its aggregate in this step, or `NONE` if it was not pushed. Empty before the first push of a step.
    numbers: Vec<u32>,
    aggregates: Vec<RowAggregate>,
    /// Member rows, with their ring indices.
    members: Vec<(u32, u32)>,
}

/// The aggregate of one row.
#[derive(Clone, Debug, Default)]
struct RowAggregate {
    /// Target mass, kg.
    mass: f32,
    /// Range of the members of all its rings.
    members: Range<u32>,
    /// Mean length of the rods at its middle, metres, once it is known.
    rod: Option<f32>,
    /// Substep and number of rings for which its mass was computed last.
    weighed: (u32, u32),
    /// Number of members in those rings.
    count: u32,
    inverse_mass: f32,
    inverse_inertia: Mat3,
    lever: Vec3,
}

/// No aggregate.
const NONE: u32 = u32::MAX;

impl<'a> HeldCloth<'a> {
    /// In a substep of a plan. The first substep of a step discards the aggregates, since masses may have changed.
    pub(super) fn new(
        plan: &'a Plan,
        (substep, execution): (SubstepParameters, ExecutionContext<'a>),
        scratch: &'a mut PressedScratch,
    ) -> Self {
        if substep.number == 0 {
            scratch.numbers.clear();
            scratch.aggregates.clear();
            scratch.members.clear();
        }
        Self { plan, substep, execution, scratch }
    }
}

impl PressedCloth for HeldCloth<'_> {
    fn aggregate(
        &mut self,
        particles: &Particles,
        row: u32,
        Push { distance, mass }: Push,
    ) -> Option<Aggregate<'_>> {
        let PressedScratch { numbers, aggregates, members, listed, .. } = &mut *self.scratch;
        if numbers.is_empty() {
            numbers.resize(particles.len(), NONE);
        }
        let number = numbers.get_mut(row as usize)?;
        if *number == NONE {
            *number = aggregates.len() as u32;
            aggregates.push(RowAggregate::default());
        }
        let own = &mut aggregates[*number as usize];
        let rod = *own.rod.get_or_insert_with(|| mean_rod(self.plan, row));
        // Most pushes are so small that the particle moves alone. (None is long enough if it has no rods.)
        let rings = ((distance / (STRAIN * rod)) as u32).min(MAX_RINGS) + 1;
        if rings < 2 || rod <= 0.0 {
            return None;
        }
        // Rounded to few sizes, because the pressing mass varies slightly from substep to substep.
        let mass = power_of_two(mass);
        if own.mass != mass {
            let first = members.len() as u32;
            grow(self.plan, particles, (row, mass), members, listed);
            let members = first..members.len() as u32;
            *own = RowAggregate { mass, members, rod: own.rod, ..RowAggregate::default() };
        }
        let members = &members[own.members.start as usize..own.members.end as usize];
        let rings = rings.min(members.last().map_or(0, |&(_, ring)| ring + 1));
        if rings < 2 {
            return None;
        }
        let weighed = (self.substep.number, rings);
        if own.weighed != weighed {
            own.weighed = weighed;
            own.count = members.partition_point(|&(_, ring)| ring < rings) as u32;
            own.weigh(particles, &members[..own.count as usize]);
        }
        let RowAggregate { inverse_mass, inverse_inertia, lever, .. } = *own;
        let members = &members[..own.count as usize];
        Some(Aggregate { inverse_mass, inverse_inertia, lever, members, rings })
    }

    fn project(
        &mut self,
        particles: &mut Particles,
        (particle_contacts, normal_impulses): (&ParticleContacts, &mut [NormalImpulse]),
        rows: &mut Vec<u32>,
    ) -> bool {
        let Self { plan, substep, execution, scratch } = self;
        let PressedScratch { strain, listed, .. } = &mut **scratch;
        let context = SolveContext::new(plan, particle_contacts, *substep, *execution);
        listed.clear(particles.len());
        rows.retain(|&row| listed.insert(row));
        rows.sort_unstable();
        let mut any = false;
        let number_of = |row: u32| plan.islands.of[row as usize] as usize;
        for rows in rows.chunk_by(|&one, &next| number_of(one) == number_of(next)) {
            let island = &plan.islands.list[number_of(rows[0])];
            if !island.takes_microsteps() {
                continue;
            }
            let (graph, run) = (plan.tethers.graph_of(island), plan.stretch(island));
            let (Some(graph), Some(run)) = (graph, run) else { continue };
            let first = run.start as u32;
            let members = rows.iter().map(|row| row - first);
            let position = &mut particles.position[run];
            if let Some(tethers) = plan.tethers.of(island) {
                for member in members.clone() {
                    any |= tethers.hold_member(member as usize, position, first);
                }
            }
            let moved = strain.limit_about(graph, position, members, RINGS);
            any |= !moved.is_empty();
            // Contacts come last: the particles that were moved are projected out of the shapes again.
            let (mut places, interval) = (Places::all(particles), context.interval());
            let mut normal_impulses = NormalImpulses::all(normal_impulses);
            let others = moved.iter().map(|member| member + first);
            let moved = rows.iter().copied().chain(others.filter(|&row| listed.insert(row)));
            particle_contacts.project_rows(&mut places, &mut normal_impulses, moved, interval);
        }
        any
    }
}

/// Appends the aggregate of a row to the members: the particles around it, ring by ring of rods, until they have the given mass, each weighted by its share.
/// Pins are not included, and the aggregate does not grow past them.
fn grow(
    plan: &Plan,
    particles: &Particles,
    (row, mass): (u32, f32),
    members: &mut Vec<(u32, u32)>,
    listed: &mut Marks,
) {
    let w = |row: u32| particles.position[row as usize].w;
    let first = members.len();
    members.push((row, 0));
    let Some((graph, first_row)) = graph_about(plan, row) else { return };
    listed.clear(particles.len());
    listed.insert(row);
    // Sums over all members: of the masses, and of the masses times the ring index.
    let (mut sum, mut moment) = (1.0 / w(row), 0.0);
    let (mut ring, mut rings) = (first, 1);
    while rings < MAX_RINGS && sum - moment / (rings as f32) < mass && ring < members.len() {
        let end = members.len();
        for at in ring..end {
            for rod in graph.rods_of(members[at].0 - first_row) {
                let next = rod.to + first_row;
                if w(next) > 0.0 && listed.insert(next) {
                    members.push((next, rings));
                    sum += 1.0 / w(next);
                    moment += rings as f32 / w(next);
                }
            }
        }
        (ring, rings) = (end, rings + 1);
    }
}

/// Mean length of the rods of a row, metres; 0 if its neighbours cannot be pushed along.
fn mean_rod(plan: &Plan, row: u32) -> f32 {
    let Some((graph, first_row)) = graph_about(plan, row) else { return 0.0 };
    let rods = graph.rods_of(row - first_row);
    rods.iter().map(|rod| rod.rest).sum::<f32>() / rods.len() as f32
}

/// The graph of the large cloth that a row is part of, and the row that it begins with.
fn graph_about(plan: &Plan, row: u32) -> Option<(&RodGraph, u32)> {
    let island = &plan.islands.list[*plan.islands.of.get(row as usize)? as usize];
    let graph = plan.tethers.graph_of(island).filter(|_| island.takes_microsteps())?;
    Some((graph, plan.stretch(island)?.start as u32))
}

impl RowAggregate {
    /// Computes mass and inertia of its members, of which the first is the middle, at their positions at the start of the substep.
    fn weigh(&mut self, particles: &Particles, members: &[(u32, u32)]) {
        let start = |row: u32| particles.start[row as usize].truncate();
        let middle = start(members[0].0);
        let (_, rings) = self.weighed;
        let masses = members.iter().filter_map(|&(row, ring)| {
            let w = particles.position[row as usize].w;
            (w > 0.0).then(|| (ring_share(ring, rings) / w, start(row) - middle))
        });
        let (mut mass, mut first) = (0.0_f32, Vec3::ZERO);
        let (mut along, mut across) = (Vec3::ZERO, Vec3::ZERO);
        for (own, r) in masses {
            mass += own;
            first += r * own;
            along += r * r * own;
            across += Vec3::new(r.x * r.y, r.x * r.z, r.y * r.z) * own;
        }
        let barycentre = first / mass;
        // About the barycentre (Steiner).
        let b = barycentre;
        let along = along - b * b * mass;
        let across = across - Vec3::new(b.x * b.y, b.x * b.z, b.y * b.z) * mass;
        let inertia = [
            [along.y + along.z, -across.x, -across.y],
            [-across.x, along.x + along.z, -across.z],
            [-across.y, -across.z, along.x + along.y],
        ];
        let inertia = inertia.map(|row| row.map(f64::from));
        let inverse = DMat3::IDENTITY.to_cols_array_2d().map(|axis| {
            symmetric::solve(&inertia, DVec3::from_array(axis)).map(|(column, _)| column.as_vec3())
        });
        self.inverse_inertia = match inverse {
            [Some(x), Some(y), Some(z)] => Mat3::from_cols(x, y, z),
            _ => Mat3::ZERO,
        };
        self.inverse_mass = 1.0 / mass;
        self.lever = -barycentre;
    }
}

/// Rounds up to a power of two, for positive finite values.
fn power_of_two(x: f32) -> f32 {
    const MANTISSA: u32 = (1 << 23) - 1;
    f32::from_bits((x.to_bits() + MANTISSA) & !MANTISSA).min(f32::MAX)
}

/// A set of rows that is cleared often.
#[derive(Clone, Debug, Default)]
struct Marks {
    /// The number of the last set that contained each row.
    last: Vec<u32>,
    number: u32,
}

impl Marks {
    /// Empties the set, and allocates for this many rows.
    fn clear(&mut self, rows: usize) {
        self.number = self.number.wrapping_add(1);
        if self.number == 0 || self.last.len() < rows {
            (self.number, self.last) = (1, vec![0; rows]);
        }
    }

    /// Adds a row; returns whether it was not in the set.
    #[inline]
    fn insert(&mut self, row: u32) -> bool {
        core::mem::replace(&mut self.last[row as usize], self.number) != self.number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::InstructionSet;
    use crate::recipes::{ClothSpec, cloth_grid};
    use crate::simulation::Simulation;

    /// Cells along a side.
    const CELLS: u32 = 24;

    /// A sheet of 2 m whose particles have different masses, with one pin near the middle.
    fn sheet() -> Simulation {
        let side = ClothSpec { width: 2.0, height: 2.0, ..ClothSpec::default() };
        let spec = ClothSpec { columns: CELLS, rows: CELLS, ..side };
        let mut world = Simulation::default();
        let mut cloth = cloth_grid(&spec).unwrap();
        cloth.pin(row(8, 12)).unwrap();
        cloth.build(&mut world).unwrap();
        world.step(1.0 / 60.0).unwrap();
        for i in 0..world.particles.len() {
            world.particles.position[i].w *= 1.0 + 0.1 * (i % 7) as f32;
        }
        world
    }

    fn row(x: u32, y: u32) -> u32 {
        y * (CELLS + 1) + x
    }

    /// Calls `check` with the particles and the aggregate of a row.
    fn aggregate<T>(
        row: u32,
        push: Push,
        check: impl FnOnce(&mut Particles, Option<Aggregate>) -> T,
    ) -> T {
        let world = sheet();
        let mut particles = world.particles.clone();
        let substep = SubstepParameters { h: 1e-3, lag: 1e-3, gravity: 9.81, number: 0, of: 10 };
        let execution = ExecutionContext { instructions: InstructionSet::default(), workers: None };
        let mut scratch = PressedScratch::default();
        let mut cloth = HeldCloth::new(world.plan(), (substep, execution), &mut scratch);
        let aggregate = cloth.aggregate(&particles.clone(), row, push);
        check(&mut particles, aggregate)
    }

    #[test]
    fn a_push_that_stretches_no_rod_by_much_moves_one_particle() {
        let rod = 2.0 / CELLS as f32;
        let push = |distance| Push { distance, mass: 10.0 };
        assert!(aggregate(row(12, 12), push(STRAIN * rod), |_, own| own.is_none()));
        let rings = |distance| aggregate(row(12, 12), push(distance), |_, own| own.unwrap().rings);
        assert_eq!(rings(2.0 * STRAIN * rod), 2);
        assert!(rings(0.1) > 4 && rings(10.0) <= MAX_RINGS, "{} {}", rings(0.1), rings(10.0));
    }

    #[test]
    fn those_that_go_along_weigh_as_much_as_they_may_and_no_pin_is_among_them() {
        for mass in [0.01, 0.05, 0.2] {
            let push = Push { distance: 10.0, mass };
            aggregate(row(12, 12), push, |particles, own| {
                let own = own.unwrap();
                let share = |ring| ring_share(ring, own.rings);
                let each = own.members.iter().map(|&(row, ring)| {
                    let w = particles.position[row as usize].w;
                    assert!(w > 0.0 && row != self::row(8, 12));
                    share(ring) / w
                });
                let whole = each.sum::<f32>();
                assert!((whole * own.inverse_mass - 1.0).abs() < 1e-4);
                assert!(whole >= mass && whole < 5.0 * mass, "{mass}: {whole}");
                assert_eq!(own.members[0], (row(12, 12), 0));
            });
        }
    }

    /// At a hem and at a pin an aggregate is one-sided: it turns about its barycentre.
    #[test]
    fn a_push_keeps_momentum_and_moments_and_moves_the_middle_as_it_says() {
        for at in [row(12, 12), row(0, 0), row(24, 7), row(9, 12)] {
            for impulse in [Vec3::Y * 1e-3, Vec3::new(2e-3, -1e-3, 3e-3)] {
                let push = Push { distance: 0.05, mass: 0.1 };
                aggregate(at, push, |particles, own| {
                    let own = own.unwrap();
                    let before = particles.position.clone();
                    own.apply_impulse(particles, at, impulse);
                    let start = |row: usize| particles.start[row].truncate();
                    let middle = start(at as usize);
                    let moved = |row: usize| (particles.position[row] - before[row]).truncate();
                    let (mut sum, mut moment) = (Vec3::ZERO, Vec3::ZERO);
                    for row in (0..before.len()).filter(|&row| before[row].w > 0.0) {
                        let given = moved(row) / before[row].w;
                        sum += given;
                        moment += (start(row) - middle).cross(given);
                    }
                    let size = impulse.length();
                    assert!((sum - impulse).length() < 1e-4 * size, "{at}: {sum} {impulse}");
                    // Half a metre is how wide it is.
                    assert!(moment.length() < 1e-4 * size, "{at}: {moment}");
                    let along = impulse / size;
                    let predicted = own.compliance(along) * size;
                    let actual = moved(at as usize).dot(along);
                    assert!(
                        (predicted - actual).abs() < 1e-4 * actual,
                        "{at}: {predicted} {actual}"
                    );
                    assert_eq!(moved(row(8, 12) as usize), Vec3::ZERO);
                });
            }
        }
    }

    #[test]
    fn sizes_are_rounded_up_to_powers_of_two() {
        for (x, up) in [(1.0, 1.0), (1.1, 2.0), (0.3, 0.5), (0.25, 0.25)] {
            assert_eq!(power_of_two(x), up, "{x}");
        }
        assert!(power_of_two(f32::MAX).is_finite());
    }
}
