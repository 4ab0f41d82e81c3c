//! Contacts in velocities, after those are derived from positions: restitution, planar drag, and removal of depenetration speed.
//!
//! Restitution is one problem in velocities over all contacts (Moreau's law of impacts). Speed that came of recovering an overlap is taken off.
//!
//! # The law
//!
//! Position corrections are inelastic: a body that is moved to a surface leaves it with the speed that it lacked to get there. So with `v⁻` the normal speeds
//! before contacts (negative when approaching), `v` those that the positions gave and `P ≥ 0` the impulses of the points that pressed in this substep, the
//! velocities after it satisfy, at all points at once,
//!
//! ```text
//! P ≥ 0,    v + e v⁻ ≥ 0,    P (v + e v⁻) = 0
//! ```
//!
//! with `e` the restitution where `v⁻` was faster than `2gh`, which gravity alone gives to a resting body, and 0 elsewhere. Points that were parting may come
//! to approach (`v⁻ > 0`, pushed by others): they bounce in a later substep. With one `e` everywhere energy changes by `½ Σ P (v⁻ + v) = ½ Σ P v⁻ (1 - e)`,
//! and with `e = 1` by nothing, whatever the contacts: a ball into two that touch, a row of balls. It is solved by projected Gauss–Seidel: manifold by
//! manifold (`normal_solve`), as a change of the impulses of the positions, so that a point may end with less than it had. Moreau, *Unilateral
//! Contact and Dry Friction in Finite Freedom Dynamics*, 1988.
//!
//! Bodies recovered from a deep overlap (see `normal_solve`) are left with no normal speed: that much of their impulse is taken back.
//!
//! # Where
//!
//! All of it happens at the poses where the substep began, to which the normals belong. A normal that had turned meanwhile would not be the one along which
//! the approach was measured: oblique bounces would gain energy each time, and a gas of balls would heat up without end. Moments are taken about those poses,
//! too, so two bodies that bounced off each other move from there with their new velocities, `q = p + h v`, as if they had bounced when the substep began:
//! then the conserved angular momentum is Verlet's own. So does a single particle that bounced off a body, if nothing else has moved it in the substep. A body
//! that is pushed out of an old overlap stays where it was pushed to, and one that bounced off static geometry, where no momentum has to be kept, at the
//! surface.
//!
//! # Which manifolds take part
//!
//! Impacts spread from fast contacts, in the [rounds](ImpactRound) that body colliders have in common with single particles: in a heap that is hit, the
//! manifolds that pressed are solved as far as the impact reaches. Manifolds of bodies that recovered from a deep overlap are solved in the first round in any
//! case. A body takes part with its row in `bodies`, which then has velocities, and its particles get the change of that in the end.
//!
//! # Friction
//!
//! Friction in positions (`friction`) is limited by the impulse that the positions gave, which depends on how deep the two were when the substep ended. So the
//! impulse `P` that restitution has added to a manifold causes friction here, at its centre of pressure: the slip there is reduced by an impulse of at most
//! `μ P`, with the effective mass there. Friction in positions starts anew then.
//!
//! # Drags
//!
//! Planar friction as a drag between body colliders, after restitution: while two touch, a share of their relative velocity along and across the contact
//! plane is lost in each second ([`PlanarDrag`]).
//!
//! The relative velocity `v` at the centre of pressure is reduced by an impulse there with the effective mass that the two would have as points, so that a
//! box that slides on a plane slows down as `v (1 - along)^t`:
//!
//! ```text
//! J = -s v / (1/M_a + 1/M_b)        s = 1 - (1 - drag)^h
//! ```
//!
//! for each of the two parts of `v`, and in the same way for the relative spin about the normal. It is equal and opposite, so momenta are kept; and never
//! more than stops the two there.

use glam::Vec3;

use super::super::restitution::{ImpactRound, is_elastic, quiet, rebound, threshold};
use super::BodyContactSolver;
use super::bodies::{Bodies, SHIFT, TURN, WideBody as Rows};
use super::loose::ScalarBody;
use super::normal_solve::{ContactPatch, PatchSide, anchors, skins, solve_normal_impulses};
use super::rigid_state::{BounceStates, ShowStates};
use super::turn::{Matrix, load, tangents};
use super::wide_contact::{Contact, FAR, WideContact};
use crate::constraints::PlanarDrag;
use crate::lanes::{LANES, Lanes, Record, SetLanes, Vector, Work, get, with};
use crate::particles::Particles;

/// Body colliders that take part in an impact. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct ImpactScratch {
    /// For each group a bit for each body collider whose row has velocities; and the groups with any, in the order of their extraction.
    read: Vec<u32>,
    entered: Vec<u32>,
    /// Rows of these groups before that.
    kept: Vec<Record>,
    /// For each group a bit for each body collider whose position is not changed by its bounce.
    stays: Vec<u32>,
    /// Rows of single particles that bounced off body colliders and move on with these; some more than once.
    goes_on: Vec<u32>,
}

impl ImpactScratch {
    fn begin(&mut self, groups: usize) {
        self.entered.clear();
        self.kept.clear();
        self.goes_on.clear();
        for bits in [&mut self.read, &mut self.stays] {
            bits.clear();
            bits.resize(groups, 0);
        }
    }

    /// Whether a row has velocities: that of a body collider in an impact, or of static geometry, which has displacements in all cases.
    fn is_read(&self, row: u32) -> bool {
        let bits = self.read.get(row as usize / LANES);
        bits.is_none_or(|bits| bits >> (row as usize % LANES) & 1 == 1)
    }

    /// Moves a single particle on from where the substep began, with its new velocity.
    pub(super) fn go_on(&mut self, row: u32) {
        self.goes_on.push(row);
    }

    /// Keeps the body collider of a row where the positions have moved it; static geometry is ignored.
    pub(super) fn stay(&mut self, row: u32) {
        if let Some(bits) = self.stays.get_mut(row as usize / LANES) {
            *bits |= 1 << (row as usize % LANES);
        }
    }
}

impl BodyContactSolver {
    /// Begins the impacts of a substep, before the rounds.
    pub(crate) fn begin_impacts(&mut self) {
        self.impacts.begin(self.groups.groups.len());
    }

    /// Whether there are contacts in this step.
    pub(crate) fn any_contacts(&self) -> bool {
        !(self.wide_contacts.is_empty() && self.loose.is_empty())
    }

    /// Number of rows that take part in impacts, static geometry included.
    pub(crate) fn impact_rows(&self) -> usize {
        self.bodies.rows.len()
    }

    /// Solves restitution in one of the rounds, and takes off depenetration speed in the first.
    pub(in crate::collide) fn bounce(
        &mut self,
        particles: &mut Particles,
        round: &mut ImpactRound,
    ) {
        let mut wide_contacts = core::mem::take(&mut self.wide_contacts);
        for wide in &mut wide_contacts {
            round.next();
            let reached = if wide.kept { reached(wide, round) } else { 0 };
            // Manifolds without restitution spread nothing, unless an impact reaches them.
            let (lanes, spread) = if round.is_first() {
                let bounces = wide.kept && wide.elastic != 0;
                let fast = if bounces { fast(wide, &self.contacts, round.h) } else { 0 };
                (wide.depenetrated | fast | reached, fast | reached)
            } else {
                (reached, reached)
            };
            if lanes == 0 {
                continue;
            }
            self.enter(particles, rows(wide, lanes));
            let static_geometry = wide.against_static;
            let stays = wide.depenetrated | static_geometry | !wide.elastic;
            rows(wide, lanes & stays).for_each(|row| self.impacts.stay(row));
            let changed = spread & self.solve_impacts(wide, (lanes, static_geometry), round.h);
            for row in rows(wide, changed) {
                self.mark_body(row, round);
            }
        }
        self.wide_contacts = wide_contacts;
        self.bounce_loose(particles, round);
    }

    /// Records that an impact has changed the velocity of a row, unless nothing can. A contact of a body is not solved exactly: several points are in a limited
    /// number of steps, and friction may change the normal velocity through the rotation.
    pub(super) fn mark_body(&self, row: u32, round: &mut ImpactRound) {
        if self.bodies.is_movable(row as usize) {
            round.mark_inexact(round.body(row));
        }
    }

    /// Ends the impacts of a substep of `h` seconds after the rounds: friction of the added impulses, drags, and the velocities of particles.
    pub(crate) fn end_impacts(&mut self, particles: &mut Particles, h: f32) {
        let mut wide_contacts = core::mem::take(&mut self.wide_contacts);
        for wide in wide_contacts.iter_mut().filter(|wide| wide.kept && wide.elastic != 0) {
            for lane in SetLanes(wide.elastic & !wide.depenetrated) {
                if self.impacts.is_read(wide.a[lane]) && self.impacts.is_read(wide.b[lane]) {
                    rub(wide, lane, &self.contacts, &mut self.bodies, h);
                }
            }
        }
        for wide in wide_contacts.iter().filter(|wide| wide.kept) {
            let slow = dragged(wide, &self.contacts);
            self.enter(particles, rows(wide, slow));
            rows(wide, slow).for_each(|row| self.impacts.stay(row));
            for lane in SetLanes(slow) {
                if let Some(one) = self.contacts.get(wide.number[lane] as usize) {
                    drag(wide, lane, one, &mut self.bodies, h);
                }
            }
        }
        self.wide_contacts = wide_contacts;
        if !self.impacts.entered.is_empty() {
            self.leave(particles, h);
        }
        self.limit_speeds(particles);
    }

    /// Extracts the groups of body colliders in some rows with their velocities, where the substep began, unless they have been. Static geometry is ignored.
    pub(super) fn enter(&mut self, particles: &Particles, rows: impl Iterator<Item = u32>) {
        for row in rows {
            let number = row as usize / LANES;
            let Some(bits) = self.impacts.read.get_mut(number) else { continue };
            let is_new = *bits == 0;
            *bits |= 1 << (row as usize % LANES);
            if !is_new {
                continue;
            }
            let rows = number * LANES..(number + 1) * LANES;
            self.impacts.kept.extend_from_slice(&self.bodies.rows[rows]);
            self.impacts.entered.push(number as u32);
            let (lanes, first) = (self.rigid.lanes(number), number * LANES);
            if lanes != self.groups.groups[number].sound {
                let columns = [&particles.start[..], &particles.velocity];
                self.extract_pose(number, columns, None, !0);
            }
            if lanes != 0 {
                let Self { groups, bodies, rigid, instructions, h, .. } = self;
                let (h, mass) = (*h, &groups.groups[number].mass);
                let (state, wide_swept) = (&rigid.states[number], None);
                let show = ShowStates { mass, state, bodies, first, h, at_start: true, wide_swept };
                with(*instructions, show);
            }
        }
    }

    /// Solves some manifolds of a wide contact, and returns a bit for each that was changed.
    fn solve_impacts(
        &mut self,
        wide: &mut WideContact,
        (lanes, static_geometry): (u32, u32),
        h: f32,
    ) -> u32 {
        let Self { contacts, bodies, instructions, .. } = self;
        let one = |lane: usize| contacts.get(wide.number[lane] as usize);
        let (mut restitution, mut least) = ([0.0; LANES], [0.0; LANES]);
        for lane in SetLanes(lanes) {
            let Some(one) = one(lane) else { continue };
            restitution[lane] = one.combined_material.restitution;
            least[lane] = threshold(one.gravity, h);
        }
        with(
            *instructions,
            RestitutionSolve { wide, lanes, static_geometry, bodies, restitution, least, h },
        )
    }

    /// Applies the velocity changes to the particles, and moves those of body colliders that bounced, in a substep of `h` seconds.
    fn leave(&mut self, particles: &mut Particles, h: f32) {
        self.shared.clear();
        let Particles { position, start, velocity, .. } = particles;
        for number in 0..self.groups.groups.len() {
            let Self { groups, bodies, rigid, instructions, impacts, .. } = self;
            if impacts.read[number] == 0 {
                continue;
            }
            let (lanes, group) = (rigid.lanes(number), &groups.groups[number]);
            if lanes != 0 {
                let bounce = BounceStates {
                    mass: &group.mass,
                    state: &mut rigid.states[number],
                    bodies,
                    first: number * LANES,
                    h,
                    lanes: impacts.read[number],
                    stays: impacts.stays[number],
                };
                with(*instructions, bounce);
            }
            if lanes != group.sound {
                self.apply_pose_delta(number, !lanes, start, Some(velocity));
            }
        }
        let Self { groups, bodies, rigid, shared, impacts, asleep, .. } = self;
        for (row, by) in shared.iter() {
            velocity[row as usize] += by;
        }
        for number in 0..groups.groups.len() {
            let bounced = impacts.read[number] & !impacts.stays[number] & !rigid.lanes(number);
            for lane in SetLanes(bounced) {
                let solid = groups.sound_in(number, lane).map(|solid| &groups.parts[solid]);
                let rows = solid.map_or(0..0, |part| part.entries.clone());
                for row in groups.rows[rows].iter().map(|&row| row as usize) {
                    if position[row].w > 0.0 {
                        let gone = velocity[row].truncate() * h;
                        position[row] = (start[row].truncate() + gone).extend(position[row].w);
                    }
                }
            }
        }
        for row in impacts.goes_on.iter().map(|&row| row as usize) {
            let gone = velocity[row].truncate() * h;
            position[row] = (start[row].truncate() + gone).extend(position[row].w);
        }
        // Body colliders that take part in no impact get their rows back: their result must not depend on their neighbour lanes. So do those that sleep, which keep
        // the pose that was extracted when the step began.
        for (&number, kept) in impacts.entered.iter().zip(impacts.kept.chunks(LANES)) {
            let number = number as usize;
            for (lane, row) in kept.iter().enumerate() {
                if (impacts.read[number] & !asleep[number]) >> lane & 1 == 0 {
                    bodies.rows[number * LANES + lane] = *row;
                }
            }
        }
    }
}

/// A bit for each manifold of a wide contact that bounces.
fn fast(wide: &WideContact, contacts: &[Contact], h: f32) -> u32 {
    let is_fast = |lane: usize| {
        let Some(one) = contacts.get(wide.number[lane] as usize) else { return false };
        let least = threshold(one.gravity, h);
        let pressed = |i: usize| wide.force[i][lane] > 0.0 && wide.approach[i][lane] < -least;
        one.combined_material.restitution > 0.0 && (0..POINTS).any(pressed)
    };
    (0..LANES).fold(0, |bits, lane| bits | u32::from(is_fast(lane)) << lane)
}

/// A bit for each manifold of a wide contact that pressed in this substep and that an impact reaches.
fn reached(wide: &WideContact, round: &ImpactRound) -> u32 {
    let is_reached = |lane: usize| {
        let ends = [wide.a[lane], wide.b[lane]].map(|row| round.body(row));
        wide.sum[lane] > 0.0 && round.reaches(ends)
    };
    (0..LANES).fold(0, |bits, lane| bits | u32::from(is_reached(lane)) << lane)
}

/// The rows in `bodies` of some manifolds of a wide contact.
fn rows(wide: &WideContact, lanes: u32) -> impl Iterator<Item = u32> {
    SetLanes(lanes).flat_map(|lane| [wide.a[lane], wide.b[lane]])
}

/// Limit of points in a manifold.
const POINTS: usize = 4;

/// Impact solve of a wide contact, whose rows have velocities.
struct RestitutionSolve<'a> {
    wide: &'a mut WideContact,
    /// A bit for each manifold to solve; the others are left unchanged.
    lanes: u32,
    /// A bit for each manifold whose second one is static or kinematic geometry.
    static_geometry: u32,
    bodies: &'a mut Bodies,
    restitution: [f32; LANES],
    /// Approach speed of each up to which it does not bounce, m/s.
    least: [f32; LANES],
    h: f32,
}

impl Work for RestitutionSolve<'_> {
    /// A bit for each manifold whose speeds were changed.
    type Output = u32;

    /// Most have two points at the most, as in `normal_solve`; missing points do not affect the others. Solving with the second one fixed or not gives the
    /// same bits.
    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        if L::load(&self.wide.missing[2]).lt(L::splat(FAR)).any() {
            self.solve::<L, 4>()
        } else {
            self.solve::<L, 2>()
        }
    }
}

impl RestitutionSolve<'_> {
    #[inline(always)]
    fn solve<L: Lanes, const POINTS: usize>(self) -> u32 {
        let Self { wide, lanes, static_geometry, bodies, restitution, least, h } = self;
        let (none, lanes) = (L::zero(), L::mask(lanes));
        let mut a = Rows::<L>::load(bodies, &wide.a);
        let mut b = Rows::<L>::load(bodies, &wide.b);
        if wide.fixed {
            // Its anchors are in world axes.
            b.rotation = Matrix::of([none, none, none, L::splat(1.0)]);
        }
        let (static_geometry, share) = (L::mask(static_geometry), L::load(&wide.own));
        let n = load::<L>(&wide.up);
        let (restitution, least) = (L::load(&restitution), L::load(&least));
        let apart = b.centre + load::<L>(&wide.offset) - a.centre;
        let (on_a, on_b) = anchors::<L, POINTS>(wide, &a, Some(&b), apart);
        let radii = [L::load(&wide.radii[0]), L::load(&wide.radii[1])];
        let (t, u) = tangents(n);
        // Rows of static and kinematic geometry have displacements instead of velocities.
        let rate = static_geometry.select(L::splat(1.0 / h), L::splat(1.0));
        let along = n.dot(a.step + a.shift - b.step * rate - b.shift);
        let (turn_a, turn_b) = (a.spin + a.turn, b.spin * rate + b.turn);
        let turn_a = (turn_a.dot(t), turn_a.dot(u));
        let turn_b = (turn_b.dot(t), turn_b.dot(u));
        let (apart_t, apart_u) = (apart.dot(t), apart.dot(u));
        let weight = a.inverse_mass + b.inverse_mass;
        let (own, theirs) = (PatchSide::of_body(&a, t, u), Some(PatchSide::of_body(&b, t, u)));
        let apart = (apart_t, apart_u);
        let mut patch = ContactPatch { weight, a: own, b: theirs, apart, regularisation: none };
        let stiff = patch.about(none, none);
        let (mut c, mut force) = ([none; POINTS], [none; POINTS]);
        let mut at = [(none, none); POINTS];
        let mut fastest = none;
        let skins = skins(wide, n, &radii, (&a, Some(&b)));
        for i in 0..POINTS {
            let (on_a, on_b) = (on_a[i] - skins[0], on_b[i] + skins[1]);
            let arm = on_a.or_else(static_geometry, on_b + (on_a - on_b) * share);
            let (x, y) = (arm.dot(t), arm.dot(u));
            at[i] = (x, y);
            let speed = along + (y * turn_a.0 - x * turn_a.1);
            let speed = speed - ((y - apart_u) * turn_b.0 - (x - apart_t) * turn_b.1);
            let approach = L::load(&wide.approach[i]);
            let touches = lanes.and(approach.lt(L::splat(0.5 * FAR))).and(patch.yields(at[i]));
            let bounces = is_elastic(restitution, approach.abs(), least);
            let wanted = bounces.and(rebound(restitution, approach));
            fastest = fastest.max(touches.and(bounces).and(approach.abs()));
            force[i] = touches.and(L::load(&wide.force[i])) * L::splat(1.0 / h);
            c[i] = touches.select(wanted - speed, L::splat(-FAR));
        }
        patch.regularise(&at);
        // The impulse of a point may become smaller, but not negative.
        let all = solve_normal_impulses(&patch, &c, &at, Some(&force));
        let (mut sum, mut x, mut y) = (none, none, none);
        for i in 0..POINTS {
            let more = all[i] - force[i];
            sum = sum + more;
            x = x + more * at[i].0;
            y = y + more * at[i].1;
        }
        let good = lanes.and(sum.abs().lt(L::splat(1e30)));
        let (sum, x, y) = (good.and(sum), good.and(x), good.and(y));
        // What is taken back of a recovery was reported as a contact all the same.
        let reported = L::mask(!wide.depenetrated).and(sum) * L::splat(h);
        (L::load(&wide.total) + reported).store(&mut wide.total);
        let moved = stiff.times(Vector::new(sum, x, y));
        let mut change = none;
        for i in 0..POINTS {
            change = change.max((moved.x + at[i].0 * moved.y + at[i].1 * moved.z).abs());
            let force = good.select(all[i] * L::splat(h), L::load(&wide.force[i]));
            force.store(&mut wide.force[i]);
        }
        a.shift += n * (sum * a.inverse_mass);
        a.turn += patch.a.turned(x, y);
        let first = [a.shift.with(a.inverse_mass), a.turn.with(none)];
        L::put_records(&mut bodies.rows, &wide.a, first);
        if let Some(side) = &patch.b {
            b.shift -= n * (sum * b.inverse_mass);
            b.turn -= side.turned(x - apart_t * sum, y - apart_u * sum);
            let second = [b.shift.with(b.inverse_mass), b.turn.with(none)];
            L::put_records(&mut bodies.rows, &wide.b, second);
        }
        good.and(quiet(restitution, least, fastest).lt(change)).bits() & 0xFF
    }
}

/// A bit for each manifold of a wide contact that pressed and has a drag.
fn dragged(wide: &WideContact, contacts: &[Contact]) -> u32 {
    let is_dragged = |lane: usize| {
        let one = contacts.get(wide.number[lane] as usize);
        wide.sum[lane] > 0.0
            && one.is_some_and(|one| one.combined_material.drag != PlanarDrag::default())
    };
    (0..LANES).fold(0, |bits, lane| bits | u32::from(is_dragged(lane)) << lane)
}

/// Applies to two bodies the friction of the impulse that restitution has added, as if they were in contact at the centre of pressure alone.
fn rub(wide: &mut WideContact, lane: usize, contacts: &[Contact], bodies: &mut Bodies, h: f32) {
    let Some(contact) = contacts.get(wide.number[lane] as usize) else { return };
    let more = wide.force.iter().map(|force| force[lane]).sum::<f32>() - wide.sum[lane];
    let most = contact.combined_material.friction * more / h;
    // Not a number counts as none.
    if most.is_nan() || most <= 0.0 {
        return;
    }
    // All of the friction of this impact has acted then: what is left of the mean of its impulses would act in flight.
    wide.friction_limit[lane] = 0.0;
    let touch = Touch::of(wide, lane, contact, bodies, h);
    let n = get(&wide.up, lane);
    let slip = touch.past - n * touch.past.dot(n);
    let Some(way) = slip.try_normalize() else { return };
    let impulse = way * -most.min(slip.length() / touch.compliance(way));
    touch.apply(bodies, impulse, Vec3::ZERO);
}

/// Two bodies whose rows have velocities, at the centre of pressure of a contact.
struct Touch {
    rows: [usize; 2],
    bodies: [ScalarBody; 2],
    /// From the centre of each to there, metres.
    levers: [Vec3; 2],
    /// Inverse masses, 1/kg.
    weights: [f32; 2],
    /// Velocity of the first one past the second, m/s.
    past: Vec3,
}

impl Touch {
    fn of(wide: &WideContact, lane: usize, contact: &Contact, bodies: &Bodies, h: f32) -> Self {
        let rows = [wide.a[lane], wide.b[lane]].map(|row| row as usize);
        let arm = get(&wide.arm, lane);
        let (one, mut other) = (ScalarBody::of(bodies, rows[0]), ScalarBody::of(bodies, rows[1]));
        if contact.geometry.is_some() {
            // Rows of static and kinematic geometry have displacements instead of velocities.
            (other.step, other.spin) = (other.step / h, other.spin / h);
        }
        let lever = arm - (other.centre + get(&wide.offset, lane) - one.centre);
        let past = one.velocity_at(arm) - other.velocity_at(lever);
        let weights = rows.map(|row| bodies[row][SHIFT].w);
        Self { rows, bodies: [one, other], levers: [arm, lever], weights, past }
    }

    /// Inverse effective mass along a unit vector, 1/kg.
    fn compliance(&self, along: Vec3) -> f32 {
        let turned = |which: usize| {
            let moment = self.levers[which].cross(along);
            moment.dot(self.bodies[which].spun(moment))
        };
        self.weights[0] + self.weights[1] + turned(0) + turned(1)
    }

    /// Applies an impulse, N·s, and a moment, N·m·s, to the first one, and the opposite ones to the second.
    fn apply(&self, bodies: &mut Bodies, impulse: Vec3, moment: Vec3) {
        let turn =
            |which: usize| self.bodies[which].spun(self.levers[which].cross(impulse) + moment);
        let turns = [turn(0), turn(1)];
        if !(impulse.is_finite() && turns[0].is_finite() && turns[1].is_finite()) {
            return;
        }
        for ((row, weight), (turn, sign)) in
            self.rows.into_iter().zip(self.weights).zip(turns.into_iter().zip([1.0, -1.0]))
        {
            bodies[row][SHIFT] += (impulse * (weight * sign)).extend(0.0);
            bodies[row][TURN] += (turn * sign).extend(0.0);
        }
    }
}

/// Applies drag to two bodies whose rows have velocities, in a substep of `h` seconds.
fn drag(wide: &WideContact, lane: usize, contact: &Contact, bodies: &mut Bodies, h: f32) {
    let touch = Touch::of(wide, lane, contact, bodies, h);
    let n = get(&wide.up, lane);
    let [along, across] = contact.combined_material.drag.lost_in(h);
    let weight = touch.weights[0] + touch.weights[1];
    let mut impulse = Vec3::ZERO;
    let normal = n * touch.past.dot(n);
    for (part, share) in [(touch.past - normal, along), (normal, across)] {
        let Some(way) = part.try_normalize() else { continue };
        impulse -= part * (share / weight).min(1.0 / touch.compliance(way));
    }
    let [one, other] = &touch.bodies;
    let spin = n.dot(one.spin + one.turn - other.spin - other.turn);
    let moment = n * (-along * spin / n.dot(one.spun(n) + other.spun(n)).max(f32::MIN_POSITIVE));
    touch.apply(bodies, impulse, moment);
}
