//! Contacts that were found for a step: manifolds coloured and packed by eights, and loose particles near solids.

use glam::{Mat3, Vec3};

use super::super::{Grip, Party};
use super::mass_ratio::SWEEPS;
use super::memory::Remembered;
use super::pack::{FAR, Pack, may_slide, may_turn, wear};
use super::turn::Eight;
use crate::constraints::PlanarDrag;
use crate::lanes::LANES;

/// A manifold that may come to press in this step, as it was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Numbers of the solids; where the second one stands, its row among the bodies.
    pub(super) a: u32,
    pub(super) b: u32,
    /// Number of the stand, if the second one is one.
    pub(super) stand: Option<u32>,
    /// The axes of that, if it stays where it is in this step.
    pub(super) still: Option<Mat3>,
    /// Its place in the memory, where the manifold is.
    pub(super) memory: u32,
    /// The second one's origin, or where it is, from the first one's origin, metres.
    pub(super) offset: Vec3,
    pub(super) grip: Grip,
    pub(super) listened: bool,
    pub(super) parties: [Party; 2],
    pub(super) colour: u32,
    /// How often it is pressed in a substep: `mass_ratio::SWEEPS` has the number.
    pub(super) level: usize,
    /// How far the smaller one of the two reaches, metres.
    pub(super) size: f32,
    /// See `Pack`.
    pub(super) strain: f32,
    /// See `Pack`; metres.
    pub(super) blunt: f32,
}

impl Found {
    /// Its colour, and which part of that it is of: what is pressed as often has packs of its own, and of that what stands still.
    pub(super) fn class(&self) -> usize {
        2 * (SWEEPS.len() * self.colour as usize + self.level) + usize::from(self.still.is_some())
    }
}

/// A stand that is only noticed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensed {
    pub(super) parties: [Party; 2],
    pub(super) point: Vec3,
    pub(super) normal: Vec3,
}

/// Gives manifolds colours: of one colour no two have a solid in common, so that eight of them can be corrected at once. By their order, the first
/// colour that is free.
pub(super) fn colour(found: &mut [Found], solids: usize, used: &mut Vec<u64>) -> u32 {
    used.clear();
    used.resize(solids, 0);
    let mut most = 0;
    // What has more manifolds than there are bits gets a colour for each.
    let mut beyond = u64::BITS;
    for one in found {
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

/// Numbers of manifolds by [class](Found::class), and of one class first those that pressed before, then as they are; `begins` is scratch. Those of a
/// colour may come in any order, and a pack in which nothing presses is soon done with.
fn by_colour(
    (found, memory): (&[Found], &[Remembered]),
    colours: u32,
    order: &mut Vec<u32>,
    begins: &mut Vec<u32>,
) {
    let class =
        |one: &Found| 2 * one.class() + usize::from(!memory[one.memory as usize].grasp.presses());
    begins.clear();
    let classes = 4 * SWEEPS.len() * colours as usize;
    begins.resize(classes + 1, 0);
    for one in found {
        begins[class(one) + 1] += 1;
    }
    for class in 0..classes {
        begins[class + 1] += begins[class];
    }
    order.clear();
    order.resize(found.len(), 0);
    for (number, one) in found.iter().enumerate() {
        let place = &mut begins[class(one)];
        order[*place as usize] = number as u32;
        *place += 1;
    }
}

/// Packs manifolds of one of so many colours by eights, for substeps of `h` seconds. `order` and `begins` are scratch; `row` is where a solid or a
/// stand is among the bodies, `centre` that of a solid in its own frame.
pub(super) fn pack(
    (found, memory, h): (&[Found], &[Remembered], f32),
    (nothing, colours): (u32, u32),
    [order, begins]: [&mut Vec<u32>; 2],
    packs: &mut Vec<Pack>,
    (row, centre): (impl Fn(u32) -> u32, impl Fn(u32) -> Vec3),
) {
    packs.clear();
    by_colour((found, memory), colours, order, begins);
    let (mut class, mut lane) = (usize::MAX, LANES);
    for &number in order.iter() {
        let one = &found[number as usize];
        if lane == LANES || one.class() != class {
            packs.push(Pack::empty(nothing, one.still.is_some(), SWEEPS[one.level]));
            (class, lane) = (one.class(), 0);
        }
        if let Some(pack) = packs.last_mut() {
            let known = &memory[one.memory as usize];
            let rows = [row(one.a), row(one.b)];
            put((pack, lane), (number, rows), (one, known), [centre(one.a), centre(one.b)], h);
        }
        lane += 1;
    }
    keep_for_impacts(packs);
}

/// Lets all packs keep what a restitution needs, if anything has one: what was not fast itself may take part in an impact.
pub(super) fn keep_for_impacts(packs: &mut [Pack]) {
    if packs.iter().any(|pack| pack.elastic != 0) {
        packs.iter_mut().for_each(|pack| pack.kept = true);
    }
}

/// Puts one of a number into a lane, for substeps of `h` seconds. `rows` are those of the two among the bodies, `centres` those in their own frames.
pub(super) fn put(
    (pack, lane): (&mut Pack, usize),
    (number, rows): (u32, [u32; 2]),
    (one, known): (&Found, &Remembered),
    centres: [Vec3; 2],
    h: f32,
) {
    (pack.a[lane], pack.b[lane]) = (rows[0], rows[1]);
    pack.number[lane] = number;
    put_manifold(pack, lane, (one, known), centres);
    pack.strain[lane] = one.strain;
    pack.friction[lane] = one.grip.friction;
    pack.elastic |= u32::from(one.grip.restitution > 0.0) << lane;
    let drags = one.grip.drag != PlanarDrag::default();
    pack.kept |= one.listened || one.grip.restitution > 0.0 || drags;
    known.grasp.put(pack, lane, h);
}

/// Writes what two shapes are to each other into a lane.
pub(super) fn put_manifold(
    pack: &mut Pack,
    lane: usize,
    (one, known): (&Found, &Remembered),
    [centre_a, centre_b]: [Vec3; 2],
) {
    let seen = |v: Vec3| one.still.map_or(v, |axes| axes * v);
    let mut manifold = known.manifold;
    // Of what stays where it is the axis is not loaded, and its normal does not turn.
    manifold.axial[1] &= one.still.is_none();
    let [own, theirs] = manifold.radii;
    (pack.radii[0][lane], pack.radii[1][lane]) = (own, theirs);
    pack.round |= theirs > 0.0;
    for (lanes, axial) in pack.axial.iter_mut().zip(manifold.axial) {
        *lanes = *lanes & !(1 << lane) | u32::from(axial) << lane;
    }
    pack.own[lane] = match (own > 0.0, theirs > 0.0) {
        _ if one.stand.is_some() => 1.0,
        (true, false) => 1.0,
        (false, true) => 0.0,
        _ => 0.5,
    };
    let normal = known.manifold.normal;
    let of_first = theirs > 0.0 && own == 0.0;
    let normal = if of_first { known.seen_from.turn_back(normal) } else { seen(normal) };
    set(&mut pack.normal, lane, normal);
    set(&mut pack.offset, lane, one.offset);
    pack.wear[lane] = wear(&known.manifold);
    let (turn, slide) = (may_turn(&known.manifold), may_slide(&known.manifold, one.size));
    (pack.bent[lane], pack.stiff[lane]) = (1.0 / turn, 1.0 / slide);
    pack.blunt[lane] = one.blunt;
    pack.elsewhere[lane] = 2.0 * one.size * turn / slide;
    (pack.strain[lane], pack.gap[lane]) = (0.0, 0.0);
    let points = known.manifold.points();
    if points.is_empty() {
        pack.allowed[lane] = 0.0;
    }
    for i in 0..pack.missing.len() {
        let anchors = points.get(i).map(|point| manifold.anchors(point, &known.seen_from));
        let [on_a, on_b] = anchors.map_or([Vec3::ZERO; 2], |[a, b]| [a - centre_a, b - centre_b]);
        set(&mut pack.on_a[i], lane, on_a);
        set(&mut pack.on_b[i], lane, seen(on_b));
        pack.approach[i][lane] = FAR;
        pack.missing[i][lane] = if anchors.is_some() { 0.0 } else { FAR };
    }
}

pub(super) fn set(to: &mut [Eight; 3], lane: usize, from: Vec3) {
    for (to, from) in to.iter_mut().zip(from.to_array()) {
        to[lane] = from;
    }
}
