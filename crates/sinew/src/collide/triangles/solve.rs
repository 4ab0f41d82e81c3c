//! Contact solver of a substep, one contact after the other: corrects overlaps and crossings, and applies static friction.
//!
//! # The kernel
//!
//! A particle at `x₀` touches a triangle at the point with the weights `b₁ b₂ b₃` of its corners; an edge touches another at `s` and `t` along them. Either way
//! a contact is four points with shares `kᵢ` that add up to zero, `(1, -b₁, -b₂, -b₃)` or `(1-s, s, t-1, -t)`, a unit vector `n` from the second to the first,
//! and the contact distance `r`:
//!
//! ```text
//! C = n · Σ kᵢ xᵢ - r ≥ 0        ∇ᵢC = kᵢ n
//! ```
//!
//! With inverse masses `w` the least correction that satisfies it (physics.md C10) is, for `δ = -C > 0`,
//!
//! ```text
//! xᵢ += wᵢ kᵢ λ n        λ = δ / Σ wⱼ kⱼ²
//! ```
//!
//! The shares add up to zero, and so do the changes of momentum `kᵢ λ n`. They apply no torque where `n` is along the line between the two points, as where
//! they touch by their thickness.
//!
//! The contact distance is the sum of the two thicknesses there: the particle's radius, and the corners' radii interpolated by their weights. So a triangle is
//! as thick as its particles are, and the thickness is continuous where the triangle ends and its particles alone begin. Two features of one body may be as
//! near as they are in its rest shape.
//!
//! `n` is the direction between the nearest points at the end of the substep, unless the two passed through each other: then it is that of
//! [`crossing`](super::crossing), towards the side that they came from.
//!
//! # Friction
//!
//! Since the start of the substep the two points have slid by `t = D - (D·n) n`, with `D = Σ kᵢ (xᵢ - startᵢ)`. Where that is within the friction limit, `‖t‖ ≤
//! μ δ` (F8), it is undone with the same shares, and the contact sticks. Otherwise `restitution` applies dynamic friction to the velocity.

use glam::{DVec3, Vec3};

use super::super::distance::{of_lines, to_triangle};
use super::close_list::CloseList;
use super::crossing::{ContactShares, Four, gap};
use super::participants::TriangleParticipants;
use super::search::TriangleCandidate;
use crate::particles::Particles;

/// Positions of the members in this substep, in double precision: scratch of it.
#[derive(Clone, Debug, Default)]
pub(super) struct SubstepState {
    /// Position now, metres from the member's own origin.
    pub(super) at: Vec<DVec3>,
    /// Position at the start of the substep, likewise.
    pub(super) from: Vec<DVec3>,
    /// Origin of each member, metres.
    origin: Vec<DVec3>,
    /// Inverse mass, 1/kg.
    pub(super) weight: Vec<f64>,
    /// The sweep in which each member was last moved; zero if in none.
    pub(super) moved: Vec<u32>,
    pub(super) close: CloseList,
}

/// A contact that needs a correction.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleContact {
    pub(super) way: ContactShares,
    /// Contact distance less the actual distance, metres.
    pub(super) overlap: f64,
    /// Contact distance, metres.
    pub(super) reach: f64,
    /// Whether they passed through each other.
    pub(super) crossed: bool,
}

/// Points nearer than this share of the contact distance have no accurate direction.
const COINCIDENT: f64 = 1e-6;

impl SubstepState {
    /// Loads the positions of the members in a substep.
    pub(super) fn load(&mut self, participants: &TriangleParticipants, particles: &Particles) {
        let Self { at, from, origin, weight, moved, .. } = self;
        at.clear();
        from.clear();
        origin.clear();
        weight.clear();
        moved.clear();
        moved.resize(participants.rows.len(), 0);
        for &row in &participants.rows {
            let i = row as usize;
            let place = particles.position[i];
            at.push(place.truncate().as_dvec3());
            from.push(particles.start[i].truncate().as_dvec3());
            origin.push(particles.origin[i].as_dvec3());
            weight.push(f64::from(place.w));
        }
    }

    /// Writes the moved members back. Returns whether one was displaced further than its `reserve`, metres. Those count as moved in the sweep
    /// `sweep`, and all others as not moved.
    pub(super) fn store(
        &mut self,
        participants: &TriangleParticipants,
        particles: &mut Particles,
        reserve: &[f32],
        sweep: u32,
    ) -> bool {
        let mut any = false;
        let each = participants.rows.iter().zip(&self.at).zip(&mut self.moved).zip(reserve);
        for (((&row, at), moved), &reserve) in each {
            if *moved == 0 {
                continue;
            }
            let place = &mut particles.position[row as usize];
            let to = at.as_vec3();
            let far = (to - place.truncate()).length() > reserve;
            *place = to.extend(place.w);
            *moved = if far { sweep } else { 0 };
            any |= far;
        }
        any
    }

    /// Whether one of four members was moved in this sweep or a later one.
    pub(super) fn moved_since(&self, four: [u32; 4], sweep: u32) -> bool {
        let of = |k: usize| self.moved[four[k] as usize] >= sweep;
        of(0) | of(1) | of(2) | of(3)
    }

    /// The points of a candidate, in the coordinates of the first.
    #[inline]
    pub(super) fn four(&self, candidate: &TriangleCandidate) -> Four {
        let [i, j, k, l] = candidate.four;
        let zero = self.origin[i as usize];
        let at = |i: u32| self.at[i as usize] + (self.origin[i as usize] - zero);
        let from = |i: u32| self.from[i as usize] + (self.origin[i as usize] - zero);
        Four {
            from: [from(i), from(j), from(k), from(l)],
            to: [at(i), at(j), at(k), at(l)],
            edges: candidate.edges,
        }
    }

    /// The contact of a candidate, if it needs a correction.
    pub(super) fn contact(
        &self,
        participants: &TriangleParticipants,
        candidate: &TriangleCandidate,
    ) -> Option<TriangleContact> {
        let four = self.four(candidate);
        let radius = |k: usize| f64::from(participants.radius[candidate.four[k] as usize]);
        let reach_at = |shares: [f64; 4]| {
            let of = |k: usize| shares[k].abs() * radius(k);
            (of(0) + of(1) + of(2) + of(3)).min(f64::from(candidate.most))
        };
        let shares = nearest(&four);
        let apart = shares.map_or(DVec3::ZERO, |shares| gap(shares, four.to));
        let square = apart.length_squared();
        // If they are further apart than they can have moved relative to each other, they have not passed through each other.
        if square <= four.longest_way()
            && let Some(way) = four.crossing()
        {
            let reach = reach_at(way.shares);
            let overlap = reach - way.normal.dot(gap(way.shares, four.to));
            return (overlap > 0.0).then_some(TriangleContact {
                way,
                overlap,
                reach,
                crossed: true,
            });
        }
        let shares = shares?;
        let reach = reach_at(shares);
        // Also for NaN.
        if square.partial_cmp(&(reach * reach)) != Some(core::cmp::Ordering::Less) {
            return None;
        }
        let distance = square.sqrt();
        let coincident = distance <= COINCIDENT * reach;
        let normal = if coincident { four.side(shares)? } else { apart / distance };
        let overlap = reach - normal.dot(apart);
        Some(TriangleContact {
            way: ContactShares { shares, normal },
            overlap,
            reach,
            crossed: false,
        })
    }

    /// Moves four members along a direction, each by its share, so that the contact points separate by `apart`, metres. `inverse` is their [`Self::inverse`].
    pub(super) fn separate(
        &mut self,
        four: [u32; 4],
        shares: [f64; 4],
        apart: DVec3,
        inverse: f64,
        sweep: u32,
    ) {
        let each = apart / inverse;
        for (&i, share) in four.iter().zip(shares) {
            let i = i as usize;
            let by = self.weight[i] * share;
            if by != 0.0 {
                self.move_to(i, self.at[i] + each * by, sweep);
            }
        }
    }

    /// Moves a member to a position.
    pub(super) fn move_to(&mut self, i: usize, at: DVec3, sweep: u32) {
        self.close.record_displacement(i, at - self.at[i]);
        self.at[i] = at;
        self.moved[i] = sweep;
    }

    /// Inverse effective mass of the two points, 1/kg: `Σ w k²`.
    pub(super) fn inverse(&self, four: [u32; 4], shares: [f64; 4]) -> f64 {
        let of = |k: usize| self.weight[four[k] as usize] * shares[k] * shares[k];
        of(0) + of(1) + of(2) + of(3)
    }

    /// Relative displacement of the two points since the start of the substep, metres.
    pub(super) fn moved(&self, four: [u32; 4], shares: [f64; 4]) -> DVec3 {
        let way = |k: usize| self.at[four[k] as usize] - self.from[four[k] as usize];
        gap(shares, [way(0), way(1), way(2), way(3)])
    }

    /// Midpoint of the two points, world coordinates, metres.
    pub(super) fn point(&self, four: [u32; 4], way: &ContactShares) -> Vec3 {
        let at = four.map(|i| self.at[i as usize] + self.origin[i as usize]);
        // Without its sign, the share of a member is its weight in its own point.
        gap(way.shares.map(|share| 0.5 * share.abs()), at).as_vec3()
    }
}

/// The shares of the nearest points at the end of the substep. Edges count only where both points are within them: their ends are corners, which are tested
/// against triangles.
#[inline]
fn nearest(four: &Four) -> Option<[f64; 4]> {
    let [p, a, b, c] = four.to;
    if four.edges {
        let [s, t] = of_lines([p, a], [b, c], 0.0)?;
        return Some([1.0 - s, s, t - 1.0, -t]);
    }
    let [i, j, k] = to_triangle(p, [a, b, c]);
    Some([1.0, -i, -j, -k])
}
