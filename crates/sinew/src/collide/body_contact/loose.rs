//! Contacts of body colliders with single particles that belong to none, and with the edges and triangles between them
//! ([`features`](crate::collide::features)): the sphere of the particle's radius against the shape, two-way.

use glam::{Mat3, Vec3, Vec4};

use super::super::features::{Corners, Features, Reach, ShapeBeside};
use super::super::friction::friction_share;
use super::super::impact::ContactParticipant;
use super::super::material::CombinedMaterial;
use super::super::nearby::Nearby;
use super::super::pressed::{Aggregate, PressedCloth, Push};
use super::super::recovery::{limit_depth, recovery, split_depth};
use super::super::restitution::{ImpactRound, elastic_gain, is_elastic, spreads, threshold};
use super::super::shape::Shape;
use super::super::surface_point::{SupportPlane, SurfacePath, SurfacePoint, each};
use super::super::world::World;
use super::bodies::{Bodies, CENTRE, ROTATION, SHIFT, TURN, rotation};
use super::groups::BodyGroups;
use super::narrow_phase::participant;
use super::normal_solve::LEAST_LEVER;
use super::swept_bounds::SweptBounds;
use super::turn::Symmetric;
use super::{BodyContactSolver, ContactEvent};
use crate::lanes::{Number, Vector};
use crate::particles::{NO_BODY, Particles, Places};

/// Limit of the total mass of the single particles that touch a body collider, as a share of its mass, up to which neighbours are pushed along with them
/// ([`PressedCloth::aggregate`]). In the two scenes of `TURNS` (`body_contact`) without, and with 10, 30 and 100 %: 29, 3.6, 3.3 and 3.3 %, in 1.9, 2.7, 2.4
/// and 2.7 ms; 116, 5.4, 4.2 and 4.3 %, in 2.9, 3.4, 3.4 and 3.7 ms.
const AGGREGATED: f32 = 0.3;

/// The number of particles that are pushed along follows from the displacement of the pushed one, up to this multiple of the body collider's own approach. A
/// cloth that is draped over a body is pulled onto it by its own tension: there the body does not move, and each particle is pushed alone. A sheet that falls
/// on nine crates moves by 146, 29 and 26 mm/s in the third to the fifth second if all of each push counts, and by 8, 3 and 3 with this limit, root mean
/// square, from tick to tick.
const BODY_APPROACH: f32 = 8.0;

/// Share of free fall from which on a body counts as falling. At less it is at rest on something else, and what other contacts leave of its fall is rounding, or
/// the load of what lies on it: times the ratio of the masses that flung a sheet on crates about at 2 m/s, at four substeps.
const LEAST_LOAD: f32 = 0.05;

/// Distance from the path that its velocity gave it, as a share of that, up to which nothing has moved a particle in a substep.
const OFF_PATH: f32 = 0.01;

/// Contacts of body colliders with single particles. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Loose {
    pairs: Vec<LooseContact>,
    /// The same, as numbers of body colliders and of particles or middles of features.
    near: Vec<(u32, SurfacePoint)>,
    corners: Corners,
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
    /// Whether it falls, and is not at rest on something else ([`LEAST_LOAD`]).
    falls: bool,
    /// Number of lighter particles that it touches.
    touching: u32,
}

/// A particle, an edge or a triangle near a body collider.
#[derive(Clone, Copy, Debug)]
struct LooseContact {
    solid: u32,
    /// The particle; or that point of a feature which is nearest to the body collider in this substep.
    at: SurfacePoint,
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
    /// A plane between a feature and the body collider, by the last search.
    plane: SupportPlane,
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
        self.pairs.iter().flat_map(|near| near.at.rows())
    }

    /// Lists the pairs of single particles or features and body colliders whose bounds overlap in this step. Within a step only those body colliders have
    /// their features found again that have left the bounds they had, which are `outside`; those of others depend on nothing that happens elsewhere.
    pub(super) fn broad_phase(
        &mut self,
        swept: &[SweptBounds],
        groups: &BodyGroups,
        particles: &Particles,
        world: &World,
        (nearby, features): (&Nearby, &Features),
        outside: Option<&[u32]>,
    ) {
        let Self { pairs, near, rows, body_colliders, open, .. } = self;
        near.clear();
        if let Some(outside) = outside {
            let stays = |pair: &&LooseContact| {
                !pair.at.is_particle() && outside.binary_search(&pair.solid).is_err()
            };
            near.extend(pairs.iter().filter(stays).map(|pair| (pair.solid, pair.at.middle())));
        }
        pairs.clear();
        rows.clear();
        body_colliders.clear();
        open.clear();
        let filter = world.filter;
        let reach = |row: usize| reach_of(particles, world, row as u32);
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
        if rows.is_empty() && features.is_empty() {
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
                    near.push((number, SurfacePoint::particle(row)));
                }
            }
        }
        if !features.is_empty() {
            self.find_features(swept, particles, world, (nearby, features), outside);
        }
        let Self { pairs, near, .. } = self;
        near.sort_unstable_by_key(|&(solid, at)| (solid, at.order()));
        pairs.extend(near.iter().map(|&(solid, at)| {
            let row = at.first();
            let (body, theirs) = (particles.body[row as usize], swept[solid as usize].body);
            let who = if body == NO_BODY {
                ContactParticipant::Particle(row)
            } else {
                ContactParticipant::Body(body)
            };
            let (own, other) = (filter.body(body), filter.body(theirs));
            LooseContact {
                solid,
                at,
                combined_material: other.material.against(&own.material),
                reports_events: own.events || other.events,
                participants: [who, participant(groups, solid as usize, theirs)],
                force: 0.0,
                push: None,
                plane: SupportPlane::default(),
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
        self.pairs.iter().filter(|near| near.force > 0.0).flat_map(|near| near.at.rows())
    }

    /// Adds the features whose bounds overlap those of a body collider in this step, unless the body collider is blunt there, or flat.
    fn find_features(
        &mut self,
        swept: &[SweptBounds],
        particles: &Particles,
        world: &World,
        (nearby, features): (&Nearby, &Features),
        outside: Option<&[u32]>,
    ) {
        let Self { near, corners, .. } = self;
        let is_searched = |number: usize| {
            outside.is_none_or(|outside| outside.binary_search(&(number as u32)).is_ok())
        };
        let near_shapes = nearby.to_shapes();
        let reach = |row: u32| {
            let most = reach_of(particles, world, row) - particles.radius[row as usize];
            Reach { most, likely: most }
        };
        for body in features.bodies().filter(|&body| near_shapes.has(body)) {
            let row = features.first_row(body);
            features.collect(body, particles, reach, corners);
            for (number, one) in swept.iter().enumerate().filter(|(_, swept)| swept.sound) {
                let may_touch = world.filter.rows_may_touch((body, row), (one.body, one.row));
                if !(is_searched(number) && may_touch) {
                    continue;
                }
                let likely = (one.velocity.length() + world.g() * world.dt) * world.dt;
                let beside = ShapeBeside {
                    shape: &world.body_colliders[number].shape,
                    bounds: one.bounds,
                    frame: one.frame,
                    origin: one.origin,
                    reach: Reach { most: likely + one.speculative_margin, likely },
                };
                features.find_beside(body, &beside, particles, corners, |feature, _| {
                    let mut rows = feature.rows().iter();
                    if rows.all(|&row| particles.radius[row as usize] > 0.0) {
                        near.push((number as u32, feature.middle()));
                    }
                });
            }
        }
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
        let passes =
            [false, true].into_iter().flat_map(|again| (0..count).map(move |i| (again, i)));
        for (again, number) in passes {
            let near = &mut pairs[number];
            let s = near.solid as usize;
            let is_first = turn == 0 && !again;
            let is_feature = !near.at.is_particle();
            if is_first {
                (near.force, near.push) = (0.0, None);
            } else if again && near.push.is_none() || near.left == near.at.path(particles).now {
                continue;
            }
            let Some(frame) = ShapeFrame::keep(&mut frame, near.solid, particles, groups, bodies)
            else {
                continue;
            };
            let (at, body) = (frame.at, ScalarBody::of(bodies, frame.at));
            let shape = &world.body_colliders[s].shape;
            // A feature is located anew until it touches.
            if is_feature && near.force == 0.0 {
                let paths = near.at.corner_paths(particles);
                if !near.locate((shape, frame, &body), &paths, &particles.radius) {
                    near.at = near.at.middle();
                    near.left = near.at.path(particles).now;
                    continue;
                }
            }
            let path = near.at.path(particles);
            near.left = path.now;
            let Approach { lift, way, from, to } = frame.approach(&body, &path);
            let radius = near.at.thickness(near.at.radius(&particles.radius, 0), from.distance(to));
            let (w, inverse_mass) = (path.now.w, bodies[at][SHIFT].w);
            let row = near.at.main_row();
            let Some(touch) = shape.touch(from, to, radius) else {
                let push = near.push.filter(|_| again);
                let aggregate = push.and_then(|push| cloth.aggregate(particles, row, push));
                if let Some(aggregate) = aggregate {
                    let gap = shape.nearest(to).distance - radius;
                    near.take_back(particles, &aggregate, (bodies, at), gap);
                }
                continue;
            };
            let touch = limit_depth(touch, shape, (from, to, radius), recovery(h, world.g()));
            let Some(mut touch) = touch else { continue };
            let n = frame.rotation * touch.normal;
            let n = n + body.turn.cross(n);
            // What is recovered of an old overlap with a feature is no velocity.
            let approach = touch.normal.dot(from - to);
            let (new, old) = split_depth(touch.depth, approach);
            if is_feature && w > 0.0 && old > 0.0 {
                touch.depth = new;
                near.at.shift(&mut Places::all(particles), n * old);
                near.left = near.at.path(particles).now;
                if touch.depth <= 0.0 {
                    continue;
                }
            }
            let path = near.at.path(particles);
            let (q, p) = (path.now, path.start);
            let gone = q.truncate() - p;
            let body_approach = gone.dot(n) - way.dot(n);
            let distance = touch.depth.min(BODY_APPROACH * body_approach);
            let push = presses[s].push((inverse_mass, w), (n, distance));
            // An old overlap is recovered by the particle alone, at a bounded speed: overlapping aggregates would each recover it again.
            let push = push.filter(|_| 2.0 * approach > touch.depth);
            let aggregate = push.and_then(|push| cloth.aggregate(particles, row, push));
            // Of what is pushed along by the load on a body that does not fall, the mean approach is stopped, and no more: what hangs still beside a particle
            // that is pulled onto the body would be flung away. The next pass moves the particle by what is left, alone.
            let limited = push.is_some_and(|push| push.distance > distance) && !presses[s].falls;
            let approaches = match aggregate {
                Some(all) if limited => body_approach - all.displacement(particles, row, n),
                _ => f32::INFINITY,
            };
            let aggregate = aggregate.filter(|_| !(limited && again) && approaches > 0.0);
            // Moments are about where the substep began, which is what Verlet keeps; those of cloth that moves along about its middle.
            let about = match aggregate {
                Some(_) => {
                    let middle = SurfacePoint::particle(row).path(particles);
                    middle.start + (middle.origin - path.origin)
                }
                None => p,
            };
            let lever = about + lift - body.centre;
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
            let mut depth =
                if aggregate.is_some() { touch.depth.min(approaches) } else { touch.depth };
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
                aggregate.apply_impulse(particles, row, impulse);
                pressed.extend(aggregate.members.iter().map(|&(row, _)| row));
            } else {
                near.at.apply_impulse(&mut Places::all(particles), impulse);
                pressed.extend(near.at.rows().filter(|_| near.at.is_particle()));
            }
            bodies[at][SHIFT] -= (impulse * inverse_mass).extend(0.0);
            bodies[at][TURN] -= body.spun(lever.cross(impulse)).extend(0.0);
            if near.force == 0.0 {
                // Until velocities are derived, the column holds those that led into the prediction. What is pinned is moved without them.
                let velocity = near.at.velocity(particles);
                let own = if w > 0.0 { velocity } else { gone / h };
                near.approach = n.dot(own - body.predicted_velocity_at(lever, h));
                let off = (gone - velocity * h).length_squared();
                near.alone = aggregate.is_none()
                    && near.at.is_particle()
                    && w > 0.0
                    && off <= OFF_PATH * OFF_PATH * gone.length_squared()
                    && touch.depth <= (1.0 + OFF_PATH) * approach;
            } else {
                near.alone = false;
            }
            near.left = near.at.path(particles).now;
            near.force += force;
            near.normal = n;
            near.arm = lever;
            near.total += force;
            near.point = path.origin + near.left.truncate() - n * radius;
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
            let touches = |at: &SurfacePoint| {
                let Approach { from, to, .. } = frame.approach(&body, &at.path(particles));
                shape.touch(from, to, particles.radius[at.first() as usize]).is_some()
            };
            let single = own.iter().map(|near| near.at).filter(SurfacePoint::is_particle);
            let moves = shift.w > 0.0;
            let lighter = single.filter(|at| {
                moves && AGGREGATED * particles.position[at.first() as usize].w > shift.w
            });
            let touching = lighter.filter(|at| touches(at)).count() as u32;
            let fall = world.gravity * (h * h) + shift.truncate();
            let least = LEAST_LOAD * world.gravity.length_squared() * (h * h);
            let falls = fall.dot(world.gravity) > least;
            presses[solid as usize] = Pressing { fall, falls, touching };
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

/// How far from its position a particle may touch something in this step, metres.
fn reach_of(particles: &Particles, world: &World, row: u32) -> f32 {
    let speed = particles.velocity[row as usize].truncate().length();
    particles.radius[row as usize] + (speed + world.g() * world.dt) * world.dt
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
#[derive(Clone, Copy)]
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

    /// Whether a feature whose corners move along these paths stays in front of a plane that the shape is behind, by its thickness after a displacement. A
    /// bound: it may be so even if this does not show it.
    fn is_apart(
        &self,
        body: &ScalarBody,
        plane: &SupportPlane,
        paths: &[SurfacePath; 3],
        thickness: impl Fn(f32) -> f32,
    ) -> bool {
        let SupportPlane { normal, offset } = *plane;
        // As in `approach`, with the turn by contacts on the side of the plane.
        let along = self.rotation * normal;
        let along = along + body.turn.cross(along);
        let offset = offset - normal.dot(self.centre);
        let (drift, spin) = ((body.step + body.shift).length(), body.spin.length());
        let turn = spin + 0.5 * spin * spin + body.turn.length();
        let centre = body.centre + body.step + body.shift;
        paths.iter().all(|path| {
            let q = path.now.truncate();
            let arm = q + (path.origin - self.origin) - centre;
            let moved = (q - path.start).length() + drift + turn * arm.length();
            let distance = along.dot(arm) - offset;
            let rounding = 1e-5 * (arm.length() + offset.abs());
            distance > thickness(moved) + moved + rounding
        })
    }

    /// Relative motion of a particle, or of a point of a feature, and the body collider.
    #[inline]
    fn approach(&self, body: &ScalarBody, path: &SurfacePath) -> Approach {
        let (q, p) = (path.now.truncate(), path.start);
        let lift = path.origin - self.origin;
        let arm = q + lift - (body.centre + body.step + body.shift);
        let way = (q - p) - body.moved(arm);
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
        aggregate.apply_impulse(particles, self.at.main_row(), n * -force);
        bodies[at][SHIFT] += (n * (force * inverse_mass)).extend(0.0);
        bodies[at][TURN] += (turn * force).extend(0.0);
        self.force -= force;
        self.total -= force;
        self.left = self.at.path(particles).now;
    }

    /// Moves the point of a feature to where that is nearest to the shape, by the paths of its corners past it. Returns whether the two may touch.
    fn locate(
        &mut self,
        (shape, frame, body): (&Shape, &ShapeFrame, &ScalarBody),
        paths: &[SurfacePath; 3],
        radius: &[f32],
    ) -> bool {
        self.at = self.at.middle();
        let radius = self.at.radius(radius, 0);
        if frame.is_apart(body, &self.plane, paths, |moved| self.at.thickness(radius, moved)) {
            return false;
        }
        let corners = each([0, 1, 2], |k| frame.approach(body, &paths[k]));
        let corners = [each(corners, |one| one.from), each(corners, |one| one.to)];
        self.at.approach((shape, &mut self.plane), corners, radius)
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
            let solid = near.solid as usize;
            let at = self.groups.place(solid);
            let restitution = near.combined_material.restitution;
            let is_reached = round.reaches(near.at.rows().chain([round.body(at as u32)]));
            if !(is_reached || round.is_first() && restitution > 0.0) {
                continue;
            }
            let rows = &self.groups.rows[self.groups.parts[solid].entries.clone()];
            let rows = rows.iter().copied().chain(near.at.rows());
            let least = threshold(round.gravity.greatest(rows), round.h);
            if !(is_reached || is_elastic(restitution, near.approach.abs(), least).any()) {
                continue;
            }
            self.enter(particles, core::iter::once(at as u32));
            let row = near.at.first();
            let stayed = || near.left == particles.position[row as usize];
            if near.alone && stayed() && near.approach < -least {
                self.impacts.go_on(row);
            } else {
                self.impacts.stay(at as u32);
            }
            let (body, elasticity) =
                (ScalarBody::of(&self.bodies, at), (restitution, near.approach, least));
            let past = near.at.velocity(particles) - body.velocity_at(near.arm);
            let weights = (near.at.path(particles).now.w, self.bodies[at][SHIFT].w);
            let least = body.least(self.bodies[at][CENTRE].w);
            let impact = near.impact(weights, &body, past, elasticity, least);
            let Some((impulse, gained)) = impact else { continue };
            near.total += impulse.dot(near.normal) * round.h;
            near.at.apply_impact(particles, impulse);
            self.bodies[at][SHIFT] -= (impulse * weights.1).extend(0.0);
            self.bodies[at][TURN] -= body.spun(near.arm.cross(impulse)).extend(0.0);
            if spreads(elasticity, gained, !is_reached).any() {
                if weights.0 > 0.0 {
                    near.at.rows().for_each(|row| round.mark_inexact(row));
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
