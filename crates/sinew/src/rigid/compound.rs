//! A compound that moves as an explicit rigid body, in a simulation of particles (physics.md M1, M2).
//!
//! Between steps its particles are the state, as for every other compound: adding it to the simulation's list, or removing it, swaps the representation. When a
//! step begins, the body is read from its particles ([`RigidBody::from_rows`]). In each substep
//!
//! 1. the forces on its particles are summed into a force and a torque, and the body is stepped;
//! 2. its particles are placed accordingly, and constraints and contacts move them like any others; among the constraints is a [`Rigid`] shape (which replaces
//!    those that held them together), so that what pulls at one of them pulls at all;
//! 3. if nothing moved them, the body continues unchanged, to the last bit of its own integrator. Otherwise it takes the pose of its particles, and a
//!    displacement `d` of a particle counts as an impulse `m d/h` on the body.

use glam::{DVec3, Quat, Vec3, Vec4};

use super::{RigidBody, RigidIntegrator};
use crate::constraints::{Constraint, ConstraintKind, Rigid};
use crate::particles::Particles;

/// Particles that move as one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Compound {
    /// Rows of the particles. Constraints among them alone are inactive meanwhile.
    pub rows: Vec<usize>,
    /// Rest position of each in the body's own frame, metres.
    pub rest: Vec<Vec3>,
    /// Its integrator.
    pub integrator: RigidIntegrator,
}

/// The rigid bodies of a step. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct CompoundBodies {
    /// The body of each compound; `None` where there cannot be one (a particle is pinned, or none has mass). Those stay particles.
    bodies: Vec<Option<RigidBody>>,
    /// Positions of the particles as the bodies placed them in this substep, compound after compound.
    placed: Vec<Vec4>,
}

impl Compound {
    /// A compound with these rest positions (metres) in its own frame, and the default integrator.
    pub fn new(rows: impl IntoIterator<Item = usize>, rest: Vec<Vec3>) -> Self {
        Self { rows: rows.into_iter().collect(), rest, integrator: RigidIntegrator::default() }
    }

    /// The shape constraint that holds its particles together.
    pub(crate) fn shape(&self) -> Constraint {
        let kind = Rigid { rest: self.rest.as_slice().into(), softness: Default::default() };
        Constraint::new(self.rows.iter().map(|&row| row as u32), ConstraintKind::Rigid(kind))
    }
}

impl CompoundBodies {
    /// Reads the bodies from their particles, at the start of a step.
    pub(crate) fn read(&mut self, particles: &Particles, compounds: &[Compound]) {
        self.bodies.clear();
        self.bodies.extend(compounds.iter().map(|compound| read_one(particles, compound)));
    }

    /// Sets all velocities to zero.
    pub(crate) fn stop(&mut self) {
        for body in self.bodies.iter_mut().flatten() {
            (body.velocity, body.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
        }
    }

    /// Steps the bodies by `h` seconds, and places their particles accordingly. This overwrites the predictions of these particles.
    pub(crate) fn predict(&mut self, particles: &mut Particles, compounds: &[Compound], h: f32) {
        self.placed.clear();
        for (compound, slot) in compounds.iter().zip(&mut self.bodies) {
            let Some(body) = slot else { continue };
            let (mut force, mut torque, mut loss) = (Vec3::ZERO, Vec3::ZERO, 0.0);
            for &i in &compound.rows {
                let m = particles.mass(i);
                let push = particles.acceleration(i) * m;
                let arm = (particles.origin[i] - body.origin) + particles.start[i].truncate()
                    - body.position;
                force += push;
                torque += arm.cross(push);
                loss += particles.rate(i) * m;
            }
            if body.step(force, torque, h, compound.integrator).is_err() {
                *slot = None;
                continue;
            }
            // Damping acts equally on each particle's velocity, and so on the body's two velocities.
            let kept = libm::expf(-loss / body.mass * h);
            body.velocity *= kept;
            body.angular_velocity *= kept;
            for (&i, (place, _)) in compound.rows.iter().zip(body.place(&compound.rest)) {
                let local = (body.origin - particles.origin[i]) + place;
                particles.position[i] = local.extend(particles.position[i].w);
                let lag = particles.velocity[i].w;
                particles.velocity[i] = ((local - particles.start[i].truncate()) / h).extend(lag);
                self.placed.push(particles.position[i]);
            }
        }
    }

    /// Ends a substep of `h` seconds: applies to the bodies what constraints did to their particles, and gives all particles the velocities of their bodies.
    pub(crate) fn end_substep(
        &mut self,
        particles: &mut Particles,
        compounds: &[Compound],
        h: f32,
    ) {
        let mut placed = self.placed.iter();
        for (compound, slot) in compounds.iter().zip(&mut self.bodies) {
            if slot.is_none() {
                continue;
            }
            let placed = placed.by_ref().take(compound.rows.len());
            if let Some(push) = Push::of(particles, compound, placed) {
                *slot = slot.as_ref().and_then(|body| pushed(particles, compound, body, &push, h));
            }
            if let Some(body) = slot
                && body.write_rows_in_step(particles, &compound.rows, &compound.rest).is_err()
            {
                *slot = None;
            }
        }
    }
}

/// Total displacement of a body's particles by constraints in a substep.
struct Push {
    /// `Σ m d`, kg·m.
    linear: DVec3,
    /// `Σ m p × d` about the origin of the particles, kg·m².
    angular: DVec3,
}

impl Push {
    /// `None` if no particle was moved by more than round-off.
    fn of<'a>(
        particles: &Particles,
        compound: &Compound,
        placed: impl Iterator<Item = &'a Vec4>,
    ) -> Option<Self> {
        let mut push = Self { linear: DVec3::ZERO, angular: DVec3::ZERO };
        let mut touched = false;
        for (&i, put) in compound.rows.iter().zip(placed) {
            let now = particles.position[i].truncate();
            let moved = now - put.truncate();
            // Four times the spacing of `f32` there: the shape's own projection rounds by less.
            touched |= moved.abs().max_element() > 4.0 * f32::EPSILON * now.abs().max_element();
            let m = f64::from(particles.mass(i));
            push.linear += moved.as_dvec3() * m;
            push.angular += now.as_dvec3().cross(moved.as_dvec3()) * m;
        }
        touched.then_some(push)
    }
}

/// The body at the pose of its particles, with the impulses that moved them there.
fn pushed(
    particles: &Particles,
    compound: &Compound,
    body: &RigidBody,
    push: &Push,
    h: f32,
) -> Option<RigidBody> {
    let mut found = read_one(particles, compound)?;
    let first = *compound.rows.first()?;
    // The particles are relative to the origin of their island, the body to its own.
    let centre = (found.origin - particles.origin[first]).as_dvec3() + found.position.as_dvec3();
    (found.velocity, found.angular_velocity) = (body.velocity, body.angular_velocity);
    found.apply_impulse((push.linear / f64::from(h)).as_vec3());
    found.apply_angular_impulse(
        ((push.angular - centre.cross(push.linear)) / f64::from(h)).as_vec3(),
    );
    Some(found)
}

/// The body of a compound; `None` if there cannot be one.
fn read_one(particles: &Particles, compound: &Compound) -> Option<RigidBody> {
    let held = |&i: &usize| i >= particles.len() || particles.inverse_mass(i) == 0.0;
    if compound.rows.iter().any(held) {
        return None;
    }
    RigidBody::from_rows(particles, &compound.rows, &compound.rest, Quat::IDENTITY).ok()
}
