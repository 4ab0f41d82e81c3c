//! Contact cache: the manifold and the friction anchor of each pair that touches, kept from one step to the next.
//!
//! # What for
//!
//! Friction that holds must know from where: positions alone say how far something slid in a substep, not how far it is from where it stuck, so that
//! a stack on a slope would creep for ever (see `friction`). And where two touch need not be found again as long as they lie as they lay: in a heap
//! at rest that is a quarter of the work.
//!
//! # When a manifold still holds
//!
//! It was found where the two were less than `reach` apart, and has all corners that were so near. Since then no point of the first one has moved by
//! more than `δ = |Δt| + |Δφ| r` as seen from the second one, with `r` how far out the first one reaches. So it has all that are nearer than `reach -
//! δ` now; if they may come nearer by `m` in this step, it holds while `δ + m ≤ reach`. Manifolds are looked for with a little more than `m`
//! ([`SLACK`]), which is what that leaves. And it holds no longer when the two have turned or slid by half of what a manifold is good for within a
//! step (`wide_contact`).
//!
//! # Whose it is
//!
//! All of it is live state, to be saved and restored with the particles. Contacts are named by the ids of those that touch
//! ([`BodyCollider::id`](crate::BodyCollider), [`Collider::id`](crate::Collider)) and not by their places in lists, so that what comes and
//! goes elsewhere changes nothing. A cache that is lost, or is of something else, counts as empty: friction then begins anew. Vectors are in the axes
//! of the world, as they are from substep to substep (`friction`).

use glam::{Mat3, Vec3};

use super::super::frame::Frame;
use super::super::manifold::Manifold;
use super::super::words::{Reader, Write};

/// How much farther than needed manifolds are looked for, as a share of the smaller one's size: two that have moved against each other by less than
/// that keep theirs. More would list pairs that never touch.
pub(super) const SLACK: f32 = 0.03;
/// How stale a manifold may be when a step begins, as a share of what it may be within a step.
const STALE: f32 = 0.5;
/// Cosine of the angle between the normals of what touched and what touches, from which on that is the same contact.
const SAME: f32 = 0.9;

/// The angle that two may turn against each other before they are compared again, rad.
const TURNED: f32 = 0.02;
/// The same for how far they may slide on each other, as a share of their size.
const SLID: f32 = 0.03;
/// How much further what is round may turn: about the centre of the rounding that moves nothing, and its points are no farther from there than it is long.
const ROUND: f32 = 2.5;
/// How much faster a manifold becomes stale whose [slope](Manifold::slope) is 1. Its points are points of the two, and as one slides over the rim of
/// the other it touches with others, that are higher by the slope times the way: so that must be less, and no height is wrong by more than `SLID /
/// STEEP` of the size, or what it slides in two substeps (`normal_solve`). Without that a box fell half a millimetre deep into a rim that its manifold did not know of, and was thrown out of it, again
/// and again, for minutes; three times as much finds a tenth more manifolds in a heap of boxes in random poses, for nothing.
const STEEP: f32 = 100.0;

/// Contact cache: the manifolds and friction anchors of body colliders that touch. Live state, to be saved and restored with the particles. Empty by
/// default, and then friction begins anew.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactCache {
    /// Ascending by who touches, as long as ids of body colliders and of colliders ascend in their lists.
    pub(super) contacts: Vec<CachedManifold>,
}

/// A manifold kept from step to step, and the friction anchor of the pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CachedManifold {
    pub(super) key: ContactKey,
    /// Of the two shapes, so that another one is not taken for it.
    pub(super) content_hashes: [u64; 2],
    pub(super) manifold: Manifold,
    /// Where the first one was in the coordinates of the second one when that was found.
    pub(super) seen_from: Frame,
    /// How far apart what was looked for then; negative where one of the two is made of triangles, each with a manifold, which are found in each
    /// step.
    pub(super) reach: f32,
    pub(super) friction_anchor: FrictionAnchor,
}

/// Who touches whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ContactKey {
    /// The first one's id.
    pub(super) a: u64,
    pub(super) other: Other,
    /// Which triangle of those made of such.
    pub(super) nth: u32,
}

impl ContactKey {
    /// Whether it is of the same two.
    fn is_of(&self, other: &Self) -> bool {
        (self.a, self.other) == (other.a, other.other)
    }
}

/// The second one: what it is, and its id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Other {
    BodyCollider(u64),
    /// A collider, and which of its walls, of one that is made of several.
    Collider(u64, u32),
    Plane(u64),
    /// A box, and which of its walls.
    Wall(u64, u32),
}

/// Friction anchor: the accumulated slip and impulse from which friction starts. Vectors in the axes of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FrictionAnchor {
    /// How hard the two press each other, N: as an impulse in positions that is `F h²`.
    pub(super) force: f32,
    /// How far what sticks is from where it stuck, metres, and turned, rad.
    pub(super) accumulated_slip: Vec3,
    pub(super) twist: f32,
    pub(super) up: Vec3,
    pub(super) arm: Vec3,
    pub(super) radius: f32,
}

impl ContactCache {
    /// The manifolds of a body collider with those that come after it, and with static geometry; for an engine that keeps that with the body
    /// collider.
    pub fn of(&self, solid: u64) -> &[CachedManifold] {
        let first = self.contacts.partition_point(|one| one.key.a < solid);
        let own = &self.contacts[first..];
        &own[..own.partition_point(|one| one.key.a == solid)]
    }

    /// The [manifolds](Self::of) of many body colliders, one after the other: of all, in the order of their ids, it goes through the cache once.
    pub fn each(
        &self,
        solids: impl Iterator<Item = u64>,
    ) -> impl Iterator<Item = &[CachedManifold]> {
        let mut rest = &self.contacts[..];
        solids.map(move |solid| {
            let first = rest.iter().position(|one| one.key.a >= solid).unwrap_or(rest.len());
            let own = &rest[first..];
            let end = own.iter().position(|one| one.key.a != solid).unwrap_or(own.len());
            let (own, behind) = own.split_at(end);
            rest = behind;
            own
        })
    }

    /// Adds the manifolds of a body collider; to be called for one after the other, in the order of their ids. Those of another one are left out.
    pub fn add(&mut self, solid: u64, contacts: &[CachedManifold]) {
        self.contacts.extend(contacts.iter().filter(|one| one.key.a == solid));
    }

    /// Forgets everything; its memory is kept.
    pub fn clear(&mut self) {
        self.contacts.clear();
    }

    /// How many contacts it holds.
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }
}

impl CachedManifold {
    /// All of it as words, for whoever stores what contacts remember. Floats stand by their bits.
    pub fn to_words(&self) -> Vec<u32> {
        let Self { key, content_hashes, manifold, seen_from, reach, friction_anchor } = self;
        let mut words = Vec::new();
        words.long(key.a);
        let (kind, id, wall) = match key.other {
            Other::BodyCollider(id) => (0, id, 0),
            Other::Collider(id, wall) => (1, id, wall),
            Other::Plane(id) => (2, id, 0),
            Other::Wall(id, wall) => (3, id, wall),
        };
        words.push(kind);
        words.long(id);
        words.extend([wall, key.nth]);
        content_hashes.iter().for_each(|&hash| words.long(hash));
        manifold.write(&mut words);
        words.vec3(seen_from.translation);
        words.mat3(seen_from.rotation);
        words.float(*reach);
        let FrictionAnchor { force, accumulated_slip, twist, up, arm, radius } = friction_anchor;
        words.float(*force);
        words.vec3(*accumulated_slip);
        words.float(*twist);
        words.vec3(*up);
        words.vec3(*arm);
        words.float(*radius);
        words
    }

    /// The same from its words. `None` if they are too few, too many, or of nothing that there is.
    pub fn from_words(words: &[u32]) -> Option<Self> {
        let mut reader = Reader(words);
        let a = reader.long()?;
        let (kind, id) = (reader.word()?, reader.long()?);
        let (wall, nth) = (reader.word()?, reader.word()?);
        let other = match kind {
            0 => Other::BodyCollider(id),
            1 => Other::Collider(id, wall),
            2 => Other::Plane(id),
            3 => Other::Wall(id, wall),
            _ => return None,
        };
        let key = ContactKey { a, other, nth };
        let content_hashes = [reader.long()?, reader.long()?];
        let manifold = Manifold::read(&mut reader)?;
        let seen_from = Frame { translation: reader.vec3()?, rotation: reader.mat3()? };
        let reach = reader.float()?;
        let friction_anchor = FrictionAnchor {
            force: reader.float()?,
            accumulated_slip: reader.vec3()?,
            twist: reader.float()?,
            up: reader.vec3()?,
            arm: reader.vec3()?,
            radius: reader.float()?,
        };
        reader.all(Self { key, content_hashes, manifold, seen_from, reach, friction_anchor })
    }

    /// How stale the manifold is: how far the two have turned and slid since it was found, as `WideContact` has it; `None` where it holds no longer.
    /// `here` is where the first one is in the second one's coordinates now, `size` how far it reaches and the smaller one of the two, and `reach`
    /// how near they may come.
    pub(super) fn staleness(
        &self,
        here: &Frame,
        (size, smaller): (f32, f32),
        reach: f32,
    ) -> Option<f32> {
        let was = &self.seen_from;
        let moved = (here.translation - was.translation).length();
        let (p, q) = (&here.rotation, &was.rotation);
        let square = (p.x_axis - q.x_axis).length_squared()
            + (p.y_axis - q.y_axis).length_squared()
            + (p.z_axis - q.z_axis).length_squared();
        // |R - S|² = 8 sin² ½φ.
        let turned = (0.5 * square).sqrt();
        let manifold = &self.manifold;
        let staleness = turned / may_turn(manifold) + moved / may_slide(manifold, smaller);
        let staleness = staleness * staleness_rate(manifold);
        (moved + turned * size + reach <= self.reach && staleness < STALE).then_some(staleness)
    }

    /// Whether a point of the two is nearer than so much, metres.
    pub(super) fn is_near(&self, here: &Frame, reach: f32) -> bool {
        let Self { manifold, seen_from, .. } = self;
        let reach = reach + manifold.radii[0] + manifold.radii[1];
        let anchors = |point| manifold.anchors(point, seen_from);
        let apart = |[on_a, on_b]: [Vec3; 2]| manifold.normal.dot(here.point(on_a) - on_b);
        manifold.points().iter().any(|point| apart(anchors(point)) <= reach)
    }
}

/// The angle that the two of a manifold may turn against each other, rad.
pub(super) fn may_turn(manifold: &Manifold) -> f32 {
    if manifold.is_round() { ROUND * TURNED } else { TURNED }
}

/// How far the two of a manifold may slide on each other, metres, of a size; no farther than that.
pub(super) fn may_slide(manifold: &Manifold, size: f32) -> f32 {
    manifold.free.min(size).max(SLID * size)
}

/// How much faster than others a manifold becomes stale.
fn staleness_rate(manifold: &Manifold) -> f32 {
    1.0 + steepness(manifold)
}

/// By how much faster it does because of its slope.
pub(super) fn steepness(manifold: &Manifold) -> f32 {
    STEEP * manifold.slope
}

impl FrictionAnchor {
    /// Whether anything is pressed.
    pub(super) fn is_loaded(&self) -> bool {
        self.force > 0.0
    }
}

/// The cache of the step before, and that of this step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct CacheBuilder {
    was: Vec<CachedManifold>,
    pub(super) now: Vec<CachedManifold>,
    /// The first of those that were which is not yet behind.
    next: usize,
    /// How many of those that are now are in order; others came later.
    sorted: usize,
    /// Who touches whom of those that may be carried over unasked, ascending; whether they are in this step; the first that is not yet; and the first of those
    /// that were which may be one.
    dormant: Vec<ContactKey>,
    carries: bool,
    next_dormant: usize,
    from_dormant: usize,
}

impl CacheBuilder {
    /// Takes over the cache.
    pub(super) fn take(&mut self, cache: &mut ContactCache) {
        core::mem::swap(&mut self.now, &mut cache.contacts);
        cache.contacts.clear();
    }

    /// Gives it back.
    pub(super) fn give(&mut self, cache: &mut ContactCache) {
        self.settle();
        core::mem::swap(&mut self.now, &mut cache.contacts);
        self.now.clear();
    }

    /// Begins a step: what is cached is from the step before. Says whether those that were [noted](Self::note_dormant) are carried over unasked in it.
    pub(super) fn begin(&mut self, carries: bool) {
        self.carries = carries;
        core::mem::swap(&mut self.was, &mut self.now);
        self.now.clear();
        self.next = 0;
        (self.next_dormant, self.from_dormant) = (0, 0);
    }

    /// Notes that none may be carried over unasked.
    pub(super) fn forget_dormant(&mut self) {
        self.dormant.clear();
    }

    /// Notes those from a place on that may be carried over unasked in the next steps.
    pub(super) fn note_dormant(&mut self, from: usize) {
        self.dormant.extend(self.now[from..].iter().map(|one| one.key));
    }

    /// Carries those over unasked that come before a key; without one, all.
    fn carry_dormant(&mut self, before: Option<&ContactKey>) {
        let Self { was, now, dormant, carries, next_dormant, from_dormant, .. } = self;
        if !*carries {
            return;
        }
        while let Some(key) = dormant.get(*next_dormant) {
            if before.is_some_and(|before| before <= key) {
                break;
            }
            *next_dormant += 1;
            while was.get(*from_dormant).is_some_and(|one| one.key < *key) {
                *from_dormant += 1;
            }
            if was.get(*from_dormant).is_some_and(|one| one.key == *key) {
                now.extend_from_slice(&was[*from_dormant..=*from_dormant]);
            }
        }
    }

    /// Where the first manifold of the step before is that does not come before a key; to be asked in ascending order.
    pub(super) fn seek(&mut self, key: &ContactKey) -> usize {
        self.next = self.first_from(self.next, key);
        self.next
    }

    /// The same from a place on.
    fn first_from(&self, from: usize, key: &ContactKey) -> usize {
        let before = self.was[from..].iter().take_while(|one| one.key < *key);
        from + before.count()
    }

    /// The cached manifold at a place, if it has a key.
    pub(super) fn cached(&self, at: usize, key: &ContactKey) -> Option<&CachedManifold> {
        self.was.get(at).filter(|one| one.key == *key)
    }

    /// Says that what is added next has a key, and what is carried over unasked before it belongs here.
    pub(super) fn come_to(&mut self, key: &ContactKey) {
        self.carry_dormant(Some(key));
    }

    /// Keeps what is cached at a place, and says where; what friction holds there only if it is near.
    pub(super) fn keep(&mut self, at: usize, near: bool) -> u32 {
        let place = self.now.len();
        // At once to where it belongs: it has three hundred bytes.
        self.now.extend_from_slice(&self.was[at..=at]);
        if !near {
            self.now[place].friction_anchor = FrictionAnchor::default();
        }
        place as u32
    }

    /// Adds a manifold. What friction held of the one with its key, from a place on, it holds, if that is the same contact; `axes` are the second one's.
    pub(super) fn add(&mut self, mut one: CachedManifold, from: usize, axes: &Mat3) {
        let was = self.cached(self.first_from(from, &one.key), &one.key);
        let normal = *axes * one.manifold.normal;
        if let Some(was) = was.filter(|was| was.friction_anchor.up.dot(normal) > SAME) {
            one.friction_anchor = was.friction_anchor;
        }
        self.now.push(one);
    }

    /// Carries the manifolds of a pair over as they were, from the first of them on.
    pub(super) fn carry_over(&mut self, key: &ContactKey, from: usize) {
        let same = self.was[from..].iter().take_while(|one| one.key.is_of(key)).count();
        self.now.extend_from_slice(&self.was[from..from + same]);
    }

    /// Which part of two a manifold is of.
    pub(super) fn part(&self, cache_index: u32) -> u32 {
        self.now[cache_index as usize].key.nth
    }

    /// Says that all that is cached by now is in order.
    pub(super) fn in_order(&mut self) {
        self.carry_dormant(None);
        self.sorted = self.now.len();
    }

    /// Inserts a missed manifold, and returns where.
    pub(super) fn insert_missed(&mut self, one: CachedManifold) -> u32 {
        let place = match self.now[..self.sorted].binary_search_by_key(&one.key, |one| one.key) {
            Ok(place) => {
                self.now[place] = one;
                place
            }
            Err(_) => {
                self.now.push(one);
                self.now.len() - 1
            }
        };
        place as u32
    }

    /// Puts what came later where it belongs.
    fn settle(&mut self) {
        let Self { was, now, sorted, .. } = self;
        if now.len() <= *sorted {
            return;
        }
        was.clear();
        was.extend(now.drain(*sorted..));
        sort(was);
        // From behind, so that each is moved once.
        let (mut from, mut to) = (now.len(), now.len() + was.len());
        now.extend_from_slice(was);
        for missed in was.iter().rev() {
            while from > 0 && now[from - 1].key > missed.key {
                (from, to) = (from - 1, to - 1);
                now[to] = now[from];
            }
            to -= 1;
            now[to] = *missed;
        }
    }
}

/// Puts them in the order of their keys. Compiled once: sorting is much code, and those that call this are compiled several times.
#[inline(never)]
pub(super) fn sort(remembered: &mut [CachedManifold]) {
    remembered.sort_unstable_by_key(|one| one.key);
}
