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
//! The first is one problem over all contacts that touch: a contact solves it for itself, and the [rounds](ImpactRounds) for all, starting from the impulses of
//! the positions. With `e = 1` everywhere it keeps the energy, however many touch. There are two such problems: that of body colliders, and that of particles,
//! with each other, with triangles and with colliders. What of the second touches a body collider in the same substep loses energy.
//!
//! The [`threshold`] `2gh` is twice the speed that gravity adds in a substep: below it a contact is taken for a resting one, which would otherwise bounce for
//! ever. `g` is the gravity on the two ([`RowGravity`](crate::forces::RowGravity)), the greater one if they differ. Without restitution two moving sides neither
//! approach any more nor separate faster than before, because the correction of an overlap must not add velocity. Contacts between particles and of triangles
//! have one impulse of restitution and friction: [`contact_impulse`].
//!
//! Particles on colliders, particle pairs, triangles and body colliders all use these functions. What is particular to one of them (several points of a
//! manifold, effective masses) is in its own file.

use super::friction::friction_share;
use crate::forces::RowGravity;
use crate::lanes::{Number, Vector};

/// Change of a normal speed that counts as none, m/s: below the resolution of positions of a metre in a substep.
pub(super) const QUIET: f32 = 1e-6;
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

/// The relative normal velocity after an elastic contact, m/s, from the one `before` it (negative when approaching).
#[inline(always)]
pub(super) fn rebound<N: Number>(coefficient: N, before: N) -> N {
    N::zero() - coefficient * before
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
    let elastic = is_elastic(coefficient, before.abs(), threshold);
    let wanted = elastic.and(rebound(coefficient, before));
    let elastic = (wanted - now).max(zero - pressed);
    let inelastic = now.min(before.max(zero)).max(zero) - now;
    let gained = zero.lt(coefficient).select(elastic, inelastic);
    let slip = velocity - n * now;
    let limit = limit + friction * gained.max(zero);
    let share = friction_share(slip.length(), limit);
    (n * (gained / inverse_mass) - slip * (share / inverse_mass), gained)
}

/// Mask of the contacts whose change `gained`, m/s, reaches their neighbours in the next [round](ImpactRounds): in the `first` one only what was fast enough to
/// bounce, since the rest has been solved with its neighbours in positions.
#[inline(always)]
pub(super) fn spreads<N: Number>(
    (coefficient, before, threshold): (N, N, N),
    gained: N,
    first: bool,
) -> N {
    let changed = N::splat(QUIET).lt(gained.abs());
    if first { is_elastic(coefficient, before.abs(), threshold).and(changed) } else { changed }
}

/// Rounds of Gauss–Seidel over the contacts of particles that touched in a substep. The first solves all; each further one those with a particle whose velocity
/// an impact has changed since the round before. So a contact is solved as often as its neighbours demand, whatever happens elsewhere.
#[derive(Clone, Debug, Default)]
pub(super) struct ImpactRounds {
    /// For each row the last round in which an impact changed its velocity. Rounds are counted on from substep to substep.
    changed_in: Vec<u32>,
    round: u32,
    any_changed: bool,
}

/// One of the [rounds](ImpactRounds) after a substep.
pub(super) struct ImpactRound<'a> {
    /// Length of the substep, seconds.
    pub(super) h: f32,
    pub(super) gravity: &'a RowGravity,
    rounds: &'a mut ImpactRounds,
    is_first: bool,
}

impl ImpactRounds {
    /// Calls `pass` for each round after a substep of `h` seconds with this many rows.
    pub(super) fn run(
        &mut self,
        rows: usize,
        (h, gravity): (f32, &RowGravity),
        mut pass: impl FnMut(&mut ImpactRound),
    ) {
        if self.round > u32::MAX - 2 * ROUNDS {
            *self = Self::default();
        }
        self.changed_in.resize(rows, 0);
        // Rows that were changed in the last round of the substep before are too long ago.
        self.round += 2;
        for number in 0..ROUNDS {
            self.any_changed = false;
            pass(&mut ImpactRound { h, gravity, rounds: self, is_first: number == 0 });
            self.round += 1;
            if !self.any_changed {
                break;
            }
        }
    }
}

impl ImpactRound<'_> {
    /// Whether this is the first round.
    pub(super) fn is_first(&self) -> bool {
        self.is_first
    }

    /// Whether a contact of these rows is solved in this round.
    pub(super) fn reaches(&self, rows: impl IntoIterator<Item = u32>) -> bool {
        let ImpactRounds { changed_in, round, .. } = &*self.rounds;
        self.is_first || rows.into_iter().any(|row| changed_in[row as usize] + 1 >= *round)
    }

    /// Records that an impact has changed the velocity of a row.
    pub(super) fn mark(&mut self, row: u32) {
        self.rounds.changed_in[row as usize] = self.rounds.round;
        self.rounds.any_changed = true;
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
            rounds.run(8, (0.01, &RowGravity::default()), |round| {
                for i in (0..7).rev() {
                    if round.reaches([i, i + 1]) {
                        solved[i as usize] += 1;
                        if i == numbers && numbers < 3 {
                            round.mark(i + 1);
                        }
                    }
                }
                numbers += 1;
            });
            assert_eq!((numbers, solved), (4, [2, 3, 3, 2, 1, 1, 1]));
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
