//! All that a step needs to know of contacts and nobody saves, and in which order its parts are asked.

use super::body_collider::BodyCollider;
use super::body_contact::{BodyContactSolver, ContactCache, RigidStep};
use super::filter::ContactFilter;
use super::impact::{Impact, Impacts};
use super::nearby::Nearby;
use super::pairs::Pairs;
use super::particle_contact::{NormalImpulse, NormalImpulses, ParticleContacts};
use super::pressed::PressedCloth;
use super::triangles::Triangles;
use super::world::World;
use crate::islands::Islands;
use crate::lanes::InstructionSet;
use crate::particles::Particles;

/// Contacts of a step. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    pub(crate) particle_contacts: ParticleContacts,
    pub(crate) normal_impulses: Vec<NormalImpulse>,
    /// For each row whether it does not collide by itself: it belongs to a body collider, or its body touches nothing.
    aside: Vec<bool>,
    /// For each row whether it takes no part in `pairs`: it is aside, or triangles do all that its pairs would.
    unpaired: Vec<bool>,
    nearby: Nearby,
    pairs: Pairs,
    triangles: Triangles,
    pub(crate) body_contact: BodyContactSolver,
    impacts: Impacts,
}

impl Contacts {
    /// Chooses the instructions of the wide kernels. They never change a result.
    pub(crate) fn use_instructions(&mut self, instructions: InstructionSet) {
        self.body_contact.instructions = instructions;
        self.pairs.instructions = instructions;
        self.triangles.use_instructions(instructions);
    }

    /// Notes which rows belong to which body colliders, when those or the particles have changed.
    pub(crate) fn compile(&mut self, body_colliders: &[BodyCollider], particles: &Particles) {
        self.body_contact.compile(body_colliders, particles);
        self.nearby.compile(body_colliders, particles);
    }

    /// Whether a row does not collide by itself: it belongs to a body collider, which does in its place, or its body touches nothing.
    pub(crate) fn is_aside(&self, row: u32) -> bool {
        self.aside.get(row as usize).is_some_and(|&aside| aside)
    }

    /// Begins a step: finds what may come to touch what, and borrows the contact cache until the step [ends](Self::keep). Bodies that ask for
    /// it collide by the triangles of `surfaces`.
    pub(crate) fn begin(
        &mut self,
        (particles, surfaces): (&Particles, &[[u32; 3]]),
        world: World,
        contact_cache: &mut ContactCache,
    ) {
        let World { filter, dt, .. } = world;
        self.impacts.clear();
        self.set_aside(particles, filter);
        let normal_impulses = &mut self.normal_impulses;
        self.particle_contacts.begin(particles, &world, &self.aside, normal_impulses);
        self.nearby.broad_phase(particles, &world, &self.aside);
        let Self { aside, unpaired, nearby, .. } = self;
        self.body_contact.broad_phase(particles, &world, nearby, contact_cache);
        self.triangles.broad_phase(particles, surfaces, (filter, nearby), aside, dt);
        unpaired.clone_from(aside);
        self.triangles.mark_corners(filter, particles.len(), unpaired);
        self.pairs.broad_phase(particles, (filter, nearby), &particles.rest, unpaired, dt);
    }

    /// Whether a body may come to touch particles of another one in this step.
    pub(crate) fn may_meet_others(&self, body: u32) -> bool {
        self.nearby.to_particles().has_beside(body)
    }

    /// Whether it may come to touch particles in this step, of another one or its own.
    pub(crate) fn may_meet_any(&self, body: u32) -> bool {
        self.nearby.to_particles().has(body)
    }

    /// Notes which rows do not collide by themselves.
    fn set_aside(&mut self, particles: &Particles, filter: &ContactFilter) {
        let Self { aside, body_contact, .. } = self;
        aside.clear();
        aside.extend_from_slice(body_contact.rows());
        if filter.bodies().iter().any(|body| body.disabled) {
            aside.resize(particles.len(), false);
            let disabled = particles.body.iter().map(|&body| filter.body(body).disabled);
            aside.iter_mut().zip(disabled).for_each(|(aside, disabled)| *aside |= disabled);
        }
    }

    /// The body colliders, of which some are rigid states.
    pub(crate) fn rigid_states(&mut self) -> &mut BodyContactSolver {
        &mut self.body_contact
    }

    /// Reads those of this step, and notes which islands they are. In a world in 2D there are none: single particles are held in its plane.
    pub(crate) fn begin_rigid_states(
        &mut self,
        particles: &mut Particles,
        islands: &mut Islands,
        step: RigidStep,
    ) {
        let held = self.particle_contacts.holds_in_plane();
        self.body_contact.begin_rigid_states(particles, islands, step, held);
    }

    /// Whether some of them are in this step.
    pub(crate) fn has_rigid_states(&self) -> bool {
        self.body_contact.has_rigid_states()
    }

    /// Whether something may come to touch something else that moves, so that islands cannot go their ways alone.
    pub(crate) fn is_active(&self) -> bool {
        let quiet = self.body_contact.is_empty() || self.body_contact.is_idle();
        !quiet || !self.pairs.is_empty() || !self.triangles.is_empty()
    }

    /// Between the constraints of a substep of `h` seconds and its velocities.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        world: &World,
        (h, substep): (f32, u32),
        cloth: &mut impl PressedCloth,
    ) {
        let Self { particle_contacts, normal_impulses, nearby, body_contact, .. } = self;
        let cloth = (cloth, &*particle_contacts, &mut normal_impulses[..]);
        body_contact.project(particles, (world, nearby), (h, substep), cloth);
        self.pairs.project(particles, world.filter, h);
        // Last, so that what it says of sides holds when the next substep begins.
        self.triangles.project(particles, world.filter);
        self.particle_contacts.flatten(particles, false);
    }

    /// After the velocities.
    pub(crate) fn bounce(&mut self, particles: &mut Particles, h: f32, gravity: f32) {
        self.body_contact.bounce(particles, h, gravity);
        self.pairs.bounce(particles, h, gravity);
        self.triangles.bounce(particles, h, gravity);
        self.particle_contacts.flatten(particles, true);
    }

    /// How deep body colliders are in each other and in what stands, metres, with a row of each.
    pub(crate) fn overlaps(&mut self) -> impl Iterator<Item = (u32, f32)> {
        self.body_contact.overlaps()
    }

    /// Gives the contact cache back.
    pub(crate) fn keep(&mut self, contact_cache: &mut ContactCache) {
        self.body_contact.keep(contact_cache);
    }

    /// What has touched what in a step.
    pub(crate) fn report(&mut self, particles: &Particles) -> &[Impact] {
        let mut normal_impulses = NormalImpulses::all(&mut self.normal_impulses);
        self.particle_contacts.report(particles, &mut normal_impulses, &mut self.impacts);
        self.body_contact.report(&mut self.impacts);
        self.pairs.report(&mut self.impacts);
        self.triangles.report(&mut self.impacts);
        self.impacts.merge()
    }
}
