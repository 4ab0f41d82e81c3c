//! Coulomb friction of wide contacts.
//!
//! In a heap, the normal solve tilts a box one way at one contact and back at the next; friction in between would drag the bodies on it, a little in each
//! substep, for ever. And friction tilts boxes, so it must not come last. So the friction of all contacts is solved before all normals, with the normal
//! impulses of the substeps before as its limit; only contacts that are new, or slide and are pressed more than that, are solved once more afterwards.
//! Friction acts against the slip `s` of the two surfaces on each other since the substep began, at the centre of pressure, and against the turn of one on
//! the other ([`TangentialSlip`]). The impulse is at most `μ Σ λ`, its moment about the normal at most that times the radius of the patch; of a point
//! contact, a hundredth of its size (`wide_contact::TORSIONAL_RADIUS`), without accumulated slip.
//!
//! # Predicted impulses
//!
//! Before the normal solve, bodies have fallen by `g h²`, and a body that is wedged between two slopes has slid on both by nearly that: more than friction
//! can hold. It would act against the fall up to its limit, although the two slopes together let nothing slide, and leave the actual creep alone: a wedged
//! box crept at a quarter of a millimetre a second for ever, and in a heap of a thousand one or the other fell because of it, for minutes. So where friction
//! would slip, it acts against the slip that will be left when all contacts have pressed as in the substeps before (`Bodies::predicted`). Where it sticks it
//! does not: impulses fluctuate in a heap, and would shake resting bodies (a thousand boxes then keep moving at 1 mm/s).
//!
//! # Impacts
//!
//! The mean of the normal impulses acts for some substeps after these have ended. An impact has its friction at once, after the normals, and would have it twice.
//! So from an impact on ([`IMPACT`]) until it sticks, a contact has no friction before the normals, and that of each substep's impulse after them.
//!
//! # Friction anchors
//!
//! The normal solve moves bodies after the friction solve, in a heap again and again, and friction on a slope is solved for a body before it is for those on
//! it. A sticking contact keeps its distance from where it stuck (`accumulated_slip`), and friction acts against that, too: so the contact stays there,
//! however little each substep leaves. On a slope the accumulated slip of a resting stack is as large as it takes to hold all of it. A part of it is taken
//! back in a substep ([`BACK`]), because a body moved back leaves with that speed. In a sliding contact it fades ([`FADES`]), or friction would keep pulling
//! to where the contact once stuck. All of it is kept from step to step (`contact_cache`).
//!
//! # The constraint residual
//!
//! It is the part of the contact corrections that joints take back. Friction on a bone needs the displacement that the bone really had.
//!
//! A particle that `k` body colliders share is displaced by a `k`-th of what each of them requires (`groups`). A pelvis, which shares all of its particles
//! with others, goes back by half of its slip, while contacts assume that it went back by all of it. The difference would not be held: a ragdoll on the
//! ground crept over it by up to a centimetre a second, for ever.
//!
//! So once the particles are displaced, the motion of such body colliders is extracted once more: the displacement of their centres since the substep began,
//! and their turn, as in `pose`. The difference from what contacts assume is added to the accumulated slip of sticking contacts.

use glam::Vec4;

use super::BodyContactSolver;
use super::bodies::{Bodies, WideSlidingBody, from_row};
use super::groups::BodyGroup;
use super::pose::{Gathered, ParticleSource};
use super::turn::{LaneArray, Matrix, Symmetric, load, tangents, zero};
use super::wide_contact::WideContact;
use crate::lanes::{FIELDS, LANES, Lanes, Vector, kernel};
use crate::particles::Particles;

/// Part of the accumulated slip that is taken back in a substep. With all of it a heap of a thousand boxes never rests (7 mm/s), with half of it at 1 to 3
/// mm/s, with a fifth at 0.1; with a twentieth a stack slips on a slope that is nearly too steep before it is held.
const BACK: f32 = 0.2;
/// Factor on the accumulated slip in a substep in which the contact slides. A stack on a slope that is nearly too steep slides for a few substeps in some
/// contacts and must not lose its anchor by that (with 0.9 it slides on for ever); a contact that really slides has lost it after some fifty substeps.
const FADES: f32 = 0.97;

/// Share of the newest substep in the running mean of normal impulses that limits friction. In a heap contacts press twice as hard in one substep and not at
/// all in the next; with the newest impulse alone friction would let go each time: a thousand boxes poured in any pose then keep moving at 1 to 8 mm/s for
/// ever, and with a mean they come to rest. Over time the friction limit has the same mean.
const NEWEST_SHARE: f32 = 0.25;
/// The largest multiplier of the friction ellipse, as a multiple of the trace of the compliance: from it on, to `f32`, friction has the direction of the slip.
const MOST_MULTIPLIER: f32 = 1e6;
/// Displacement by the normal impulse in a substep, metres, below which a contact counts as unloaded.
const NOTHING: f32 = 1e-10;
/// Excess of the present normal impulse over the mean, as a share of that, from which on friction of a sliding contact acts on the excess at once. Sticking
/// contacts do not need it.
const MORE: f32 = 0.1;
/// Multiple of the mean beyond which a normal impulse is that of an impact. In a heap at rest contacts press up to twice or three times as hard as in the mean.
const IMPACT: f32 = 4.0;

kernel!(
    /// Solves friction of wide contacts: before the normal solve, limited by the impulses of the substeps before; and after it, where needed, by the excess
    /// over these.
    pub(super) fn solve_all_friction<L: Lanes>(
        wide_contacts: &mut [WideContact],
        after: bool,
        // Accumulated slip that may be taken back in a substep, metres.
        max_correction: f32,
        bodies: &mut Bodies,
    ) {
        if after {
            bodies.predicted.fill(Vec4::ZERO);
        }
        for wide in wide_contacts {
            if after {
                friction_after::<L>(wide, bodies, max_correction);
            } else {
                friction_before::<L>(wide, bodies);
            }
        }
    }
);

/// Friction limited by the impulses of the substeps before.
#[inline(always)]
fn friction_before<L: Lanes>(wide: &mut WideContact, bodies: &mut Bodies) {
    let none = L::zero();
    let friction_limit = limit_before(wide);
    let friction_limit_used = if none.lt(friction_limit).any() {
        let slip = TangentialSlip::of(wide, bodies);
        let slid = slip.slid + slip.accumulated_slip * L::splat(BACK);
        let answer = slip.answer(wide, slid, friction_limit, Some(bodies));
        slip.apply(wide, &answer, bodies);
        answer.friction_limit_used
    } else {
        none
    };
    friction_limit_used.store(&mut wide.friction_limit_used);
}

/// The impulse of which friction is available before the normal solve, kg·m: none in a contact that has slid since an impact.
#[inline(always)]
fn limit_before<L: Lanes>(wide: &WideContact) -> L {
    let sticks = L::mask(!wide.sliding & 0xFF);
    L::zero().lt(L::load(&wide.friction)).and(sticks).and(L::load(&wide.friction_limit))
}

/// Friction limited by the excess over that; updates the friction anchor.
#[inline(always)]
fn friction_after<L: Lanes>(wide: &mut WideContact, bodies: &mut Bodies, max_correction: f32) {
    let none = L::zero();
    let rough = none.lt(L::load(&wide.friction));
    let mean = rough.and(L::load(&wide.friction_limit));
    let friction_limit = limit_before(wide);
    let (sum, mut friction_limit_used) = (L::load(&wide.sum), L::load(&wide.friction_limit_used));
    let more = rough.and((sum - friction_limit).max(none));
    if !none.lt(more.max(mean)).any() {
        // A contact that has let go for a substep sticks again at its old anchor.
        (wide.sticking, wide.sliding) = (0, 0);
        for accumulated_slip in &mut wide.accumulated_slip {
            (L::load(accumulated_slip) * L::splat(FADES)).store(accumulated_slip);
        }
        wide.friction_limit = LaneArray::default();
        return;
    }
    let slip = TangentialSlip::of(wide, bodies);
    let (mut left, mut granted) = (slip.slid, friction_limit);
    let needs = friction_limit_used.lt(friction_limit).select(none, more);
    let needs = (friction_limit * L::splat(MORE)).lt(needs).and(needs);
    if none.lt(needs).any() {
        // A contact without a limit before acts against the accumulated slip here.
        let fresh = friction_limit.le(none).and(L::splat(BACK));
        let slid = slip.slid + slip.accumulated_slip * fresh;
        let answer = slip.answer(wide, slid, needs, None);
        slip.apply(wide, &answer, bodies);
        (friction_limit_used, granted) =
            (friction_limit_used + answer.friction_limit_used, granted + needs);
        left += answer.back;
    }
    let sticks = friction_limit_used.lt(granted);
    slip.keep(wide, left, sticks, max_correction);
    let slides = L::mask(wide.sliding).or((mean * L::splat(IMPACT)).lt(sum));
    let mean = mean + (sum - mean) * L::splat(NEWEST_SHARE);
    let light = (mean * slip.weight()).le(L::splat(NOTHING));
    let mean = rough.and(light.select(none, mean));
    mean.store(&mut wide.friction_limit);
    wide.sliding = slides.bits() & none.lt(mean).bits() & !sticks.bits() & 0xFF;
    slip.predict_impulse(wide, mean, bodies);
}

kernel!(
    /// Predicts the impulses of wide contacts before the first substep of a step; earlier predictions are dropped.
    pub(super) fn predict_impulses<L: Lanes>(wide_contacts: &[WideContact], bodies: &mut Bodies) {
        bodies.predicted.fill(Vec4::ZERO);
        for wide in wide_contacts {
            let friction_limit = L::load(&wide.friction_limit);
            if !L::zero().lt(friction_limit).any() {
                continue;
            }
            TangentialSlip::of(wide, bodies).predict_impulse(wide, friction_limit, bodies);
        }
    }
);

/// Response of friction to a slip.
struct FrictionResponse<L> {
    /// Displacement and turn that are added to the first one, and subtracted from the second one, if that can move.
    a: (Vector<L>, Vector<L>),
    b: Option<(Vector<L>, Vector<L>)>,
    /// Part of the normal impulse whose friction was used, kg·m.
    friction_limit_used: L,
    /// Slip that it takes back.
    back: Vector<L>,
}

/// Tangential slip of eight pairs.
struct TangentialSlip<L> {
    a: WideSlidingBody<L>,
    /// `None` for fixed geometry.
    b: Option<WideSlidingBody<L>>,
    n: Vector<L>,
    t: Vector<L>,
    u: Vector<L>,
    /// Point of friction, from the centres of both.
    arm: Vector<L>,
    other: Vector<L>,
    /// Along `t` and `u`, metres, and about `n`, rad: in this substep, and accumulated before.
    slid: Vector<L>,
    accumulated_slip: Vector<L>,
}

impl<L: Lanes> TangentialSlip<L> {
    #[inline(always)]
    fn of(wide: &WideContact, bodies: &Bodies) -> Self {
        let a = WideSlidingBody::<L>::load(bodies, &wide.a);
        let b = if wide.fixed { None } else { Some(WideSlidingBody::<L>::load(bodies, &wide.b)) };
        let (n, arm) = (load::<L>(&wide.up), load::<L>(&wide.arm));
        let mut apart = load::<L>(&wide.offset);
        if let Some(b) = &b {
            apart = b.centre + apart;
        }
        let other = arm - (apart - a.centre);
        let (t, u) = tangents(n);
        let (mut slid, mut turned) = (a.moved(arm), a.spin + a.turn);
        if let Some(b) = &b {
            // The lever is from where the substep began, which is what Verlet keeps; the material there is where the two have come to.
            slid -= b.moved(other + a.step - b.step);
            turned = turned - b.spin - b.turn;
        }
        let twist = n.dot(turned);
        let slid = Vector::new(slid.dot(t), slid.dot(u), twist);
        let [x, y, z, turned] = &wide.accumulated_slip;
        let accumulated_slip = Vector::new(L::load(x), L::load(y), L::load(z));
        let accumulated_slip =
            Vector::new(accumulated_slip.dot(t), accumulated_slip.dot(u), L::load(turned));
        Self { a, b, n, t, u, arm, other, slid, accumulated_slip }
    }

    /// Inverse effective mass without rotation, 1/kg.
    #[inline(always)]
    fn weight(&self) -> L {
        match &self.b {
            None => self.a.inverse_mass,
            Some(b) => self.a.inverse_mass + b.inverse_mass,
        }
    }

    /// The response of friction to a slip, limited by the normal impulse `against`. With the predicted displacements of bodies, those that slip respond to the slip
    /// that is left after these.
    #[inline(always)]
    #[allow(clippy::manual_map, reason = "a closure is not made for the processor that it runs on")]
    fn answer(
        &self,
        wide: &WideContact,
        slid: Vector<L>,
        against: L,
        predicted: Option<&Bodies>,
    ) -> FrictionResponse<L> {
        let Self { a, b, n, t, u, arm, other, .. } = self;
        let axes = (*t, *u, *n);
        let weight = self.weight();
        let (own, stiff) = EffectiveMass::of(&a.inverse_inertia, *arm, axes);
        let along = Vector::new(weight, weight, L::zero()) + stiff.along;
        let mut stiff = Symmetric { along, ..stiff };
        let mut theirs = None;
        if let Some(b) = b {
            let (yields, more) = EffectiveMass::of(&b.inverse_inertia, *other, axes);
            stiff.along += more.along;
            stiff.across += more.across;
            theirs = Some((b.inverse_mass, yields));
        }
        let limit = against * L::load(&wide.friction);
        let radii = (L::load(&wide.radius), L::load(&wide.torsional_radius));
        let patch = FrictionPatch::new(&stiff, limit, radii);
        let (mut slid, mut stop) = (slid, patch.stop(slid));
        if let Some(bodies) = predicted {
            let slips = stop.good.and(L::splat(1.0).le(stop.much));
            if slips.any() {
                slid = (slid + self.predicted(wide, bodies)).or_else(slips, slid);
                stop = patch.stop(slid);
            }
        }
        let (f, much) = patch.impulse(slid, &stop);
        let good = f.length_squared().lt(L::splat(1e30));
        let f = Vector::new(good.and(f.x), good.and(f.y), good.and(f.z));
        let along = *t * f.x + *u * f.y;
        FrictionResponse {
            a: (along * a.inverse_mass, own.turned(f)),
            b: match &theirs {
                None => None,
                Some((inverse_mass, yields)) => Some((along * *inverse_mass, yields.turned(f))),
            },
            friction_limit_used: good.and(against * much),
            back: stiff.times(f),
        }
    }

    /// Applies a response to both.
    #[inline(always)]
    fn apply(&self, wide: &WideContact, answer: &FrictionResponse<L>, bodies: &mut Bodies) {
        let Self { a, b, .. } = self;
        let (shift, turn) = (a.shift + answer.a.0, a.turn + answer.a.1);
        let first = [shift.with(a.inverse_mass), turn.with(a.depenetration_mark)];
        L::put_records(&mut bodies.rows, &wide.a, first);
        if let (Some(b), Some(answer)) = (b, &answer.b) {
            let (shift, turn) = (b.shift - answer.0, b.turn - answer.1);
            let second = [shift.with(b.inverse_mass), turn.with(b.depenetration_mark)];
            L::put_records(&mut bodies.rows, &wide.b, second);
        }
    }

    /// Adds the displacements by normal impulses `sum` at the centre of pressure to the predicted ones.
    #[inline(always)]
    fn predict_impulse(&self, wide: &WideContact, sum: L, bodies: &mut Bodies) {
        let push = self.n * sum;
        add_predicted(&self.a, &wide.a, self.arm, push, bodies);
        if let Some(b) = &self.b {
            add_predicted(b, &wide.b, self.other, -push, bodies);
        }
    }

    /// Slip that all predicted impulses will cause.
    #[inline(always)]
    fn predicted(&self, wide: &WideContact, bodies: &Bodies) -> Vector<L> {
        let (a, turned) = moved_at::<L>(&bodies.predicted, &wide.a, self.arm);
        let (mut past, mut twisted) = (a, turned);
        if self.b.is_some() {
            let (b, other) = moved_at::<L>(&bodies.predicted, &wide.b, self.other);
            (past, twisted) = (a - b, turned - other);
        }
        Vector::new(past.dot(self.t), past.dot(self.u), self.n.dot(twisted))
    }

    /// Stores the remaining slip of sticking contacts; that of sliding contacts fades.
    #[inline(always)]
    fn keep(&self, wide: &mut WideContact, left: Vector<L>, sticks: L, most: f32) {
        let Self { accumulated_slip, t, u, .. } = self;
        let left = *accumulated_slip + left;
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&wide.radius));
        let sticks = sticks.and(size.le(L::splat(most / BACK)));
        wide.sticking = sticks.bits();
        let left = left.or_else(sticks, *accumulated_slip * L::splat(FADES));
        // A point contact has no defined twist.
        let is_point = L::load(&wide.radius).lt(L::load(&wide.torsional_radius));
        let twist = is_point.select(L::zero(), left.z);
        let mut along = *t * left.x + *u * left.y;
        if let Some(b) = &self.b {
            // It is a distance on the surface of the second one, and turns with that.
            along += b.spin.cross(along);
        }
        for (to, from) in wide.accumulated_slip.iter_mut().zip([along.x, along.y, along.z, twist]) {
            from.store(to);
        }
    }
}

/// Friction of eight patches: Coulomb's limits are `limit` along a patch and `limit · radius` about its normal, and for both together their ellipse.
///
/// Where the impulse that stops the slip `(x, y)` and the twist `z` at once is beyond the limit, the two slip, and friction acts against the slip that is left.
/// With `K` the compliance, `s` the slip without friction and `D` the squares of the ellipse's axes, `1, 1, radius²`, by the limit's, the impulse is
///
/// ```text
/// f = -(K + λ D⁻¹)⁻¹ s        with the λ ≥ 0 with which f lies on the ellipse
/// ```
///
/// which dissipates most (Moreau's principle, taken at the end of the substep). The impulse that would stop everything, merely shortened, has a moment where the
/// patch lies beside the centre of mass, although nothing twists: a barrel that slid over two rails turned by half a radian. The equation for `λ` is that of a
/// trust region (Moré and Sorensen 1983). Two numbers that are not above its root are at hand, Newton's first step from zero and `|s| / limit - tr K`; the
/// larger one is taken, and the impulse, which then is on the ellipse or beyond, shortened to it. From a `λ` that is too large it would have to be lengthened,
/// which can turn a slip around and make it faster.
///
/// Where the radius is less than `torsional_radius`, metres, it is a point contact. Its twist is stopped, too, by at most `limit · torsional_radius`; but its
/// slip is solved as if it did not twist.
struct FrictionPatch<L> {
    /// Compliance, the identity where nothing slides; and that to a twist alone.
    k: Symmetric<L>,
    twisted: L,
    limit: L,
    radius: L,
    torsional_radius: L,
    slides: L,
    twists: L,
    /// Inverses of the ellipse's axes; 0 for a twist that friction does not stop.
    share: Vector<L>,
}

/// The impulse that would stop a slip.
struct StoppingImpulse<L> {
    f: Vector<L>,
    /// As a multiple of the limit.
    much: L,
    /// Whether the compliance is positive definite.
    good: L,
}

impl<L: Lanes> FrictionPatch<L> {
    #[inline(always)]
    fn new(k: &Symmetric<L>, limit: L, (radius, torsional_radius): (L, L)) -> Self {
        let (none, one) = (L::zero(), L::splat(1.0));
        let slides = none.lt(limit).and(none.lt(k.along.x)).and(none.lt(k.along.y));
        // Without compliance to a twist there is none.
        let twists = torsional_radius
            .le(radius)
            .and(none.lt(radius))
            .and((L::splat(1e-6) * (k.along.x + k.along.y)).lt(k.along.z * radius * radius));
        let along = Vector::new(
            slides.select(k.along.x, one),
            slides.select(k.along.y, one),
            twists.and(slides).select(k.along.z, one),
        );
        let across = &k.across;
        let across = Vector::new(slides.and(across.x), twists.and(across.y), twists.and(across.z));
        let inverse = one / slides.select(limit, one);
        let share = Vector::new(inverse, inverse, twists.and(inverse / radius));
        let (k, twisted) = (Symmetric { along, across }, k.along.z);
        Self { k, twisted, limit, radius, torsional_radius, slides, twists, share }
    }

    #[inline(always)]
    fn stop(&self, slid: Vector<L>) -> StoppingImpulse<L> {
        let (f, pivot) = self.k.solve(self.slip(slid));
        let good = self.slides.and(L::zero().lt(pivot));
        StoppingImpulse { f, much: self.length(f), good }
    }

    /// The impulse of friction against a slip, given the one that would stop it, and the used share of the limit.
    #[inline(always)]
    fn impulse(&self, slid: Vector<L>, stop: &StoppingImpulse<L>) -> (Vector<L>, L) {
        let Self { k, twisted, limit, radius, torsional_radius, slides, twists, share } = self;
        let (none, one) = (L::zero(), L::splat(1.0));
        let StoppingImpulse { mut f, much, good } = *stop;
        let slips = good.and(one.lt(much));
        if slips.any() {
            let slip = self.slip(slid);
            let about = twists.and(one / (*radius * *radius));
            let normal = Vector::new(f.x, f.y, f.z * about);
            let newton = normal.dot(f) / normal.dot(k.solve(normal).0) * (much - one);
            let turned = slip.z * *radius;
            let fast = (slip.x * slip.x + slip.y * slip.y + turned * turned).sqrt();
            let trace = k.along.x + k.along.y + twists.and(k.along.z * *radius * *radius);
            let most = trace * L::splat(MOST_MULTIPLIER);
            let more = slips.and(newton.max(fast * share.x - trace).min(most));
            let along = k.along + Vector::new(more, more, more * about);
            let left = Symmetric { along, across: k.across }.solve(slip).0;
            f = (left * (one / self.length(left)).min(one)).or_else(slips, f);
        }
        let is_point = radius.lt(*torsional_radius).and(*slides).and(none.lt(*twisted));
        let (way, most) = (-slid.z / *twisted, *limit * *torsional_radius);
        let twist = is_point.and(good).and(way.max(-most).min(most));
        (Vector::new(good.and(f.x), good.and(f.y), good.and(f.z) + twist), good.and(much.min(one)))
    }

    /// The negative slip, without a twist that friction does not stop.
    #[inline(always)]
    fn slip(&self, slid: Vector<L>) -> Vector<L> {
        Vector::new(-slid.x, -slid.y, -self.twists.and(slid.z))
    }

    /// The length of an impulse as a multiple of the limit.
    #[inline(always)]
    fn length(&self, f: Vector<L>) -> L {
        let share = &self.share;
        Vector::new(f.x * share.x, f.y * share.y, f.z * share.z).length_squared().sqrt()
    }
}

/// Adds the displacement of eight bodies by an impulse `push` at an arm from their centres to the predicted ones.
#[inline(always)]
fn add_predicted<L: Lanes>(
    body: &WideSlidingBody<L>,
    rows: &[u32; LANES],
    arm: Vector<L>,
    push: Vector<L>,
    bodies: &mut Bodies,
) {
    let [shifts, turns] = pair_of_rows(rows);
    let turn = body.inverse_inertia.times(arm.cross(push));
    let shift = Vector::of(L::rows(&bodies.predicted, &shifts)).0 + push * body.inverse_mass;
    let turn = Vector::of(L::rows(&bodies.predicted, &turns)).0 + turn;
    // Non-finite values must not reach other bodies.
    let good = (shift.length_squared() + turn.length_squared()).lt(L::splat(1e30));
    let none = Vector::new(L::zero(), L::zero(), L::zero());
    let (shift, turn) = (shift.or_else(good, none), turn.or_else(good, none));
    L::put_rows(&mut bodies.predicted, &shifts, shift.with(L::zero()));
    L::put_rows(&mut bodies.predicted, &turns, turn.with(L::zero()));
}

/// Response of a body to impulses along two directions at an arm, and to a moment about a third: the turn that each of them causes.
struct EffectiveMass<L> {
    t: Vector<L>,
    u: Vector<L>,
    n: Vector<L>,
}

impl<L: Lanes> EffectiveMass<L> {
    /// The response, and the compliance matrix of the three without the displacement of the centre.
    #[inline(always)]
    fn of(
        inverse_inertia: &Symmetric<L>,
        arm: Vector<L>,
        (t, u, n): (Vector<L>, Vector<L>, Vector<L>),
    ) -> (Self, Symmetric<L>) {
        let (t, u) = (arm.cross(t), arm.cross(u));
        let (by_t, by_u) = (inverse_inertia.times(t), inverse_inertia.times(u));
        let by_n = inverse_inertia.times(n);
        let along = Vector::new(t.dot(by_t), u.dot(by_u), n.dot(by_n));
        let across = Vector::new(t.dot(by_u), t.dot(by_n), u.dot(by_n));
        (Self { t: by_t, u: by_u, n: by_n }, Symmetric { along, across })
    }

    #[inline(always)]
    fn turned(&self, f: Vector<L>) -> Vector<L> {
        self.t * f.x + self.u * f.y + self.n * f.z
    }
}

/// Positions of the displacements and of the turns of eight bodies in [`Bodies::predicted`] and [`Bodies::residual`].
#[inline(always)]
fn pair_of_rows(rows: &[u32; LANES]) -> [[u32; LANES]; 2] {
    let mut pair = [[0; LANES]; 2];
    for (lane, row) in rows.iter().enumerate() {
        (pair[0][lane], pair[1][lane]) = (2 * row, 2 * row + 1);
    }
    pair
}

/// Predicted displacement, or residual, of a point of each of eight bodies, and its turn.
#[inline(always)]
fn moved_at<L: Lanes>(of: &[Vec4], rows: &[u32; LANES], arm: Vector<L>) -> (Vector<L>, Vector<L>) {
    let [shifts, turns] = pair_of_rows(rows);
    let turn = Vector::of(L::rows(of, &turns)).0;
    let shift = Vector::of(L::rows(of, &shifts)).0;
    (shift + turn.cross(arm), turn)
}

impl BodyContactSolver {
    /// Measures the residual of body colliders that share particles and stick, and adds it to their accumulated slip.
    pub(super) fn measure_residual(&mut self, particles: &Particles) {
        let Self { groups, origin_offsets, bodies, gathered, wide_contacts, instructions, .. } =
            self;
        let (rigid, sticking) = (&self.rigid, &mut self.sticking);
        // Groups without sticking contacts are left out.
        sticking.clear();
        sticking.resize(groups.groups.len(), false);
        for wide in wide_contacts.iter().filter(|wide| wide.sticking != 0) {
            for &row in wide.a.iter().chain(&wide.b) {
                if let Some(sticks) = sticking.get_mut(row as usize / LANES) {
                    *sticks = true;
                }
            }
        }
        let mut any = false;
        let slots = &groups.slots;
        let groups = groups.groups.iter().zip(&*sticking).enumerate();
        let sharing = groups.filter(|(_, (group, sticks))| group.shares && **sticks);
        for (number, (group, _)) in sharing {
            let source = ParticleSource {
                slots: &slots[group.slots.clone()],
                origin_offsets: origin_offsets.of(group),
                position: &particles.position,
                other: &particles.start,
                fresh: false,
            };
            let (first, lanes) = (number * LANES, !rigid.lanes(number));
            measure_residual(group, source, bodies, first, gathered, lanes, *instructions);
            any = true;
        }
        if any {
            apply_residual(wide_contacts, bodies, *instructions);
        }
    }
}

kernel!(
    /// Compares the actual motion of a group with the one that contacts assume.
    fn measure_residual<L: Lanes>(
        group: &BodyGroup,
        source: ParticleSource<'_>,
        bodies: &mut Bodies,
        // The first row of the group among the bodies.
        first: usize,
        // Scratch.
        gathered: &mut Vec<Gathered>,
        // A bit for each lane to measure: rigid states have no residual.
        lanes: u32,
    ) {
        let (rows, lanes) = (from_row(first), L::mask(lanes));
        let [shift, turn, along, across, _, believed, spin, rotation] =
            L::records::<FIELDS>(&bodies.rows, &rows);
        let (centre, step) = source.centre::<L>(&group.mass, gathered);
        let mut momentum = zero::<L>();
        for (slot, kept) in source.slots.iter().zip(gathered) {
            let (arm, moved) = (load(&kept.position) - centre, load(&kept.moved) - step);
            momentum += arm.cross(moved) * L::load(&slot.pull);
        }
        let inverse = if group.pinned {
            Symmetric::load(&group.mass.led).turned(&Matrix::of(rotation))
        } else {
            Symmetric { along: Vector::of(along).0, across: Vector::of(across).0 }
        };
        let off = step - Vector::of(believed).0 - Vector::of(shift).0;
        let turned = inverse.times(momentum) - Vector::of(spin).0 - Vector::of(turn).0;
        let (off, turned) = (off.or_else(lanes, zero()), turned.or_else(lanes, zero()));
        let [shifts, turns] = pair_of_rows(&rows);
        L::put_rows(&mut bodies.residual, &shifts, off.with(L::zero()));
        L::put_rows(&mut bodies.residual, &turns, turned.with(L::zero()));
    }
);

kernel!(
    /// Adds the residual to the accumulated slip of sticking contacts.
    fn apply_residual<L: Lanes>(wide_contacts: &mut [WideContact], bodies: &Bodies) {
        for wide in wide_contacts.iter_mut().filter(|wide| wide.sticking != 0) {
            let sticks = L::mask(wide.sticking);
            let (n, arm) = (load::<L>(&wide.up), load::<L>(&wide.arm));
            let (mut past, mut turned) = moved_at::<L>(&bodies.residual, &wide.a, arm);
            if !wide.fixed {
                let (own, theirs) = (centre::<L>(bodies, &wide.a), centre::<L>(bodies, &wide.b));
                let other = arm - (theirs + load::<L>(&wide.offset) - own);
                let (b, back) = moved_at::<L>(&bodies.residual, &wide.b, other);
                (past, turned) = (past - b, turned - back);
            }
            let twist = n.dot(turned);
            // Non-finite values must not be stored.
            let sound = (past.length_squared() + twist * twist).lt(L::splat(1e30));
            let sticks = sticks.and(sound);
            for (accumulated_slip, by) in
                wide.accumulated_slip.iter_mut().zip([past.x, past.y, past.z, twist])
            {
                (L::load(accumulated_slip) + sticks.and(by)).store(accumulated_slip);
            }
        }
    }
);

/// Centres of eight bodies when the substep began, metres from their origins.
#[inline(always)]
fn centre<L: Lanes>(bodies: &Bodies, rows: &[u32; LANES]) -> Vector<L> {
    let [_, _, _, _, centre] = L::records(&bodies.rows, rows);
    Vector::of(centre).0
}
