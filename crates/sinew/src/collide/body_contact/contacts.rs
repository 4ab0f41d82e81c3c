//! Contacts of a step: manifolds, coloured and packed into wide contacts.

use glam::{Mat3, Vec3};

use super::super::{CombinedMaterial, ContactParticipant};
use super::contact_cache::CachedManifold;
use super::mass_ratio::SWEEPS;
use super::turn::LaneArray;
use super::wide_contact::{FAR, WideContact, may_slide, may_turn, staleness_rate};
use crate::constraints::PlanarDrag;
use crate::lanes::LANES;

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
    /// How often it is pressed in a substep: `mass_ratio::SWEEPS` has the number.
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

/// Numbers of manifolds by [class](Contact::class), and of one class first those that pressed before, then as they are; `begins` is scratch. Those of
/// a colour may come in any order, and a wide contact in which nothing presses is soon done with.
fn by_colour(
    (contacts, cache): (&[Contact], &[CachedManifold]),
    colours: u32,
    order: &mut Vec<u32>,
    begins: &mut Vec<u32>,
) {
    let class = |one: &Contact| {
        2 * one.class() + usize::from(!cache[one.cache_index as usize].friction_anchor.is_loaded())
    };
    begins.clear();
    let classes = 4 * SWEEPS.len() * colours as usize;
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
    let drags = one.combined_material.drag != PlanarDrag::default();
    wide.kept |= one.reports_events || one.combined_material.restitution > 0.0 || drags;
    known.friction_anchor.put(wide, lane, h);
}

/// Writes what two shapes are to each other into a lane.
pub(super) fn put_manifold(
    wide: &mut WideContact,
    lane: usize,
    (one, known): (&Contact, &CachedManifold),
    [centre_a, centre_b]: [Vec3; 2],
) {
    let seen = |v: Vec3| one.fixed.map_or(v, |axes| axes * v);
    let mut manifold = known.manifold;
    // Of what stays where it is the axis is not loaded, and its normal does not turn.
    manifold.axial[1] &= one.fixed.is_none();
    let [own, theirs] = manifold.radii;
    (wide.radii[0][lane], wide.radii[1][lane]) = (own, theirs);
    wide.round |= theirs > 0.0;
    for (lanes, axial) in wide.axial.iter_mut().zip(manifold.axial) {
        *lanes = *lanes & !(1 << lane) | u32::from(axial) << lane;
    }
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
    wide.staleness_rate[lane] = staleness_rate(&known.manifold);
    let (turn, slide) = (may_turn(&known.manifold), may_slide(&known.manifold, one.size));
    (wide.bent[lane], wide.stiff[lane]) = (1.0 / turn, 1.0 / slide);
    wide.torsional_radius[lane] = one.torsional_radius;
    wide.elsewhere[lane] = 2.0 * one.size * turn / slide;
    (wide.staleness[lane], wide.predicted_gap[lane]) = (0.0, 0.0);
    let points = known.manifold.points();
    if points.is_empty() {
        wide.friction_limit[lane] = 0.0;
    }
    for i in 0..wide.missing.len() {
        let anchors = points.get(i).map(|point| manifold.anchors(point, &known.seen_from));
        let [on_a, on_b] = anchors.map_or([Vec3::ZERO; 2], |[a, b]| [a - centre_a, b - centre_b]);
        set(&mut wide.on_a[i], lane, on_a);
        set(&mut wide.on_b[i], lane, seen(on_b));
        wide.approach[i][lane] = FAR;
        wide.missing[i][lane] = if anchors.is_some() { 0.0 } else { FAR };
    }
}

pub(super) fn set(to: &mut [LaneArray; 3], lane: usize, from: Vec3) {
    for (to, from) in to.iter_mut().zip(from.to_array()) {
        to[lane] = from;
    }
}
