//! The law of restitution, which all contacts apply after velocities are derived from positions. Written once, for one lane or eight.
//!
//! The position solve has no restitution: whatever is moved onto a surface leaves it with the speed of that correction. So contacts correct velocities at the
//! end of a substep of `h` seconds. With `u` the relative normal velocity before the contact acted (negative when approaching), `u'` the present one, `P` the sum
//! of the impulses of the contact in this substep, that of the positions included, and `e` the coefficient of restitution,
//!
//! ```text
//! P ≥ 0,    u' + e u ≥ 0,    P (u' + e u) = 0         where e > 0, with 0 in place of e where |u| < 2gh     (Moreau's law of impacts)
//! u' is clamped between 0 and max(u, 0)               where e = 0, between two moving sides
//! ```
//!
//! The first is one problem over all contacts that touch in a substep, of particles with each other, with triangles, with colliders and with body colliders, and
//! of body colliders with each other and with static geometry. A contact solves it for itself, if all others stay as they are, and the [rounds](ImpactRounds)
//! for all, starting from the impulses of the positions. With `e = 1` everywhere it keeps the energy, however many touch.
//!
//! The [`threshold`] `2gh` is twice the speed that gravity adds in a substep: below it a contact is taken for a resting one, which would otherwise bounce for
//! ever. `g` is the gravity on the two ([`RowGravity`](crate::forces::RowGravity)), the greater one if they differ. Without restitution two moving sides neither
//! approach any more nor separate faster than before, because the correction of an overlap must not add velocity. Contacts between particles and of triangles
//! have one impulse of restitution and friction: [`contact_impulse`].
//!
//! Particles on colliders, particle pairs, triangles and body colliders all use these functions. What is particular to one of them (several points of a
//! manifold, effective masses) is in its own file.
//!
//! # The rounds
//!
//! Impacts spread. A contact is solved in the first round if it is fast enough to bounce, and in any round if an impact has changed the velocity of one of its
//! two ends since it was last solved. So it is solved as often as its neighbours demand, and nothing that happens elsewhere changes a bit of it. What nothing
//! can move passes nothing on.

use super::friction::friction_share;
use crate::forces::RowGravity;
use crate::lanes::{Number, Vector};

/// Change of a normal speed that counts as none, m/s: below the resolution of positions of a metre in a substep.
const QUIET: f32 = 1e-6;
/// The same as a share of the [`threshold`], below which a contact would not bounce at all: of what bounces with all of its speed, and of what does not bounce. In
/// between it is in proportion. What loses energy anyway need not be solved further, and a heap in which something bounces in each substep would be, as a whole.
const QUIET_SHARE: [f32; 2] = [0.01, 0.25];
/// Limit of Gauss–Seidel rounds. A row of five balls takes some thirty; what is left at the limit is inelastic.
pub(super) const ROUNDS: u32 = 64;

/// The approach speed up to which contacts are inelastic, m/s: `2gh`, for gravity in m/s² and a substep of `h` seconds.
#[inline(always)]
pub(super) fn threshold<N: Number>(gravity: N, h: f32) -> N {
    N::splat(2.0) * gravity * N::splat(h)
}

/// Mask of the contacts that are elastic at an approach `speed`, m/s.
#[inline(always)]
pub(super) fn is_elastic<N: Number>(coefficient: N, speed: N, threshold: N) -> N {
    N::zero().lt(coefficient).and(threshold.lt(speed))
}

/// The change of a normal speed up to which a contact is solved, m/s, from its coefficient of restitution, its threshold and the fastest speed before it.
#[inline(always)]
pub(super) fn quiet<N: Number>(coefficient: N, threshold: N, before: N) -> N {
    let [elastic, inelastic] = QUIET_SHARE.map(N::splat);
    let share = inelastic + coefficient * (elastic - inelastic);
    let least = N::splat(QUIET);
    least.max(threshold * share).max(before.abs() * least)
}

/// The relative normal velocity after an elastic contact, m/s, from the one `before` it (negative when approaching).
#[inline(always)]
pub(super) fn rebound<N: Number>(coefficient: N, before: N) -> N {
    N::zero() - coefficient * before
}

/// What a contact adds to its relative normal velocity `now`, m/s, by Moreau's law, if all others stay as they are; of what it has `pressed` so far, m/s, it may
/// take back as much.
#[inline(always)]
pub(super) fn elastic_gain<N: Number>(
    now: N,
    (coefficient, before, threshold): (N, N, N),
    pressed: N,
) -> N {
    let elastic = is_elastic(coefficient, before.abs(), threshold);
    let wanted = elastic.and(rebound(coefficient, before));
    (wanted - now).max(N::zero() - pressed)
}

/// The impulse of a contact between two moving sides on the first one, N·s, and what it adds to their relative velocity along the normal `n`, m/s: restitution
/// from the relative normal velocity `before` it, and friction. `velocity` is the present relative velocity, `inverse_mass` the inverse effective mass, 1/kg, and
/// `pressed` what the contact has added along the normal so far, m/s, with the position solve. Friction takes at most `limit`, m/s, off the slip, and the
/// coefficient `friction` times the speed that is added along the normal: the position solve of an impact removes only the part of the approach by which the two
/// overlapped when the substep ended.
#[inline(always)]
pub(super) fn contact_impulse<N: Number>(
    n: Vector<N>,
    velocity: Vector<N>,
    (coefficient, before, threshold): (N, N, N),
    (friction, limit): (N, N),
    (inverse_mass, pressed): (N, N),
) -> (Vector<N>, N) {
    let (zero, now) = (N::zero(), n.dot(velocity));
    let elastic = elastic_gain(now, (coefficient, before, threshold), pressed);
    let inelastic = now.min(before.max(zero)).max(zero) - now;
    let gained = zero.lt(coefficient).select(elastic, inelastic);
    let slip = velocity - n * now;
    let limit = limit + friction * gained.max(zero);
    let share = friction_share(slip.length(), limit);
    (n * (gained / inverse_mass) - slip * (share / inverse_mass), gained)
}

/// Mask of the contacts whose change `gained`, m/s, is passed on to their neighbours in the [rounds](ImpactRounds). Of those that no impact has reached, which
/// are solved `unreached` in the first round, it is only what was fast enough to bounce: the rest has been solved with its neighbours in positions.
#[inline(always)]
pub(super) fn spreads<N: Number>(
    (coefficient, before, threshold): (N, N, N),
    gained: N,
    unreached: bool,
) -> N {
    let changed = quiet(coefficient, threshold, before).lt(gained.abs());
    if unreached { is_elastic(coefficient, before.abs(), threshold).and(changed) } else { changed }
}

/// Rounds of Gauss–Seidel over the contacts that touched in a substep. Each contact has a turn in each of them, always in the same order, and is solved then if
/// an impact has changed one of its two ends since its last turn.
#[derive(Clone, Debug, Default)]
pub(super) struct ImpactRounds {
    /// For each end the number of the turn in which an impact last changed its velocity: rows of particles, then rows of body colliders.
    changed_at: Vec<u64>,
    /// The greatest of these.
    last_change: u64,
    /// Number of the present turn. Turns are counted on from substep to substep by even numbers: odd ones stand for right after a turn.
    turn: u64,
    any_changed: bool,
}

/// One of the [rounds](ImpactRounds) after a substep.
pub(super) struct ImpactRound<'a> {
    /// Length of the substep, seconds.
    pub(super) h: f32,
    pub(super) gravity: &'a RowGravity,
    rounds: &'a mut ImpactRounds,
    /// Number of rows of particles.
    particles: u32,
    /// Turn before the first one of the first round.
    began: u64,
    /// By how much turns are counted on in a round; `None` in the first.
    length: Option<u64>,
}

impl ImpactRounds {
    /// Calls `pass` for each round after a substep of `h` seconds with this many rows of particles and of body colliders.
    pub(super) fn run(
        &mut self,
        (particles, bodies): (usize, usize),
        (h, gravity): (f32, &RowGravity),
        mut pass: impl FnMut(&mut ImpactRound),
    ) {
        self.changed_at.resize(particles + bodies, 0);
        // What the substep before has changed is too long ago.
        self.turn += 2;
        let (began, particles, mut length) = (self.turn, particles as u32, None);
        for _ in 0..ROUNDS {
            self.any_changed = false;
            pass(&mut ImpactRound { h, gravity, rounds: self, particles, began, length });
            if !self.any_changed {
                break;
            }
            length = length.or(Some(self.turn - began));
        }
    }
}

impl ImpactRound<'_> {
    /// Whether this is the first round.
    pub(super) fn is_first(&self) -> bool {
        self.length.is_none()
    }

    /// The end that is a row of `bodies`; a row of particles is the end of that number.
    pub(super) fn body(&self, row: u32) -> u32 {
        self.particles + row
    }

    /// Begins the turn of the next contact, or of several without a common end. Each round has the same turns in the same order.
    pub(super) fn next(&mut self) {
        self.rounds.turn += 2;
    }

    /// Whether an impact has changed one of these ends since the last turn of this contact; in the first round, in this one.
    pub(super) fn reaches(&self, ends: impl IntoIterator<Item = u32>) -> bool {
        let ImpactRounds { changed_at, last_change, turn, .. } = &*self.rounds;
        let last = self.length.map_or(self.began, |length| turn - length);
        *last_change > last && ends.into_iter().any(|end| changed_at[end as usize] > last)
    }

    /// Records that the impact of this turn has changed the velocity of an end, and that its own contact is solved thereby.
    pub(super) fn mark(&mut self, end: u32) {
        self.mark_at(end, self.rounds.turn);
    }

    /// The same, if its own contact is not solved exactly, and has to be once more.
    pub(super) fn mark_inexact(&mut self, end: u32) {
        self.mark_at(end, self.rounds.turn + 1);
    }

    fn mark_at(&mut self, end: u32, turn: u64) {
        let rounds = &mut *self.rounds;
        rounds.changed_at[end as usize] = turn;
        (rounds.last_change, rounds.any_changed) = (turn, true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a contact along x adds to the relative velocity.
    fn gained(coefficient: f32, before: f32, now: f32, pressed: f32) -> f32 {
        let (n, v) = (Vector::new(1.0_f32, 0.0, 0.0), Vector::new(now, 0.0, 0.0));
        let restitution = (coefficient, before, threshold(8.0, 1.0 / 64.0));
        contact_impulse(n, v, restitution, (0.0, 0.0), (1.0, pressed)).1
    }

    #[test]
    fn only_what_is_next_to_a_change_is_solved_again() {
        let mut rounds = ImpactRounds::default();
        for _substep in 0..2 {
            // A chain of contacts `[i, i + 1]`: the first changes in the first round, and each one in the round after its neighbour.
            let mut solved = [0; 7];
            let mut numbers = 0;
            rounds.run((6, 2), (0.01, &RowGravity::default()), |round| {
                assert_eq!(round.body(1), 7, "the last end is the second body");
                for i in (0..7).rev() {
                    round.next();
                    if round.is_first() || round.reaches([i, i + 1]) {
                        solved[i as usize] += 1;
                        if i == numbers && numbers < 3 {
                            round.mark(i + 1);
                        }
                    }
                }
                numbers += 1;
            });
            assert_eq!((numbers, solved), (4, [1, 2, 2, 2, 1, 1, 1]), "and not for its own change");
        }
    }

    #[test]
    fn in_the_first_round_an_impact_reaches_what_comes_after_it() {
        let mut rounds = ImpactRounds::default();
        for _substep in 0..2 {
            let mut reached = Vec::new();
            rounds.run((4, 0), (0.01, &RowGravity::default()), |round| {
                for i in 0..3 {
                    round.next();
                    if round.reaches([i, i + 1]) {
                        reached.push((round.is_first(), i));
                    }
                    if round.is_first() && i == 1 {
                        round.mark(2);
                    }
                }
            });
            assert_eq!(reached, [(true, 2)]);
        }
    }

    #[test]
    fn what_is_not_solved_exactly_is_solved_once_more() {
        let mut rounds = ImpactRounds::default();
        for _substep in 0..2 {
            let mut reached = Vec::new();
            let mut number = 0;
            rounds.run((2, 0), (0.01, &RowGravity::default()), |round| {
                for contact in 0..2 {
                    round.next();
                    if round.reaches([0, 1]) {
                        reached.push((number, contact));
                    }
                    if round.is_first() && contact == 1 {
                        round.mark_inexact(0);
                    }
                }
                number += 1;
            });
            assert_eq!(reached, [(1, 0), (1, 1)]);
        }
    }

    #[test]
    fn fast_contacts_bounce_and_others_are_clamped() {
        assert_eq!(threshold(8.0_f32, 1.0 / 64.0), 0.25);
        assert_eq!(
            gained(0.5, -2.0, 7.0, 9.0),
            1.0 - 7.0,
            "elastic, whatever the position solve gave"
        );
        assert_eq!(
            gained(0.5, -2.0, 7.0, 2.0),
            -2.0,
            "it takes back what it has pressed, and does not pull"
        );
        assert_eq!(gained(0.5, -0.1, 7.0, 7.1), -7.0, "below the threshold");
        assert_eq!(gained(0.0, -2.0, 7.0, 9.0), -7.0, "no restitution");
        assert_eq!(gained(0.0, 0.3, 7.0, 6.7), 0.3 - 7.0, "not faster than before");
        assert_eq!(gained(0.0, 0.3, 0.1, 0.0), 0.0, "never accelerated");
        assert_eq!(
            gained(0.5, 0.3, -0.4, 0.0),
            0.25,
            "parting sides that are pushed together bounce later"
        );
        assert_eq!(gained(0.0, 0.3, -0.4, 0.0), 0.4, "stops approaching");
    }
}
