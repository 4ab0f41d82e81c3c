//! The simulation: particles, forces and constraints, and one method for each phase of a step.

mod lists;
mod loads;
mod prepare;
mod queries;
mod rest;
mod rigid_states;
mod sleep;
mod slide;
mod statics;
mod undisturbed;
mod velocities;
mod weight;

pub use queries::{Filter, Hit};
pub use sleep::Sleep;
pub use slide::{SlideConfig, SlideOutput};
pub use statics::Relaxed;

use core::ops::Range;
use std::sync::Arc;

use glam::{Vec3, Vec4};

use crate::collide::{
    BodyCollider, BodyContacts, Collider, ContactCache, ContactFilter, ContactParticipant,
    Contacts, World,
};
use crate::constraints::{Boundaries, Constraint, Distance, Pin};
use crate::forces::{self, Forces};
use crate::islands::Islands;
use crate::lanes::InstructionSet;
use crate::not_cloned::NotCloned;
use crate::particles::Particles;
use crate::rigid::{Compound, CompoundBodies};
use crate::settings::{BodySettings, SolverSettings};
use crate::solve::{self, Changes, IslandReport, Plan, SolverReport};
use crate::threads::{ExecutionContext, Workers};
use crate::tracked::Tracked;
use crate::{integrate, ledger};

/// A world of particles.
///
/// [`step`](Self::step) takes a whole step. An engine that runs a game's own systems between the phases calls [`begin_step`](Self::begin_step) instead, then
/// for each substep [`begin_substep`](Self::begin_substep) and the phases in their order, then [`end_step`](Self::end_step).
#[derive(Clone, Debug, Default)]
pub struct Simulation {
    /// Configuration of the solver.
    pub settings: SolverSettings,
    /// The particles: live state, to be saved and restored.
    pub particles: Particles,
    /// Gravity, winds, fluids, charges, springs and controls.
    pub forces: Forces,
    /// Planes, boxes and pins that hold particles one by one.
    pub boundaries: Boundaries,
    /// Solver settings of each body, indexed by body. [`Particles::set_body`] assigns particles to bodies.
    pub bodies: Tracked<Vec<BodySettings>>,
    /// Static and kinematic collision shapes. They may change at any step; nothing is compiled from them.
    pub colliders: Vec<Collider>,
    /// How each body takes part in contacts, indexed as `bodies`. A body beyond the end of the list collides by its body colliders, with the default settings;
    /// its other particles touch only colliders.
    pub contacts: Tracked<Vec<BodyContacts>>,
    /// Pairs of a body and another body or a collider that never touch, though no constraint joins them: for instance what is fastened to a kinematic collider.
    /// In any order; pairs of any other kind have no effect.
    pub ignored: Vec<[ContactParticipant; 2]>,
    /// Contact cache: manifolds and friction anchors of body colliders that touch. Live state, to be saved and restored with the particles. During a step the
    /// solver holds it, and this field is not valid.
    pub contact_cache: ContactCache,
    /// Which bodies may sleep, and for how long each has been still, indexed as `bodies`. A body beyond the end of the list never sleeps.
    pub sleep: Tracked<Vec<Sleep>>,
    /// Instruction set of the wide kernels; by default the best that the machine has. It never changes a result.
    pub instructions: InstructionSet,
    /// Threads lent to the step; none by default. They never change a result.
    pub workers: Option<Arc<dyn Workers>>,
    /// Simulated time in seconds at the start of the current substep; gusts of wind depend on it.
    pub time: f64,
    distances: Vec<Distance>,
    constraints: Vec<Constraint>,
    compounds: Vec<Compound>,
    body_colliders: Vec<BodyCollider>,
    scratch: Scratch,
    report: SolverReport,
}

/// Working data of a step that is not part of the saved state.
#[derive(Clone, Debug, Default)]
struct Scratch {
    plan: Plan,
    /// Changes of the lists that are not compiled into the plan yet.
    changes: Changes,
    /// Inputs from which the islands' settings were merged in the last step: the world's settings, the length of a substep in seconds, and the revisions of
    /// `bodies` and of the particles' [edits](Particles::edits). `None` if they depended on more than these.
    settings_inputs: Option<(SolverSettings, f32, u64, u64)>,
    /// Indices of the distances whose strains are measured.
    measured_strains: Vec<usize>,
    substep: Substep,
    electric: forces::ElectricScratch,
    fluids: forces::FluidScratch,
    filter: ContactFilter,
    row_gravity: forces::RowGravity,
    contacts: Contacts,
    solving: solve::SolveScratch,
    loads: solve::Loads,
    damping: solve::Damping,
    /// For measuring the errors left.
    sweep_scratch: solve::SweepScratch,
    lane_particles: Vec<solve::LaneParticles>,
    moving: CompoundBodies,
    sleep_scratch: NotCloned<sleep::SleepScratch>,
    /// Pinned particles that were given another origin for this step.
    anchors: Vec<prepare::PinnedOrigin>,
    /// Pressure of each wind on each triangle, sampled when the step began.
    pressures: forces::Pressures,
    /// The triangles under wind pressure, packed for the wide kernels.
    surfaces: forces::PackedSurfaces,
    /// The air at each triangle and loose particle, sampled when the step began.
    air: forces::Air,
    /// Positions and inverse masses when the step began, for rows that turn non-finite.
    checkpoint: Vec<Vec4>,
    /// Velocities when the step began, m/s, and their lags, seconds; only in a step of one substep, otherwise empty.
    first_velocity: Vec<Vec4>,
    /// Length of the last step, seconds.
    length: f32,
    /// Rows that are integrated as particles in this step: those that neither sleep nor follow a rigid state.
    single_rows: Vec<integrate::StepRows>,
    /// Rows that follow a rigid state or sleep, or take microsteps: what `single_rows` is cut by.
    rows_apart: Vec<integrate::StepRows>,
    /// Ranges of rows to check at the end of the step: all but those of sleeping islands whose rows are consecutive.
    awake_rows: Vec<Range<usize>>,
    /// Whether nothing but the crate's own forces reads particles until the step ends. Particles of rigid states without forces on single particles then need
    /// to be written only at the end.
    unobserved: bool,
    /// Triangles to which wind pressure is applied corner by corner: those that are not part of a rigid state.
    particle_surfaces: Vec<Range<usize>>,
    /// Whether nothing moves in this step.
    at_rest: bool,
    rest: NotCloned<rest::Rest>,
}

/// Position within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Substep {
    /// Length of a substep, seconds.
    pub length: f32,
    /// Substeps left, the current one included.
    pub remaining: u32,
}

/// Why a step was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a step of {0} s cannot be taken: it must be positive and finite, and not too short to halve"
)]
pub struct StepFault(pub f32);

impl Simulation {
    /// Advances by `dt` seconds and reports how it went.
    ///
    /// # Errors
    /// A `dt` that is not positive and finite, or so short that 1/h² overflows for a substep `h`, is refused and nothing changes.
    pub fn step(&mut self, dt: f32) -> Result<&SolverReport, StepFault> {
        if self.step_at_rest(dt) {
            return Ok(&self.report);
        }
        let substeps = self.begin_step(dt)?;
        self.take_substeps();
        for _ in 0..self.scratch.substep.remaining.min(substeps) {
            self.begin_substep();
            self.accumulate_forces();
            self.apply_wind();
            self.apply_buoyancy();
            self.apply_electric();
            self.integrate();
            self.solve_constraints();
        }
        self.end_step();
        Ok(&self.report)
    }

    /// Begins a step of `dt` seconds: updates the plan if constraints changed, runs the broad phase, and returns the number of substeps to take.
    ///
    /// # Errors
    /// A `dt` that is not positive and finite, or so short that 1/h² overflows for a substep `h`, is refused and nothing changes.
    pub fn begin_step(&mut self, dt: f32) -> Result<u32, StepFault> {
        // Reports of the last step do not apply to this one, whether it is taken or refused.
        self.report.frozen.clear();
        self.report.too_fast.clear();
        let settings = self.settings.clamped();
        let h = dt / settings.substeps as f32;
        // 1/h² must be finite: compliances are scaled by it.
        if !(dt.is_finite() && h > 0.0 && (1.0 / (h * h)).is_finite()) {
            return Err(StepFault(dt));
        }
        self.compile();
        self.particles.revalidate();
        self.scratch.substep = Substep { length: h, remaining: settings.substeps };
        self.share_origins();
        self.find_loads();
        self.merge_settings(settings);
        self.set_checkpoint();
        self.scratch.length = dt;
        self.scratch.first_velocity.clear();
        if settings.substeps == 1 {
            self.scratch.first_velocity.extend_from_slice(&self.particles.velocity);
        }
        self.put_to_sleep(dt);
        self.scratch.at_rest = self.is_at_rest();
        self.scratch.plan.islands.find_singles();
        let connected = (&self.scratch.plan.islands, &self.forces.springs[..]);
        self.scratch.damping.apply(&mut self.particles, &self.bodies, connected, dt);
        self.scratch.moving.read(&self.particles, &self.compounds);
        self.begin_contacts();
        self.begin_rigid_states();
        self.sample_winds();
        self.note_forces();
        self.pack_surfaces();
        self.report.substeps = settings.substeps;
        self.report.sweeps = 0;
        self.report.most_sweeps = 0;
        self.report.converged = true;
        let islands = &self.scratch.plan.islands.list;
        // What sleeps has not moved since it was measured, provided that was with the same plan.
        for (own, island) in self.report.islands.iter_mut().zip(islands) {
            let IslandReport { error, strain, .. } = *own;
            *own = IslandReport::default();
            if island.asleep {
                *own = IslandReport { error, strain, measured: true, ..*own };
            }
        }
        self.report.islands.resize(islands.len(), IslandReport::default());
        Ok(settings.substeps)
    }

    /// Where in the step the simulation is: the length of a substep and how many are left.
    pub fn substep(&self) -> Substep {
        self.scratch.substep
    }

    /// Begins a substep: clears the sums of forces and of damping. From here to `integrate`, forces add up in any order.
    pub fn begin_substep(&mut self) {
        forces::reset(&mut self.particles, &self.forces);
    }

    /// Phase 1: adds gravity, the game's own forces, controls and springs.
    pub fn accumulate_forces(&mut self) {
        forces::apply_gravity_and_external(&mut self.particles, &self.forces, self.instructions);
        forces::apply_controls(&mut self.particles, &self.forces.controls);
        forces::apply_springs(&mut self.particles, &self.forces.springs, self.instructions);
    }

    /// Phase 2: adds the pressure of the winds on the surfaces, and the drag and the lift of the air.
    pub fn apply_wind(&mut self) {
        let Self { particles, instructions, scratch, .. } = self;
        let Scratch { surfaces, pressures, air, substep, unobserved, .. } = scratch;
        // In the last substep all, because accelerations are read between steps.
        let only_particles = *unobserved && substep.remaining > 1;
        forces::apply_wind(particles, surfaces, pressures, only_particles, *instructions);
        forces::apply_air(particles, surfaces, air, substep.length, *instructions);
    }

    /// Phase 3: adds the buoyancy and the drag of the fluids.
    pub fn apply_buoyancy(&mut self) {
        let scratch = &mut self.scratch.fluids;
        forces::apply_fluids(&mut self.particles, &self.forces, scratch);
    }

    /// Phase 4: adds the forces between charges, and those of electric fields.
    pub fn apply_electric(&mut self) {
        if self.particles.column_summary.neutral {
            return;
        }
        let scratch = &mut self.scratch.electric;
        forces::apply_electric(&mut self.particles, &self.forces, scratch, self.instructions);
    }

    /// Phase 5: predicts the next positions with the world's integrator, after the drag of planes, and moves pinned particles towards their targets.
    pub fn integrate(&mut self) {
        let Substep { length, remaining } = self.scratch.substep;
        if self.settings.statics {
            self.particles.velocity.fill(Vec4::ZERO);
            self.scratch.moving.stop();
        }
        self.release_moved();
        self.scratch.contacts.particle_contacts.drag(&mut self.particles, length);
        self.predict_rigid_states();
        let execution = execution(self.instructions, &self.workers);
        let (integrator, rows) = (self.settings.integrator, &self.scratch.single_rows);
        integrate::predict(&mut self.particles, integrator, length, rows, execution);
        self.write_rigid_states(false);
        self.scratch.moving.predict(&mut self.particles, &self.compounds, length);
        for pin in &self.boundaries.pins {
            let i = pin.particle as usize;
            if i < self.particles.len() && pin.target.is_finite() {
                // Relative to the particle's origin: far out, world coordinates are too coarse for a path in small parts.
                let pin = Pin { target: pin.target - self.particles.origin[i], ..*pin };
                let here = self.particles.position[i];
                self.particles.position[i] =
                    pin.step_towards_target(here.truncate(), remaining).extend(here.w);
            }
        }
    }

    /// Phase 6: enforces constraints and contacts, derives the velocities from the corrected positions, and ends the substep.
    pub fn solve_constraints(&mut self) {
        self.release_moved();
        let parameters = self.substep_parameters();
        let solve::SubstepParameters { h, gravity, number: substep, of: substeps, .. } = parameters;
        let Self { particles, settings, instructions, workers, scratch, report, .. } = self;
        let steps = (h, substeps, scratch.at_rest);
        let Scratch {
            plan,
            filter,
            row_gravity,
            contacts,
            solving,
            loads,
            single_rows,
            sweep_scratch,
            ..
        } = scratch;
        let execution = execution(*instructions, workers);
        let open = contacts.is_active().then_some(&single_rows[..]);
        let Contacts { particle_contacts, normal_impulses, .. } = contacts;
        let context = solve::SolveContext::new(plan, particle_contacts, parameters, execution);
        let with = (&mut *solving, &mut *loads);
        solve::solve_all(particles, normal_impulses, context, open, with, report);
        if open.is_some() {
            let given = (&self.boundaries, &self.colliders[..], &self.body_colliders[..]);
            let among = (&*filter, &plan.islands);
            let pull = (self.forces.gravity, &*row_gravity);
            let world = contact_world(given, among, pull, steps);
            let mut cloth = solving.pressed_cloth(plan, parameters, execution);
            contacts.project(particles, &world, (h, substep), &mut cloth, execution);
            plan.islands.mark_pressed(contacts.body_contact.pressed_rows());
            let Contacts { particle_contacts, normal_impulses, body_contact, .. } = contacts;
            let context = solve::SolveContext::new(plan, particle_contacts, parameters, execution);
            let stopped = body_contact.stopped();
            solve::propagate_impacts(particles, normal_impulses, context, stopped, solving, report);
            solve::derive_all(particles, normal_impulses, context, single_rows, solving);
            contacts.bounce(particles, h, row_gravity);
        }
        let reports = &mut report.islands;
        let scratch = (sweep_scratch, loads);
        solve::limit_all_recoveries(particles, plan, (h, gravity), reports, scratch);
        integrate::finish(particles, settings.integrator, h);
        self.write_rigid_states(true);
        self.scratch.moving.end_substep(&mut self.particles, &self.compounds, h);
        self.time += f64::from(h);
        self.scratch.substep.remaining = self.scratch.substep.remaining.saturating_sub(1);
    }

    /// Parameters of the current substep.
    fn substep_parameters(&self) -> solve::SubstepParameters {
        let Substep { length: h, remaining } = self.scratch.substep;
        let (lag, gravity) = (self.settings.integrator.lag(h), self.forces.gravity.length());
        let of = self.report.substeps;
        solve::SubstepParameters { h, lag, gravity, number: of.saturating_sub(remaining), of }
    }

    /// Ends a step: resets rows that turned non-finite to where the step began, at rest, limits speeds, and measures the errors left.
    pub fn end_step(&mut self) {
        if core::mem::take(&mut self.scratch.unobserved) {
            self.write_all_rigid_states();
        }
        self.wake();
        self.scratch.loads.end(&self.scratch.plan);
        self.particles.record_edits(false);
        let len = self.particles.len();
        let awake = |rows: &Range<usize>| rows.start.min(len)..rows.end.min(len);
        for mut among in self.scratch.awake_rows.iter().map(awake) {
            while let Some(rows) = self.particles.next_broken(among.clone()) {
                among.start = rows.end;
                for i in rows {
                    if self.particles.is_finite(i) {
                        continue;
                    }
                    let good = self.scratch.checkpoint.get(i).copied().unwrap_or_default();
                    self.particles.position[i] = good;
                    self.particles.start[i] = good;
                    self.particles.set_velocity(i, Vec3::ZERO);
                    self.report.frozen.push(i as u32);
                }
            }
        }
        self.scratch.contacts.particle_contacts.take_off_recovery(&mut self.particles);
        let most = self.settings.clamped().max_speed;
        if most < f32::INFINITY {
            for rows in self.scratch.awake_rows.iter().map(awake) {
                self.particles.limit_speeds(rows, most, &mut self.report.too_fast);
            }
        }
        let Scratch { plan, contacts, sweep_scratch, lane_particles, .. } = &mut self.scratch;
        let (instructions, report) = (self.instructions, &mut self.report);
        solve::measure(
            &mut self.particles,
            &contacts.particle_contacts,
            plan,
            instructions,
            (sweep_scratch, lane_particles),
            report,
        );
        solve::measure_overlaps(contacts.overlaps(), &plan.islands, report);
        contacts.keep(&mut self.contact_cache);
        let impacts = contacts.report(&self.particles);
        report.impacts.clear();
        report.impacts.extend_from_slice(impacts);
        self.restore_anchors();
        self.record_rest();
    }

    /// Where particle `i` was when the last step began, metres: for interpolation between two steps.
    #[inline]
    pub fn step_start(&self, i: usize) -> Vec3 {
        let began = self.scratch.checkpoint.get(i);
        began
            .map_or_else(|| self.particles.position(i), |q| self.particles.origin[i] + q.truncate())
    }

    /// Discards the positions at the start of the last step. To be called when rows now hold other particles.
    pub fn forget_step_start(&mut self) {
        self.scratch.checkpoint.clear();
        self.scratch.first_velocity.clear();
    }

    /// How the last step went.
    pub fn report(&self) -> &SolverReport {
        &self.report
    }

    /// Report of the last step on the island of particle `i`: of all particles that constraints connect with it.
    pub fn island_report(&self, i: usize) -> Option<&IslandReport> {
        self.report.islands.get(self.island_of(i)? as usize)
    }

    /// The index of the island of particle `i` in the last step, in [`SolverReport::islands`].
    pub fn island_of(&self, i: usize) -> Option<u32> {
        self.scratch.plan.islands.of.get(i).copied()
    }

    /// Mass of the island of particle `i`, kg, without pinned particles. Zero before the first step.
    pub fn island_mass(&self, i: usize) -> f32 {
        let plan = &self.scratch.plan;
        let island =
            plan.islands.of.get(i).and_then(|&number| plan.islands.list.get(number as usize));
        let members =
            island.map_or(&[][..], |island| &plan.islands.members[island.members.clone()]);
        let masses = members.iter().filter_map(|&row| {
            let w = self.particles.position.get(row as usize)?.w;
            (w > 0.0).then(|| 1.0 / f64::from(w))
        });
        masses.sum::<f64>() as f32
    }

    /// The largest number of constraint groups in an island: a group holds constraints of one kind and one colour, which share no particle.
    pub fn colours(&self) -> usize {
        self.scratch.plan.islands.list.iter().map(|island| island.groups.len()).max().unwrap_or(0)
    }

    /// The distances of the plan, each with the index of its group in its island: those of one group share no particle, and are solved side by side.
    pub fn grouped_distances(&self) -> impl Iterator<Item = (usize, &Distance)> {
        let plan = &self.scratch.plan;
        plan.islands.list.iter().flat_map(|island| {
            let groups = plan.groups.get(island.groups.clone()).unwrap_or_default();
            let own = groups.iter().enumerate().filter(|(_, group)| group.has_distances());
            own.flat_map(|(number, group)| {
                let distances = plan.distances.get(group.range.clone()).unwrap_or_default();
                distances.iter().map(move |distance| (number, distance))
            })
        })
    }

    /// Number of islands: sets of particles that constraints connect; a loose particle is an island by itself.
    pub fn islands(&self) -> usize {
        self.scratch.plan.islands.list.len()
    }

    /// The plan of the last step.
    #[cfg(test)]
    pub(crate) fn plan(&self) -> &solve::Plan {
        &self.scratch.plan
    }

    /// Particle contacts of the last step.
    #[cfg(test)]
    pub(crate) fn particle_contacts(&self) -> &crate::collide::ParticleContacts {
        &self.scratch.contacts.particle_contacts
    }

    /// Energy that soft distances and constraints store, J.
    pub(crate) fn soft_energy(&mut self) -> f64 {
        solve::soft_energy(&mut self.particles, &self.scratch.plan)
    }

    /// Energy and momentum of the whole world. It sums the forces at the present positions first.
    pub fn ledger(&mut self) -> ledger::Ledger {
        self.compile();
        self.share_origins();
        self.sample_winds();
        self.pack_surfaces();
        self.begin_substep();
        self.accumulate_forces();
        self.apply_wind();
        self.apply_buoyancy();
        self.apply_electric();
        let soft = self.soft_energy();
        let ledger = ledger::sum(&self.particles, &self.forces, soft);
        self.restore_anchors();
        ledger
    }
}

/// Instruction set and workers for a phase.
fn execution(
    instructions: InstructionSet,
    workers: &Option<Arc<dyn Workers>>,
) -> ExecutionContext<'_> {
    ExecutionContext { instructions, workers: workers.as_deref() }
}

/// Everything that contacts depend on: shapes and boundaries; filter and islands; gravity, m/s²; length of a substep, seconds, number of substeps, and whether
/// nothing moves in the step.
fn contact_world<'a>(
    given: (&'a Boundaries, &'a [Collider], &'a [BodyCollider]),
    (filter, islands): (&'a ContactFilter, &'a Islands),
    (gravity, row_gravity): (Vec3, &'a forces::RowGravity),
    (h, substeps, at_rest): (f32, u32, bool),
) -> World<'a> {
    let (boundaries, colliders, body_colliders) = given;
    let dt = h * substeps as f32;
    World {
        boundaries,
        colliders,
        body_colliders,
        filter,
        islands,
        dt,
        substeps,
        gravity,
        row_gravity,
        at_rest,
    }
}
