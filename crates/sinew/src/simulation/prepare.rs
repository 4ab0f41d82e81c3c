//! Preparation of a step: plan, origins, settings of islands, checkpoint, broad phase, and the air.

use glam::{Vec3, Vec4};
use smallvec::SmallVec;

use super::{Scratch, Simulation, Substep, contact_world, execution};
use crate::constraints::{Constraint, Distance};
use crate::forces;
use crate::islands::Islands;
use crate::particles::{NO_BODY, Particles, snap};
use crate::rigid::Compound;
use crate::settings::{BodySettings, SolverSettings};
use crate::solve::{Pins, PlanInput, divide, keeps_momenta};

impl Simulation {
    /// Updates the plan to the lists.
    pub(super) fn compile(&mut self) {
        let Self { particles, distances, constraints, compounds, scratch, .. } = self;
        let Scratch { plan, changes, .. } = scratch;
        let particles_came_or_went = plan.rows != particles.len();
        if changes.is_empty() && !particles_came_or_went {
            return;
        }
        let given = PlanInput { distances, constraints, particles: particles.len() };
        if !compounds.is_empty() {
            self.compile_with_compounds();
        } else if changes.are_few() && !particles_came_or_went {
            plan.update(given, changes);
        } else {
            plan.compile_changed(given, changes.same());
        }
        let Self { particles, distances, constraints, body_colliders, scratch, .. } = self;
        let Scratch { changes, contacts, filter, plan, .. } = scratch;
        let given = PlanInput { distances, constraints, particles: particles.len() };
        let body = |row: u32| particles.body.get(row as usize);
        if !changes.are_few() || changes.any_between(given, |a, b| body(a) != body(b)) {
            filter.invalidate_joints();
        }
        if !changes.are_few() || particles_came_or_went {
            contacts.compile(body_colliders, particles);
        }
        contacts.rigid_states().find_rigid_islands(
            body_colliders,
            &plan.islands,
            |solid, island| plan.is_rigid_body_of(solid, island),
        );
        plan.islands.list.iter_mut().for_each(|island| island.has_body_colliders = false);
        for &row in body_colliders.iter().flat_map(|solid| &solid.rows) {
            if let Some(&number) = plan.islands.of.get(row as usize) {
                plan.islands.list[number as usize].has_body_colliders = true;
            }
        }
        changes.clear();
        scratch.settings_inputs = None;
        // They were of the old islands, which may have other numbers now.
        self.report.islands.clear();
        scratch.loads.mark_stale();
        scratch.sleep_scratch.0.forget_support();
    }

    /// Compiles the plan with explicit rigid bodies: each is one shape constraint.
    fn compile_with_compounds(&mut self) {
        let (distances, constraints) = self.outside_compounds();
        let particles = self.particles.len();
        let plan = &mut self.scratch.plan;
        plan.compile(PlanInput { distances: &distances, constraints: &constraints, particles });
        for &row in self.compounds.iter().flat_map(|compound| &compound.rows) {
            if let Some(&island) = plan.islands.of.get(row) {
                plan.islands.list[island as usize].rigid = true;
            }
        }
    }

    /// The lists without constraints among the particles of one compound, which its shape replaces, and with the shapes.
    fn outside_compounds(&self) -> (Vec<Distance>, Vec<Constraint>) {
        let [distances, constraints] = self.numbers_outside_compounds();
        let distances = distances.iter().map(|&i| self.distances[i as usize]).collect();
        let constraints = constraints.iter().map(|&i| self.constraints[i as usize].clone());
        (distances, constraints.chain(self.compounds.iter().map(Compound::shape)).collect())
    }

    /// The indices of the distances and of the constraints that are not among the particles of one compound.
    pub(super) fn numbers_outside_compounds(&self) -> [Vec<u32>; 2] {
        let mut compound_of = vec![usize::MAX; self.particles.len()];
        for (number, compound) in self.compounds.iter().enumerate() {
            for &row in &compound.rows {
                if let Some(slot) = compound_of.get_mut(row) {
                    *slot = number;
                }
            }
        }
        let inside = |rows: &[u32]| {
            let mut owners = rows.iter().map(|&row| compound_of.get(row as usize).copied());
            let first = owners.next().flatten().filter(|&owner| owner != usize::MAX);
            first.is_some() && owners.all(|owner| owner == first)
        };
        let distances = self.distances.iter().zip(0..).filter(|(d, _)| !inside(&[d.a, d.b]));
        let constraints = self.constraints.iter().zip(0..).filter(|(c, _)| !inside(&c.rows));
        [distances.map(|(_, i)| i).collect(), constraints.map(|(_, i)| i).collect()]
    }

    /// Gives all particles of an island one origin near them, as the constraint kernels require.
    pub(super) fn share_origins(&mut self) {
        let Self { particles, scratch: Scratch { plan, checkpoint, anchors, .. }, .. } = self;
        anchors.clear();
        for number in 0..plan.islands.list.len() {
            let island = &plan.islands.list[number];
            let rows =
                || plan.islands.members[island.members.clone()].iter().map(|&row| row as usize);
            let first = rows().find(|&i| particles.is_finite(i));
            // From the local position, which has more digits than the world position far out.
            let Some(first) = first else {
                plan.islands.list[number].one_origin = false;
                continue;
            };
            let origin = particles.origin[first] + snap(particles.position[first].truncate());
            let all = plan.stretch(island).map(|rows| &particles.origin[rows]);
            let mut one_origin = all.is_some_and(|all| all.iter().all(|own| *own == origin));
            if !one_origin {
                one_origin = true;
                for i in rows() {
                    if particles.origin[i] == origin {
                        continue;
                    }
                    let shift = (particles.origin[i] - origin).extend(0.0);
                    // A particle so far off that the difference of the origins overflows keeps its own: no constraint can act over that distance.
                    if !shift.is_finite() {
                        one_origin = false;
                        continue;
                    }
                    let (home, place) = (particles.origin[i], particles.position[i]);
                    particles.origin[i] = origin;
                    particles.position[i] += shift;
                    particles.start[i] += shift;
                    if place.w == 0.0 {
                        let shifted = particles.position[i];
                        anchors.push(PinnedOrigin { row: i, home, place, shifted });
                    }
                    if let Some(good) = checkpoint.get_mut(i) {
                        *good += shift;
                    }
                }
            }
            plan.islands.list[number].one_origin = one_origin;
        }
    }

    /// Restores pinned particles that were not moved to the last bit: relative to the origin of their island they may have been rounded.
    pub(super) fn restore_anchors(&mut self) {
        let Self { particles, scratch: Scratch { anchors, checkpoint, .. }, .. } = self;
        for PinnedOrigin { row, home, place, shifted } in anchors.drain(..) {
            if particles.position[row] == shifted {
                particles.origin[row] = home;
                particles.position[row] = place;
                particles.start[row] = place;
                if let Some(good) = checkpoint.get_mut(row) {
                    *good = place;
                }
            }
        }
    }

    /// Merges the settings of the bodies in each island.
    pub(super) fn merge_settings(&mut self, world: SolverSettings) {
        let Self { particles, bodies, forces, distances, scratch, .. } = self;
        let Scratch { plan, substep, settings_inputs, loads, measured_strains, .. } = scratch;
        let h = substep.length;
        // Springs, loads and statics change the result from step to step, so it is reused only without them.
        let is_plain = forces.springs.is_empty() && loads.is_empty() && !world.statics;
        let inputs = (world, h, bodies.revision(), particles.edits());
        if is_plain && *settings_inputs == Some(inputs) {
            return plan.tether(particles);
        }
        *settings_inputs = is_plain.then_some(inputs);
        for island in &mut plan.islands.list {
            (island.has_springs, island.strain_measured) = (false, false);
        }
        for row in forces.springs.iter().flat_map(|spring| [spring.a, spring.b]) {
            if let Some(&number) = plan.islands.of.get(row as usize) {
                plan.islands.list[number as usize].has_springs = true;
            }
        }
        for distance in measured_strains.iter().filter_map(|&number| distances.get(number)) {
            if let Some(&number) = plan.islands.of.get(distance.a as usize) {
                plan.islands.list[number as usize].strain_measured = true;
            }
        }
        // Neighbouring bodies mostly have the same settings.
        let mut last: Option<(BodySettings, SolverSettings)> = None;
        for number in 0..plan.islands.list.len() {
            let island = &plan.islands.list[number];
            let members = &plan.islands.members[island.members.clone()];
            let (pins, body) = match plan.stretch(island) {
                Some(rows) => {
                    let (body, others) =
                        (particles.body[rows.start], &particles.body[rows.clone()]);
                    let is_one = others.iter().all(|&other| other == body);
                    let columns = (rows.start as u32..).zip(&particles.position[rows]);
                    let pinned = columns.filter(|(_, position)| position.w == 0.0);
                    (Pins::of(pinned.map(|(row, _)| row)), is_one.then_some(body))
                }
                None => {
                    let pinned = |row: &u32| particles.position[*row as usize].w == 0.0;
                    (Pins::of(members.iter().copied().filter(pinned)), None)
                }
            };
            let own =
                body.filter(|_| pins == Pins::None).and_then(|body| bodies.get(body as usize));
            let settings = match (own, last) {
                (Some(own), Some((asked, settings))) if asked == *own => settings,
                (Some(own), _) => {
                    let settings = own.over(world, h);
                    last = Some((*own, settings));
                    settings
                }
                (None, _) => settings_of(members, particles, bodies, (world, h)),
            };
            let island = &mut plan.islands.list[number];
            island.settings = settings;
            island.free = pins == Pins::None && keeps_momenta(island);
            let members = &plan.islands.members[island.members.clone()];
            let most = match body {
                None if !island.is_small() => {
                    settings_of_most(members, particles, bodies, (world, h))
                }
                _ => settings,
            };
            divide(plan, number, h, most);
            let island = &mut plan.islands.list[number];
            let may_turn = (island.is_small() || island.has_chains()) && !island.takes_microsteps();
            island.pivot = match pins {
                Pins::Few(rows) if may_turn && keeps_momenta(island) => Some(rows),
                _ => None,
            };
        }
        plan.tether(particles);
    }

    /// Stores a good state of each row, which it is reset to if it turns non-finite.
    pub(super) fn set_checkpoint(&mut self) {
        let Self { particles, scratch: Scratch { checkpoint, .. }, .. } = self;
        checkpoint.resize(particles.len(), Vec4::ZERO);
        for (good, q) in checkpoint.iter_mut().zip(&particles.position) {
            // A row that a caller set to a non-finite position is reset to the last one stored.
            *good = if q.is_finite() { *q } else { good.truncate().extend(q.w) };
        }
    }

    /// Runs the broad phase.
    pub(super) fn begin_contacts(&mut self) {
        let reports = self.reports_contacts();
        let Self {
            particles,
            forces,
            boundaries,
            colliders,
            body_colliders,
            contacts,
            contact_cache,
            ..
        } = self;
        let links = (&self.distances[..], &self.constraints[..]);
        let scratch = &mut self.scratch;
        let at_rest = scratch.at_rest && !reports;
        let Substep { length, remaining: substeps } = scratch.substep;
        let (plan, filter) = (&scratch.plan, &mut scratch.filter);
        filter.update(particles, contacts, &self.ignored, &plan.islands, links);
        let given = (&*boundaries, &colliders[..], &body_colliders[..]);
        let (among, steps) = ((&*filter, &plan.islands), (length, substeps, at_rest));
        scratch.row_gravity.update(particles, forces);
        let pull = (forces.gravity, &scratch.row_gravity);
        let world = contact_world(given, among, pull, steps);
        let execution = execution(self.instructions, &self.workers);
        scratch.contacts.begin((particles, &forces.surfaces), world, contact_cache, execution);
        scratch.contacts.particle_contacts.note_inside(particles, length);
        let Scratch { contacts, plan, .. } = scratch;
        let Islands { list, members, rows_near_colliders, .. } = &mut plan.islands;
        rows_near_colliders.clear();
        rows_near_colliders.extend(contacts.body_contact.rows_near_shapes());
        rows_near_colliders.sort_unstable();
        rows_near_colliders.dedup();
        for island in list.iter_mut().filter(|island| island.takes_microsteps()) {
            let mut last = NO_BODY;
            (island.may_touch_others, island.may_touch_any, island.pressed) = (false, false, false);
            for &row in &members[island.members.clone()] {
                let body = particles.body[row as usize];
                // Neighbours mostly share their body.
                if core::mem::replace(&mut last, body) != body {
                    island.may_touch_others |= contacts.may_touch_others(body);
                    island.may_touch_any |= contacts.may_touch_any(body);
                }
            }
        }
    }

    /// Samples winds and air at every triangle.
    pub(super) fn sample_winds(&mut self) {
        let Self { particles, forces, scratch, instructions, .. } = self;
        let flows = &forces.air_flows;
        forces::sample_air(
            particles,
            &forces.surfaces,
            flows,
            self.time,
            &mut scratch.air,
            *instructions,
        );
        scratch.pressures.clear();
        for wind in &forces.winds {
            let surfaces = &forces.surfaces;
            scratch.pressures.sample(particles, surfaces, wind, self.time, *instructions);
        }
    }

    /// Packs the triangles that winds and air act on, if there are any.
    pub(super) fn pack_surfaces(&mut self) {
        let Self { particles, forces, scratch, .. } = self;
        let Scratch { surfaces, pressures, air, particle_surfaces, .. } = scratch;
        if !pressures.is_empty() || air.is_at_triangles() {
            surfaces.pack(&forces.surfaces, particle_surfaces, &particles.origin);
        }
    }
}

/// A pinned particle whose origin was changed to that of its island, to be restored.
#[derive(Clone, Copy, Debug)]
pub(super) struct PinnedOrigin {
    row: usize,
    /// Its own origin, metres.
    home: Vec3,
    /// Its position from that origin, with its inverse mass, zero.
    place: Vec4,
    /// Its position from the island's origin.
    shifted: Vec4,
}

/// The settings of the body that most particles of an island belong to, in substeps of `h` seconds.
fn settings_of_most(
    members: &[u32],
    particles: &Particles,
    bodies: &[BodySettings],
    (world, h): (SolverSettings, f32),
) -> SolverSettings {
    let body = |row: &u32| particles.body[*row as usize];
    let mut counts = SmallVec::<[(u32, usize); 8]>::new();
    for run in members.chunk_by(|one, next| body(one) == body(next)) {
        match counts.iter_mut().find(|(known, _)| *known == body(&run[0])) {
            Some((_, count)) => *count += run.len(),
            None => counts.push((body(&run[0]), run.len())),
        }
    }
    // The first of equals.
    let most = counts.into_iter().reduce(|most, next| if next.1 > most.1 { next } else { most });
    let own = most.and_then(|(body, _)| bodies.get(body as usize));
    own.map_or(world, |body| body.over(world, h))
}

/// The merged settings of the bodies of an island, in substeps of `h` seconds.
fn settings_of(
    members: &[u32],
    particles: &Particles,
    bodies: &[BodySettings],
    (world, h): (SolverSettings, f32),
) -> SolverSettings {
    if bodies.is_empty() {
        return world;
    }
    let (mut found, mut last) = (None::<SolverSettings>, None);
    for &row in members {
        let body = particles.body[row as usize];
        // Neighbours mostly share their body. The settings of a pinned particle do not count, as no constraint moves it.
        if last == Some(body) || particles.position[row as usize].w == 0.0 {
            continue;
        }
        last = Some(body);
        let own = bodies.get(body as usize).map_or(world, |body| body.over(world, h));
        found = Some(found.map_or(own, |sum| SolverSettings {
            max_sweeps: sum.max_sweeps.max(own.max_sweeps),
            tolerance: sum.tolerance.min(own.tolerance),
            gradient_at: if own.gradient_at == sum.gradient_at {
                own.gradient_at
            } else {
                Default::default()
            },
            keep_spin: sum.keep_spin || own.keep_spin,
            ..sum
        }));
    }
    found.unwrap_or(world)
}
