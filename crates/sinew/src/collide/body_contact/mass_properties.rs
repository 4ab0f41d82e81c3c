//! What a body collider weighs: mass, centre, inertia and the pseudo-inverse of that.
//!
//! # Pinned particles
//!
//! A body collider with one pinned particle turns about that: the pin is its centre, and its inverse mass is zero. With two it turns about the line
//! through them: of its inverse inertia is left `e eᵀ / (eᵀ I e)`. With more it is immovable.
//!
//! # Body colliders that are lines
//!
//! Two particles do not say how a body collider is turned about their line, and no impulse turns it that way: the inverse inertia is the
//! pseudo-inverse. When the rotation is extracted, the matrix `K` of Newton's step (see `pose/rotation.rs`) vanishes along the line; a regularisation
//! `top · e eᵀ` keeps it regular and adds nothing to the step, which is across the line. So the twist stays what it was.

use glam::{DVec3, Vec3};

use crate::pose::symmetric;

/// Moments of inertia below this share of the greatest count as zero: thinner than 1 in 300. What is thinner would show the round-off of its
/// particles' positions as a trembling about its line.
pub(super) const LINE: f64 = 1e-5;
/// How many times the mass of all others a pinned particle counts when the pose is read. Its constraints keep a body collider in shape, so any number
/// reads the same pose; a greater one is nearer to the pin while they do not.
const PIN: f64 = 16.0;

/// What a body collider weighs.
pub(super) struct MassProperties {
    pub(super) pins: usize,
    /// Mass of the free particles.
    mass: f64,
    pub(super) centre: DVec3,
    pub(super) middle: f64,
    pub(super) inverse_mass: f64,
    pub(super) inertia: [[f64; 3]; 3],
    pub(super) inverse: [[f64; 3]; 3],
    pub(super) led: [[f64; 3]; 3],
    pub(super) regularisation: [[f64; 3]; 3],
}

impl MassProperties {
    pub(super) fn of(rest: &[Vec3], inverses: &[f32], sharers: &[u32]) -> Self {
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
            middle: 0.0,
            inverse_mass: if pins == 0 { 1.0 / mass } else { 0.0 },
            inertia: Default::default(),
            inverse: Default::default(),
            led: Default::default(),
            regularisation: Default::default(),
        };
        let pull = |i: usize| this.pull(inverses[i], sharers[i]);
        let decides = |i: usize| if pins == 0 || inverses[i] <= 0.0 { pull(i) } else { 0.0 };
        let sum: f64 = (0..rest.len()).map(decides).sum();
        let centre: DVec3 = (0..rest.len()).map(|i| rest[i].as_dvec3() * (decides(i) / sum)).sum();
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
            2 => {
                axis().map_or_else(|| inverse_and_regularisation(inertia).0, |e| about(e, inertia))
            }
            _ => [[0.0; 3]; 3],
        };
        Self { centre, middle: 1.0 / sum, inertia, inverse, led, regularisation, ..this }
    }

    /// What a particle counts when the pose is read, kg.
    pub(super) fn pull(&self, inverse_mass: f32, sharers: u32) -> f64 {
        if inverse_mass > 0.0 {
            1.0 / (f64::from(inverse_mass) * f64::from(sharers))
        } else if self.mass > 0.0 {
            self.mass * PIN
        } else {
            1.0
        }
    }
}

/// `Σ m (r² 1 - r rᵀ)`.
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

/// The pseudo-inverse of an inertia, and what makes it regular.
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

/// The inverse inertia of what can turn about one axis alone.
fn about(e: DVec3, inertia: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
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
