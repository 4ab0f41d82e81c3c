//! Normal impulses of wide contacts, between body colliders and against static geometry: eight manifolds of one colour at a time.
//!
//! # The method
//!
//! Müller, Macklin, Chentanez, Jeschke, Kim, *Detailed Rigid Body Simulation with Extended Position Based Dynamics*, 2020: in each of many substeps each
//! contact is corrected once, in positions. An impulse `P` (kg·m) at an arm `r` from a centre moves that by `P/M` and turns the body by `I⁻¹ (r × P)`, so
//! along a normal `n` the inverse effective mass of two body colliders is
//!
//! ```text
//! w = 1/M_a + 1/M_b + (r_a × n)ᵀ I_a⁻¹ (r_a × n) + (r_b × n)ᵀ I_b⁻¹ (r_b × n)
//! ```
//!
//! Here the points of a manifold are solved together, and so is its friction (`friction`). The corrections of a body collider are summed up as one shift and
//! one turn, which its particles get in the end (`pose`). Turns within a substep are small: points are moved to first order, and the error is corrected in
//! the next substep.
//!
//! # Overlap
//!
//! Overlap at the start of a substep, left by a sweep over a heap or by a corner that was found too late, has to be recovered; but a body moved out by a
//! length in a substep leaves with the speed of that length by `h`. Towers stand because of that: each box overlaps the one below by as much as it needs to
//! be pushed out with its load. Much deeper overlap is recovered over several substeps, and marked, with all body colliders that it pushes: `restitution`
//! then removes the resulting speed.
//!
//! # Near a pin
//!
//! A pinned body collider can only turn, and a contact with a short lever `a` about the pin turns it far: to recover an overlap of millimetres there, two
//! ropes that hang from one point would turn their first segments by radians in each substep, and fling themselves away at any speed. So the recovery per
//! substep limits not the displacement of the contact point, but that of the farthest free particle, at the distance `R` from the pin, and to what a single
//! particle recovers (`recovery`): with `K` the displacement of the point per impulse and `D = R |I⁻¹ (r × n)|` that of the farthest particle, the overlap is
//! recovered by at most `K / D` of that. `K / D` is `a / R` where only pinned bodies yield. The more that a tower needs would be 10 m/s at four substeps: figures
//! with a hand pinned inside of a solid came out at up to 50 m/s. Approach within the substep is stopped as elsewhere: near a pin it is small.
//!
//! # Where impulses act
//!
//! Verlet keeps `Σ m p × (q - p)`: angular momentum is conserved if the two impulses of a contact have the same moment about where the *substep began*. So
//! arms go from the centres at the start to one point between the two anchors, as seen from there. Static geometry takes any moment; there the arm goes to
//! the body collider's own anchor.
//!
//! # The unknowns of one manifold
//!
//! They are the normal impulses of its points, four at most. They are solved together, eight manifolds side by side.
//!
//! With `λ` the impulses along the normal (in kg·m, since positions are moved), `K` the displacements of the points per impulse, and `c` the depths of the
//! points, the problem is `λ ≥ 0` with `K λ ≥ c`, where one of the two is an equality. Four points in a plane move as a rigid plane does, so `K` has rank 3,
//! and if one point were solved after the other, a box at rest would rock from corner to corner. So the overlapping points are solved at once, for a pressure
//! that is linear over the patch, `λ = G μ` with rows `g = (1, x, y)` of `G`: `Gᵀ K G μ = Gᵀ c`. That is exact for up to three points and symmetric for four.
//! Where an impulse would be negative, the points are solved one after the other, in a few rounds, with each accumulated impulse clamped at zero.
//!
//! `K` is never computed as a whole. An impulse along the normal at `(x, y)` has the moment `y t - x u` about a centre, with `t` and `u` across the normal:
//! it is linear in `g`. So `K = G Q Gᵀ` with one 3×3 matrix `Q` of the pair ([`ContactPatch::about`]), and with the points measured from the middle of the
//! overlapping ones, `S = Gᵀ G` is a number and a 2×2 block: `Gᵀ K G = S Q S`.

use super::bodies::{Bodies, WideBody as Rows};
use super::turn::{Symmetric, load, store, tangents, zero};
use super::wide_contact::{FAR, WideContact};
use crate::lanes::{LANES, Lanes, Vector, kernel};

/// Greatest staleness that a manifold gains in a substep because of its slope (`contact_cache::steepness`): one that slides fast over a rim is recomputed in
/// every third substep. Recomputing it in each took a ninth of the time of a poured heap and left the same mean overlap, 0.28 mm; manifolds that creep over a
/// rim stay below this limit.
const STEEP_SHARE: f32 = 0.34;
/// Rounds of solving point after point. The rest is corrected in the next substep.
const ROUNDS: usize = 6;
/// Least lever about a pin or axis of a contact with a pinned body collider, as a share of its reach from there. A point with a shorter one cannot be moved
/// and is left out: the square of this, 1e-5, is some 80 times the round-off of `f32`, which a zero lever leaves in the inverse effective mass.
pub(super) const LEAST_LEVER: f32 = 3e-3;
/// Regularisation of points near a pin, as a share of the inverse effective mass of the patch point with the longest lever: without it points on both sides
/// of a pin would press against each other without bound, and the turn of their round-off would be large.
const PIN_REGULARISATION: f32 = 1e-3;
/// Regularisation of the tilt of a patch, as a share of its stiffness, so that a small patch, whose tilt is round-off, does not respond to it.
const TILT_REGULARISATION: f32 = 1e-3;

kernel!(
    /// Solves the normals of wide contacts one after the other, over a substep of `h` seconds.
    pub(super) fn solve_normals<L: Lanes>(
        wide_contacts: &mut [WideContact],
        bodies: &mut Bodies,
        h: f32,
        // Overlap from the start of the substep that may be recovered in it, and displacement of the farthest point of a pinned body by that, metres.
        recovery_limits: [f32; 2],
        // Recovered overlap beyond which the resulting speed is taken off, metres; and the same for contacts with a restitution.
        depenetration_limits: [f32; 2],
        // Number of the sweep in the substep: sweep 0 is over all wide contacts, later ones over those that take more.
        sweep: u32,
    ) {
        for wide in wide_contacts.iter_mut().filter(|wide| sweep < wide.sweeps) {
            // Most have two points at the most, and missing points do not affect the others.
            let third = L::load(&wide.missing[2]).lt(L::splat(FAR));
            let context = (h, recovery_limits, depenetration_limits, sweep);
            if third.any() {
                solve_wide_contact::<L, 4>(wide, bodies, context);
            } else {
                solve_wide_contact::<L, 2>(wide, bodies, context);
            }
        }
    }
);

#[inline(always)]
fn solve_wide_contact<L: Lanes, const POINTS: usize>(
    wide: &mut WideContact,
    bodies: &mut Bodies,
    (h, [recover, max_swing], [max_depenetration, elastic_depenetration], sweep): (
        f32,
        [f32; 2],
        [f32; 2],
        u32,
    ),
) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut a = Rows::<L>::load(bodies, &wide.a);
    let mut b = if wide.fixed { None } else { Some(Rows::<L>::load(bodies, &wide.b)) };
    // From the first one's centre to the second one's at the start, and the change of that. A `match`, because a closure is not compiled for the instruction
    // set of the kernel.
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
        L::mask(wide.elastic).select(L::splat(elastic_depenetration), L::splat(max_depenetration));
    let mut depenetrated = [none; POINTS];
    let mut left = [none; POINTS];

    let stiff = L::load(&wide.inverse_slip);
    let across = (drift - n * before).length() * stiff;
    let turned = spin.length() * L::load(&wide.inverse_turn);
    let moved = turned + across;
    let steep = (moved * L::load(&wide.steepness)).min(L::splat(STEEP_SHARE));
    let staleness = moved + steep;
    let mut total_staleness = L::load(&wide.staleness);
    if sweep == 0 {
        total_staleness = total_staleness + staleness;
        total_staleness.store(&mut wide.staleness);
    }

    let plane = PatchPlane { t, u, apart: (apart.dot(t), apart.dot(u)) };
    let (mut turning, mut spinning) = (plane.tilt(a.turn), plane.tilt(a.spin));
    if let Some(b) = &b {
        turning = turning.minus(&plane, b.turn);
        spinning = spinning.minus(&plane, b.spin);
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
    // Distance of the nearest points if they go on as in this substep, as a multiple of the valid slip; 0 if it is unknown. Where other points cannot be
    // nearer than that, nothing touches, and a stale manifold will do.
    let predicted_gap =
        none - (most + before.max(none)) * stiff - staleness * L::load(&wide.other_approach);
    let predicted_gap = L::splat(-0.5 * FAR).lt(most).and(predicted_gap);
    let may_be_nearer = L::load(&wide.other_approach) * total_staleness;
    let holds = total_staleness.lt(L::splat(1.0)).or(may_be_nearer.lt(predicted_gap));
    wide.stale = !holds.bits() & 0xFF;
    if (sweep == 0 || wide.sum == [0.0; LANES]) && !none.lt(most).any() {
        // Nothing touches, and nothing pressed in this substep. The rest would change none of the eight.
        wide.sum = [0.0; LANES];
        wide.depenetrated = 0;
        wide.force = [[0.0; LANES]; 4];
        wide.remaining_overlap = [0.0; LANES];
        let arm = unpressed_arm(wide, &radii, (&at, &height), (t, u, n));
        wide.let_go(n, arm);
        return;
    }
    let (apart_t, apart_u) = plane.apart;
    let theirs = match &b {
        None => None,
        Some(b) => Some(PatchSide::of_body(b, t, u)),
    };
    let mut patch = ContactPatch {
        weight,
        a: PatchSide::of_body(&a, t, u),
        b: theirs,
        apart: plane.apart,
        regularisation: none,
    };
    if none.lt(patch.pin_reach()).any() {
        patch.limit_recovery(&mut c, &at, &left, [recover, L::splat(max_swing)]);
        patch.regularise(&at);
    }
    // Impulses of earlier sweeps of the substep may be taken back: they are accumulated, and their sums are clamped at zero.
    let mut accumulated = [none; POINTS];
    let force = if sweep > 0 {
        for (to, from) in accumulated.iter_mut().zip(&wide.force) {
            *to = L::load(from);
        }
        solve_normal_impulses(&patch, &c, &at, Some(&accumulated))
    } else {
        solve_normal_impulses(&patch, &c, &at, None)
    };
    let (mut sum, mut x, mut y, mut z) = (none, none, none, none);
    let mut more = Vector::new(none, none, none);
    for i in 0..POINTS {
        sum = sum + force[i];
        x = x + force[i] * at[i].0;
        y = y + force[i] * at[i].1;
        z = z + force[i] * height[i];
        let by = force[i] - accumulated[i];
        more += Vector::new(by, by * at[i].0, by * at[i].1);
    }

    // Non-finite values must not reach the other body.
    let good = sum.lt(L::splat(1e30)).and(none.lt(sum).or(more.x.lt(none)));
    let old = (a.shift, a.turn);
    let mut old_b = (a.shift, a.turn);
    a.shift += n * (more.x * a.inverse_mass);
    a.turn += patch.a.turned(more.y, more.z);
    let mut size = a.shift.length_squared() + a.turn.length_squared();
    let mut marked = none.lt(a.depenetration_mark);
    if let (Some(b), Some(side)) = (&mut b, &patch.b) {
        old_b = (b.shift, b.turn);
        b.shift -= n * (more.x * b.inverse_mass);
        b.turn -= side.turned(more.y - apart_t * more.x, more.z - apart_u * more.x);
        size = size + b.shift.length_squared() + b.turn.length_squared();
        marked = marked.or(none.lt(b.depenetration_mark));
    }
    let good = good.and(size.lt(L::splat(1e30)));
    good.and(sum).store(&mut wide.sum);
    let mut deepest = none;
    for i in 0..POINTS {
        deepest = deepest.max(none.lt(force[i]).and(left[i]));
    }
    deepest.store(&mut wide.remaining_overlap);
    let marked = good.and(marked.or(pressed(&depenetrated, &force)));
    wide.depenetrated = marked.bits();
    if wide.kept || wide.sweeps > 1 || marked.any() {
        wide.force = [[0.0; LANES]; 4];
        for i in 0..POINTS {
            good.and(force[i]).store(&mut wide.force[i]);
            let touches = none.lt(c[i]).or(none.lt(force[i]));
            let approach = (spun[i] - before) * L::splat(1.0 / h);
            touches.select(approach, L::splat(FAR)).store(&mut wide.approach[i]);
        }
        (L::load(&wide.total) + good.and(more.x)).store(&mut wide.total);
    }
    let unpressed = unpressed_arm(wide, &radii, (&at, &height), (t, u, n));
    if !good.any() {
        wide.let_go(n, unpressed);
        return;
    }
    let mark = marked.and(one);
    let (shift, turn) = (a.shift.or_else(good, old.0), a.turn.or_else(good, old.1));
    let first = [shift.with(a.inverse_mass), turn.with(a.depenetration_mark.max(mark))];
    L::put_records(&mut bodies.rows, &wide.a, first);
    if let Some(b) = b {
        let (shift, turn) = (b.shift.or_else(good, old_b.0), b.turn.or_else(good, old_b.1));
        let mark = none.lt(b.inverse_mass).and(b.depenetration_mark.max(mark));
        let second = [shift.with(b.inverse_mass), turn.with(mark)];
        L::put_records(&mut bodies.rows, &wide.b, second);
    }

    // Where friction acts: at the centre of pressure, with the extent of the patch around it.
    let share = good.and(none.lt(sum)).and(one / sum);
    let (x, y, z) = (x * share, y * share, z * share);
    let mut spread = none;
    for i in 0..POINTS {
        let (dx, dy, dz) = (at[i].0 - x, at[i].1 - y, height[i] - z);
        spread = spread + (dx * dx + dy * dy + dz * dz) * force[i];
    }
    good.and((spread * share).sqrt()).store(&mut wide.radius);
    store(n, &mut wide.up);
    let arm = t * x + u * y + n * z;
    store(arm.or_else(none.lt(share), unpressed), &mut wide.arm);
}

/// Where friction acts without an impulse in this substep, from the first one's centre: at the centre, because friction at an edge that has lifted would rock the
/// body, for minutes; of a round shape where it is nearest, or what rolls would be held at its centre. Joints turn bones and segments on their contact points, so
/// these count as not round here (they have no torsional radius): bones of figures that fell by a metre were off by 1.5 % instead of 1 % otherwise.
#[inline(always)]
fn unpressed_arm<L: Lanes, const POINTS: usize>(
    wide: &WideContact,
    radii: &[L; 2],
    (at, height): (&[(L, L); POINTS], &[L; POINTS]),
    (t, u, n): (Vector<L>, Vector<L>, Vector<L>),
) -> Vector<L> {
    let (none, one) = (L::zero(), L::splat(1.0));
    let (mut count, mut x, mut y, mut z) = (none, none, none, none);
    for i in 0..POINTS {
        let there = L::load(&wide.missing[i]).lt(L::splat(FAR));
        count = count + there.and(one);
        (x, y) = (x + there.and(at[i].0), y + there.and(at[i].1));
        z = z + there.and(height[i]);
    }
    let alone = none.lt(L::load(&wide.torsional_radius));
    let is_round = none.lt(radii[0].max(radii[1])).and(alone).and(none.lt(count));
    let share = is_round.and(one / count);
    t * (x * share) + u * (y * share) + n * (z * share)
}

/// The anchors of both from the first one's centre; `apart` goes from there to the second one's centre.
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

/// Vectors along the normal from the surface to the centre of the rounding of the first ones, and the reverse of the second ones.
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

/// The directions across axes that are nearest to `n`; `n` itself where it is along the axis.
#[inline(always)]
fn across_axis<L: Lanes>(n: Vector<L>, axis: Vector<L>) -> Vector<L> {
    let across = n - axis * n.dot(axis);
    let sine = across.length();
    (across * (L::splat(1.0) / sine)).or_else(L::splat(1e-3).lt(sine), n)
}

/// The normals of manifolds whose second one is round: that of a face turns with the face, and that between two round ones follows from their positions. A
/// function of its own, since few manifolds need it.
#[inline(always)]
fn round_normals<L: Lanes, const POINTS: usize>(
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
    // Coinciding centres have no direction.
    let apart = (radii[0] * L::splat(1e-3)).lt(length).and(own).and(theirs);
    let of_face = theirs.and(radii[0].le(none));
    let face = a.rotation.times(load(&wide.normal));
    let n = face.or_else(of_face, n);
    (between * (L::splat(1.0) / length)).or_else(apart, n)
}

/// The plane of a patch, and the position of the second one's centre in it, from the first one's, metres.
struct PatchPlane<L> {
    t: Vector<L>,
    u: Vector<L>,
    apart: (L, L),
}

/// Relative motion along the normal by two turns, `(r_a × n)·φ_a - (r_b × n)·φ_b`: linear in the position in the patch.
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
    /// The tilt relative to a turn `b` of the second one.
    #[inline(always)]
    fn minus(self, plane: &PatchPlane<L>, b: Vector<L>) -> Self {
        let (bt, bu) = (b.dot(plane.t), b.dot(plane.u));
        let at_centre = plane.apart.1 * bt - plane.apart.0 * bu;
        Self { t: self.t - bt, u: self.u - bu, at_centre }
    }

    #[inline(always)]
    fn at(&self, (x, y): (L, L)) -> L {
        y * self.t - x * self.u + self.at_centre
    }
}

/// Whether a point with the depenetration flag presses.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "points in several arrays")]
fn pressed<L: Lanes, const POINTS: usize>(depenetrated: &[L; POINTS], force: &[L; POINTS]) -> L {
    let mut any = L::zero();
    for i in 0..POINTS {
        any = any.or(depenetrated[i].and(L::zero().lt(force[i])));
    }
    any
}

/// Compliance of two bodies to impulses along the normal of a patch.
pub(super) struct ContactPatch<L> {
    /// Sum of their inverse masses, 1/kg.
    pub(super) weight: L,
    pub(super) a: PatchSide<L>,
    /// `None` for fixed geometry.
    pub(super) b: Option<PatchSide<L>>,
    /// Position of the second one's centre from the first one's, along `t` and `u`, metres.
    pub(super) apart: (L, L),
    /// Compliance added to each point for its own impulse, 1/kg: see [`PIN_REGULARISATION`].
    pub(super) regularisation: L,
}

/// One of the bodies: its inverse inertia `J` in the axes of the patch.
pub(super) struct PatchSide<L> {
    /// `J t` and `J u`.
    t: Vector<L>,
    u: Vector<L>,
    /// `t·J t`, `u·J u`, `t·J u`, 1/(kg·m²).
    tt: L,
    uu: L,
    tu: L,
    /// Reach of a pinned body from its pin, metres; 0 of others.
    pin_reach: L,
    /// Compliance at the [least lever](LEAST_LEVER), 1/kg.
    least: L,
}

impl<L: Lanes> PatchSide<L> {
    #[inline(always)]
    pub(super) fn of(inverse_inertia: &Symmetric<L>, t: Vector<L>, u: Vector<L>) -> Self {
        let (jt, ju) = (inverse_inertia.times(t), inverse_inertia.times(u));
        let (pin_reach, least) = (L::zero(), L::zero());
        Self { t: jt, u: ju, tt: t.dot(jt), uu: u.dot(ju), tu: t.dot(ju), pin_reach, least }
    }

    /// A body, which may be pinned.
    #[inline(always)]
    pub(super) fn of_body(body: &Rows<L>, t: Vector<L>, u: Vector<L>) -> Self {
        let (pin_reach, Vector { x, y, z }) = (body.pin_reach, body.inverse_inertia.along);
        let lever = pin_reach * L::splat(LEAST_LEVER);
        let least = (x + y + z) * lever * lever;
        Self { pin_reach, least, ..Self::of(&body.inverse_inertia, t, u) }
    }

    /// The turn by impulses along the normal with the moments `x` and `y`, kg·m², from this centre.
    #[inline(always)]
    pub(super) fn turned(&self, x: L, y: L) -> Vector<L> {
        self.t * y - self.u * x
    }

    /// Displacement along the normal at `(x, y)` from this centre, per impulse there, by turning alone, 1/kg.
    #[inline(always)]
    fn moved(&self, x: L, y: L) -> L {
        x * (x * self.uu - y * self.tu) + y * (y * self.tt - x * self.tu)
    }

    /// Adds its share to `Q` about a point at `(x, y)` from its centre.
    #[inline(always)]
    fn add_to(&self, q: &mut Symmetric<L>, x: L, y: L) {
        let along = (x * self.uu - y * self.tu, y * self.tt - x * self.tu);
        q.along.x = q.along.x + (x * along.0 + y * along.1);
        q.along.y = q.along.y + self.uu;
        q.along.z = q.along.z + self.tt;
        q.across.x = q.across.x + along.0;
        q.across.y = q.across.y + along.1;
        q.across.z = q.across.z - self.tu;
    }
}

impl<L: Lanes> ContactPatch<L> {
    /// `Q` about the point at `(x, y)` from the first one's centre: maps the sum and the moments `Gᵀ λ` of impulses to the motion of the patch plane.
    #[inline(always)]
    pub(super) fn about(&self, x: L, y: L) -> Symmetric<L> {
        let none = L::zero();
        let mut q = Symmetric {
            along: Vector::new(self.weight, none, none),
            across: Vector::new(none, none, none),
        };
        self.a.add_to(&mut q, x, y);
        if let Some(b) = &self.b {
            b.add_to(&mut q, x - self.apart.0, y - self.apart.1);
        }
        q
    }

    /// Reach of the two from their pins, metres; 0 where neither is pinned.
    #[inline(always)]
    fn pin_reach(&self) -> L {
        match &self.b {
            None => self.a.pin_reach,
            Some(b) => self.a.pin_reach.max(b.pin_reach),
        }
    }

    /// Reduces `c` by the overlap whose recovery would move any point of a pinned body farther than `max_swing` metres; and leaves out points that have no
    /// lever about pins and no other body that yields. See [the module](self), "Near a pin".
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "points in several arrays")]
    fn limit_recovery<const POINTS: usize>(
        &self,
        c: &mut [L; POINTS],
        at: &[(L, L); POINTS],
        left: &[L; POINTS],
        [recover, max_swing]: [L; 2],
    ) {
        for i in 0..POINTS {
            let (x, y) = at[i];
            let moved = self.moved(x, y);
            let mut swung = self.a.turned(x, y).length() * self.a.pin_reach;
            if let Some(b) = &self.b {
                let (x, y) = (x - self.apart.0, y - self.apart.1);
                swung = swung.max(b.turned(x, y).length() * b.pin_reach);
            }
            let most = L::zero().lt(swung).select(max_swing * (moved / swung), recover);
            let less = left[i].min(recover) - left[i].min(recover.min(most));
            c[i] = self.yields(at[i]).select(c[i] - less, L::splat(-FAR));
        }
    }

    /// Whether the point at `(x, y)` yields to an impulse: not without a lever about the pins, if no other body does.
    #[inline(always)]
    pub(super) fn yields(&self, (x, y): (L, L)) -> L {
        let least = match &self.b {
            None => self.a.least,
            Some(b) => self.a.least.max(b.least),
        };
        least.lt(self.moved(x, y))
    }

    /// Displacement along the normal at `(x, y)` per impulse there, 1/kg.
    #[inline(always)]
    fn moved(&self, x: L, y: L) -> L {
        let moved = self.weight + self.a.moved(x, y);
        match &self.b {
            None => moved,
            Some(b) => moved + b.moved(x - self.apart.0, y - self.apart.1),
        }
    }

    /// Adds enough compliance to pinned patches to keep impulses bounded.
    #[inline(always)]
    pub(super) fn regularise<const POINTS: usize>(&mut self, at: &[(L, L); POINTS]) {
        let mut most = L::zero();
        for &(x, y) in at {
            most = most.max(self.moved(x, y));
        }
        let pinned = L::zero().lt(self.pin_reach());
        self.regularisation = pinned.and(most * L::splat(PIN_REGULARISATION));
    }
}

/// The impulses that recover the depths `c` of points at `(x, y)` from the first one's centre, metres. Missing points are far outside: with or without them,
/// the others get the same bits.
///
/// With the impulses `had` that have moved the points already, it returns the sums of these and the new ones, and the sums are not negative. What is solved for is
/// the change: without depth there is none, although the regularised system would have other sums.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "points in several arrays")]
pub(super) fn solve_normal_impulses<L: Lanes, const POINTS: usize>(
    patch: &ContactPatch<L>,
    c: &[L; POINTS],
    at: &[(L, L); POINTS],
    had: Option<&[L; POINTS]>,
) -> [L; POINTS] {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut inside = [none; POINTS];
    let (mut x, mut y, mut count) = (none, none, none);
    for i in 0..POINTS {
        inside[i] = none.lt(c[i]);
        if let Some(had) = had {
            inside[i] = inside[i].or(none.lt(had[i]));
        }
        count = count + inside[i].and(one);
        x = x + inside[i].and(at[i].0);
        y = y + inside[i].and(at[i].1);
    }
    let share = none.lt(count).select(one / count, none);
    let (x, y) = (x * share, y * share);
    let q = patch.about(x, y);
    // S, and Gᵀ c.
    let (mut xx, mut yy, mut xy) = (none, none, none);
    let mut b = Vector::new(none, none, none);
    let g = centred(at, &inside, (x, y), share);
    for i in 0..POINTS {
        let (dx, dy) = g[i];
        let (ix, iy) = (inside[i].and(dx), inside[i].and(dy));
        xx = xx + ix * ix;
        yy = yy + iy * iy;
        xy = xy + ix * iy;
        b.x = b.x + inside[i].and(c[i]);
        b.y = b.y + ix * c[i];
        b.z = b.z + iy * c[i];
    }
    let (qx, qy) = (q.across.x, q.across.y);
    let (ax, ay) = (xx * q.along.y + xy * q.across.z, xx * q.across.z + xy * q.along.z);
    let (bx, by) = (xy * q.along.y + yy * q.across.z, xy * q.across.z + yy * q.along.z);
    // Without points, or where nothing yields, the divisor is 1.
    let extra = patch.regularisation;
    let pressing = count * count * q.along.x + count * extra;
    let pressing = none.lt(pressing).select(pressing, one);
    let size = (xx + yy) * share;
    let torsional_radius =
        none.lt(size).select(pressing * L::splat(TILT_REGULARISATION) * size, one);
    let mass = Symmetric {
        along: Vector::new(
            pressing,
            ax * xx + ay * xy + torsional_radius + extra * xx,
            bx * xy + by * yy + torsional_radius + extra * yy,
        ),
        across: Vector::new(
            count * (qx * xx + qy * xy),
            count * (qx * xy + qy * yy),
            ax * xy + ay * yy + extra * xy,
        ),
    };
    let (mu, _) = mass.solve(b);
    let mut force = [none; POINTS];
    let mut pulls = none;
    let (mut sums, mut before) = (zero(), zero());
    for i in 0..POINTS {
        let mut f = inside[i].and(mu.x + g[i].0 * mu.y + g[i].1 * mu.z);
        if let Some(had) = had {
            f = had[i] + f;
            before += Vector::new(had[i], had[i] * g[i].0, had[i] * g[i].1);
        }
        pulls = pulls.or(f.lt(none));
        force[i] = f.max(none);
        sums.x = sums.x + force[i];
        sums.y = sums.y + force[i] * g[i].0;
        sums.z = sums.z + force[i] * g[i].1;
    }
    // A point that was outside may have been pressed in.
    let (moved, before) = (q.times(sums), q.times(before));
    let mut c = *c;
    for i in 0..POINTS {
        let mut outside = c[i].le(none);
        if let Some(had) = had {
            outside = outside.and(had[i].le(none));
            let own = before.x + g[i].0 * before.y + g[i].1 * before.z;
            c[i] = c[i] + (own + extra * had[i]);
        }
        let left = c[i] - (moved.x + g[i].0 * moved.y + g[i].1 * moved.z);
        pulls = pulls.or(outside.and(none.lt(left)));
    }
    if pulls.any() {
        gauss_seidel((&q, extra), &g, &c, pulls, &mut force);
    }
    force
}

/// Positions of the points from the middle of the overlapping ones. That middle is rounded, which matters for points as close together as the round-off: so
/// it is computed and subtracted a second time.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "points in several arrays")]
fn centred<L: Lanes, const POINTS: usize>(
    at: &[(L, L); POINTS],
    inside: &[L; POINTS],
    (x, y): (L, L),
    share: L,
) -> [(L, L); POINTS] {
    let mut off = *at;
    let (mut more, mut and_more) = (L::zero(), L::zero());
    // No `map`: its closure is not compiled for the instruction set of the kernel, and would be called for each operation.
    for i in 0..POINTS {
        off[i] = (off[i].0 - x, off[i].1 - y);
        more = more + inside[i].and(off[i].0);
        and_more = and_more + inside[i].and(off[i].1);
    }
    let (more, and_more) = (more * share, and_more * share);
    for off in &mut off {
        *off = (off.0 - more, off.1 - and_more);
    }
    off
}

/// Projected Gauss–Seidel over the points, where a mask is set.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "rows and columns of the same points")]
fn gauss_seidel<L: Lanes, const POINTS: usize>(
    (q, extra): (&Symmetric<L>, L),
    g: &[(L, L); POINTS],
    c: &[L; POINTS],
    mask: L,
    force: &mut [L; POINTS],
) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut k = [[none; POINTS]; POINTS];
    let mut inverse = [none; POINTS];
    for i in 0..POINTS {
        let far = q.times(Vector::new(one, g[i].0, g[i].1));
        for j in 0..=i {
            k[i][j] = far.x + far.y * g[j].0 + far.z * g[j].1;
            k[j][i] = k[i][j];
        }
        k[i][i] = k[i][i] + extra;
        inverse[i] = mask.and(none.lt(k[i][i])).and(one / k[i][i]);
    }
    for _ in 0..ROUNDS {
        for i in 0..POINTS {
            // The last changed impulse is added last: the others are available earlier.
            let mut others = k[i][i] * force[i];
            for j in [(i + 1) % 4, (i + 2) % 4] {
                if j < POINTS {
                    others = others + k[i][j] * force[j];
                }
            }
            let (last, mut left) = ((i + 3) % 4, c[i] - others);
            if last < POINTS {
                left = left - k[i][last] * force[last];
            }
            force[i] = (force[i] + left * inverse[i]).max(none);
        }
    }
}

#[cfg(test)]
mod tests;
