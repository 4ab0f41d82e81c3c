//! Manifolds between body colliders, and between body colliders and static geometry: eight of one colour at a time.
//!
//! # The method
//!
//! Müller, Macklin, Chentanez, Jeschke, Kim, *Detailed Rigid Body Simulation with Extended Position Based Dynamics*, 2020: in each of many substeps
//! each contact is corrected once, in positions; an impulse `P` (kg·m) at an arm `r` from a centre moves that by `P/M` and turns it by `I⁻¹ (r × P)`,
//! so along a normal `n` two body colliders give way by
//!
//! ```text
//! w = 1/M_a + 1/M_b + (r_a × n)ᵀ I_a⁻¹ (r_a × n) + (r_b × n)ᵀ I_b⁻¹ (r_b × n)
//! ```
//!
//! Here the points of a manifold are solved together, and so is its friction (`patch_solve`), and what contacts did to a body collider is summed up
//! as one shift and one turn, which the particles get in the end (`pose`). A turn within a substep is small: points are moved by it to
//! first order, and what that leaves is corrected in the next substep.
//!
//! # Overlap
//!
//! What is inside when a substep begins, because a sweep over a heap leaves something or because a new corner was found too late, must come out; but
//! what is moved out by a length in a substep leaves with that length by `h`. A tower stands on that: each box is in the one below by as much as its
//! load is to push it out again. What is much deeper is recovered over some substeps, and marked, with all that it pushes on: `restitution` then
//! takes off the speed that it came out with.
//!
//! # Where impulses act
//!
//! Verlet keeps `Σ m p × (q - p)`: angular momentum is conserved if the two impulses of a contact have the same moment about where the *substep
//! began*. So arms go from the centres at the start to one point between the two anchors, as seen from there. What stands takes any moment; there the
//! arm goes to the body collider's own anchor.

use super::bodies::{Bodies, WideBody as Rows};
use super::patch_solve::{ContactPatch, PatchSide, solve_normal_impulses};
use super::tangential_slip::tangents;
use super::turn::{load, store};
use super::wide_contact::{FAR, WideContact};
use crate::lanes::{LANES, Lanes, Vector, Work};

/// Solves the normals of wide contacts one after the other, over a substep of `h` seconds.
pub(super) struct NormalSolve<'a> {
    pub(super) wide_contacts: &'a mut [WideContact],
    pub(super) bodies: &'a mut Bodies,
    pub(super) h: f32,
    /// How far out of an overlap that a substep began with two may be moved in it, metres.
    pub(super) recover: f32,
    /// Beyond which the speed that comes of it is to be taken off, metres; and of what has a restitution.
    pub(super) pops: [f32; 2],
    /// Which sweep of the substep it is: the first one, 0, is over all of them, others over those that take more.
    pub(super) sweep: u32,
}

impl Work for NormalSolve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { wide_contacts, bodies, h, recover, pops, sweep } = self;
        for wide in wide_contacts.iter_mut().filter(|wide| sweep < wide.sweeps) {
            // Most have two points at the most, and what is missing has no say.
            let third = L::load(&wide.missing[2]).lt(L::splat(FAR));
            let how = (h, recover, pops, sweep);
            match (third.any(), wide.fixed) {
                (false, false) => solve_wide_contact::<L, 2, false>(wide, bodies, how),
                (false, true) => solve_wide_contact::<L, 2, true>(wide, bodies, how),
                (true, false) => solve_wide_contact::<L, 4, false>(wide, bodies, how),
                (true, true) => solve_wide_contact::<L, 4, true>(wide, bodies, how),
            }
        }
    }
}

/// `FIXED` is what the wide contact says of that: the same bits, without all that is nothing.
#[inline(always)]
fn solve_wide_contact<L: Lanes, const POINTS: usize, const FIXED: bool>(
    wide: &mut WideContact,
    bodies: &mut Bodies,
    (h, recover, [max_depenetration, elastic_pop], sweep): (f32, f32, [f32; 2], u32),
) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut a = Rows::<L>::load(bodies, &wide.a);
    let mut b = if FIXED { None } else { Some(Rows::<L>::load(bodies, &wide.b)) };
    // From the first one's centre to the second one's, at the start; and how much that has grown. A match, for a closure is not made for the
    // processor that it runs on.
    let offset = load::<L>(&wide.offset);
    let normal = load::<L>(&wide.normal);
    let (apart, drift, mut n, shift, spin, weight) = match &b {
        None => (offset - a.centre, -a.step, normal, a.shift, a.spin, a.inverse_mass),
        Some(b) => (
            b.centre + offset - a.centre,
            b.step - a.step,
            b.rotation.times(normal),
            a.shift - b.shift,
            a.spin - b.spin,
            a.inverse_mass + b.inverse_mass,
        ),
    };
    let (on_a, on_b) = anchors::<L, POINTS>(wide, &a, b.as_ref(), apart);
    let radii = [L::load(&wide.radii[0]), L::load(&wide.radii[1])];
    if wide.round {
        n = round_normals(wide, &a, n, &radii, (&on_a, &on_b));
    }
    let skins = skins(wide, n, &radii, (&a, b.as_ref()));
    let before = n.dot(drift);
    let between = n.dot(shift);
    let own = L::load(&wide.own);
    let (t, u) = tangents(n);
    let recover = L::splat(recover);
    let max_depenetration =
        L::mask(wide.elastic).select(L::splat(elastic_pop), L::splat(max_depenetration));
    let mut depenetrated = [none; POINTS];
    let mut left = [none; POINTS];

    let stiff = L::load(&wide.stiff);
    let across = (drift - n * before).length() * stiff;
    let turned = spin.length() * L::load(&wide.bent);
    let staleness = (turned + across) * L::load(&wide.staleness_rate);
    (L::load(&wide.staleness) + staleness).store(&mut wide.staleness);

    let plane = PatchPlane { t, u, apart: (apart.dot(t), apart.dot(u)) };
    let (mut turning, mut spinning) = (plane.tilt(a.turn), plane.tilt(a.spin));
    if let Some(b) = &b {
        turning = turning.less(&plane, b.turn);
        spinning = spinning.less(&plane, b.spin);
    }
    let mut c = [none; POINTS];
    let mut at = [(none, none); POINTS];
    let mut spun = [none; POINTS];
    let mut height = [none; POINTS];
    for i in 0..POINTS {
        let (on_a, on_b) = (on_a[i] - skins[0], on_b[i] + skins[1]);
        let predicted_gap = on_a - on_b;
        let arm = on_b + predicted_gap * own;
        at[i] = (arm.dot(t), arm.dot(u));
        height[i] = arm.dot(n);
        spun[i] = spinning.at(at[i]);
        let turned = turning.at(at[i]);
        let nearer = before - spun[i] - between - turned;
        let inside = before - n.dot(predicted_gap) - L::load(&wide.missing[i]) - between - turned;
        c[i] = inside.min(nearer + recover);
        left[i] = inside - nearer;
        depenetrated[i] = max_depenetration.lt(left[i]);
    }
    let most = c.iter().fold(c[0], |most, &c| most.max(c));
    let predicted_gap =
        none - (most + before.max(none)) * stiff - staleness * L::load(&wide.elsewhere);
    L::splat(-0.5 * FAR).lt(most).and(predicted_gap).store(&mut wide.predicted_gap);
    if sweep == 0 && !none.lt(most).any() {
        // Nothing touches: nor did it press in this substep.
        wide.sum = [0.0; LANES];
        wide.depenetrated = 0;
        wide.force = [[0.0; LANES]; 4];
        wide.left = [0.0; LANES];
        wide.let_go(n);
        return;
    }
    let (apart_t, apart_u) = plane.apart;
    let theirs = match &b {
        None => None,
        Some(b) => Some(PatchSide::of(&b.inverse_inertia, t, u)),
    };
    let patch = ContactPatch {
        weight,
        a: PatchSide::of(&a.inverse_inertia, t, u),
        b: theirs,
        apart: plane.apart,
    };
    // What it has pressed with in this substep it may take back: the impulses are accumulated, and none of the sums pulls.
    let mut had = [none; POINTS];
    if sweep > 0 {
        let mut moments = Vector::new(none, none, none);
        for i in 0..POINTS {
            had[i] = L::load(&wide.force[i]);
            moments += Vector::new(had[i], had[i] * at[i].0, had[i] * at[i].1);
        }
        let moved = patch.about(none, none).times(moments);
        for i in 0..POINTS {
            let own = moved.x + at[i].0 * moved.y + at[i].1 * moved.z;
            c[i] = c[i] + own;
        }
    }
    let force = solve_normal_impulses(&patch, &c, &at);
    let (mut sum, mut x, mut y, mut z) = (none, none, none, none);
    let mut more = Vector::new(none, none, none);
    for i in 0..POINTS {
        sum = sum + force[i];
        x = x + force[i] * at[i].0;
        y = y + force[i] * at[i].1;
        z = z + force[i] * height[i];
        let by = force[i] - had[i];
        more += Vector::new(by, by * at[i].0, by * at[i].1);
    }

    // Nothing that is not a number may get to the other side.
    let good = sum.lt(L::splat(1e30)).and(none.lt(sum).or(more.x.lt(none)));
    let old = (a.shift, a.turn);
    let mut old_b = (a.shift, a.turn);
    a.shift += n * (more.x * a.inverse_mass);
    a.turn += patch.a.turned(more.y, more.z);
    let mut size = a.shift.length_squared() + a.turn.length_squared();
    let mut hit = none.lt(a.depenetration_mark);
    if let (Some(b), Some(side)) = (&mut b, &patch.b) {
        old_b = (b.shift, b.turn);
        b.shift -= n * (more.x * b.inverse_mass);
        b.turn -= side.turned(more.y - apart_t * more.x, more.z - apart_u * more.x);
        size = size + b.shift.length_squared() + b.turn.length_squared();
        hit = hit.or(none.lt(b.depenetration_mark));
    }
    let good = good.and(size.lt(L::splat(1e30)));
    good.and(sum).store(&mut wide.sum);
    let deepest = left.iter().zip(&force);
    let deepest = deepest.fold(none, |most, (&left, &f)| most.max(none.lt(f).and(left)));
    deepest.store(&mut wide.left);
    let hit = good.and(hit.or(pressed(&depenetrated, &force)));
    wide.depenetrated = hit.bits();
    if wide.kept || wide.sweeps > 1 || hit.any() {
        wide.force = [[0.0; LANES]; 4];
        for i in 0..POINTS {
            good.and(force[i]).store(&mut wide.force[i]);
            let touches = none.lt(c[i]).or(none.lt(force[i]));
            let approach = (spun[i] - before) * L::splat(1.0 / h);
            touches.select(approach, L::splat(FAR)).store(&mut wide.approach[i]);
        }
        (L::load(&wide.total) + good.and(more.x)).store(&mut wide.total);
    }
    if !good.any() {
        wide.let_go(n);
        return;
    }
    let mark = hit.and(one);
    let (shift, turn) = (a.shift.or_else(good, old.0), a.turn.or_else(good, old.1));
    let first = [shift.with(a.inverse_mass), turn.with(a.depenetration_mark.max(mark))];
    L::put_records(&mut bodies.rows, &wide.a, first);
    if let Some(b) = b {
        let (shift, turn) = (b.shift.or_else(good, old_b.0), b.turn.or_else(good, old_b.1));
        let mark = none.lt(b.inverse_mass).and(b.depenetration_mark.max(mark));
        let second = [shift.with(b.inverse_mass), turn.with(mark)];
        L::put_records(&mut bodies.rows, &wide.b, second);
    }

    // Where friction is to act: at the centre of the pressure, and how far it reaches from there.
    let share = good.and(one / sum);
    let (x, y, z) = (x * share, y * share, z * share);
    let mut spread = none;
    for i in 0..POINTS {
        let (dx, dy, dz) = (at[i].0 - x, at[i].1 - y, height[i] - z);
        spread = spread + (dx * dx + dy * dy + dz * dz) * force[i];
    }
    // Where nothing presses in this substep, at the centre.
    good.and((spread * share).sqrt()).store(&mut wide.radius);
    store(n, &mut wide.up);
    store(t * x + u * y + n * z, &mut wide.arm);
}

/// The anchors of both from the first one's centre, when the second one's is so far from there.
#[inline(always)]
pub(super) fn anchors<L: Lanes, const POINTS: usize>(
    wide: &WideContact,
    a: &Rows<L>,
    b: Option<&Rows<L>>,
    apart: Vector<L>,
) -> ([Vector<L>; POINTS], [Vector<L>; POINTS]) {
    let none = Vector::new(L::zero(), L::zero(), L::zero());
    let (mut on_a, mut on_b) = ([none; POINTS], [none; POINTS]);
    for i in 0..POINTS {
        on_a[i] = a.rotation.times(load(&wide.on_a[i]));
        on_b[i] = load(&wide.on_b[i]);
        if let Some(b) = b {
            on_b[i] = b.rotation.times(on_b[i]);
        }
        on_b[i] += apart;
    }
    (on_a, on_b)
}

/// From the surfaces to the centres of what is round of the first ones; and back of the second ones.
#[inline(always)]
pub(super) fn skins<L: Lanes>(
    wide: &WideContact,
    n: Vector<L>,
    radii: &[L; 2],
    (a, b): (&Rows<L>, Option<&Rows<L>>),
) -> [Vector<L>; 2] {
    let mut out = [n; 2];
    if wide.axial != [0; 2] {
        out[0] = across_axis(n, a.rotation.y).or_else(L::mask(wide.axial[0]), n);
        if let Some(b) = b {
            out[1] = across_axis(n, b.rotation.y).or_else(L::mask(wide.axial[1]), n);
        }
    }
    [out[0] * radii[0], out[1] * radii[1]]
}

/// The directions across axes that are nearest to others; those, where they are along the axes.
#[inline(always)]
fn across_axis<L: Lanes>(n: Vector<L>, axis: Vector<L>) -> Vector<L> {
    let across = n - axis * n.dot(axis);
    let sine = across.length();
    (across * (L::splat(1.0) / sine)).or_else(L::splat(1e-3).lt(sine), n)
}

/// The normals of those whose second one is round: a face's turns with the face, and that of two that are round is from the one to the other. A matter of
/// the few, so that the many do not load it.
#[inline(always)]
pub(super) fn round_normals<L: Lanes, const POINTS: usize>(
    wide: &WideContact,
    a: &Rows<L>,
    n: Vector<L>,
    radii: &[L; 2],
    (on_a, on_b): (&[Vector<L>; POINTS], &[Vector<L>; POINTS]),
) -> Vector<L> {
    let none = L::zero();
    let mut between = Vector::new(none, none, none);
    for i in 0..POINTS {
        let there = L::load(&wide.missing[i]).lt(L::splat(FAR));
        let apart = on_a[i] - on_b[i];
        between += apart.or_else(there, Vector::new(none, none, none));
    }
    let length = between.length();
    let (own, theirs) = (none.lt(radii[0]), none.lt(radii[1]));
    // Two centres in one place are apart in no direction.
    let apart = (radii[0] * L::splat(1e-3)).lt(length).and(own).and(theirs);
    let of_face = theirs.and(radii[0].le(none));
    let face = a.rotation.times(load(&wide.normal));
    let n = face.or_else(of_face, n);
    (between * (L::splat(1.0) / length)).or_else(apart, n)
}

/// The plane of a patch, and where the second one's centre is in it, from the first one's, metres.
struct PatchPlane<L> {
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

impl<L: Lanes> PatchPlane<L> {
    #[inline(always)]
    fn tilt(&self, a: Vector<L>) -> Tilt<L> {
        Tilt { t: a.dot(self.t), u: a.dot(self.u), at_centre: L::zero() }
    }
}

impl<L: Lanes> Tilt<L> {
    /// The same when the second one turns, too.
    #[inline(always)]
    fn less(self, plane: &PatchPlane<L>, b: Vector<L>) -> Self {
        let (bt, bu) = (b.dot(plane.t), b.dot(plane.u));
        let at_centre = plane.apart.1 * bt - plane.apart.0 * bu;
        Self { t: self.t - bt, u: self.u - bu, at_centre }
    }

    #[inline(always)]
    fn at(&self, (x, y): (L, L)) -> L {
        y * self.t - x * self.u + self.at_centre
    }
}

/// Where a point that popped out presses.
#[inline(always)]
fn pressed<L: Lanes, const POINTS: usize>(depenetrated: &[L; POINTS], force: &[L; POINTS]) -> L {
    let pairs = depenetrated.iter().zip(force);
    pairs.fold(L::zero(), |any, (&depenetrated, &force)| {
        any.or(depenetrated.and(L::zero().lt(force)))
    })
}
