//! What two that touch remember of each other from one step to the next: where they touch, and what friction holds.
//!
//! # What for
//!
//! Friction that holds must know from where: positions alone say how far something slid in a substep, not how far it is from where it stuck, so
//! that a stack on a slope would creep for ever (see `hold`). And where two touch need not be found again as long as they lie as they lay: in a heap
//! at rest that is a quarter of the work.
//!
//! # When a manifold still holds
//!
//! It was found where the two were less than `reach` apart, and has all corners that were so near. Since then no point of the first one has moved by
//! more than `δ = |Δt| + |Δφ| r` as seen from the second one, with `r` how far out the first one reaches. So it has all that are nearer than `reach -
//! δ` now; if they may come nearer by `m` in this step, it holds while `δ + m ≤ reach`. Manifolds are looked for with a little more than `m`
//! ([`SLACK`]), which is what that leaves. And it holds no longer when the two have turned or slid by half of what a manifold is good for within a
//! step (`pack`).
//!
//! # Whose it is
//!
//! All of it is live state, to be saved and restored with the particles. Contacts are named by those who touch ([`Solid::id`](super::Solid),
//! [`Collider::id`](super::super::Collider)) and not by their places in lists, so that what comes and goes elsewhere changes nothing. A memory that
//! is lost, or is of something else, is none: friction then begins anew. Vectors are in the axes of the world, as they are from substep to substep
//! (`hold`).

use glam::Vec3;

use super::super::Frame;
use super::super::manifold::Manifold;
use super::found::{Found, set};
use super::pack::{Pack, may_slide, may_turn, wear};

/// How much farther than needed manifolds are looked for, as a share of the smaller one's size: two that have moved against each other by less than
/// that keep theirs. More would list pairs that never touch.
pub(super) const SLACK: f32 = 0.03;
/// Which part of what a manifold may be strained in a step it may be when a step begins.
const STRAINED: f32 = 0.5;
/// Cosine of the angle between the normals of what touched and what touches, from which on that is the same contact.
const SAME: f32 = 0.9;

/// What solids that touch remember of each other: live state, to be saved and restored with the particles. Empty by default, and then friction begins
/// anew.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactMemory {
    /// Ascending by who touches, as long as ids of solids and of colliders ascend in their lists.
    pub(super) contacts: Vec<Remembered>,
}

/// What two that touch remember of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remembered {
    pub(super) key: Key,
    /// Of the two shapes, so that another one is not taken for it.
    pub(super) marks: [u64; 2],
    pub(super) manifold: Manifold,
    /// Where the first one was in the coordinates of the second one when that was found.
    pub(super) seen_from: Frame,
    /// How far apart what was looked for then; negative where one of the two is made of triangles, each with a manifold, which are found in each
    /// step.
    pub(super) reach: f32,
    pub(super) grasp: Grasp,
}

/// Who touches whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    /// The first one's id.
    pub(super) a: u64,
    pub(super) other: Other,
    /// Which triangle of those made of such.
    pub(super) nth: u32,
}

impl Key {
    /// Whether it is of the same two.
    fn is_of(&self, other: &Self) -> bool {
        (self.a, self.other) == (other.a, other.other)
    }
}

/// The second one: what it is, and its id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Other {
    Solid(u64),
    Collider(u64),
    Plane(u64),
    /// A box, and which of its walls.
    Wall(u64, u32),
}

/// What friction holds. Vectors in the axes of the world: see `Pack`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Grasp {
    /// How hard the two press each other, N: as an impulse in positions that is `F h²`.
    force: f32,
    /// How far what sticks is from where it stuck, metres, and turned, rad.
    late: Vec3,
    twist: f32,
    up: Vec3,
    arm: Vec3,
    radius: f32,
}

impl ContactMemory {
    /// What a solid remembers of those it touches that come after it, and of what stands; for an engine that keeps that with the solid.
    pub fn of(&self, solid: u64) -> &[Remembered] {
        let first = self.contacts.partition_point(|one| one.key.a < solid);
        let own = &self.contacts[first..];
        &own[..own.partition_point(|one| one.key.a == solid)]
    }

    /// Adds what a solid remembers; to be called for one after the other, in the order of their ids. What another one remembers is left out.
    pub fn add(&mut self, solid: u64, contacts: &[Remembered]) {
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

impl Remembered {
    /// How much the two are strained against each other since the manifold was found, as `Pack` has it; `None` where it holds no longer. `here` is
    /// where the first one is in the second one's coordinates now, `size` how far it reaches and the smaller one of the two, and `reach` how near
    /// they may come.
    pub(super) fn strain(
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
        let strain = turned / may_turn(manifold) + moved / may_slide(manifold, smaller);
        let strain = strain * wear(manifold);
        (moved + turned * size + reach <= self.reach && strain < STRAINED).then_some(strain)
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

impl Grasp {
    /// Of a lane, in a substep of `h` seconds.
    pub(super) fn of(pack: &Pack, lane: usize, h: f32) -> Self {
        let vector = |v: &[[f32; 8]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        let [x, y, z, twist] = &pack.late;
        let grasp = Self {
            force: pack.allowed[lane] / (h * h),
            late: Vec3::new(x[lane], y[lane], z[lane]),
            twist: twist[lane],
            up: vector(&pack.up),
            arm: vector(&pack.arm),
            radius: pack.radius[lane],
        };
        let sum = grasp.late + grasp.up + grasp.arm + grasp.twist + grasp.radius;
        let sound = grasp.force > 0.0 && grasp.force < f32::INFINITY && sum.is_finite();
        if sound { grasp } else { Self::default() }
    }

    /// Whether anything is pressed.
    pub(super) fn presses(&self) -> bool {
        self.force > 0.0
    }

    /// Into a lane.
    pub(super) fn put(&self, pack: &mut Pack, lane: usize, h: f32) {
        let Self { force, late, twist, up, arm, radius } = *self;
        pack.allowed[lane] = force * (h * h);
        let [x, y, z, turned] = &mut pack.late;
        (x[lane], y[lane], z[lane], turned[lane]) = (late.x, late.y, late.z, twist);
        set(&mut pack.up, lane, up);
        set(&mut pack.arm, lane, arm);
        pack.radius[lane] = radius;
    }
}

/// What was remembered, and what is to be. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    was: Vec<Remembered>,
    pub(super) now: Vec<Remembered>,
    /// The first of those that were which is not yet behind.
    next: usize,
    /// How many of those that are now are in order; others came later.
    sorted: usize,
}

impl Memory {
    /// Takes over what is remembered.
    pub(super) fn take(&mut self, memory: &mut ContactMemory) {
        core::mem::swap(&mut self.now, &mut memory.contacts);
        memory.contacts.clear();
    }

    /// Gives it back.
    pub(super) fn give(&mut self, memory: &mut ContactMemory) {
        self.settle();
        core::mem::swap(&mut self.now, &mut memory.contacts);
        self.now.clear();
    }

    /// What is remembered is from before.
    pub(super) fn begin(&mut self) {
        core::mem::swap(&mut self.was, &mut self.now);
        self.now.clear();
        self.next = 0;
    }

    /// What was remembered of a contact; to be asked in ascending order.
    pub(super) fn recall(&mut self, key: &Key) -> Option<&Remembered> {
        while self.was.get(self.next).is_some_and(|one| one.key < *key) {
            self.next += 1;
        }
        self.was.get(self.next).filter(|one| one.key == *key)
    }

    /// Keeps what was [recalled](Self::recall) last, and says where; what it holds only if it is near.
    pub(super) fn keep(&mut self, near: bool) -> u32 {
        let place = self.now.len();
        // At once to where it belongs: it has three hundred bytes.
        self.now.extend_from_slice(&self.was[self.next..=self.next]);
        if !near {
            self.now[place].grasp = Grasp::default();
        }
        place as u32
    }

    /// Keeps what was remembered of two as it was.
    pub(super) fn carry(&mut self, key: &Key) {
        self.recall(key);
        let from = self.next;
        while self.was.get(self.next).is_some_and(|one| one.key.is_of(key)) {
            self.next += 1;
        }
        self.now.extend_from_slice(&self.was[from..self.next]);
    }

    /// What friction held at a place where something was found afresh, if that is the same contact; `frame` is the second one's.
    pub(super) fn learn(&mut self, place: usize, frame: &Frame) {
        let (key, normal) = (self.now[place].key, frame.turn(self.now[place].manifold.normal));
        if let Some(was) = self.recall(&key).filter(|was| was.grasp.up.dot(normal) > SAME) {
            self.now[place].grasp = was.grasp;
        }
    }

    /// Which part of two a manifold is of.
    pub(super) fn part(&self, one: &Found) -> u32 {
        self.now[one.memory as usize].key.nth
    }

    /// Says that all that is remembered by now is in order.
    pub(super) fn in_order(&mut self) {
        self.sorted = self.now.len();
    }

    /// Remembers what comes later than that, and where.
    pub(super) fn learn_late(&mut self, one: Remembered) -> u32 {
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
        for late in was.iter().rev() {
            while from > 0 && now[from - 1].key > late.key {
                (from, to) = (from - 1, to - 1);
                now[to] = now[from];
            }
            to -= 1;
            now[to] = *late;
        }
    }
}

/// Puts them in the order of their keys. Compiled once: sorting is much code, and those that call this are compiled several times.
#[inline(never)]
pub(super) fn sort(remembered: &mut [Remembered]) {
    remembered.sort_unstable_by_key(|one| one.key);
}
