//! The solver's working copy of the components, and the tables that lead from one to the other. Scratch: it is refilled at the start
//! of every tick, and nothing in it survives one.

mod links;
mod phases;

pub(crate) use links::{CompiledSurfaces, LinkAt, Links, Place};
pub(crate) use phases::PhaseWatch;

use core::ops::Deref;
use std::collections::BTreeSet;

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;
use sinew::pose::{Motion, Pose};
use sinew::{ContactParticipant, ParticleFault, Particles, Simulation, SolverReport};

use crate::components::{CreationOrder, Particle, ParticleRow};
use crate::messages::ReportedErrors;
use crate::rows::Layout;

/// The columns that the phases work on, for the systems of a game that join in between [phases](crate::PhaseSystems).
///
/// Outside the substeps it holds the last tick's end. To change the simulation there, change components.
#[derive(Resource, Default)]
pub struct SinewWorld {
    /// The simulation whose columns were gathered from the components of this tick. In a box, since the world is moved out of its resource and back by systems
    /// that need all else as well.
    pub(crate) simulation: Box<Simulation>,
    pub(crate) tables: Tables,
}

/// Between which places rows are drawn where time does not pass by one whole tick for each fixed tick. Nothing of the simulation depends on it.
#[derive(Default)]
pub(crate) struct Played {
    /// Where the rows were when the last fixed tick ended, as far as that was played, metres.
    from: Vec<Vec3>,
    /// Where they were when this one ended.
    to: Vec<Vec3>,
    /// Where they were when the last tick began, metres.
    began: Vec<Vec3>,
    /// The layout of rows that they are in.
    layout: u64,
}

impl SinewWorld {
    /// The particles of this substep. [`ParticleRow`](crate::ParticleRow) says which row is whose.
    pub fn particles(&self) -> &Particles {
        &self.simulation.particles
    }

    /// The particles of this substep, to add forces to or to move. What there is of them follows from components alone.
    pub fn particles_mut(&mut self) -> ParticlesMut<'_> {
        ParticlesMut(&mut self.simulation.particles)
    }

    /// The simulation: settings, forces and constraints as gathered for this tick.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Length of the current substep, seconds, and how many are left in this tick.
    pub fn substep(&self) -> sinew::Substep {
        self.simulation.substep()
    }

    /// How the last tick went.
    pub fn report(&self) -> &SolverReport {
        self.simulation.report()
    }

    /// Who takes part in a contact of the [report](Self::report) of the last tick: a body, a loose particle or a collider. It may have been
    /// despawned since.
    pub fn entity_of(&self, participant: ContactParticipant) -> Option<Entity> {
        let (list, number) = match participant {
            ContactParticipant::Body(number) => (&self.tables.bodies, number),
            ContactParticipant::Particle(row) => (&self.tables.entities, row),
            ContactParticipant::Collider(number) => (&self.tables.colliders, number),
            // Grounds and rooms are colliders.
            ContactParticipant::Plane(_) | ContactParticipant::Box(_) => return None,
        };
        list.get(number as usize).copied()
    }

    /// Notes what a fixed tick has played of the last tick, of which the part `ahead` is yet to come; and where that began, if it has just been `taken`: a
    /// gathering later, the simulation does not know.
    pub(crate) fn play(&mut self, ahead: f32, taken: bool) {
        let Self { simulation, tables: Tables { played, layout, .. } } = self;
        let layout = layout.number;
        let rows = simulation.particles.len();
        if taken || played.began.len() != rows || played.layout != layout {
            played.began.clear();
            played.began.extend((0..rows).map(|row| simulation.step_start(row)));
        }
        core::mem::swap(&mut played.from, &mut played.to);
        played.to.clear();
        played.to.extend(played.began.iter().enumerate().map(|(row, &before)| {
            let now = simulation.particles.position(row);
            now + (before - now) * ahead
        }));
        if played.layout != layout || played.from.len() != played.to.len() {
            played.layout = layout;
            played.from.clone_from(&played.to);
        }
    }

    /// Where a row is a share of the way through the fixed tick, as far as that played, metres; `None` of one that is new.
    pub(crate) fn played_at(&self, row: usize, share: f32) -> Option<Vec3> {
        let (from, to) = (self.tables.played.from.get(row)?, self.tables.played.to.get(row)?);
        Some(*from + (*to - *from) * share)
    }

    /// Energies and momenta of everything, J, kg·m/s and kg·m²/s, as of the end of the last tick.
    pub fn ledger(&mut self) -> sinew::Ledger {
        self.simulation.ledger()
    }
}

/// The particles of a substep as a game's system between two [phases](crate::PhaseSystems) may change them: forces, velocities and positions. It reads as
/// [`Particles`] does. A row out of range panics, as an index does; a number that is not finite makes that particle alone non-finite, and the tick's end
/// puts it back to where the tick began. What [sleeps](crate::Sleep) feels nothing of it, and is awake in the next tick.
pub struct ParticlesMut<'w>(&'w mut Particles);

impl Deref for ParticlesMut<'_> {
    type Target = Particles;

    fn deref(&self) -> &Particles {
        self.0
    }
}

impl ParticlesMut<'_> {
    /// Adds a force to particle `i` in this substep, N. Before [`Integrate`](crate::PhaseSystems::Integrate) only.
    pub fn add_force(&mut self, i: usize, force: Vec3) {
        if force != Vec3::ZERO {
            self.0.wake(i);
        }
        self.0.add_force(i, force);
    }

    /// Adds an acceleration to particle `i` in this substep, m/s², whatever its mass. Before [`Integrate`](crate::PhaseSystems::Integrate) only.
    pub fn add_acceleration(&mut self, i: usize, acceleration: Vec3) {
        if acceleration != Vec3::ZERO {
            self.0.wake(i);
        }
        self.0.add_acceleration(i, acceleration);
    }

    /// Adds a drag of `rate` per second, 0 and up, towards a velocity, m/s, to particle `i` in this substep.
    pub fn drag_towards(&mut self, i: usize, rate: f32, velocity: Vec3) {
        self.0.wake(i);
        self.0.drag_towards(i, rate, velocity);
    }

    /// Scales the gravity that particle `i` feels, for the rest of this tick.
    pub fn scale_gravity(&mut self, i: usize, factor: f32) {
        self.0.wake(i);
        self.0.scale_gravity(i, factor);
    }

    /// Puts particle `i` somewhere, metres in the world. Its velocity stays.
    pub fn set_position(&mut self, i: usize, position: Vec3) {
        self.0.set_position(i, position);
    }

    /// Moves particle `i` by so much, metres. Its velocity stays.
    pub fn displace(&mut self, i: usize, displacement: Vec3) {
        self.0.displace(i, displacement);
    }

    /// Gives particle `i` a velocity, m/s.
    pub fn set_velocity(&mut self, i: usize, velocity: Vec3) {
        self.0.wake(i);
        self.0.set_velocity(i, velocity);
    }

    /// Adds an impulse to particle `i`, N·s. A pinned particle does not feel it.
    pub fn add_impulse(&mut self, i: usize, impulse: Vec3) {
        if impulse != Vec3::ZERO {
            self.0.wake(i);
        }
        self.0.add_impulse(i, impulse);
    }

    /// Adds an impulse, N·s, to some particles as a whole, at a point in the world, metres.
    pub fn apply_impulse_at(&mut self, rows: &[u32], impulse: Vec3, point: Vec3) {
        rows.iter().for_each(|&row| self.0.wake(row as usize));
        self.0.apply_impulse_at(rows, impulse, point);
    }

    /// Adds an angular impulse, N·m·s, to some particles about their barycentre.
    pub fn apply_angular_impulse(&mut self, rows: &[u32], angular_impulse: Vec3) {
        rows.iter().for_each(|&row| self.0.wake(row as usize));
        self.0.apply_angular_impulse(rows, angular_impulse);
    }
}

/// Who is in which row, and what is set aside.
#[derive(Default)]
pub(crate) struct Tables {
    /// The particle of each row, in the order of creation.
    pub(crate) entities: Vec<Entity>,
    /// The same with their numbers.
    pub(crate) order: Vec<(CreationOrder, Entity)>,
    /// Why a row is set aside, if it is.
    pub(crate) refused: Vec<Option<ParticleFault>>,
    /// How many rows are set aside.
    pub(crate) set_aside: usize,
    /// Which properties of particles the columns hold.
    pub(crate) held: HeldProperties,
    /// How often properties in the columns had been changed when gathering was done. A game that does so, too, does it for a tick.
    pub(crate) edits: u64,
    /// Whether properties of a particle were copied in this tick.
    pub(crate) properties_gathered: bool,
    /// Whether a body came, went or has something new to say in this tick, or has its particles in other rows.
    pub(crate) bodies_changed: bool,
    /// Mass of each row, kg, pinned or not: a pinned particle still counts where its body is.
    pub(crate) mass: Vec<f32>,
    /// The body (or the loose particle) of each number in `Simulation::bodies` and `Simulation::contacts`.
    pub(crate) bodies: Vec<Entity>,
    /// The collider of each number in `Simulation::colliders`, in the order of creation.
    pub(crate) colliders: Vec<Entity>,
    /// The part, or the rod, of each of `Simulation::body_colliders`.
    pub(crate) parts: Vec<Entity>,
    /// Why a spring or a constraint is set aside: so that each is reported once.
    pub(crate) reported_errors: ReportedErrors,
    /// Pins with a broken number: so that each is reported once.
    pub(crate) broken: BTreeSet<Entity>,
    /// Which links the solver's lists hold.
    pub(crate) links: Links,
    /// Distances, springs or surfaces must be compiled afresh.
    pub(crate) stale: bool,
    /// Whether they were in this tick.
    pub(crate) relinked: bool,
    /// Whether distances came, went or changed before this tick.
    pub(crate) retied: bool,
    /// Where rows are drawn.
    pub(crate) played: Played,
    /// When particles were last written back.
    pub(crate) scattered: Option<Tick>,
    /// Which particles somebody else has written to since they were last gathered, by row, and whether it may have been any.
    pub(crate) touched: Touched,
    /// Whether loading the particles is put off until something is known to have changed.
    pub(crate) deferred: bool,
    /// Whether nothing but the time changed in this tick.
    pub(crate) rested: bool,
    /// Whether a step was taken in this tick, and is over.
    pub(crate) stepped: bool,
    /// The bodies that sleep, by number: from the end of gathering on as they were, from scattering on those that slept through the tick.
    pub(crate) asleep: Vec<bool>,
    /// Those of them of which nothing was written: what is extracted of them stays as it is.
    pub(crate) unmoved: Vec<bool>,
    /// When the contact cache was last kept, and how many there were who might remember something; `None` if the parts are not the same since.
    pub(crate) cache_kept: Option<(Tick, usize)>,
    /// Which row each particle has.
    pub(crate) layout: Layout,
    /// Who watches the phases of the tick at hand; nobody in a usual one.
    pub(crate) watch: Option<Box<PhaseWatch>>,
    /// What each of the phases of forces added to the acceleration of each row in the last substep, m/s²; `None`: nobody wants to know.
    pub(crate) forces: Option<Box<[Vec<Vec3>; 4]>>,
}

/// What properties the columns hold.
#[derive(Debug, Default)]
pub(crate) struct HeldProperties {
    /// The layout of rows that they are in.
    pub(crate) layout: u64,
    /// How many particles there are with each of the components that say them.
    pub(crate) counts: [usize; 8],
    /// Which of these components the particle of each row had when its properties were copied, a bit for each; 0 of a row whose properties never were.
    pub(crate) kinds: Vec<u8>,
    /// By how much each particle says that gravity on it is scaled; its body may scale it, too.
    pub(crate) gravity_scale: Vec<f32>,
}

impl HeldProperties {
    /// Makes room for so many rows, of which some, from the first on, are what they were.
    pub(crate) fn lay_out(&mut self, same: usize, rows: usize) {
        self.kinds.truncate(same);
        self.kinds.resize(rows, 0);
        self.gravity_scale.truncate(same);
        self.gravity_scale.resize(rows, 1.0);
    }
}

/// Which particles were written to since they were last gathered.
#[derive(Default)]
pub(crate) struct Touched {
    /// Whether it may have been any.
    pub(crate) all: bool,
    /// Their rows, in any order.
    pub(crate) rows: Vec<u32>,
}

impl SinewWorld {
    /// Whether all of some rows are of bodies in a list, which goes by their numbers.
    fn all_in(&self, bodies: &[bool], rows: &[u32]) -> bool {
        let listed = |&row: &u32| {
            let body = self.simulation.particles.body(row as usize);
            body.is_some_and(|body| bodies.get(body as usize) == Some(&true))
        };
        let particles = self.simulation.particles.len();
        !rows.is_empty() && rows.iter().all(|row| (*row as usize) < particles && listed(row))
    }

    /// Whether those who slept through the last tick need not be loaded: nobody has written to any of them, neither as a component nor in the columns.
    pub(crate) fn keeps_sleepers(&self) -> bool {
        let Tables { touched, set_aside, .. } = &self.tables;
        let as_they_were = !touched.all && touched.rows.is_empty() && *set_aside == 0;
        as_they_were && self.simulation.are_sleepers_untouched()
    }

    /// How many particles of a table from a place on are of bodies that slept through the last tick, and stand in their rows as they were written back: since then the
    /// length of a substep may have been another one.
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
            // What is written back of a body is so at once.
            let sleeps = || self.tables.asleep.get(body as usize) == Some(&true);
            if last != Some(body) && !(sleeps() && particles.lag(row) == states[place].lag) {
                break;
            }
            (place, last) = (place + 1, Some(body));
        }
        place - from
    }

    /// How many particles of a table there are from a place on until the next one of a body that slept through the last tick; one at least.
    pub(crate) fn waking_run(&self, rows: &[ParticleRow], from: usize) -> usize {
        let particles = &self.simulation.particles;
        let body = |place: usize| {
            let row = rows[place].get().filter(|&row| row < particles.len());
            row.and_then(|row| particles.body(row))
        };
        let mut last = body(from);
        let mut others = from + 1..rows.len();
        let next = others.find(|&place| {
            let before = core::mem::replace(&mut last, body(place));
            let sleeps = |body: u32| self.tables.asleep.get(body as usize) == Some(&true);
            before != last && last.is_some_and(sleeps)
        });
        next.unwrap_or(rows.len()) - from
    }

    /// Loads the particles of a table from a place on, as long as they stand in consecutive rows and none is at fault. Returns how many.
    pub(crate) fn load(&mut self, states: &[Particle], rows: &[ParticleRow], from: usize) -> usize {
        let run = self.tables.sound_run(&rows[from..]);
        let some = states[from..from + run].iter().map(|&particle| particle.into());
        self.simulation.particles.load(rows[from].0 as usize, some)
    }

    /// Whether all rows are as the last tick left them, and that tick left them as they were; then they need not be gathered while all rest.
    pub(crate) fn is_settled(&self) -> bool {
        let Tables { touched, set_aside, .. } = &self.tables;
        !touched.all && touched.rows.is_empty() && *set_aside == 0 && self.simulation.is_settled()
    }

    /// Takes a tick of `dt` seconds at once in which nothing but the time changes, and notes that there is nothing to scatter or to extract. Whether this was one.
    pub(crate) fn step_at_rest(&mut self, dt: f32) -> bool {
        self.tables.rested = self.tables.deferred && self.simulation.step_at_rest(dt);
        self.tables.rested
    }

    /// Where a body collider is that went through this tick as one rigid state; `None` of any other. Its rotation is the one of two quaternions that is nearer to
    /// where it was turned before.
    pub(crate) fn rigid_pose(&self, collider: u32, before: Quat) -> Option<Pose> {
        let pose = self.tables.stepped.then(|| self.simulation.rigid_pose(collider as usize))??;
        let rotation = if pose.rotation.dot(before) < 0.0 { -pose.rotation } else { pose.rotation };
        Some(Pose { rotation, ..pose })
    }

    /// How a body collider moves that went through this tick as one rigid state; `None` of any other.
    pub(crate) fn rigid_motion(&self, collider: u32) -> Option<Motion> {
        self.tables.stepped.then(|| self.simulation.rigid_motion(collider as usize))?
    }

    /// Whether all of some rows slept through the tick.
    pub(crate) fn slept_through(&self, rows: &[u32]) -> bool {
        self.all_in(&self.tables.asleep, rows)
    }

    /// Whether what was extracted of some rows in the last tick holds.
    pub(crate) fn are_unmoved(&self, rows: &[u32]) -> bool {
        self.all_in(&self.tables.unmoved, rows)
    }
}

/// Gathers what was left out because all of it [rests](SinewWorld::is_settled), where it does not after all.
pub(crate) fn load_deferred(world: &mut World) {
    if world.resource::<SinewWorld>().tables.deferred {
        let ran = world.run_system_cached(load_particles);
        debug_assert!(ran.is_ok(), "the system needs nothing that may be missing");
    }
}

fn load_particles(mut world: ResMut<SinewWorld>, particles: Query<(&Particle, &ParticleRow)>) {
    world.tables.deferred = false;
    for (states, rows) in particles.contiguous_iter().into_iter().flatten() {
        let mut i = 0;
        while i < rows.len() {
            // None of them is set aside, or it would not have been left out.
            i += world.load(states, rows, i).max(1);
        }
    }
}

impl Tables {
    /// Whether an entity is a particle that is set aside.
    pub(crate) fn is_set_aside(&self, entity: Entity) -> bool {
        self.set_aside > 0
            && self.layout.row_of.get(&entity).is_some_and(|&row| !self.is_sound(row as usize))
    }

    /// Whether a row is there, and not set aside.
    pub(crate) fn is_sound(&self, row: usize) -> bool {
        self.refused.get(row).is_some_and(Option::is_none)
    }

    /// How many of some particles stand in consecutive rows from the first one's on, none of them set aside. 0 if the first one is, or has no row.
    pub(crate) fn sound_run(&self, rows: &[ParticleRow]) -> usize {
        let Some(first) = rows.first().and_then(|row| row.get()) else { return 0 };
        let sound = |row: usize| self.set_aside == 0 || self.is_sound(row);
        let mut wanted = (first..self.refused.len()).zip(rows);
        wanted
            .position(|(wanted, row)| row.0 as usize != wanted || !sound(wanted))
            .unwrap_or_else(|| rows.len().min(self.refused.len().saturating_sub(first)))
    }

    /// The row of a particle that takes part, or `None` if it is gone or set aside.
    pub(crate) fn sound_row(&self, entity: Entity) -> Option<u32> {
        let row = *self.layout.row_of.get(&entity)?;
        self.refused[row as usize].is_none().then_some(row)
    }
}
