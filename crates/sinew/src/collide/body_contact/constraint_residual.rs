//! Constraint residual: what joints take back of what contacts did. Friction that holds a bone must know how far that really went.
//!
//! A particle that `k` body colliders share is displaced by the `k`-th part of what each of them asks (`groups`). A pelvis, which others hang on by
//! all of its particles, goes back by half of what it slid, where contacts believe that it went back by all of it. What they do not know of they do
//! not hold: a ragdoll on the ground crept over it by up to a centimetre a second, for ever.
//!
//! So when the particles were displaced, such body colliders are read once more: how far their centres have gone since the substep began, and how
//! they have turned, as in `pose`. By what that differs from what contacts believe, they are farther from where they stuck (`friction`). What
//! slides does not ask.

use super::BodyContactSolver;
use super::bodies::{Bodies, from_row};
use super::groups::BodyGroup;
use super::pose::{Gathered, ParticleSource};
use super::tangential_slip::{moved_at, pair_of_rows};
use super::turn::{Matrix, Symmetric, load, zero};
use super::wide_contact::WideContact;
use crate::lanes::{FIELDS, LANES, Lanes, Vector, Work, with};
use crate::particles::Particles;

impl BodyContactSolver {
    /// Notes where body colliders did not go as contacts had them, because they share particles with others.
    pub(super) fn measure_residual(&mut self, particles: &Particles) {
        let Self { groups, origin_offsets, bodies, gathered, wide_contacts, instructions, .. } =
            self;
        let mut any = false;
        for (number, group) in groups.groups.iter().enumerate().filter(|(_, group)| group.shares) {
            let source = ParticleSource {
                slots: &groups.slots[group.slots.clone()],
                origin_offsets: origin_offsets.of(group),
                position: &particles.position,
                other: &particles.start,
                fresh: false,
            };
            let first = number * LANES;
            with(*instructions, MeasureResidual { group, source, bodies, first, gathered });
            any = true;
        }
        if any {
            with(*instructions, ApplyResidual { wide_contacts, bodies });
        }
    }
}

/// Compares where a group is with where contacts believe it to be.
struct MeasureResidual<'a> {
    group: &'a BodyGroup,
    source: ParticleSource<'a>,
    bodies: &'a mut Bodies,
    /// The first row of the group among the bodies.
    first: usize,
    /// Scratch.
    gathered: &'a mut Vec<Gathered>,
}

impl Work for MeasureResidual<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { group, source, bodies, first, gathered } = self;
        let rows = from_row(first);
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
        let [shifts, turns] = pair_of_rows(&rows);
        L::put_rows(&mut bodies.residual, &shifts, off.with(L::zero()));
        L::put_rows(&mut bodies.residual, &turns, turned.with(L::zero()));
    }
}

/// Adds the residual to the accumulated slip of those that stick.
struct ApplyResidual<'a> {
    wide_contacts: &'a mut [WideContact],
    bodies: &'a Bodies,
}

impl Work for ApplyResidual<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { wide_contacts, bodies } = self;
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
}

/// Centres of eight bodies when the substep began, metres from their origins.
#[inline(always)]
fn centre<L: Lanes>(bodies: &Bodies, rows: &[u32; LANES]) -> Vector<L> {
    let [_, _, _, _, centre] = L::records(&bodies.rows, rows);
    Vector::of(centre).0
}
