//! Islands that move as one rigid state: when they are read, moved and written.

use super::velocities::carried;
use super::{Scratch, Simulation, Substep};
use crate::collide::{RigidStep, Written};
use crate::integrate::StepRows;
use crate::pose::{Motion, Pose};
use crate::solve::SubstepParameters;

impl Simulation {
    /// Reads those of this step.
    pub(super) fn begin_rigid_states(&mut self) {
        let Self { particles, bodies, boundaries, scratch, .. } = self;
        let Scratch { plan, contacts, substep: Substep { length: h, .. }, .. } = scratch;
        let step = RigidStep { bodies, pins: &boundaries.pins, h: *h };
        contacts.begin_rigid_states(particles, &mut plan.islands, step);
        self.scratch.unseen = false;
        self.list_single_rows();
    }

    /// Lists the rows that do not follow from rigid states and do not sleep, and those that do not sleep.
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
            if island.is_left_alone() {
                let rows = plan.stretch(island);
                rows_apart.extend(rows.map(|rows| StepRows { rows, microsteps: 0 }));
            } else if island.takes_microsteps() {
                rows_apart.extend(plan.step_rows(island));
            }
        }
        rows_apart.sort_unstable_by_key(|own| own.rows.start);
        single_rows.clear();
        let mut rows_apart = rows_apart.iter().cloned().peekable();
        StepRows::cut(0..last, &mut rows_apart, |own| single_rows.push(own));
    }

    /// Has those go on as particles that somebody else has moved.
    pub(super) fn release_moved(&mut self) {
        let Self { particles, scratch: Scratch { plan, contacts, .. }, .. } = self;
        if contacts.has_rigid_states()
            && contacts.rigid_states().release_moved(particles, &mut plan.islands)
        {
            self.list_single_rows();
        }
    }

    /// Predicts them, before their particles are.
    pub(super) fn predict_rigid_states(&mut self) {
        let which = self.which_substep();
        let Self { particles, scratch, .. } = self;
        let Scratch { plan, contacts, pressures, substep: Substep { length: h, .. }, .. } = scratch;
        if contacts.has_rigid_states() {
            let states = contacts.rigid_states();
            states.predict_rigid_states(particles, &plan.islands, pressures, *h, which);
        }
    }

    /// Takes them through all substeps that remain, and says whether that went well: that nothing can have touched them.
    pub(super) fn advance_idle_states(&mut self) -> bool {
        let which = self.which_substep();
        let Self { particles, scratch: Scratch { contacts, substep, .. }, .. } = self;
        if contacts.has_rigid_states() {
            contacts.rigid_states().advance_idle_states(particles, substep.length, which);
            if !contacts.rigid_states().is_idle() {
                // No particle has been written yet: they are what they were.
                let unseen = self.scratch.unseen;
                self.begin_rigid_states();
                self.scratch.contacts.rigid_states().set_not_idle();
                self.scratch.unseen = unseen;
                return false;
            }
        }
        true
    }

    /// Notes what acts on them in this step, and which triangles are of others.
    pub(super) fn note_forces(&mut self) {
        let Self { particles, forces, body_colliders, scratch, .. } = self;
        let Scratch { plan, contacts, pressures, separate_surfaces, .. } = scratch;
        separate_surfaces.clear();
        if !contacts.has_rigid_states() {
            separate_surfaces.push(0..forces.surfaces.len());
            return;
        }
        let named = forces.rows();
        let any = named.is_none();
        let charges = if particles.column_summary.neutral { &[][..] } else { &particles.charge };
        let charged = charges.iter().enumerate().filter(|(_, charge)| **charge != 0.0);
        let rows = particles.column_summary.singular.iter().copied();
        let rows = rows.chain(named.into_iter().flatten());
        let rows = rows.chain(charged.map(|(row, _)| row as u32));
        let states = contacts.rigid_states();
        if !pressures.is_empty() {
            states.find_skins(&forces.surfaces, body_colliders);
        }
        states.note_forces(&plan.islands, (any, rows), pressures, separate_surfaces);
    }

    /// Writes the particles of those that somebody looks at within the step: when they have been predicted, and when a substep `ends`.
    pub(super) fn write_rigid_states(&mut self, ends: bool) {
        let Self { particles, scratch: Scratch { contacts, unseen, substep, .. }, .. } = self;
        if !contacts.has_rigid_states() {
            return;
        }
        let which = match (*unseen, ends, substep.remaining) {
            (false, ..) => Written::All,
            // They are to be where they are when the wind in the last substep is summed up.
            (true, true, 2) => Written::ForcedAndWindy,
            (true, ..) => Written::Forced,
        };
        let exact = ends && substep.remaining <= 1;
        contacts.rigid_states().write_rigid_states(particles, which, exact);
    }

    /// Writes all of their particles when the step ends.
    pub(super) fn write_all_rigid_states(&mut self) {
        let Self { particles, scratch: Scratch { contacts, .. }, .. } = self;
        if contacts.has_rigid_states() {
            contacts.rigid_states().write_rigid_states(particles, Written::All, true);
        }
    }

    /// The pose of a [body collider](Self::body_colliders) that went through the last step as one rigid state, in its own frame, by its number in the list:
    /// what a fit to its particles gives but for round-off, at hand. `None` of any other, and where that is not finite.
    ///
    /// Of the last step: not of particles that were moved since.
    pub fn rigid_pose(&self, number: usize) -> Option<Pose> {
        let first = *self.body_colliders.get(number)?.rows.first()? as usize;
        let pose = self.scratch.contacts.body_contact.rigid_pose(number)?;
        let translation = self.particles.origin.get(first)? + pose.translation;
        let is_finite = translation.is_finite() && pose.rotation.is_finite();
        is_finite.then_some(Pose { translation, ..pose })
    }

    /// How a [body collider](Self::body_colliders) moves that went through the last step as one rigid state, by its number in the list: what
    /// [`motion`](crate::pose::motion) of its particles and their [velocities](Self::velocity_now) gives but for round-off, at hand. `None` of any other, where
    /// forces act on its particles one by one, and where that is not finite.
    ///
    /// Of the last step: not of particles that were moved since.
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

    /// The number of the substep at hand, and how many there are in the step.
    fn which_substep(&self) -> (u32, u32) {
        let SubstepParameters { number, of, .. } = self.substep_parameters();
        (number, of)
    }
}
