//! Applies the change of a pose to the particles: each is displaced by what its body collider was shifted and turned, so that rods inside stay as
//! they are and what is soft keeps its own deformation.
//!
//! # Momentum
//!
//! The turn is a rotation `ΔR`, and `(ΔR - 1) r` with the arms `r = q - q̄` as the particles really are keeps momentum, because `Σ m r = 0`. Angular
//! momentum, as Verlet keeps it, changes by `Σ m (p - p̄) × d`, and is to change by `T = I φ`, the moment of the impulses. What is missing comes of
//! the rotation from `p` to `q`, of second order in the turn, and of particles that are not quite where the body collider has them; a further
//! infinitesimal turn `ψ` makes up for it:
//!
//! ```text
//! J ψ = T - Σ m (p - p̄) × (ΔR - 1)(q - q̄)        J = Σ m ((p - p̄)·(q - q̄) 1 - (q - q̄)(p - p̄)ᵀ)
//! ```
//!
//! All of it follows from `Σ m (q - q̄)(p - p̄)ᵀ`, which was summed up when the body collider was read. So `d = shift + D (q - q̄)` with one matrix
//! `D` a body collider. Velocities change in the same way, with `ψ × r` alone.

use glam::Vec4;

use super::bodies::{Bodies, from_row};
use super::extract_pose::PoseSums;
use super::groups::{BodyGroup, Slot};
use super::turn::{LaneArray, Matrix, Symmetric, load};
use crate::lanes::{FIELDS, LANES, Lanes, Vector, Work};

/// Changes of rows that several body colliders share, or that are alone in their eight: to be added when all are known. Slot by slot, and in each
/// body collider by body collider: what is summed up of those that share a row must not depend on who else is in their eights.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedDeltas(Vec<Vec<(u32, Vec4)>>);

impl SharedDeltas {
    /// Forgets all, and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.0.iter_mut().for_each(Vec::clear);
    }

    /// In their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, Vec4)> {
        self.0.iter().flatten().copied()
    }

    /// The list of a slot.
    fn of(&mut self, slot: usize) -> &mut Vec<(u32, Vec4)> {
        if self.0.len() <= slot {
            self.0.resize_with(slot + 1, Vec::new);
        }
        &mut self.0[slot]
    }
}

/// Changes the particles of a group.
pub(super) struct ApplyPoseDelta<'a> {
    pub(super) group: &'a BodyGroup,
    pub(super) slots: &'a [Slot],
    pub(super) origin_offsets: Option<&'a [[LaneArray; 3]]>,
    pub(super) position: &'a mut [Vec4],
    /// What is changed instead of the positions.
    pub(super) velocity: Option<&'a mut [Vec4]>,
    pub(super) bodies: &'a Bodies,
    pub(super) first: usize,
    pub(super) sums: &'a PoseSums,
    pub(super) shared: &'a mut SharedDeltas,
}

impl Work for ApplyPoseDelta<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { group, slots, origin_offsets, position, mut velocity, .. } = self;
        let Self { bodies, first, sums, shared, .. } = self;
        let [shift, turn, .., rotation] = L::records::<FIELDS>(&bodies.rows, &from_row(first));
        let (shift, turn) = (Vector::of(shift).0, Vector::of(turn).0);
        let much = shift.length_squared() + turn.length_squared();
        if !L::zero().lt(much).any() {
            return;
        }
        let r = Matrix::of(rotation);
        let field = field::<L>(group, turn, &r, sums, velocity.is_none());
        let centre = load(&sums.centre);
        for (number, slot) in slots.iter().enumerate() {
            let (q, w) = Vector::of(L::rows(position, &slot.rows));
            let arm = match origin_offsets {
                Some(origin_offsets) => q + load(&origin_offsets[number]) - centre,
                None => q - centre,
            };
            // Of a pinned one nothing.
            let share = L::zero().lt(w).and(L::load(&slot.share));
            let moved = (shift + field.times(arm)) * share;
            if group.scattered {
                let mut by = [Vec4::ZERO; LANES];
                L::put_run(&mut by, 0, moved.with(L::zero()));
                let shared = shared.of(number);
                for (row, by) in slot.rows.iter().zip(by) {
                    if by != Vec4::ZERO {
                        shared.push((*row, by));
                    }
                }
            } else if let Some(velocity) = &mut velocity {
                let (v, lag) = Vector::of(L::rows(velocity, &slot.rows));
                L::put_rows(velocity, &slot.rows, (v + moved).with(lag));
            } else {
                L::put_rows(position, &slot.rows, (q + moved).with(w));
            }
        }
    }
}

/// `D`, which takes arms to displacements, of body colliders with the rotations `r`.
#[inline(always)]
fn field<L: Lanes>(
    group: &BodyGroup,
    turn: Vector<L>,
    r: &Matrix<L>,
    sums: &PoseSums,
    rotates: bool,
) -> Matrix<L> {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mass = &group.mass;
    let mut field = Matrix::zero();
    if rotates {
        // ΔR - 1 = 2 ([v] + [v]²) / (1 + v²) of the quaternion (v, 1), and [v]² = v vᵀ - v² 1.
        let half = turn * L::splat(0.5);
        let square = half.length_squared();
        let factor = L::splat(2.0) / (one + square);
        field.add_outer(half, half);
        field.x.x = field.x.x - square;
        field.y.y = field.y.y - square;
        field.z.z = field.z.z - square;
        add_cross(&mut field, half);
        field = Matrix { x: field.x * factor, y: field.y * factor, z: field.z * factor };
    }
    let [x, y, z] = &sums.pairs;
    let pairs = Matrix { x: load(x), y: load(y), z: load(z) };
    let wanted = Symmetric::load(&mass.inertia).turned(r).times(turn);
    let missing = wanted - field.times_matrix(&pairs).twice_axial();
    let regularisation = Symmetric::load(&mass.regularisation).turned(r);
    let trace = pairs.x.x + pairs.y.y + pairs.z.z;
    let j = Matrix {
        x: Vector::new(trace, none, none) - pairs.x
            + Vector::new(regularisation.along.x, regularisation.across.x, regularisation.across.y),
        y: Vector::new(none, trace, none) - pairs.y
            + Vector::new(regularisation.across.x, regularisation.along.y, regularisation.across.z),
        z: Vector::new(none, none, trace) - pairs.z
            + Vector::new(regularisation.across.y, regularisation.across.z, regularisation.along.z),
    };
    let further = j.solve(missing);
    // A part of the turn, or all of it; what is more is none.
    let most = turn.length_squared() * L::splat(4.0);
    let free = L::zero().lt(L::load(&mass.free));
    let sound = free.and(further.length_squared().le(most));
    let otherwise = if rotates { Vector::new(none, none, none) } else { turn };
    add_cross(&mut field, further.or_else(sound, otherwise));
    field
}

/// Adds `[v]`.
#[inline(always)]
fn add_cross<L: Lanes>(to: &mut Matrix<L>, v: Vector<L>) {
    let none = L::zero();
    to.x += Vector::new(none, v.z, none - v.y);
    to.y += Vector::new(none - v.z, none, v.x);
    to.z += Vector::new(v.y, none - v.x, none);
}
