//! Rigid states: islands that move as one rigid body in a step. When they are read from particles, predicted, and written back.

use super::velocities::carried;
use super::{Scratch, Simulation, Substep};
use crate::collide::{RigidStep, Written};
use crate::integrate::StepRows;
use crate::pose::{Motion, Pose};
use crate::solve::SubstepParameters;

impl Simulation {
    /// Reads the rigid states of this step from their particles.
    pub(super) fn begin_rigid_states(&mut self) {
        let Self { particles, bodies, boundaries, scratch, .. } = self;
        let Scratch { plan, contacts, substep: Substep { length: h, .. }, .. } = scratch;
        let step = RigidStep { bodies, pins: &boundaries.pins, h: *h };
        contacts.begin_rigid_states(particles, &mut plan.islands, step);
        self.scratch.unobserved = false;
        self.list_single_rows();
    }

    /// Lists the rows to integrate as particles, those to except from that, and those that are not asleep.
    fn list_single_rows(&mut self) {
        let Scratch { plan, single_rows, rows_apart, awake_rows, .. } = &mut self.scratch;
        let (mut next, last) = (0, self.particles.len());
        awake_rows.clear();
        for island in plan.islands.list.iter().filter(|island| island.asleep) {
            if let Some(rows) = plan.stretch(island) {
                if next < rows.start {
                    awake_rows.push(next..rows.start);
                }
                next = rows.end;
            }
        }
        if next < last {
            awake_rows.push(next..last);
        }
        rows_apart.clear();
        for island in &plan.islands.list {
            if island.is_skipped() {
                let rows = plan.stretch(island);
                rows_apart.extend(rows.map(|rows| StepRows { rows, microsteps: 0 }));
            } else if island.takes_microsteps() {
                rows_apart.extend(plan.step_rows(island));
            }
        }
        rows_apart.sort_unstable_by_key(|own| own.rows.start);
        single_rows.clear();
        let mut rows_apart = rows_apart.iter().cloned().peekable();
        StepRows::split(0..last, &mut rows_apart, |own| single_rows.push(own));
    }

    /// Turns rigid states whose particles were moved from outside back into particles for the rest of the step.
    pub(super) fn release_moved(&mut self) {
        let Self { particles, scratch: Scratch { plan, contacts, .. }, .. } = self;
        if contacts.has_rigid_states()
            && contacts.rigid_states().release_moved(particles, &mut plan.islands)
        {
            self.list_single_rows();
        }
    }

    /// Predicts the rigid states, before the particles.
    pub(super) fn predict_rigid_states(&mut self) {
        let which = self.which_substep();
        let Self { particles, scratch, .. } = self;
        let Scratch { plan, contacts, pressures, substep: Substep { length: h, .. }, .. } = scratch;
        if contacts.has_rigid_states() {
            let states = contacts.rigid_states();
            states.predict_rigid_states(particles, &plan.islands, pressures, *h, which);
        }
    }

    /// Takes the rigid states through all remaining substeps. Returns false, with everything as before, if one of them may have touched something.
    pub(super) fn advance_idle_states(&mut self) -> bool {
        let which = self.which_substep();
        let Self { particles, scratch: Scratch { contacts, substep, .. }, .. } = self;
        if contacts.has_rigid_states() {
            contacts.rigid_states().advance_idle_states(particles, substep.length, which);
            if !contacts.rigid_states().is_idle() {
                // No particle has been written yet, so the states can be read again.
                let unobserved = self.scratch.unobserved;
                self.begin_rigid_states();
                self.scratch.contacts.rigid_states().set_not_idle();
                self.scratch.unobserved = unobserved;
                return false;
            }
        }
        true
    }

    /// Notes which forces act on the rigid states in this step, and which triangles belong to none of them.
    pub(super) fn note_forces(&mut self) {
        let Self { particles, forces, body_colliders, scratch, .. } = self;
        let Scratch { plan, contacts, pressures, particle_surfaces, .. } = scratch;
        particle_surfaces.clear();
        if !contacts.has_rigid_states() {
            particle_surfaces.push(0..forces.surfaces.len());
            return;
        }
        let named = forces.rows();
        let any = named.is_none();
        let charges = if particles.column_summary.neutral { &[][..] } else { &particles.charge };
        let charged = charges.iter().enumerate().filter(|(_, charge)| **charge != 0.0);
        let rows = particles.column_summary.nonuniform.iter().copied();
        let rows = rows.chain(named.into_iter().flatten());
        let rows = rows.chain(charged.map(|(row, _)| row as u32));
        let states = contacts.rigid_states();
        if !pressures.is_empty() {
            states.find_skins(&forces.surfaces, body_colliders);
        }
        states.note_forces(&plan.islands, (any, rows), pressures, particle_surfaces);
    }

    /// Writes the particles of those rigid states whose particles are read within the step: after prediction, and at the end of a substep (`ends`).
    pub(super) fn write_rigid_states(&mut self, ends: bool) {
        let Self { particles, scratch: Scratch { contacts, unobserved, substep, .. }, .. } = self;
        if !contacts.has_rigid_states() {
            return;
        }
        let which = match (*unobserved, ends, substep.remaining) {
            (false, ..) => Written::All,
            // Their positions are needed when the wind in the last substep is summed.
            (true, true, 2) => Written::ForcedAndWindy,
            (true, ..) => Written::Forced,
        };
        let exact = ends && substep.remaining <= 1;
        contacts.rigid_states().write_rigid_states(particles, which, exact);
    }

    /// Writes the particles of all rigid states when the step ends.
    pub(super) fn write_all_rigid_states(&mut self) {
        let Self { particles, scratch: Scratch { contacts, .. }, .. } = self;
        if contacts.has_rigid_states() {
            contacts.rigid_states().write_rigid_states(particles, Written::All, true);
        }
    }

    /// Pose of a [body collider](Self::body_colliders), given by its index, that went through the last step as one rigid state; in the collider's own frame. It
    /// is stored, and equals a fit to the particles up to round-off. `None` for any other collider, and where the pose is not finite.
    ///
    /// It is the pose at the end of the last step: particles that were moved since do not change it.
    pub fn rigid_pose(&self, number: usize) -> Option<Pose> {
        let first = *self.body_colliders.get(number)?.rows.first()? as usize;
        let pose = self.scratch.contacts.body_contact.rigid_pose(number)?;
        let translation = self.particles.origin.get(first)? + pose.translation;
        let is_finite = translation.is_finite() && pose.rotation.is_finite();
        is_finite.then_some(Pose { translation, ..pose })
    }

    /// Motion of a [body collider](Self::body_colliders), given by its index, that went through the last step as one rigid state. It is stored, and equals
    /// [`motion`](crate::pose::motion) of its particles and their [velocities](Self::velocity_now) up to round-off. `None` for any other collider, where forces
    /// act on its particles one by one, and where the motion is not finite.
    ///
    /// It is the motion at the end of the last step: particles that were moved since do not change it.
    pub fn rigid_motion(&self, number: usize) -> Option<Motion> {
        let first = *self.body_colliders.get(number)?.rows.first()? as usize;
        let changed = [&self.report.frozen, &self.report.too_fast];
        let is_changed = || {
            let rows = &self.body_colliders[number].rows;
            changed.iter().any(|all| all.iter().any(|row| rows.contains(row)))
        };
        let bodies = &self.scratch.contacts.body_contact;
        let found = bodies.rigid_motion(number)?;
        if bodies.is_forced(number) || !self.scratch.first_velocity.is_empty() || is_changed() {
            return None;
        }
        let (a, length) = (self.particles.acceleration(first), self.scratch.length);
        let mean = (found.velocity - found.gone / length) / (0.5 * (length - found.lag));
        let motion = Motion {
            mass: found.mass,
            barycentre: self.particles.origin.get(first)? + found.centre,
            velocity: carried(found.velocity, found.lag, a, Some(mean).filter(|a| a.is_finite())),
            angular_velocity: found.angular_velocity,
            inertia: found.inertia,
        };
        let sum = motion.barycentre + motion.velocity + motion.angular_velocity;
        (sum.is_finite() && motion.mass.is_finite() && motion.inertia.is_finite()).then_some(motion)
    }

    /// The index of the current substep, and the number of substeps of the step.
    fn which_substep(&self) -> (u32, u32) {
        let SubstepParameters { number, of, .. } = self.substep_parameters();
        (number, of)
    }
}
