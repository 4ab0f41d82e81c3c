//! The particles as columns (structure of arrays): one array per quantity, so that a phase reads and writes only what it needs.
//!
//! Memory layout of one particle, hot columns first:
//!
//! ```text
//! position      [x y z w]   16 B   metres from the origin; w = inverse mass, 1/kg: what a constraint reads and writes
//! origin        [x y z]     12 B   whole metres: what `position` is relative to, the same for all particles of an island
//! start         [x y z w]   16 B   the same at the start of the substep
//! velocity      [x y z l]   16 B   mean velocity of the last substep, m/s; l = its length, s (see below)
//! rounding      [x y z 0]   16 B   what rounding took from the velocity when it last changed, m/s: added to the next change
//! acceleration  [x y z 0]   16 B   sum of the forces so far this substep, times the inverse mass, less what all share, m/s²
//! external      [x y z]     12 B   the game's own force on the particle, N
//! radius, charge, damping   12 B   m, C, 1/s
//! gravity scale              4 B
//! medium                     4 B   damping that fluids and balls in the air add this substep, 1/s
//! drift         [x y z]     12 B   that damping times the velocity of the medium, m/s²: where it drags the particle to; empty while nothing flows
//! body                       4 B   which of the simulation's bodies it belongs to
//! rest        [x y z]       12 B   where it is in its body's rest shape, for contacts of the body with itself; empty while none has a place
//! ```
//!
//! # Why positions are relative to an origin of their own
//!
//! At 5 km from zero, neighbouring `f32` values are 0.5 mm apart, and a body at rest trembles or tilts. So a position is stored as an origin in whole metres
//! and an offset from it that keeps its digits; the particles of an island share the origin, which follows them when a step begins. A scene moved by whole
//! metres then runs bit for bit as it does at zero. Constraints work on the offsets alone; positions of different islands are compared by
//! [`Particles::separation`], and with a point of the world by [`Particles::relative_to`].
//!
//! # Why the previous position is kept as a velocity
//!
//! Verlet's state is `(p, p_old)`. This crate keeps the same state as `(p, v, l)` with `v = (p - p_old) / l`, where `l`
//! is the length of the substep that led from `p_old` to `p`. Nothing is lost, and three things are gained:
//!
//! - **Round-off.** In `f32` the difference of two positions 5 m from the origin is good to 5e-7 m, which is 7 % of what gravity adds in a substep of 1/1200 s.
//!   The velocity keeps its own 24 bits wherever the particle is.
//! - **The start.** A particle that is given a velocity has `l = 0`: the velocity is true *now*, not half a substep ago. The time-corrected formula of
//!   [`integrate`](crate::integrate) then starts it on the exact parabola.
//! - **Step changes.** `l` is stored with the particle, so the step may change at any tick, for any particle.

mod bulk;
mod edit;
#[cfg(test)]
mod edit_tests;
mod places;
mod rate;
mod seed;
mod sums;
mod total_mass;

pub use bulk::ParticleState;
pub use rate::{drag_of_rate, rate_of_drag};
pub use seed::{ParticleFault, ParticleSeed};

pub(crate) use places::{Places, ground};
pub(crate) use sums::ColumnSummary;
pub(crate) use total_mass::TotalMass;

use glam::{Vec3, Vec4};

use crate::tracked::Revision;

/// All particles of a simulation, in columns. Rows are numbered from 0 in the order of [`push`](Self::push).
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// `[x y z w]`: position in metres from the origin and inverse mass in 1/kg. The kernels of the constraints work on this alone.
    pub(crate) position: Vec<Vec4>,
    /// Origin that `position` and `start` are relative to, whole metres.
    pub(crate) origin: Vec<Vec3>,
    pub(crate) start: Vec<Vec4>,
    /// `[x y z l]`: mean velocity of the last substep in m/s, and that substep's length in seconds.
    pub(crate) velocity: Vec<Vec4>,
    pub(crate) rounding: Vec<Vec4>,
    pub(crate) acceleration: Vec<Vec4>,
    /// Whether `acceleration` was written to in this substep; otherwise it is all zeros.
    pub(crate) acceleration_dirty: bool,
    /// Acceleration that all particles that are not pinned have in addition, m/s².
    pub(crate) uniform_acceleration: Vec3,
    pub(crate) external: Vec<Vec3>,
    pub(crate) radius: Vec<f32>,
    pub(crate) charge: Vec<f32>,
    pub(crate) damping: Vec<f32>,
    pub(crate) gravity_scale: Vec<f32>,
    pub(crate) medium: Vec<f32>,
    /// Whether `medium` was written to in this substep; otherwise it is all zeros.
    pub(crate) medium_dirty: bool,
    /// Damping that all particles have in addition, 1/s.
    pub(crate) uniform_damping: f32,
    pub(crate) drift: Vec<Vec3>,
    pub(crate) body: Vec<u32>,
    /// Position of each particle in its body's rest shape, metres; NaN for one without. Empty while none has one.
    pub(crate) rest: Vec<Vec3>,
    /// Revision returned by [`edits`](Self::edits).
    edits: Revision,
    /// Count returned by [`writes`](Self::writes).
    writes: u64,
    pub(crate) column_summary: ColumnSummary,
    /// Whether rows moved by the caller are recorded, and those rows in order.
    records_edits: bool,
    moved: Vec<u32>,
    /// Rows that the caller applied forces or media to, recorded likewise.
    pushed: Vec<u32>,
    /// Whether any body sleeps; rows to wake in the next step, and rows written to by the caller meanwhile.
    sleepers: bool,
    woken: Vec<u32>,
    touched: Vec<u32>,
}

/// Most written rows that are listed: a game may add a force to every particle in each substep.
const MAX_TOUCHED: usize = 4096;

/// Body of a particle that belongs to none.
pub(crate) const NO_BODY: u32 = u32::MAX;

impl Particles {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Removes all particles and keeps the memory.
    pub fn clear(&mut self) {
        self.resize(0);
    }

    /// Adds a particle and returns its row.
    ///
    /// # Errors
    /// A seed with a [fault](ParticleSeed::fault) is refused and nothing changes.
    pub fn push(&mut self, seed: ParticleSeed) -> Result<u32, ParticleFault> {
        if let Some(fault) = seed.fault() {
            return Err(fault);
        }
        let row = self.len();
        self.resize(row + 1);
        self.write(row, &seed);
        Ok(row as u32)
    }

    /// Overwrites row `i`, clears its external force, and removes it from its body.
    ///
    /// # Errors
    /// A seed with a [fault](ParticleSeed::fault) is refused and nothing changes.
    ///
    /// # Panics
    /// If there is no row `i`.
    pub fn set(&mut self, i: usize, seed: ParticleSeed) -> Result<(), ParticleFault> {
        if let Some(fault) = seed.fault() {
            return Err(fault);
        }
        self.write(i, &seed);
        self.note_edit();
        self.external[i] = Vec3::ZERO;
        Ok(())
    }

    /// Resizes to exactly `len` particles. New rows are pinned particles at the origin.
    pub fn resize(&mut self, len: usize) {
        self.note_edit();
        if len < self.len() {
            // The recorded rows may soon hold other particles.
            self.record_edits(false);
            self.note_sleepers(false);
        }
        self.position.resize(len, Vec4::ZERO);
        self.origin.resize(len, Vec3::ZERO);
        self.start.resize(len, Vec4::ZERO);
        self.velocity.resize(len, Vec4::ZERO);
        self.rounding.resize(len, Vec4::ZERO);
        self.acceleration.resize(len, Vec4::ZERO);
        self.external.resize(len, Vec3::ZERO);
        self.radius.resize(len, 0.0);
        self.charge.resize(len, 0.0);
        self.damping.resize(len, 0.0);
        self.gravity_scale.resize(len, 1.0);
        self.medium.resize(len, 0.0);
        self.drift.clear();
        self.forget_summary();
        self.body.resize(len, NO_BODY);
        if !self.rest.is_empty() {
            self.rest.resize(len, Vec3::NAN);
        }
    }

    /// Position of particle `i`, metres, rounded to `f32`.
    #[inline]
    pub fn position(&self, i: usize) -> Vec3 {
        self.origin[i] + self.position[i].truncate()
    }

    /// What [`position`](Self::position) leaves out, metres: the sum of the two is the particle's exact position.
    pub fn remainder(&self, i: usize) -> Vec3 {
        bulk::exact_sum(self.origin[i], self.position[i]).1.truncate()
    }

    /// `p_a - p_b`, metres, from their local positions: accurate to 1e-7 of the distance however far out both are.
    #[inline]
    pub fn separation(&self, a: usize, b: usize) -> Vec3 {
        let local = self.position[a].truncate() - self.position[b].truncate();
        local + (self.origin[a] - self.origin[b])
    }

    /// `p_i - point`, metres, for a point of the world.
    #[inline]
    pub fn relative_to(&self, i: usize, point: Vec3) -> Vec3 {
        (self.origin[i] - point) + self.position[i].truncate()
    }

    /// `normal · p_i - offset`, metres: height of particle `i` above a plane in world coordinates.
    #[inline]
    pub fn height(&self, i: usize, normal: Vec3, offset: f32) -> f32 {
        places::height(self.origin[i], self.position[i], normal, offset)
    }

    /// Moves particle `i` to a point, in metres, and keeps its velocity: a teleport, or (between the phases `integrate` and `solve_constraints`) a positional
    /// constraint of the caller's own.
    pub fn set_position(&mut self, i: usize, position: Vec3) {
        let local = position - self.origin[i];
        self.position[i] = local.extend(self.position[i].w);
        self.note_moved(i);
        self.wake(i);
    }

    /// Moves particle `i` by `displacement`, metres, and keeps its velocity.
    pub fn displace(&mut self, i: usize, displacement: Vec3) {
        self.position[i] += displacement.extend(0.0);
        self.note_moved(i);
        self.wake(i);
    }

    /// Position of particle `i` at the start of the current substep, metres.
    pub fn start(&self, i: usize) -> Vec3 {
        self.origin[i] + self.start[i].truncate()
    }

    /// Mean velocity of particle `i` over the last substep, m/s, true half a substep ago. [`Simulation::velocity_now`](crate::Simulation::velocity_now) returns
    /// the velocity at the instant of the position.
    #[inline]
    pub fn velocity(&self, i: usize) -> Vec3 {
        self.velocity[i].truncate()
    }

    /// Velocity of particle `i` at the instant of its position, m/s, under the summed forces alone. It depends only on saved state, and so does what is
    /// computed from it.
    #[inline]
    pub(crate) fn free_velocity_now(&self, i: usize) -> Vec3 {
        self.velocity(i) + self.acceleration(i) * (0.5 * self.lag(i))
    }

    /// Length in seconds of the substep over which [`velocity`](Self::velocity) is the mean; 0 for a velocity that was set.
    #[inline]
    pub fn lag(&self, i: usize) -> f32 {
        self.velocity[i].w
    }

    /// Sets the velocity of particle `i`, m/s, true at this instant.
    pub fn set_velocity(&mut self, i: usize, velocity: Vec3) {
        self.velocity[i] = velocity.extend(0.0);
        self.rounding[i] = Vec4::ZERO;
        self.note_moved(i);
    }

    /// [`displace`](Self::displace) and [`set_velocity`](Self::set_velocity) for the step itself: wakes nothing.
    pub(crate) fn put(&mut self, i: usize, displacement: Vec3, velocity: Vec3) {
        self.position[i] += displacement.extend(0.0);
        self.velocity[i] = velocity.extend(0.0);
        self.rounding[i] = Vec4::ZERO;
    }

    /// Adds an impulse, N·s: the momentum of the particle changes by exactly that. Pinned particles are not affected.
    pub fn add_impulse(&mut self, i: usize, impulse: Vec3) {
        let change = impulse * self.position[i].w;
        self.velocity[i] += change.extend(0.0);
        self.note_moved(i);
    }

    /// Starts or stops recording rows that are moved or given a velocity, and clears the record.
    pub(crate) fn record_edits(&mut self, on: bool) {
        self.records_edits = on;
        self.moved.clear();
        self.pushed.clear();
    }

    /// Removes one row from the record of moved rows, and returns it.
    pub(crate) fn pop_moved(&mut self) -> Option<u32> {
        self.moved.pop()
    }

    /// The same for rows that forces or media were added to.
    pub(crate) fn pop_pushed(&mut self) -> Option<u32> {
        self.pushed.pop()
    }

    /// Keeps what particle `i` belongs to awake in the next step. For callers that add forces between two phases, which do not act on a sleeper.
    pub fn wake(&mut self, i: usize) {
        self.note_write(i);
        if self.sleepers && self.woken.last() != Some(&(i as u32)) {
            self.woken.push(i as u32);
        }
    }

    /// Rows to wake in the next step.
    pub(crate) fn woken(&self) -> &[u32] {
        &self.woken
    }

    /// Rows that the caller wrote to, as counted by [`writes`](Self::writes), since [`note_sleepers`](Self::note_sleepers) was last called; recorded only while
    /// something sleeps. `None` if there are more than are listed.
    pub(crate) fn touched(&self) -> Option<&[u32]> {
        (self.touched.len() < MAX_TOUCHED).then_some(&self.touched)
    }

    /// Notes whether any body sleeps in this step, and clears the rows to wake and the rows written to.
    pub(crate) fn note_sleepers(&mut self, any: bool) {
        self.sleepers = any;
        self.woken.clear();
        self.touched.clear();
    }

    /// Counts of the caller's writes: to properties, and to state or forces. If they are unchanged, so are all rows, except those that were
    /// [loaded](Self::load).
    pub(crate) fn writes(&self) -> [u64; 2] {
        [self.edits(), self.writes]
    }

    #[inline]
    fn note_write(&mut self, i: usize) {
        self.writes = self.writes.wrapping_add(1);
        let is_listed =
            self.touched.last() == Some(&(i as u32)) || self.touched.len() == MAX_TOUCHED;
        if self.sleepers && !is_listed {
            self.touched.push(i as u32);
        }
    }

    #[inline]
    pub(super) fn note_moved(&mut self, i: usize) {
        self.note_write(i);
        if self.records_edits {
            self.moved.push(i as u32);
        }
    }

    #[inline]
    fn note_pushed(&mut self, i: usize) {
        if self.records_edits && self.pushed.last() != Some(&(i as u32)) {
            self.pushed.push(i as u32);
        }
    }

    /// Inverse mass of particle `i`, 1/kg; 0 if it is pinned.
    pub fn inverse_mass(&self, i: usize) -> f32 {
        self.position[i].w
    }

    /// Mass of particle `i`, kg; infinite if it is pinned.
    pub fn mass(&self, i: usize) -> f32 {
        1.0 / self.position[i].w
    }

    /// Radius of particle `i`, metres.
    pub fn radius(&self, i: usize) -> f32 {
        self.radius[i]
    }

    /// Electric charge of particle `i`, coulombs.
    pub fn charge(&self, i: usize) -> f32 {
        self.charge[i]
    }

    /// Sets the external force on particle `i`, N, which acts in every substep until it is set again.
    pub fn set_external_force(&mut self, i: usize, force: Vec3) {
        self.note_edit();
        self.external[i] = force;
        self.note_nonuniform(i);
    }

    /// Multiple of the world's gravity that acts on particle `i`. 1 by default.
    pub fn gravity_scale(&self, i: usize) -> f32 {
        self.gravity_scale[i]
    }

    /// Sets the multiple of the world's gravity that acts on particle `i`; a non-finite value is ignored.
    pub fn set_gravity_scale(&mut self, i: usize, scale: f32) {
        if scale.is_finite() && scale != self.gravity_scale[i] {
            self.note_edit();
            self.gravity_scale[i] = scale;
            self.note_nonuniform(i);
        }
    }

    /// Multiplies the [gravity scale](Self::set_gravity_scale) of particle `i` by a factor; a non-finite factor is ignored.
    pub fn scale_gravity(&mut self, i: usize, factor: f32) {
        self.set_gravity_scale(i, self.gravity_scale[i] * factor);
    }

    /// Assigns particle `i` to one of the simulation's [bodies](crate::Simulation::bodies), by index; `None`, the default, for no body.
    pub fn set_body(&mut self, i: usize, body: Option<u32>) {
        self.note_edit();
        self.body[i] = body.unwrap_or(NO_BODY);
    }

    /// The body that particle `i` belongs to.
    pub fn body(&self, i: usize) -> Option<u32> {
        (self.body[i] != NO_BODY).then_some(self.body[i])
    }

    /// Whether row `i` holds only finite numbers.
    pub fn is_finite(&self, i: usize) -> bool {
        // Also of the parts: both may be finite while their sum is not.
        self.position(i).is_finite() && self.position[i].is_finite() && self.velocity[i].is_finite()
    }

    /// Row `i` as a seed: the state that a caller must save to restore the particle.
    pub fn seed(&self, i: usize) -> ParticleSeed {
        ParticleSeed {
            position: self.position(i),
            remainder: self.remainder(i),
            velocity: self.velocity(i),
            lag: self.lag(i),
            mass: self.mass(i),
            radius: self.radius[i],
            charge: self.charge[i],
            drag: drag_of_rate(self.damping[i]),
            gravity_scale: self.gravity_scale[i],
        }
    }

    fn write(&mut self, i: usize, seed: &ParticleSeed) {
        let (origin, local) = bulk::place(seed.position, seed.remainder);
        self.origin[i] = origin;
        self.position[i] = local.extend(1.0 / seed.mass);
        self.note_moved(i);
        self.start[i] = self.position[i];
        self.velocity[i] = seed.velocity.extend(seed.lag);
        self.rounding[i] = Vec4::ZERO;
        self.radius[i] = seed.radius;
        self.charge[i] = seed.charge;
        self.gravity_scale[i] = seed.gravity_scale;
        self.forget_summary();
        self.note_nonuniform(i);
        self.body[i] = NO_BODY;
        if let Some(rest) = self.rest.get_mut(i) {
            *rest = Vec3::NAN;
        }
        // Most particles have no drag, and a logarithm in each tick would be the most expensive part of a row.
        self.damping[i] = if seed.drag > 0.0 { rate_of_drag(seed.drag) } else { 0.0 };
    }
}

/// The whole metres nearest to a position. Halves round up, on either side of zero, so that a scene moved by whole metres is snapped in the same way.
#[inline]
pub(crate) fn snap(position: Vec3) -> Vec3 {
    let half_up = position + 0.5;
    if half_up.abs().cmplt(Vec3::splat(WHOLE)).all() {
        // Inlined, instead of a call to the library's `floor`.
        let floor = |x: f32| {
            let whole = x as i32 as f32;
            if whole > x { whole - 1.0 } else { whole }
        };
        return Vec3::new(floor(half_up.x), floor(half_up.y), floor(half_up.z));
    }
    half_up.floor()
}

/// From here on every `f32` is a whole number: 2²³ metres.
const WHOLE: f32 = 8_388_608.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_faulty_seed_is_refused_and_changes_nothing() {
        let good = ParticleSeed::at(Vec3::X);
        let bad = [
            (ParticleSeed::at(Vec3::NAN), ParticleFault::Position),
            (good.with_velocity(Vec3::INFINITY), ParticleFault::Velocity),
            (good.with_mass(-1.0), ParticleFault::Mass),
            (good.with_mass(0.0), ParticleFault::Mass),
            (good.with_mass(f32::NAN), ParticleFault::Mass),
            (good.with_mass(1e-45), ParticleFault::Mass),
            (good.with_radius(-0.1), ParticleFault::Radius),
            (good.with_charge(f32::NAN), ParticleFault::Charge),
            (good.with_drag(1.5), ParticleFault::Drag),
        ];
        let mut particles = Particles::default();
        for (seed, fault) in bad {
            assert_eq!(particles.push(seed), Err(fault), "{seed:?}");
        }
        assert!(particles.is_empty());
        assert_eq!(particles.push(good), Ok(0));
        assert_eq!(particles.set(0, bad[0].0), Err(ParticleFault::Position));
        assert_eq!(particles.seed(0), good);
    }

    #[test]
    fn an_impulse_changes_momentum_by_exactly_itself() {
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::ZERO).with_mass(4.0)).unwrap();
        particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).unwrap();
        let impulse = Vec3::new(2.0, -1.0, 0.5);
        particles.add_impulse(0, impulse);
        particles.add_impulse(1, impulse);
        assert_eq!(particles.velocity(0) * 4.0, impulse);
        assert_eq!(particles.velocity(1), Vec3::ZERO);
    }

    #[test]
    fn a_position_and_its_remainder_are_the_particle_to_the_last_bit() {
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::new(5000.25, -0.5, 1e20))).unwrap();
        let tiny = Vec3::X * 1e-5;
        particles.displace(0, tiny);
        assert_eq!(particles.position(0).x, 5000.25, "too small for f32 out there");
        let mut copy = Particles::default();
        copy.push(particles.seed(0)).unwrap();
        copy.displace(0, -tiny);
        assert!((copy.remainder(0).x).abs() < 1e-7);
        assert_eq!(copy.position(0), Vec3::new(5000.25, -0.5, 1e20));
    }

    #[test]
    fn what_is_snapped_is_the_floor_of_what_is_half_a_metre_farther() {
        let near = [0.0, -0.0, 0.3, 0.5, 0.49999997, 0.50000006, 1.5, 7.25, 1e-20, 1e-42, 999.4999];
        let far = [4_194_303.5, 8_388_607.0, 8_388_607.5, 8_388_608.0, 1.6e7, 3e9, f32::INFINITY];
        for x in near.iter().chain(&far).flat_map(|&x| [x, -x]) {
            let (own, floor) = (snap(Vec3::new(x, 0.0, x)), (x + 0.5).floor());
            assert_eq!([own.x, own.z].map(f32::to_bits), [floor.to_bits(); 2], "{x}");
        }
        assert!(snap(Vec3::new(f32::NAN, 1.0, 1.0)).x.is_nan());
    }

    #[test]
    fn drag_and_rate_are_inverse() {
        for drag in [0.0, 0.015, 0.5, 0.99, 1.0] {
            assert!((drag_of_rate(rate_of_drag(drag)) - drag).abs() < 1e-6);
        }
    }
}
