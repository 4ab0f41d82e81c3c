//! Contact cache: the manifold and the friction anchor of each pair in contact, kept from one step to the next.
//!
//! # What for
//!
//! Static friction needs its anchor: positions alone give the slip of a substep, but not the distance from where a contact stuck, so that a stack on a slope
//! would creep for ever (see `friction`). And manifolds need not be computed again while two bodies lie as they lay: in a heap at rest that is a quarter of
//! the work.
//!
//! # When a manifold is still valid
//!
//! It was computed where the two were less than `reach` apart, and has all points up to that distance. Since then no point of the first one has moved by more
//! than `δ = |Δt| + |Δφ| r` in the frame of the second, with `r` the reach of the first. So it has all points that are nearer than `reach - δ` now; if they
//! may approach by `m` in this step, it is valid while `δ + m ≤ reach`. Manifolds are computed up to a little more than `m` ([`SLACK`]), which leaves that
//! room. It also becomes invalid when the two have turned or slid by half of what a manifold allows within a step (`wide_contact`).
//!
//! # Saving and restoring
//!
//! All of it is live state, to be saved and restored with the particles. Contacts are named by the ids of their participants
//! ([`BodyCollider::id`](crate::BodyCollider), [`Collider::id`](crate::Collider)) and not by list positions, so that additions and removals elsewhere change
//! nothing. A cache that is lost or belongs to another world counts as empty: friction then starts anew. Vectors are in world axes, as they are from substep
//! to substep (`friction`).

use glam::{Mat3, Vec3};

use super::super::frame::Frame;
use super::super::manifold::Manifold;
use super::super::words::{Reader, Write};

/// Distance beyond need up to which manifolds are computed, as a share of the smaller one's size: pairs that have moved against each other by less than that
/// keep theirs. A greater value would list pairs that never touch.
pub(super) const SLACK: f32 = 0.03;
/// Limit of staleness when a step begins, as a share of the limit within a step.
const MAX_STALENESS: f32 = 0.5;
/// Cosine of the angle between the old and the new normal, from which on a contact counts as the same.
const SAME_NORMAL: f32 = 0.9;

/// Turn of the two against each other up to which a manifold is valid, rad.
const MAX_TURN: f32 = 0.02;
/// The same for their slip, as a share of their size.
const MAX_SLIP: f32 = 0.03;
/// Factor on the valid turn of round shapes: turning about the centre of the rounding moves no point, and the anchors are no farther from it than the shape
/// is long.
const ROUND_FACTOR: f32 = 2.5;
/// Factor on the rate of staleness of a manifold whose [slope](Manifold::slope) is 1. Its points are fixed to the two, and as one slides over the rim of the
/// other it touches with other points, which are higher by the slope times the slip. With this factor no height is wrong by more than `MAX_SLIP /
/// SLOPE_FACTOR` of the size, or by the slip of two substeps (`normal_solve`). Without it a box fell half a millimetre deep into a rim that its manifold did
/// not have, and was thrown out of it, again and again, for minutes; a factor of three times as much computes a tenth more manifolds in a heap of boxes in
/// random poses, without a gain.
const SLOPE_FACTOR: f32 = 100.0;

/// Contact cache: the manifolds and friction anchors of body colliders in contact. Live state, to be saved and restored with the particles. Empty by default;
/// friction then starts anew.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactCache {
    /// Ascending by key, as long as the ids of body colliders and of colliders ascend in their lists.
    pub(super) contacts: Vec<CachedManifold>,
}

/// A manifold that is kept from step to step, with the friction anchor of the pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CachedManifold {
    pub(super) key: ContactKey,
    /// Content hashes of the two shapes, to detect a changed shape.
    pub(super) content_hashes: [u64; 2],
    pub(super) manifold: Manifold,
    /// The first one's frame in the coordinates of the second when the manifold was computed.
    pub(super) seen_from: Frame,
    /// Distance up to which it has all points, metres; as a negative number for one of triangles: up to that distance the pair has a manifold for each plane of them.
    pub(super) reach: f32,
    pub(super) friction_anchor: FrictionAnchor,
}

/// The participants of a manifold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ContactKey {
    /// Id of the first body collider.
    pub(super) a: u64,
    pub(super) other: Other,
    /// Triangle of a mesh, of several coplanar ones the first.
    pub(super) nth: u32,
}

impl ContactKey {
    /// Whether it has the same two participants.
    fn is_of(&self, other: &Self) -> bool {
        (self.a, self.other) == (other.a, other.other)
    }
}

/// The second participant: its kind and its id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Other {
    BodyCollider(u64),
    /// A collider, and the number of its half-space if it is made of several.
    Collider(u64, u32),
    Plane(u64),
    /// A box, and the number of its wall.
    Wall(u64, u32),
}

/// Friction anchor: the accumulated slip and the normal force from which friction starts. Vectors in world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FrictionAnchor {
    /// Normal force between the two, N. As an impulse in positions it is `F h²`.
    pub(super) force: f32,
    /// Distance of a sticking contact from where it stuck, metres, and its turn, rad.
    pub(super) accumulated_slip: Vec3,
    pub(super) twist: f32,
    pub(super) up: Vec3,
    pub(super) arm: Vec3,
    pub(super) radius: f32,
    /// Whether the contact has slid since an impact.
    pub(super) slides: bool,
}

impl ContactCache {
    /// The manifolds of a body collider, by id, with body colliders after it and with static geometry; for an engine that stores them with the body collider.
    pub fn of(&self, solid: u64) -> &[CachedManifold] {
        let first = self.contacts.partition_point(|one| one.key.a < solid);
        let own = &self.contacts[first..];
        &own[..own.partition_point(|one| one.key.a == solid)]
    }

    /// The [manifolds](Self::of) of many body colliders, one slice each. `solids` must be ids in ascending order; the cache is traversed once.
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

    /// Adds the manifolds of a body collider. Call it for one after the other, in ascending order of their ids. Manifolds of other ids are left out.
    pub fn add(&mut self, solid: u64, contacts: &[CachedManifold]) {
        self.contacts.extend(contacts.iter().filter(|one| one.key.a == solid));
    }

    /// Removes everything and keeps the memory.
    pub fn clear(&mut self) {
        self.contacts.clear();
    }

    /// The number of manifolds in the cache.
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Whether the cache is empty.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }
}

impl CachedManifold {
    /// The whole entry as words, for storing it. Floats are stored by their bits.
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
        let FrictionAnchor { force, accumulated_slip, twist, up, arm, radius, slides } =
            friction_anchor;
        words.float(*force);
        words.vec3(*accumulated_slip);
        words.float(*twist);
        words.vec3(*up);
        words.vec3(*arm);
        words.float(*radius);
        words.push(u32::from(*slides));
        words
    }

    /// The entry from its words. `None` if their number is wrong or they encode no valid entry.
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
            slides: reader.word()? != 0,
        };
        reader.all(Self { key, content_hashes, manifold, seen_from, reach, friction_anchor })
    }

    /// Staleness of the manifold as in `WideContact`: turn and slip of the two since it was computed, as a share of what is allowed. `None` if it is no
    /// longer valid. `here` is the first one's present frame in the coordinates of the second, `size` the reach of the first and of the smaller one, and
    /// `reach` the distance up to which they may touch, metres.
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
        let staleness = turned / turn_limit(manifold) + moved / slip_limit(manifold, smaller);
        let staleness = staleness * staleness_rate(manifold);
        (moved + turned * size + reach <= self.reach.abs() && staleness < MAX_STALENESS)
            .then_some(staleness)
    }

    /// Whether it is one of a triangle.
    pub(super) fn is_of_triangle(&self) -> bool {
        self.reach < 0.0
    }

    /// Whether a point of the manifold is nearer than `reach`, metres.
    pub(super) fn is_near(&self, here: &Frame, reach: f32) -> bool {
        let Self { manifold, seen_from, .. } = self;
        let reach = reach + manifold.radii[0] + manifold.radii[1];
        let anchors = |point| manifold.anchors(point, seen_from);
        let apart = |[on_a, on_b]: [Vec3; 2]| manifold.normal.dot(here.point(on_a) - on_b);
        manifold.points().iter().any(|point| apart(anchors(point)) <= reach)
    }
}

/// Turn of the two up to which a manifold is valid, rad.
pub(super) fn turn_limit(manifold: &Manifold) -> f32 {
    if manifold.is_round() { ROUND_FACTOR * MAX_TURN } else { MAX_TURN }
}

/// Slip of the two up to which a manifold is valid, metres; for shapes of a size, and at most that.
pub(super) fn slip_limit(manifold: &Manifold, size: f32) -> f32 {
    manifold.slide_limit.min(size).max(MAX_SLIP * size)
}

/// Factor on the rate at which a manifold becomes stale.
fn staleness_rate(manifold: &Manifold) -> f32 {
    1.0 + steepness(manifold)
}

/// The part of that factor, beyond 1, that comes of its slope.
pub(super) fn steepness(manifold: &Manifold) -> f32 {
    SLOPE_FACTOR * manifold.slope
}

impl FrictionAnchor {
    /// Whether the contact carries a load.
    pub(super) fn is_loaded(&self) -> bool {
        self.force > 0.0
    }
}

/// The cache of the step before, and that of this step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct CacheBuilder {
    was: Vec<CachedManifold>,
    pub(super) now: Vec<CachedManifold>,
    /// The first manifold of the step before that the search has not passed.
    next: usize,
    /// How many of this step's manifolds are sorted; missed ones follow.
    sorted: usize,
    /// Keys of the manifolds that may be carried over without a query, ascending; whether this step does so; the first key not yet carried; and the first
    /// manifold of the step before that may have it.
    dormant: Vec<ContactKey>,
    carries_dormant: bool,
    next_dormant: usize,
    from_dormant: usize,
}

impl CacheBuilder {
    /// Takes the manifolds out of the cache.
    pub(super) fn take(&mut self, cache: &mut ContactCache) {
        core::mem::swap(&mut self.now, &mut cache.contacts);
        cache.contacts.clear();
    }

    /// Returns the manifolds to the cache.
    pub(super) fn give(&mut self, cache: &mut ContactCache) {
        self.merge_missed();
        core::mem::swap(&mut self.now, &mut cache.contacts);
        self.now.clear();
    }

    /// Begins a step: the present manifolds become those of the step before. With `carries_dormant`, the [listed](Self::note_dormant) ones are carried over
    /// without a query.
    pub(super) fn begin(&mut self, carries_dormant: bool) {
        self.carries_dormant = carries_dormant;
        core::mem::swap(&mut self.was, &mut self.now);
        self.now.clear();
        self.next = 0;
        (self.next_dormant, self.from_dormant) = (0, 0);
    }

    /// Clears the list of manifolds that are carried over without a query.
    pub(super) fn forget_dormant(&mut self) {
        self.dormant.clear();
    }

    /// Lists the manifolds from a position on as ones to carry over without a query in the next steps.
    pub(super) fn note_dormant(&mut self, from: usize) {
        self.dormant.extend(self.now[from..].iter().map(|one| one.key));
    }

    /// Carries over the listed manifolds before a key; without one, all.
    fn carry_dormant(&mut self, before: Option<&ContactKey>) {
        let Self { was, now, dormant, carries_dormant, next_dormant, from_dormant, .. } = self;
        if !*carries_dormant {
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

    /// Position of the first manifold of the step before whose key is not less than `key`. Keys must be passed in ascending order.
    pub(super) fn seek(&mut self, key: &ContactKey) -> usize {
        self.next = self.first_from(self.next, key);
        self.next
    }

    /// Like [`seek`](Self::seek), from a position on.
    fn first_from(&self, from: usize, key: &ContactKey) -> usize {
        let before = self.was[from..].iter().take_while(|one| one.key < *key);
        from + before.count()
    }

    /// The manifold of the step before at a position, if it has the key.
    pub(super) fn cached(&self, at: usize, key: &ContactKey) -> Option<&CachedManifold> {
        self.was.get(at).filter(|one| one.key == *key)
    }

    /// The manifold of the step before at a position.
    pub(super) fn before(&self, at: usize) -> &CachedManifold {
        &self.was[at]
    }

    /// All manifolds of the step before of the same pair, from the first of them on.
    pub(super) fn of_pair(&self, first: usize, key: &ContactKey) -> &[CachedManifold] {
        let rest = &self.was[first..];
        &rest[..rest.iter().take_while(|one| one.key.is_of(key)).count()]
    }

    /// Prepares to add manifolds of a key: carries over the listed ones before it.
    pub(super) fn advance_to(&mut self, key: &ContactKey) {
        self.carry_dormant(Some(key));
    }

    /// Keeps the manifold of the step before at a position and returns its new one; its friction anchor only if it is near.
    pub(super) fn keep(&mut self, at: usize, near: bool) -> u32 {
        let place = self.now.len();
        // Written in place, because an entry has three hundred bytes.
        self.now.extend_from_slice(&self.was[at..=at]);
        if !near {
            self.now[place].friction_anchor = FrictionAnchor::default();
        }
        place as u32
    }

    /// Adds a manifold without a friction anchor.
    pub(super) fn add(&mut self, one: CachedManifold) {
        self.now.push(one);
    }

    /// Hands the friction anchors of a pair's manifolds of the step before, from the position `from` on, to its new ones, from `first` on, where their normals
    /// agree; `axes` are those of the second participant. Each goes to the manifold with its key; if that is gone, to the first that has none: a body that
    /// slides over a floor of triangles touches others of them, and rests on the same floor.
    pub(super) fn hand_on_anchors(&mut self, from: usize, first: usize, axes: &Mat3) {
        let Some(key) = self.now.get(first).map(|one| ContactKey { nth: 0, ..one.key }) else {
            return;
        };
        let from = self.first_from(from, &key);
        let count = self.of_pair(from, &key).len();
        let Self { was, now, .. } = self;
        let (was, now) = (&was[from..from + count], &mut now[first..]);
        let agrees = |was: &CachedManifold, one: &CachedManifold| {
            was.friction_anchor.up.dot(*axes * one.manifold.normal) > SAME_NORMAL
        };
        for one in &mut *now {
            let same = was.iter().find(|was| was.key == one.key && agrees(was, one));
            one.friction_anchor = same.map_or(one.friction_anchor, |was| was.friction_anchor);
        }
        for was in was {
            if now.iter().any(|one| one.key == was.key) {
                continue;
            }
            let is_next = |one: &&mut CachedManifold| {
                one.friction_anchor == FrictionAnchor::default() && agrees(was, one)
            };
            if let Some(next) = now.iter_mut().find(is_next) {
                next.friction_anchor = was.friction_anchor;
            }
        }
    }

    /// Carries over the manifolds of a pair unchanged, from the position of the first on.
    pub(super) fn carry_over(&mut self, key: &ContactKey, from: usize) {
        let same = self.of_pair(from, key).len();
        self.now.extend_from_slice(&self.was[from..from + same]);
    }

    /// Part (triangle) that a manifold belongs to.
    pub(super) fn part(&self, cache_index: u32) -> u32 {
        self.now[cache_index as usize].key.nth
    }

    /// Ends the sorted part: all manifolds that follow are missed ones.
    pub(super) fn in_order(&mut self) {
        self.carry_dormant(None);
        self.sorted = self.now.len();
    }

    /// Inserts a missed manifold and returns its position.
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

    /// Merges the missed manifolds into the sorted ones.
    fn merge_missed(&mut self) {
        let Self { was, now, sorted, .. } = self;
        if now.len() <= *sorted {
            return;
        }
        was.clear();
        was.extend(now.drain(*sorted..));
        sort(was);
        // From the end, so that each is moved once.
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

/// Sorts manifolds by key. Not inlined: sorting is much code, and its callers are compiled several times.
#[inline(never)]
fn sort(manifolds: &mut [CachedManifold]) {
    manifolds.sort_unstable_by_key(|one| one.key);
}
