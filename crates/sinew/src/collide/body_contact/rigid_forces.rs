//! Forces on rigid states: those that act on single particles, and wind pressure on surface triangles.
//!
//! Particles of a rigid state with forces on single particles (a spring, a control, a force of the game) are written in every substep, so that these forces
//! use their present positions, and the effects are summed up. All other rigid states need no particles until the step ends: gravity and damping are the same
//! for all particles of a body, and wind is summed up over its triangles in body axes, where they are constant.
//!
//! # Wind on a triangle of a rigid body
//!
//! With `A` the area vector of a triangle and `w` the wind pressure there, the law of `forces/wind/pressure.rs` gives each corner a third of `F = w |A·w| /
//! ‖w‖`. That is the force `F` at the middle `c` of its corners: the body gains `Σ F` and, about its centre `z`, the torque `Σ (c - z) × F = Σ c × F - z × Σ
//! F`. With `w` turned into body axes, `A` and `c` are constants, whatever the masses.

use core::ops::Range;

use glam::{Vec3, Vec4};

use super::super::body_collider::BodyCollider;
use super::groups::{BodyGroups, NONE, Slot, WideMass};
use super::rigid_rotation::Rotation;
use super::rigid_state::{ForceSums, WideRigidState};
use super::turn::{LaneArray, load, set, store, zero};
use crate::forces::Pressures;
use crate::integrate::loss;
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, kernel};
use crate::particles::Particles;
use crate::tracked::Tracked;

/// Forces on the rigid states of a step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct RigidForces {
    /// For each group a bit for each lane with forces on single particles in this step, and for each with wind on its surface triangles.
    pub(super) forced: Vec<u32>,
    pub(super) windy: Vec<u32>,
    skins: Skins,
    sums: ForceSums,
    changes: Vec<[Vec4; LANES]>,
}

/// Surface triangles of bodies that may be rigid states, in body axes.
#[derive(Clone, Debug, Default)]
struct Skins {
    /// Facets of eight triangles each, and the range of each group.
    facets: Vec<WideFacet>,
    of_group: Vec<Range<usize>>,
    /// Row in `bodies` of the body that each triangle belongs to; `NONE` of others.
    owners: Vec<u32>,
    /// Particles of such bodies in triangles that belong to no single body: wind acts on these one by one.
    shared: Vec<u32>,
    /// Revision of the list of triangles that they were laid out for; `None` if bodies have changed since.
    revision: Option<u64>,
}

/// A triangle of each of eight bodies.
#[derive(Clone, Copy, Debug, Default)]
struct WideFacet {
    /// Numbers of the triangles; arbitrary, with zero area, in lanes without one.
    numbers: [u32; LANES],
    /// Middle of its corners in the body's own frame, metres, and its area vector, m².
    middle: [LaneArray; 3],
    area: [LaneArray; 3],
}

/// Forces on rigid states in a substep of `h` seconds.
pub(super) struct Acting<'a> {
    pub(super) particles: &'a Particles,
    pub(super) pressures: &'a Pressures,
    pub(super) h: f32,
}

impl RigidForces {
    /// Lays out the surface triangles of bodies that may be rigid states, if triangles or bodies have changed. `islands` is by body collider.
    pub(super) fn find_skins(
        &mut self,
        groups: &BodyGroups,
        islands: &[u32],
        body_colliders: &[BodyCollider],
        surfaces: &Tracked<Vec<[u32; 3]>>,
    ) {
        if self.skins.revision != Some(surfaces.revision()) {
            self.skins.lay_out(groups, islands, body_colliders, surfaces);
            self.skins.revision = Some(surfaces.revision());
        }
    }

    /// Makes the next call lay them out again, because bodies have changed.
    pub(super) fn forget_skins(&mut self) {
        self.skins.revision = None;
    }

    /// Begins a step: forces act on single particles of all rigid states, or of none so far.
    pub(super) fn begin(&mut self, groups: usize, all: bool) {
        self.forced.clear();
        self.forced.resize(groups, if all { u32::MAX } else { 0 });
        self.windy.clear();
        self.windy.resize(groups, 0);
    }

    /// Marks a row of `bodies` as one with forces on single particles.
    pub(super) fn force(&mut self, place: usize) {
        if let Some(bits) = self.forced.get_mut(place / LANES) {
            *bits |= 1 << (place % LANES);
        }
    }

    /// Particles of bodies on which wind acts one by one.
    pub(super) fn shared(&self) -> &[u32] {
        &self.skins.shared
    }

    /// Marks the rigid states with wind on their surface triangles. Appends to `others` the triangles that belong to particles that move by themselves.
    pub(super) fn press_on(
        &mut self,
        states: &[WideRigidState],
        asleep: &[u32],
        pressures: &Pressures,
        others: &mut Vec<Range<usize>>,
    ) {
        let Self { forced, windy, skins, .. } = self;
        let rests = |place: usize| {
            let (group, lane) = (place / LANES, place % LANES);
            let state = states.get(group).map_or(0, |state| state.lanes);
            (state & !forced[group] | asleep[group]) >> lane & 1 == 1
        };
        let mut next = 0;
        for (number, &owner) in skins.owners.iter().enumerate() {
            if owner != NONE && rests(owner as usize) {
                if pressures.acts_on(number) {
                    windy[owner as usize / LANES] |= 1 << (owner as usize % LANES);
                }
                if next < number {
                    others.push(next..number);
                }
                next = number + 1;
            }
        }
        if next < skins.owners.len() {
            others.push(next..skins.owners.len());
        }
    }

    /// Whether the particles of a row of `bodies` are accelerated one by one.
    pub(super) fn is_forced(&self, place: usize) -> bool {
        let bits = |of: &[u32]| of.get(place / LANES).copied().unwrap_or(0);
        (bits(&self.forced) | bits(&self.windy)) >> (place % LANES) & 1 == 1
    }

    /// The sums of forces on one group, if there are any.
    pub(super) fn sum(
        &mut self,
        number: usize,
        (mass, slots): (&WideMass, &[Slot]),
        state: &WideRigidState,
        Acting { particles, pressures, h }: Acting,
        instructions: InstructionSet,
    ) -> Option<&ForceSums> {
        let Self { forced, windy, skins, sums, changes } = self;
        let of = |bits: &[u32]| bits.get(number).map_or(0, |bits| bits & state.lanes);
        let uneven = particles.acceleration_dirty || particles.medium_dirty;
        let forced = if uneven { of(forced) } else { 0 };
        let windy = of(windy) & !forced;
        if forced | windy == 0 {
            return None;
        }
        *sums = ForceSums { forced, ..ForceSums::default() };
        if forced != 0 {
            changes.clear();
            changes.extend(slots.iter().map(|slot| changes_of(particles, &slot.rows, forced, h)));
            sum_forces(mass, slots, state, changes, sums, instructions);
        }
        if windy != 0 {
            let facets = &skins.facets[skins.of_group[number].clone()];
            press(mass, state, facets, pressures, windy, h, sums, instructions);
        }
        Some(sums)
    }
}

impl Skins {
    fn lay_out(
        &mut self,
        groups: &BodyGroups,
        islands: &[u32],
        body_colliders: &[BodyCollider],
        surfaces: &[[u32; 3]],
    ) {
        let Self { facets, of_group, owners, shared, .. } = self;
        facets.clear();
        of_group.clear();
        owners.clear();
        shared.clear();
        // For each row its body, as a row of `bodies`, and its rest position.
        let len = groups.solid.len();
        let mut places = vec![(NONE, Vec3::ZERO); len];
        for (number, solid) in body_colliders.iter().enumerate() {
            if islands.get(number).is_none_or(|&island| island == NONE) {
                continue;
            }
            let place = groups.place(number) as u32;
            for (&row, &rest) in solid.rows.iter().zip(&*solid.rest) {
                places[row as usize] = (place, rest);
            }
        }
        let of = |row: u32| places.get(row as usize).copied().unwrap_or((NONE, Vec3::ZERO));
        let mut own = vec![Vec::new(); groups.groups.len() * LANES];
        for (number, corners) in surfaces.iter().enumerate() {
            let [a, b, c] = corners.map(of);
            let owner = if a.0 == b.0 && a.0 == c.0 { a.0 } else { NONE };
            owners.push(owner);
            if owner == NONE {
                shared.extend(corners.iter().filter(|&&row| of(row).0 != NONE));
                continue;
            }
            let middle = (a.1 + b.1 + c.1) / 3.0;
            let area = (b.1 - a.1).cross(c.1 - a.1) * 0.5;
            own[owner as usize].push((number as u32, middle, area));
        }
        for eight in own.chunks(LANES) {
            let (first, most) = (facets.len(), eight.iter().map(Vec::len).max().unwrap_or(0));
            facets.resize(first + most, WideFacet::default());
            for (lane, own) in eight.iter().enumerate() {
                for (facet, &(number, middle, area)) in facets[first..].iter_mut().zip(own) {
                    facet.numbers[lane] = number;
                    set(&mut facet.middle, lane, middle);
                    set(&mut facet.area, lane, area);
                }
            }
            of_group.push(first..facets.len());
        }
    }
}

/// Velocity changes of eight particles in a substep of `h` seconds by forces and damping that differ between particles, m/s, as in `integrate`; zero in lanes
/// not in `forced`.
fn changes_of(particles: &Particles, rows: &[u32; LANES], forced: u32, h: f32) -> [Vec4; LANES] {
    let mut last = (0.0, 0.0);
    let mut changes = [Vec4::ZERO; LANES];
    for lane in (0..LANES).filter(|lane| forced >> lane & 1 == 1) {
        let i = rows[lane] as usize;
        let (velocity, rate) = (particles.velocity[i], particles.rate(i));
        let tau = (velocity.w + h) * 0.5;
        let exponent = if tau > 0.0 { rate * tau } else { 0.0 };
        if exponent != last.0 {
            last = (exponent, loss(exponent));
        }
        let slip = match particles.drift.get(i) {
            Some(&drift) if drift != Vec3::ZERO => velocity.truncate() - drift / rate,
            _ => velocity.truncate(),
        };
        let own = if particles.acceleration_dirty {
            particles.acceleration[i].truncate()
        } else {
            Vec3::ZERO
        };
        changes[lane] = (own * tau - slip * last.1).extend(0.0);
    }
    changes
}

kernel!(
    /// Sums up the accelerations and damping losses of the particles of eight states in a substep of `h` seconds.
    fn sum_forces<L: Lanes>(
        mass: &WideMass,
        slots: &[Slot],
        state: &WideRigidState,
        // Velocity change of each particle of each slot, m/s.
        changes: &[[Vec4; LANES]],
        sums: &mut ForceSums,
    ) {
        let r = Rotation::<L>::load(&state.rotation).matrix();
        let (mut velocity, mut momentum) = (zero::<L>(), zero::<L>());
        for (slot, changes) in slots.iter().zip(changes) {
            let (change, _) = Vector::of(L::run(changes, 0));
            let gained = change * L::load(&slot.pull);
            velocity += gained;
            momentum += r.times(load(&slot.rest)).cross(gained);
        }
        store(velocity * L::load(&mass.inverse_mass), &mut sums.velocity);
        store(momentum, &mut sums.momentum);
    }
);

kernel!(
    /// Adds the wind on the surface triangles of some of eight states in a substep of `h` seconds.
    fn press<L: Lanes>(
        mass: &WideMass,
        state: &WideRigidState,
        facets: &[WideFacet],
        pressures: &Pressures,
        windy: u32,
        h: f32,
        sums: &mut ForceSums,
    ) {
        let r = Rotation::<L>::load(&state.rotation).matrix();
        let (mut force, mut torque) = (zero::<L>(), zero::<L>());
        for wind in pressures.winds() {
            for facet in facets {
                // The second value is a sixth of one by the strength of the wind.
                let (w, sixth) = wind.of::<L>(&facet.numbers);
                let w = r.transposed_times_vector(w);
                let facing = load::<L>(&facet.area).dot(w).abs();
                let push = w * (facing * sixth * L::splat(6.0));
                force += push;
                torque += load::<L>(&facet.middle).cross(push);
            }
        }
        torque -= load::<L>(&mass.centre).cross(force);
        let lanes = L::mask(windy);
        let tau = lanes.and((L::load(&state.lag) + L::splat(h)) * L::splat(0.5));
        let velocity = r.times(force) * (L::load(&mass.inverse_mass) * tau);
        store(load::<L>(&sums.velocity) + velocity, &mut sums.velocity);
        store(load::<L>(&sums.momentum) + r.times(torque) * tau, &mut sums.momentum);
    }
);
