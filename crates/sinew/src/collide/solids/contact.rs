//! Manifolds between solids, and between solids and what stands: eight of one colour at a time.
//!
//! # The method
//!
//! Müller, Macklin, Chentanez, Jeschke, Kim, *Detailed Rigid Body Simulation with Extended Position Based Dynamics*, 2020: in each of many substeps
//! each contact is corrected once, in positions; an impulse `P` (kg·m) at an arm `r` from a centre moves that by `P/M` and turns it by `I⁻¹ (r × P)`,
//! so along a normal `n` two solids give way by
//!
//! ```text
//! w = 1/M_a + 1/M_b + (r_a × n)ᵀ I_a⁻¹ (r_a × n) + (r_b × n)ᵀ I_b⁻¹ (r_b × n)
//! ```
//!
//! Here the points of a manifold are solved together, and so is its friction (`block`), and what contacts did to a solid is summed up as one shift
//! and one turn, which the particles get in the end (`write`). A turn within a substep is small: points are moved by it to first order, and what that
//! leaves is corrected in the next substep.
//!
//! # Overlap
//!
//! What is inside when a substep begins, because a sweep over a heap leaves something or because a new corner was found too late, must come out; but
//! what is moved out by a length in a substep leaves with that length by `h`. A tower stands on that: each box is in the one below by as much as its
//! load is to push it out again. What is much deeper is recovered over some substeps, and marked, with all that it pushes on: `bounce` then takes off
//! the speed that it came out with.
//!
//! # Where impulses act
//!
//! Verlet keeps `Σ m p × (q - p)`: angular momentum is conserved if the two impulses of a contact have the same moment about where the *substep
//! began*. So arms go from the centres at the start to one point between the two anchors, as seen from there. What stands takes any moment; there the
//! arm goes to the solid's own anchor.

use super::super::manifold::Manifold;
use super::block::{Patch, Side, press};
use super::bodies::{Bodies, Eight as Rows};
use super::hold::tangents;
use super::turn::{Eight, load, store};
use crate::lanes::{LANES, Lanes, Vector, Work};

/// As good as infinitely far out, metres: what a missing point is.
pub(super) const FAR: f32 = 1e9;

/// The angle that two may turn against each other before they are compared again, rad.
const TURNED: f32 = 0.02;
/// The same for how far they may slide on each other, as a share of their size.
const SLID: f32 = 0.03;
/// How much further what is round may turn: its points then are `r φ` aside of where they should be, along a surface that bends away by `½ r φ²`. Of a
/// leg, 6 cm thick, that is 0.04 mm.
const ROUND: f32 = 2.5;
/// How much faster a manifold wears whose [slope](Manifold::slope) is 1. Its points are points of the two, and as one slides over the rim of the
/// other it touches with others, that are higher by the slope times the way: so that must be less, and no height is wrong by more than `SLID / STEEP`
/// of the size. Without that a box fell half a millimetre deep into a rim that its manifold did not know of, and was thrown out of it, again and
/// again, for minutes; three times as much finds a tenth more manifolds in a heap of boxes in random poses, for nothing.
const STEEP: f32 = 100.0;

/// The angle that the two of a manifold may turn against each other, rad.
pub(super) fn may_turn(manifold: &Manifold) -> f32 {
    if manifold.round { ROUND * TURNED } else { TURNED }
}

/// How far the two of a manifold may slide on each other, metres, of a size; no farther than that.
pub(super) fn may_slide(manifold: &Manifold, size: f32) -> f32 {
    manifold.free.min(size).max(SLID * size)
}

/// How much faster than others a manifold wears.
pub(super) fn wear(manifold: &Manifold) -> f32 {
    1.0 + STEEP * manifold.slope
}

/// Eight manifolds that have no solid in common; on lines of the cache of its own, because an eight that lies across two of them costs twice as much.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Pack {
    /// Rows of the bodies that are pushed along the normal, and of those that are pushed back.
    pub(super) a: [u32; LANES],
    pub(super) b: [u32; LANES],
    /// Which of the manifolds that were found it is.
    pub(super) number: [u32; LANES],
    /// In the second one's axes.
    pub(super) normal: [Eight; 3],
    /// Anchors from the centres, in their own axes, metres.
    pub(super) on_a: [[Eight; 3]; 4],
    pub(super) on_b: [[Eight; 3]; 4],
    /// Added to the distance of each point, metres: none for one that is there.
    pub(super) missing: [Eight; 4],
    /// From the first one's origin to the second one's, metres.
    pub(super) offset: [Eight; 3],
    pub(super) friction: Eight,
    /// One by the length that the two may slide on each other before they are compared again, 1/m.
    pub(super) stiff: Eight,
    /// One by the angle that they may turn against each other before that, 1/rad.
    pub(super) bent: Eight,
    /// By how much more than the strain says, times what they may slide, others of their points may have come nearer than those of the manifold: a turn
    /// of `φ` takes these away by up to `r φ` and others there by as much.
    pub(super) elsewhere: Eight,
    /// How much faster than others they are strained by that, and by turning: [`wear`].
    pub(super) wear: Eight,
    /// How much they have turned and slid since they were compared: 1 is as much as they may, where they touch.
    pub(super) strain: Eight,
    /// How far apart the nearest of their points will be if they go on as in the last substep, by how far they may slide; 0 where that is not known.
    pub(super) gap: Eight,
    /// How much of the arm is the first one's anchor: 1 if the second one stands, else a half.
    pub(super) own: Eight,
    /// Whether approach and place are to be kept: something bounces, or somebody listens.
    pub(super) kept: bool,
    /// A bit for each manifold where more overlap was recovered in this substep than may turn into speed, or one of whose solids comes from where
    /// that was.
    pub(super) popped: u32,
    /// Of the substep: impulses of the points, kg·m.
    pub(super) force: [Eight; 4],
    /// Their speeds before contacts, m/s; negative when approaching.
    pub(super) approach: [Eight; 4],
    /// Normal in the world, and the centre of pressure from the first one's centre, metres.
    pub(super) up: [Eight; 3],
    pub(super) arm: [Eight; 3],
    /// How far the points are from there; and the sum of their impulses, kg·m.
    pub(super) radius: Eight,
    pub(super) sum: Eight,
    /// Against how much of such a sum friction has acted in this substep, before it was pressed; and may act in the next: a mean of the last ones.
    pub(super) used: Eight,
    pub(super) allowed: Eight,
    /// How far what sticks is from where it stuck, metres, and has turned about the normal, rad: pressing moved it after it was held,
    /// and joints took a part of what held it (`lost`).
    pub(super) late: [Eight; 4],
    /// A bit for each manifold that sticks.
    pub(super) stuck: u32,
    /// Of the step: sum of the impulses, kg·m.
    pub(super) total: Eight,
}

impl Pack {
    /// One without manifolds; `nothing` is the row of nothing.
    pub(super) fn empty(nothing: u32) -> Self {
        let (none, vector) = ([0.0; LANES], [[0.0; LANES]; 3]);
        Self {
            a: [nothing; LANES],
            b: [nothing; LANES],
            number: [u32::MAX; LANES],
            normal: vector,
            on_a: [vector; 4],
            on_b: [vector; 4],
            missing: [[FAR; LANES]; 4],
            offset: vector,
            friction: none,
            stiff: none,
            bent: none,
            elsewhere: none,
            wear: none,
            strain: none,
            gap: none,
            own: none,
            kept: false,
            popped: 0,
            force: [none; 4],
            approach: [none; 4],
            up: vector,
            arm: vector,
            radius: none,
            sum: none,
            used: none,
            allowed: none,
            late: [none; 4],
            stuck: 0,
            total: none,
        }
    }
}

impl Pack {
    /// What lets go for a substep is held at its centre meanwhile: friction at an edge that has lifted would rock it, and it rocks on for minutes.
    #[inline(always)]
    fn let_go<L: Lanes>(&mut self, normal: Vector<L>) {
        self.radius = [0.0; LANES];
        self.arm = [[0.0; LANES]; 3];
        store(normal, &mut self.up);
    }
}

/// Presses packs apart one after the other, over a substep of `h` seconds.
pub(super) struct Press<'a> {
    pub(super) packs: &'a mut [Pack],
    pub(super) bodies: &'a mut Bodies,
    pub(super) h: f32,
    /// How far out of an overlap that a substep began with two may be moved in it, metres.
    pub(super) recover: f32,
    /// Beyond which the speed that comes of it is to be taken off, metres.
    pub(super) pop: f32,
}

impl Work for Press<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { packs, bodies, h, recover, pop } = self;
        for pack in packs {
            // Most have two points at the most, and what is missing has no say.
            let third = L::load(&pack.missing[2]).lt(L::splat(FAR));
            if third.any() {
                press_pack::<L, 4>(pack, bodies, h, [recover, pop]);
            } else {
                press_pack::<L, 2>(pack, bodies, h, [recover, pop]);
            }
        }
    }
}

#[inline(always)]
fn press_pack<L: Lanes, const POINTS: usize>(
    pack: &mut Pack,
    bodies: &mut Bodies,
    h: f32,
    [recover, pop]: [f32; 2],
) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let (mut a, mut b) = (Rows::<L>::load(bodies, &pack.a), Rows::<L>::load(bodies, &pack.b));
    // From the first one's centre to the second one's, at the start; and how much that has grown.
    let apart = b.centre + load::<L>(&pack.offset) - a.centre;
    let drift = b.step - a.step;
    let n = b.rotation.times(load(&pack.normal));
    let before = n.dot(drift);
    let between = n.dot(a.shift - b.shift);
    let own = L::load(&pack.own);
    let (t, u) = tangents(n);
    let (recover, pop) = (L::splat(recover), L::splat(pop));
    let mut popped = [none; POINTS];

    let stiff = L::load(&pack.stiff);
    let across = (drift - n * before).length() * stiff;
    let turned = (a.spin - b.spin).length() * L::load(&pack.bent);
    let strain = (turned + across) * L::load(&pack.wear);
    (L::load(&pack.strain) + strain).store(&mut pack.strain);

    let plane = Plane { t, u, apart: (apart.dot(t), apart.dot(u)) };
    let (turning, spinning) = (plane.tilt(a.turn, b.turn), plane.tilt(a.spin, b.spin));
    let mut c = [none; POINTS];
    let mut at = [(none, none); POINTS];
    let mut spun = [none; POINTS];
    let mut height = [none; POINTS];
    for i in 0..POINTS {
        let on_a = a.rotation.times(load(&pack.on_a[i]));
        let on_b = b.rotation.times(load(&pack.on_b[i])) + apart;
        let gap = on_a - on_b;
        let arm = on_b + gap * own;
        at[i] = (arm.dot(t), arm.dot(u));
        height[i] = arm.dot(n);
        spun[i] = spinning.at(at[i]);
        let turned = turning.at(at[i]);
        let nearer = before - spun[i] - between - turned;
        let inside = before - n.dot(gap) - L::load(&pack.missing[i]) - between - turned;
        c[i] = inside.min(nearer + recover);
        popped[i] = pop.lt(inside - nearer);
    }
    let most = c.iter().fold(c[0], |most, &c| most.max(c));
    let gap = none - (most + before.max(none)) * stiff - strain * L::load(&pack.elsewhere);
    L::splat(-0.5 * FAR).lt(most).and(gap).store(&mut pack.gap);
    if !none.lt(most).any() {
        // Nothing touches: nor did it press in this substep.
        pack.sum = [0.0; LANES];
        pack.popped = 0;
        pack.force = [[0.0; LANES]; 4];
        pack.let_go(n);
        return;
    }
    let (apart_t, apart_u) = plane.apart;
    let patch = Patch {
        weight: a.inverse_mass + b.inverse_mass,
        a: Side::of(&a.inverse_inertia, t, u),
        b: Side::of(&b.inverse_inertia, t, u),
        apart: plane.apart,
    };
    let force = press(&patch, &c, &at);
    let (mut sum, mut x, mut y, mut z) = (none, none, none, none);
    for i in 0..POINTS {
        sum = sum + force[i];
        x = x + force[i] * at[i].0;
        y = y + force[i] * at[i].1;
        z = z + force[i] * height[i];
    }

    // Nothing that is not a number may get to the other side.
    let good = sum.lt(L::splat(1e30)).and(none.lt(sum));
    let (old_a, old_b) = ((a.shift, a.turn), (b.shift, b.turn));
    a.shift += n * (sum * a.inverse_mass);
    b.shift -= n * (sum * b.inverse_mass);
    a.turn += patch.a.turned(x, y);
    b.turn -= patch.b.turned(x - apart_t * sum, y - apart_u * sum);
    let size = a.shift.length_squared() + a.turn.length_squared();
    let size = size + b.shift.length_squared() + b.turn.length_squared();
    let good = good.and(size.lt(L::splat(1e30)));
    good.and(sum).store(&mut pack.sum);
    let hit = none.lt(a.mark).or(none.lt(b.mark));
    let hit = good.and(hit.or(pressed(&popped, &force)));
    pack.popped = hit.bits();
    if pack.kept || hit.any() {
        pack.force = [[0.0; LANES]; 4];
        for i in 0..POINTS {
            good.and(force[i]).store(&mut pack.force[i]);
            ((spun[i] - before) * L::splat(1.0 / h)).store(&mut pack.approach[i]);
        }
        (L::load(&pack.total) + good.and(sum)).store(&mut pack.total);
    }
    if !good.any() {
        pack.let_go(n);
        return;
    }
    let mark = hit.and(one);
    let shift = (a.shift.or_else(good, old_a.0), b.shift.or_else(good, old_b.0));
    let turn = (a.turn.or_else(good, old_a.1), b.turn.or_else(good, old_b.1));
    L::put_records(
        &mut bodies.rows,
        &pack.a,
        [shift.0.with(a.inverse_mass), turn.0.with(a.mark.max(mark))],
    );
    let mark = none.lt(b.inverse_mass).and(b.mark.max(mark));
    L::put_records(&mut bodies.rows, &pack.b, [shift.1.with(b.inverse_mass), turn.1.with(mark)]);

    // Where friction is to act: at the centre of the pressure, and how far it reaches from there.
    let share = good.and(one / sum);
    let (x, y, z) = (x * share, y * share, z * share);
    let mut spread = none;
    for i in 0..POINTS {
        let (dx, dy, dz) = (at[i].0 - x, at[i].1 - y, height[i] - z);
        spread = spread + (dx * dx + dy * dy + dz * dz) * force[i];
    }
    // Where nothing presses in this substep, at the centre.
    good.and((spread * share).sqrt()).store(&mut pack.radius);
    store(n, &mut pack.up);
    store(t * x + u * y + n * z, &mut pack.arm);
}

/// The plane of a patch, and where the second one's centre is in it, from the first one's, metres.
struct Plane<L> {
    t: Vector<L>,
    u: Vector<L>,
    apart: (L, L),
}

/// What two turns do to each other along the normal: `(r_a × n)·φ_a - (r_b × n)·φ_b`, linear in where that is in the patch.
struct Tilt<L> {
    t: L,
    u: L,
    at_centre: L,
}

impl<L: Lanes> Plane<L> {
    #[inline(always)]
    fn tilt(&self, a: Vector<L>, b: Vector<L>) -> Tilt<L> {
        let (bt, bu) = (b.dot(self.t), b.dot(self.u));
        Tilt {
            t: a.dot(self.t) - bt,
            u: a.dot(self.u) - bu,
            at_centre: self.apart.1 * bt - self.apart.0 * bu,
        }
    }
}

impl<L: Lanes> Tilt<L> {
    #[inline(always)]
    fn at(&self, (x, y): (L, L)) -> L {
        y * self.t - x * self.u + self.at_centre
    }
}

/// Where a point that popped out presses.
#[inline(always)]
fn pressed<L: Lanes, const POINTS: usize>(popped: &[L; POINTS], force: &[L; POINTS]) -> L {
    let pairs = popped.iter().zip(force);
    pairs.fold(L::zero(), |any, (&popped, &force)| any.or(popped.and(L::zero().lt(force))))
}
