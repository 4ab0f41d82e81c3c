//! Poses of body colliders: extracted from the particles that a substep has predicted, and applied to them once contacts have corrected them.
//!
//! Contacts correct a pose, but the particles are what moves. Three steps connect the two, in this order: an initial rotation from positions alone when a
//! step begins; the extracted pose, once afresh at the broad phase and then once per substep; and the pose delta, applied to the particles so that momentum
//! is kept. All of them run on eight body colliders at a time.
//!
//! # The initial rotation
//!
//! No rotation is kept from step to step, so that a restored world continues with the same bits. Two particles of a body collider, one far from the first and
//! one far from the line of the two, give an approximate rotation; the extraction makes it exact.
//!
//! # The extracted pose
//!
//! With `q` the predicted positions, `p` those at the substep's start and `m` the masses, it has the centres of both; the rotation nearest to `Σ m (q - q̄)
//! rᵀ`, by one or two of Newton's steps from the last substep's (derived in `pose/rotation.rs` of the crate, here in `f32`); and the turn since the start,
//! which needs no second rotation:
//!
//! ```text
//! φ = I⁻¹ Σ m r × (δ - δ̄)        r = q - q̄,  δ = q - p
//! ```
//!
//! is the turn whose displacements `φ × r` are nearest to those of the particles. `Σ m (q - q̄)(p - p̄)ᵀ` is kept for the pose delta.
//!
//! For two particles, a segment of a rope, the nearest rotation is the shortest arc from the last one. Most segments touch nothing, and their poses are not
//! needed: a substep extracts only those of segments that are in a contact of the step or have left their swept bounds, which is checked first.
//!
//! # The pose delta, and momentum
//!
//! Each particle is displaced by the shift and the turn of its body collider, so that rods inside keep their lengths and soft bodies keep their own
//! deformation.
//!
//! The turn is a rotation `ΔR`, and `(ΔR - 1) r` with the actual arms `r = q - q̄` keeps momentum, because `Σ m r = 0`. Angular momentum, as Verlet keeps it,
//! changes by `Σ m (p - p̄) × d`, and has to change by `T = I φ`, the moment of the impulses. The difference comes of the rotation from `p` to `q`, of second
//! order in the turn, and of particles that are slightly off their rest places; a further infinitesimal turn `ψ` corrects it:
//!
//! ```text
//! J ψ = T - Σ m (p - p̄) × (ΔR - 1)(q - q̄)        J = Σ m ((p - p̄)·(q - q̄) 1 - (q - q̄)(p - p̄)ᵀ)
//! ```
//!
//! All of it follows from `Σ m (q - q̄)(p - p̄)ᵀ`, which was summed up during extraction. So `d = shift + D (q - q̄)` with one matrix `D` per body collider.
//! Velocities change in the same way, with `ψ × r` alone.

use glam::{DMat3, DQuat, Vec3, Vec4};

use super::BodyContactSolver;
use super::bodies::{Bodies, ROTATION, from_row, quaternion};
use super::groups::{
    BodyGroup, BodyGroups, CompiledCollider, RotationReference, Slot, WideMass, frame,
};
use super::swept_bounds::WideSweptBounds;
use super::turn::{LaneArray, Matrix, Symmetric, load, store, turn_further, unit_quaternion, zero};
use crate::collide::world::World;
use crate::lanes::{FIELDS, LANES, Lanes, Vector, Work, kernel, set, with};
use crate::particles::Particles;
use crate::pose::rotation;

/// Bound of a squared Newton step, rad²: such a step leaves an error of its cube, below the round-off of `f32`.
const CONVERGED: f32 = 1e-5;
/// The most Newton steps: within a step, and afresh.
const STEPS: u32 = 3;
const FRESH_STEPS: u32 = 8;

impl BodyContactSolver {
    /// Computes an initial rotation of each valid body collider.
    pub(super) fn note_initial_rotations(&mut self, particles: &Particles, world: &World) {
        let Self { groups, origin_offsets, bodies, dormant, instructions, .. } = self;
        let mut turned = [Vec4::W; LANES];
        for (number, group) in groups.groups.iter().enumerate() {
            let kept = dormant.0.kept_of(number);
            if kept != 0 && kept == group.sound {
                continue;
            }
            // Particles of one body collider have different origins: no rotation is computed in lanes.
            let rotation_reference =
                group.rotation_reference.as_ref().filter(|_| origin_offsets.of(group).is_none());
            let computed = rotation_reference.map_or(0, |rotation_reference| {
                let position = &particles.position;
                initial_rotations(rotation_reference, position, &mut turned, *instructions)
            });
            for (lane, &turned) in turned.iter().enumerate() {
                if kept >> lane & 1 == 1 {
                    continue;
                }
                let row = &mut bodies[number * LANES + lane];
                if computed >> lane & 1 == 1 {
                    row[ROTATION] = turned;
                } else if let Some(solid) = groups.sound_in(number, lane) {
                    let rest = &world.body_colliders[solid].rest;
                    row[ROTATION] = initial_rotation(groups, &groups.parts[solid], rest, particles);
                }
            }
        }
    }
}

kernel!(
    /// Computes the initial rotations of eight body colliders, to the bits of [`initial_rotation`]. Returns a bit for each lane that has one.
    fn initial_rotations<L: Lanes>(
        rotation_reference: &RotationReference,
        position: &[Vec4],
        turned: &mut [Vec4; LANES],
    ) -> u32 {
        let RotationReference { rows: [first, far, side], rest } = rotation_reference;
        let first = gather_positions::<L>(position, first);
        let (far, side) =
            (gather_positions(position, far) - first, gather_positions(position, side) - first);
        let (x, is_long) = unit(far);
        let (z, is_wide) = unit(far.cross(side));
        let [a, b, c] = rest;
        let rest = Matrix { x: load(a), y: load(b), z: load(c) };
        let q = unit_quaternion(&Matrix { x, y: z.cross(x), z }.times_matrix(&rest));
        L::put_run(turned, 0, q);
        is_long.and(is_wide).bits()
    }
);

#[inline(always)]
fn gather_positions<L: Lanes>(position: &[Vec4], rows: &[u32; LANES]) -> Vector<L> {
    Vector::of(L::rows(position, rows)).0
}

/// A vector scaled to length 1, and whether that exists.
#[inline(always)]
fn unit<L: Lanes>(v: Vector<L>) -> (Vector<L>, L) {
    let inverse = L::splat(1.0) / v.length();
    (v * inverse, L::zero().lt(inverse).and(inverse.lt(L::splat(f32::INFINITY))))
}

/// The initial rotation of a body collider from two of its particles: a function of their positions alone.
fn initial_rotation(
    groups: &BodyGroups,
    part: &CompiledCollider,
    rest: &[Vec3],
    particles: &Particles,
) -> Vec4 {
    let rows = &groups.rows[part.entries.clone()];
    let here = |i: usize| particles.separation(rows[i] as usize, rows[0] as usize);
    let there = |i: usize| rest[i] - rest[0];
    if let Some(side) = part.side {
        let frames = (frame(there(part.far), there(side)), frame(here(part.far), here(side)));
        if let (Some(from), Some(to)) = frames {
            return quaternion(&(to * from.transpose()));
        }
    }
    let ends = (there(part.far).try_normalize(), here(part.far).try_normalize());
    let (Some(from), Some(to)) = ends else { return Vec4::W };
    // The shortest arc; any axis across it for a half turn.
    let (axis, real) = (from.cross(to), 1.0 + from.dot(to));
    let q = if real > 1e-6 { axis.extend(real) } else { from.any_orthonormal_vector().extend(0.0) };
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    q / length
}

/// The rotation of a body collider by the slow robust method in `f64`, for lanes whose Newton steps have not converged.
pub(super) fn robust_rotation(
    groups: &BodyGroups,
    number: usize,
    rest: &[Vec3],
    particles: &Particles,
    near: Vec4,
) -> Vec4 {
    let part = &groups.parts[number];
    let rows = &groups.rows[part.entries.clone()];
    let place = groups.place(number);
    let slots = &groups.slots[groups.groups[place / LANES].slots.clone()];
    let points = || {
        rows.iter().zip(rest).zip(slots).map(|((&row, rest), slot)| {
            let here = particles.separation(row as usize, rows[0] as usize).as_dvec3();
            (here, (*rest - part.centre).as_dvec3(), f64::from(slot.pull[place % LANES]))
        })
    };
    let sum: f64 = points().map(|(_, _, m)| m).sum();
    let middle = points().map(|(q, _, m)| q * (m / sum)).sum::<glam::DVec3>();
    let mut moments = DMat3::ZERO;
    for (q, r, m) in points() {
        let a = (q - middle) * m;
        moments += DMat3::from_cols(a * r.x, a * r.y, a * r.z);
    }
    let near = DQuat::from_xyzw(near.x.into(), near.y.into(), near.z.into(), near.w.into());
    let q = rotation::nearest(moments, near.normalize());
    let q = Vec4::new(q.x as f32, q.y as f32, q.z as f32, q.w as f32);
    if q.is_finite() { q } else { Vec4::W }
}

/// Sums that the extraction keeps of a group for the pose delta.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PoseSums {
    /// Predicted centres, metres from the origin.
    pub(super) centre: [LaneArray; 3],
    /// `Σ m (q - q̄)(p - p̄)ᵀ` by columns, kg·m².
    pub(super) pairs: [[LaneArray; 3]; 3],
}

/// Origins of particles relative to that of the first particle of their body collider, metres.
#[derive(Clone, Debug, Default)]
pub(super) struct OriginOffsets {
    /// One for each slot; empty where all particles of each body collider have the same origin, as those of an island do.
    origin_offsets: Vec<[LaneArray; 3]>,
}

impl BodyContactSolver {
    /// Extracts the poses of a group from two columns: from positions and those at the start of the substep, with `time` the seconds since the step began;
    /// or, without a time, afresh from positions and velocities. Returns a bit for each lane that has left its swept bounds or, afresh, whose rotation did
    /// not converge. Of a group of lines only `lanes` are extracted, so that the result of a line does not depend on its neighbour lanes.
    pub(super) fn extract_pose(
        &mut self,
        number: usize,
        [position, other]: [&[Vec4]; 2],
        time: Option<f32>,
        lanes: u32,
    ) -> u32 {
        let Self { groups, origin_offsets, bodies, sums, wide_swept, gathered, .. } = self;
        let group = &groups.groups[number];
        let read = ExtractPose {
            group,
            slots: &groups.slots[group.slots.clone()],
            origin_offsets: origin_offsets.of(group),
            position,
            other,
            fresh: time.is_none(),
            lanes,
            bodies,
            first: number * LANES,
            sums: &mut sums[number],
            wide_swept: time.map(|time| (&wide_swept[number], time)),
            gathered,
        };
        with(self.instructions, read)
    }

    /// Returns a bit for each line of a group that has left its swept bounds, `time` seconds after the step began.
    pub(super) fn lines_outside(&self, number: usize, position: &[Vec4], time: f32) -> u32 {
        let Self { groups, origin_offsets, wide_swept, .. } = self;
        let group = &groups.groups[number];
        let slots = &groups.slots[group.slots.clone()];
        let (origin_offsets, swept) = (origin_offsets.of(group), &wide_swept[number]);
        lines_outside(&group.mass, slots, origin_offsets, position, swept, time, self.instructions)
    }

    /// Applies the pose deltas of the body colliders in `lanes` to their particles, or changes their velocities instead. Deltas of scattered groups and
    /// shared particles are added to `shared`.
    pub(super) fn apply_pose_delta(
        &mut self,
        number: usize,
        lanes: u32,
        position: &mut [Vec4],
        velocity: Option<&mut [Vec4]>,
    ) {
        let Self { groups, origin_offsets, bodies, sums, shared, .. } = self;
        let group = &groups.groups[number];
        let write = ApplyPoseDelta {
            group,
            lanes,
            slots: &groups.slots[group.slots.clone()],
            origin_offsets: origin_offsets.of(group),
            position,
            velocity,
            bodies,
            first: number * LANES,
            sums: &sums[number],
            shared,
        };
        with(self.instructions, write);
    }
}

/// Extraction of the poses of a group.
struct ExtractPose<'a> {
    group: &'a BodyGroup,
    slots: &'a [Slot],
    origin_offsets: Option<&'a [[LaneArray; 3]]>,
    position: &'a [Vec4],
    /// Positions at the start of the substep; afresh, velocities.
    other: &'a [Vec4],
    fresh: bool,
    /// A bit for each line that is extracted.
    lanes: u32,
    bodies: &'a mut Bodies,
    /// The first row of the group in `bodies`.
    first: usize,
    sums: &'a mut PoseSums,
    /// Swept bounds of the group, and the time since the step began, seconds; `None` afresh.
    wide_swept: Option<(&'a WideSweptBounds, f32)>,
    /// Scratch.
    gathered: &'a mut Vec<Gathered>,
}

/// One particle of each of eight body colliders, gathered once for two passes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gathered {
    pub(super) position: [LaneArray; 3],
    /// Displacement in the substep, or velocity.
    pub(super) moved: [LaneArray; 3],
    inverse_mass: LaneArray,
}

impl Work for ExtractPose<'_> {
    /// A bit for each lane: afresh, where the rotation did not converge; otherwise, where a body collider has left its swept bounds.
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
            lanes,
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
        for (slot, kept) in slots.iter().zip(&*gathered) {
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
        let (q, unconverged) = match (slots, &gathered[..]) {
            ([one, other], [from, to, ..]) if group.lines => {
                let rest = load::<L>(&other.rest) - load(&one.rest);
                along_line(rest, load(&to.position) - load(&from.position), rotation, lanes)
            }
            _ => nearest(mass, &moments, rotation, fresh),
        };
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
            start.with(L::load(&mass.pin_reach)),
            step.with(none),
            spin.with(none),
            q,
        ];
        L::put_records(&mut bodies.rows, &rows, fields);
        store(centre, &mut sums.centre);
        for (column, to) in [pairs.x, pairs.y, pairs.z].into_iter().zip(&mut sums.pairs) {
            store(column, to);
        }
        match wide_swept {
            // Lines were checked before the extraction.
            Some(_) if group.lines => 0,
            Some((wide_swept, time)) => wide_swept.outside::<L>(centre, q, time),
            None => unconverged,
        }
    }
}

kernel!(
    /// Returns a bit for each line that has left its swept bounds. All lines are checked, since most touch nothing and are not extracted.
    fn lines_outside<L: Lanes>(
        mass: &WideMass,
        slots: &[Slot],
        origin_offsets: Option<&[[LaneArray; 3]]>,
        position: &[Vec4],
        wide_swept: &WideSweptBounds,
        time: f32,
    ) -> u32 {
        let [one, other] = slots else { return 0 };
        let (mut from, _) = Vector::of(L::rows(position, &one.rows));
        let (mut to, other_w) = Vector::of(L::rows(position, &other.rows));
        if let Some([own, theirs]) = origin_offsets {
            (from, to) = (from + load(own), to + load(theirs));
        }
        let held = L::zero().lt(L::load(&mass.pin_centred));
        let line = to - from;
        // As in `centre`, whose first summand is zero here.
        let pull = L::load(&other.pull);
        let free = L::zero().lt(other_w);
        let weight = held.select(free.select(L::zero(), pull), pull);
        let centre = from + line * weight * L::load(&mass.inverse_weight);
        let length = line.length();
        let line = line * L::zero().lt(length).and(L::splat(1.0) / length);
        wide_swept.lines_outside::<L>(centre, line, time)
    }
);

/// Where the particles of a group are read from.
pub(super) struct ParticleSource<'a> {
    pub(super) slots: &'a [Slot],
    pub(super) origin_offsets: Option<&'a [[LaneArray; 3]]>,
    pub(super) position: &'a [Vec4],
    pub(super) other: &'a [Vec4],
    pub(super) fresh: bool,
}

impl ParticleSource<'_> {
    /// Centres, and their displacements or velocities; fills `gathered`.
    #[inline(always)]
    pub(super) fn centre<L: Lanes>(
        &self,
        mass: &WideMass,
        gathered: &mut Vec<Gathered>,
    ) -> (Vector<L>, Vector<L>) {
        let held = L::zero().lt(L::load(&mass.pin_centred));
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
            let weight = held.select(free.select(L::zero(), pull), pull);
            sum += (q - near) * weight;
            step += moved * weight;
        }
        let middle = L::load(&mass.inverse_weight);
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

/// The rotation of a line with the rest direction `rest` and the present direction `line`, by the shortest arc from a near rotation: the limit of [`nearest`]
/// for a line. Lanes not in `lanes` keep their rotation, and so do lines without a direction or turned by a half turn; returns a bit for each of the latter
/// two.
#[inline(always)]
fn along_line<L: Lanes>(
    rest: Vector<L>,
    line: Vector<L>,
    from: [L; 4],
    lanes: u32,
) -> ([L; 4], u32) {
    // In the frame of the line before.
    let line = Matrix::of(from).transposed_times_vector(line);
    let size = (rest.length_squared() * line.length_squared()).sqrt();
    let real = size + rest.dot(line);
    let good = (size * L::splat(1e-6)).lt(real).and(real.lt(L::splat(f32::INFINITY)));
    let q = turn_further(from, rest.cross(line), real);
    let set = good.and(L::mask(lanes));
    let mut turned = from;
    for (old, new) in turned.iter_mut().zip(q) {
        *old = set.select(new, *old);
    }
    (turned, !good.bits() & 0xFF)
}

/// The rotation nearest to the moments, by Newton's steps from a near rotation. Returns a bit for each lane that has not converged.
#[inline(always)]
fn nearest<L: Lanes>(
    mass: &WideMass,
    moments: &Matrix<L>,
    from: [L; 4],
    fresh: bool,
) -> ([L; 4], u32) {
    let regularisation = Symmetric::<L>::load(&mass.regularisation);
    // A converged lane keeps its value while others go on: its result must not depend on its neighbour lanes.
    let (mut q, mut going) = (from, L::zero().same(L::zero()));
    for _ in 0..if fresh { FRESH_STEPS } else { STEPS } {
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
        // Not a maximum: the last rotation stays.
        let good = L::zero().lt(pivot).and(square.le(L::splat(1e6)));
        let good = going.and(good);
        let one = L::splat(1.0);
        let next = turn_further(q, w, one + (one + square).sqrt());
        for (old, new) in q.iter_mut().zip(next) {
            *old = good.select(new, *old);
        }
        going = good.and(square.lt(L::splat(CONVERGED))).select(L::zero(), going);
        if !going.any() {
            break;
        }
    }
    (q, going.bits() & 0xFF)
}

impl OriginOffsets {
    /// Collects the origins of particles where they differ within a body collider; `these` are the numbers of all that may have changed.
    pub(super) fn collect(&mut self, groups: &BodyGroups, these: &[u32], particles: &Particles) {
        let were_even = self.origin_offsets.is_empty();
        self.origin_offsets.clear();
        let origin = |row: u32| particles.origin[row as usize];
        let even = |part: &CompiledCollider| {
            let rows = &groups.rows[part.entries.clone()];
            let first = rows.first().map_or(Vec3::ZERO, |&first| origin(first));
            rows.iter().all(|&row| origin(row) == first)
        };
        let is_even = |number: &u32| even(&groups.parts[*number as usize]);
        if if were_even { these.iter().all(is_even) } else { groups.parts.iter().all(even) } {
            return;
        }
        for group in &groups.groups {
            let slots = &groups.slots[group.slots.clone()];
            for slot in slots {
                let mut offset = [LaneArray::default(); 3];
                for lane in 0..slot.rows.len() {
                    let by = origin(slot.rows[lane]) - origin(slots[0].rows[lane]);
                    set(&mut offset, lane, by);
                }
                self.origin_offsets.push(offset);
            }
        }
    }

    /// Those of the slots of a group.
    pub(super) fn of(&self, group: &BodyGroup) -> Option<&[[LaneArray; 3]]> {
        self.origin_offsets.get(group.slots.clone())
    }
}

/// Deltas of particles that several body colliders share or whose groups are scattered, to be added once all are known. They are ordered by slot, and within
/// a slot by body collider, so that the sum for a shared row does not depend on how body colliders are distributed over groups.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedDeltas(Vec<Vec<(u32, Vec4)>>);

impl SharedDeltas {
    /// Clears the lists and keeps their memory.
    pub(super) fn clear(&mut self) {
        self.0.iter_mut().for_each(Vec::clear);
    }

    /// All deltas in their order.
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

/// Pose delta of a group, applied to its particles.
struct ApplyPoseDelta<'a> {
    group: &'a BodyGroup,
    /// A bit for each lane whose particles are changed; particles of rigid states follow from those.
    lanes: u32,
    slots: &'a [Slot],
    origin_offsets: Option<&'a [[LaneArray; 3]]>,
    position: &'a mut [Vec4],
    /// Velocities to change instead of the positions.
    velocity: Option<&'a mut [Vec4]>,
    bodies: &'a Bodies,
    first: usize,
    sums: &'a PoseSums,
    shared: &'a mut SharedDeltas,
}

impl Work for ApplyPoseDelta<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { group, slots, origin_offsets, position, mut velocity, .. } = self;
        let Self { lanes, bodies, first, sums, shared, .. } = self;
        let [shift, turn, .., rotation] = L::records::<FIELDS>(&bodies.rows, &from_row(first));
        let (shift, turn) = (Vector::of(shift).0, Vector::of(turn).0);
        let lanes = L::mask(lanes);
        let (shift, turn) = (shift.or_else(lanes, zero()), turn.or_else(lanes, zero()));
        let square = shift.length_squared() + turn.length_squared();
        if !L::zero().lt(square).any() {
            return;
        }
        let r = Matrix::of(rotation);
        let field = delta_matrix::<L>(group, turn, &r, sums, velocity.is_none());
        let centre = load(&sums.centre);
        for (number, slot) in slots.iter().enumerate() {
            let (q, w) = Vector::of(L::rows(position, &slot.rows));
            let arm = match origin_offsets {
                Some(origin_offsets) => q + load(&origin_offsets[number]) - centre,
                None => q - centre,
            };
            // Pinned particles stay.
            let share = lanes.and(L::zero().lt(w)).and(L::load(&slot.share));
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

/// `D`, which maps arms to displacements, of body colliders with the rotations `r`.
#[inline(always)]
fn delta_matrix<L: Lanes>(
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
    // The correction is at most twice the turn; anything greater is discarded.
    let most = turn.length_squared() * L::splat(4.0);
    let free = L::zero().lt(L::load(&mass.free));
    let sound = free.and(further.length_squared().le(most));
    let otherwise = if rotates { Vector::new(none, none, none) } else { turn };
    add_cross(&mut field, further.or_else(sound, otherwise));
    field
}

/// Adds the cross-product matrix `[v]`.
#[inline(always)]
fn add_cross<L: Lanes>(to: &mut Matrix<L>, v: Vector<L>) {
    let none = L::zero();
    to.x += Vector::new(none, v.z, none - v.y);
    to.y += Vector::new(none - v.z, none, v.x);
    to.z += Vector::new(v.y, none - v.x, none);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::InstructionSet;
    use crate::test_random::Random;

    /// Eight lanes give the same bits as single body colliders, on each instruction set; collinear or non-finite particles give no rotation.
    #[test]
    fn initial_rotations_in_lanes_match_single_ones() {
        let mut random = Random::new(3);
        let part = CompiledCollider { far: 1, side: Some(2), ..CompiledCollider::default() };
        let mut odd = 0;
        for round in 0..200 {
            let mut three = || [(); 3].map(|()| random.vector());
            let rest = [(); LANES].map(|()| three());
            let mut here = [(); LANES].map(|()| three());
            match round % 4 {
                // Unchanged; a half turn about each axis in turn; collinear; NaN.
                0 => here = rest,
                1 => here[0] = rest[0].map(|r| 2.0 * r * (r.x.abs() - r) - r),
                2 => here[round % LANES][2] = here[round % LANES][0],
                _ => here[round % LANES][1] = Vec3::NAN,
            }
            let rows: Vec<u32> = (0..3 * LANES as u32).collect();
            let eight = (0..LANES).map(|lane| (&part, &rows[3 * lane..], &rest[lane][..]));
            let Some(rotation_reference) = RotationReference::of(eight) else { continue };
            let position: Vec<Vec4> =
                here.iter().flatten().map(|place| place.extend(1.0)).collect();
            for set in [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::Avx2] {
                let mut turned = [Vec4::ZERO; LANES];
                let (rotation_reference, position) = (&rotation_reference, &position[..]);
                let computed = initial_rotations(rotation_reference, position, &mut turned, set);
                for lane in 0..LANES {
                    let ([a, b, c], [p, q, r]) = (rest[lane], here[lane]);
                    let frames = (frame(b - a, c - a), frame(q - p, r - p));
                    let (Some(from), Some(to)) = frames else {
                        odd += 1;
                        assert_eq!(computed >> lane & 1, 0, "{set:?}, round {round}, lane {lane}");
                        continue;
                    };
                    let alone = quaternion(&(to * from.transpose()));
                    assert_eq!(computed >> lane & 1, 1, "{set:?}, round {round}, lane {lane}");
                    let bits = |q: Vec4| q.to_array().map(f32::to_bits);
                    assert_eq!(bits(turned[lane]), bits(alone), "{set:?}, round {round}");
                }
            }
        }
        assert!(odd > 100, "{odd}");
    }
}
