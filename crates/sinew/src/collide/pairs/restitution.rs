//! After the velocities are derived: what two that touched part with; and what is reported.
//!
//! Two particles that touched get the relative speed along the normal that `collide/restitution` asks for, by an impulse along the normal, equal and
//! opposite. Where they had overlapped when the substep began, positions leave them a speed that is much too high: without the inelastic case a heap
//! would boil.
//!
//! Friction in positions holds what sticks (`solve`). What slides loses speed here, which also calms what the overlaps of other pairs set in motion: with
//! friction in positions alone 500 balls kept boiling at 20 mm/s.

use glam::{Vec3, Vec4};

use super::super::filter::ContactFilter;
use super::super::friction::friction_share;
use super::super::impact::{ContactParticipant, Impacts};
use super::super::restitution::separation_speed;
use super::neighbour_list::PairBlock;
use crate::lanes::{LANES, Lanes, Vector, kernel};
use crate::particles::Particles;

/// A block in which some touched.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Touched {
    /// From the second to the first; zero where they did not.
    pub(super) normal: [[f32; LANES]; 3],
    /// How fast they parted along it, m/s; negative where they came nearer.
    pub(super) parting: [f32; LANES],
    /// Inverse masses, 1/kg.
    pub(super) weights: [[f32; LANES]; 2],
    /// First `μ` times the overlap, metres: how much sliding it may take. In the end the impulse along the normal beside what the overlap took, N·s.
    pub(super) impulse: [f32; LANES],
    /// Its number.
    pub(super) block: u32,
}

kernel!(
    /// The impulses of all that touched.
    pub(super) fn bounce_pairs<L: Lanes>(
        touched: &mut [Touched],
        blocks: &[PairBlock],
        velocity: &mut [Vec4],
        // What is slower than this does not bounce, m/s.
        least: f32,
        // Length of the substep, seconds.
        h: f32,
    ) {
        for one in touched {
            let block = &blocks[one.block as usize];
            let [rows_a, rows_b] = &block.rows;
            let (a, lag_a) = Vector::of(L::rows(velocity, rows_a));
            let (b, lag_b) = Vector::of(L::rows(velocity, rows_b));
            let [x, y, z] = &one.normal;
            let n = Vector::new(L::load(x), L::load(y), L::load(z));
            let hit = L::splat(0.5).lt(n.length_squared());
            let (before, now) = (L::load(&one.parting), n.dot(a - b));
            let restitution = L::load(&block.restitution);
            let wanted = separation_speed(restitution, before, now, least);
            let (w_a, w_b) = (L::load(&one.weights[0]), L::load(&one.weights[1]));
            let size = (wanted - now) / (w_a + w_b);
            let along = (a - b) - n * now;
            let (length, most) = (along.length(), L::load(&one.impulse) * L::splat(1.0 / h));
            let held = friction_share(length, most);
            size.store(&mut one.impulse);
            let impulse = n * size - along * (held / (w_a + w_b));
            let (a, b) = ((a + impulse * w_a).or_else(hit, a), (b - impulse * w_b).or_else(hit, b));
            L::put_rows(velocity, rows_a, a.with(lag_a));
            L::put_rows(velocity, rows_b, b.with(lag_b));
        }
    }
);

/// Two that met, and were treated by themselves or are to be reported.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairHit {
    rows: [u32; 2],
    bodies: [u32; 2],
    /// Unit vector from the second to the first.
    normal: Vec3,
    /// How fast they came nearer, m/s.
    approach: f32,
    restitution: f32,
    /// What the overlap alone took, N·s.
    impulse: f32,
    /// Which of those that touched it is, and its lane there, unless it was treated by itself.
    place: Option<(usize, usize)>,
    /// Half way between the two, metres.
    point: Vec3,
    pub(super) reported: bool,
}

impl PairHit {
    /// Two that were pushed apart by `overlap` metres in a substep of `h` seconds, and whose velocities are still those that led to it.
    pub(super) fn new(
        particles: &Particles,
        filter: &ContactFilter,
        rows: [u32; 2],
        (normal, overlap): (Vec3, f32),
        place: Option<(usize, usize)>,
        h: f32,
    ) -> Self {
        let [a, b] = rows.map(|row| row as usize);
        let bodies = [particles.body[a], particles.body[b]];
        let [one, other] = bodies.map(|body| filter.body(body));
        let closing = particles.velocity(b) - particles.velocity(a);
        let weights = particles.inverse_mass(a) + particles.inverse_mass(b);
        Self {
            rows,
            bodies,
            normal,
            approach: closing.dot(normal),
            restitution: one.material.against(&other.material).restitution,
            impulse: overlap / (weights * h),
            point: particles.position(a) - particles.separation(a, b) * 0.5,
            place,
            reported: one.events || other.events,
        }
    }

    /// Gives the two the velocity that they part with, unless they got it with others of a block; what came slower than `least`, m/s, does not
    /// bounce.
    pub(super) fn bounce(&mut self, particles: &mut Particles, touched: &[Touched], least: f32) {
        if let Some((number, lane)) = self.place {
            self.impulse += touched[number].impulse[lane];
            return;
        }
        let [a, b] = self.rows.map(|row| row as usize);
        let now = (particles.velocity(a) - particles.velocity(b)).dot(self.normal);
        let wanted = separation_speed(self.restitution, -self.approach, now, least);
        let (w_a, w_b) = (particles.inverse_mass(a), particles.inverse_mass(b));
        let size = (wanted - now) / (w_a + w_b);
        self.impulse += size;
        let impulse = self.normal * size;
        particles.velocity[a] += (impulse * w_a).extend(0.0);
        particles.velocity[b] -= (impulse * w_b).extend(0.0);
    }

    /// Reports it.
    pub(super) fn report(&self, impacts: &mut Impacts) {
        let participants = self.bodies.map(ContactParticipant::Body);
        impacts.add(participants, self.point, self.normal, self.impulse, false);
    }
}
