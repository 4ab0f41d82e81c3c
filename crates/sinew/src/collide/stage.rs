//! All contact state that a step needs and that is not saved, and the order in which the contact passes run.

use super::body_collider::BodyCollider;
use super::body_contact::{BodyContactSolver, ContactCache, RigidStep};
use super::features::Features;
use super::impact::{Impact, Impacts};
use super::nearby::Nearby;
use super::pairs::Pairs;
use super::particle_contact::{NormalImpulse, NormalImpulses, ParticleContacts};
use super::pressed::PressedCloth;
use super::restitution::ImpactRounds;
use super::triangles::Triangles;
use super::world::World;
use crate::forces::RowGravity;
use crate::islands::Islands;
use crate::particles::Particles;
use crate::threads::ExecutionContext;
use crate::tracked::Tracked;

/// Contact state of a step. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    pub(crate) particle_contacts: ParticleContacts,
    pub(crate) normal_impulses: Vec<NormalImpulse>,
    features: Features,
    /// For each row whether it takes no part in `pairs`: it does not collide as a particle, or triangles do all that its pairs would.
    unpaired: Vec<bool>,
    nearby: Nearby,
    pairs: Pairs,
    triangles: Triangles,
    impact_rounds: ImpactRounds,
    pub(crate) body_contact: BodyContactSolver,
    impacts: Impacts,
}

impl Contacts {
    /// Rebuilds the map from rows to body colliders, when those or the particles have changed.
    pub(crate) fn compile(&mut self, body_colliders: &[BodyCollider], particles: &Particles) {
        self.body_contact.compile(body_colliders, particles);
        self.nearby.compile(body_colliders, particles);
    }

    /// Whether a row does not collide as a particle: it belongs to a body collider, which collides in its place, or contacts of its body are disabled.
    pub(crate) fn is_excluded(&self, row: u32) -> bool {
        self.particle_contacts.is_excluded(row)
    }

    /// Begins a step: runs the broad phases, and borrows the contact cache until the step [ends](Self::keep). Bodies that collide by their
    /// [surface](crate::BodyContacts::surface) use the triangles of `surfaces`.
    pub(crate) fn begin(
        &mut self,
        (particles, surfaces): (&Particles, &Tracked<Vec<[u32; 3]>>),
        world: World,
        contact_cache: &mut ContactCache,
        execution: ExecutionContext<'_>,
    ) {
        let World { filter, dt, .. } = world;
        self.body_contact.instructions = execution.instructions;
        self.pairs.instructions = execution.instructions;
        self.impacts.clear();
        let Self { particle_contacts, features, unpaired, nearby, body_contact, .. } = self;
        let any_surface = filter.bodies().iter().any(|body| body.surface && !body.disabled);
        if any_surface && !(world.colliders.is_empty() && body_contact.is_empty()) {
            features.update(surfaces, filter, particles);
        } else {
            features.clear();
        }
        let own = (body_contact.rows(), &*features);
        particle_contacts.begin(particles, &world, own, &mut self.normal_impulses);
        let excluded = &particle_contacts.excluded;
        nearby.broad_phase(particles, &world, excluded);
        body_contact.broad_phase(particles, &world, (nearby, features), contact_cache);
        let near = (filter, &*nearby);
        self.triangles.broad_phase(particles, surfaces, near, excluded, dt, execution);
        unpaired.clone_from(excluded);
        self.triangles.mark_corners(filter, particles.len(), unpaired);
        self.pairs.broad_phase(particles, (filter, nearby), &particles.rest, unpaired, dt);
    }

    /// Whether a body may touch particles of another body in this step.
    pub(crate) fn may_touch_others(&self, body: u32) -> bool {
        self.nearby.to_particles().has_other(body)
    }

    /// Whether a body may touch particles in this step, of another body or its own.
    pub(crate) fn may_touch_any(&self, body: u32) -> bool {
        self.nearby.to_particles().has(body)
    }

    /// The solver of body colliders, some of which are rigid states.
    pub(crate) fn rigid_states(&mut self) -> &mut BodyContactSolver {
        &mut self.body_contact
    }

    /// Loads the rigid states of this step, and marks their islands. A 2D world has none, since its plane constrains single particles.
    pub(crate) fn begin_rigid_states(
        &mut self,
        particles: &mut Particles,
        islands: &mut Islands,
        step: RigidStep,
    ) {
        let held = self.particle_contacts.holds_in_plane();
        self.body_contact.begin_rigid_states(particles, islands, step, held);
    }

    /// Whether this step has rigid states.
    pub(crate) fn has_rigid_states(&self) -> bool {
        self.body_contact.has_rigid_states()
    }

    /// Whether two dynamic things may touch in this step, so that islands cannot be solved independently.
    pub(crate) fn is_active(&self) -> bool {
        let quiet = self.body_contact.is_empty() || self.body_contact.is_idle();
        !quiet || !self.pairs.is_empty() || !self.triangles.is_empty()
    }

    /// Solves the contacts in positions: after the constraints of a substep of `h` seconds and before its velocities.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        world: &World,
        (h, substep): (f32, u32),
        cloth: &mut impl PressedCloth,
        execution: ExecutionContext<'_>,
    ) {
        let Self { particle_contacts, normal_impulses, nearby, features, body_contact, .. } = self;
        let cloth = (cloth, &*particle_contacts, &mut normal_impulses[..]);
        body_contact.project(particles, (world, nearby, features), (h, substep), cloth);
        self.pairs.project(particles, world.filter, h);
        // Last, so that the sides that it determines still hold when the next substep begins.
        self.triangles.project(particles, world.filter, execution);
        self.particle_contacts.flatten(particles, false);
    }

    /// Solves restitution: after the velocities of a substep.
    pub(crate) fn bounce(&mut self, particles: &mut Particles, h: f32, gravity: &RowGravity) {
        let Self { particle_contacts, normal_impulses, pairs, triangles, body_contact, .. } = self;
        body_contact.begin_impacts();
        let any_touched = pairs.any_touched() || triangles.any_touched();
        if any_touched || body_contact.any_contacts() || particle_contacts.any_elastic() {
            let mut normal_impulses = NormalImpulses::all(normal_impulses);
            let ends = (particles.len(), body_contact.impact_rows());
            self.impact_rounds.run(ends, (h, gravity), |round| {
                particle_contacts.bounce_again(particles, &mut normal_impulses, round);
                body_contact.bounce(particles, round);
                pairs.bounce(particles, round);
                triangles.bounce(particles, round);
            });
            pairs.end_substep();
            triangles.end_substep();
        }
        body_contact.end_impacts(particles, h);
        particle_contacts.flatten(particles, true);
    }

    /// Depths of overlap of body colliders with each other and with static geometry, metres, each with a row of the two.
    pub(crate) fn overlaps(&mut self) -> impl Iterator<Item = (u32, f32)> {
        self.body_contact.overlaps()
    }

    /// Returns the contact cache.
    pub(crate) fn keep(&mut self, contact_cache: &mut ContactCache) {
        self.body_contact.keep(contact_cache);
    }

    /// The contact events of a step.
    pub(crate) fn report(&mut self, particles: &Particles) -> &[Impact] {
        let mut normal_impulses = NormalImpulses::all(&mut self.normal_impulses);
        self.particle_contacts.report(particles, &mut normal_impulses, &mut self.impacts);
        self.body_contact.report(particles, &mut self.impacts);
        self.pairs.report(&mut self.impacts);
        self.triangles.report(&mut self.impacts);
        self.impacts.merge()
    }
}
