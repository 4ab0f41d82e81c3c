//! Broad phase over whole bodies: which of them may come to touch another one in a step, so that what is far from everything costs nothing.
//!
//! It is asked for bodies that have particles of their own to collide with: cloth, ropes, soft bodies, single particles. Rigid parts are compared one by
//! one as it is (`body_contact`), and stand here for what those may run into.

use glam::Vec3;

use super::manifold::Broad;
use super::material::BodyContacts;
use super::world::World;
use crate::kept::Kept;
use crate::particles::{NO_BODY, Particles};

/// Bodies, and which are near another one. Scratch of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nearby {
    bodies: Vec<BodyExtent>,
    bounds: Vec<(Vec3, Vec3)>,
    broad: Kept<Broad>,
    pairs: Vec<[u32; 2]>,
    near: Vec<bool>,
    /// Of each body, whether it is near another one.
    beside: Vec<bool>,
}

/// Where a body is.
#[derive(Clone, Copy, Debug)]
struct BodyExtent {
    low: Vec3,
    high: Vec3,
    /// The square of its fastest particle's speed, m²/s².
    fastest: f32,
    /// Whether it has particles that collide by themselves.
    free: bool,
}

/// How much further than its fastest particle would go alone, a body may go: what is flung by its neighbours is faster than all of them were.
pub(super) const HASTE: f32 = 1.5;

/// How far a body may reach in a step of `dt` seconds, metres, beside the radii of its particles, if the fastest of them goes at `speed` m/s.
pub(super) fn reach(speed: f32, gravity: f32, dt: f32) -> f32 {
    HASTE * (speed + gravity * dt) * dt
}

impl Nearby {
    /// All that take part, wherever they are.
    #[cfg(test)]
    pub(super) fn everywhere(contacts: &[BodyContacts]) -> Self {
        let near = contacts.iter().map(BodyContacts::takes_part).collect();
        Self { near, ..Self::default() }
    }

    /// Finds them. Rows that are marked in `aside` do not collide by themselves.
    pub(super) fn broad_phase(&mut self, particles: &Particles, world: &World, aside: &[bool]) {
        let contacts = world.filter.bodies();
        for bodies in [&mut self.near, &mut self.beside] {
            bodies.clear();
            bodies.resize(contacts.len(), false);
        }
        if !contacts.iter().any(BodyContacts::takes_part) {
            return;
        }
        // Where all that collide do so by a shape, nobody is looked for.
        let is_free = |(row, &body): (usize, &u32)| {
            let own = contacts.get(body as usize);
            !aside.get(row).is_some_and(|&aside| aside)
                && own.is_some_and(|own| particles.radius[row] > 0.0 || own.surface)
        };
        if !particles.body.iter().enumerate().any(is_free) {
            return;
        }
        self.enclose(particles, world, aside);
        if !self.bodies.iter().any(|body| body.free) {
            return;
        }
        let Self { bodies, bounds, broad, pairs, near, beside } = self;
        bounds.clear();
        bounds.extend(bodies.iter().map(|body| body.bounds(world)));
        broad.0.pairs(bounds, pairs);
        for (number, (body, own)) in bodies.iter().zip(contacts).enumerate() {
            near[number] = body.free && own.with_itself && !own.disabled;
        }
        for &[a, b] in &*pairs {
            let [a, b] = [a as usize, b as usize];
            if (bodies[a].free || bodies[b].free) && contacts[a].meets(&contacts[b]) {
                (near[a], near[b]) = (true, true);
                (beside[a], beside[b]) = (true, true);
            }
        }
    }

    /// Whether a body may come to touch another one, or itself.
    #[inline(always)]
    pub(super) fn has(&self, body: u32) -> bool {
        self.near.get(body as usize).is_some_and(|&near| near)
    }

    /// Whether a body may come to touch another one.
    pub(super) fn has_beside(&self, body: u32) -> bool {
        self.beside.get(body as usize).is_some_and(|&beside| beside)
    }

    /// Puts a box about each body that takes part, and about where its pins lead.
    fn enclose(&mut self, particles: &Particles, world: &World, aside: &[bool]) {
        let contacts = world.filter.bodies();
        self.bodies.clear();
        self.bodies.resize(contacts.len(), BodyExtent::NOWHERE);
        for (row, &body) in particles.body.iter().enumerate() {
            let Some(own) = contacts.get(body as usize) else { continue };
            let at = particles.origin[row] + particles.position[row].truncate();
            if !own.takes_part() || !at.is_finite() {
                continue;
            }
            let (extent, radius) = (&mut self.bodies[body as usize], particles.radius[row]);
            extent.add(at, radius);
            let speed = particles.velocity[row].truncate().length_squared();
            extent.fastest = extent.fastest.max(speed);
            let aside = aside.get(row).is_some_and(|&aside| aside);
            extent.free |= !aside && (radius > 0.0 || own.surface);
        }
        for pin in &world.boundaries.pins {
            let body = particles.body.get(pin.particle as usize).copied().unwrap_or(NO_BODY);
            if let Some(extent) = self.bodies.get_mut(body as usize)
                && pin.target.is_finite()
            {
                extent.add(pin.target, particles.radius[pin.particle as usize]);
            }
        }
    }
}

impl BodyExtent {
    const NOWHERE: Self =
        Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, fastest: 0.0, free: false };

    #[inline(always)]
    fn add(&mut self, at: Vec3, radius: f32) {
        self.low = self.low.min(at - radius);
        self.high = self.high.max(at + radius);
    }

    /// What it may reach in the step; a box that overlaps nothing for one that takes no part.
    fn bounds(&self, world: &World) -> (Vec3, Vec3) {
        let reach = reach(self.fastest.sqrt(), world.gravity, world.dt);
        // Far out the sum with the origin is rounded.
        let wide = reach + 1e-6 * (self.low.abs().max(self.high.abs()).max_element() + 1.0);
        (self.low - wide, self.high + wide)
    }
}
