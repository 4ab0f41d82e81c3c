//! Steps in which no external force but gravity acts run all substeps at once; steps in which nothing moves run only the last substep.

use glam::{Vec3, Vec4};

use super::{Scratch, Simulation, Substep, execution};
use crate::collide::Contacts;
use crate::constraints::PlanarDrag;
use crate::forces::Forces;
use crate::integrate::Integrator;
use crate::solve;

impl Simulation {
    /// Whether the phases before integration do the same to all particles in every substep of this step. If they do, and nothing of the caller's acts between
    /// the phases, [`take_substeps`](Self::take_substeps) may be called once, between `begin_step` and `end_step`, instead of the phases.
    pub fn is_undisturbed(&self) -> bool {
        let Self { boundaries, settings, .. } = self;
        self.has_constant_forces()
            && self.scratch.loads.is_empty()
            && !self.scratch.contacts.is_active()
            && settings.integrator == Integrator::Verlet
            && !settings.statics
            && self.compounds.is_empty()
            && boundaries.pins.is_empty()
            && boundaries.planes.iter().all(|plane| plane.drag == PlanarDrag::default())
    }

    /// Whether the forces on all particles are the same in every substep, wherever the particles are.
    fn has_constant_forces(&self) -> bool {
        let Forces { surfaces, winds, .. } = &self.forces;
        // Winds act only on surfaces.
        let is_calm = winds.is_empty() || surfaces.is_empty();
        let quiet = is_calm && self.forces.rows().is_some_and(|mut rows| rows.next().is_none());
        let summary = &self.particles.column_summary;
        quiet && summary.nonuniform.is_empty() && summary.neutral
    }

    /// Whether nothing moves in this step: all islands sleep or are single pinned particles at rest, and the geometry around them is static. Then each substep
    /// has the same input and the same result as the one before.
    pub(super) fn is_at_rest(&self) -> bool {
        let Self { particles, boundaries, colliders, compounds, settings, scratch, .. } = self;
        let islands = &scratch.plan.islands.list;
        // Sleeping particles count as pinned.
        let stays = |(position, velocity): (&Vec4, &Vec4)| {
            position.w == 0.0 && velocity.truncate() == Vec3::ZERO
        };
        islands.iter().any(|island| island.asleep)
            && islands.iter().all(|island| island.asleep || island.members.len() == 1)
            && !settings.statics
            && compounds.is_empty()
            && colliders.iter().all(|collider| collider.start == collider.end)
            && boundaries.pins.iter().all(|pin| {
                let i = pin.particle as usize;
                i >= particles.len() || particles.relative_to(i, pin.target) == Vec3::ZERO
            })
            && particles.position.iter().zip(&particles.velocity).all(stays)
    }

    /// Advances the time by all substeps but the last, one by one, so that it has the same bits as otherwise.
    fn pass_to_last_substep(&mut self) {
        let Substep { length, remaining } = &mut self.scratch.substep;
        while *remaining > 1 {
            self.time += f64::from(*length);
            *remaining -= 1;
        }
    }

    /// Runs all remaining substeps at once, with the same bits as phase by phase, if the step is [undisturbed](Self::is_undisturbed). Otherwise the caller must
    /// run the phases afterwards, and nothing but these phases may read particles until the step ends.
    pub fn take_substeps(&mut self) {
        self.scratch.unobserved = true;
        if self.scratch.at_rest {
            self.pass_to_last_substep();
        }
        if !self.is_undisturbed() {
            return;
        }
        self.begin_substep();
        self.accumulate_forces();
        if !self.advance_idle_states() {
            return;
        }
        let (parameters, remaining) = (self.substep_parameters(), self.scratch.substep.remaining);
        let Self { particles, instructions, workers, scratch, report, .. } = self;
        let Scratch {
            plan,
            contacts: Contacts { particle_contacts, normal_impulses, .. },
            solving,
            ..
        } = scratch;
        let execution = execution(*instructions, workers);
        let context = solve::SolveContext::new(plan, particle_contacts, parameters, execution);
        solve::advance_all(particles, normal_impulses, context, remaining, solving, report);
        let h = parameters.h;
        (0..remaining).for_each(|_| self.time += f64::from(h));
        self.scratch.substep.remaining = 0;
    }
}
