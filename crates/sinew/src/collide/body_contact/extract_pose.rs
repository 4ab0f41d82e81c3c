//! Extracts the poses of body colliders from their particles, eight body colliders at a time: once afresh when contacts are looked for, and once a
//! substep from there on.
//!
//! # What is read
//!
//! With `q` the predicted positions, `p` those at the substep's start and `m` the masses: the centres of both; the rotation nearest to
//! `Σ m (q - q̄) rᵀ` by one or two of Newton's steps from the last substep's (derived in `pose/rotation.rs`, here in `f32`); and how it has turned
//! since the start, which needs no second rotation:
//!
//! ```text
//! φ = I⁻¹ Σ m r × (δ - δ̄)        r = q - q̄,  δ = q - p
//! ```
//!
//! is the turn whose displacements `φ × r` are nearest to those of the particles. `Σ m (q - q̄)(p - p̄)ᵀ` is kept for the way back
//! (`apply_pose_delta`).

use glam::{Vec3, Vec4};

use super::bodies::{Bodies, from_row};
use super::groups::{BodyGroup, BodyGroups, CompiledCollider, Slot, WideMass};
use super::swept_bounds::WideSweptBounds;
use super::turn::{LaneArray, Matrix, Symmetric, load, store, turn_further, zero};
use crate::lanes::{FIELDS, Lanes, Vector, Work};
use crate::particles::Particles;

/// A Newton step of this angle, squared, leaves an error of its cube, which is below the round-off.
const DONE: f32 = 1e-5;
/// The most steps, within a step and from nowhere.
const STEPS: u32 = 3;
const FRESH: u32 = 8;

/// What a group keeps from reading for writing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PoseSums {
    /// Centres as predicted, metres from the origin.
    pub(super) centre: [LaneArray; 3],
    /// `Σ m (q - q̄)(p - p̄)ᵀ` by columns, kg·m².
    pub(super) pairs: [[LaneArray; 3]; 3],
}

/// Where the particles are relative to the origin of their body collider's first one.
#[derive(Clone, Debug, Default)]
pub(super) struct OriginOffsets {
    /// One for each slot; empty where all particles of each body collider have one origin, as those of an island do.
    origin_offsets: Vec<[LaneArray; 3]>,
}

/// Reads a group.
pub(super) struct ExtractPose<'a> {
    pub(super) group: &'a BodyGroup,
    pub(super) slots: &'a [Slot],
    pub(super) origin_offsets: Option<&'a [[LaneArray; 3]]>,
    pub(super) position: &'a [Vec4],
    /// Positions at the start; or, afresh, velocities.
    pub(super) other: &'a [Vec4],
    pub(super) fresh: bool,
    pub(super) bodies: &'a mut Bodies,
    /// The first row of the group among the bodies.
    pub(super) first: usize,
    pub(super) sums: &'a mut PoseSums,
    /// Their swept bounds, and the time since the step began, seconds; `None` afresh.
    pub(super) wide_swept: Option<(&'a WideSweptBounds, f32)>,
    /// Scratch.
    pub(super) gathered: &'a mut Vec<Gathered>,
}

/// One particle of each of eight body colliders, gathered once for two passes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gathered {
    pub(super) position: [LaneArray; 3],
    /// Displacement or velocity.
    pub(super) moved: [LaneArray; 3],
    inverse_mass: LaneArray,
}

impl Work for ExtractPose<'_> {
    /// A bit for each lane: afresh, where the rotation could not be found; otherwise, where a body collider has left its swept bounds.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let Self {
            group,
            slots,
            origin_offsets,
            position,
            other,
            fresh,
            bodies,
            first,
            sums,
            wide_swept,
            gathered,
        } = self;
        let mass = &group.mass;
        if slots.is_empty() {
            return 0;
        }
        let source = ParticleSource { slots, origin_offsets, position, other, fresh };
        let (centre, step) = source.centre::<L>(mass, gathered);
        let (mut pairs, mut moments, mut momentum) =
            (Matrix::<L>::zero(), Matrix::<L>::zero(), zero::<L>());
        for (slot, kept) in slots.iter().zip(gathered) {
            let (q, moved) = (load(&kept.position), load(&kept.moved));
            let (w, pull) = (L::load(&kept.inverse_mass), L::load(&slot.pull));
            let own = L::zero().lt(w).and(pull);
            let (arm, moved) = (q - centre, moved - step);
            moments.add_outer(arm * pull, load(&slot.rest));
            momentum += arm.cross(moved) * pull;
            let start = if fresh { arm } else { arm - moved };
            pairs.add_outer(arm * own, start);
        }
        let rows = from_row(first);
        let [.., rotation] = L::records::<FIELDS>(&bodies.rows, &rows);
        let (q, residual) = nearest(mass, &moments, rotation, fresh);
        let r = Matrix::of(q);
        let inverse = Symmetric::load(&mass.inverse_inertia).turned(&r);
        let led = if group.pinned { Symmetric::load(&mass.led).turned(&r) } else { inverse };
        let spin = led.times(momentum);
        let none = L::zero();
        let start = if fresh { centre } else { centre - step };
        let fields = [
            zero::<L>().with(L::load(&mass.inverse_mass)),
            zero::<L>().with(none),
            inverse.along.with(none),
            inverse.across.with(none),
            start.with(none),
            step.with(none),
            spin.with(none),
            q,
        ];
        L::put_records(&mut bodies.rows, &rows, fields);
        store(centre, &mut sums.centre);
        for (column, to) in [pairs.x, pairs.y, pairs.z].into_iter().zip(&mut sums.pairs) {
            store(column, to);
        }
        wide_swept.map_or(residual, |(wide_swept, time)| wide_swept.left::<L>(centre, q, time))
    }
}

/// Where particles are, and where they come from.
pub(super) struct ParticleSource<'a> {
    pub(super) slots: &'a [Slot],
    pub(super) origin_offsets: Option<&'a [[LaneArray; 3]]>,
    pub(super) position: &'a [Vec4],
    pub(super) other: &'a [Vec4],
    pub(super) fresh: bool,
}

impl ParticleSource<'_> {
    /// Centres, and how far those have gone or how fast they go; and what was gathered.
    #[inline(always)]
    pub(super) fn centre<L: Lanes>(
        &self,
        mass: &WideMass,
        gathered: &mut Vec<Gathered>,
    ) -> (Vector<L>, Vector<L>) {
        let held = L::zero().lt(L::load(&mass.held));
        gathered.resize(self.slots.len(), Gathered::default());
        let (mut near, mut sum, mut step) = (zero::<L>(), zero::<L>(), zero::<L>());
        for (number, (slot, kept)) in self.slots.iter().zip(gathered).enumerate() {
            let (q, moved, w) = self.gather::<L>(number);
            if number == 0 {
                near = q;
            }
            store(q, &mut kept.position);
            store(moved, &mut kept.moved);
            w.store(&mut kept.inverse_mass);
            let (pull, free) = (L::load(&slot.pull), L::zero().lt(w));
            let decides = held.select(free.select(L::zero(), pull), pull);
            sum += (q - near) * decides;
            step += moved * decides;
        }
        let middle = L::load(&mass.middle);
        (near + sum * middle, step * middle)
    }

    /// Position, displacement or velocity, and inverse mass of one particle of each body collider.
    #[inline(always)]
    fn gather<L: Lanes>(&self, number: usize) -> (Vector<L>, Vector<L>, L) {
        let slot = &self.slots[number];
        let (mut q, w) = Vector::of(L::rows(self.position, &slot.rows));
        let (other, _) = Vector::of(L::rows(self.other, &slot.rows));
        let moved = if self.fresh { other } else { q - other };
        if let Some(origin_offsets) = self.origin_offsets {
            q += load(&origin_offsets[number]);
        }
        (q, moved, w)
    }
}

/// The rotation nearest to the moments, from one that is near.
#[inline(always)]
fn nearest<L: Lanes>(
    mass: &WideMass,
    moments: &Matrix<L>,
    from: [L; 4],
    fresh: bool,
) -> ([L; 4], u32) {
    let regularisation = Symmetric::<L>::load(&mass.regularisation);
    // Who is done waits for the others as it is: who is beside it must not matter.
    let (mut q, mut going) = (from, L::zero().same(L::zero()));
    for _ in 0..if fresh { FRESH } else { STEPS } {
        let s = Matrix::of(q).transposed_times(moments);
        let half = L::splat(-0.5);
        let along = Vector::new(s.y.y + s.z.z, s.x.x + s.z.z, s.x.x + s.y.y);
        let across =
            Vector::new((s.x.y + s.y.x) * half, (s.x.z + s.z.x) * half, (s.y.z + s.z.y) * half);
        let k = Symmetric {
            along: along + regularisation.along,
            across: across + regularisation.across,
        };
        let gradient = Vector::new(s.y.z - s.z.y, s.z.x - s.x.z, s.x.y - s.y.x);
        let (w, pivot) = k.solve(gradient);
        let square = w.length_squared();
        // Where that is no maximum, the last one stays.
        let good = L::zero().lt(pivot).and(square.le(L::splat(1e6)));
        let good = going.and(good);
        let one = L::splat(1.0);
        let next = turn_further(q, w, one + (one + square).sqrt());
        for (old, new) in q.iter_mut().zip(next) {
            *old = good.select(new, *old);
        }
        going = good.and(square.lt(L::splat(DONE))).select(L::zero(), going);
        if !going.any() {
            break;
        }
    }
    (q, going.bits() & 0xFF)
}

impl OriginOffsets {
    /// Notes the origins of particles where they differ within a body collider.
    pub(super) fn take(&mut self, groups: &BodyGroups, particles: &Particles) {
        self.origin_offsets.clear();
        let origin = |row: u32| particles.origin[row as usize];
        let even = |part: &CompiledCollider| {
            let rows = &groups.rows[part.entries.clone()];
            let first = rows.first().map_or(Vec3::ZERO, |&first| origin(first));
            rows.iter().all(|&row| origin(row) == first)
        };
        if groups.parts.iter().all(even) {
            return;
        }
        for group in &groups.groups {
            let slots = &groups.slots[group.slots.clone()];
            for slot in slots {
                let mut lift = [LaneArray::default(); 3];
                for lane in 0..slot.rows.len() {
                    let by = origin(slot.rows[lane]) - origin(slots[0].rows[lane]);
                    for (to, from) in lift.iter_mut().zip(by.to_array()) {
                        to[lane] = from;
                    }
                }
                self.origin_offsets.push(lift);
            }
        }
    }

    /// Those of some slots.
    pub(super) fn of(&self, group: &BodyGroup) -> Option<&[[LaneArray; 3]]> {
        self.origin_offsets.get(group.slots.clone())
    }
}
