//! Pressed cloth: where a shape of another body presses on large cloth, contacts and rods take turns.
//!
//! A particle of cloth weighs next to nothing beside a crate. A contact between the two moves the particle, and hardly the crate: it brakes that by as much
//! as one particle weighs, however taut the cloth is, for it knows of no rods. Those pull the particle back in the next substep, and the crate pushes
//! it out again. So a crate of mass `M` on particles of mass `m` in all is stopped by taut cloth within some `M/m` substeps, and meanwhile stretches it by
//! as far as it goes. More sweeps of the rods are no help, for the contacts have the last word; what counts is how often the two change places. (That is Gauss and
//! Seidel's way with a large mass on small ones, which converges by `1 - m/M` in a turn.)
//!
//! So contacts of particles with shapes have several turns in a substep, and in between what they have moved is held: to its pins, by its
//! [tethers](super::tethers), and by the rods about it that are off by more than [strain limiting](super::strain_limit) lets them, for a few rings of rods. That is as much as
//! is felt of a push, and a small share of a sweep. It moves positions before velocities are derived: it is solving, and keeps momentum as rods do.

use super::context::SolveContext;
use super::strain_limit::StrainScratch;
use crate::collide::{NormalImpulse, NormalImpulses};
use crate::particles::{Particles, Places};

/// Over so many rings of rods about what was pressed on a push is handed on in one turn. By 1, 2 and 4 the worst thread under the crate of `TURNS` (`body_contact`) is
/// stretched to 2.0, 1.9 and 1.9 times its length (in 1.94, 2.03 and 2.30 ms a tick), and cloth on nine crates at rest by 7.1, 5.8 and 5.6 %.
const RINGS: usize = 2;

/// Holds large cloth by its rods and tethers where the particles of some rows were pressed on; returns whether that moved any. Puts the rows in order.
pub(crate) fn hold_pressed(
    particles: &mut Particles,
    normal_impulses: &mut [NormalImpulse],
    context: SolveContext,
    pressed: &mut Vec<u32>,
    strain: &mut StrainScratch,
) -> bool {
    let SolveContext { plan, contacts, .. } = context;
    pressed.sort_unstable();
    pressed.dedup();
    let mut any = false;
    let number_of = |row: u32| plan.islands.of[row as usize] as usize;
    for rows in pressed.chunk_by(|&one, &next| number_of(one) == number_of(next)) {
        let island = &plan.islands.list[number_of(rows[0])];
        if !island.takes_microsteps() {
            continue;
        }
        let (graph, run) = (plan.tethers.graph_of(island), plan.stretch(island));
        let (Some(graph), Some(run)) = (graph, run) else { continue };
        let first = run.start as u32;
        let members = rows.iter().map(|row| row - first);
        let position = &mut particles.position[run];
        if let Some(tethers) = plan.tethers.of(island) {
            for member in members.clone() {
                any |= tethers.hold_member(member as usize, position, first);
            }
        }
        let moved = strain.limit_about(graph, position, members, RINGS);
        any |= !moved.is_empty();
        // What stands has the last word: who was held is pressed on again.
        let (mut places, interval) = (Places::all(particles), context.interval());
        let mut normal_impulses = NormalImpulses::all(normal_impulses);
        let moved = rows.iter().copied().chain(moved.iter().map(|member| member + first));
        contacts.project_rows(&mut places, &mut normal_impulses, moved, interval);
    }
    any
}
