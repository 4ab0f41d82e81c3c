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
use super::swept_bounds::SweptBounds;
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
    /// Contacts of one body collider that may be with a floor.
    floors: Vec<Touching>,
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
    /// Lists the contacts of each of `count` body colliders, ascending; without those with geometry that moves in this step.
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

/// The body colliders of a contact; none of one with geometry that moves in this step.
fn bodies(contact: &Contact) -> impl Iterator<Item = usize> {
    let stays = contact.geometry.is_none() || contact.fixed.is_some();
    let second = contact.geometry.is_none().then_some(contact.b as usize);
    stays.then_some(contact.a as usize).into_iter().chain(second)
}

impl BodyContactSolver {
    /// Removes the ghosts among the contacts of a step. Kinematic geometry that moves in the step is left alone.
    pub(super) fn drop_ghosts(&mut self, world: &World) {
        let mut scratch = core::mem::take(&mut self.ghosts);
        scratch.list(&self.contacts, self.swept.len());
        scratch.is_ghost.clear();
        scratch.is_ghost.resize(self.contacts.len(), false);
        let mut any = false;
        for body in 0..self.swept.len() {
            // Most touch one only, or are at rest on others.
            let touching = scratch.of(body);
            if touching.windows(2).any(|pair| pair[0].other != pair[1].other)
                && self.may_meet_seams(body, touching)
            {
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
            let own = MovingBody::new(self.moving_shape(body, self.swept[body].origin, world));
            let one = Touching::of(u32::MAX, contact, body);
            let mut floors = self.ghosts.of(body).iter();
            self.nears(body, &one)
                && floors.any(|floor| {
                    let with = (&one, (contact, manifold));
                    self.may_hold(&own, floor, (body, world.dt))
                        && self.may_be_beside(&own, &one, floor, (body, world.dt))
                        && self.is_ghost_beside(&own, with, floor, body, world)
                })
        })
    }

    /// Finds the ghosts among the contacts of one body collider, and marks the contacts beside them.
    fn find_ghosts(&mut self, body: usize, world: &World, scratch: &mut GhostScratch) -> bool {
        let own = MovingBody::new(self.moving_shape(body, self.swept[body].origin, world));
        let GhostScratch { begins, touching, is_ghost, floors } = scratch;
        let touching = &touching[begins[body] as usize..begins[body + 1] as usize];
        floors.clear();
        floors.extend(touching.iter().filter(|of| self.may_hold(&own, of, (body, world.dt))));
        if floors.is_empty() {
            return false;
        }
        let mut any = false;
        for one in touching {
            if is_ghost[one.number as usize] || !self.nears(body, one) {
                continue;
            }
            // What is a ghost itself holds nothing.
            let beside: SmallVec<[u32; 8]> = floors
                .iter()
                .filter(|floor| !is_ghost[floor.number as usize])
                .filter(|floor| self.may_be_beside(&own, one, floor, (body, world.dt)))
                .filter(|floor| {
                    let contact = self.contact_and_manifold(one.number);
                    self.is_ghost_beside(&own, (one, contact), floor, body, world)
                })
                .map(|floor| floor.number)
                .collect();
            if beside.is_empty() {
                continue;
            }
            any = true;
            is_ghost[one.number as usize] = true;
            let place = self.contacts[one.number as usize].cache_index as usize;
            self.cache.now[place].friction_anchor = FrictionAnchor::default();
            for other in beside {
                self.contacts[other as usize].goes_on = true;
            }
        }
        any
    }

    fn contact_and_manifold(&self, number: u32) -> (&Contact, &Manifold) {
        let contact = &self.contacts[number as usize];
        (contact, &self.cache.now[contact.cache_index as usize].manifold)
    }

    /// Whether a body collider moves towards anything that it touches, or touches several pieces of static geometry.
    fn may_meet_seams(&self, body: usize, touching: &[Touching]) -> bool {
        let fixed = |of: &&Touching| of.other as usize >= self.swept.len();
        let mut fixed = touching.iter().filter(fixed).map(|of| of.other);
        let first = fixed.next();
        fixed.any(|other| Some(other) != first)
            || touching.iter().any(|of| self.approach(body, of) > APPROACH)
    }

    /// Whether a contact of a body collider may be a ghost: one with another body may if the two approach each other.
    fn nears(&self, body: usize, one: &Touching) -> bool {
        one.other as usize >= self.swept.len() || self.approach(body, one) > APPROACH
    }

    /// The speed at which a body collider and what it touches approach each other, m/s.
    fn approach(&self, body: usize, one: &Touching) -> f32 {
        let other = self.swept.get(one.other as usize).map_or(Vec3::ZERO, |other| other.velocity);
        one.normal.dot(other - self.swept[body].velocity)
    }

    /// Whether a contact is a ghost beside another one of the same body collider.
    fn is_ghost_beside(
        &self,
        own: &MovingBody,
        (one, (contact, manifold)): (&Touching, (&Contact, &Manifold)),
        floor: &Touching,
        body: usize,
        world: &World,
    ) -> bool {
        let beside = self.contact_and_manifold(floor.number);
        let contact = self.contact_with((contact, manifold, one.normal), body, world);
        let beside = self.contact_with((beside.0, beside.1, floor.normal), body, world);
        is_ghost(own, &contact, &beside)
    }

    /// Whether a body collider may slide or roll on what it touches, as on a floor: it does not tumble, and another body neither turns nor parts from it.
    fn may_hold(&self, own: &MovingBody, floor: &Touching, (body, dt): (usize, f32)) -> bool {
        let up = floor.normal;
        let holds = |below: &SweptBounds| {
            let turn = below.spin - up * up.dot(below.spin);
            own.allows_gap(up.dot(self.swept[body].velocity - below.velocity) * dt)
                && own.allows_turn((turn * dt).length(), self.reach(floor.other))
        };
        self.swept.get(floor.other as usize).is_none_or(holds) && own.keeps_upright(up)
    }

    /// Whether a body collider may slide from a floor to something else. It looks at motions and centres only: in a heap that falls, few come further.
    fn may_be_beside(
        &self,
        own: &MovingBody,
        one: &Touching,
        floor: &Touching,
        (body, dt): (usize, f32),
    ) -> bool {
        // Inner edges of one mesh are known to itself.
        if floor.other == one.other {
            return false;
        }
        let (up, this) = (floor.normal, &self.swept[body]);
        let [below, other] = [floor, one].map(|of| self.swept.get(of.other as usize));
        let velocity = |of: Option<&SweptBounds>| of.map_or(Vec3::ZERO, |of| of.velocity);
        let floor_velocity = velocity(below);
        let goes_along = |velocity: Vec3| own.allows_gap(up.dot(velocity - floor_velocity) * dt);
        let place = |swept: &SweptBounds| swept.origin + swept.centre;
        let may_be_met = match other {
            Some(other) => {
                own.may_be_above(up.dot(place(this) - place(other))) && goes_along(this.velocity)
            }
            None => below.is_none() || self.approach(body, one) > APPROACH,
        };
        may_be_met && goes_along(velocity(other))
    }

    /// Greatest distance of the surface of a body collider from its centre, metres.
    fn reach(&self, body: u32) -> f32 {
        self.groups.parts[body as usize].reach
    }

    /// A contact with what does not move, or with another body collider, as it is seen from one of its body colliders.
    fn contact_with<'a>(
        &'a self,
        (contact, manifold, normal): (&Contact, &'a Manifold, Vec3),
        body: usize,
        world: &World<'a>,
    ) -> ContactWith<'a> {
        let other = match contact.geometry {
            Some(number) => MovingShape {
                shape: &self.static_geometry[number as usize].shape,
                frame: Frame {
                    translation: contact.offset,
                    rotation: contact.fixed.unwrap_or_default(),
                },
                turn: Vec3::ZERO,
                reach: 0.0,
            },
            None => {
                let origin = self.swept[body].origin;
                let second = contact.a as usize == body;
                let other = if second { contact.b } else { contact.a };
                self.moving_shape(other as usize, origin, world)
            }
        };
        ContactWith { other, manifold, normal, is_second: contact.a as usize != body }
    }

    /// A body collider, seen from an origin.
    fn moving_shape<'a>(&self, body: usize, origin: Vec3, world: &World<'a>) -> MovingShape<'a> {
        let swept = &self.swept[body];
        let translation = swept.frame.translation + (swept.origin - origin);
        MovingShape {
            shape: &world.body_colliders[body].shape,
            frame: Frame { translation, ..swept.frame },
            turn: swept.spin * world.dt,
            reach: self.groups.parts[body].reach,
        }
    }
}
