//! Pressed cloth: where a shape of another body presses on large cloth, contacts and rods take turns.
//!
//! A particle of cloth weighs next to nothing beside a crate. A contact between the two moves the particle, and hardly the crate: it brakes that by as much
//! as one particle weighs, however taut the cloth is, for it knows of no rods. Those pull the particle back in the next substep, and the crate pushes
//! it out again. That is Gauss and Seidel's way with a large mass on small ones, which converges by `1 - m/M` in a turn: a crate of mass `M` on particles of mass `m`
//! in all is stopped by taut cloth within some `M/m` substeps, and meanwhile stretches it by as far as it goes; and at rest on it, it takes a push of `g h² M/m` in each
//! substep to carry it, 3 mm on a flat bottom, and 9 cm on a corner. More sweeps of the rods are no help, for the contacts have the last word. What counts is
//! how much is pushed, and how often the two change places.
//!
//! So what is pushed is not a particle but a piece of cloth: the particles about it, ring by ring of rods, the nearer the more, until they weigh a share of what
//! presses ([`Aggregate`](crate::collide::Aggregate)). It is what (smoothed) aggregation is to a multigrid method: errors that a sweep takes many substeps for are corrected on
//! a coarse level, which here has one unknown, and is wanted where contacts are and nowhere else. An impulse on it keeps momentum as one on a particle does. It
//! stretches each rod by a ring's share of the push, where the whole of it was in the first one.
//!
//! And contacts of particles with shapes have several turns in a substep, and in between what they have moved is held: to its pins, by its
//! [tethers](super::tethers), and by the rods about it that are off by more than [strain limiting](super::strain_limit) lets them, for a few rings of rods. It moves positions
//! before velocities are derived: it is solving, and keeps momentum as rods do.

use core::ops::Range;

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::context::{SolveContext, SubstepParameters};
use super::plan::Plan;
use super::strain_limit::StrainScratch;
use crate::collide::{
    Aggregate, NormalImpulse, NormalImpulses, ParticleContacts, PressedCloth, Push, ring_share,
};
use crate::particles::{Particles, Places};
use crate::pose::symmetric;
use crate::threads::ExecutionContext;

/// Over so many rings of rods about what was pressed on a push is handed on in one turn. In the two scenes of `TURNS` (`body_contact`) by 2, 4 and 8: 3.7, 3.3 and 3.0 %, in 2.4, 2.4 and
/// 2.7 ms; 5.0, 4.2 and 4.3 %, in 3.2, 3.4 and 3.8 ms.
const RINGS: usize = 4;

/// A push goes to so many rings that no rod is stretched by more than this share of its length. Particles that are not pressed on, and go along with what hardly needs
/// them, are thrown a little in each substep: particles of a sheet that lies on nine crates move by 233, 2 and 5 mm/s from tick to tick in the eighth second by 1, 2 and 4 %, root mean square.
const STRAIN: f32 = 0.02;

/// Of so many rings of rods an aggregate is at the most: of grid cloth some 900 particles. By 8 and 12, before some pushes were taken back, what a
/// crate in slack cloth stretches it by was half as much again.
const MOST_RINGS: u32 = 16;

/// Cloth that contacts press on in a substep, held by its constraints.
pub(crate) struct HeldCloth<'a> {
    plan: &'a Plan,
    substep: SubstepParameters,
    execution: ExecutionContext<'a>,
    scratch: &'a mut PressedScratch,
}

/// What pressed cloth needs. Scratch: nothing of it lasts longer than a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct PressedScratch {
    strain: StrainScratch,
    /// Which rows are listed.
    listed: Marks,
    /// Of each row the number of its aggregate in this step; of what was not pushed that of none.
    numbers: Vec<u32>,
    aggregates: Vec<RowAggregate>,
    /// Rows, with the numbers of their rings.
    members: Vec<(u32, u32)>,
}

/// That of one row.
#[derive(Clone, Debug, Default)]
struct RowAggregate {
    /// How much it may weigh, kg.
    mass: f32,
    /// Of all of its rings.
    members: Range<u32>,
    /// The length of the rods in its middle, metres.
    rod: f32,
    /// In which substep, with how many rings, it was weighed last.
    weighed: (u32, u32),
    /// How many members that were.
    count: u32,
    inverse_mass: f32,
    inverse_inertia: Mat3,
    lever: Vec3,
}

/// No aggregate.
const NONE: u32 = u32::MAX;

impl<'a> HeldCloth<'a> {
    /// In a substep of a plan. In the first of a step what is known of aggregates is forgotten, for masses may have changed.
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
        // Of few sizes, for what presses touches somewhat more or less from substep to substep.
        let mass = power_of_two(mass);
        if own.mass != mass {
            let first = members.len() as u32;
            let rod = grow(self.plan, particles, (row, mass), members, listed);
            let members = first..members.len() as u32;
            *own = RowAggregate { mass, members, rod, ..RowAggregate::default() };
        }
        let members = &members[own.members.start as usize..own.members.end as usize];
        let most = members.last().map_or(0, |&(_, ring)| ring + 1);
        let rings = ((distance / (STRAIN * own.rod)) as u32 + 1).min(most);
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

    fn hold(
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
            // What stands has the last word: who was held is pressed on again.
            let (mut places, interval) = (Places::all(particles), context.interval());
            let mut normal_impulses = NormalImpulses::all(normal_impulses);
            let others = moved.iter().map(|member| member + first);
            let moved = rows.iter().copied().chain(others.filter(|&row| listed.insert(row)));
            particle_contacts.project_rows(&mut places, &mut normal_impulses, moved, interval);
        }
        any
    }
}

/// Adds the aggregate of a row to the members: the particles about it, ring by ring of rods, until they weigh so much, each as often as its share is. Pins are no part of it,
/// and end it. Returns the mean length of the rods in its middle, metres.
fn grow(
    plan: &Plan,
    particles: &Particles,
    (row, mass): (u32, f32),
    members: &mut Vec<(u32, u32)>,
    listed: &mut Marks,
) -> f32 {
    let w = |row: u32| particles.position[row as usize].w;
    let first = members.len();
    members.push((row, 0));
    let Some(&number) = plan.islands.of.get(row as usize) else { return 0.0 };
    let island = &plan.islands.list[number as usize];
    let (graph, run) = (plan.tethers.graph_of(island), plan.stretch(island));
    let (true, Some(graph), Some(run)) = (island.takes_microsteps(), graph, run) else {
        return 0.0;
    };
    let first_row = run.start as u32;
    listed.clear(particles.len());
    listed.insert(row);
    // Of all of them, and times the number of their rings.
    let (mut sum, mut moment) = (1.0 / w(row), 0.0);
    let (mut ring, mut rings) = (first, 1);
    while rings < MOST_RINGS && sum - moment / (rings as f32) < mass && ring < members.len() {
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
    let rods = graph.rods_of(row - first_row);
    rods.iter().map(|rod| rod.rest).sum::<f32>() / rods.len() as f32
}

impl RowAggregate {
    /// Weighs its members, of which the first is in their middle, where they were when the substep began.
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

/// The next power of two, of what is positive and finite.
fn power_of_two(x: f32) -> f32 {
    const MANTISSA: u32 = (1 << 23) - 1;
    f32::from_bits((x.to_bits() + MANTISSA) & !MANTISSA).min(f32::MAX)
}

/// Which rows are in a set, that is cleared often.
#[derive(Clone, Debug, Default)]
struct Marks {
    /// In which of the sets each was last.
    last: Vec<u32>,
    number: u32,
}

impl Marks {
    /// Of so many rows none is in the set.
    fn clear(&mut self, rows: usize) {
        self.number = self.number.wrapping_add(1);
        if self.number == 0 || self.last.len() < rows {
            (self.number, self.last) = (1, vec![0; rows]);
        }
    }

    /// Whether a row was not in it.
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

    /// A sheet of 2 m whose particles have different masses, and one row in the middle of it.
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

    /// Lends the aggregate of a row to `see`, with the particles.
    fn aggregate<T>(
        row: u32,
        push: Push,
        see: impl FnOnce(&mut Particles, Option<Aggregate>) -> T,
    ) -> T {
        let world = sheet();
        let mut particles = world.particles.clone();
        let substep = SubstepParameters { h: 1e-3, lag: 1e-3, gravity: 9.81, number: 0, of: 10 };
        let execution = ExecutionContext { instructions: InstructionSet::default(), workers: None };
        let mut scratch = PressedScratch::default();
        let mut cloth = HeldCloth::new(world.plan(), (substep, execution), &mut scratch);
        let aggregate = cloth.aggregate(&particles.clone(), row, push);
        see(&mut particles, aggregate)
    }

    #[test]
    fn a_push_that_stretches_no_rod_by_much_moves_one_particle() {
        let rod = 2.0 / CELLS as f32;
        let push = |distance| Push { distance, mass: 10.0 };
        assert!(aggregate(row(12, 12), push(STRAIN * rod), |_, own| own.is_none()));
        let rings = |distance| aggregate(row(12, 12), push(distance), |_, own| own.unwrap().rings);
        assert_eq!(rings(2.0 * STRAIN * rod), 2);
        assert!(rings(0.1) > 4 && rings(10.0) <= MOST_RINGS, "{} {}", rings(0.1), rings(10.0));
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

    /// At a hem and at a pin there is more of it on one side: it turns about its barycentre.
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
                    let said = own.compliance(along) * size;
                    let went = moved(at as usize).dot(along);
                    assert!((said - went).abs() < 1e-4 * went, "{at}: {said} {went}");
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
