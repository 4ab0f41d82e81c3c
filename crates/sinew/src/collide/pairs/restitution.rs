//! Restitution and kinetic friction of the pairs that touched, after velocities have been derived; and contact events.
//!
//! Pairs that touched get the relative normal velocity of `collide/restitution`, by equal and opposite impulses along the normal. Where a pair overlapped at
//! the start of the substep, the position solve leaves it a velocity that is much too fast: without the inelastic case a heap would boil.
//!
//! The position solve removes slip that is within the friction limit (`solve`). A pair that slips loses velocity here. In a heap that damps what the overlaps
//! of other pairs set in motion: with friction in positions alone 500 balls kept boiling at 20 mm/s.

use glam::{Vec3, Vec4};

use super::super::filter::ContactFilter;
use super::super::impact::{ContactParticipant, Impacts};
use super::super::restitution::{ImpactRound, contact_impulse, spreads, threshold};
use super::neighbour_list::PairBlock;
use crate::lanes::{LANES, Lanes, Number, SetLanes, Vector, kernel};
use crate::particles::Particles;

/// A block of pairs of which some touched.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Touched {
    /// Unit normal from the second to the first; zero in lanes that did not touch.
    pub(super) normal: [[f32; LANES]; 3],
    /// Relative normal velocity that led to the contact, m/s; negative when approaching.
    pub(super) parting: [f32; LANES],
    /// Inverse masses, 1/kg.
    pub(super) weights: [[f32; LANES]; 2],
    /// Overlap that the position solve has corrected, metres.
    pub(super) overlap: [f32; LANES],
    /// What has been added to the relative normal velocity since, m/s.
    pub(super) gained: [f32; LANES],
    /// Index of its pair block.
    pub(super) block: u32,
}

kernel!(
    /// Solves the velocities of the blocks that touched in one of the rounds, in the first with the friction of the overlaps.
    pub(super) fn bounce_pairs<L: Lanes>(
        touched: &mut [Touched],
        blocks: &[PairBlock],
        velocity: &mut [Vec4],
        round: &mut ImpactRound<'_>,
    ) -> () {
        let ImpactRound { h, gravity, .. } = *round;
        let (none, rate, first) = (L::zero(), L::splat(1.0 / h), round.is_first());
        for one in touched {
            round.next();
            let block = &blocks[one.block as usize];
            let [rows_a, rows_b] = &block.rows;
            let [x, y, z] = &one.normal;
            let n = Vector::new(L::load(x), L::load(y), L::load(z));
            let mut hit = L::splat(0.5).lt(n.length_squared());
            let reached = |lane: &usize| round.reaches([rows_a[*lane], rows_b[*lane]]);
            let reached = SetLanes(hit.bits()).filter(reached).fold(0, |all, i| all | 1 << i);
            if !first {
                if reached == 0 {
                    continue;
                }
                hit = L::mask(reached);
            }
            let (a, lag_a) = Vector::of(L::rows(velocity, rows_a));
            let (b, lag_b) = Vector::of(L::rows(velocity, rows_b));
            let least = threshold(L::load(&gravity.of_pairs(rows_a, rows_b)), h);
            let elastic = (L::load(&block.restitution), L::load(&one.parting), least);
            let (w_a, w_b) = (L::load(&one.weights[0]), L::load(&one.weights[1]));
            let (friction, added) = (L::load(&block.friction), L::load(&one.gained));
            let pressed = L::load(&one.overlap) * rate;
            let limit = if first { friction * L::load(&one.overlap) * rate } else { none };
            let (impulse, gained) =
                contact_impulse(n, a - b, elastic, (friction, limit), (w_a + w_b, pressed + added));
            (added + hit.and(gained)).store(&mut one.gained);
            let (a, b) = ((a + impulse * w_a).or_else(hit, a), (b - impulse * w_b).or_else(hit, b));
            L::put_rows(velocity, rows_a, a.with(lag_a));
            L::put_rows(velocity, rows_b, b.with(lag_b));
            let passed_on = L::mask(reached).and(spreads(elastic, gained, false));
            let spreads = hit.and(spreads(elastic, gained, first)).or(passed_on);
            for (rows, w) in [(rows_a, w_a), (rows_b, w_b)] {
                let moves = spreads.and(none.lt(w)).bits();
                SetLanes(moves).for_each(|lane| round.mark(rows[lane]));
            }
        }
    }
);

/// A contact that was solved by itself or is to be reported.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairHit {
    rows: [u32; 2],
    bodies: [u32; 2],
    /// Unit vector from the second to the first.
    normal: Vec3,
    /// Approach speed, m/s.
    approach: f32,
    friction: f32,
    restitution: f32,
    /// Impulse, N·s: at first that of the overlap alone.
    impulse: f32,
    /// Its index in the touched blocks and its lane, unless it was solved by itself.
    place: Option<(usize, usize)>,
    /// Midpoint of the two, metres.
    point: Vec3,
    pub(super) reported: bool,
}

impl PairHit {
    /// A contact whose overlap of `overlap` metres was corrected in a substep of `h` seconds. The velocities must still be those that led to it.
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
        let combined_material = one.material.against(&other.material);
        Self {
            rows,
            bodies,
            normal,
            approach: closing.dot(normal),
            friction: combined_material.friction,
            restitution: combined_material.restitution,
            impulse: overlap / (weights * h),
            point: particles.position(a) - particles.separation(a, b) * 0.5,
            place,
            reported: one.events || other.events,
        }
    }

    /// Applies restitution to the pair, unless its block does.
    pub(super) fn bounce(&mut self, particles: &mut Particles, round: &mut ImpactRound) {
        if self.place.is_some() {
            return;
        }
        round.next();
        let is_reached = round.reaches(self.rows);
        if !(is_reached || round.is_first()) {
            return;
        }
        let [a, b] = self.rows.map(|row| row as usize);
        let (w_a, w_b) = (particles.inverse_mass(a), particles.inverse_mass(b));
        let velocity = Vector::<f32>::splat(particles.velocity(a) - particles.velocity(b));
        let least = threshold(round.gravity.greatest(self.rows), round.h);
        let elastic = (self.restitution, -self.approach, least);
        // The position solve has all of the friction of its own correction (`swept`).
        let (normal, friction) = (Vector::splat(self.normal), (self.friction, 0.0));
        let weights = w_a + w_b;
        let pressed = (weights, self.impulse * weights);
        let (impulse, gained) = contact_impulse(normal, velocity, elastic, friction, pressed);
        let impulse = Vec3::from(impulse);
        self.impulse += gained / weights;
        let spreads = spreads(elastic, gained, !is_reached).any();
        for (row, w, sign) in [(self.rows[0], w_a, 1.0), (self.rows[1], w_b, -1.0)] {
            if w > 0.0 {
                particles.velocity[row as usize] += (impulse * (w * sign)).extend(0.0);
                if spreads {
                    round.mark(row);
                }
            }
        }
    }

    /// Adds the impulse that its block has added, if it is in one.
    pub(super) fn note_impulse(&mut self, touched: &[Touched]) {
        if let Some((number, lane)) = self.place {
            let Touched { gained, weights: [a, b], .. } = &touched[number];
            self.impulse += gained[lane] / (a[lane] + b[lane]);
        }
    }

    /// Adds it to the contact events.
    pub(super) fn report(&self, impacts: &mut Impacts) {
        let participants = self.bodies.map(ContactParticipant::Body);
        impacts.add(participants, self.point, self.normal, self.impulse, false);
    }
}
