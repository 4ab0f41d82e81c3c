//! Two that may come to touch: what is remembered of where they do, as long as that holds, and otherwise what is found afresh.

use glam::Vec3;

use super::super::manifold::{Scratch, collide, is_of_triangles};
use super::super::{BodyContacts, Frame, Grip, Party, Shape, World};
use super::Solids;
use super::astray::Late;
use super::found::{Found, Sensed};
use super::groups::Groups;
use super::memory::{Grasp, Key, Memory, Other, Remembered, SLACK};
use super::pack::BLUNT;
use crate::particles::{NO_BODY, Particles};

impl Solids {
    /// Finds the manifolds of a pair after a share of the step, or remembers them; `late`, those that are not known yet.
    pub(super) fn compare(
        &mut self,
        [a, b]: [usize; 2],
        particles: &Particles,
        world: &World,
        (share, late): (f32, bool),
    ) {
        let Self { groups, seen, stands, found, memory, sensed, scratch, late: known, .. } = self;
        let time = (1.0 - share) * world.dt;
        let (one, size) = (&seen[a], groups.parts[a].reach);
        // Neighbours in a body are near each other all the time.
        let same = seen.get(b).is_some_and(|other| one.body == other.body && one.body != NO_BODY);
        if same && groups.share_a_row(a, b) {
            return;
        }
        let contacts = |body: u32| world.bodies.get(body as usize).copied().unwrap_or_default();
        let own: BodyContacts = contacts(one.body);
        let party = |number: usize| party(groups, number, seen[number].body);
        let solid = &world.solids[a];
        let key = |other| Key { a: solid.id, other, nth: 0 };
        let meeting = |b: usize| Found {
            a: a as u32,
            b: b as u32,
            stand: None,
            still: None,
            memory: 0,
            offset: Vec3::ZERO,
            grip: Grip::default(),
            listened: own.events,
            parties: [party(a); 2],
            colour: 0,
            size: 0.0,
            strain: 0.0,
            blunt: 0.0,
        };
        let (meet, there, meeting) = if let Some(other) = seen.get(b) {
            let theirs = contacts(other.body);
            let overlap = || world.solids[a].overlaps_at_rest(&world.solids[b], particles);
            if !own.layers.meets(theirs.layers) || same && (!own.with_itself || overlap()) {
                return;
            }
            let key = key(Other::Solid(world.solids[b].id));
            if groups.parts[a].immovable && groups.parts[b].immovable {
                if !late {
                    memory.carry(&key);
                }
                return;
            }
            let offset = other.origin - one.origin;
            let frame = Frame { translation: other.frame.translation + offset, ..other.frame };
            let size = (size, size.min(groups.parts[b].reach));
            let meeting = Found {
                offset,
                grip: own.material.against(&theirs.material),
                listened: own.events || theirs.events,
                parties: [party(a), party(b)],
                size: size.1,
                ..meeting(b)
            };
            // Within a step nobody is quite where he was expected.
            let off = if late { one.beside + other.beside } else { 0.0 };
            let reach = one.reach_of(other, time) + off;
            let meet = Meet { key, shapes: [&solid.shape, &world.solids[b].shape], size, reach };
            (meet, frame, meeting)
        } else {
            let number = b - seen.len();
            let stand = &stands[number];
            if !own.layers.meets(stand.layers) {
                return;
            }
            let frame = stand.frame_at(world, share);
            let here = stand.seen_from(&frame, one.origin);
            let listened = own.events || stand.events;
            let parties = [party(a), stand.party];
            if stand.sensor {
                if listened {
                    let seen_from = one.frame.from_within(&here);
                    let (shape, scratch) = (&solid.shape, &mut scratch.0);
                    collide(shape, &stand.shape, &seen_from, 0.0, scratch, &mut |manifold| {
                        if let Some(point) = manifold.points().first() {
                            let normal = frame.turn(manifold.normal);
                            let point = one.origin + one.frame.point(point.on_a);
                            sensed.push(Sensed { parties, point, normal });
                        }
                    });
                }
                return;
            }
            let key = key(stand.other);
            if groups.parts[a].immovable {
                if !late {
                    memory.carry(&key);
                }
                return;
            }
            let meeting = Found {
                stand: Some(number as u32),
                still: stand.moving.is_none().then_some(here.rotation),
                offset: here.translation,
                grip: stand.grip(&own.material),
                listened,
                parties,
                size,
                ..meeting(groups.padded() + number)
            };
            let reach = one.reach(time) + stand.carries(one, world, share);
            let size = (size, size);
            let meet = Meet { key, shapes: [&solid.shape, &stand.shape], size, reach };
            (meet, here, meeting)
        };
        // Joints of bones turn these on their points, and they crept on over the floor when that was held.
        let alone = groups.is_alone(a) && (b >= seen.len() || groups.is_alone(b));
        let blunt = if alone { BLUNT * meeting.size } else { 0.0 };
        let meeting = Found { blunt, ..meeting };
        let (frames, scratch) = ([&one.frame, &there], &mut scratch.0);
        if late {
            meet.find_late(frames, meeting, known, memory, found, scratch);
        } else {
            meet.find(frames, meeting, memory, found, scratch);
        }
    }
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
    fn find(
        self,
        [a, b]: [&Frame; 2],
        meeting: Found,
        memory: &mut Memory,
        found: &mut Vec<Found>,
        scratch: &mut Scratch,
    ) {
        let Self { key, shapes, size: (size, smaller), reach } = self;
        let here = a.from_within(b);
        let marks = shapes.map(Shape::mark);
        let of_triangles = shapes.into_iter().any(is_of_triangles);
        let known = memory.recall(&key).filter(|known| known.marks == marks).copied();
        let strain = known.and_then(|known| known.strain(&here, (size, smaller), reach));
        if let (Some(mut known), Some(strain)) = (known, strain) {
            if known.is_near(&here, reach) {
                found.push(Found { strain, memory: memory.now.len() as u32, ..meeting });
            } else {
                known.grasp = Grasp::default();
            }
            memory.now.push(known);
            return;
        }
        let (first, far) = (memory.now.len(), reach + SLACK * smaller);
        collide(shapes[0], shapes[1], &here, far, scratch, &mut |manifold| {
            let (key, manifold) = (Key { nth: manifold.part, ..key }, *manifold);
            let (reach, grasp) = (if of_triangles { -1.0 } else { far }, Grasp::default());
            memory.now.push(Remembered { key, marks, manifold, seen_from: here, reach, grasp });
        });
        // Triangles come in any order.
        memory.now[first..].sort_unstable_by_key(|one| one.key);
        for place in first..memory.now.len() {
            memory.learn(place, b);
            if memory.now[place].is_near(&here, reach) {
                found.push(Found { memory: place as u32, ..meeting });
            }
        }
    }

    /// The same within a step, for those that were not found before.
    fn find_late(
        self,
        [a, b]: [&Frame; 2],
        meeting: Found,
        late: &Late,
        memory: &mut Memory,
        found: &mut Vec<Found>,
        scratch: &mut Scratch,
    ) {
        let Self { key, shapes, reach, .. } = self;
        let (here, pair) = (a.from_within(b), [meeting.a, meeting.b]);
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
            found.push(Found { memory: memory.learn_late(one), ..meeting });
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
