//! The lectures' friction between body colliders, after restitution: while two touch, a share of their velocity along and across each other is lost
//! in each second ([`PlanarDrag`]).
//!
//! What is dragged is what goes past at the centre of the pressure, `v`, by an impulse there of the mass that the two would have as points, so that a
//! box that slides on a plane slows down as `v (1 - along)^t`:
//!
//! ```text
//! J = -s v / (1/M_a + 1/M_b)        s = 1 - (1 - drag)^h
//! ```
//!
//! of each of the two parts of `v`, and the same of how they spin on each other about the normal. It is equal and opposite, so momenta are kept; and
//! never more than stops the two there.

use glam::Vec3;

use super::bodies::{Bodies, SHIFT, TURN};
use super::loose::ScalarBody;
use super::wide_contact::{Contact, WideContact};
use crate::constraints::PlanarDrag;
use crate::lanes::LANES;
use crate::particles::rate_of_drag;

/// A bit for each manifold of a wide contact that pressed and has a drag.
pub(super) fn dragged(wide: &WideContact, contacts: &[Contact]) -> u32 {
    let is_dragged = |lane: usize| {
        let one = contacts.get(wide.number[lane] as usize);
        wide.sum[lane] > 0.0
            && one.is_some_and(|one| one.combined_material.drag != PlanarDrag::default())
    };
    (0..LANES).fold(0, |bits, lane| bits | u32::from(is_dragged(lane)) << lane)
}

/// Drags two that have been read with their velocities, in a substep of `h` seconds.
pub(super) fn drag(
    wide: &WideContact,
    lane: usize,
    contacts: &Contact,
    bodies: &mut Bodies,
    h: f32,
) {
    let [a, b] = [wide.a[lane], wide.b[lane]].map(|row| row as usize);
    let vector = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
    let (n, arm) = (vector(&wide.up), vector(&wide.arm));
    let (one, mut other) = (ScalarBody::of(bodies, a), ScalarBody::of(bodies, b));
    if contacts.geometry.is_some() {
        // What stands was noted with its displacement.
        (other.step, other.spin) = (other.step / h, other.spin / h);
    }
    let lever = arm - (other.centre + vector(&wide.offset) - one.centre);
    let past = one.velocity_at(arm) - other.velocity_at(lever);
    let weights = [a, b].map(|row| bodies[row][SHIFT].w);
    let weight = weights[0] + weights[1];
    let residual = |drag: f32| -libm::expm1f(-rate_of_drag(drag) * h);
    let (along, across) = (
        residual(contacts.combined_material.drag.along),
        residual(contacts.combined_material.drag.across),
    );
    let mut impulse = Vec3::ZERO;
    let normal = n * past.dot(n);
    for (part, share) in [(past - normal, along), (normal, across)] {
        let Some(way) = part.try_normalize() else { continue };
        let (here, there) = (arm.cross(way), lever.cross(way));
        let stiff = weight + here.dot(one.spun(here)) + there.dot(other.spun(there));
        impulse -= part * (share / weight).min(1.0 / stiff);
    }
    let spin = n.dot(one.spin + one.turn - other.spin - other.turn);
    let moment = n * (-along * spin / n.dot(one.spun(n) + other.spun(n)).max(f32::MIN_POSITIVE));
    let turns = [one.spun(arm.cross(impulse) + moment), other.spun(lever.cross(impulse) + moment)];
    if !(impulse.is_finite() && turns[0].is_finite() && turns[1].is_finite()) {
        return;
    }
    for (row, weight, turn, sign) in
        [(a, weights[0], turns[0], 1.0), (b, weights[1], turns[1], -1.0)]
    {
        bodies[row][SHIFT] += (impulse * (weight * sign)).extend(0.0);
        bodies[row][TURN] += (turn * sign).extend(0.0);
    }
}
