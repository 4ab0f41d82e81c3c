//! A small world with only particles, rods and a box, to test pairs in.

mod cloth;
mod contacts;
mod heap;
mod order;
mod two;

use glam::{Vec3, Vec4};

use super::Pairs;
use crate::collide::nearby::Nearby;
use crate::collide::restitution::ImpactRounds;
use crate::collide::{BodyContacts, ContactFilter, Material};
use crate::integrate::{Derive, Integrator, StepRows, derive, predict};
use crate::lanes::InstructionSet;
use crate::particles::{ParticleSeed, Particles};
use crate::threads::ExecutionContext;

/// Particles and all that acts on them in a step.
#[derive(Clone, Default)]
struct World {
    particles: Particles,
    contacts: Vec<BodyContacts>,
    rest: Vec<Vec3>,
    pairs: Pairs,
    filter: ContactFilter,
    gravity: Vec3,
    /// Rows of each rod, and its length, metres.
    rods: Vec<(u32, u32, f32)>,
    /// Corners of a box that holds all particles, and its coefficient of friction.
    room: Option<(Vec3, Vec3, f32)>,
    /// Number of neighbour list builds.
    rebuilds: u32,
}

/// Substeps of a step.
const SUBSTEPS: u32 = 10;

impl World {
    /// Adds a particle of a body.
    fn push(&mut self, seed: ParticleSeed, body: u32) -> usize {
        let row = self.particles.push(seed).unwrap() as usize;
        self.particles.set_body(row, Some(body));
        row
    }

    fn find(&mut self, dt: f32) {
        self.find_without(&[], dt);
    }

    /// Runs the broad phase without the rows that are marked.
    fn find_without(&mut self, excluded: &[bool], dt: f32) {
        let Self { particles, contacts, rest, pairs, filter, .. } = self;
        *filter = ContactFilter::untied(contacts);
        let nearby = Nearby::everywhere(contacts);
        pairs.broad_phase(particles, (filter, &nearby), rest, excluded, dt);
    }

    /// A step of `dt` seconds; returns the greatest overlap found, metres.
    fn step(&mut self, dt: f32) -> f32 {
        self.find(dt);
        let h = dt / SUBSTEPS as f32;
        let mut worst = 0.0_f32;
        for _ in 0..SUBSTEPS {
            worst = worst.max(self.substep(h));
        }
        self.rebuilds += self.pairs.rebuilds;
        worst
    }

    fn substep(&mut self, h: f32) -> f32 {
        let execution = ExecutionContext { instructions: InstructionSet::best(), workers: None };
        let Self { particles, pairs, filter, .. } = self;
        particles.clear_sums(0.0);
        particles.accelerate_all(self.gravity);
        predict(
            particles,
            Integrator::Verlet,
            h,
            &[StepRows { rows: 0..particles.len(), microsteps: 1 }],
            execution,
        );
        for &(a, b, length) in &self.rods {
            pull(particles, a as usize, b as usize, length);
        }
        if let Some(room) = self.room {
            (0..particles.len()).for_each(|i| hold(particles, i, room));
        }
        let worst = pairs.project(particles, filter, h);
        let Particles { position, start, velocity, .. } = particles;
        derive(Derive { position, start, velocity, momentum_drift: &[], h, lag: h }, execution);
        let gravity = self.gravity.length().into();
        let rows = particles.len();
        ImpactRounds::default()
            .run((rows, 0), (h, &gravity), |round| pairs.bounce(particles, round));
        pairs.end_substep();
        worst
    }

    /// Kinetic energy, J.
    fn energy(&self) -> f64 {
        self.sum(|m, _, v| 0.5 * m * v.as_dvec3().length_squared())
    }

    fn momentum(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.sum(|m, _, v| m * f64::from(v[k])))
    }

    fn angular_momentum(&self) -> [f64; 3] {
        let turn = |p: Vec3, v: Vec3| p.as_dvec3().cross(v.as_dvec3());
        [0, 1, 2].map(|k| self.sum(|m, p, v| m * turn(p, v)[k]))
    }

    fn sum(&self, of: impl Fn(f64, Vec3, Vec3) -> f64) -> f64 {
        let loose = (0..self.particles.len()).filter(|&i| self.particles.inverse_mass(i) > 0.0);
        loose
            .map(|i| {
                let mass = f64::from(self.particles.mass(i));
                of(mass, self.particles.position(i), self.particles.velocity(i))
            })
            .sum()
    }
}

/// Contact settings of a body that collides with itself and with others.
fn self_colliding(friction: f32, restitution: f32) -> BodyContacts {
    let material = Material { friction, restitution, ..Default::default() };
    BodyContacts { material, with_bodies: true, with_itself: true, ..Default::default() }
}

fn pull(particles: &mut Particles, a: usize, b: usize, length: f32) {
    let d = particles.separation(a, b);
    let weights = particles.inverse_mass(a) + particles.inverse_mass(b);
    let now = d.length();
    if now > 0.0 && weights > 0.0 {
        let each = d * ((length - now) / now / weights);
        let (w_a, w_b) = (particles.inverse_mass(a), particles.inverse_mass(b));
        particles.displace(a, each * w_a);
        particles.displace(b, -each * w_b);
    }
}

/// Keeps a particle in a box, with friction on its walls.
fn hold(particles: &mut Particles, i: usize, (low, high, friction): (Vec3, Vec3, f32)) {
    let (at, r) = (particles.position(i), particles.radius(i));
    let out = at.clamp(low + r, high - r) - at;
    let depth = out.length();
    if particles.inverse_mass(i) == 0.0 || depth == 0.0 {
        return;
    }
    let n = out / depth;
    let moved = (particles.position[i] - particles.start[i]).truncate() + out;
    let slid = moved - n * n.dot(moved);
    let back = Vec3::from(super::super::friction::friction(slid.into(), depth, friction));
    particles.position[i] += (out + back).extend(0.0);
}

fn bits(columns: &[Vec4]) -> Vec<[u32; 4]> {
    columns.iter().map(|v| v.to_array().map(f32::to_bits)).collect()
}
