//! Contacts of a step, and the form in which they are solved: eight manifolds of one colour side by side.
//!
//! A contact is one manifold that may come to press. Contacts are coloured, so that no two of a colour move the same body collider, and packed into wide
//! contacts of eight. How long a manifold is valid while the two turn and slide on each other is said here, too.
//!
//! # Light body colliders that carry heavy ones
//!
//! Those take more sweeps. Gauss and Seidel's way hands a load down from body to body. Of a mass `M` that lies on a mass `m` on the ground, each sweep
//! brings `m/M` of what is missing to the ground, and gives the rest back. Overlap makes up for a part of it: what is in too deep by `δ` is pushed by
//! `m δ/h²` from below, so with one sweep the two come to rest where `δ = M g h²/m`, which is 3 mm for 100 kg on 1 kg at 600 substeps a second, and for
//! 1000 kg more than is recovered in a substep: the light one is pressed into the ground. With `n` sweeps it is an `n`-th of that. So they are swept
//! about as often as the ratio is; and not those alone, but all that the light one lies on and is lighter than its load by as much. Body colliders that
//! share particles with others (bones) are as heavy as their joints make them, and are left alone.

use glam::{Mat3, Vec3};

use super::super::impact::ContactParticipant;
use super::super::material::CombinedMaterial;
use super::contact_cache::{CachedManifold, FrictionAnchor, may_slide, may_turn, steepness};
use super::turn::{LaneArray, set, store};
use crate::constraints::PlanarDrag;
use crate::lanes::{LANES, Lanes, Vector};

/// As good as infinitely far out, metres: what a missing point is.
pub(super) const FAR: f32 = 1e9;

/// Torsional patch radius of everything, as a share of its size. What touches in a point has no arm to stop a turn on it with, in numbers; of any
/// stuff there is one, and a box that stands on a corner, or hangs between two, does not turn about that for ever.
pub(super) const TORSIONAL_RADIUS: f32 = 0.01;

/// How often manifolds are pressed in a substep, by their level: as often as the ratio of masses, or the next power of two, where that is more than
/// [`RATIO`].
pub(super) const SWEEPS: [u32; 4] = [1, 8, 16, 32];
/// From which ratio of masses on manifolds take more sweeps. A heap of crates of different sizes has less in it, and rests as it is.
const RATIO: f32 = 8.0;
/// How far down a load is followed, body colliders.
const DEPTH: usize = 16;

/// A manifold that may come to press in this step, as it was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Numbers of the body colliders; where the second one stands, its row among the bodies.
    pub(super) a: u32,
    pub(super) b: u32,
    /// Number of the static geometry, if the second one is some.
    pub(super) geometry: Option<u32>,
    /// The axes of that, if it stays where it is in this step.
    pub(super) fixed: Option<Mat3>,
    /// Its place in the contact cache, where the manifold is.
    pub(super) cache_index: u32,
    /// The second one's origin, or where it is, from the first one's origin, metres.
    pub(super) offset: Vec3,
    pub(super) combined_material: CombinedMaterial,
    pub(super) reports_events: bool,
    pub(super) participants: [ContactParticipant; 2],
    pub(super) colour: u32,
    /// How often it is pressed in a substep: [`SWEEPS`] has the number.
    pub(super) level: usize,
    /// How far the smaller one of the two reaches, metres.
    pub(super) size: f32,
    /// See `WideContact`.
    pub(super) staleness: f32,
    /// See `WideContact`; metres.
    pub(super) torsional_radius: f32,
}

impl Contact {
    /// Its colour, and which part of that it is of: what is pressed as often has wide contacts of its own, and of that static geometry.
    pub(super) fn class(&self) -> usize {
        2 * (SWEEPS.len() * self.colour as usize + self.level) + usize::from(self.fixed.is_some())
    }
}

/// A sensor that overlaps a body collider.
#[derive(Clone, Copy, Debug)]
pub(super) struct SensorOverlap {
    pub(super) participants: [ContactParticipant; 2],
    pub(super) point: Vec3,
    pub(super) normal: Vec3,
}

/// Gives manifolds colours: of one colour no two have a body collider in common, so that eight of them can be corrected at once. By their order, the
/// first colour that is free.
pub(super) fn colour(contacts: &mut [Contact], body_colliders: usize, used: &mut Vec<u64>) -> u32 {
    used.clear();
    used.resize(body_colliders, 0);
    let mut most = 0;
    // What has more manifolds than there are bits gets a colour for each.
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

/// Numbers of manifolds by [class](Contact::class), and of one class first those that pressed before, then as they are; those with more than two points at both
/// ends. `begins` is scratch. Those of a colour may come in any order: a wide contact in which nothing presses is soon done with, and one in which none has more
/// than two points takes half of the work.
fn by_colour(
    (contacts, cache): (&[Contact], &[CachedManifold]),
    colours: u32,
    order: &mut Vec<u32>,
    begins: &mut Vec<u32>,
) {
    let class = |one: &Contact| {
        let known = &cache[one.cache_index as usize];
        let kind = match (known.friction_anchor.is_loaded(), known.manifold.points().len() > 2) {
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

/// Packs manifolds of one of so many colours by eights, for substeps of `h` seconds. `order` and `begins` are scratch; `row` is where a body collider
/// or static geometry is among the bodies, `centre` that of a body collider in its own frame.
pub(super) fn pack_contacts(
    (contacts, cache, h): (&[Contact], &[CachedManifold], f32),
    (nothing, colours): (u32, u32),
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
            wide_contacts.push(WideContact::empty(nothing, one.fixed.is_some(), SWEEPS[one.level]));
            (class, lane) = (one.class(), 0);
        }
        if let Some(wide) = wide_contacts.last_mut() {
            let known = &cache[one.cache_index as usize];
            let rows = [row(one.a), row(one.b)];
            put((wide, lane), (number, rows), (one, known), [centre(one.a), centre(one.b)], h);
        }
        lane += 1;
    }
    keep_for_impacts(wide_contacts);
}

/// Lets all wide contacts keep what a restitution needs, if anything has one: what was not fast itself may take part in an impact.
pub(super) fn keep_for_impacts(wide_contacts: &mut [WideContact]) {
    if wide_contacts.iter().any(|wide| wide.elastic != 0) {
        wide_contacts.iter_mut().for_each(|wide| wide.kept = true);
    }
}

/// Puts one of a number into a lane, for substeps of `h` seconds. `rows` are those of the two among the bodies, `centres` those in their own frames.
pub(super) fn put(
    (wide, lane): (&mut WideContact, usize),
    (number, rows): (u32, [u32; 2]),
    (one, known): (&Contact, &CachedManifold),
    centres: [Vec3; 2],
    h: f32,
) {
    (wide.a[lane], wide.b[lane]) = (rows[0], rows[1]);
    wide.number[lane] = number;
    put_manifold(wide, lane, (one, known), centres);
    wide.staleness[lane] = one.staleness;
    wide.friction[lane] = one.combined_material.friction;
    wide.elastic |= u32::from(one.combined_material.restitution > 0.0) << lane;
    wide.against_static |= u32::from(one.geometry.is_some()) << lane;
    let drags = one.combined_material.drag != PlanarDrag::default();
    wide.kept |= one.reports_events || one.combined_material.restitution > 0.0 || drags;
    wide.set_friction_anchor(lane, &known.friction_anchor, h);
}

/// Writes what two shapes are to each other into a lane.
pub(super) fn put_manifold(
    wide: &mut WideContact,
    lane: usize,
    (one, known): (&Contact, &CachedManifold),
    [centre_a, centre_b]: [Vec3; 2],
) {
    let seen = |v: Vec3| one.fixed.map_or(v, |axes| axes * v);
    let manifold = &known.manifold;
    // Of what stays where it is the axis is not loaded, and its normal does not turn.
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
    let normal = known.manifold.normal;
    let of_first = theirs > 0.0 && own == 0.0;
    let normal = if of_first { known.seen_from.turn_back(normal) } else { seen(normal) };
    set(&mut wide.normal, lane, normal);
    set(&mut wide.offset, lane, one.offset);
    wide.steepness[lane] = steepness(&known.manifold);
    let (turn, slide) = (may_turn(&known.manifold), may_slide(&known.manifold, one.size));
    (wide.bent[lane], wide.stiff[lane]) = (1.0 / turn, 1.0 / slide);
    wide.torsional_radius[lane] = one.torsional_radius;
    wide.elsewhere[lane] = 2.0 * one.size * turn / slide;
    wide.staleness[lane] = 0.0;
    wide.stale &= !(1 << lane);
    let points = known.manifold.points();
    if points.is_empty() {
        wide.friction_limit[lane] = 0.0;
    }
    for i in 0..wide.missing.len() {
        let (mut on_a, mut on_b, mut missing) = (Vec3::ZERO, Vec3::ZERO, FAR);
        if let Some(point) = points.get(i) {
            let [a, b] = manifold.anchors_about(point, &known.seen_from, axial);
            (on_a, on_b, missing) = (a - centre_a, seen(b - centre_b), 0.0);
        }
        set(&mut wide.on_a[i], lane, on_a);
        set(&mut wide.on_b[i], lane, on_b);
        wide.approach[i][lane] = FAR;
        wide.missing[i][lane] = missing;
    }
}

/// Eight manifolds that have no solid in common; on lines of the cache of its own, because an eight that lies across two of them costs twice as much.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct WideContact {
    /// Rows of the bodies that are pushed along the normal, and of those that are pushed back.
    pub(super) a: [u32; LANES],
    pub(super) b: [u32; LANES],
    /// Which of the manifolds that were found it is.
    pub(super) number: [u32; LANES],
    /// Whether all of the second ones stay where they are in this step: then nothing of them is asked. Most of what lies somewhere lies on such, and
    /// of all that is reckoned for two bodies half is for the second one.
    pub(super) fixed: bool,
    /// How often they are pressed in a substep, 1 and up: see [`set_levels`].
    pub(super) sweeps: u32,
    /// In the second one's axes; in the world's if that stays where it is, and in the first one's if the second one is round and the first one is not:
    /// a normal turns with the face, and not with the ball on it. Of two that are round it follows from where they are.
    pub(super) normal: [LaneArray; 3],
    /// Radii of what is round, metres: see [`Manifold::radii`](crate::collide::manifold::Manifold::radii).
    pub(super) radii: [LaneArray; 2],
    /// Whether the second one of any is round.
    pub(super) round: bool,
    /// A bit for each manifold whose first one, and whose second one, is round about its own y axis alone: see [`Manifold::axial`](crate::collide::manifold::Manifold::axial).
    pub(super) axial: [u32; 2],
    /// [Anchors](crate::collide::manifold::Manifold::anchors) from the centres, in their own axes, metres; the second one's in the world's if that stays where it is.
    pub(super) on_a: [[LaneArray; 3]; 4],
    pub(super) on_b: [[LaneArray; 3]; 4],
    /// Added to the distance of each point, metres: none for one that is there.
    pub(super) missing: [LaneArray; 4],
    /// From the first one's origin to the second one's, metres.
    pub(super) offset: [LaneArray; 3],
    pub(super) friction: LaneArray,
    /// One by the length that the two may slide on each other before they are compared again, 1/m.
    pub(super) stiff: LaneArray,
    /// One by the angle that they may turn against each other before that, 1/rad.
    pub(super) bent: LaneArray,
    /// By how much more than the staleness says, times what they may slide, others of their points may have come nearer than those of the manifold: a
    /// turn of `φ` takes these away by up to `r φ` and others there by as much.
    pub(super) elsewhere: LaneArray,
    /// By how much faster than others they become stale by that, and by turning: [`steepness`].
    pub(super) steepness: LaneArray,
    /// How much they have turned and slid since they were compared: 1 is as much as they may, where they touch.
    pub(super) staleness: LaneArray,
    /// A bit for each that is too stale for what it is needed for, and is to be compared again.
    pub(super) stale: u32,
    /// The arm at which friction acts against turning on what is a point, metres: [`TORSIONAL_RADIUS`] of its size, if its particles are nobody
    /// else's.
    pub(super) torsional_radius: LaneArray,
    /// How much of the arm is the first one's anchor: 1 if the second one stands, or the first one alone is round, for a ball touches a face where the ball is;
    /// none if the second one alone is; else a half.
    pub(super) own: LaneArray,
    /// Whether approach and place are to be kept: something bounces, or somebody listens.
    pub(super) kept: bool,
    /// A bit for each manifold with a restitution: what it recovers of an overlap never turns into speed, but for what a load needs.
    pub(super) elastic: u32,
    /// A bit for each manifold whose second one is static geometry, moving or not.
    pub(super) against_static: u32,
    /// A bit for each manifold where more overlap was recovered in this substep than may turn into speed, or one of whose body colliders comes from
    /// where that was.
    pub(super) depenetrated: u32,
    /// Of the substep: impulses of the points, kg·m.
    pub(super) force: [LaneArray; 4],
    /// Their speeds before contacts, m/s; negative when approaching. [`FAR`] for what touches nothing.
    pub(super) approach: [LaneArray; 4],
    /// Normal in the world, and the centre of pressure from the first one's centre, metres.
    pub(super) up: [LaneArray; 3],
    pub(super) arm: [LaneArray; 3],
    /// How far the points are from there; and the sum of their impulses, kg·m.
    pub(super) radius: LaneArray,
    pub(super) sum: LaneArray,
    /// Against how much of such a sum friction has acted in this substep, before it was pressed; and may act in the next: a mean of the last ones.
    pub(super) friction_limit_used: LaneArray,
    pub(super) friction_limit: LaneArray,
    /// How far what sticks is from where it stuck, metres, and has turned about the normal, rad: pressing moved it after it was held,
    /// and joints took a part of what held it (`friction`).
    pub(super) accumulated_slip: [LaneArray; 4],
    /// A bit for each manifold that sticks.
    pub(super) sticking: u32,
    /// Of the step: sum of the impulses, kg·m.
    pub(super) total: LaneArray,
    /// How deep the points that press were in when the substep began, metres: what the one before has left.
    pub(super) left: LaneArray,
}

impl WideContact {
    /// One without manifolds; `nothing` is the row of nothing.
    pub(super) fn empty(nothing: u32, fixed: bool, sweeps: u32) -> Self {
        let (none, vector) = ([0.0; LANES], [[0.0; LANES]; 3]);
        Self {
            a: [nothing; LANES],
            b: [nothing; LANES],
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
            stiff: none,
            bent: none,
            elsewhere: none,
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
            total: none,
            left: none,
        }
    }
}

impl WideContact {
    /// The friction anchor of a lane, in a substep of `h` seconds.
    pub(super) fn friction_anchor(&self, lane: usize, h: f32) -> FrictionAnchor {
        let vector = |v: &[[f32; 8]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        let [x, y, z, twist] = &self.accumulated_slip;
        let friction_anchor = FrictionAnchor {
            force: self.friction_limit[lane] / (h * h),
            accumulated_slip: Vec3::new(x[lane], y[lane], z[lane]),
            twist: twist[lane],
            up: vector(&self.up),
            arm: vector(&self.arm),
            radius: self.radius[lane],
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

    /// Starts friction of a lane from an anchor.
    fn set_friction_anchor(&mut self, lane: usize, anchor: &FrictionAnchor, h: f32) {
        let FrictionAnchor { force, accumulated_slip, twist, up, arm, radius } = *anchor;
        self.friction_limit[lane] = force * (h * h);
        let [x, y, z, turned] = &mut self.accumulated_slip;
        (x[lane], y[lane], z[lane], turned[lane]) =
            (accumulated_slip.x, accumulated_slip.y, accumulated_slip.z, twist);
        set(&mut self.up, lane, up);
        set(&mut self.arm, lane, arm);
        self.radius[lane] = radius;
    }

    /// What lets go for a substep is held at its centre meanwhile: friction at an edge that has lifted would rock it, and it rocks on for minutes.
    #[inline(always)]
    pub(super) fn let_go<L: Lanes>(&mut self, normal: Vector<L>) {
        self.radius = [0.0; LANES];
        self.arm = [[0.0; LANES]; 3];
        store(normal, &mut self.up);
    }
}

/// Says of each manifold how often it is to be pressed. `mass` is that of a body collider, kg, or none of what shares particles or is held; `loads`
/// is scratch.
pub(super) fn set_levels(
    contacts: &mut [Contact],
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
    if !any {
        return;
    }
    for _ in 0..DEPTH {
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
        let ratio = ratio(one.a).max(other);
        if ratio >= RATIO {
            let enough = SWEEPS.iter().position(|&sweeps| sweeps as f32 >= ratio);
            one.level = enough.unwrap_or(SWEEPS.len() - 1);
        }
    }
}
