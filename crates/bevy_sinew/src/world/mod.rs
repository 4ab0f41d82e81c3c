//! The solver's working copy of the components, and the tables that map between the two. Scratch: it is filled at the start of every tick, and none of it
//! persists.

mod links;
mod phases;

pub(crate) use links::{CompiledSurfaces, LinkIndex, LinkKey, Links};
pub(crate) use phases::PhaseWatch;

use core::ops::Deref;
use std::collections::BTreeSet;

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;
use sinew::pose::{Motion, Pose};
use sinew::{ContactParticipant, ParticleFault, Particles, Simulation, SolverReport};

#[cfg(feature = "interpolation")]
use crate::carry::RigidMotion;
use crate::components::{CreationOrder, Particle, ParticleRow};
use crate::messages::ReportedErrors;
use crate::rows::Layout;

/// The solver's particles and reports: for custom systems that run between [phases](crate::PhaseSystems), for spatial queries, and to read statistics.
///
/// Outside of the substeps it has the state at the end of the last tick. To change the simulation there, change components.
#[derive(Resource, Default)]
pub struct SinewWorld {
    /// The simulation, gathered from the components. Boxed, since systems that need the rest of the world move this resource out and back.
    pub(crate) simulation: Box<Simulation>,
    pub(crate) tables: Tables,
}

/// The positions between which rows are drawn if the simulation has a speed of its own. The simulation does not depend on it.
#[derive(Default)]
pub(crate) struct PlayedPositions {
    /// Positions at the end of the previous fixed tick, as far as it was played, metres.
    previous: Vec<Vec3>,
    /// Positions at the end of this one, metres.
    current: Vec<Vec3>,
    /// Positions at the start of the last tick, metres.
    tick_start: Vec<Vec3>,
    /// The layout of the rows.
    layout: u64,
}

impl SinewWorld {
    /// The particles of this substep. [`ParticleRow`](crate::ParticleRow) is the row of a particle entity.
    pub fn particles(&self) -> &Particles {
        &self.simulation.particles
    }

    /// The particles of this substep, for adding forces or moving them. Particles are added and removed by components only.
    pub fn particles_mut(&mut self) -> ParticlesMut<'_> {
        ParticlesMut(&mut self.simulation.particles)
    }

    /// The simulation: settings, forces and constraints as gathered for this tick.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Length of the current substep, seconds, and the number of substeps that remain in this tick.
    pub fn substep(&self) -> sinew::Substep {
        self.simulation.substep()
    }

    /// Statistics of the last tick: sweeps, errors, contacts.
    pub fn report(&self) -> &SolverReport {
        self.simulation.report()
    }

    /// The entity of a participant in a contact of the last tick's [report](Self::report): a body, a loose particle or a collider. It may have been despawned
    /// since.
    pub fn entity_of(&self, participant: ContactParticipant) -> Option<Entity> {
        let (list, number) = match participant {
            ContactParticipant::Body(number) => (&self.tables.bodies, number),
            ContactParticipant::Particle(row) => (&self.tables.entities, row),
            ContactParticipant::Collider(number) => (&self.tables.colliders, number),
            // The plugin passes grounds and bounding boxes as colliders.
            ContactParticipant::Plane(_) | ContactParticipant::Box(_) => return None,
        };
        list.get(number as usize).copied()
    }

    /// Stores what a fixed tick has played of the last tick, of which the fraction `ahead` is still to be played; and where that tick began, if it has just
    /// been `taken`, since the next gather discards that.
    pub(crate) fn record_played(&mut self, ahead: f32, taken: bool) {
        let Self { simulation, tables: Tables { played, layout, .. } } = self;
        let layout = layout.number;
        let rows = simulation.particles.len();
        if taken || played.tick_start.len() != rows || played.layout != layout {
            played.tick_start.clear();
            played.tick_start.extend((0..rows).map(|row| simulation.step_start(row)));
        }
        core::mem::swap(&mut played.previous, &mut played.current);
        played.current.clear();
        played.current.extend(played.tick_start.iter().enumerate().map(|(row, &before)| {
            let now = simulation.particles.position(row);
            now + (before - now) * ahead
        }));
        if played.layout != layout || played.previous.len() != played.current.len() {
            played.layout = layout;
            played.previous.clone_from(&played.current);
        }
    }

    /// Moves where a row was at the start of the last tick along with its body, which the game has moved, and, unless it is `carried`, also where it was drawn: it
    /// jumps there.
    #[cfg(feature = "interpolation")]
    pub(crate) fn move_played(&mut self, row: usize, motion: &RigidMotion, carried: bool) {
        let Tables { played, layout, .. } = &mut self.tables;
        if played.layout != layout.number {
            return;
        }
        let drawn = played.current.get_mut(row).filter(|_| !carried);
        for place in [played.tick_start.get_mut(row), drawn].into_iter().flatten() {
            *place = motion.of_point(*place);
        }
    }

    /// The position of a row, metres, at a fraction (`share`) of the fixed tick, as played; `None` for a new row.
    pub(crate) fn played_at(&self, row: usize, share: f32) -> Option<Vec3> {
        let (previous, current) =
            (self.tables.played.previous.get(row)?, self.tables.played.current.get(row)?);
        Some(*previous + (*current - *previous) * share)
    }

    /// Energies and momenta of everything at the end of the last tick, J, kg·m/s and kg·m²/s.
    pub fn ledger(&mut self) -> sinew::Ledger {
        self.simulation.ledger()
    }
}

/// Write access to the particles of a substep for a custom system between two [phases](crate::PhaseSystems): forces, velocities and positions. It dereferences
/// to [`Particles`]. A row out of range panics, like an index. A number that is not finite affects only that particle, which is put back to the start of the
/// tick at its end. A [sleeping](crate::Sleep) body is not affected in this tick, and is awake in the next one.
pub struct ParticlesMut<'w>(&'w mut Particles);

impl Deref for ParticlesMut<'_> {
    type Target = Particles;

    fn deref(&self) -> &Particles {
        self.0
    }
}

impl ParticlesMut<'_> {
    /// Adds a force to particle `i` in this substep, N. Only before [`Integrate`](crate::PhaseSystems::Integrate).
    pub fn add_force(&mut self, i: usize, force: Vec3) {
        if force != Vec3::ZERO {
            self.0.wake(i);
        }
        self.0.add_force(i, force);
    }

    /// Adds an acceleration to particle `i` in this substep, m/s², independent of its mass. Only before [`Integrate`](crate::PhaseSystems::Integrate).
    pub fn add_acceleration(&mut self, i: usize, acceleration: Vec3) {
        if acceleration != Vec3::ZERO {
            self.0.wake(i);
        }
        self.0.add_acceleration(i, acceleration);
    }

    /// Adds damping with the rate `rate`, 1/s, 0 or more, towards a velocity, m/s, to particle `i` in this substep.
    pub fn drag_towards(&mut self, i: usize, rate: f32, velocity: Vec3) {
        if rate != 0.0 {
            self.0.wake(i);
        }
        self.0.drag_towards(i, rate, velocity);
    }

    /// Scales the gravity on particle `i`, for the rest of this tick.
    pub fn scale_gravity(&mut self, i: usize, factor: f32) {
        if factor != 1.0 {
            self.0.wake(i);
        }
        self.0.scale_gravity(i, factor);
    }

    /// Moves particle `i` to a position, metres in the world. Its velocity stays.
    pub fn set_position(&mut self, i: usize, position: Vec3) {
        self.0.set_position(i, position);
    }

    /// Moves particle `i` by a displacement, metres. Its velocity stays.
    pub fn displace(&mut self, i: usize, displacement: Vec3) {
        self.0.displace(i, displacement);
    }

    /// Sets the velocity of particle `i`, m/s.
    pub fn set_velocity(&mut self, i: usize, velocity: Vec3) {
        self.0.wake(i);
        self.0.set_velocity(i, velocity);
    }

    /// Applies an impulse to particle `i`, N·s. A pinned particle is not affected.
    pub fn add_impulse(&mut self, i: usize, impulse: Vec3) {
        if impulse != Vec3::ZERO {
            self.0.wake(i);
        }
        self.0.add_impulse(i, impulse);
    }

    /// Applies an impulse, N·s, at a point in the world, metres, to some particles as a whole.
    pub fn apply_impulse_at(&mut self, rows: &[u32], impulse: Vec3, point: Vec3) {
        rows.iter().for_each(|&row| self.0.wake(row as usize));
        self.0.apply_impulse_at(rows, impulse, point);
    }

    /// Applies an angular impulse, N·m·s, to some particles about their centre of mass.
    pub fn apply_angular_impulse(&mut self, rows: &[u32], angular_impulse: Vec3) {
        rows.iter().for_each(|&row| self.0.wake(row as usize));
        self.0.apply_angular_impulse(rows, angular_impulse);
    }
}

/// The mapping between entities and rows, and what is set aside.
#[derive(Default)]
pub(crate) struct Tables {
    /// The particle of each row, in the order of creation.
    pub(crate) entities: Vec<Entity>,
    /// The particles with their order of creation.
    pub(crate) order: Vec<(CreationOrder, Entity)>,
    /// The error of each row that is set aside.
    pub(crate) refused: Vec<Option<ParticleFault>>,
    /// The number of rows that are set aside.
    pub(crate) set_aside: usize,
    /// The properties of particles that the columns have.
    pub(crate) properties: GatheredProperties,
    /// The solver's count of property edits at the end of the gather. Edits by a game are valid for one tick, and change the count.
    pub(crate) edits: u64,
    /// Whether properties of any particle were copied in this tick.
    pub(crate) properties_gathered: bool,
    /// Whether a body was added, removed or changed in this tick, or has its particles in other rows.
    pub(crate) bodies_changed: bool,
    /// Mass of each row, kg. Pinned particles have theirs, too: it counts for their body's centre of mass.
    pub(crate) mass: Vec<f32>,
    /// The body (or the loose particle) of each index in `Simulation::bodies` and `Simulation::contacts`.
    pub(crate) bodies: Vec<Entity>,
    /// The collider of each index in `Simulation::colliders`, in the order of creation.
    pub(crate) colliders: Vec<Entity>,
    /// The part, or the rod, of each of `Simulation::body_colliders`.
    pub(crate) parts: Vec<Entity>,
    /// Errors of springs and constraints, so that each is reported once.
    pub(crate) reported_errors: ReportedErrors,
    /// Pins with an invalid number, so that each is reported once.
    pub(crate) broken: BTreeSet<Entity>,
    /// The keys of the links in the solver's lists.
    pub(crate) links: Links,
    /// Whether distances, springs or surfaces must be compiled again.
    pub(crate) links_stale: bool,
    /// Whether they were compiled in this tick.
    pub(crate) links_compiled: bool,
    /// Whether distances were added, removed or changed before this tick.
    pub(crate) distances_changed: bool,
    /// Where rows are drawn.
    pub(crate) played: PlayedPositions,
    /// The change tick at which the last tick began that has ended; `None` before there is one.
    pub(crate) began: Option<Tick>,
    /// The particles that are disabled, sorted.
    pub(crate) disabled: Vec<Entity>,
    /// The change tick at which particles were last written back.
    pub(crate) scattered: Option<Tick>,
    /// Rows of particles that anything but the simulation has written to since they were last gathered.
    pub(crate) dirty: DirtyRows,
    /// Whether loading the particles is deferred until a change is found.
    pub(crate) deferred: bool,
    /// Whether nothing but the time changed in this tick.
    pub(crate) rested: bool,
    /// Whether a step was taken in this tick, and has ended.
    pub(crate) stepped: bool,
    /// Whether each body sleeps, by index: after the gather as at the start of the tick, after the scatter whether it slept through the tick.
    pub(crate) asleep: Vec<bool>,
    /// Whether each body slept, and nothing wrote to it: what was extracted from it is still valid.
    pub(crate) unmoved: Vec<bool>,
    /// The change tick at which the contact cache was last kept, and the number of caches; `None` if the parts have changed since.
    pub(crate) cache_kept: Option<(Tick, usize)>,
    /// The row of each particle.
    pub(crate) layout: Layout,
    /// The record of the phases of this tick; `None` in a usual one.
    pub(crate) watch: Option<Box<PhaseWatch>>,
    /// The acceleration that each of the force phases added to each row in the last substep, m/s²; `None` if it is not recorded.
    pub(crate) forces: Option<Box<[Vec<Vec3>; 4]>>,
}

/// The properties that the columns have.
#[derive(Debug, Default)]
pub(crate) struct GatheredProperties {
    /// The layout of their rows.
    pub(crate) layout: u64,
    /// The number of particles with each of the property components.
    pub(crate) counts: [usize; 8],
    /// Which of these components the particle of each row had when its properties were copied, one bit each; 0 for a row whose properties were never copied.
    pub(crate) kinds: Vec<u8>,
    /// The gravity scale of each particle, without that of its body.
    pub(crate) gravity_scale: Vec<f32>,
}

impl GatheredProperties {
    /// Resizes to this number of rows, of which the first `same` are kept.
    pub(crate) fn lay_out(&mut self, same: usize, rows: usize) {
        self.kinds.truncate(same);
        self.kinds.resize(rows, 0);
        self.gravity_scale.truncate(same);
        self.gravity_scale.resize(rows, 1.0);
    }
}

/// The particles that were written to since they were last gathered.
#[derive(Default)]
pub(crate) struct DirtyRows {
    /// Whether any particle may have been written to.
    pub(crate) all: bool,
    /// The rows that were written to, in any order.
    pub(crate) rows: Vec<u32>,
}

impl SinewWorld {
    /// Whether all of some rows belong to bodies that are true in `bodies`, a list by body index.
    fn all_in(&self, bodies: &[bool], rows: &[u32]) -> bool {
        let listed = |&row: &u32| {
            let body = self.simulation.particles.body(row as usize);
            body.is_some_and(|body| bodies.get(body as usize) == Some(&true))
        };
        let particles = self.simulation.particles.len();
        !rows.is_empty() && rows.iter().all(|row| (*row as usize) < particles && listed(row))
    }

    /// Whether bodies that slept through the last tick need not be loaded: nothing has written to any of them, neither to a component nor to the columns.
    pub(crate) fn keeps_sleepers(&self) -> bool {
        let Tables { dirty, set_aside, .. } = &self.tables;
        let as_they_were = !dirty.all && dirty.rows.is_empty() && *set_aside == 0;
        as_they_were && self.simulation.are_sleepers_untouched()
    }

    /// The number of consecutive particles of a table, starting at `from`, that belong to bodies that slept through the last tick and have in their rows what
    /// was written back. (The substep length may have changed since.)
    pub(crate) fn sleeping_run(
        &self,
        states: &[Particle],
        rows: &[ParticleRow],
        from: usize,
    ) -> usize {
        let particles = &self.simulation.particles;
        let (mut place, mut last) = (from, None);
        while let Some(row) = rows.get(place).and_then(|row| row.get()) {
            let body = if row < particles.len() { particles.body(row) } else { None };
            let Some(body) = body else { break };
            // All particles of a body are written back together.
            let sleeps = || self.tables.asleep.get(body as usize) == Some(&true);
            if last != Some(body) && !(sleeps() && particles.lag(row) == states[place].lag) {
                break;
            }
            (place, last) = (place + 1, Some(body));
        }
        place - from
    }

    /// The number of particles of a table, starting at `from`, before the next one of a body that slept through the last tick; at least 1.
    pub(crate) fn waking_run(&self, rows: &[ParticleRow], from: usize) -> usize {
        let particles = &self.simulation.particles;
        let body = |place: usize| rows[place].within(particles).and_then(|row| particles.body(row));
        let mut last = body(from);
        let mut others = from + 1..rows.len();
        let next = others.find(|&place| {
            let before = core::mem::replace(&mut last, body(place));
            let sleeps = |body: u32| self.tables.asleep.get(body as usize) == Some(&true);
            before != last && last.is_some_and(sleeps)
        });
        next.unwrap_or(rows.len()) - from
    }

    /// Loads particles of a table, starting at `from`, as long as they have consecutive rows and none is set aside. Returns how many.
    pub(crate) fn load(&mut self, states: &[Particle], rows: &[ParticleRow], from: usize) -> usize {
        let run = self.tables.valid_run(&rows[from..]);
        let some = states[from..from + run].iter().map(|&particle| particle.into());
        self.simulation.particles.load(rows[from].0 as usize, some)
    }

    /// Whether all rows are as the last tick left them, and that tick did not change them; they need not be gathered then.
    pub(crate) fn is_settled(&self) -> bool {
        let Tables { dirty, set_aside, .. } = &self.tables;
        !dirty.all && dirty.rows.is_empty() && *set_aside == 0 && self.simulation.is_settled()
    }

    /// If nothing but the time changes in a tick of `dt` seconds, takes it at once, and records that there is nothing to scatter or to extract. Returns whether
    /// it did.
    pub(crate) fn step_at_rest(&mut self, dt: f32) -> bool {
        self.tables.rested = self.tables.deferred && self.simulation.step_at_rest(dt);
        self.tables.rested
    }

    /// The pose of a body collider that was one rigid state in this tick; `None` for any other. Of the two quaternions of its rotation, the one nearer to
    /// `before`.
    pub(crate) fn rigid_pose(&self, collider: u32, before: Quat) -> Option<Pose> {
        let pose = self.tables.stepped.then(|| self.simulation.rigid_pose(collider as usize))??;
        let rotation = if pose.rotation.dot(before) < 0.0 { -pose.rotation } else { pose.rotation };
        Some(Pose { rotation, ..pose })
    }

    /// The motion of a body collider that was one rigid state in this tick; `None` for any other.
    pub(crate) fn rigid_motion(&self, collider: u32) -> Option<Motion> {
        self.tables.stepped.then(|| self.simulation.rigid_motion(collider as usize))?
    }

    /// Whether the bodies of all of some rows slept through the tick.
    pub(crate) fn slept_through(&self, rows: &[u32]) -> bool {
        self.all_in(&self.tables.asleep, rows)
    }

    /// Whether what was extracted from some rows in the last tick is still valid.
    pub(crate) fn are_unmoved(&self, rows: &[u32]) -> bool {
        self.all_in(&self.tables.unmoved, rows)
    }
}

/// Loads the particles that were deferred because everything is [at rest](SinewWorld::is_settled), when they are needed after all.
pub(crate) fn load_deferred(world: &mut World) {
    if world.resource::<SinewWorld>().tables.deferred {
        let ran = world.run_system_cached(load_particles);
        debug_assert!(ran.is_ok(), "all parameters of the system always exist");
    }
}

fn load_particles(mut world: ResMut<SinewWorld>, particles: Query<(&Particle, &ParticleRow)>) {
    world.tables.deferred = false;
    for (states, rows) in particles.contiguous_iter().into_iter().flatten() {
        let mut i = 0;
        while i < rows.len() {
            // None of them is set aside, or they would not have been deferred.
            i += world.load(states, rows, i).max(1);
        }
    }
}

impl Tables {
    /// Whether an entity is a particle that takes no part for a time: it is set aside, or disabled.
    pub(crate) fn is_absent(&self, entity: Entity) -> bool {
        let is_set_aside = |row: u32| !self.is_valid(row as usize);
        self.set_aside > 0 && self.layout.row_of.get(&entity).is_some_and(|&row| is_set_aside(row))
            || !self.disabled.is_empty() && self.disabled.binary_search(&entity).is_ok()
    }

    /// Whether a row exists, and is not set aside.
    pub(crate) fn is_valid(&self, row: usize) -> bool {
        self.refused.get(row).is_some_and(Option::is_none)
    }

    /// The number of leading particles that have consecutive rows, none of them set aside. 0 if the first one is set aside, or has no row.
    pub(crate) fn valid_run(&self, rows: &[ParticleRow]) -> usize {
        let Some(first) = rows.first().and_then(|row| row.get()) else { return 0 };
        let valid = |row: usize| self.set_aside == 0 || self.is_valid(row);
        let mut wanted = (first..self.refused.len()).zip(rows);
        wanted
            .position(|(wanted, row)| row.0 as usize != wanted || !valid(wanted))
            .unwrap_or_else(|| rows.len().min(self.refused.len().saturating_sub(first)))
    }

    /// The row of a particle that takes part; `None` if it is gone or set aside.
    pub(crate) fn valid_row(&self, entity: Entity) -> Option<u32> {
        let row = *self.layout.row_of.get(&entity)?;
        self.is_valid(row as usize).then_some(row)
    }
}
