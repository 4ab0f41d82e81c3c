//! Two that may come to touch: what is remembered of where they do, as long as that holds, and otherwise what is found afresh.

use super::super::manifold::{Scratch, collide, is_of_triangles};
use super::super::{Frame, Party, Shape, Solid, World};
use super::Solids;
use super::astray::Late;
use super::found::{Found, Sensed};
use super::groups::Groups;
use super::memory::{Grasp, Key, Memory, Other, Remembered, SLACK, sort};
use super::pack::BLUNT;
use super::way::Seen;
use crate::particles::{NO_BODY, Particles};

impl Solids {
    /// Finds the manifolds of a pair after a share of the step, or remembers them; `late`, those that are not known yet.
    #[inline]
    pub(super) fn compare(
        &mut self,
        pair: [usize; 2],
        particles: &Particles,
        world: &World,
        when: (f32, bool),
    ) {
        if pair[1] < self.seen.len() {
            self.compare_solids(pair, particles, world, when);
        } else {
            self.compare_with_stand(pair, world, when);
        }
    }

    /// Two solids.
    fn compare_solids(
        &mut self,
        [a, b]: [usize; 2],
        particles: &Particles,
        world: &World,
        (share, late): (f32, bool),
    ) {
        let Self { groups, overlaps, seen, found, memory, scratch, late: known, .. } = self;
        let (one, other) = (&seen[a], &seen[b]);
        // Neighbours in a body are near each other all the time.
        let same = one.body == other.body && one.body != NO_BODY;
        if same && groups.share_a_row(a, b) {
            return;
        }
        let filter = world.filter;
        let (own, theirs) = (filter.body(one.body), filter.body(other.body));
        let overlap =
            || overlaps.has(a, b) || world.solids[a].overlaps_at_rest(&world.solids[b], particles);
        let of = |seen: &Seen| (seen.body, seen.row);
        if !filter.rows_may_touch(of(one), of(other)) || same && overlap() {
            return;
        }
        let (solid, with) = (&world.solids[a], &world.solids[b]);
        let key = Key { a: solid.id, other: Other::Solid(with.id), nth: 0 };
        let (part, their) = (&groups.parts[a], &groups.parts[b]);
        if part.immovable && their.immovable {
            if !late {
                memory.carry(&key);
            }
            return;
        }
        let offset = other.origin - one.origin;
        let there = Frame { translation: other.frame.translation + offset, ..other.frame };
        let (shapes, size) =
            ([&solid.shape, &with.shape], (part.reach, part.reach.min(their.reach)));
        // Joints of bones turn these on their points, and they crept on over the floor when that was held.
        let blunt = if groups.is_alone(a) && groups.is_alone(b) { BLUNT * size.1 } else { 0.0 };
        let meeting = || Found {
            a: a as u32,
            b: b as u32,
            stand: None,
            still: None,
            memory: 0,
            offset,
            grip: own.material.against(&theirs.material),
            listened: own.events || theirs.events,
            parties: [party(groups, a, one.body), party(groups, b, other.body)],
            colour: 0,
            level: 0,
            size: size.1,
            strain: 0.0,
            blunt,
        };
        // Within a step nobody is quite where he was expected.
        let off = if late { one.beside + other.beside } else { 0.0 };
        let reach = one.reach_of(other, (1.0 - share) * world.dt) + off;
        let (meet, frames) = (Meet { key, shapes, size, reach }, [&one.frame, &there]);
        if late {
            let pair = [a as u32, b as u32];
            meet.find_late(frames, (pair, meeting), known, memory, found, &mut scratch.0);
        } else {
            meet.find(frames, meeting, memory, found, &mut scratch.0);
        }
    }

    /// A solid and what stands.
    fn compare_with_stand(
        &mut self,
        [a, b]: [usize; 2],
        world: &World,
        (share, late): (f32, bool),
    ) {
        let Self { groups, seen, stands, found, memory, sensed, scratch, late: known, .. } = self;
        let (one, number) = (&seen[a], b - seen.len());
        let (solid, stand) = (&world.solids[a], &stands[number]);
        let own = world.filter.body(one.body);
        let ignored = matches!(stand.party, Party::Collider(collider)
            if !world.filter.may_touch_collider(one.body, collider));
        if ignored || !own.layers.meets(stand.layers) {
            return;
        }
        let frame = stand.frame_at(world, share);
        let here = stand.seen_from(&frame, one.origin);
        let listened = own.events || stand.events;
        let parties = || [party(groups, a, one.body), stand.party];
        if stand.sensor {
            if listened {
                let seen_from = one.frame.from_within(&here);
                let (shape, scratch) = (&solid.shape, &mut scratch.0);
                collide(shape, &stand.shape, &seen_from, 0.0, scratch, &mut |manifold| {
                    if let Some(point) = manifold.points().first() {
                        let normal = frame.turn(manifold.normal);
                        let point = one.origin + one.frame.point(point.on_a);
                        sensed.push(Sensed { parties: parties(), point, normal });
                    }
                });
            }
            return;
        }
        let (part, key) = (&groups.parts[a], Key { a: solid.id, other: stand.other, nth: 0 });
        if part.immovable || is_nailed(groups, a, solid, [&one.frame, &here], &stand.shape) {
            if !late {
                memory.carry(&key);
            }
            return;
        }
        let row = (groups.padded() + number) as u32;
        let meeting = || Found {
            a: a as u32,
            b: row,
            stand: Some(number as u32),
            still: stand.moving.is_none().then_some(here.rotation),
            memory: 0,
            offset: here.translation,
            grip: stand.grip(&own.material),
            listened,
            parties: parties(),
            colour: 0,
            level: 0,
            size: part.reach,
            strain: 0.0,
            blunt: if groups.is_alone(a) { BLUNT * part.reach } else { 0.0 },
        };
        let (shapes, size) = ([&solid.shape, &stand.shape], (part.reach, part.reach));
        let reach = one.reach((1.0 - share) * world.dt) + stand.carries(one, world, share);
        let (meet, frames) = (Meet { key, shapes, size, reach }, [&one.frame, &here]);
        if late {
            let pair = [a as u32, row];
            meet.find_late(frames, (pair, meeting), known, memory, found, &mut scratch.0);
        } else {
            meet.find(frames, meeting, memory, found, &mut scratch.0);
        }
    }
}

/// Whether a segment is pinned in what stands, or nearer to it than it is thick. What is nailed to a post does not run into it: about its pin a contact has no
/// lever, and to come out there the segment would have to turn by any angle, and flings what hangs on it away.
fn is_nailed(
    groups: &Groups,
    number: usize,
    solid: &Solid,
    [one, stand]: [&Frame; 2],
    shape: &Shape,
) -> bool {
    let part = &groups.parts[number];
    let pinned = |i: &usize| groups.weighed(part.entries.start + i) == 0.0;
    if part.side.is_some() || !(0..solid.rest.len()).any(|i| pinned(&i)) {
        return false;
    }
    let (low, high) = solid.shape.bounds();
    let thick = 0.5 * (high - low).min_element();
    let is_near = |i: usize| shape.nearest(stand.local(one.point(solid.rest[i]))).distance < thick;
    (0..solid.rest.len()).filter(pinned).any(is_near)
}

/// A solid, and another one or what stands.
struct Meet<'a> {
    key: Key,
    shapes: [&'a Shape; 2],
    /// How far the first one reaches, and the smaller one of the two, metres.
    size: (f32, f32),
    /// How near they may come in the step, metres.
    reach: f32,
}

impl Meet<'_> {
    /// Adds their manifolds to what is remembered, and those that may come to press to what was found, each as `meeting` has it.
    #[inline(always)]
    fn find(
        self,
        [a, b]: [&Frame; 2],
        meeting: impl Fn() -> Found,
        memory: &mut Memory,
        found: &mut Vec<Found>,
        scratch: &mut Scratch,
    ) {
        let Self { key, shapes, size: (size, smaller), reach } = self;
        let here = a.from_within(b);
        let marks = shapes.map(Shape::mark);
        let of_triangles = shapes.into_iter().any(is_of_triangles);
        let known = memory.recall(&key).filter(|known| known.marks == marks);
        let holds = known.and_then(|known| {
            Some((known.strain(&here, (size, smaller), reach)?, known.is_near(&here, reach)))
        });
        if let Some((strain, near)) = holds {
            let memory = memory.keep(near);
            if near {
                found.push(Found { strain, memory, ..meeting() });
            }
            return;
        }
        let (first, far) = (memory.now.len(), reach + SLACK * smaller);
        collide(shapes[0], shapes[1], &here, far, scratch, &mut |manifold| {
            let (key, manifold) = (Key { nth: manifold.part, ..key }, *manifold);
            let (reach, grasp) = (if of_triangles { -1.0 } else { far }, Grasp::default());
            memory.now.push(Remembered { key, marks, manifold, seen_from: here, reach, grasp });
        });
        // Triangles come in any order.
        if of_triangles {
            sort(&mut memory.now[first..]);
        }
        for place in first..memory.now.len() {
            memory.learn(place, b);
            if memory.now[place].is_near(&here, reach) {
                found.push(Found { memory: place as u32, ..meeting() });
            }
        }
    }

    /// The same within a step, for those that were not found before; the pair as it is in [`Found`].
    fn find_late(
        self,
        [a, b]: [&Frame; 2],
        (pair, meeting): ([u32; 2], impl Fn() -> Found),
        late: &Late,
        memory: &mut Memory,
        found: &mut Vec<Found>,
        scratch: &mut Scratch,
    ) {
        let Self { key, shapes, reach, .. } = self;
        let here = a.from_within(b);
        let marks = shapes.map(Shape::mark);
        let of_triangles = shapes.into_iter().any(is_of_triangles);
        if !of_triangles && late.has(pair, 0, found, memory) {
            return;
        }
        collide(shapes[0], shapes[1], &here, reach, scratch, &mut |manifold| {
            if of_triangles && late.has(pair, manifold.part, found, memory) {
                return;
            }
            let (key, manifold) = (Key { nth: manifold.part, ..key }, *manifold);
            let (reach, grasp) = (if of_triangles { -1.0 } else { reach }, Grasp::default());
            let one = Remembered { key, marks, manifold, seen_from: here, reach, grasp };
            found.push(Found { memory: memory.learn_late(one), ..meeting() });
        });
    }
}

/// Who a solid is, for the report.
pub(super) fn party(groups: &Groups, number: usize, body: u32) -> Party {
    if body == NO_BODY {
        let first = groups.parts[number].entries.start;
        Party::Particle(groups.rows.get(first).copied().unwrap_or_default())
    } else {
        Party::Body(body)
    }
}
