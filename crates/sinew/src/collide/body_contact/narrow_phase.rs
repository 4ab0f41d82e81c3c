//! Narrow phase: the manifolds of a pair.
//!
//! They are taken from the contact cache as long as they are valid, and otherwise computed afresh.
//!
//! # Refresh within a step
//!
//! Pairs that turn and slide on each other are compared again, where they are by then, and kinematic geometry is followed.
//!
//! # Overlap at rest
//!
//! Parts of one body that overlap in its rest shape never touch: a thigh and the pelvis that it goes into, two bones away. They are found when body
//! colliders, bodies or rest places have changed, for the bodies that touch themselves. Those that are very many are segments of a rope, which are
//! compared when they come near each other ([`overlaps_at_rest`](BodyCollider::overlaps_at_rest)).

use glam::{Quat, Vec3};

use super::super::manifold::{ManifoldScratch, collide, is_of_triangles};
use super::super::{ContactFilter, ContactParticipant, Frame, Shape, World};
use super::broad_phase::MissedPairs;
use super::contact_cache::{
    CacheBuilder, CachedManifold, ContactKey, FrictionAnchor, Other, SLACK, sort,
};
use super::groups::BodyGroups;
use super::swept_bounds::SweptBounds;
use super::wide_contact::{Contact, SensorOverlap, TORSIONAL_RADIUS, WideContact, put_manifold};
use super::{BodyCollider, BodyContactSolver};
use crate::kept::Kept;
use crate::lanes::LANES;
use crate::particles::{NO_BODY, Particles};
use crate::pose::pose;

/// Parts of a body up to which all pairs are compared beforehand.
const MOST: usize = 64;

/// By how much two must be clear of each other in the rest shape to touch at all, as a share of how far the smaller one reaches.
const CLEAR: f32 = 0.01;

impl BodyContactSolver {
    /// Computes the manifolds of a pair after a share of the step, or takes them from the cache; within a step those alone that the broad phase
    /// missed.
    #[inline]
    pub(super) fn compare(
        &mut self,
        pair: [usize; 2],
        particles: &Particles,
        world: &World,
        when: (f32, bool),
    ) {
        if pair[1] < self.swept.len() {
            self.compare_solids(pair, particles, world, when);
        } else {
            self.compare_with_geometry(pair, world, when);
        }
    }

    /// Two body colliders.
    fn compare_solids(
        &mut self,
        [a, b]: [usize; 2],
        particles: &Particles,
        world: &World,
        (share, missed): (f32, bool),
    ) {
        let Self { groups, overlaps, swept, contacts, cache, scratch, missed: known, .. } = self;
        let (one, other) = (&swept[a], &swept[b]);
        // Neighbours in a body are near each other all the time.
        let same = one.body == other.body && one.body != NO_BODY;
        if same && groups.share_a_row(a, b) {
            return;
        }
        let filter = world.filter;
        let (own, theirs) = (filter.body(one.body), filter.body(other.body));
        let overlap = || {
            overlaps.has(a, b)
                || world.body_colliders[a].overlaps_at_rest(&world.body_colliders[b], particles)
        };
        let of = |swept: &SweptBounds| (swept.body, swept.row);
        if !filter.rows_may_touch(of(one), of(other)) || same && overlap() {
            return;
        }
        let (solid, with) = (&world.body_colliders[a], &world.body_colliders[b]);
        let key = ContactKey { a: solid.id, other: Other::BodyCollider(with.id), nth: 0 };
        let (part, their) = (&groups.parts[a], &groups.parts[b]);
        let offset = other.origin - one.origin;
        let there = Frame { translation: other.frame.translation + offset, ..other.frame };
        let stuck = part.immovable && their.immovable
            || are_pinned_together(groups, [a, b], [solid, with], [&one.frame, &there]);
        if stuck {
            if !missed {
                cache.carry_over(&key);
            }
            return;
        }
        let (shapes, size) =
            ([&solid.shape, &with.shape], (part.reach, part.reach.min(their.reach)));
        // Joints of bones turn these on their points, and they crept on over the floor when that was held.
        let torsional_radius =
            if groups.is_alone(a) && groups.is_alone(b) { TORSIONAL_RADIUS * size.1 } else { 0.0 };
        let meeting = || Contact {
            a: a as u32,
            b: b as u32,
            geometry: None,
            fixed: None,
            cache_index: 0,
            offset,
            combined_material: own.material.against(&theirs.material),
            reports_events: own.events || theirs.events,
            participants: [participant(groups, a, one.body), participant(groups, b, other.body)],
            colour: 0,
            level: 0,
            size: size.1,
            staleness: 0.0,
            torsional_radius,
        };
        // Within a step nobody is quite where he was expected.
        let off = if missed { one.speculative_margin + other.speculative_margin } else { 0.0 };
        let reach = one.reach_of(other, (1.0 - share) * world.dt) + off;
        let (query, frames) = (PairQuery { key, shapes, size, reach }, [&one.frame, &there]);
        if missed {
            let pair = [a as u32, b as u32];
            query.find_missed(frames, (pair, meeting), known, cache, contacts, &mut scratch.0);
        } else {
            query.narrow_phase(frames, meeting, cache, contacts, &mut scratch.0);
        }
    }

    /// A body collider and static geometry.
    fn compare_with_geometry(
        &mut self,
        [a, b]: [usize; 2],
        world: &World,
        (share, missed): (f32, bool),
    ) {
        let Self {
            groups,
            swept,
            static_geometry,
            contacts,
            cache,
            sensor_overlaps,
            scratch,
            missed: known,
            ..
        } = self;
        let (one, number) = (&swept[a], b - swept.len());
        let (solid, geometry) = (&world.body_colliders[a], &static_geometry[number]);
        let own = world.filter.body(one.body);
        let ignored = matches!(geometry.participant, ContactParticipant::Collider(collider)
            if !world.filter.may_touch_collider(one.body, collider));
        if ignored || !own.layers.meets(geometry.layers) {
            return;
        }
        let frame = geometry.frame_at(world, share);
        let here = geometry.seen_from(&frame, one.origin);
        let reports_events = own.events || geometry.events;
        let participants = || [participant(groups, a, one.body), geometry.participant];
        if geometry.sensor {
            if reports_events {
                let seen_from = one.frame.from_within(&here);
                let (shape, scratch) = (&solid.shape, &mut scratch.0);
                collide(shape, &geometry.shape, &seen_from, 0.0, scratch, &mut |manifold| {
                    if let Some(point) = manifold.points().first() {
                        let normal = frame.turn(manifold.normal);
                        let point = one.origin + one.frame.point(point.on_a);
                        sensor_overlaps.push(SensorOverlap {
                            participants: participants(),
                            point,
                            normal,
                        });
                    }
                });
            }
            return;
        }
        let (part, key) =
            (&groups.parts[a], ContactKey { a: solid.id, other: geometry.other, nth: 0 });
        if part.immovable || is_nailed(groups, a, solid, [&one.frame, &here], &geometry.shape) {
            if !missed {
                cache.carry_over(&key);
            }
            return;
        }
        let row = (groups.padded() + number) as u32;
        let meeting = || Contact {
            a: a as u32,
            b: row,
            geometry: Some(number as u32),
            fixed: geometry.moving.is_none().then_some(here.rotation),
            cache_index: 0,
            offset: here.translation,
            combined_material: geometry.combined_material(&own.material),
            reports_events,
            participants: participants(),
            colour: 0,
            level: 0,
            size: part.reach,
            staleness: 0.0,
            torsional_radius: if groups.is_alone(a) { TORSIONAL_RADIUS * part.reach } else { 0.0 },
        };
        let (shapes, size) = ([&solid.shape, &geometry.shape], (part.reach, part.reach));
        let reach = one.reach((1.0 - share) * world.dt) + geometry.carries(one, world, share);
        let (query, frames) = (PairQuery { key, shapes, size, reach }, [&one.frame, &here]);
        if missed {
            let pair = [a as u32, row];
            query.find_missed(frames, (pair, meeting), known, cache, contacts, &mut scratch.0);
        } else {
            query.narrow_phase(frames, meeting, cache, contacts, &mut scratch.0);
        }
    }
}

/// Whether a segment is pinned in static geometry, or nearer to it than it is thick. What is nailed to a post does not run into it: about its pin a
/// contact has no lever, and to come out there the segment would have to turn by any angle, and flings what hangs on it away.
fn is_nailed(
    groups: &BodyGroups,
    number: usize,
    solid: &BodyCollider,
    [one, geometry]: [&Frame; 2],
    shape: &Shape,
) -> bool {
    let part = &groups.parts[number];
    let pinned = |i: &usize| groups.weighed(part.entries.start + i) == 0.0;
    if part.side.is_some() || !(0..solid.rest.len()).any(|i| pinned(&i)) {
        return false;
    }
    let (low, high) = solid.shape.bounds();
    let thick = 0.5 * (high - low).min_element();
    let is_near =
        |i: usize| shape.nearest(geometry.local(one.point(solid.rest[i]))).distance < thick;
    (0..solid.rest.len()).filter(pinned).any(is_near)
}

/// Whether two segments are pinned in one place, or nearer to each other than they are thick; or one of them there in one that cannot move at all: ropes that
/// hang from one hook. What they overlap by there no turn can mend.
fn are_pinned_together(
    groups: &BodyGroups,
    numbers: [usize; 2],
    solids: [&BodyCollider; 2],
    frames: [&Frame; 2],
) -> bool {
    let parts = numbers.map(|number| &groups.parts[number]);
    let pinned = |of: usize, i: usize| groups.weighed(parts[of].entries.start + i) == 0.0;
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

/// A body collider, and another one or static geometry.
struct PairQuery<'a> {
    key: ContactKey,
    shapes: [&'a Shape; 2],
    /// How far the first one reaches, and the smaller one of the two, metres.
    size: (f32, f32),
    /// How near they may come in the step, metres.
    reach: f32,
}

impl PairQuery<'_> {
    /// Adds their manifolds to the cache, and those that may come to press to the contacts, each as `meeting` has it.
    #[inline(always)]
    fn narrow_phase(
        self,
        [a, b]: [&Frame; 2],
        meeting: impl Fn() -> Contact,
        cache: &mut CacheBuilder,
        contacts: &mut Vec<Contact>,
        scratch: &mut ManifoldScratch,
    ) {
        let Self { key, shapes, size: (size, smaller), reach } = self;
        let here = a.from_within(b);
        let content_hashes = [shapes[0].content_hash(), shapes[1].content_hash()];
        let of_triangles = is_of_triangles(shapes[0]) || is_of_triangles(shapes[1]);
        let known = cache.lookup(&key).filter(|known| known.content_hashes == content_hashes);
        let holds = known.and_then(|known| {
            Some((known.staleness(&here, (size, smaller), reach)?, known.is_near(&here, reach)))
        });
        if let Some((staleness, near)) = holds {
            let cache_index = cache.keep(near);
            if near {
                contacts.push(Contact { staleness, cache_index, ..meeting() });
            }
            return;
        }
        let (first, far) = (cache.now.len(), reach + SLACK * smaller);
        collide(shapes[0], shapes[1], &here, far, scratch, &mut |manifold| {
            let (key, manifold) = (ContactKey { nth: manifold.part, ..key }, *manifold);
            let (reach, friction_anchor) =
                (if of_triangles { -1.0 } else { far }, FrictionAnchor::default());
            cache.now.push(CachedManifold {
                key,
                content_hashes,
                manifold,
                seen_from: here,
                reach,
                friction_anchor,
            });
        });
        // Triangles come in any order.
        if of_triangles {
            sort(&mut cache.now[first..]);
        }
        for place in first..cache.now.len() {
            cache.inherit_anchor(place, b);
            if cache.now[place].is_near(&here, reach) {
                contacts.push(Contact { cache_index: place as u32, ..meeting() });
            }
        }
    }

    /// The same within a step, for those that were not found before; the pair as it is in [`Contact`].
    fn find_missed(
        self,
        [a, b]: [&Frame; 2],
        (pair, meeting): ([u32; 2], impl Fn() -> Contact),
        missed: &MissedPairs,
        cache: &mut CacheBuilder,
        contacts: &mut Vec<Contact>,
        scratch: &mut ManifoldScratch,
    ) {
        let Self { key, shapes, reach, .. } = self;
        let here = a.from_within(b);
        let content_hashes = [shapes[0].content_hash(), shapes[1].content_hash()];
        let of_triangles = is_of_triangles(shapes[0]) || is_of_triangles(shapes[1]);
        if !of_triangles && missed.has(pair, 0, contacts, cache) {
            return;
        }
        collide(shapes[0], shapes[1], &here, reach, scratch, &mut |manifold| {
            if of_triangles && missed.has(pair, manifold.part, contacts, cache) {
                return;
            }
            let (key, manifold) = (ContactKey { nth: manifold.part, ..key }, *manifold);
            let (reach, friction_anchor) =
                (if of_triangles { -1.0 } else { reach }, FrictionAnchor::default());
            let one = CachedManifold {
                key,
                content_hashes,
                manifold,
                seen_from: here,
                reach,
                friction_anchor,
            };
            contacts.push(Contact { cache_index: cache.insert_missed(one), ..meeting() });
        });
    }
}

/// Who a body collider is, for the report.
pub(super) fn participant(groups: &BodyGroups, number: usize, body: u32) -> ContactParticipant {
    if body == NO_BODY {
        let first = groups.parts[number].entries.start;
        ContactParticipant::Particle(groups.rows.get(first).copied().unwrap_or_default())
    } else {
        ContactParticipant::Body(body)
    }
}

impl BodyContactSolver {
    /// Compares those again that have turned against each other, or slid on each other, by more than their points are good for; at the places where
    /// this substep began, after a share of the step.
    ///
    /// Where the points of a manifold are farther apart than others may have come nearer than those meanwhile (`WideContact::elsewhere`), nothing
    /// touches, and nothing is compared: so most that fly past each other never are.
    pub(super) fn refresh_manifolds(&mut self, world: &World, share: f32) {
        let Self {
            groups,
            swept,
            static_geometry,
            contacts,
            wide_contacts,
            bodies,
            scratch,
            cache,
            ..
        } = self;
        let frame = |number: usize| bodies.frame(groups.place(number), groups.parts[number].centre);
        let time = (1.0 - share) * world.dt;
        for wide in wide_contacts {
            // Nearly all are as they were: that is one question.
            if (0..LANES).fold(true, |good, lane| good & holds(wide, lane)) {
                continue;
            }
            for lane in 0..LANES {
                if holds(wide, lane) {
                    continue;
                }
                let Some(one) = contacts.get_mut(wide.number[lane] as usize) else { continue };
                let known = &mut cache.now[one.cache_index as usize];
                // Those of several are found once a step.
                if known.reach < 0.0 {
                    continue;
                }
                let (a, b) = (one.a as usize, one.b as usize);
                let (shape, own) = (&world.body_colliders[a].shape, frame(a));
                let geometry = one.geometry.map(|number| &static_geometry[number as usize]);
                let (other, theirs, centre, reach) = match geometry {
                    Some(geometry) => {
                        let theirs = geometry.frame_at(world, share);
                        let theirs = geometry.seen_from(&theirs, swept[a].origin);
                        one.offset = theirs.translation;
                        let reach =
                            swept[a].reach(time) + geometry.carries(&swept[a], world, share);
                        (&geometry.shape, theirs, Vec3::ZERO, reach)
                    }
                    None => {
                        let theirs = frame(b);
                        let reach = swept[a].reach_of(&swept[b], time);
                        let translation = theirs.translation + one.offset;
                        (
                            &world.body_colliders[b].shape,
                            Frame { translation, ..theirs },
                            groups.parts[b].centre,
                            reach,
                        )
                    }
                };
                let seen_from = own.from_within(&theirs);
                known.manifold = Default::default();
                (known.seen_from, known.reach) = (seen_from, reach);
                collide(shape, other, &seen_from, reach, &mut scratch.0, &mut |manifold| {
                    known.manifold = *manifold;
                });
                put_manifold(wide, lane, (one, known), [groups.parts[a].centre, centre]);
            }
        }
    }

    /// Where kinematic geometry is when a substep begins, as seen from what may touch them.
    pub(super) fn follow_kinematic_geometry(&mut self, world: &World, from: f32) {
        let Self { contacts, wide_contacts, static_geometry, swept, .. } = self;
        if static_geometry.iter().all(|geometry| geometry.moving.is_none()) {
            return;
        }
        for wide in wide_contacts {
            for lane in 0..LANES {
                let Some(one) = contacts.get(wide.number[lane] as usize) else { continue };
                let Some(geometry) = one.geometry.map(|number| &static_geometry[number as usize])
                else {
                    continue;
                };
                if geometry.moving.is_some() {
                    let frame = geometry.frame_at(world, from);
                    let here = geometry.seen_from(&frame, swept[one.a as usize].origin).translation;
                    for (to, from) in wide.offset.iter_mut().zip(here.to_array()) {
                        to[lane] = from;
                    }
                }
            }
        }
    }
}

/// Whether a manifold is still good for what it is needed for.
#[inline(always)]
fn holds(wide: &WideContact, lane: usize) -> bool {
    let staleness = wide.staleness[lane];
    (staleness < 1.0) | (wide.elsewhere[lane] * staleness < wide.predicted_gap[lane])
}

/// The pairs that overlap at rest. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct RestOverlaps {
    /// Numbers of body colliders, the lower first; sorted.
    pairs: Vec<[u32; 2]>,
    /// [Edits](Particles::edits) of the particles when they were found; `None` when body colliders have changed since.
    seen: Option<u64>,
    /// Body and number of each body collider; where those of the body at hand are at rest, and the boxes about them.
    body_colliders: Vec<(u32, u32)>,
    frames: Vec<(u32, Frame, (Vec3, Vec3))>,
    scratch: Kept<ManifoldScratch>,
}

impl RestOverlaps {
    /// Has them looked for anew.
    pub(super) fn reset(&mut self) {
        self.seen = None;
    }

    /// Whether two body colliders of one body overlap at rest, as far as that was found beforehand.
    #[inline]
    pub(super) fn has(&self, a: usize, b: usize) -> bool {
        !self.pairs.is_empty() && self.pairs.binary_search(&[a as u32, b as u32]).is_ok()
    }

    /// Finds them, if anything has changed.
    pub(super) fn update(
        &mut self,
        body_colliders: &[BodyCollider],
        groups: &BodyGroups,
        particles: &Particles,
        filter: &ContactFilter,
    ) {
        if self.seen == Some(particles.edits()) {
            return;
        }
        self.seen = Some(particles.edits());
        self.pairs.clear();
        self.body_colliders.clear();
        if particles.rest.is_empty() {
            return;
        }
        for (number, (solid, part)) in body_colliders.iter().zip(&groups.parts).enumerate() {
            // A row may be gone.
            let first = solid.rows.first().and_then(|&row| particles.body.get(row as usize));
            let body = first.copied().unwrap_or(NO_BODY);
            if part.sound && filter.body(body).with_itself {
                self.body_colliders.push((body, number as u32));
            }
        }
        self.body_colliders.sort_unstable();
        let all = core::mem::take(&mut self.body_colliders);
        for own in all.chunk_by(|one, other| one.0 == other.0) {
            if (2..=MOST).contains(&own.len()) {
                self.compare(own, body_colliders, groups, particles);
            }
        }
        self.body_colliders = all;
        self.pairs.sort_unstable();
    }

    /// Compares the body colliders of one body with each other.
    fn compare(
        &mut self,
        own: &[(u32, u32)],
        body_colliders: &[BodyCollider],
        groups: &BodyGroups,
        particles: &Particles,
    ) {
        let Self { frames, pairs, scratch, .. } = self;
        frames.clear();
        for &(_, number) in own {
            let solid = &body_colliders[number as usize];
            let points = solid.rows.iter().zip(&*solid.rest);
            let points = points.map(|(&row, &rest)| (particles.rest[row as usize], rest, 1.0));
            // Without a place at rest there is no frame either.
            if let Some(contacts) = pose(points, Quat::IDENTITY) {
                let frame = Frame::new(contacts.translation, contacts.rotation);
                frames.push((number, frame, solid.shape.bounds_in(&frame)));
            }
        }
        for (i, &(a, frame_a, bounds_a)) in frames.iter().enumerate() {
            for &(b, frame_b, bounds_b) in &frames[i + 1..] {
                let [one, other] = [a, b].map(|number| number as usize);
                let apart =
                    bounds_a.0.cmpgt(bounds_b.1).any() || bounds_b.0.cmpgt(bounds_a.1).any();
                if apart || groups.share_a_row(one, other) {
                    continue;
                }
                let (shape, with) = (&body_colliders[one].shape, &body_colliders[other].shape);
                let clear = CLEAR * groups.parts[one].reach.min(groups.parts[other].reach);
                let (here, mut overlap) = (frame_a.from_within(&frame_b), false);
                collide(shape, with, &here, clear, &mut scratch.0, &mut |manifold| {
                    overlap |= manifold.points().iter().any(|point| point.distance < clear);
                });
                if overlap {
                    pairs.push([a.min(b), a.max(b)]);
                }
            }
        }
    }
}
