//! Contacts of body colliders with single particles that belong to none: the sphere of the particle's radius against the shape, two-way.

use glam::{Mat3, Vec3, Vec4};

use super::super::friction::friction_share;
use super::super::impact::ContactParticipant;
use super::super::material::CombinedMaterial;
use super::super::nearby::Nearby;
use super::super::pressed::{Aggregate, PressedCloth, Push};
use super::super::recovery::{limit_depth, recovery};
use super::super::restitution::{ImpactRound, elastic_gain, is_elastic, spreads, threshold};
use super::super::world::World;
use super::bodies::{Bodies, CENTRE, ROTATION, SHIFT, TURN, rotation};
use super::groups::BodyGroups;
use super::narrow_phase::participant;
use super::normal_solve::LEAST_LEVER;
use super::swept_bounds::SweptBounds;
use super::turn::Symmetric;
use super::{BodyContactSolver, ContactEvent};
use crate::lanes::{Number, Vector};
use crate::particles::{NO_BODY, Particles};

/// Limit of the total mass of the single particles that touch a body collider, as a share of its mass, up to which neighbours are pushed along with them
/// ([`PressedCloth::aggregate`]). In the two scenes of `TURNS` (`body_contact`) without, and with 10, 30 and 100 %: 29, 3.6, 3.3 and 3.3 %, in 1.9, 2.7, 2.4
/// and 2.7 ms; 116, 5.4, 4.2 and 4.3 %, in 2.9, 3.4, 3.4 and 3.7 ms.
const AGGREGATED: f32 = 0.3;

/// The number of particles that are pushed along follows from the displacement of the pushed one, up to this multiple of the body collider's own approach. A
/// cloth that is draped over a body is pulled onto it by its own tension: there the body does not move, and each particle is pushed alone. A sheet that falls
/// on nine crates moves by 146, 29 and 26 mm/s in the third to the fifth second if all of each push counts, and by 8, 3 and 3 with this limit, root mean
/// square, from tick to tick.
const BODY_APPROACH: f32 = 8.0;

/// Distance from the path that its velocity gave it, as a share of that, up to which nothing has moved a particle in a substep.
const OFF_PATH: f32 = 0.01;

/// Contacts of body colliders with single particles. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Loose {
    pairs: Vec<LooseContact>,
    /// The same, as numbers of body colliders and of rows.
    near: Vec<(u32, u32)>,
    /// Rows that the last pass has moved; some more than once.
    pressed: Vec<u32>,
    /// The load of each body collider on single particles.
    presses: Vec<Pressing>,
    /// Particles and body colliders by their lower bound along x.
    rows: Vec<(f32, u32)>,
    body_colliders: Vec<(f32, u32)>,
    open: Vec<u32>,
}

/// Load of a body collider on single particles in a substep, taken at its first pass.
#[derive(Clone, Copy, Debug, Default)]
struct Pressing {
    /// Free fall in the substep, less the displacement by other contacts, metres: the particles below have to carry that.
    fall: Vec3,
    /// Number of lighter particles that it touches.
    touching: u32,
}

/// A particle near a body collider.
#[derive(Clone, Copy, Debug)]
struct LooseContact {
    solid: u32,
    row: u32,
    combined_material: CombinedMaterial,
    reports_events: bool,
    participants: [ContactParticipant; 2],
    /// In this substep: accumulated normal impulse of the positions, kg·m, its normal and lever, and the relative normal velocity before contacts, m/s, negative
    /// when approaching.
    force: f32,
    normal: Vec3,
    arm: Vec3,
    approach: f32,
    /// Accumulated normal impulse of the positions and of impacts, N·s.
    impulse: f32,
    /// Whether the particle came on the path that its velocity gave it, and out of no old overlap: no constraint or other contact had moved it in this substep.
    alone: bool,
    /// How neighbours were pushed along, if they were.
    push: Option<Push>,
    /// Position of the particle after the last pass over this contact.
    left: Vec4,
    /// Sum of the impulses in this step, kg·m.
    total: f32,
    point: Vec3,
}

impl Loose {
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
    }

    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Whether no single particle of this step's world can touch a body collider.
    pub(super) fn none_collide(&self) -> bool {
        self.rows.is_empty()
    }

    /// The body colliders near single particles, once for each pair.
    pub(super) fn bodies(&self) -> impl Iterator<Item = u32> {
        self.pairs.iter().map(|near| near.solid)
    }

    /// The rows of those particles, once for each pair.
    pub(super) fn rows(&self) -> impl Iterator<Item = u32> {
        self.pairs.iter().map(|near| near.row)
    }

    /// Lists the pairs of single particles and body colliders whose bounds overlap in this step.
    pub(super) fn broad_phase(
        &mut self,
        swept: &[SweptBounds],
        groups: &BodyGroups,
        particles: &Particles,
        world: &World,
        nearby: &Nearby,
    ) {
        let Self { pairs, near, rows, body_colliders, open, .. } = self;
        pairs.clear();
        near.clear();
        rows.clear();
        body_colliders.clear();
        open.clear();
        let filter = world.filter;
        let g = world.g();
        let reach = |row: usize| {
            let speed = particles.velocity[row].truncate().length();
            particles.radius[row] + (speed + g * world.dt) * world.dt
        };
        for row in 0..particles.len() {
            let solid = groups.solid.get(row) == Some(&true);
            let takes_part = nearby.to_shapes().has_particle(row, particles.body[row]);
            if particles.radius[row] > 0.0 && !solid && takes_part {
                let low = particles.position(row).x - reach(row);
                if low.is_finite() {
                    rows.push((low, row as u32));
                }
            }
        }
        if rows.is_empty() {
            return;
        }
        let sound = swept.iter().enumerate().filter(|(_, swept)| swept.sound);
        body_colliders.extend(sound.map(|(number, swept)| (swept.bounds.0.x, number as u32)));
        let order = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        rows.sort_unstable_by(order);
        body_colliders.sort_unstable_by(order);
        // A particle has a width, too: body colliders open where it ends, and close where it begins.
        let mut next = 0;
        let widest = rows.iter().map(|&(_, row)| reach(row as usize)).fold(0.0, f32::max) * 2.0;
        for &(low, row) in rows.iter() {
            while let Some(&(_, number)) =
                body_colliders.get(next).filter(|solid| solid.0 <= low + widest)
            {
                open.push(number);
                next += 1;
            }
            open.retain(|&number| swept[number as usize].bounds.1.x >= low);
            let i = row as usize;
            let (place, reach) = (particles.position(i), Vec3::splat(reach(i)));
            let body = particles.body[i];
            for &number in open.iter() {
                let one = &swept[number as usize];
                let (low, high) = (place - reach, place + reach);
                let apart = low.cmpgt(one.bounds.1).any() || high.cmplt(one.bounds.0).any();
                if !apart && filter.rows_may_touch((body, row), (one.body, one.row)) {
                    near.push((number, row));
                }
            }
        }
        near.sort_unstable();
        pairs.extend(near.iter().map(|&(solid, row)| {
            let (body, theirs) = (particles.body[row as usize], swept[solid as usize].body);
            let who = if body == NO_BODY {
                ContactParticipant::Particle(row)
            } else {
                ContactParticipant::Body(body)
            };
            let (own, other) = (filter.body(body), filter.body(theirs));
            LooseContact {
                solid,
                row,
                combined_material: other.material.against(&own.material),
                reports_events: own.events || other.events,
                participants: [who, participant(groups, solid as usize, theirs)],
                force: 0.0,
                push: None,
                left: Vec4::ZERO,
                normal: Vec3::Y,
                arm: Vec3::ZERO,
                approach: 0.0,
                impulse: 0.0,
                alone: false,
                total: 0.0,
                point: Vec3::ZERO,
            }
        }));
    }

    /// Rows that the last [pass](Self::project) has moved, body collider by body collider; some more than once.
    pub(super) fn pressed(&mut self) -> &mut Vec<u32> {
        &mut self.pressed
    }

    /// Rows of particles with an impulse in this substep.
    pub(super) fn pressed_in_substep(&self) -> impl Iterator<Item = u32> {
        self.pairs.iter().filter(|near| near.force > 0.0).map(|near| near.row)
    }

    /// Solves the contacts one after the other; in later passes of a substep those whose particle has moved since. Of a pinned body collider the recovered
    /// overlap moves no point by more than `recover`, metres (`normal_solve`, "Near a pin"): as much as may turn into speed, because no later stage takes
    /// that off.
    pub(super) fn project(
        &mut self,
        particles: &mut Particles,
        groups: &BodyGroups,
        bodies: &mut Bodies,
        world: &World,
        (h, recover): (f32, f32),
        (turn, cloth): (u32, &mut impl PressedCloth),
    ) {
        if turn == 0 {
            self.note_pressing(particles, groups, bodies, world, h);
        }
        let Self { pairs, pressed, presses, .. } = self;
        pressed.clear();
        let mut frame = None;
        let count = pairs.len();
        // Contacts with an aggregate have two passes, since aggregates overlap and push each other's particles.
        for number in 0..2 * count {
            let again = number >= count;
            let near = &mut pairs[number % count];
            let (s, i) = (near.solid as usize, near.row as usize);
            let (q, p) = (particles.position[i], particles.start[i]);
            if turn == 0 && !again {
                (near.force, near.push) = (0.0, None);
            } else if near.left == q || again && near.push.is_none() {
                continue;
            }
            near.left = q;
            let Some(frame) = ShapeFrame::keep(&mut frame, near.solid, particles, groups, bodies)
            else {
                continue;
            };
            let (at, body) = (frame.at, ScalarBody::of(bodies, frame.at));
            let Approach { lift, way, from, to } = frame.approach(&body, particles, i);
            let (w, inverse_mass) = (q.w, bodies[at][SHIFT].w);
            let radius = particles.radius[i];
            let shape = &world.body_colliders[s].shape;
            let Some(touch) = shape.touch(from, to, radius) else {
                let push = near.push.filter(|_| again);
                let aggregate = push.and_then(|push| cloth.aggregate(particles, near.row, push));
                if let Some(aggregate) = aggregate {
                    let gap = shape.nearest(to).distance - radius;
                    near.take_back(particles, &aggregate, (bodies, at), gap);
                }
                continue;
            };
            let recoverable = recovery(h, world.g());
            let touch = limit_depth(touch, shape, (from, to, radius), recoverable);
            let Some(touch) = touch else { continue };
            let n = frame.rotation * touch.normal;
            let n = n + body.turn.cross(n);
            // Moments are about where the substep began, which is what Verlet keeps.
            let lever = p.truncate() + lift - body.centre;
            let body_approach = (q - p).truncate().dot(n) - way.dot(n);
            let distance = touch.depth.min(BODY_APPROACH * body_approach);
            let push = presses[s].push((inverse_mass, w), (n, distance));
            // An old overlap is recovered by the particle alone, at a bounded speed: overlapping aggregates would each recover it again.
            let approach = touch.normal.dot(from - to);
            let push = push.filter(|_| 2.0 * approach > touch.depth);
            let aggregate = push.and_then(|push| cloth.aggregate(particles, near.row, push));
            let weight = |along: Vec3| {
                let moment = lever.cross(along);
                let own = aggregate.map_or(w, |all| all.compliance(along));
                own + inverse_mass + moment.dot(body.spun(moment))
            };
            let stiff = weight(n);
            let pin_reach = bodies[at][CENTRE].w;
            let least = body.least(pin_reach);
            if !(stiff > least && stiff.is_finite() && touch.depth.is_finite()) {
                continue;
            }
            let mut depth = touch.depth;
            if pin_reach > 0.0 {
                let left = (depth + way.dot(n)).max(0.0);
                let swung = body.spun(lever.cross(n)).length() * pin_reach;
                let share = if swung < stiff { 1.0 } else { stiff / swung };
                depth -= left - left.min(recover * share);
                if depth <= 0.0 {
                    continue;
                }
            }
            let force = depth / stiff;
            let slid = way + n * (depth - way.dot(n));
            let slid = slid - n * slid.dot(n);
            let length = slid.length();
            let mut impulse = n * force;
            let along = if length > 0.0 { slid / length } else { Vec3::ZERO };
            if weight(along) > least {
                let most = near.combined_material.friction * force;
                impulse -= along * (length / weight(along)).min(most);
            }
            if !impulse.is_finite() {
                continue;
            }
            if let Some(aggregate) = aggregate {
                near.push = push;
                aggregate.apply_impulse(particles, near.row, impulse);
                pressed.extend(aggregate.members.iter().map(|&(row, _)| row));
            } else {
                particles.position[i] += (impulse * w).extend(0.0);
                pressed.push(near.row);
            }
            bodies[at][SHIFT] -= (impulse * inverse_mass).extend(0.0);
            bodies[at][TURN] -= body.spun(lever.cross(impulse)).extend(0.0);
            if near.force == 0.0 {
                // Until velocities are derived, the column holds those that led into the prediction. What is pinned is moved without them.
                let own = if w > 0.0 { particles.velocity(i) } else { (q - p).truncate() / h };
                near.approach = n.dot(own - body.predicted_velocity_at(lever, h));
                let gone = (q - p).truncate();
                let off = (gone - particles.velocity(i) * h).length_squared();
                near.alone = aggregate.is_none()
                    && w > 0.0
                    && off <= OFF_PATH * OFF_PATH * gone.length_squared()
                    && touch.depth <= (1.0 + OFF_PATH) * approach;
            } else {
                near.alone = false;
            }
            near.left = particles.position[i];
            near.force += force;
            near.normal = n;
            near.arm = lever;
            near.total += force;
            near.point = particles.position(i) - n * radius;
        }
    }

    /// Computes the load of each body collider.
    fn note_pressing(
        &mut self,
        particles: &Particles,
        groups: &BodyGroups,
        bodies: &Bodies,
        world: &World,
        h: f32,
    ) {
        let Self { pairs, presses, .. } = self;
        presses.clear();
        presses.resize(groups.parts.len(), Pressing::default());
        for own in pairs.chunk_by(|one, next| one.solid == next.solid) {
            let solid = own[0].solid;
            let Some(frame) = ShapeFrame::of(solid, particles, groups, bodies) else { continue };
            let (body, shift) = (ScalarBody::of(bodies, frame.at), bodies[frame.at][SHIFT]);
            let shape = &world.body_colliders[solid as usize].shape;
            let touches = |i: usize| {
                let Approach { from, to, .. } = frame.approach(&body, particles, i);
                shape.touch(from, to, particles.radius[i]).is_some()
            };
            let rows = own.iter().map(|near| near.row as usize);
            let moves = shift.w > 0.0;
            let lighter = rows.filter(|&i| moves && AGGREGATED * particles.position[i].w > shift.w);
            let touching = lighter.filter(|&i| touches(i)).count() as u32;
            let fall = world.gravity * (h * h) + shift.truncate();
            presses[solid as usize] = Pressing { fall, touching };
        }
    }

    /// Adds the contact events of this step.
    pub(super) fn note_contact_events(&mut self, contact_events: &mut Vec<ContactEvent>, h: f32) {
        for near in self.pairs.iter_mut().filter(|near| near.reports_events && near.total > 0.0) {
            let (participants, point, normal) = (near.participants, near.point, near.normal);
            contact_events.push(ContactEvent {
                participants,
                point,
                normal,
                impulse: near.total / h,
            });
            near.total = 0.0;
        }
    }
}

/// Frame of a body collider in a substep, for contacts with particles.
struct ShapeFrame {
    solid: u32,
    /// Its row in `bodies`.
    at: usize,
    /// Rotation as extracted, without the turn by contacts.
    rotation: Mat3,
    /// The origin of its particles, metres.
    origin: Vec3,
    /// Its centre in the coordinates of its shape, metres.
    centre: Vec3,
}

/// Relative motion of a particle and a body collider in a substep.
struct Approach {
    /// From the origin of the body collider to that of the particle, metres.
    lift: Vec3,
    /// Displacement of the particle relative to the body collider's material at that point, metres.
    way: Vec3,
    /// Start and end of that in the coordinates of the shape.
    from: Vec3,
    to: Vec3,
}

impl Pressing {
    /// The push on a particle along a unit vector, by `distance` metres or by its share of the load, from the inverse masses of the body collider and of the
    /// particle, 1/kg; `None` if no neighbours are pushed along.
    #[inline]
    fn push(&self, (own, w): (f32, f32), (along, distance): (Vec3, f32)) -> Option<Push> {
        let touching = self.touching.max(1) as f32;
        let mass = AGGREGATED / (own * touching);
        let carried = self.fall.dot(along) * w / (own * touching);
        (mass * w > 1.0 && mass < f32::INFINITY)
            .then(|| Push { distance: distance.max(carried), mass })
    }
}

impl ShapeFrame {
    fn of(solid: u32, particles: &Particles, groups: &BodyGroups, bodies: &Bodies) -> Option<Self> {
        let part = &groups.parts[solid as usize];
        let home = *groups.rows.get(part.entries.start)?;
        let (at, origin) = (groups.place(solid as usize), particles.origin[home as usize]);
        Some(Self {
            solid,
            at,
            rotation: rotation(bodies[at][ROTATION]),
            origin,
            centre: part.centre,
        })
    }

    /// The frame of a body collider, reused if it is the last one.
    #[inline]
    fn keep<'a>(
        last: &'a mut Option<Self>,
        solid: u32,
        particles: &Particles,
        groups: &BodyGroups,
        bodies: &Bodies,
    ) -> Option<&'a Self> {
        if last.as_ref().is_none_or(|last| last.solid != solid) {
            *last = Self::of(solid, particles, groups, bodies);
        }
        last.as_ref()
    }

    /// Relative motion of a particle and the body collider.
    #[inline]
    fn approach(&self, body: &ScalarBody, particles: &Particles, i: usize) -> Approach {
        let (q, p) = (particles.position[i], particles.start[i]);
        let lift = particles.origin[i] - self.origin;
        let arm = q.truncate() + lift - (body.centre + body.step + body.shift);
        let way = (q - p).truncate() - body.moved(arm);
        // In the frame of the body collider, with its turn by contacts to first order.
        let r = &self.rotation;
        let local = |v: Vec3| {
            let v = v - body.turn.cross(v);
            Vec3::new(r.x_axis.dot(v), r.y_axis.dot(v), r.z_axis.dot(v))
        };
        let to = local(arm) + self.centre;
        Approach { lift, way, from: to - local(way), to }
    }
}

impl LooseContact {
    /// Takes back impulse of this substep, as far as the two are apart by `gap`, metres, because other contacts have pushed the particle as well. Impulses
    /// are accumulated, and their sums stay nonnegative.
    fn take_back(
        &mut self,
        particles: &mut Particles,
        aggregate: &Aggregate,
        (bodies, at): (&mut Bodies, usize),
        gap: f32,
    ) {
        let (n, inverse_mass) = (self.normal, bodies[at][SHIFT].w);
        let moment = self.arm.cross(n);
        let turn = ScalarBody::of(bodies, at).spun(moment);
        let stiff = aggregate.compliance(n) + inverse_mass + moment.dot(turn);
        let force = (gap / stiff).min(self.force);
        if !(force > 0.0 && force.is_finite()) {
            return;
        }
        aggregate.apply_impulse(particles, self.row, n * -force);
        bodies[at][SHIFT] += (n * (force * inverse_mass)).extend(0.0);
        bodies[at][TURN] += (turn * force).extend(0.0);
        self.force -= force;
        self.total -= force;
        self.left = particles.position[self.row as usize];
    }

    /// The impulse of an impact with its friction, N·s, on a particle that moves past a body collider with the velocity `past`, m/s, and what it adds to that
    /// along the normal. Takes the inverse masses of the two, 1/kg; near a pin an inverse effective mass of `least` or less counts as none.
    fn impact(
        &mut self,
        (w, inverse_mass): (f32, f32),
        body: &ScalarBody,
        past: Vec3,
        elasticity: (f32, f32, f32),
        least: f32,
    ) -> Option<(Vec3, f32)> {
        let (n, arm) = (self.normal, self.arm);
        // Relative velocity that an impulse causes.
        let moved =
            |impulse: Vec3| impulse * (w + inverse_mass) + body.spun(arm.cross(impulse)).cross(arm);
        let stiff = n.dot(moved(n));
        let gained = elastic_gain(n.dot(past), elasticity, self.impulse * stiff);
        let size = gained / stiff;
        let past = past + moved(n * size);
        let slip = past - n * past.dot(n);
        let way = slip.normalize_or_zero();
        let across = way.dot(moved(way)).max(f32::MIN_POSITIVE);
        let limit = self.combined_material.friction * size.max(0.0) * across;
        // Along the unit vector: a slip whose square underflows has none, and nothing to be divided by.
        let friction = slip.length() * friction_share(slip.length(), limit) / across;
        let impulse = n * size - way * friction;
        if !(stiff > least && impulse.is_finite()) {
            return None;
        }
        self.impulse += size;
        Some((impulse, gained))
    }
}

impl BodyContactSolver {
    /// Solves the contacts with single particles in one of the rounds: in the first one those that are fast, and in all of them those that an impact reaches. A
    /// fast contact may be parting, out of an overlap that the positions have recovered: it takes that back, or it would turn into speed. Slow ones carry loads.
    pub(super) fn bounce_loose(&mut self, particles: &mut Particles, round: &mut ImpactRound) {
        let mut pairs = core::mem::take(&mut self.loose.pairs);
        for near in &mut pairs {
            round.next();
            if near.force <= 0.0 {
                continue;
            }
            if round.is_first() {
                near.impulse = near.force / round.h;
            }
            let (solid, i) = (near.solid as usize, near.row as usize);
            let at = self.groups.place(solid);
            let ends = [near.row, round.body(at as u32)];
            let restitution = near.combined_material.restitution;
            let is_reached = round.reaches(ends);
            if !(is_reached || round.is_first() && restitution > 0.0) {
                continue;
            }
            let rows = &self.groups.rows[self.groups.parts[solid].entries.clone()];
            let rows = rows.iter().chain([&near.row]).copied();
            let least = threshold(round.gravity.greatest(rows), round.h);
            if !(is_reached || is_elastic(restitution, near.approach.abs(), least).any()) {
                continue;
            }
            self.enter(particles, core::iter::once(at as u32));
            if near.alone && near.left == particles.position[i] && near.approach < -least {
                self.impacts.go_on(near.row);
            } else {
                self.impacts.stay(at as u32);
            }
            let (body, elasticity) =
                (ScalarBody::of(&self.bodies, at), (restitution, near.approach, least));
            let past = particles.velocity(i) - body.velocity_at(near.arm);
            let weights = (particles.position[i].w, self.bodies[at][SHIFT].w);
            let least = body.least(self.bodies[at][CENTRE].w);
            let impact = near.impact(weights, &body, past, elasticity, least);
            let Some((impulse, gained)) = impact else { continue };
            near.total += impulse.dot(near.normal) * round.h;
            particles.velocity[i] += (impulse * weights.0).extend(0.0);
            self.bodies[at][SHIFT] -= (impulse * weights.1).extend(0.0);
            self.bodies[at][TURN] -= body.spun(near.arm.cross(impulse)).extend(0.0);
            if spreads(elasticity, gained, !is_reached).any() {
                if weights.0 > 0.0 {
                    round.mark_inexact(near.row);
                }
                self.mark_body(at as u32, round);
            }
        }
        self.loose.pairs = pairs;
    }
}

/// A single row of `bodies`, without lanes.
pub(super) struct ScalarBody {
    pub(super) centre: Vec3,
    pub(super) step: Vec3,
    shift: Vec3,
    pub(super) spin: Vec3,
    pub(super) turn: Vec3,
    inverse_inertia: Symmetric<f32>,
}

impl ScalarBody {
    pub(super) fn of(bodies: &Bodies, row: usize) -> Self {
        let [shift, turn, along, across, centre, step, spin, _] = bodies[row].map(Vec4::truncate);
        let inverse_inertia =
            Symmetric { along: Vector::splat(along), across: Vector::splat(across) };
        Self { centre, step, shift, spin, turn, inverse_inertia }
    }

    /// Displacement since the substep began of the point at `arm` from the centre, metres.
    fn moved(&self, arm: Vec3) -> Vec3 {
        let middle = arm - self.spin.cross(arm) * 0.5;
        self.step + self.shift + self.spin.cross(middle) + self.turn.cross(arm)
    }

    /// Velocity of that point, m/s, if the row has velocities.
    pub(super) fn velocity_at(&self, arm: Vec3) -> Vec3 {
        self.step + self.shift + (self.spin + self.turn).cross(arm)
    }

    /// Compliance at the least lever about a pin, 1/kg, for a body of this reach from its pin.
    fn least(&self, pin_reach: f32) -> f32 {
        let lever = pin_reach * LEAST_LEVER;
        let Vector { x, y, z } = self.inverse_inertia.along;
        (x + y + z) * lever * lever
    }

    /// Velocity of that point without contacts, m/s, if the row has displacements of a substep of `h` seconds.
    fn predicted_velocity_at(&self, arm: Vec3, h: f32) -> Vec3 {
        (self.step + self.spin.cross(arm)) / h
    }

    /// The turn by a moment.
    pub(super) fn spun(&self, v: Vec3) -> Vec3 {
        self.inverse_inertia.times(Vector::splat(v)).into()
    }
}
