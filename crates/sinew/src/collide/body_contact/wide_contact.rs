//! Contacts of a step, and the form in which they are solved: wide contacts of eight manifolds of one colour.
//!
//! A contact is one manifold that may press in the step. Contacts are coloured, so that no two of a colour move the same body collider, and packed into wide
//! contacts of eight. The validity of a manifold under turn and slip of the two is set here, too.
//!
//! # Light body colliders that carry heavy ones
//!
//! These take more sweeps. Gauss–Seidel passes a load on from body to body. With a mass `M` on a mass `m` on the ground, each sweep passes `m/M` of the
//! missing impulse to the ground, and returns the rest. Overlap makes up for a part of it: a body that is too deep by `δ` is pushed by `m δ/h²` from below,
//! so with one sweep the two come to rest at `δ = M g h²/m`, which is 3 mm for 100 kg on 1 kg at 600 substeps a second; for 1000 kg it exceeds what is
//! recovered in a substep, and the light body is pressed into the ground. With `n` sweeps it is an `n`-th of that. So the number of sweeps is about the mass
//! ratio, for the manifolds of the light body, and of those below it that are lighter than the load by as much. Body colliders that share particles with
//! others (bones) have the effective mass of their joints, and are left at one sweep.
//!
//! # Small body colliders
//!
//! These take more sweeps, too, or stacks of them lean and fall. A contact of a body of mass `m` yields by `h²/m` to a force, so one whose points are at a distance
//! `r` from its centre of pressure resists a turn `φ` with the moment `m r² φ/h²`. The weight of a stack of `N` bodies of a reach `a` has the moment `N m g · N a
//! φ` then. With `n` sweeps a contact is about `n` times as stiff, so the stack stands if
//!
//! ```text
//! n > S N² g h²/a
//! ```
//!
//! for `r` about `a`: what counts is the size beside what a body falls in a substep. Gauss–Seidel passes loads on late, so `S` is greater than one: with one sweep
//! stacks of ten to twenty cubes fall at `N² g h²/a` of an eighth, and stand at a fourteenth. [`SMALL`] is for `N = 10` and `S = 24`. At ten substeps of 1/600 s ten
//! cubes of a metre need one sweep then, ten of two centimetres four; and they stand from 5 mm on. The number follows from the size and not from the load: where
//! it changed with that, towers hopped.

use glam::{Mat3, Vec3};

use super::super::impact::ContactParticipant;
use super::super::material::CombinedMaterial;
use super::contact_cache::{CachedManifold, FrictionAnchor, slip_limit, steepness, turn_limit};
use super::turn::{LaneArray, set, store};
use crate::constraints::PlanarDrag;
use crate::lanes::{LANES, Lanes, Vector, get};

/// Distance that stands for infinity, metres: that of a missing point.
pub(super) const FAR: f32 = 1e9;

/// Torsional patch radius of all contacts, as a share of their size. A point contact has no arm to resist a turn in numbers, but any material has a small
/// one: without it a box that stands on a corner, or is clamped between two, would turn about that for ever.
pub(super) const TORSIONAL_RADIUS: f32 = 0.01;

/// Sweeps per substep of a manifold by its level: as many as it needs, or the next power of two.
pub(super) const SWEEPS: [u32; 6] = [1, 2, 4, 8, 16, 32];
/// Mass ratio from which on manifolds take more sweeps. Heaps of crates of different sizes have smaller ratios and rest with one.
const RATIO: f32 = 8.0;
/// Number of body colliders through which a load is followed down.
const DEPTH: usize = 16;
/// Sweeps of small body colliders, as a multiple of `g h²` by the reach of the smaller one: `S N²` for stacks of ten.
const SMALL: f32 = 2400.0;

/// A manifold that may press in this step, as it was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Number of the first body collider, and of the second one; for static geometry its row in `bodies`.
    pub(super) a: u32,
    pub(super) b: u32,
    /// Number of the static geometry, if the second is one.
    pub(super) geometry: Option<u32>,
    /// Rotation of the static geometry, if it stays where it is in this step.
    pub(super) fixed: Option<Mat3>,
    /// Position of the manifold in the contact cache.
    pub(super) cache_index: u32,
    /// Origin of the second body collider, or position of static geometry, from the first one's origin, metres.
    pub(super) offset: Vec3,
    pub(super) combined_material: CombinedMaterial,
    /// The greater one of the magnitudes of gravity on the two, m/s².
    pub(super) gravity: f32,
    pub(super) reports_events: bool,
    pub(super) participants: [ContactParticipant; 2],
    pub(super) colour: u32,
    /// Level of its number of sweeps: an index of [`SWEEPS`].
    pub(super) level: usize,
    /// Reach of the smaller one of the two, metres.
    pub(super) size: f32,
    /// See `WideContact`.
    pub(super) staleness: f32,
    /// See `WideContact`; metres.
    pub(super) torsional_radius: f32,
    /// The normal when the step began, in world axes: from the second towards the first.
    pub(super) normal: Vec3,
    /// Whether the face that is touched goes on beyond its rim in this step, because another collider lies beside it (`ghosts`).
    pub(super) goes_on: bool,
}

impl Contact {
    /// Sort key for packing: colour, level and whether the second one is fixed. Manifolds of different classes are in different wide contacts.
    pub(super) fn class(&self) -> usize {
        2 * (SWEEPS.len() * self.colour as usize + self.level) + usize::from(self.fixed.is_some())
    }
}

/// Assigns the first free colour to each manifold, in their order: no two of a colour share a body collider, so that eight of them can be corrected at once.
/// Returns the number of colours.
pub(super) fn colour(contacts: &mut [Contact], body_colliders: usize, used: &mut Vec<u64>) -> u32 {
    used.clear();
    used.resize(body_colliders, 0);
    let mut most = 0;
    // Manifolds beyond the number of bits get a colour each.
    let mut beyond = u64::BITS;
    for one in contacts {
        let (a, b) = (one.a as usize, one.b as usize);
        let taken = used[a] | used.get(b).copied().unwrap_or(0);
        let free = (!taken).trailing_zeros();
        if free >= u64::BITS {
            one.colour = beyond;
            beyond += 1;
        } else {
            one.colour = free;
            used[a] |= 1 << free;
            if let Some(used) = used.get_mut(b) {
                *used |= 1 << free;
            }
        }
        most = most.max(one.colour + 1);
    }
    most
}

/// Sorts the numbers of manifolds by [class](Contact::class), and within a class those that pressed before first; manifolds of more than two points come at
/// both ends. `begins` is scratch. The order within a colour is free: a wide contact in which nothing presses is soon done with, and one without manifolds of
/// more than two points takes half of the work.
fn by_colour(
    (contacts, cache): (&[Contact], &[CachedManifold]),
    colours: u32,
    order: &mut Vec<u32>,
    begins: &mut Vec<u32>,
) {
    let class = |one: &Contact| {
        let cached = &cache[one.cache_index as usize];
        let kind = match (cached.friction_anchor.is_loaded(), cached.manifold.points().len() > 2) {
            (true, true) => 0,
            (true, false) => 1,
            (false, false) => 2,
            (false, true) => 3,
        };
        4 * one.class() + kind
    };
    begins.clear();
    let classes = 4 * 2 * SWEEPS.len() * colours as usize;
    begins.resize(classes + 1, 0);
    for one in contacts {
        begins[class(one) + 1] += 1;
    }
    for class in 0..classes {
        begins[class + 1] += begins[class];
    }
    order.clear();
    order.resize(contacts.len(), 0);
    for (number, one) in contacts.iter().enumerate() {
        let place = &mut begins[class(one)];
        order[*place as usize] = number as u32;
        *place += 1;
    }
}

/// Packs manifolds into wide contacts, by colour, for substeps of `h` seconds. `null_row` is the null row, `order` and `begins` are scratch; `row` maps a body
/// collider or static geometry to its row in `bodies`, `centre` a body collider to the centre in its own frame.
pub(super) fn pack_contacts(
    (contacts, cache, h): (&[Contact], &[CachedManifold], f32),
    (null_row, colours): (u32, u32),
    [order, begins]: [&mut Vec<u32>; 2],
    wide_contacts: &mut Vec<WideContact>,
    (row, centre): (impl Fn(u32) -> u32, impl Fn(u32) -> Vec3),
) {
    wide_contacts.clear();
    by_colour((contacts, cache), colours, order, begins);
    let (mut class, mut lane) = (usize::MAX, LANES);
    for &number in order.iter() {
        let one = &contacts[number as usize];
        if lane == LANES || one.class() != class {
            wide_contacts.push(WideContact::empty(
                null_row,
                one.fixed.is_some(),
                SWEEPS[one.level],
            ));
            (class, lane) = (one.class(), 0);
        }
        if let Some(wide) = wide_contacts.last_mut() {
            let cached = &cache[one.cache_index as usize];
            let rows = [row(one.a), row(one.b)];
            put((wide, lane), (number, rows), (one, cached), [centre(one.a), centre(one.b)], h);
        }
        lane += 1;
    }
}

/// Puts a contact into a lane, for substeps of `h` seconds. `rows` are those of the two in `bodies`, `centres` their centres in their own frames.
pub(super) fn put(
    (wide, lane): (&mut WideContact, usize),
    (number, rows): (u32, [u32; 2]),
    (one, cached): (&Contact, &CachedManifold),
    centres: [Vec3; 2],
    h: f32,
) {
    (wide.a[lane], wide.b[lane]) = (rows[0], rows[1]);
    wide.number[lane] = number;
    put_manifold(wide, lane, (one, cached), centres);
    wide.staleness[lane] = one.staleness;
    wide.friction[lane] = one.combined_material.friction;
    wide.elastic |= u32::from(one.combined_material.restitution > 0.0) << lane;
    wide.against_static |= u32::from(one.geometry.is_some()) << lane;
    let drags = one.combined_material.drag != PlanarDrag::default();
    wide.kept |= one.reports_events || one.combined_material.restitution > 0.0 || drags;
    wide.set_friction_anchor(lane, &cached.friction_anchor, h);
}

/// Writes the manifold of a contact into a lane.
pub(super) fn put_manifold(
    wide: &mut WideContact,
    lane: usize,
    (one, cached): (&Contact, &CachedManifold),
    [centre_a, centre_b]: [Vec3; 2],
) {
    let seen = |v: Vec3| one.fixed.map_or(v, |axes| axes * v);
    let manifold = &cached.manifold;
    // Of a fixed second one no rotation is loaded, so its axis cannot be used.
    let axial = [manifold.axial[0], manifold.axial[1] & one.fixed.is_none()];
    let [own, theirs] = manifold.radii;
    (wide.radii[0][lane], wide.radii[1][lane]) = (own, theirs);
    wide.round |= theirs > 0.0;
    let bit = |lanes: u32, axial: bool| lanes & !(1 << lane) | u32::from(axial) << lane;
    wide.axial = [bit(wide.axial[0], axial[0]), bit(wide.axial[1], axial[1])];
    wide.own[lane] = match (own > 0.0, theirs > 0.0) {
        _ if one.geometry.is_some() => 1.0,
        (true, false) => 1.0,
        (false, true) => 0.0,
        _ => 0.5,
    };
    let normal = cached.manifold.normal;
    let of_first = theirs > 0.0 && own == 0.0;
    let normal = if of_first { cached.seen_from.turn_back(normal) } else { seen(normal) };
    set(&mut wide.normal, lane, normal);
    set(&mut wide.offset, lane, one.offset);
    wide.steepness[lane] = steepness(&cached.manifold);
    let (turn, slide) = (turn_limit(&cached.manifold), slip_limit(&cached.manifold, one.size));
    (wide.inverse_turn[lane], wide.inverse_slip[lane]) = (1.0 / turn, 1.0 / slide);
    wide.torsional_radius[lane] = one.torsional_radius;
    wide.other_approach[lane] = 2.0 * one.size * turn / slide;
    wide.staleness[lane] = 0.0;
    wide.stale &= !(1 << lane);
    let points = cached.manifold.points();
    if points.is_empty() {
        wide.friction_limit[lane] = 0.0;
    }
    for i in 0..wide.missing.len() {
        let (mut on_a, mut on_b, mut missing) = (Vec3::ZERO, Vec3::ZERO, FAR);
        if let Some(point) = points.get(i) {
            let [a, b] = manifold.anchors_about(point, &cached.seen_from, axial);
            (on_a, on_b, missing) = (a - centre_a, seen(b - centre_b), 0.0);
        }
        set(&mut wide.on_a[i], lane, on_a);
        set(&mut wide.on_b[i], lane, on_b);
        wide.approach[i][lane] = FAR;
        wide.missing[i][lane] = missing;
    }
}

/// Eight manifolds without a common body collider. Aligned to cache lines, because eight lanes that span two of them take twice as long.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct WideContact {
    /// Rows in `bodies` of the first ones, pushed along the normal, and of the second ones, pushed against it.
    pub(super) a: [u32; LANES],
    pub(super) b: [u32; LANES],
    /// Numbers of the contacts; `u32::MAX` in empty lanes.
    pub(super) number: [u32; LANES],
    /// Whether all second ones stay where they are in this step. Their rows are not loaded then, which saves half of the work; most contacts of resting
    /// bodies are of this kind.
    pub(super) fixed: bool,
    /// Number of sweeps per substep, at least 1: see [`set_levels`].
    pub(super) sweeps: u32,
    /// Normal in the second one's axes; in world axes if that is fixed, and in the first one's axes if the second is round and the first is not: a normal
    /// turns with the face, not with the ball on it. Between two round ones it is computed from their positions.
    pub(super) normal: [LaneArray; 3],
    /// Radii of round shapes, metres: see [`Manifold::radii`](crate::collide::manifold::Manifold::radii).
    pub(super) radii: [LaneArray; 2],
    /// Whether the second one of any manifold is round.
    pub(super) round: bool,
    /// A bit for each manifold whose first one, and whose second one, is round about its own y axis alone: see
    /// [`Manifold::axial`](crate::collide::manifold::Manifold::axial).
    pub(super) axial: [u32; 2],
    /// [Anchors](crate::collide::manifold::Manifold::anchors) from the centres, in their own axes, metres; the second one's in world axes if it is fixed.
    pub(super) on_a: [[LaneArray; 3]; 4],
    pub(super) on_b: [[LaneArray; 3]; 4],
    /// Added to the distance of each point, metres: zero for a point that exists, [`FAR`] for a missing one.
    pub(super) missing: [LaneArray; 4],
    /// From the first one's origin to the second one's, metres.
    pub(super) offset: [LaneArray; 3],
    pub(super) friction: LaneArray,
    /// One by the slip up to which the manifold is valid, 1/m.
    pub(super) inverse_slip: LaneArray,
    /// One by the turn up to which the manifold is valid, 1/rad.
    pub(super) inverse_turn: LaneArray,
    /// Distance, per unit of staleness and as a multiple of the valid slip, by which other points of the two may have approached more than those of the
    /// manifold: a turn of `φ` moves these apart by up to `r φ` and others together by as much.
    pub(super) other_approach: LaneArray,
    /// Part of the rate of staleness that comes of the slope: [`steepness`].
    pub(super) steepness: LaneArray,
    /// Turn and slip of the two since the manifold was computed, as a share of what is valid: a touching manifold is recomputed from 1 on.
    pub(super) staleness: LaneArray,
    /// A bit for each manifold that is too stale and has to be recomputed.
    pub(super) stale: u32,
    /// Arm at which friction resists a turn on a point contact, metres: [`TORSIONAL_RADIUS`] of its size, or zero if a body collider shares its particles.
    pub(super) torsional_radius: LaneArray,
    /// Share of the first one's anchor in the arm: 1 against static geometry, or if the first one alone is round, since a ball touches a face where the ball
    /// is; 0 if the second one alone is round; else a half.
    pub(super) own: LaneArray,
    /// Whether forces, approach speeds and totals are kept: a contact has a restitution or a drag, or reports events.
    pub(super) kept: bool,
    /// A bit for each manifold with a restitution: overlap that it recovers does not turn into speed, beyond what a load needs.
    pub(super) elastic: u32,
    /// A bit for each manifold whose second one is static or kinematic geometry.
    pub(super) against_static: u32,
    /// A bit for each manifold that recovered more overlap in this substep than may turn into speed, or one of whose body colliders has a depenetration mark.
    pub(super) depenetrated: u32,
    /// Normal impulses of the points in this substep, kg·m.
    pub(super) force: [LaneArray; 4],
    /// Normal speeds of the points before contacts, m/s; negative when approaching. [`FAR`] for points that do not touch.
    pub(super) approach: [LaneArray; 4],
    /// Normal in world axes, and centre of pressure from the first one's centre, metres.
    pub(super) up: [LaneArray; 3],
    pub(super) arm: [LaneArray; 3],
    /// Root mean square distance of the points from there, metres; and the sum of their impulses, kg·m.
    pub(super) radius: LaneArray,
    pub(super) sum: LaneArray,
    /// Impulse, kg·m, of which friction was used in this substep before the normal solve; and that of which friction is available in the next one: a mean of
    /// the last sums.
    pub(super) friction_limit_used: LaneArray,
    pub(super) friction_limit: LaneArray,
    /// Accumulated slip of a sticking contact, metres, and turn about the normal, rad: the normal solve moved it after the friction solve, and joints took
    /// back a part of the friction (`friction`).
    pub(super) accumulated_slip: [LaneArray; 4],
    /// A bit for each manifold that sticks, and for each that has slid since an impact.
    pub(super) sticking: u32,
    pub(super) sliding: u32,
    /// Sum of the impulses in this step, kg·m.
    pub(super) total: LaneArray,
    /// Depth of the pressing points when the substep began, metres: what the substep before has left.
    pub(super) remaining_overlap: LaneArray,
}

impl WideContact {
    /// A wide contact without manifolds; `null_row` is the null row.
    pub(super) fn empty(null_row: u32, fixed: bool, sweeps: u32) -> Self {
        let (none, vector) = ([0.0; LANES], [[0.0; LANES]; 3]);
        Self {
            a: [null_row; LANES],
            b: [null_row; LANES],
            number: [u32::MAX; LANES],
            fixed,
            sweeps,
            normal: vector,
            radii: [none; 2],
            round: false,
            axial: [0; 2],
            on_a: [vector; 4],
            on_b: [vector; 4],
            missing: [[FAR; LANES]; 4],
            offset: vector,
            friction: none,
            inverse_slip: none,
            inverse_turn: none,
            other_approach: none,
            steepness: none,
            staleness: none,
            stale: 0,
            torsional_radius: none,
            own: none,
            kept: false,
            elastic: 0,
            against_static: 0,
            depenetrated: 0,
            force: [none; 4],
            approach: [[FAR; LANES]; 4],
            up: vector,
            arm: vector,
            radius: none,
            sum: none,
            friction_limit_used: none,
            friction_limit: none,
            accumulated_slip: [none; 4],
            sticking: 0,
            sliding: 0,
            total: none,
            remaining_overlap: none,
        }
    }
}

impl WideContact {
    /// The friction anchor of a lane, from a substep of `h` seconds.
    pub(super) fn friction_anchor(&self, lane: usize, h: f32) -> FrictionAnchor {
        let [x, y, z, twist] = &self.accumulated_slip;
        let friction_anchor = FrictionAnchor {
            force: self.friction_limit[lane] / (h * h),
            accumulated_slip: Vec3::new(x[lane], y[lane], z[lane]),
            twist: twist[lane],
            up: get(&self.up, lane),
            arm: get(&self.arm, lane),
            radius: self.radius[lane],
            slides: self.sliding >> lane & 1 == 1,
        };
        let sum = friction_anchor.accumulated_slip
            + friction_anchor.up
            + friction_anchor.arm
            + friction_anchor.twist
            + friction_anchor.radius;
        let sound =
            friction_anchor.force > 0.0 && friction_anchor.force < f32::INFINITY && sum.is_finite();
        if sound { friction_anchor } else { FrictionAnchor::default() }
    }

    /// Starts friction of a lane from an anchor, for substeps of `h` seconds.
    fn set_friction_anchor(&mut self, lane: usize, anchor: &FrictionAnchor, h: f32) {
        let FrictionAnchor { force, accumulated_slip, twist, up, arm, radius, slides } = *anchor;
        self.sliding = self.sliding & !(1 << lane) | u32::from(slides) << lane;
        self.friction_limit[lane] = force * (h * h);
        let [x, y, z, turned] = &mut self.accumulated_slip;
        (x[lane], y[lane], z[lane], turned[lane]) =
            (accumulated_slip.x, accumulated_slip.y, accumulated_slip.z, twist);
        set(&mut self.up, lane, up);
        set(&mut self.arm, lane, arm);
        self.radius[lane] = radius;
    }

    /// Moves the point of friction to `arm` while a manifold does not press.
    #[inline(always)]
    pub(super) fn let_go<L: Lanes>(&mut self, normal: Vector<L>, arm: Vector<L>) {
        self.radius = [0.0; LANES];
        store(arm, &mut self.arm);
        store(normal, &mut self.up);
    }
}

/// Sets the number of sweeps of each manifold, for substeps of `h` seconds. `mass` is that of a body collider, kg, or `None` if it shares particles or is pinned;
/// `loads` is scratch.
pub(super) fn set_levels(
    (contacts, h): (&mut [Contact], f32),
    body_colliders: usize,
    mass: impl Fn(u32) -> Option<f32>,
    loads: &mut Vec<f32>,
) {
    loads.clear();
    let mut any = false;
    for one in contacts.iter().filter(|one| one.geometry.is_none()) {
        let (Some(a), Some(b)) = (mass(one.a), mass(one.b)) else { continue };
        if a.max(b) < RATIO * a.min(b) {
            continue;
        }
        if !any {
            loads.resize(body_colliders, 0.0);
            any = true;
        }
        let light = if a < b { one.a } else { one.b };
        let load = &mut loads[light as usize];
        *load = load.max(a.max(b));
    }
    for _ in 0..if any { DEPTH } else { 0 } {
        let mut changed = false;
        for one in contacts.iter().filter(|one| one.geometry.is_none()) {
            for (from, to) in [(one.a, one.b), (one.b, one.a)] {
                let (load, Some(mass)) = (loads[from as usize], mass(to)) else { continue };
                if load >= RATIO * mass && load > loads[to as usize] {
                    loads[to as usize] = load;
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    for one in contacts {
        let ratio = |solid: u32| {
            let load = loads.get(solid as usize).copied().unwrap_or(0.0);
            mass(solid).map_or(0.0, |mass| load / mass)
        };
        let other = if one.geometry.is_none() { ratio(one.b) } else { 0.0 };
        let ratio = Some(ratio(one.a).max(other)).filter(|ratio| *ratio >= RATIO);
        let is_alone = mass(one.a).is_some() || one.geometry.is_none() && mass(one.b).is_some();
        let small = if is_alone { SMALL * one.gravity * (h * h) / one.size } else { 0.0 };
        let needed = small.max(ratio.unwrap_or(0.0));
        let enough = SWEEPS.iter().position(|&sweeps| sweeps as f32 >= needed);
        one.level = enough.unwrap_or(SWEEPS.len() - 1);
    }
}
