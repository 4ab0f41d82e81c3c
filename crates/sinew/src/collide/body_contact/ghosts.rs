//! Drops ghost contacts: those with the inner edges of a floor that is made of several colliders or bodies (`manifold::ghost`).
//!
//! Their manifolds stay in the contact cache, since in the next step they may be none.

use glam::Vec3;
use smallvec::SmallVec;

use super::super::frame::Frame;
use super::super::manifold::{ContactWith, Manifold, MovingBody, MovingShape, is_ghost};
use super::super::world::World;
use super::BodyContactSolver;
use super::contact_cache::FrictionAnchor;
use super::wide_contact::Contact;

/// Approach along the normal up to which a contact with another body is not looked at, m/s: it presses, if at all, where the two lie. So nothing is compared in a
/// heap at rest, and nothing in it changes.
const APPROACH: f32 = 1e-3;

/// The contacts of each body collider. Scratch of the broad phase.
#[derive(Clone, Debug, Default)]
pub(super) struct GhostScratch {
    /// Where the contacts of each body collider begin in `touching`, and the end of the last one's.
    begins: Vec<u32>,
    touching: Vec<Touching>,
    /// Of each contact, whether it is a ghost.
    is_ghost: Vec<bool>,
    /// What one body collider touches.
    neighbours: Vec<Neighbour>,
}

/// A contact as it is seen from one of its body colliders.
#[derive(Clone, Copy, Debug, Default)]
struct Touching {
    /// Number of the contact, and of the other one in it.
    number: u32,
    other: u32,
    /// From the other one towards the body collider.
    normal: Vec3,
}

impl Touching {
    fn of(number: u32, contact: &Contact, body: usize) -> Self {
        if contact.a as usize == body {
            Self { number, other: contact.b, normal: contact.normal }
        } else {
            Self { number, other: contact.a, normal: -contact.normal }
        }
    }
}

impl GhostScratch {
    /// Lists the contacts of each of `count` body colliders, ascending.
    fn list(&mut self, contacts: &[Contact], count: usize) {
        let Self { begins, touching, .. } = self;
        begins.clear();
        begins.resize(count + 2, 0);
        for contact in contacts {
            bodies(contact).for_each(|body| begins[body + 2] += 1);
        }
        let mut sum = 0;
        for begin in &mut *begins {
            sum += *begin;
            *begin = sum;
        }
        touching.clear();
        touching.resize(sum as usize, Touching::default());
        for (contact, number) in contacts.iter().zip(0..) {
            for body in bodies(contact) {
                touching[begins[body + 1] as usize] = Touching::of(number, contact, body);
                begins[body + 1] += 1;
            }
        }
    }

    fn of(&self, body: usize) -> &[Touching] {
        &self.touching[self.begins[body] as usize..self.begins[body + 1] as usize]
    }
}

/// The body colliders of a contact.
fn bodies(contact: &Contact) -> impl Iterator<Item = usize> {
    let second = contact.geometry.is_none().then_some(contact.b as usize);
    core::iter::once(contact.a as usize).chain(second)
}

/// What a body collider touches, and how it moves.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    touching: Touching,
    /// Velocity that it has at the centre of the body collider, m/s.
    velocity: Vec3,
    /// Rotation vector of its motion in the step, rad.
    turn: Vec3,
    /// From the centre of another body collider to that of this one, metres; none of static or kinematic geometry.
    arm: Option<Vec3>,
    /// Speed at which the two approach each other, m/s.
    approach: f32,
}

impl Neighbour {
    /// Whether it may be a ghost: a contact with another body may if the two approach each other.
    fn nears(&self) -> bool {
        self.arm.is_none() || self.approach > APPROACH
    }
}

/// Whether a body collider moves towards anything that it touches, or touches several pieces of static or kinematic geometry: others are at rest.
fn may_meet_seams(neighbours: &[Neighbour]) -> bool {
    let fixed = |of: &&Neighbour| of.arm.is_none();
    let mut fixed = neighbours.iter().filter(fixed).map(|of| of.touching.other);
    let first = fixed.next();
    fixed.any(|other| Some(other) != first) || neighbours.iter().any(|of| of.approach > APPROACH)
}

impl BodyContactSolver {
    /// Removes the ghosts among the contacts of a step.
    pub(super) fn drop_ghosts(&mut self, world: &World) {
        let mut scratch = core::mem::take(&mut self.ghosts);
        scratch.list(&self.contacts, self.swept.len());
        scratch.is_ghost.clear();
        scratch.is_ghost.resize(self.contacts.len(), false);
        let mut any = false;
        for body in 0..self.swept.len() {
            // Most touch one only.
            let touching = scratch.of(body);
            if touching.windows(2).any(|pair| pair[0].other != pair[1].other) {
                any |= self.find_ghosts(body, world, &mut scratch);
            }
        }
        if any {
            let mut is_ghost = scratch.is_ghost.iter();
            self.contacts.retain(|_| !is_ghost.next().is_some_and(|is| *is));
            scratch.list(&self.contacts, self.swept.len());
        }
        self.ghosts = scratch;
    }

    /// Whether a manifold that the broad phase missed is a ghost beside one that it found.
    pub(super) fn is_missed_ghost(
        &self,
        contact: &Contact,
        manifold: &Manifold,
        world: &World,
    ) -> bool {
        bodies(contact).any(|body| {
            let one = self.neighbour(body, &Touching::of(u32::MAX, contact, body), world);
            if !one.nears() {
                return false;
            }
            let own = self.moving_body(body, world);
            let with = self.contact_with((contact, manifold, one.touching.normal), body, world);
            self.ghosts.of(body).iter().any(|floor| {
                let floor = self.neighbour(body, floor, world);
                self.may_hold(&own, &floor, world.dt)
                    && self.may_be_beside(&own, &one, &floor, (body, world.dt))
                    && is_ghost(&own, &with, &self.found(&floor, body, world))
            })
        })
    }

    /// Finds the ghosts among the contacts of one body collider, and marks the contacts beside them.
    fn find_ghosts(&mut self, body: usize, world: &World, scratch: &mut GhostScratch) -> bool {
        let GhostScratch { begins, touching, is_ghost: ghosts, neighbours } = scratch;
        let touching = &touching[begins[body] as usize..begins[body + 1] as usize];
        neighbours.clear();
        neighbours.extend(touching.iter().map(|of| self.neighbour(body, of, world)));
        if !may_meet_seams(neighbours) {
            return false;
        }
        let own = self.moving_body(body, world);
        // Those that may hold the body come first.
        let mut floors = 0;
        for place in 0..neighbours.len() {
            if self.may_hold(&own, &neighbours[place], world.dt) {
                neighbours.swap(floors, place);
                floors += 1;
            }
        }
        let floors = &neighbours[..floors];
        let mut any = false;
        for one in neighbours.iter().filter(|one| one.nears()) {
            let number = one.touching.number as usize;
            if ghosts[number] {
                continue;
            }
            let mut with = None;
            // What is a ghost itself holds nothing.
            let beside: SmallVec<[u32; 8]> = floors
                .iter()
                .filter(|floor| !ghosts[floor.touching.number as usize])
                .filter(|floor| self.may_be_beside(&own, one, floor, (body, world.dt)))
                .filter(|floor| {
                    let with = with.get_or_insert_with(|| self.found(one, body, world));
                    is_ghost(&own, with, &self.found(floor, body, world))
                })
                .map(|floor| floor.touching.number)
                .collect();
            if beside.is_empty() {
                continue;
            }
            any = true;
            ghosts[number] = true;
            let place = self.contacts[number].cache_index as usize;
            self.cache.now[place].friction_anchor = FrictionAnchor::default();
            for other in beside {
                self.contacts[other as usize].goes_on = true;
            }
        }
        any
    }

    /// The motion of what a body collider touches, as a rigid whole, at the centre of the body collider.
    #[inline(always)]
    fn neighbour(&self, body: usize, &touching: &Touching, world: &World) -> Neighbour {
        let this = &self.swept[body];
        let (velocity, turn, arm) = match self.swept.get(touching.other as usize) {
            Some(other) => {
                let arm = (this.origin - other.origin) + (this.centre - other.centre);
                (other.velocity + other.spin.cross(arm), other.spin * world.dt, Some(arm))
            }
            None => {
                let number = touching.other as usize - self.groups.padded();
                let geometry = &self.static_geometry[number];
                (geometry.carried(this, world, 0.0) / world.dt, geometry.turn(world), None)
            }
        };
        let approach = touching.normal.dot(velocity - this.velocity);
        Neighbour { touching, velocity, turn, arm, approach }
    }

    /// Whether a body collider may slide or roll on what it touches, as on a floor: it does not tumble on it, and another body does not part from it.
    fn may_hold(&self, own: &MovingBody, floor: &Neighbour, dt: f32) -> bool {
        (floor.arm.is_none() || own.allows_gap(floor.approach * dt))
            && own.keeps_upright(floor.touching.normal, floor.turn)
    }

    /// Whether a body collider may slide from a floor to something else. It looks at motions and centres only: in a heap that falls, few come further.
    fn may_be_beside(
        &self,
        own: &MovingBody,
        one: &Neighbour,
        floor: &Neighbour,
        (body, dt): (usize, f32),
    ) -> bool {
        // Inner edges of one mesh are known to itself.
        if floor.touching.other == one.touching.other {
            return false;
        }
        let up = floor.touching.normal;
        let goes_along = |velocity: Vec3| own.allows_gap(up.dot(velocity - floor.velocity) * dt);
        let may_be_met = match one.arm {
            Some(arm) => own.may_be_above(up.dot(arm)) && goes_along(self.swept[body].velocity),
            None => floor.arm.is_none() || one.approach > APPROACH,
        };
        may_be_met && goes_along(one.velocity)
    }

    /// A contact that the broad phase found, as it is seen from one of its body colliders.
    fn found<'a>(&'a self, of: &Neighbour, body: usize, world: &World<'a>) -> ContactWith<'a> {
        let contact = &self.contacts[of.touching.number as usize];
        let manifold = &self.cache.now[contact.cache_index as usize].manifold;
        self.contact_with((contact, manifold, of.touching.normal), body, world)
    }

    /// A contact, as it is seen from one of its body colliders.
    fn contact_with<'a>(
        &'a self,
        (contact, manifold, normal): (&Contact, &'a Manifold, Vec3),
        body: usize,
        world: &World<'a>,
    ) -> ContactWith<'a> {
        let origin = self.swept[body].origin;
        let other = match contact.geometry {
            Some(number) => {
                let geometry = &self.static_geometry[number as usize];
                MovingShape {
                    shape: &geometry.shape,
                    frame: geometry.seen_from(&geometry.start, origin),
                    turn: geometry.turn(world),
                    is_body: false,
                }
            }
            None => {
                let second = contact.a as usize == body;
                let other = if second { contact.b } else { contact.a };
                self.moving_shape(other as usize, origin, world)
            }
        };
        ContactWith { other, manifold, normal, is_second: contact.a as usize != body }
    }

    fn moving_body<'a>(&self, body: usize, world: &World<'a>) -> MovingBody<'a> {
        let own = self.moving_shape(body, self.swept[body].origin, world);
        MovingBody::new(own, self.groups.parts[body].reach)
    }

    /// A body collider, seen from an origin.
    fn moving_shape<'a>(&self, body: usize, origin: Vec3, world: &World<'a>) -> MovingShape<'a> {
        let swept = &self.swept[body];
        let translation = swept.frame.translation + (swept.origin - origin);
        MovingShape {
            shape: &world.body_colliders[body].shape,
            frame: Frame { translation, ..swept.frame },
            turn: swept.spin * world.dt,
            is_body: true,
        }
    }
}
