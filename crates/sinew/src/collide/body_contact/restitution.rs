//! What contacts do to the velocities of body colliders after those are derived: restitution, drags, and taking off what came of an overlap.
//!
//! Restitution is one problem in velocities over all that touch (Moreau's law of impacts). Speed that came of recovering an overlap is taken off.
//!
//! # The law
//!
//! Positions have no elasticity: what is put on a surface leaves it with the speed that it lacked to get there. So with `v⁻` the speeds along the normals
//! before contacts (negative when approaching), `v` those that the positions gave and `P ≥ 0` the impulses of the points that pressed in this substep, the
//! velocities after it obey, at all points at once,
//!
//! ```text
//! P ≥ 0,    v + e v⁻ ≥ 0,    P (v + e v⁻) = 0
//! ```
//!
//! with `e` the restitution where `v⁻` was faster than `2gh`, which gravity alone gives to what lies still, and 0 elsewhere. What was parting may come
//! to approach (`v⁻ > 0`, and others push): it bounces in a later substep. With one `e` everywhere energy changes by `½ Σ P (v⁻ + v) = ½ Σ P v⁻ (1 - e)`,
//! and with `e = 1` by nothing, whatever touches what: a ball into two that touch, a row of balls. It is solved by projected Gauss–Seidel: manifold
//! by manifold, each exactly (`normal_solve`), from the impulses that the positions took, so that one may end with less than it had. Moreau, *Unilateral
//! Contact and Dry Friction in Finite Freedom Dynamics*, 1988.
//!
//! What came out of a deep overlap (see `normal_solve`) is left with no speed along the normal: of the impulse that it got, so much is taken back.
//!
//! # Where
//!
//! All of it happens where the substep began, which is where the normals are from. A normal that had turned meanwhile would not be the one along which
//! the approach was measured: what bounces off obliquely would gain energy each time, and a gas of balls would heat up without end. Moments are kept
//! about that place, too, and so two that bounced off each other go from there with their new velocities, `q = p + h v`, as if they had bounced when the
//! substep began: then that is Verlet's own angular momentum. What is being pushed out of an old overlap stays where it was pushed to, and what bounced off
//! static geometry, where there is no momentum to be kept, at the surface.
//!
//! # Who takes part
//!
//! Impacts spread from what was fast. A manifold is solved if it was fast itself, or if one of its body colliders was changed by more than [`QUIET`]
//! since it was solved last; so a heap on which something falls is asked as far as it is felt, and what is elsewhere changes nothing.
//!
//! # Drags
//!
//! They are the lectures' friction between body colliders, after restitution: while two touch, a share of their velocity along and across each other is
//! lost in each second ([`PlanarDrag`]).
//!
//! What is dragged is what goes past at the centre of the pressure, `v`, by an impulse there of the mass that the two would have as points, so that a
//! box that slides on a plane slows down as `v (1 - along)^t`:
//!
//! ```text
//! J = -s v / (1/M_a + 1/M_b)        s = 1 - (1 - drag)^h
//! ```
//!
//! of each of the two parts of `v`, and the same of how they spin on each other about the normal. It is equal and opposite, so momenta are kept; and
//! never more than stops the two there.

use glam::Vec3;

use super::super::restitution::{is_elastic, rebound, threshold};
use super::BodyContactSolver;
use super::bodies::{Bodies, SHIFT, TURN, WideBody as Rows};
use super::loose::ScalarBody;
use super::normal_solve::{ContactPatch, PatchSide, anchors, skins, solve_normal_impulses};
use super::rigid_state::{BounceStates, ShowStates};
use super::turn::{Matrix, load, tangents};
use super::wide_contact::{Contact, FAR, WideContact};
use crate::constraints::PlanarDrag;
use crate::lanes::{LANES, Lanes, Record, SetLanes, Vector, Work, with};
use crate::particles::Particles;

/// A change of a speed that is none, m/s: below what positions of a metre can hold in a substep.
const QUIET: f32 = 1e-6;
/// Rounds of Gauss and Seidel's, at the most. A row of five takes some thirty; what is left then is inelastic.
const ROUNDS: u32 = 64;

/// Which body colliders are part of an impact. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct ImpactScratch {
    /// A bit for each body collider of each group that has been read with its velocities; and the groups of which there are any, in the order of
    /// that.
    read: Vec<u32>,
    entered: Vec<u32>,
    /// The rows of those as they were before.
    kept: Vec<Record>,
    /// A bit for each body collider of each group that is not moved to where it bounced to.
    stays: Vec<u32>,
    /// A bit for each body collider of each group that was changed in this round, and in the last one.
    changed: Vec<u32>,
    was_changed: Vec<u32>,
}

impl ImpactScratch {
    fn begin(&mut self, groups: usize) {
        self.entered.clear();
        self.kept.clear();
        let Self { read, stays, changed, was_changed, .. } = self;
        for bits in [read, stays, changed, was_changed] {
            bits.clear();
            bits.resize(groups, 0);
        }
    }

    /// A bit for each manifold of a wide contact one of whose body colliders was changed in the last round.
    fn changed_last_round(&self, wide: &WideContact) -> u32 {
        let is_changed = |row: u32| {
            let bits = self.was_changed.get(row as usize / LANES).copied().unwrap_or(0);
            bits >> (row as usize % LANES) & 1
        };
        let lanes = 0..LANES;
        lanes.fold(0, |bits, i| bits | (is_changed(wide.a[i]) | is_changed(wide.b[i])) << i)
    }
}

fn mark(bits: &mut [u32], row: u32) {
    if let Some(bits) = bits.get_mut(row as usize / LANES) {
        *bits |= 1 << (row as usize % LANES);
    }
}

impl BodyContactSolver {
    /// Gives what bounced its velocity.
    pub(crate) fn bounce(&mut self, particles: &mut Particles, h: f32, gravity: f32) {
        let least = threshold(gravity, h);
        self.bounce_loose(particles, h, least);
        self.impacts.begin(self.groups.groups.len());
        let mut wide_contacts = core::mem::take(&mut self.wide_contacts);
        let mut any = false;
        for round in 0..ROUNDS {
            let mut any_changed = false;
            for wide in &mut wide_contacts {
                // What has no restitution is asked once, and hands nothing on, unless an impact reaches it.
                let (lanes, spread) = match round {
                    0 => {
                        let bounces = wide.kept && wide.elastic != 0;
                        let fast = if bounces { fast(wide, &self.contacts, least) } else { 0 };
                        (wide.depenetrated | fast, fast)
                    }
                    _ if wide.kept => {
                        let any_changed = self.impacts.changed_last_round(wide) & pressed(wide);
                        (any_changed, any_changed)
                    }
                    _ => (0, 0),
                };
                if lanes == 0 {
                    continue;
                }
                any = true;
                self.enter(particles, wide, lanes);
                let static_geometry = wide.against_static;
                let stays = wide.depenetrated | static_geometry | !wide.elastic;
                for lane in SetLanes(lanes & stays) {
                    mark(&mut self.impacts.stays, wide.a[lane]);
                    mark(&mut self.impacts.stays, wide.b[lane]);
                }
                let changed = spread & self.solve_impacts(wide, (lanes, static_geometry), least, h);
                any_changed |= changed != 0;
                for lane in SetLanes(changed) {
                    mark(&mut self.impacts.changed, wide.a[lane]);
                    mark(&mut self.impacts.changed, wide.b[lane]);
                }
            }
            let ImpactScratch { changed, was_changed, .. } = &mut self.impacts;
            core::mem::swap(changed, was_changed);
            changed.fill(0);
            if !any_changed {
                break;
            }
        }
        for wide in wide_contacts.iter().filter(|wide| wide.kept) {
            let slow = dragged(wide, &self.contacts);
            if slow == 0 {
                continue;
            }
            any = true;
            self.enter(particles, wide, slow);
            for lane in SetLanes(slow) {
                mark(&mut self.impacts.stays, wide.a[lane]);
                mark(&mut self.impacts.stays, wide.b[lane]);
                if let Some(one) = self.contacts.get(wide.number[lane] as usize) {
                    drag(wide, lane, one, &mut self.bodies, h);
                }
            }
        }
        self.wide_contacts = wide_contacts;
        if any {
            self.leave(particles, h);
        }
        self.limit_speeds(particles);
    }

    /// Reads the body colliders of some manifolds with their velocities, where the substep began, unless they have been.
    fn enter(&mut self, particles: &Particles, wide: &WideContact, lanes: u32) {
        for lane in SetLanes(lanes) {
            for row in [wide.a[lane], wide.b[lane]] {
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
                    let show =
                        ShowStates { mass, state, bodies, first, h, at_start: true, wide_swept };
                    with(*instructions, show);
                }
            }
        }
    }

    /// Solves some manifolds of a wide contact, and says which of them were changed.
    fn solve_impacts(
        &mut self,
        wide: &mut WideContact,
        (lanes, static_geometry): (u32, u32),
        least: f32,
        h: f32,
    ) -> u32 {
        let Self { contacts, bodies, instructions, .. } = self;
        let one = |lane: usize| contacts.get(wide.number[lane] as usize);
        let mut restitution = [0.0; LANES];
        for lane in SetLanes(wide.elastic) {
            restitution[lane] = one(lane).map_or(0.0, |one| one.combined_material.restitution);
        }
        with(
            *instructions,
            RestitutionSolve { wide, lanes, static_geometry, bodies, restitution, least, h },
        )
    }

    /// Changes the velocities of the particles as those of their body colliders were, and where those are that bounced, in a substep of `h` seconds.
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
        let Self { groups, bodies, rigid, shared, impacts, .. } = self;
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
        // Those that take part in none are left as they were read in the substep: it must not matter to them who is beside them.
        for (&number, kept) in impacts.entered.iter().zip(impacts.kept.chunks(LANES)) {
            let number = number as usize;
            for (lane, row) in kept.iter().enumerate() {
                if impacts.read[number] >> lane & 1 == 0 {
                    bodies.rows[number * LANES + lane] = *row;
                }
            }
        }
    }
}

/// A bit for each manifold of a wide contact that bounces.
fn fast(wide: &WideContact, contacts: &[Contact], least: f32) -> u32 {
    let is_fast = |lane: usize| {
        let pressed = |i: usize| wide.force[i][lane] > 0.0 && wide.approach[i][lane] < -least;
        let one = contacts.get(wide.number[lane] as usize);
        one.is_some_and(|one| one.combined_material.restitution > 0.0) && (0..POINTS).any(pressed)
    };
    (0..LANES).fold(0, |bits, lane| bits | u32::from(is_fast(lane)) << lane)
}

/// A bit for each manifold of a wide contact that pressed in this substep.
fn pressed(wide: &WideContact) -> u32 {
    (0..LANES).fold(0, |bits, lane| bits | u32::from(wide.sum[lane] > 0.0) << lane)
}

/// Points of a manifold, at the most.
const POINTS: usize = 4;

/// A wide contact whose body colliders have been read with their velocities.
struct RestitutionSolve<'a> {
    wide: &'a mut WideContact,
    /// A bit for each manifold that it is about; those beside it are left alone.
    lanes: u32,
    /// And one for each whose second one stands.
    static_geometry: u32,
    bodies: &'a mut Bodies,
    restitution: [f32; LANES],
    least: f32,
    h: f32,
}

impl Work for RestitutionSolve<'_> {
    /// A bit for each manifold whose speeds were changed.
    type Output = u32;

    /// Most have two points at the most, as in `normal_solve`; what is missing has no say. What is left out there of a second one that stays where it is
    /// is the same bits.
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
            // Its anchors are in the world's axes.
            b.rotation = Matrix::of([none, none, none, L::splat(1.0)]);
        }
        let (static_geometry, share) = (L::mask(static_geometry), L::load(&wide.own));
        let n = load::<L>(&wide.up);
        let restitution = L::load(&restitution);
        let apart = b.centre + load::<L>(&wide.offset) - a.centre;
        let (on_a, on_b) = anchors::<L, POINTS>(wide, &a, Some(&b), apart);
        let radii = [L::load(&wide.radii[0]), L::load(&wide.radii[1])];
        let (t, u) = tangents(n);
        // What stands was noted with its displacement.
        let rate = static_geometry.select(L::splat(1.0 / h), L::splat(1.0));
        let along = n.dot(a.step + a.shift - b.step * rate - b.shift);
        let (turn_a, turn_b) = (a.spin + a.turn, b.spin * rate + b.turn);
        let turn_a = (turn_a.dot(t), turn_a.dot(u));
        let turn_b = (turn_b.dot(t), turn_b.dot(u));
        let (apart_t, apart_u) = (apart.dot(t), apart.dot(u));
        let own = PatchSide::of(&a.inverse_inertia, t, u);
        let weight = a.inverse_mass + b.inverse_mass;
        let theirs = PatchSide::of(&b.inverse_inertia, t, u);
        let apart = (apart_t, apart_u);
        let patch = ContactPatch { weight, a: own, b: Some(theirs), apart, regularisation: none };
        let stiff = patch.about(none, none);
        let (mut c, mut force) = ([none; POINTS], [none; POINTS]);
        let mut at = [(none, none); POINTS];
        let mut had = Vector::new(none, none, none);
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
            let touches = lanes.and(approach.lt(L::splat(0.5 * FAR)));
            let bounces = is_elastic(restitution, approach.abs(), least);
            let wanted = bounces.and(rebound(restitution, approach));
            fastest = fastest.max(touches.and(bounces).and(approach.abs()));
            force[i] = touches.and(L::load(&wide.force[i])) * L::splat(1.0 / h);
            had += Vector::new(force[i], force[i] * x, force[i] * y);
            c[i] = touches.select(wanted - speed, L::splat(-FAR));
        }
        // What pressed may press less, but not pull.
        let had = stiff.times(had);
        for i in 0..POINTS {
            c[i] = c[i] + (had.x + at[i].0 * had.y + at[i].1 * had.z);
        }
        let all = solve_normal_impulses(&patch, &c, &at);
        let (mut sum, mut x, mut y) = (none, none, none);
        for i in 0..POINTS {
            let more = all[i] - force[i];
            sum = sum + more;
            x = x + more * at[i].0;
            y = y + more * at[i].1;
        }
        let good = lanes.and(sum.abs().lt(L::splat(1e30)));
        let (sum, x, y) = (good.and(sum), good.and(x), good.and(y));
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
        let quiet = L::splat(QUIET).max(fastest * L::splat(QUIET));
        good.and(quiet.lt(change)).bits() & 0xFF
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

/// Drags two that have been read with their velocities, in a substep of `h` seconds.
fn drag(wide: &WideContact, lane: usize, contacts: &Contact, bodies: &mut Bodies, h: f32) {
    let [a, b] = [wide.a[lane], wide.b[lane]].map(|row| row as usize);
    let vector = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
    let (n, arm) = (vector(&wide.up), vector(&wide.arm));
    let (one, mut other) = (ScalarBody::of(bodies, a), ScalarBody::of(bodies, b));
    if contacts.geometry.is_some() {
        // What stands was noted with its displacement.
        (other.step, other.spin) = (other.step / h, other.spin / h);
    }
    let lever = arm - (other.centre + vector(&wide.offset) - one.centre);
    let past = one.velocity_at(arm) - other.velocity_at(lever);
    let weights = [a, b].map(|row| bodies[row][SHIFT].w);
    let weight = weights[0] + weights[1];
    let [along, across] = contacts.combined_material.drag.lost_in(h);
    let mut impulse = Vec3::ZERO;
    let normal = n * past.dot(n);
    for (part, share) in [(past - normal, along), (normal, across)] {
        let Some(way) = part.try_normalize() else { continue };
        let (here, there) = (arm.cross(way), lever.cross(way));
        let stiff = weight + here.dot(one.spun(here)) + there.dot(other.spun(there));
        impulse -= part * (share / weight).min(1.0 / stiff);
    }
    let spin = n.dot(one.spin + one.turn - other.spin - other.turn);
    let moment = n * (-along * spin / n.dot(one.spun(n) + other.spun(n)).max(f32::MIN_POSITIVE));
    let turns = [one.spun(arm.cross(impulse) + moment), other.spun(lever.cross(impulse) + moment)];
    if !(impulse.is_finite() && turns[0].is_finite() && turns[1].is_finite()) {
        return;
    }
    for (row, weight, turn, sign) in
        [(a, weights[0], turns[0], 1.0), (b, weights[1], turns[1], -1.0)]
    {
        bodies[row][SHIFT] += (impulse * (weight * sign)).extend(0.0);
        bodies[row][TURN] += (turn * sign).extend(0.0);
    }
}
