//! Narrow phase: the manifolds of a pair.
//!
//! Manifolds are taken from the contact cache while they are valid, and are otherwise computed. Pairs of boxes are compared eight at a time ([`BoxPairs`]):
//! they are queued, with all pairs after them, until there are enough.
//!
//! # Refresh within a step
//!
//! Manifolds of pairs that turn or slide on each other are computed again at their present poses, and kinematic geometry is moved along.

use glam::Vec3;

use super::super::body_collider::BodyCollider;
use super::super::frame::Frame;
use super::super::impact::ContactParticipant;
use super::super::manifold::{BoxPairs, Manifold, ManifoldScratch, collide, is_of_triangles};
use super::super::shape::Shape;
use super::super::world::World;
use super::BodyContactSolver;
use super::contact_cache::{CachedManifold, ContactKey, FrictionAnchor, Other, SLACK};
use super::groups::{BodyGroups, CompiledCollider};
use super::sensors::SensorPath;
use super::static_geometry::StaticGeometry;
use super::swept_bounds::SweptBounds;
use super::wide_contact::{Contact, TORSIONAL_RADIUS, WideContact, put_manifold};
use crate::lanes::{SetLanes, set};
use crate::particles::{NO_BODY, Particles};

/// Squared difference of two normals up to which they are those of one face.
const SAME_FACE: f32 = 1e-6;

/// Limit of queued pairs, so that their data stay in the fastest cache.
const MAX_PENDING: usize = 64;

/// Queued pairs, and the buffers to compute them. Scratch.
#[derive(Default)]
pub(super) struct NarrowPhase {
    pending: Vec<Comparison>,
    boxes: BoxPairs,
    /// Wide contact and lane of each pair of boxes whose manifold has become stale within a step, the first one's frame in the coordinates of the second, and the
    /// distance up to which they may touch, metres.
    stale: Vec<(usize, usize, Frame, f32)>,
    manifolds: ManifoldScratch,
    /// Manifolds of a missed pair.
    missed: Vec<Manifold>,
}

impl BodyContactSolver {
    /// Computes the manifolds of pairs when a step begins, or takes them from the cache; with `is_new`, lists those of dormant pairs.
    pub(super) fn compare_all(
        &mut self,
        pairs: &[[u32; 2]],
        particles: &Particles,
        world: &World,
        is_new: bool,
    ) {
        for &pair in pairs {
            let Some(query) = self.query(pair, particles, world, None) else { continue };
            let (from, source) = self.find_source(&query, world);
            let NarrowPhase { pending, .. } = &mut self.narrow_phase.0;
            // Manifolds are added in the order of the pairs: pairs after queued boxes are queued, too.
            if pending.is_empty() && !matches!(source, ManifoldSource::BoxPair(_)) {
                let first = self.add_manifolds(&query, from, &source, &[], world);
                self.note_dormant(pair, first, is_new);
                continue;
            }
            pending.push(Comparison { query, from, source });
            if pending.len() >= MAX_PENDING {
                self.add_pending(world, is_new);
            }
        }
        self.add_pending(world, is_new);
    }

    /// Searches the cache for the manifolds of a query. Returns their first position there, and where the manifolds of this step come from.
    #[inline(always)]
    fn find_source(&mut self, query: &PairQuery, world: &World) -> (usize, ManifoldSource) {
        let PairQuery { pair, ref key, ref here, size, reach, immovable } = *query;
        let from = self.cache.seek(key);
        if immovable {
            return (from, ManifoldSource::CarriedOver);
        }
        let shapes = shapes(pair, world, &self.static_geometry);
        if have_triangles(shapes) {
            let cached = self.cache.of_pair(from, key);
            let is_valid = |cached: &CachedManifold| {
                cached.content_hashes == content_hashes(shapes)
                    && cached.staleness(here, size, reach).is_some()
            };
            let valid = !cached.is_empty() && cached.iter().all(is_valid);
            let count = cached.len();
            let source = ManifoldSource::CachedTriangles { count };
            return (from, if valid { source } else { ManifoldSource::Computed });
        }
        let cached = self.cache.cached(from, key);
        let valid = cached.filter(|cached| cached.content_hashes == content_hashes(shapes));
        let valid = valid.and_then(|cached| {
            let staleness = cached.staleness(here, size, reach)?;
            Some(ManifoldSource::Cached { staleness, near: cached.is_near(here, reach) })
        });
        let boxes = &mut self.narrow_phase.0.boxes;
        let mut compared = || {
            let boxes = boxes.push(shapes, here, reach + SLACK * size.1);
            boxes.map_or(ManifoldSource::Computed, ManifoldSource::BoxPair)
        };
        (from, valid.unwrap_or_else(&mut compared))
    }

    /// Compares the queued boxes, and adds the manifolds of all queued pairs.
    fn add_pending(&mut self, world: &World, is_new: bool) {
        let NarrowPhase { boxes, pending, .. } = &mut self.narrow_phase.0;
        let (mut boxes, mut pending) = (core::mem::take(boxes), core::mem::take(pending));
        let found = boxes.collide(self.instructions);
        for Comparison { query, from, source } in pending.drain(..) {
            let first = self.add_manifolds(&query, from, &source, found, world);
            self.note_dormant(query.pair, first, is_new);
        }
        boxes.clear();
        (self.narrow_phase.0.boxes, self.narrow_phase.0.pending) = (boxes, pending);
    }

    /// Adds the manifolds of a pair to the cache, and those near enough to press to the contacts. Returns the position of the first in the cache.
    #[inline(always)]
    fn add_manifolds(
        &mut self,
        query: &PairQuery,
        from: usize,
        source: &ManifoldSource,
        found: &[Manifold],
        world: &World,
    ) -> usize {
        let PairQuery { pair, ref key, ref here, size, reach, .. } = *query;
        self.cache.advance_to(key);
        let first = self.cache.now.len();
        match *source {
            ManifoldSource::CarriedOver => self.cache.carry_over(key, from),
            ManifoldSource::Cached { staleness, near } => {
                self.keep_manifold(pair, from, (staleness, near), world);
            }
            ManifoldSource::CachedTriangles { count } => {
                for at in from..from + count {
                    let cached = self.cache.before(at);
                    let staleness = cached.staleness(here, size, reach).unwrap_or_default();
                    let near = cached.is_near(here, reach);
                    self.keep_manifold(pair, at, (staleness, near), world);
                }
            }
            ManifoldSource::BoxPair(_) | ManifoldSource::Computed => {
                let axes = self.second_frame(pair, world, 0.0).rotation;
                let Self { cache, static_geometry, narrow_phase, .. } = self;
                let (shapes, far) = (shapes(pair, world, static_geometry), reach + SLACK * size.1);
                let mut add = |manifold: &Manifold| {
                    cache.add(query.cached(shapes, manifold, far));
                };
                if let ManifoldSource::BoxPair(number) = *source {
                    let manifold = &found[number];
                    if !manifold.points().is_empty() {
                        add(manifold);
                    }
                } else {
                    let [a, b] = shapes;
                    collide(a, b, here, far, &mut narrow_phase.0.manifolds, &mut add);
                }
                cache.hand_on_anchors(from, first, &axes);
                for place in first..self.cache.now.len() {
                    if self.cache.now[place].is_near(here, reach) {
                        let contact = self.contact(pair, (place as u32, 0.0), world, 0.0);
                        self.contacts.push(contact);
                    }
                }
            }
        }
        first
    }

    /// Keeps the manifold at `at` of the last step's cache, and adds a contact if it is near enough to press.
    #[inline(always)]
    fn keep_manifold(
        &mut self,
        pair: [u32; 2],
        at: usize,
        (staleness, near): (f32, bool),
        world: &World,
    ) {
        let cache_index = self.cache.keep(at, near);
        if near {
            let contact = self.contact(pair, (cache_index, staleness), world, 0.0);
            self.contacts.push(contact);
        }
    }

    /// Lists the manifolds of a dormant pair, from `first` on, as ones to carry over without a query in the next steps, if the set of dormant islands is new.
    #[inline(always)]
    fn note_dormant(&mut self, pair: [u32; 2], first: usize, is_new: bool) {
        if is_new && self.dormant.0.are_both_dormant(&self.groups, pair) {
            self.cache.note_dormant(first);
        }
    }

    /// The frame of the second of a pair, from the first one's origin; of kinematic geometry after a fraction `share` of the step.
    #[inline(always)]
    fn second_frame(&self, [a, b]: [u32; 2], world: &World, share: f32) -> Frame {
        let (one, b) = (&self.swept[a as usize], b as usize);
        match b.checked_sub(self.swept.len()) {
            None => {
                let other = &self.swept[b];
                let offset = other.origin - one.origin;
                Frame { translation: other.frame.translation + offset, ..other.frame }
            }
            Some(number) => {
                let geometry = &self.static_geometry[number];
                geometry.seen_from(&geometry.frame_at(world, share), one.origin)
            }
        }
    }

    /// The contact of a manifold in the cache with the given staleness, after a fraction `share` of the step.
    #[inline(always)]
    fn contact(
        &self,
        [a, b]: [u32; 2],
        (cache_index, staleness): (u32, f32),
        world: &World,
        share: f32,
    ) -> Contact {
        let Self { groups, swept, static_geometry, .. } = self;
        let (first, second) = (a as usize, b as usize);
        let (one, part) = (&swept[first], &groups.parts[first]);
        let cached = self.cache.now.get(cache_index as usize);
        let normal = cached.map_or(Vec3::ZERO, |cached| cached.manifold.normal);
        let (own, is_alone) = (world.filter.body(one.body), groups.is_alone(first));
        let participant_a = participant(groups, first, one.body);
        let gravity = |part: &CompiledCollider| {
            world.row_gravity.greatest(groups.rows[part.entries.clone()].iter().copied())
        };
        // Joints turn bones on their contact points: bones whose turn was held crept over the floor.
        let torsional =
            |is_alone: bool, size: f32| if is_alone { TORSIONAL_RADIUS * size } else { 0.0 };
        let Some(number) = second.checked_sub(swept.len()) else {
            let (other, their) = (&swept[second], &groups.parts[second]);
            let theirs = world.filter.body(other.body);
            let size = part.reach.min(their.reach);
            return Contact {
                a,
                b,
                geometry: None,
                fixed: None,
                cache_index,
                offset: other.origin - one.origin,
                combined_material: own.material.against(&theirs.material),
                gravity: gravity(part).max(gravity(their)),
                reports_events: own.events || theirs.events,
                participants: [participant_a, participant(groups, second, other.body)],
                colour: 0,
                level: 0,
                size,
                staleness,
                torsional_radius: torsional(is_alone && groups.is_alone(second), size),
                normal: other.frame.turn(normal),
                goes_on: false,
            };
        };
        let geometry = &static_geometry[number];
        let here = self.second_frame([a, b], world, share);
        Contact {
            a,
            b: (groups.padded() + number) as u32,
            geometry: Some(number as u32),
            fixed: geometry.moving.is_none().then_some(here.rotation),
            cache_index,
            offset: here.translation,
            combined_material: geometry.combined_material(&own.material),
            gravity: gravity(part),
            reports_events: own.events || geometry.events,
            participants: [participant_a, geometry.participant],
            colour: 0,
            level: 0,
            size: part.reach,
            staleness,
            torsional_radius: torsional(is_alone, part.reach),
            normal: here.rotation * normal,
            goes_on: false,
        }
    }

    /// Query of a pair at the start of the step, or after the fraction `missed` of it if the broad phase missed the pair. `None` for pairs that never
    /// collide, and for sensors, whose overlaps are recorded.
    #[inline(always)]
    fn query(
        &mut self,
        pair: [u32; 2],
        particles: &Particles,
        world: &World,
        missed: Option<f32>,
    ) -> Option<PairQuery> {
        if (pair[1] as usize) < self.swept.len() {
            self.query_solids(pair, particles, world, missed)
        } else {
            self.query_geometry(pair, world, missed.unwrap_or(0.0))
        }
    }

    /// Query of two body colliders.
    #[inline(always)]
    fn query_solids(
        &self,
        pair: [u32; 2],
        particles: &Particles,
        world: &World,
        missed: Option<f32>,
    ) -> Option<PairQuery> {
        let Self { groups, overlaps, swept, .. } = self;
        let [a, b] = pair.map(|number| number as usize);
        let (one, other) = (&swept[a], &swept[b]);
        // Neighbours in a body are near each other at all times.
        let same = one.body == other.body && one.body != NO_BODY;
        if same && groups.share_a_row(a, b) {
            return None;
        }
        let overlap = || {
            overlaps.has(a, b)
                || world.body_colliders[a].overlaps_at_rest(&world.body_colliders[b], particles)
        };
        let of = |swept: &SweptBounds| (swept.body, swept.row);
        if !world.filter.rows_may_touch(of(one), of(other)) || same && overlap() {
            return None;
        }
        let (solid, with) = (&world.body_colliders[a], &world.body_colliders[b]);
        let (part, their) = (&groups.parts[a], &groups.parts[b]);
        let there = self.second_frame(pair, world, 0.0);
        // Within a step, bodies deviate from their extrapolated paths.
        let off = missed.map_or(0.0, |_| one.speculative_margin + other.speculative_margin);
        Some(PairQuery {
            pair,
            key: ContactKey { a: solid.id, other: Other::BodyCollider(with.id), nth: 0 },
            here: one.frame.from_within(&there),
            size: (part.reach, part.reach.min(their.reach)),
            reach: one.reach_of(other, (1.0 - missed.unwrap_or(0.0)) * world.dt) + off,
            immovable: part.immovable && their.immovable
                || are_pinned_together(groups, [a, b], [solid, with], [&one.frame, &there]),
        })
    }

    /// Query of a body collider and static or kinematic geometry.
    fn query_geometry(&mut self, pair: [u32; 2], world: &World, share: f32) -> Option<PairQuery> {
        let here = self.second_frame(pair, world, share);
        let Self { groups, swept, static_geometry, sensors, narrow_phase, .. } = self;
        let (a, number) = (pair[0] as usize, pair[1] as usize - swept.len());
        let (one, part) = (&swept[a], &groups.parts[a]);
        let (solid, geometry) = (&world.body_colliders[a], &static_geometry[number]);
        let own = world.filter.body(one.body);
        let ignored = matches!(geometry.participant, ContactParticipant::Collider(collider)
            if !world.filter.may_touch_collider(one.body, collider));
        if ignored || !own.layers.interacts_with(geometry.layers) {
            return None;
        }
        let seen_from = one.frame.from_within(&here);
        if geometry.sensor {
            if own.events || geometry.events {
                let sum = solid.rest.iter().map(|&rest| one.frame.point(rest)).sum::<Vec3>();
                let path = SensorPath {
                    participants: [participant(groups, a, one.body), geometry.participant],
                    number: pair[0],
                    shapes: [solid.shape.clone(), geometry.shape.clone()],
                    frames: [one.frame, here],
                    mean: sum / solid.rest.len() as f32,
                    carried: geometry.carried(one, world, share),
                    origin: one.origin,
                };
                sensors.note(path, one, &mut narrow_phase.0.manifolds);
            }
            return None;
        }
        Some(PairQuery {
            pair,
            key: ContactKey { a: solid.id, other: geometry.other, nth: 0 },
            here: seen_from,
            size: (part.reach, part.reach),
            reach: one.reach((1.0 - share) * world.dt) + geometry.carries(one, world, share),
            immovable: part.immovable
                || is_pinned_inside(groups, a, solid, [&one.frame, &here], &geometry.shape),
        })
    }

    /// Computes the manifolds of a pair that the broad phase missed, after a fraction `share` of the step, except those that were found before.
    pub(super) fn compare_missed(
        &mut self,
        pair: [u32; 2],
        particles: &Particles,
        world: &World,
        share: f32,
    ) {
        let Some(query) =
            self.query(pair, particles, world, Some(share)).filter(|it| !it.immovable)
        else {
            return;
        };
        let contact = self.contact(pair, (0, 0.0), world, share);
        let reach = query.reach;
        let shapes = shapes(pair, world, &self.static_geometry);
        let (of_triangles, pair) = (have_triangles(shapes), [contact.a, contact.b]);
        if !of_triangles && self.missed.has(pair, 0, &self.contacts, &self.cache) {
            return;
        }
        let [a, b] = shapes;
        let NarrowPhase { manifolds, missed: found, .. } = &mut self.narrow_phase.0;
        found.clear();
        collide(a, b, &query.here, reach, manifolds, &mut |manifold| found.push(*manifold));
        let axes =
            contact.fixed.unwrap_or_else(|| self.second_frame(query.pair, world, share).rotation);
        for number in 0..self.narrow_phase.0.missed.len() {
            let manifold = &self.narrow_phase.0.missed[number];
            let contact = Contact { normal: axes * manifold.normal, ..contact };
            if of_triangles && self.missed.has(pair, manifold.part, &self.contacts, &self.cache)
                || self.is_missed_ghost(&contact, manifold, world)
            {
                continue;
            }
            let cache_index = self.cache.insert_missed(query.cached(shapes, manifold, reach));
            self.contacts.push(Contact { cache_index, ..contact });
        }
    }
}

/// A pair to compare: a body collider, and another one or static geometry.
struct PairQuery {
    /// Number of the body collider, and of the second; static geometry has numbers after those of body colliders.
    pair: [u32; 2],
    key: ContactKey,
    /// The first one's frame in the coordinates of the second.
    here: Frame,
    /// Reach of the first, and of the smaller of the two, metres.
    size: (f32, f32),
    /// Distance up to which they may touch in the step, metres.
    reach: f32,
    /// Whether neither can be moved by the other.
    immovable: bool,
}

/// A queued pair, and where its manifolds come from.
struct Comparison {
    query: PairQuery,
    /// Position of its first manifold of the step before.
    from: usize,
    source: ManifoldSource,
}

/// Where the manifolds of a pair come from.
enum ManifoldSource {
    /// Carried over unchanged; no contact results.
    CarriedOver,
    /// The cached manifold is valid, with its staleness; `near` if it may press in this step.
    Cached { staleness: f32, near: bool },
    /// A number of cached manifolds of triangles are valid.
    CachedTriangles { count: usize },
    /// Two boxes: the index of the pair in their queue.
    BoxPair(usize),
    /// To be computed.
    Computed,
}

impl PairQuery {
    /// A manifold of the pair as a cache entry, computed up to the distance `reach`, metres.
    #[inline(always)]
    fn cached(&self, shapes: [&Shape; 2], manifold: &Manifold, reach: f32) -> CachedManifold {
        CachedManifold {
            key: ContactKey { nth: manifold.part, ..self.key },
            content_hashes: content_hashes(shapes),
            manifold: *manifold,
            seen_from: self.here,
            reach: if have_triangles(shapes) { -reach } else { reach },
            friction_anchor: FrictionAnchor::default(),
        }
    }
}

/// The shapes of a pair: of two body colliders, or of one and static geometry.
#[inline(always)]
fn shapes<'a>(
    pair: [u32; 2],
    world: &World<'a>,
    static_geometry: &'a [StaticGeometry],
) -> [&'a Shape; 2] {
    let [a, b] = pair.map(|number| number as usize);
    let solid = &world.body_colliders[a].shape;
    match b.checked_sub(world.body_colliders.len()) {
        None => [solid, &world.body_colliders[b].shape],
        Some(number) => [solid, &static_geometry[number].shape],
    }
}

/// Whether the pair has one manifold for each plane of triangles.
#[inline(always)]
fn have_triangles([a, b]: [&Shape; 2]) -> bool {
    is_of_triangles(a) || is_of_triangles(b)
}

#[inline(always)]
fn content_hashes([a, b]: [&Shape; 2]) -> [u64; 2] {
    [a.content_hash(), b.content_hash()]
}

/// Centres of the two of a contact in their own frames; zero for static geometry.
#[inline(always)]
fn centres(groups: &BodyGroups, one: &Contact) -> [Vec3; 2] {
    let second =
        if one.geometry.is_none() { groups.parts[one.b as usize].centre } else { Vec3::ZERO };
    [groups.parts[one.a as usize].centre, second]
}

/// Whether a segment is pinned inside static geometry, or nearer to it than its own thickness. Such a contact is ignored: about its pin it has no lever, so
/// recovering the overlap would turn the segment by any angle and fling what hangs on it.
fn is_pinned_inside(
    groups: &BodyGroups,
    number: usize,
    solid: &BodyCollider,
    [one, geometry]: [&Frame; 2],
    shape: &Shape,
) -> bool {
    let part = &groups.parts[number];
    let pinned = |i: &usize| groups.inverse_mass(part.entries.start + i) == 0.0;
    if part.side.is_some() || !(0..solid.rest.len()).any(|i| pinned(&i)) {
        return false;
    }
    let (low, high) = solid.shape.bounds();
    let thick = 0.5 * (high - low).min_element();
    let is_near =
        |i: usize| shape.nearest(geometry.local(one.point(solid.rest[i]))).distance < thick;
    (0..solid.rest.len()).filter(pinned).any(is_near)
}

/// Whether two segments are pinned at one place, or nearer to each other than their thickness, or one of them is pinned inside an immovable one: ropes that
/// hang from one hook. No turn can resolve their overlap there.
fn are_pinned_together(
    groups: &BodyGroups,
    numbers: [usize; 2],
    solids: [&BodyCollider; 2],
    frames: [&Frame; 2],
) -> bool {
    let parts = numbers.map(|number| &groups.parts[number]);
    let pinned = |of: usize, i: usize| groups.inverse_mass(parts[of].entries.start + i) == 0.0;
    let has_pin = |of: usize| (0..solids[of].rest.len()).any(|i| pinned(of, i));
    if parts.iter().any(|part| part.side.is_some()) || !(has_pin(0) && has_pin(1)) {
        return false;
    }
    let [thick, their] = solids.map(|solid| {
        let (low, high) = solid.shape.bounds();
        0.5 * (high - low).min_element()
    });
    let pins = |of: usize| {
        let (solid, frame) = (solids[of], frames[of]);
        let all = (0..solid.rest.len()).filter(move |&i| pinned(of, i));
        all.map(|i| frame.point(solid.rest[i]))
    };
    let is_in = |pin: Vec3, of: usize, thick: f32| {
        let (shape, frame) = (&solids[of].shape, frames[of]);
        parts[of].immovable && shape.nearest(frame.local(pin)).distance < thick
    };
    pins(0)
        .any(|pin| is_in(pin, 1, thick) || pins(1).any(|other| pin.distance(other) < thick + their))
        || pins(1).any(|pin| is_in(pin, 0, their))
}

/// Replaces the manifold of a contact within a step, unless the face that the two touch goes on and the new manifold is one of its rim.
fn refresh(
    wide: &mut WideContact,
    lane: usize,
    (one, cached): (&Contact, &mut CachedManifold),
    (manifold, seen_from, reach): (&Manifold, Frame, f32),
    centres: [Vec3; 2],
) {
    let was = &cached.manifold;
    let is_of_rim =
        manifold.normal.distance_squared(was.normal) > SAME_FACE || manifold.axial != was.axial;
    if one.goes_on && is_of_rim {
        return;
    }
    (cached.manifold, cached.seen_from, cached.reach) = (*manifold, seen_from, reach);
    put_manifold(wide, lane, (one, cached), centres);
}

/// The contact participant that a body collider is reported as.
pub(super) fn participant(groups: &BodyGroups, number: usize, body: u32) -> ContactParticipant {
    if body == NO_BODY {
        let first = groups.parts[number].entries.start;
        ContactParticipant::Particle(groups.rows.get(first).copied().unwrap_or_default())
    } else {
        ContactParticipant::Body(body)
    }
}

impl BodyContactSolver {
    /// Recomputes, at the poses where this substep began after a fraction `share` of the step, the manifolds of pairs that have turned or slid on each other
    /// beyond the validity of their points.
    ///
    /// Manifolds whose points are farther apart than other points can have come nearer meanwhile (`WideContact::other_approach`) are not touching and are not
    /// recomputed: so most pairs that fly past each other never are.
    pub(super) fn refresh_manifolds(&mut self, world: &World, share: f32) {
        let Self {
            groups,
            swept,
            static_geometry,
            contacts,
            wide_contacts,
            bodies,
            narrow_phase,
            cache,
            instructions,
            ..
        } = self;
        let NarrowPhase { boxes, stale, manifolds, .. } = &mut narrow_phase.0;
        boxes.clear();
        stale.clear();
        let frame = |number: usize| bodies.frame(groups.place(number), groups.parts[number].centre);
        let time = (1.0 - share) * world.dt;
        for (number, wide) in wide_contacts.iter_mut().enumerate() {
            for lane in SetLanes(wide.stale) {
                let Some(one) = contacts.get_mut(wide.number[lane] as usize) else { continue };
                let cached = &mut cache.now[one.cache_index as usize];
                // Those with one manifold for each plane of triangles are not computed within a step.
                if cached.is_of_triangle() {
                    continue;
                }
                let (a, b) = (one.a as usize, one.b as usize);
                let (shape, own) = (&world.body_colliders[a].shape, frame(a));
                let geometry = one.geometry.map(|number| &static_geometry[number as usize]);
                let (other, theirs, reach) = match geometry {
                    Some(geometry) => {
                        let theirs = geometry.frame_at(world, share);
                        let theirs = geometry.seen_from(&theirs, swept[a].origin);
                        one.offset = theirs.translation;
                        let reach =
                            swept[a].reach(time) + geometry.carries(&swept[a], world, share);
                        (&geometry.shape, theirs, reach)
                    }
                    None => {
                        let theirs = frame(b);
                        let reach = swept[a].reach_of(&swept[b], time);
                        let translation = theirs.translation + one.offset;
                        (&world.body_colliders[b].shape, Frame { translation, ..theirs }, reach)
                    }
                };
                let seen_from = own.from_within(&theirs);
                if boxes.push([shape, other], &seen_from, reach).is_some() {
                    stale.push((number, lane, seen_from, reach));
                    continue;
                }
                let mut found = Manifold::default();
                collide(shape, other, &seen_from, reach, manifolds, &mut |one| found = *one);
                refresh(
                    wide,
                    lane,
                    (one, cached),
                    (&found, seen_from, reach),
                    centres(groups, one),
                );
            }
        }
        let found = boxes.collide(*instructions);
        for (&(number, lane, seen_from, reach), manifold) in stale.iter().zip(found) {
            let wide = &mut wide_contacts[number];
            let one = &contacts[wide.number[lane] as usize];
            let cached = &mut cache.now[one.cache_index as usize];
            refresh(wide, lane, (one, cached), (manifold, seen_from, reach), centres(groups, one));
        }
    }

    /// Updates the offset of kinematic geometry in its contacts when a substep begins.
    pub(super) fn follow_kinematic_geometry(&mut self, world: &World, from: f32) {
        let Self { contacts, wide_contacts, static_geometry, swept, .. } = self;
        for wide in wide_contacts.iter_mut().filter(|wide| !wide.fixed) {
            for lane in SetLanes(wide.against_static) {
                let one = &contacts[wide.number[lane] as usize];
                let Some(number) = one.geometry else { continue };
                let geometry = &static_geometry[number as usize];
                let frame = geometry.frame_at(world, from);
                let here = geometry.seen_from(&frame, swept[one.a as usize].origin).translation;
                set(&mut wide.offset, lane, here);
            }
        }
    }
}
