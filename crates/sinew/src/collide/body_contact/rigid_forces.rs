//! Forces on rigid states: which act on their particles one by one, and the pressure of winds on a skin.
//!
//! Where something pulls on single particles of a rigid state (a spring, a control, a force of a game's own), these are written in every substep, so that it finds them where
//! they are, and what it does to them is summed up. All others need no particles until the step ends: gravity and damping are the same for all of a body, and
//! winds are summed up over its triangles in its own axes, where those stand still.
//!
//! # Wind on a triangle of a rigid body
//!
//! With `A` the area of a triangle, a vector across it, and `w` the pressure there, the lectures' law (`forces/wind/pressure.rs` of the crate) gives each corner a third of
//! `F = w |A·w| / ‖w‖`. That is the force `F` at the middle `c` of its corners: the body gains `Σ F` and, about its centre `z`, `Σ (c - z) × F = Σ c × F - z × Σ F`. With `w`
//! turned into its axes, `A` and `c` are numbers that do not change, whatever it weighs.

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

/// What acts on the rigid states of a step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct RigidForces {
    /// A bit for each lane of a group on whose particles something acts one by one in this step, and for each whose skin winds press on.
    pub(super) forced: Vec<u32>,
    pub(super) windy: Vec<u32>,
    skins: Skins,
    sums: ForceSums,
    changes: Vec<[Vec4; LANES]>,
}

/// Triangles of bodies that may be rigid states, in their own axes.
#[derive(Clone, Debug, Default)]
struct Skins {
    /// Eight triangles each, and where those of each group are.
    facets: Vec<WideFacet>,
    of_group: Vec<Range<usize>>,
    /// The row among the bodies of whom each triangle belongs to; `NONE` of others.
    owners: Vec<u32>,
    /// Particles of bodies of triangles that belong to nobody: these are pressed on one by one.
    shared: Vec<u32>,
    /// The number of the list of triangles that they are of; `None` if bodies have changed since.
    revision: Option<u64>,
}

/// A triangle of each of eight bodies.
#[derive(Clone, Copy, Debug, Default)]
struct WideFacet {
    /// Numbers of the triangles; of lanes without one any, and no area.
    numbers: [u32; LANES],
    /// The middle of its corners in the body's own frame, metres, and its area, m², across it.
    middle: [LaneArray; 3],
    area: [LaneArray; 3],
}

/// What acts on rigid states in a substep of `h` seconds.
pub(super) struct Acting<'a> {
    pub(super) particles: &'a Particles,
    pub(super) pressures: &'a Pressures,
    pub(super) h: f32,
}

impl RigidForces {
    /// Lays out the skins of bodies that may be rigid states, of each body collider that is one its island, if triangles or bodies have changed.
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

    /// Has skins be laid out anew: bodies have changed.
    pub(super) fn forget_skins(&mut self) {
        self.skins.revision = None;
    }

    /// Begins a step with so many groups: something acts on the particles of all rigid states one by one, or of none so far.
    pub(super) fn begin(&mut self, groups: usize, all: bool) {
        self.forced.clear();
        self.forced.resize(groups, if all { u32::MAX } else { 0 });
        self.windy.clear();
        self.windy.resize(groups, 0);
    }

    /// Something acts on single particles of what is in a row among the bodies.
    pub(super) fn force(&mut self, place: usize) {
        if let Some(bits) = self.forced.get_mut(place / LANES) {
            *bits |= 1 << (place % LANES);
        }
    }

    /// Particles of bodies that winds press on one by one.
    pub(super) fn shared(&self) -> &[u32] {
        &self.skins.shared
    }

    /// Notes on whose skins such pressures on all triangles press. Appends the triangles to `others` that belong to particles that move by themselves.
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
                if pressures.blow_on(number) {
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

    /// Whether the particles of what is in a row among the bodies are accelerated one by one.
    pub(super) fn is_forced(&self, place: usize) -> bool {
        let bits = |of: &[u32]| of.get(place / LANES).copied().unwrap_or(0);
        (bits(&self.forced) | bits(&self.windy)) >> (place % LANES) & 1 == 1
    }

    /// Those on one group, if there are any.
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
        // Where each row is: whose it is, and where it rests.
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

/// By how much the velocities of some of eight particles change in a substep of `h` seconds by what does not act on all alike, m/s: as `integrate` has it.
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
    /// Sums up what the particles of eight are accelerated by and lose in a substep of `h` seconds.
    fn sum_forces<L: Lanes>(
        mass: &WideMass,
        slots: &[Slot],
        state: &WideRigidState,
        // By how much the velocity of each particle of each slot changes, m/s.
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
    /// Adds what winds do to the skins of some of eight in a substep of `h` seconds.
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
                // With a sixth of one by its strength.
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
