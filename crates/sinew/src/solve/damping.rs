//! Internal friction of a body: relative motion of its particles is damped, and its rigid motion is kept.
//!
//! A joint without friction never comes to rest: the head of a figure that lies on stairs swings from its neck for minutes, and keeps the whole figure from
//! falling asleep. Air drag would stop that, but would slow every fall too. So the velocities of a body's particles are moved towards those of a rigid body
//! with the same momentum and angular momentum, at the rate `λ` (Müller, Heidelberger, Hennix, Ratcliff, *Position Based Dynamics*, 2007, section 3.5):
//!
//! ```text
//! v ← v + (1 - e^(-λ dt)) (v̄ + ω × (q - q̄) - v)        Σ m v and Σ m q × v stay
//! ```
//!
//! Once a step is enough: the rate is slow compared with the motion within a step.
//!
//! What has come off a body, such as a limb or a torn half, has no friction with the rest of it. So the particles of a body are taken piece by piece, where a
//! piece is what constraints or springs connect. Particles that neither connects to anything are one piece, as what holds them together is not known here.

use core::ops::Range;

use crate::forces::Spring;
use crate::islands::Islands;
use crate::particles::Particles;
use crate::pose::MomentSums;
use crate::settings::BodySettings;
use crate::union_find::UnionFind;

/// Momentum sums of each piece of the bodies with internal friction. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Damping {
    /// Rows by piece, ascending in each.
    runs: Vec<Run>,
    /// Islands that springs join.
    joined: UnionFind,
}

/// Consecutive rows of one piece of a body.
#[derive(Clone, Debug)]
struct Run {
    /// The number of the body, and of the piece.
    piece: (u32, u32),
    rows: Range<usize>,
}

/// The piece of particles that nothing connects.
const LOOSE: u32 = u32::MAX;

impl Damping {
    /// Applies a step of `dt` seconds to the particles that are not pinned.
    pub(crate) fn apply(
        &mut self,
        particles: &mut Particles,
        bodies: &[BodySettings],
        (islands, springs): (&Islands, &[Spring]),
        dt: f32,
    ) {
        let rate = |body: &BodySettings| {
            if body.damping.is_finite() { body.damping.max(0.0) } else { 0.0 }
        };
        if bodies.iter().all(|body| rate(body) == 0.0) {
            return;
        }
        let rate_of = |number: u32| bodies.get(number as usize).map_or(0.0, rate);
        self.find_runs(&particles.body, |number| rate_of(number) > 0.0, (islands, springs));
        let Particles { position, velocity, origin, .. } = particles;
        let separation = |row: usize, first: usize| {
            let local = position[row].truncate() - position[first].truncate();
            (local + (origin[row] - origin[first])).as_dvec3()
        };
        for runs in self.runs.chunk_by(|one, next| one.piece == next.piece) {
            let rows = || runs.iter().flat_map(|run| run.rows.clone());
            let mut free = rows().filter(|&row| position[row].w > 0.0).peekable();
            // Positions are measured relative to the first row.
            let Some(&first) = free.peek() else { continue };
            let mut sums = MomentSums::NONE;
            for row in free {
                let (arm, v) = (separation(row, first), velocity[row].truncate().as_dvec3());
                sums.add(1.0 / f64::from(position[row].w), arm.into(), v.into());
            }
            // Barycentre, metres, its velocity, m/s, and the angular velocity, rad/s.
            let Some([centre, shift, turn]) = sums.rigid_motion(true) else { continue };
            let share = -libm::expm1(-f64::from(rate_of(runs[0].piece.0)) * f64::from(dt));
            for row in rows().filter(|&row| position[row].w > 0.0) {
                let arm = separation(row, first) - centre;
                let change =
                    (shift + turn.cross(arm) - velocity[row].truncate().as_dvec3()) * share;
                velocity[row] += change.as_vec3().extend(0.0);
            }
        }
    }

    /// Lists the rows of the damped bodies, piece by piece.
    fn find_runs(
        &mut self,
        body: &[u32],
        is_damped: impl Fn(u32) -> bool,
        (islands, springs): (&Islands, &[Spring]),
    ) {
        let Self { runs, joined } = self;
        if !springs.is_empty() {
            joined.reset(islands.list.len());
            let island = |row: u32| islands.of.get(row as usize);
            for (a, b) in springs.iter().filter_map(|s| island(s.a).zip(island(s.b))) {
                joined.unite(*a, *b);
            }
        }
        let mut piece = |row: usize| {
            let number = islands.of[row];
            let island = &islands.list[number as usize];
            match springs.is_empty() {
                _ if island.members.len() == 1 && !island.has_springs => LOOSE,
                true => number,
                false => joined.root(number),
            }
        };
        runs.clear();
        let mut begin = 0;
        for own in body.chunk_by(|one, next| one == next) {
            let rows = begin..begin + own.len();
            begin = rows.end;
            for row in if is_damped(own[0]) { rows } else { 0..0 } {
                let piece = (own[0], piece(row));
                match runs.last_mut() {
                    Some(run) if run.piece == piece && run.rows.end == row => run.rows.end += 1,
                    _ => runs.push(Run { piece, rows: row..row + 1 }),
                }
            }
        }
        runs.sort_unstable_by_key(|run| (run.piece, run.rows.start));
    }
}

#[cfg(test)]
mod tests;
