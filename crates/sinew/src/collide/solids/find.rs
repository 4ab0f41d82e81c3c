//! Looks for what may come to touch what in a step: bounds of all that a solid may get to, pairs of those, and manifolds of the pairs.

use glam::Vec3;

use super::super::World;
use super::super::nearby::Nearby;
use super::Solids;
use super::bodies::{ROTATION, SHIFT};
use super::found::{colour, pack};
use super::guess::certain;
use super::mass_ratio::set_levels;
use super::memory::ContactMemory;
use super::read::Read;
use super::way::{Seen, Ways};
use crate::lanes::{LANES, Record, with};
use crate::particles::{NO_BODY, Particles};

impl Solids {
    /// At the start of a step: finds everything that may come to touch in it.
    pub(crate) fn find(
        &mut self,
        particles: &Particles,
        world: &World,
        nearby: &Nearby,
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
        self.overlaps.update(world.solids, &self.groups, particles, world.filter);
        self.lifts.take(&self.groups, particles);
        super::stands::list(world, &mut self.floor, &mut self.stands);
        let rows = self.groups.padded() + self.stands.len() + 1;
        self.bodies.resize(rows);
        self.sums.resize(self.groups.groups.len(), Default::default());
        self.guess(particles, world);
        self.read_fresh(particles, world);
        self.ways.clear();
        self.ways.resize(self.groups.groups.len(), Ways::default());
        self.seen.clear();
        self.seen.resize(self.groups.parts.len(), Seen::default());
        for number in 0..self.seen.len() {
            self.note(number, particles, world, (0.0, 1.0));
        }
        self.place_stands(world, 0.0, 0.0);
        let mut pairs = core::mem::take(&mut self.pairs);
        self.near(world, &mut pairs);
        self.found.clear();
        self.memory.begin();
        for &[a, b] in &pairs {
            self.compare([a as usize, b as usize], particles, world, (0.0, false));
        }
        self.pairs = pairs;
        self.memory.in_order();
        self.late.begin(self.found.len());
        self.loose.find(&self.seen, &self.groups, particles, world, nearby);
        let Self { found, used, packs, order, begins, groups, bodies, memory, h, loads, .. } = self;
        let mass = |number: u32| {
            let weight = bodies[groups.place(number as usize)][SHIFT].w;
            (weight > 0.0 && groups.is_alone(number as usize)).then(|| 1.0 / weight)
        };
        set_levels(found, groups.parts.len(), mass, loads);
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
        self.late.packs = packs.len();
        self.fresh = true;
    }

    /// Poses and velocities.
    fn read_fresh(&mut self, particles: &Particles, world: &World) {
        let Self { groups, lifts, bodies, sums, gathered, instructions, .. } = self;
        for (number, group) in groups.groups.iter().enumerate() {
            let (first, mut asks) = (number * LANES, 0xFF);
            for _ in 0..2 {
                let before: [Record; LANES] =
                    core::array::from_fn(|lane| bodies.rows[first + lane]);
                let read = Read {
                    group,
                    slots: &groups.slots[group.slots.clone()],
                    lifts: lifts.of(group),
                    position: &particles.position,
                    other: &particles.velocity,
                    fresh: true,
                    bodies,
                    first,
                    sums: &mut sums[number],
                    ways: None,
                    gathered,
                };
                let lost = with(*instructions, read);
                // Who was found the first time stays as it was: who is beside it must not matter.
                for lane in (0..LANES).filter(|lane| asks >> lane & 1 == 0) {
                    bodies.rows[first + lane] = before[lane];
                }
                asks &= lost;
                if asks == 0 {
                    break;
                }
                for lane in (0..LANES).filter(|lane| asks >> lane & 1 == 1) {
                    if let Some(solid) = groups.sound_in(number, lane) {
                        let (rest, row) = (&world.solids[solid].rest, first + lane);
                        let near = bodies[row][ROTATION];
                        bodies[row][ROTATION] = certain(groups, solid, rest, particles, near);
                    }
                }
            }
        }
    }

    /// Pairs of solids, and of solids with what stands, that are near each other; sorted.
    fn near(&mut self, world: &World, pairs: &mut Vec<[u32; 2]>) {
        let Self { seen, stands, near, bounds, groups, nearby, order: endless, .. } = self;
        bounds.clear();
        bounds.extend(seen.iter().map(|seen| seen.bounds));
        bounds.extend(stands.iter().map(|stand| stand.bounds(world)));
        let of_one = |i: usize| {
            let body = |i: usize| seen.get(i).map_or(NO_BODY, |one| one.body);
            body(i) != NO_BODY && body(i) == body(i - 1)
        };
        near.0.pairs(bounds, of_one, nearby);
        pairs.clear();
        let mut nearby =
            nearby.iter().copied().filter(|pair| (pair[0] as usize) < seen.len()).peekable();
        // What has no end is looked at by everyone; both lists are sorted.
        endless.clear();
        endless.extend((0..stands.len() as u32).filter(|&i| stands[i as usize].endless));
        for (a, one) in seen.iter().enumerate().filter(|(_, one)| one.sound) {
            for &number in &*endless {
                if stands[number as usize].is_below(one, groups.parts[a].reach, world, 0.0) {
                    let pair = [a as u32, seen.len() as u32 + number];
                    while let Some(before) = nearby.next_if(|before| *before < pair) {
                        pairs.push(before);
                    }
                    pairs.push(pair);
                }
            }
        }
        pairs.extend(nearby);
    }

    /// Puts what stands where it is from one share of the step to another. What goes nowhere has been put there when the step began.
    pub(super) fn place_stands(&mut self, world: &World, from: f32, to: f32) {
        let (first, begins) = (self.groups.padded(), to == 0.0);
        let stands = self.stands.iter().enumerate();
        for (number, stand) in stands.filter(|(_, stand)| begins || stand.moving.is_some()) {
            let (start, end) = (stand.frame_at(world, from), stand.frame_at(world, to));
            self.bodies.place(first + number, &start, &end);
        }
    }
}
