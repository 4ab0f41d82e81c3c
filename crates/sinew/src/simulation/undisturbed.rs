//! Steps in which nothing from outside but gravity acts: all substeps at once. And steps in which nothing moves: the last substep alone.

use glam::{Vec3, Vec4};

use super::{Scratch, Simulation, Substep, execution};
use crate::collide::Contacts;
use crate::constraints::PlanarDrag;
use crate::forces::Forces;
use crate::integrate::Integrator;
use crate::solve;

impl Simulation {
    /// Whether the phases before integration do the same to all particles in every substep of this step, and nobody else works in between: then
    /// [`take_substeps`](Self::take_substeps) may be called once, between `begin_step` and `end_step`, instead of the phases.
    pub fn is_undisturbed(&self) -> bool {
        let Self { boundaries, settings, .. } = self;
        self.is_quiet()
            && self.scratch.loads.is_empty()
            && !self.scratch.contacts.is_active()
            && settings.integrator == Integrator::Verlet
            && !settings.statics
            && self.compounds.is_empty()
            && boundaries.pins.is_empty()
            && boundaries.planes.iter().all(|plane| plane.drag == PlanarDrag::default())
    }

    /// Whether the forces of all substeps are the same on all particles, wherever those are.
    fn is_quiet(&self) -> bool {
        let Forces { surfaces, winds, .. } = &self.forces;
        // Winds press on surfaces alone.
        let is_calm = winds.is_empty() || surfaces.is_empty();
        let quiet = is_calm && self.forces.rows().is_some_and(|mut rows| rows.next().is_none());
        let summary = &self.particles.column_summary;
        quiet && summary.singular.is_empty() && summary.neutral
    }

    /// Whether nothing moves in this step: all sleep, or are single particles that are pinned and stay, and what stands around them goes nowhere. Then each
    /// substep finds what the one before has found, and leaves it.
    pub(super) fn is_at_rest(&self) -> bool {
        let Self { particles, boundaries, colliders, compounds, settings, scratch, .. } = self;
        let islands = &scratch.plan.islands.list;
        // What sleeps counts as pinned.
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

    /// Lets the time pass of all substeps but the last, sum by sum, so that it comes out the same.
    fn pass_to_last_substep(&mut self) {
        let Substep { length, remaining } = &mut self.scratch.substep;
        while *remaining > 1 {
            self.time += f64::from(*length);
            *remaining -= 1;
        }
    }

    /// All phases of all substeps that remain, to the same bits as one by one. To be called where [`is_undisturbed`](Self::is_undisturbed) says so;
    /// otherwise the phases are to follow, and nobody may look at particles between them.
    pub fn take_substeps(&mut self) {
        self.scratch.unseen = true;
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
