//! Friction solve of wide contacts, by Coulomb.
//!
//! In a heap, pressing tilts a box one way at one contact and back at the next; friction that saw it in between would drag what lies on it, a little
//! in each substep, for ever. And friction tilts boxes, which must not be the last that is done to them. So all of a heap is held before all of it is
//! pressed, against what pressed it in the substeps before; and only what has just met, or slides although it is pressed more than that, once more
//! afterwards. Positions are held against `s`, how far the two surfaces have slid on each other since the substep began, at the centre of the
//! pressure; and against the turn of one on the other ([`TangentialSlip`]). The impulse is at most `μ Σ λ`, its moment about the normal at most that
//! times the radius of the patch; of what is a point, a hundredth of its size (`wide_contact::TORSIONAL_RADIUS`), without accumulated slip.
//!
//! # What is to come
//!
//! Before they are pressed, things have fallen by `g h²`, and what is wedged between two slopes has slid on both by nearly that: more than friction
//! may hold. It would act against the fall with all it has, where the two slopes together let nothing slide, and leave alone what really creeps: a
//! wedged box crept at a quarter of a millimetre a second for ever, and in a heap of a thousand one or the other fell of it, for minutes. So where
//! friction would slip, it acts against what will be left when all have pressed as they did in the substeps before (`Bodies::predicted`). Where it
//! sticks it does not: pressures come and go in a heap, and would shake what lies still (a thousand boxes then go on at 1 mm/s).
//!
//! # Where it stuck
//!
//! Pressing moves things after they were held, in a heap again and again, and what carries others on a slope is held before they are. What sticks
//! remembers how far it is from where it stuck (`accumulated_slip`), and is held against that, too: so that it stays there, however small the part
//! that each substep leaves. What lies still on a slope has accumulated as much slip as it takes for all of a stack to be held. A part of that is
//! taken back in a substep ([`BACK`]), because what is moved back leaves with speed. What slides forgets ([`FADES`]), or friction would go on pulling
//! to where it once stuck. All of it goes from step to step (`contact_cache`).
//!
//! # The constraint residual
//!
//! It is what joints take back of what contacts did. Friction that holds a bone must know how far that really went.
//!
//! A particle that `k` body colliders share is displaced by the `k`-th part of what each of them asks (`groups`). A pelvis, which others hang on by
//! all of its particles, goes back by half of what it slid, where contacts believe that it went back by all of it. What they do not know of they do
//! not hold: a ragdoll on the ground crept over it by up to a centimetre a second, for ever.
//!
//! So when the particles were displaced, such body colliders are read once more: how far their centres have gone since the substep began, and how
//! they have turned, as in `pose`. By what that differs from what contacts believe, they are farther from where they stuck. What slides does not ask.

use glam::Vec4;

use super::BodyContactSolver;
use super::bodies::{Bodies, WideSlidingBody, from_row};
use super::groups::BodyGroup;
use super::pose::{Gathered, ParticleSource};
use super::turn::{LaneArray, Matrix, Symmetric, load, tangents, zero};
use super::wide_contact::WideContact;
use crate::lanes::{FIELDS, LANES, Lanes, Vector, kernel};
use crate::particles::Particles;

/// Which part of the accumulated slip is taken back in a substep. With all of it a heap of a thousand boxes never rests (7 mm/s), with half of it at
/// 1 to 3 mm/s, with a fifth at 0.1; with a twentieth a stack slips on a slope that is nearly too steep, before it is held.
const BACK: f32 = 0.2;
/// What is left of it in a substep in which it slides. A stack on a slope that is nearly too steep slides for a few substeps in the one or other
/// contact, and must not forget by that (with 0.9 it goes on for ever); what really slides has forgotten after some fifty substeps.
const FADES: f32 = 0.97;

/// What presses is a mean over some substeps, of which this is the share of the newest one. In a heap contacts press twice as hard in one substep and
/// not at all in the next; friction that did as they do would let go each time: a thousand boxes poured in any pose then go on at 1 to 8 mm/s for
/// ever, and with a mean they come to rest. Over time that is as much friction as there was pressure.
const NEWEST_SHARE: f32 = 0.25;
/// What moves neither body by more than this in a substep, metres, is none.
const NOTHING: f32 = 1e-10;
/// By which part of the mean what slides must be pressed more for friction to act on that at once. What sticks needs no more.
const MORE: f32 = 0.1;

kernel!(
    /// Solves friction of wide contacts: before their normals are solved, against what pressed them in the substeps before; and after that, where it is
    /// needed, against what presses them more.
    pub(super) fn solve_all_friction<L: Lanes>(
        wide_contacts: &mut [WideContact],
        after: bool,
        // How far what sticks may be taken back in a substep, metres.
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

/// Against what pressed it in the substeps before.
#[inline(always)]
fn friction_before<L: Lanes>(wide: &mut WideContact, bodies: &mut Bodies) {
    let none = L::zero();
    let friction_limit = none.lt(L::load(&wide.friction)).and(L::load(&wide.friction_limit));
    let friction_limit_used = if none.lt(friction_limit).any() {
        let slip = TangentialSlip::of(wide, bodies);
        let slid = slip.slid + slip.accumulated_slip * L::splat(BACK);
        let answer = slip.answer(wide, slid, friction_limit);
        let slips = none.lt(friction_limit).and(friction_limit.le(answer.friction_limit_used));
        let answer = if slips.any() {
            let predicted = slid + slip.predicted(wide, bodies);
            slip.answer(wide, predicted.or_else(slips, slid), friction_limit)
        } else {
            answer
        };
        slip.apply(wide, &answer, bodies);
        answer.friction_limit_used
    } else {
        none
    };
    friction_limit_used.store(&mut wide.friction_limit_used);
}

/// Against what pressed it more than that, and what the anchor is to keep.
#[inline(always)]
fn friction_after<L: Lanes>(wide: &mut WideContact, bodies: &mut Bodies, max_correction: f32) {
    let none = L::zero();
    let friction_limit = none.lt(L::load(&wide.friction)).and(L::load(&wide.friction_limit));
    let (sum, mut friction_limit_used) = (L::load(&wide.sum), L::load(&wide.friction_limit_used));
    let more = none.lt(L::load(&wide.friction)).and((sum - friction_limit).max(none));
    if !none.lt(more.max(friction_limit)).any() {
        // What has let go for a substep takes hold again where it was.
        wide.sticking = 0;
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
        // Who was not held before is held against the accumulated slip here.
        let fresh = friction_limit.le(none).and(L::splat(BACK));
        let answer = slip.answer(wide, slip.slid + slip.accumulated_slip * fresh, needs);
        slip.apply(wide, &answer, bodies);
        (friction_limit_used, granted) =
            (friction_limit_used + answer.friction_limit_used, granted + needs);
        left += answer.back;
    }
    slip.keep(wide, left, friction_limit_used.lt(granted), max_correction);
    let old = L::load(&wide.friction_limit);
    let mean = old + (sum - old) * L::splat(NEWEST_SHARE);
    let light = (mean * slip.weight()).le(L::splat(NOTHING));
    let rough = none.lt(L::load(&wide.friction));
    let friction_limit = rough.and(light.select(none, mean));
    friction_limit.store(&mut wide.friction_limit);
    slip.predict_impulse(wide, friction_limit, bodies);
}

kernel!(
    /// Predicts the impulses of wide contacts in the next substep, where nothing has pressed yet: all that was noted before is forgotten.
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
    /// The displacement and the turn that it gives to the first one, and takes from the second one, if something can.
    a: (Vector<L>, Vector<L>),
    b: Option<(Vector<L>, Vector<L>)>,
    /// Against how much of the pressure it had to act, kg·m.
    friction_limit_used: L,
    /// How far it takes the slip back.
    back: Vector<L>,
}

/// Tangential slip of eight pairs.
struct TangentialSlip<L> {
    a: WideSlidingBody<L>,
    /// `None` where it stays where it is.
    b: Option<WideSlidingBody<L>>,
    n: Vector<L>,
    t: Vector<L>,
    u: Vector<L>,
    /// Where friction acts, from the centres of both.
    arm: Vector<L>,
    other: Vector<L>,
    /// Along `t` and `u`, metres, and about `n`, rad: in this substep, and before.
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
            slid -= b.moved(other);
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

    /// How far an impulse moves them apart, 1/kg.
    #[inline(always)]
    fn weight(&self) -> L {
        match &self.b {
            None => self.a.inverse_mass,
            Some(b) => self.a.inverse_mass + b.inverse_mass,
        }
    }

    /// What holds them against so much slip, as far as a sum `against` of the pressure lets it.
    #[inline(always)]
    #[allow(clippy::manual_map, reason = "a closure is not made for the processor that it runs on")]
    fn answer(&self, wide: &WideContact, slid: Vector<L>, against: L) -> FrictionResponse<L> {
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
        let (f, much) = solve_friction(
            &stiff,
            slid,
            limit,
            (L::load(&wide.radius), L::load(&wide.torsional_radius)),
        );
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

    /// Moves both by it.
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

    /// Notes that contacts are expected to press them with such sums, at the centre of the pressure.
    #[inline(always)]
    fn predict_impulse(&self, wide: &WideContact, sum: L, bodies: &mut Bodies) {
        let push = self.n * sum;
        add_predicted(&self.a, &wide.a, self.arm, push, bodies);
        if let Some(b) = &self.b {
            add_predicted(b, &wide.b, self.other, -push, bodies);
        }
    }

    /// How far all that is expected to press will have them slide on each other.
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

    /// Remembers what is left of their slip where they stick; where they slide, what was before fades.
    #[inline(always)]
    fn keep(&self, wide: &mut WideContact, left: Vector<L>, sticks: L, most: f32) {
        let Self { accumulated_slip, t, u, .. } = self;
        let left = *accumulated_slip + left;
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&wide.radius));
        let sticks = sticks.and(size.le(L::splat(most / BACK)));
        wide.sticking = sticks.bits();
        let left = left.or_else(sticks, *accumulated_slip * L::splat(FADES));
        // A point does not know how it was turned.
        let is_point = L::load(&wide.radius).lt(L::load(&wide.torsional_radius));
        let twist = is_point.select(L::zero(), left.z);
        let along = *t * left.x + *u * left.y;
        for (to, from) in wide.accumulated_slip.iter_mut().zip([along.x, along.y, along.z, twist]) {
            from.store(to);
        }
    }
}

/// What stops sliding `(x, y)` and twisting `z` at once, as far as Coulomb lets it: `limit` along the patch, `limit · radius` about its normal, and
/// of both together what is within the ellipse of the two. And which part of the limit that is.
///
/// Where the radius is less than `torsional_radius`, metres, a point holds something. It stops twisting, too, by `limit · torsional_radius` at the
/// most; but what turns on a point is held in its place as if it did not.
#[inline(always)]
fn solve_friction<L: Lanes>(
    k: &Symmetric<L>,
    slid: Vector<L>,
    limit: L,
    (radius, torsional_radius): (L, L),
) -> (Vector<L>, L) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let slides = none.lt(limit).and(none.lt(k.along.x)).and(none.lt(k.along.y));
    let is_point = radius.lt(torsional_radius);
    // What cannot be turned that way has no twist.
    let twists = torsional_radius
        .le(radius)
        .and(none.lt(radius))
        .and((L::splat(1e-6) * (k.along.x + k.along.y)).lt(k.along.z * radius * radius));
    let way = -slid.z / k.along.z;
    let most = limit * torsional_radius;
    let twist = is_point.and(slides).and(none.lt(k.along.z)).and(way.max(-most).min(most));
    let k = Symmetric {
        along: Vector::new(
            slides.select(k.along.x, one),
            slides.select(k.along.y, one),
            twists.and(slides).select(k.along.z, one),
        ),
        across: Vector::new(slides.and(k.across.x), twists.and(k.across.y), twists.and(k.across.z)),
    };
    let (f, pivot) = k.solve(Vector::new(-slid.x, -slid.y, -twists.and(slid.z)));
    let limit = slides.select(limit, one);
    let (along, about) =
        ((f.x * f.x + f.y * f.y).sqrt() / limit, twists.and(f.z / (limit * radius)));
    let much = (along * along + about * about).sqrt();
    let good = slides.and(none.lt(pivot));
    let scale = good.and(one.lt(much).select(one / much, one));
    let f = f * scale;
    (Vector::new(f.x, f.y, f.z + good.and(twist)), good.and(much.min(one)))
}

/// Notes that eight bodies are expected to be pushed so, at an arm from their centres.
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
    // Nothing that is not a number may get to others.
    let good = (shift.length_squared() + turn.length_squared()).lt(L::splat(1e30));
    let none = Vector::new(L::zero(), L::zero(), L::zero());
    let (shift, turn) = (shift.or_else(good, none), turn.or_else(good, none));
    L::put_rows(&mut bodies.predicted, &shifts, shift.with(L::zero()));
    L::put_rows(&mut bodies.predicted, &turns, turn.with(L::zero()));
}

/// Effective mass: how a body gives way to impulses along two directions at an arm, and to a moment about a third: the turn that each of them gives
/// it.
struct EffectiveMass<L> {
    t: Vector<L>,
    u: Vector<L>,
    n: Vector<L>,
}

impl<L: Lanes> EffectiveMass<L> {
    /// And how far the three move it along each other; its centre stays.
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

/// Where [`Bodies::predicted`] and [`Bodies::residual`] have the displacements and the turns of eight bodies.
#[inline(always)]
fn pair_of_rows(rows: &[u32; LANES]) -> [[u32; LANES]; 2] {
    let mut pair = [[0; LANES]; 2];
    for (lane, row) in rows.iter().enumerate() {
        (pair[0][lane], pair[1][lane]) = (2 * row, 2 * row + 1);
    }
    pair
}

/// How far what is predicted of eight bodies, or their residual, moves points of these, and how it turns them.
#[inline(always)]
fn moved_at<L: Lanes>(of: &[Vec4], rows: &[u32; LANES], arm: Vector<L>) -> (Vector<L>, Vector<L>) {
    let [shifts, turns] = pair_of_rows(rows);
    let turn = Vector::of(L::rows(of, &turns)).0;
    let shift = Vector::of(L::rows(of, &shifts)).0;
    (shift + turn.cross(arm), turn)
}

impl BodyContactSolver {
    /// Notes where body colliders did not go as contacts had them, because they share particles with others.
    pub(super) fn measure_residual(&mut self, particles: &Particles) {
        let Self { groups, origin_offsets, bodies, gathered, wide_contacts, instructions, .. } =
            self;
        let (rigid, sticking) = (&self.rigid, &mut self.sticking);
        // Who sticks to nothing is not asked for.
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
    /// Compares where a group is with where contacts believe it to be.
    fn measure_residual<L: Lanes>(
        group: &BodyGroup,
        source: ParticleSource<'_>,
        bodies: &mut Bodies,
        // The first row of the group among the bodies.
        first: usize,
        // Scratch.
        gathered: &mut Vec<Gathered>,
        // A bit for each that it is about: rigid states are where contacts believe them to be.
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
    /// Adds the residual to the accumulated slip of those that stick.
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
            // Nothing that is not a number is to be remembered.
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
