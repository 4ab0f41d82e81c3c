//! Looks for what may come to touch what in a step: bounds with a margin of how far a solid may get, pairs of those, and manifolds of the pairs.

use glam::{Vec3, Vec4};

use super::super::manifold::collide;
use super::super::{BodyContacts, Frame, Grip, Party, World};
use super::bodies::{ROTATION, rotation};
use super::found::{Found, Sensed, colour, pack};
use super::meet::Meet;
use super::memory::{ContactMemory, Key, Other, stiffness};
use super::read::{Home, Read, certain, guess};
use super::{Seen, Solids};
use crate::lanes::{LANES, with};
use crate::particles::{NO_BODY, Particles};

/// How far from its way a solid may be thrown in a step before all contacts are looked for again, by what gravity alone does, `g dt²`. Of a hundred
/// ragdolls that roll down stairs there is always one that is jolted by more than gravity: with 1 contacts were looked for twice in each step of ten
/// substeps, and in each substep of four. With 16 there are too many pairs that never touch.
const JOLTED: f32 = 8.0;

impl Solids {
    /// At the start of a step: finds everything that may come to touch in it.
    pub(crate) fn find(
        &mut self,
        particles: &Particles,
        world: &World,
        memory: &mut ContactMemory,
    ) {
        self.memory.take(memory);
        if self.is_empty() {
            self.memory.now.clear();
            return;
        }
        self.sensed.clear();
        self.h = world.dt / world.substeps.max(1) as f32;
        self.groups.weigh(world.solids, particles);
        self.lifts.take(&self.groups, particles);
        super::stands::list(world, &mut self.floor, &mut self.stands);
        let rows = self.groups.padded() + self.stands.len() + 1;
        self.bodies.resize(rows);
        self.sums.resize(self.groups.groups.len(), Default::default());
        for (number, part) in self.groups.parts.iter().enumerate().filter(|(_, part)| part.sound) {
            let rest = &world.solids[number].rest;
            let place = self.groups.place(number);
            self.bodies[place][ROTATION] = guess(&self.groups, part, rest, particles);
        }
        self.look(&particles.position, particles, world, 0.0);
    }

    /// Finds it from where the particles were after a share of the step. Not from where they were predicted: what is fast is on the other side there.
    pub(super) fn look(
        &mut self,
        places: &[Vec4],
        particles: &Particles,
        world: &World,
        share: f32,
    ) {
        self.read_fresh(places, particles, world);
        self.note(particles, world);
        self.place_stands(world, share, share);
        let mut pairs = core::mem::take(&mut self.pairs);
        self.near(world, share, &mut pairs);
        self.found.clear();
        self.memory.begin();
        for &[a, b] in &pairs {
            self.compare([a as usize, b as usize], particles, world, share);
        }
        self.pairs = pairs;
        self.loose.find(&self.seen, &self.groups, particles, world);
        let Self { found, used, packs, order, begins, groups, bodies, memory, h, .. } = self;
        let colours = colour(found, groups.parts.len(), used);
        let nothing = (bodies.rows.len() - 1) as u32;
        let centre =
            |row: u32| groups.parts.get(row as usize).map_or(Vec3::ZERO, |part| part.centre);
        let found = (&found[..], &memory.now[..], *h);
        let row = |number: u32| {
            let solid = number < groups.parts.len() as u32;
            if solid { groups.place(number as usize) as u32 } else { number }
        };
        pack(found, (nothing, colours), [order, begins], packs, (row, centre));
        self.fresh = true;
    }

    /// Poses and velocities.
    fn read_fresh(&mut self, places: &[Vec4], particles: &Particles, world: &World) {
        let Self { groups, lifts, bodies, sums, gathered, instructions, .. } = self;
        for (number, group) in groups.groups.iter().enumerate() {
            for _ in 0..2 {
                let read = Read {
                    group,
                    slots: &groups.slots[group.slots.clone()],
                    lifts: lifts.of(group),
                    position: places,
                    other: &particles.velocity,
                    fresh: true,
                    bodies,
                    first: number * LANES,
                    sums: &mut sums[number],
                    home: None,
                    gathered,
                };
                let lost = with(*instructions, read);
                if lost == 0 {
                    break;
                }
                for lane in (0..LANES).filter(|lane| lost >> lane & 1 == 1) {
                    if let Some(solid) = groups.sound_in(number, lane) {
                        let (rest, row) = (&world.solids[solid].rest, number * LANES + lane);
                        let near = bodies[row][ROTATION];
                        bodies[row][ROTATION] = certain(groups, solid, rest, particles, near);
                    }
                }
            }
        }
    }

    /// Where each solid is, and how far it may get.
    fn note(&mut self, particles: &Particles, world: &World) {
        let Self { groups, bodies, seen, homes, .. } = self;
        seen.clear();
        homes.clear();
        homes.resize(groups.groups.len(), Home::default());
        for (number, part) in groups.parts.iter().enumerate() {
            let Some(&row) = groups.rows.get(part.entries.start).filter(|_| part.sound) else {
                seen.push(Seen::default());
                continue;
            };
            let (row, place) = (row as usize, groups.place(number));
            let [.., centre, step, spin, _] = bodies[place].map(Vec4::truncate);
            let q = bodies[place][ROTATION];
            let speed = step.length() + spin.length() * part.reach;
            let margin = speed * world.dt + JOLTED * world.gravity * world.dt * world.dt;
            let origin = particles.origin[row];
            let r = rotation(q);
            let frame = Frame { translation: centre - r * part.centre, rotation: r };
            let sound = centre.is_finite() && margin.is_finite() && q.is_finite();
            let (low, high) = world.solids[number].shape.bounds_in(&frame);
            // Far out the sum with the origin is rounded.
            let wide = margin + 1e-6 * (origin.abs().max_element() + 1.0);
            let bounds = (low + origin - wide, high + origin + wide);
            let body = particles.body[row];
            let bounds = if sound { bounds } else { (Vec3::NAN, Vec3::NAN) };
            if sound {
                homes[place / LANES].put(place % LANES, centre, q, [margin, part.reach]);
            }
            seen.push(Seen { centre, frame, margin, origin, body, bounds, sound });
        }
    }

    /// Pairs of solids, and of solids with what stands, that are near each other; sorted.
    fn near(&mut self, world: &World, share: f32, pairs: &mut Vec<[u32; 2]>) {
        let Self { seen, stands, broad, bounds, groups, nearby, .. } = self;
        bounds.clear();
        bounds.extend(seen.iter().map(|seen| seen.bounds));
        for stand in stands.iter() {
            let nothing = (Vec3::NAN, Vec3::NAN);
            bounds.push(if stand.endless {
                nothing
            } else if stand.moving.is_some() {
                let (low, high) = stand.shape.bounds_in(&stand.frame_at(world, share));
                let (low_end, high_end) = stand.shape.bounds_in(&stand.frame_at(world, 1.0));
                (low.min(low_end), high.max(high_end))
            } else {
                stand.shape.bounds_in(&stand.start)
            });
        }
        broad.0.pairs(bounds, nearby);
        pairs.clear();
        let mut nearby =
            nearby.iter().copied().filter(|pair| (pair[0] as usize) < seen.len()).peekable();
        // What has no end is looked at by everyone; both lists are sorted.
        for (a, one) in seen.iter().enumerate().filter(|(_, one)| one.sound) {
            for (number, stand) in stands.iter().enumerate().filter(|(_, stand)| stand.endless) {
                let frame = stand.frame_at(world, share);
                let here = stand.seen_from(&frame, one.origin);
                let height = here.rotation.y_axis.dot(one.centre - here.translation);
                let end = stand.frame_at(world, 1.0);
                let moved = carried(&frame, &end, one.centre + one.origin);
                if height <= groups.parts[a].reach + one.margin + moved {
                    let pair = [a as u32, (seen.len() + number) as u32];
                    while let Some(before) = nearby.next_if(|before| *before < pair) {
                        pairs.push(before);
                    }
                    pairs.push(pair);
                }
            }
        }
        pairs.extend(nearby);
    }

    /// Finds the manifolds of a pair, or remembers them.
    fn compare(&mut self, [a, b]: [usize; 2], particles: &Particles, world: &World, share: f32) {
        let Self { groups, seen, stands, found, memory, sensed, scratch, .. } = self;
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
            memory: 0,
            offset: Vec3::ZERO,
            grip: Grip::default(),
            listened: own.events,
            parties: [party(a); 2],
            colour: 0,
            stiff: 0.0,
            strain: 0.0,
        };
        if let Some(other) = seen.get(b) {
            let theirs = contacts(other.body);
            let overlap = || world.solids[a].overlaps_at_rest(&world.solids[b], particles);
            if !own.layers.meets(theirs.layers) || same && (!own.with_itself || overlap()) {
                return;
            }
            let key = key(Other::Solid(world.solids[b].id));
            if groups.parts[a].immovable && groups.parts[b].immovable {
                return memory.carry(&key);
            }
            let offset = other.origin - one.origin;
            let frame = Frame { translation: other.frame.translation + offset, ..other.frame };
            let size = (size, size.min(groups.parts[b].reach));
            let meeting = Found {
                offset,
                grip: own.material.against(&theirs.material),
                listened: own.events || theirs.events,
                parties: [party(a), party(b)],
                stiff: stiffness(size.1),
                ..meeting(b)
            };
            let reach = one.margin + other.margin;
            let meet = Meet { key, shapes: [&solid.shape, &world.solids[b].shape], size, reach };
            meet.find([&one.frame, &frame], meeting, memory, found, &mut scratch.0);
            return;
        }
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
            return memory.carry(&key);
        }
        let moved = match stand.moving {
            Some(_) => carried(&frame, &stand.frame_at(world, 1.0), one.centre + one.origin),
            None => 0.0,
        };
        let meeting = Found {
            stand: Some(number as u32),
            offset: here.translation,
            grip: stand.grip(&own.material),
            listened,
            parties,
            stiff: stiffness(size),
            ..meeting(groups.padded() + number)
        };
        let (size, reach) = ((size, size), one.margin + moved);
        let meet = Meet { key, shapes: [&solid.shape, &stand.shape], size, reach };
        meet.find([&one.frame, &here], meeting, memory, found, &mut scratch.0);
    }

    /// Puts what stands where it is from one share of the step to another.
    pub(super) fn place_stands(&mut self, world: &World, from: f32, to: f32) {
        let first = self.groups.padded();
        for (number, stand) in self.stands.iter().enumerate() {
            let (start, end) = (stand.frame_at(world, from), stand.frame_at(world, to));
            self.bodies.place(first + number, &start, &end);
        }
    }
}

/// Who a solid is, for the report.
pub(super) fn party(groups: &super::groups::Groups, number: usize, body: u32) -> Party {
    if body == NO_BODY {
        let first = groups.parts[number].entries.start;
        Party::Particle(groups.rows.get(first).copied().unwrap_or_default())
    } else {
        Party::Body(body)
    }
}

/// How far what goes from one frame to another takes a point of the world, metres.
pub(super) fn carried(from: &Frame, to: &Frame, point: Vec3) -> f32 {
    if from == to { 0.0 } else { (to.point(from.local(point)) - point).length() }
}
