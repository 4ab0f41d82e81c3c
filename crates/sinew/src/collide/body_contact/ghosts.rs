//! Drops ghost contacts: those with the inner edges of a floor that is made of several colliders (`manifold::ghost`).
//!
//! Their manifolds stay in the contact cache, since in the next step they may be none.

use core::ops::Range;

use smallvec::SmallVec;

use super::super::frame::Frame;
use super::super::manifold::{Manifold, MovingBody, StaticContact, is_ghost};
use super::super::world::World;
use super::BodyContactSolver;
use super::contact_cache::FrictionAnchor;
use super::wide_contact::Contact;

impl BodyContactSolver {
    /// Removes the ghosts among the contacts of a step, which are sorted by their body colliders. What moves in the step is left alone.
    pub(super) fn drop_ghosts(&mut self, world: &World) {
        let mut ghosts = core::mem::take(&mut self.ghosts);
        ghosts.clear();
        let mut from = 0;
        while let Some(first) = self.contacts.get(from) {
            let of_one = self.with_fixed(first.a, from);
            from = of_one.end;
            let geometry = |number: usize| self.contacts[number].geometry;
            // Most touch one only.
            if !of_one.is_empty() && geometry(of_one.start) != geometry(of_one.end - 1) {
                self.find_ghosts(of_one, world, &mut ghosts);
            }
        }
        for &[ghost, beside] in &ghosts {
            let place = self.contacts[ghost as usize].cache_index as usize;
            self.cache.now[place].friction_anchor = FrictionAnchor::default();
            self.contacts[beside as usize].goes_on = true;
        }
        ghosts.dedup_by_key(|of| of[0]);
        let mut next = ghosts.iter().map(|&[ghost, _]| ghost).peekable();
        let mut number = 0..;
        self.contacts.retain(|_| next.next_if_eq(&number.next().unwrap_or_default()).is_none());
        self.ghosts = ghosts;
    }

    /// Whether a manifold that the broad phase missed is a ghost beside one that it found.
    pub(super) fn is_missed_ghost(
        &self,
        contact: &Contact,
        manifold: &Manifold,
        world: &World,
    ) -> bool {
        let found = &self.contacts[..self.missed.contacts()];
        let mut of_one = self.with_fixed(contact.a, found.partition_point(|one| one.a < contact.a));
        self.static_contact(contact, manifold).is_some_and(|one| {
            of_one.any(|number| self.is_ghost_beside(contact, &one, number, world))
        })
    }

    /// The contacts of a body collider with static geometry, among those from a position on. (Moving geometry may be among them.)
    fn with_fixed(&self, a: u32, from: usize) -> Range<usize> {
        let same = self.contacts[from..].iter().take_while(|one| one.a == a);
        let end = from + same.clone().count();
        // Body colliders come before geometry.
        end - same.skip_while(|one| one.fixed.is_none()).count()..end
    }

    /// Adds the ghosts among the contacts of one body collider with static geometry: the number of each, with that of each contact beside it.
    fn find_ghosts(&self, contacts: Range<usize>, world: &World, ghosts: &mut Vec<[u32; 2]>) {
        let before = ghosts.len();
        for number in contacts.clone() {
            let one = &self.contacts[number];
            // What is a ghost itself holds nothing.
            let is_ghost = |other: usize| ghosts[before..].iter().any(|of| of[0] == other as u32);
            let others = contacts.clone().filter(|&other| !is_ghost(other));
            let manifold = &self.cache.now[one.cache_index as usize].manifold;
            let Some(contact) = self.static_contact(one, manifold) else { continue };
            let beside: SmallVec<[usize; 8]> =
                others.filter(|&other| self.is_ghost_beside(one, &contact, other, world)).collect();
            ghosts.extend(beside.iter().map(|&beside| [number as u32, beside as u32]));
        }
    }

    /// Whether a contact is a ghost beside another one of the same body collider.
    fn is_ghost_beside(
        &self,
        contact: &Contact,
        one: &StaticContact,
        number: usize,
        world: &World,
    ) -> bool {
        let (a, other) = (contact.a as usize, &self.contacts[number]);
        // Inner edges of one mesh are known to itself.
        if other.geometry == contact.geometry {
            return false;
        }
        let manifold = &self.cache.now[other.cache_index as usize].manifold;
        let Some(beside) = self.static_contact(other, manifold) else { return false };
        let swept = &self.swept[a];
        let body = MovingBody {
            shape: &world.body_colliders[a].shape,
            frame: swept.frame,
            turn: swept.spin * world.dt,
            reach: self.groups.parts[a].reach,
        };
        is_ghost(&body, one, &beside)
    }

    /// A manifold of a contact, if its geometry stays where it is in this step.
    fn static_contact<'a>(
        &'a self,
        contact: &Contact,
        manifold: &'a Manifold,
    ) -> Option<StaticContact<'a>> {
        let shape = &self.static_geometry[contact.geometry? as usize].shape;
        let frame = Frame { translation: contact.offset, rotation: contact.fixed? };
        Some(StaticContact { shape, frame, manifold })
    }
}
