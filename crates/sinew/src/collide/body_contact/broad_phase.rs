//! Broad phase of body colliders: their swept bounds, the pairs of bounds that overlap, and the manifolds of the pairs.

use glam::Vec3;

use super::super::World;
use super::super::nearby::Nearby;
use super::BodyContactSolver;
use super::bodies::{ROTATION, SHIFT};
use super::contact_cache::ContactCache;
use super::contacts::{colour, pack_contacts};
use super::mass_ratio::set_levels;
use super::pose::{ExtractPose, certain};
use super::swept_bounds::{SweptBounds, WideSweptBounds};
use crate::lanes::{LANES, Record, with};
use crate::particles::{NO_BODY, Particles};

impl BodyContactSolver {
    /// Finds at the start of a step everything that may come to touch in it.
    pub(crate) fn broad_phase(
        &mut self,
        particles: &Particles,
        world: &World,
        nearby: &Nearby,
        cache: &mut ContactCache,
    ) {
        self.cache.take(cache);
        if self.is_empty() {
            self.cache.now.clear();
            return;
        }
        self.sensor_overlaps.clear();
        self.h = world.dt / world.substeps.max(1) as f32;
        self.groups.weigh(world.body_colliders, particles);
        self.overlaps.update(world.body_colliders, &self.groups, particles, world.filter);
        self.origin_offsets.take(&self.groups, particles);
        super::static_geometry::list(world, &mut self.floor, &mut self.static_geometry);
        let rows = self.groups.padded() + self.static_geometry.len() + 1;
        self.bodies.resize(rows);
        self.sums.resize(self.groups.groups.len(), Default::default());
        self.note_initial_rotations(particles, world);
        self.extract_poses_afresh(particles, world);
        self.wide_swept.clear();
        self.wide_swept.resize(self.groups.groups.len(), WideSweptBounds::default());
        self.swept.clear();
        self.swept.resize(self.groups.parts.len(), SweptBounds::default());
        for number in 0..self.swept.len() {
            self.note(number, particles, world, (0.0, 1.0));
        }
        self.place_static_geometry(world, 0.0, 0.0);
        let mut pairs = core::mem::take(&mut self.pairs);
        self.near_pairs(world, &mut pairs);
        self.contacts.clear();
        self.cache.begin();
        for &[a, b] in &pairs {
            self.compare([a as usize, b as usize], particles, world, (0.0, false));
        }
        self.pairs = pairs;
        self.cache.in_order();
        self.missed.begin(self.contacts.len());
        self.loose.broad_phase(&self.swept, &self.groups, particles, world, nearby);
        let Self {
            contacts,
            used,
            wide_contacts,
            order,
            begins,
            groups,
            bodies,
            cache,
            h,
            loads,
            ..
        } = self;
        let mass = |number: u32| {
            let weight = bodies[groups.place(number as usize)][SHIFT].w;
            (weight > 0.0 && groups.is_alone(number as usize)).then(|| 1.0 / weight)
        };
        set_levels(contacts, groups.parts.len(), mass, loads);
        let colours = colour(contacts, groups.parts.len(), used);
        let nothing = (bodies.rows.len() - 1) as u32;
        let centre =
            |row: u32| groups.parts.get(row as usize).map_or(Vec3::ZERO, |part| part.centre);
        let contacts = (&contacts[..], &cache.now[..], *h);
        let row = |number: u32| {
            let solid = number < groups.parts.len() as u32;
            if solid { groups.place(number as usize) as u32 } else { number }
        };
        pack_contacts(contacts, (nothing, colours), [order, begins], wide_contacts, (row, centre));
        self.missed.wide_contacts = wide_contacts.len();
        self.fresh = true;
    }

    /// Poses and velocities.
    fn extract_poses_afresh(&mut self, particles: &Particles, world: &World) {
        let Self { groups, origin_offsets, bodies, sums, gathered, instructions, .. } = self;
        for (number, group) in groups.groups.iter().enumerate() {
            let (first, mut asks) = (number * LANES, 0xFF);
            for _ in 0..2 {
                let before: [Record; LANES] =
                    core::array::from_fn(|lane| bodies.rows[first + lane]);
                let read = ExtractPose {
                    group,
                    slots: &groups.slots[group.slots.clone()],
                    origin_offsets: origin_offsets.of(group),
                    position: &particles.position,
                    other: &particles.velocity,
                    fresh: true,
                    bodies,
                    first,
                    sums: &mut sums[number],
                    wide_swept: None,
                    gathered,
                };
                let residual = with(*instructions, read);
                // Who was found the first time stays as it was: who is beside it must not matter.
                for lane in (0..LANES).filter(|lane| asks >> lane & 1 == 0) {
                    bodies.rows[first + lane] = before[lane];
                }
                asks &= residual;
                if asks == 0 {
                    break;
                }
                for lane in (0..LANES).filter(|lane| asks >> lane & 1 == 1) {
                    if let Some(solid) = groups.sound_in(number, lane) {
                        let (rest, row) = (&world.body_colliders[solid].rest, first + lane);
                        let near = bodies[row][ROTATION];
                        bodies[row][ROTATION] = certain(groups, solid, rest, particles, near);
                    }
                }
            }
        }
    }

    /// Pairs of body colliders, and of body colliders with static geometry, that are near each other; sorted.
    fn near_pairs(&mut self, world: &World, pairs: &mut Vec<[u32; 2]>) {
        let Self {
            swept, static_geometry, clusters, bounds, groups, nearby, order: endless, ..
        } = self;
        bounds.clear();
        bounds.extend(swept.iter().map(|swept| swept.bounds));
        bounds.extend(static_geometry.iter().map(|geometry| geometry.bounds(world)));
        let of_one = |i: usize| {
            let body = |i: usize| swept.get(i).map_or(NO_BODY, |one| one.body);
            body(i) != NO_BODY && body(i) == body(i - 1)
        };
        clusters.0.pairs(bounds, of_one, nearby);
        pairs.clear();
        let mut nearby =
            nearby.iter().copied().filter(|pair| (pair[0] as usize) < swept.len()).peekable();
        // What has no end is looked at by everyone; both lists are sorted.
        endless.clear();
        endless.extend(
            (0..static_geometry.len() as u32).filter(|&i| static_geometry[i as usize].endless),
        );
        for (a, one) in swept.iter().enumerate().filter(|(_, one)| one.sound) {
            for &number in &*endless {
                if static_geometry[number as usize].is_below(one, groups.parts[a].reach, world, 0.0)
                {
                    let pair = [a as u32, swept.len() as u32 + number];
                    while let Some(before) = nearby.next_if(|before| *before < pair) {
                        pairs.push(before);
                    }
                    pairs.push(pair);
                }
            }
        }
        pairs.extend(nearby);
    }

    /// Puts static geometry where it is from one share of the step to another. What goes nowhere has been put there when the step began.
    pub(super) fn place_static_geometry(&mut self, world: &World, from: f32, to: f32) {
        let (first, begins) = (self.groups.padded(), to == 0.0);
        let static_geometry = self.static_geometry.iter().enumerate();
        for (number, geometry) in
            static_geometry.filter(|(_, geometry)| begins || geometry.moving.is_some())
        {
            let (start, end) = (geometry.frame_at(world, from), geometry.frame_at(world, to));
            self.bodies.place(first + number, &start, &end);
        }
    }
}
