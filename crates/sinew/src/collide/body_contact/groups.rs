//! Mass properties of body colliders that do not change while they move: masses, centre, inertia; in groups of eight.
//!
//! # Particles that belong to several body colliders
//!
//! A particle that `k` body colliders share counts in each of them with a `k`-th of its mass, and is displaced by a `k`-th of what each of them requires. A
//! body collider whose particles have the shares `m/k` and are to be displaced by `d` brings the momentum `Σ (m/k) d`; the displacement that the particles
//! get is `Σ m (d/k)`, which is the same. So an elbow follows the upper arm and the forearm by a half each, and momentum is conserved.
//!
//! # Pinned particles
//!
//! A body collider with one pinned particle turns about it: the pin is its centre, and its inverse mass is zero. With two it turns about the line `e` through
//! them: its inverse inertia is reduced to `e eᵀ / (eᵀ I e)`. With more it is immovable.
//!
//! # Body colliders that are lines
//!
//! Two particles do not determine the rotation of a body collider about their line, and no impulse turns it about that: its inverse inertia is the
//! pseudo-inverse. When the rotation is extracted, the matrix `K` of Newton's step (see `pose/rotation.rs` of the crate) is singular along the line; a
//! regularisation `top · e eᵀ` makes it regular and adds nothing to the step, which is across the line. So the twist stays what it was.

use core::ops::Range;

use glam::{DVec3, Mat3, Vec3};

use super::super::body_collider::BodyCollider;
use super::turn::{LaneArray, set};
use crate::islands::Islands;
use crate::lanes::LANES;
use crate::particles::Particles;
use crate::pose::symmetric;

/// Moments of inertia below this share of the greatest count as zero: a body thinner than 1 in 300. Anything thinner would show the round-off of its
/// particles' positions as a trembling about its line.
const LINE: f64 = 1e-5;
/// Weight of a pinned particle when the pose is extracted, in multiples of the mass of all others. Any value extracts the same pose while constraints keep
/// the body collider in shape; a greater one stays nearer to the pin while they do not.
const PIN: f64 = 16.0;

/// No body collider, or no island.
pub(super) const NONE: u32 = u32::MAX;

/// One particle of each of eight body colliders.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub(super) rows: [u32; LANES],
    /// Weight of the particle in the extraction, kg (see [`PIN`]); 0 in lanes whose body collider has fewer particles.
    pub(super) pull: LaneArray,
    /// Share of the displacement that the particle gets: one by the number of body colliders that share it; 0 in unused lanes.
    pub(super) share: LaneArray,
    /// Its inverse mass, 1/kg.
    pub(super) inverse_mass: LaneArray,
    /// Rest position, from the body collider's centre, metres.
    pub(super) rest: [LaneArray; 3],
}

/// A group of eight body colliders.
#[derive(Clone, Debug)]
pub(super) struct BodyGroup {
    pub(super) slots: Range<usize>,
    /// Whether rows may occur twice in it, or lanes are empty: displacements are then scattered one by one.
    pub(super) scattered: bool,
    /// Whether one of them shares particles with another body collider.
    pub(super) shares: bool,
    /// Whether one of them has a pinned particle.
    pub(super) pinned: bool,
    /// Whether all have two particles: segments of ropes.
    pub(super) lines: bool,
    /// A bit for each lane with a valid body collider.
    pub(super) sound: u32,
    /// Reference for their initial rotation; `None` where it cannot be computed in lanes for all eight.
    pub(super) rotation_reference: Option<RotationReference>,
    pub(super) mass: WideMass,
}

/// Mass properties of eight body colliders.
#[derive(Clone, Debug, Default)]
pub(super) struct WideMass {
    /// One by the sum of the weights that determine the centre, 1/kg.
    pub(super) inverse_weight: LaneArray,
    /// The centre in the body collider's own frame, metres.
    pub(super) centre: [LaneArray; 3],
    /// 1 where the pinned particles alone determine the centre.
    pub(super) pin_centred: LaneArray,
    pub(super) inverse_mass: LaneArray,
    /// xx, yy, zz, xy, xz, yz about its centre, in the body collider's own axes, kg·m².
    pub(super) inertia: [LaneArray; 6],
    pub(super) inverse_inertia: [LaneArray; 6],
    /// Inverse inertia of all particles, pinned ones too: it gives the spin of a body collider that moving pins carry along.
    pub(super) led: [LaneArray; 6],
    pub(super) regularisation: [LaneArray; 6],
    /// Greatest distance of the free particles of a pinned body collider from its pin or axis, metres; 0 of others.
    pub(super) pin_reach: LaneArray,
    /// 1 where nothing is pinned, so that momentum is kept to the last bit.
    pub(super) free: LaneArray,
}

/// A body collider as it was compiled.
#[derive(Clone, Debug, Default)]
pub(super) struct CompiledCollider {
    /// Its range in the list of rows.
    pub(super) entries: Range<usize>,
    /// Whether it is valid and takes part.
    pub(super) sound: bool,
    /// Its centre in its own frame, metres.
    pub(super) centre: Vec3,
    /// Greatest distance of its surface from the centre, metres.
    pub(super) reach: f32,
    /// Indices of two of its particles that determine its initial rotation: one far from the first, and one far from the line of the two, if there is any.
    pub(super) far: usize,
    pub(super) side: Option<usize>,
    /// Whether nothing can move it.
    pub(super) immovable: bool,
}

/// All body colliders as they were compiled.
#[derive(Clone, Debug, Default)]
pub(super) struct BodyGroups {
    pub(super) groups: Vec<BodyGroup>,
    pub(super) slots: Vec<Slot>,
    pub(super) parts: Vec<CompiledCollider>,
    /// The row of each body collider in `bodies`. Body colliders with equal numbers of particles are adjacent, so that lanes of three particles do not wait
    /// for one of five, and those of two particles have groups of their own.
    places: Vec<u32>,
    /// The body collider in each of those rows; `NONE` in padding.
    order: Vec<u32>,
    /// Rows of the particles of each body collider, one after the other.
    pub(super) rows: Vec<u32>,
    /// Number of body colliders that share each of these.
    pub(super) sharers: Vec<u32>,
    /// For each body collider the others that it shares particles with.
    sharing: Vec<Vec<u32>>,
    /// For each row of the simulation whether it belongs to a body collider.
    pub(super) solid: Vec<bool>,
    /// Inverse masses from which the mass properties were computed, 1/kg.
    inverse_masses: Vec<f32>,
}

impl BodyGroups {
    /// Lays out body colliders. Invalid ones keep their number and take no part.
    pub(super) fn compile(&mut self, body_colliders: &[BodyCollider], particles: &Particles) {
        let Self {
            groups,
            slots,
            parts,
            places,
            order,
            rows,
            sharers,
            sharing,
            solid,
            inverse_masses,
        } = self;
        groups.clear();
        slots.clear();
        parts.clear();
        rows.clear();
        inverse_masses.clear();
        solid.clear();
        solid.resize(particles.len(), false);
        let mut count = vec![0_u32; particles.len()];
        for one in body_colliders {
            let (first, sound) = (rows.len(), one.fault(particles.len()).is_none());
            if sound {
                rows.extend_from_slice(&one.rows);
                for &row in &one.rows {
                    solid[row as usize] = true;
                    count[row as usize] += 1;
                }
            }
            parts.push(CompiledCollider {
                entries: first..rows.len(),
                sound,
                ..CompiledCollider::default()
            });
        }
        sharers.clear();
        sharers.extend(rows.iter().map(|&row| count[row as usize]));
        *sharing = sharing_of(parts, rows, sharers);
        inverse_masses.resize(rows.len(), f32::NAN);
        let count = |number: u32| parts[number as usize].entries.len();
        let mut sorted: Vec<u32> = (0..parts.len() as u32).collect();
        sorted.sort_by_key(|&number| count(number));
        order.clear();
        for alike in sorted.chunk_by(|&a, &b| count(a).cmp(&2) == count(b).cmp(&2)) {
            order.resize(order.len().next_multiple_of(LANES), NONE);
            order.extend(alike);
        }
        places.clear();
        places.resize(parts.len(), 0);
        for (place, &number) in order.iter().enumerate() {
            if let Some(to) = places.get_mut(number as usize) {
                *to = place as u32;
            }
        }
        for eight in order.chunks(LANES) {
            let of = |lane: usize| eight.get(lane).and_then(|&number| parts.get(number as usize));
            let each = || (0..LANES).filter_map(of);
            let most = each().map(|part| part.entries.len()).max().unwrap_or(0);
            let first = slots.len();
            let spare = rows.first().copied().unwrap_or(0);
            for place in 0..most {
                let entry = |lane: usize| {
                    let entries = of(lane).map_or(0..0, |part| part.entries.clone());
                    entries
                        .clone()
                        .nth(place)
                        .map(|i| (i, true))
                        .or(entries.clone().next().map(|i| (i, false)))
                };
                let mut slot = Slot {
                    rows: [spare; LANES],
                    pull: [0.0; LANES],
                    share: [0.0; LANES],
                    inverse_mass: [0.0; LANES],
                    rest: [[0.0; LANES]; 3],
                };
                for lane in 0..LANES {
                    if let Some((i, real)) = entry(lane) {
                        slot.rows[lane] = rows[i];
                        slot.share[lane] = if real { 1.0 / sharers[i] as f32 } else { 0.0 };
                    }
                }
                slots.push(slot);
            }
            let whole = each().count() == LANES && each().all(|part| part.sound);
            let entries = each().flat_map(|part| part.entries.clone());
            let alone = entries.into_iter().all(|i| sharers[i] == 1);
            groups.push(BodyGroup {
                slots: first..slots.len(),
                scattered: !(whole && alone),
                shares: !alone,
                pinned: false,
                lines: each().all(|part| part.entries.len() == 2),
                sound: (0..LANES).fold(0, |bits, lane| {
                    bits | u32::from(of(lane).is_some_and(|part| part.sound)) << lane
                }),
                rotation_reference: None,
                mass: WideMass::default(),
            });
        }
        for (part, solid) in parts.iter_mut().zip(body_colliders).filter(|(part, _)| part.sound) {
            (part.far, part.side) = reference_particles(&solid.rest);
        }
        for (group, eight) in groups.iter_mut().zip(order.chunks(LANES)) {
            let sound = |part: &&CompiledCollider| part.sound;
            group.rotation_reference = RotationReference::of(
                eight.iter().map(|&number| number as usize).filter_map(|number| {
                    let part = parts.get(number).filter(sound)?;
                    Some((part, &rows[part.entries.clone()], &*body_colliders[number].rest))
                }),
            );
        }
    }

    /// Recomputes the mass properties of those of `these` whose particles have changed their masses. A function of the present masses alone.
    pub(super) fn update_masses(
        &mut self,
        body_colliders: &[BodyCollider],
        these: &[u32],
        particles: &Particles,
    ) {
        for number in these.iter().map(|&number| number as usize) {
            let Some(solid) = body_colliders.get(number) else { continue };
            let Some(part) = self.parts.get(number).filter(|part| part.sound) else { continue };
            let entries = part.entries.clone();
            let now = |i: usize| particles.position[self.rows[i] as usize].w;
            if entries.clone().any(|i| self.inverse_masses[i].to_bits() != now(i).to_bits()) {
                for i in entries {
                    self.inverse_masses[i] = particles.position[self.rows[i] as usize].w;
                }
                self.update_mass(number, solid);
            }
        }
    }

    fn update_mass(&mut self, number: usize, solid: &BodyCollider) {
        let place = self.place(number);
        let part = &mut self.parts[number];
        let inverses = &self.inverse_masses[part.entries.clone()];
        let sharers = &self.sharers[part.entries.clone()];
        let weights = ColliderMass::of(&solid.rest, inverses, sharers);
        part.centre = weights.centre.as_vec3();
        let (low, high) = solid.shape.bounds();
        part.reach = (low - part.centre).abs().max((high - part.centre).abs()).length();
        part.immovable = weights.inverse_mass == 0.0 && weights.inverse == [[0.0; 3]; 3];
        let (group, lane) = (&mut self.groups[place / LANES], place % LANES);
        group.pinned |= weights.pins > 0;
        let mass = &mut group.mass;
        mass.inverse_weight[lane] = weights.inverse_weight as f32;
        set(&mut mass.centre, lane, part.centre);
        mass.pin_centred[lane] = if weights.pins > 0 { 1.0 } else { 0.0 };
        mass.free[lane] = if weights.pins > 0 { 0.0 } else { 1.0 };
        mass.inverse_mass[lane] = weights.inverse_mass as f32;
        mass.pin_reach[lane] = weights.pin_reach as f32;
        let put = |to: &mut [LaneArray; 6], from: [[f64; 3]; 3]| {
            let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = from;
            for (to, from) in to.iter_mut().zip([xx, yy, zz, xy, xz, yz]) {
                to[lane] = from as f32;
            }
        };
        put(&mut mass.inertia, weights.inertia);
        put(&mut mass.inverse_inertia, weights.inverse);
        put(&mut mass.led, weights.led);
        put(&mut mass.regularisation, weights.regularisation);
        for (slot, i) in self.slots[group.slots.clone()].iter_mut().zip(0..solid.rest.len()) {
            slot.pull[lane] = weights.pull(inverses[i], sharers[i]) as f32;
            slot.inverse_mass[lane] = inverses[i];
            let rest = (solid.rest[i].as_dvec3() - weights.centre).as_vec3();
            set(&mut slot.rest, lane, rest);
        }
    }

    /// The inverse mass, 1/kg, from which the mass properties of an entry of [`rows`](Self::rows) were computed.
    pub(super) fn inverse_mass(&self, entry: usize) -> f32 {
        self.inverse_masses[entry]
    }

    /// Whether two body colliders have a particle in common.
    #[inline]
    pub(super) fn share_a_row(&self, a: usize, b: usize) -> bool {
        self.sharing[a].contains(&(b as u32))
    }

    /// Whether a body collider shares no particle with others.
    pub(super) fn is_alone(&self, a: usize) -> bool {
        self.sharing[a].is_empty()
    }

    /// The row of a body collider in `bodies`: its group times eight plus its lane.
    #[inline(always)]
    pub(super) fn place(&self, number: usize) -> usize {
        self.places[number] as usize
    }

    /// The body collider in a lane of a group, if it is valid.
    pub(super) fn sound_in(&self, group: usize, lane: usize) -> Option<usize> {
        let number = *self.order.get(group * LANES + lane)? as usize;
        self.parts.get(number).is_some_and(|part| part.sound).then_some(number)
    }

    /// The island of the body collider in a row of `bodies`, if it is valid. Static geometry and the null row come after the rows of body colliders and have
    /// none.
    pub(super) fn island_of(&self, row: u32, islands: &Islands) -> Option<u32> {
        let (number, lane) = (row as usize / LANES, row as usize % LANES);
        let solid = self.groups.get(number).and_then(|_| self.sound_in(number, lane))?;
        islands.of.get(self.rows[self.parts[solid].entries.start] as usize).copied()
    }

    /// The number of rows in `bodies` for body colliders, padding included.
    pub(super) fn padded(&self) -> usize {
        self.groups.len() * LANES
    }
}

/// For each body collider the others that it has particles in common with.
fn sharing_of(parts: &[CompiledCollider], rows: &[u32], sharers: &[u32]) -> Vec<Vec<u32>> {
    let entries = parts.iter().zip(0..).flat_map(|(part, number)| {
        part.entries.clone().filter(|&i| sharers[i] > 1).map(move |i| (rows[i], number))
    });
    let mut shared: Vec<(u32, u32)> = entries.collect();
    shared.sort_unstable();
    let mut sharing = vec![Vec::new(); parts.len()];
    for same in shared.chunk_by(|one, other| one.0 == other.0) {
        for (_, one) in same {
            let others = same.iter().map(|(_, other)| *other).filter(|other| other != one);
            sharing[*one as usize].extend(others);
        }
    }
    sharing
}

/// The index of the particle farthest from the first one, and of the one farthest from the line through these two.
fn reference_particles(rest: &[Vec3]) -> (usize, Option<usize>) {
    let arm = |i: usize| rest[i].as_dvec3() - rest[0].as_dvec3();
    let mut far = (0, 0.0);
    for i in 1..rest.len() {
        let square = arm(i).length_squared();
        if square > far.1 {
            far = (i, square);
        }
    }
    let along = arm(far.0);
    let mut side = (None, LINE * far.1 * far.1);
    for i in 1..rest.len() {
        let square = along.cross(arm(i)).length_squared();
        if square > side.1 {
            side = (Some(i), square);
        }
    }
    (far.0, side.0)
}

/// Reference for the initial rotations of eight body colliders: rows of their first particles, of those far away, and of those off the line; and the frames
/// that these span at rest.
#[derive(Clone, Debug)]
pub(super) struct RotationReference {
    pub(super) rows: [[u32; LANES]; 3],
    pub(super) rest: [[LaneArray; 3]; 3],
}

impl RotationReference {
    /// The reference of eight body colliders whose particles are not collinear: each with its rows and rest positions. `None` of fewer.
    pub(super) fn of<'a>(
        eight: impl Iterator<Item = (&'a CompiledCollider, &'a [u32], &'a [Vec3])>,
    ) -> Option<Self> {
        let mut rotation_reference = Self { rows: [[0; LANES]; 3], rest: [[[0.0; LANES]; 3]; 3] };
        let mut count = 0;
        for (lane, (part, rows, rest)) in eight.enumerate() {
            let side = part.side?;
            for (to, from) in rotation_reference.rows.iter_mut().zip([0, part.far, side]) {
                to[lane] = rows[from];
            }
            let frame = frame(rest[part.far] - rest[0], rest[side] - rest[0])?;
            // By rows.
            for (to, from) in
                rotation_reference.rest.iter_mut().zip(frame.transpose().to_cols_array_2d())
            {
                for (to, from) in to.iter_mut().zip(from) {
                    to[lane] = from;
                }
            }
            count += 1;
        }
        (count == LANES).then_some(rotation_reference)
    }
}

/// A right-handed frame with its first axis along `a`, and `b` in the plane of its first two.
pub(super) fn frame(a: Vec3, b: Vec3) -> Option<Mat3> {
    let (x, z) = (a.try_normalize()?, a.cross(b).try_normalize()?);
    Some(Mat3::from_cols(x, z.cross(x), z))
}

/// Mass properties of one body collider.
struct ColliderMass {
    pins: usize,
    /// Mass of the free particles.
    mass: f64,
    centre: DVec3,
    inverse_weight: f64,
    inverse_mass: f64,
    pin_reach: f64,
    inertia: [[f64; 3]; 3],
    inverse: [[f64; 3]; 3],
    led: [[f64; 3]; 3],
    regularisation: [[f64; 3]; 3],
}

impl ColliderMass {
    fn of(rest: &[Vec3], inverses: &[f32], sharers: &[u32]) -> Self {
        let pins = inverses.iter().filter(|&&w| w <= 0.0).count();
        let free = |i: usize| {
            let w = f64::from(inverses[i]);
            if w > 0.0 { 1.0 / (w * f64::from(sharers[i])) } else { 0.0 }
        };
        let mass: f64 = (0..rest.len()).map(free).sum();
        let this = Self {
            pins,
            mass,
            centre: DVec3::ZERO,
            inverse_weight: 0.0,
            inverse_mass: if pins == 0 { 1.0 / mass } else { 0.0 },
            pin_reach: 0.0,
            inertia: Default::default(),
            inverse: Default::default(),
            led: Default::default(),
            regularisation: Default::default(),
        };
        let pull = |i: usize| this.pull(inverses[i], sharers[i]);
        let weight = |i: usize| if pins == 0 || inverses[i] <= 0.0 { pull(i) } else { 0.0 };
        let sum: f64 = (0..rest.len()).map(weight).sum();
        let centre: DVec3 = (0..rest.len()).map(|i| rest[i].as_dvec3() * (weight(i) / sum)).sum();
        let arm = |i: usize| rest[i].as_dvec3() - centre;
        let inertia = inertia_of((0..rest.len()).map(|i| (arm(i), free(i))));
        let all = inertia_of((0..rest.len()).map(|i| (arm(i), pull(i))));
        let (led, regularisation) = inverse_and_regularisation(all);
        let axis = || {
            let mut pinned = (0..rest.len()).filter(|&i| inverses[i] <= 0.0).map(arm);
            let (one, other) = (pinned.next()?, pinned.next()?);
            (other - one).try_normalize()
        };
        let inverse = match pins {
            0 => led,
            1 => inverse_and_regularisation(inertia).0,
            2 => axis().map_or_else(
                || inverse_and_regularisation(inertia).0,
                |e| inverse_about(e, inertia),
            ),
            _ => [[0.0; 3]; 3],
        };
        let off_axis = |i: usize| match (pins, axis()) {
            (0, _) => 0.0,
            (2, Some(e)) => arm(i).cross(e).length(),
            _ => arm(i).length(),
        };
        let pin_reach = (0..rest.len()).map(off_axis).fold(0.0, f64::max);
        Self {
            centre,
            inverse_weight: 1.0 / sum,
            pin_reach,
            inertia,
            inverse,
            led,
            regularisation,
            ..this
        }
    }

    /// Weight of a particle in the extraction of the pose, kg.
    fn pull(&self, inverse_mass: f32, sharers: u32) -> f64 {
        if inverse_mass > 0.0 {
            1.0 / (f64::from(inverse_mass) * f64::from(sharers))
        } else if self.mass > 0.0 {
            self.mass * PIN
        } else {
            1.0
        }
    }
}

/// Inertia of points with masses about zero: `Σ m (r² 1 - r rᵀ)`.
fn inertia_of(points: impl Iterator<Item = (DVec3, f64)>) -> [[f64; 3]; 3] {
    let mut sum = [[0.0; 3]; 3];
    for (r, m) in points {
        let (square, r) = (r.length_squared(), r.to_array());
        for (i, row) in sum.iter_mut().enumerate() {
            for (j, to) in row.iter_mut().enumerate() {
                *to += m * (if i == j { square } else { 0.0 } - r[i] * r[j]);
            }
        }
    }
    sum
}

/// The pseudo-inverse of an inertia, and the regularisation that makes it regular.
fn inverse_and_regularisation(inertia: [[f64; 3]; 3]) -> ([[f64; 3]; 3], [[f64; 3]; 3]) {
    let (mut inverse, mut regularisation) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    let (values, vectors) = symmetric::eigen(inertia);
    let top = values.iter().fold(0.0_f64, |top, &value| top.max(value));
    for (value, e) in values.into_iter().zip(vectors) {
        let (of, factor) = if value > LINE * top && value > f64::MIN_POSITIVE {
            (&mut inverse, 1.0 / value)
        } else {
            (&mut regularisation, if top > 0.0 { top } else { 1.0 })
        };
        for (i, row) in of.iter_mut().enumerate() {
            for (j, to) in row.iter_mut().enumerate() {
                *to += factor * e[i] * e[j];
            }
        }
    }
    (inverse, regularisation)
}

/// The inverse inertia of a body that can turn only about the axis `e`.
fn inverse_about(e: DVec3, inertia: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let e = e.to_array();
    let mut moment = 0.0;
    let mut trace = 0.0;
    for i in 0..3 {
        trace += inertia[i][i];
        for j in 0..3 {
            moment += e[i] * inertia[i][j] * e[j];
        }
    }
    let inverse = if moment > LINE * trace { 1.0 / moment } else { 0.0 };
    core::array::from_fn(|i| core::array::from_fn(|j| inverse * e[i] * e[j]))
}
