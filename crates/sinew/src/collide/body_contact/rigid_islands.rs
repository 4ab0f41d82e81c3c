//! Rigid islands: selection of the body colliders that are integrated as rigid states (`rigid_state`) in a step, and of the times when their particles are
//! read and written.
//!
//! A rigid island is one whose particles are those of one body collider, each tied to each by rods at their distances in the collider, with no other
//! constraint on any of them. Rigid islands are found when constraints or colliders have changed. In a step such an island moves as one rigid state if none
//! of its particles is pinned or asleep, no load of its rods is measured, its body has [`Representation::Auto`], and its particles are at their places in a
//! rigid body. All of that follows from saved state, so a restored world continues with the same bits.
//!
//! Its particles are written after each substep, or once a step if no system runs in between and no force acts on a single one of them (`rigid_forces`). If a
//! particle is moved between two phases, its island goes on as particles until the step ends.

use core::ops::Range;

use glam::{Mat3, Quat, Vec3};

use super::super::body_collider::BodyCollider;
use super::BodyContactSolver;
use super::groups::{BodyGroups, NONE};
use super::rigid_forces::{Acting, RigidForces};
use super::rigid_state::{AdvanceStates, ReadStates, WideRigidState, write_states};
use super::turn::LaneArray;
use crate::constraints::{GradientAt, Pin};
use crate::forces::Pressures;
use crate::integrate::Integrator;
use crate::islands::{Island, Islands};
use crate::lanes::{LANES, with};
use crate::particles::Particles;
use crate::pose::Pose;
use crate::settings::{BodySettings, Representation};
use crate::tracked::Tracked;

/// The body colliders that are rigid states. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct RigidIslands {
    /// The island of each body collider that has all of its particles; `NONE` for others.
    pub(super) islands: Vec<u32>,
    /// The body collider with all particles of an island; `NONE` for other islands.
    pub(super) solids: Vec<u32>,
    /// The states of each group.
    pub(super) states: Vec<WideRigidState>,
    pub(super) forces: RigidForces,
    /// Number of lanes that are rigid states.
    count: usize,
    /// Whether all body colliders are rigid states, and none can touch anything in this step while all stay within their swept bounds.
    idle: bool,
    times: Vec<f32>,
    /// Islands with pins, ascending.
    pinned: Vec<u32>,
}

impl RigidIslands {
    /// A bit for each lane of a group that is a rigid state.
    #[inline(always)]
    pub(super) fn lanes(&self, group: usize) -> u32 {
        self.states.get(group).map_or(0, |state| state.lanes)
    }

    /// Marks the rigid state that a row belongs to, if any, as one with forces on single particles.
    fn force(&mut self, groups: &BodyGroups, islands: &Islands, row: u32) {
        let island = islands.of.get(row as usize);
        let solid = island.and_then(|&island| self.solids.get(island as usize));
        if let Some(&solid) = solid.filter(|&&solid| solid != NONE) {
            self.forces.force(groups.place(solid as usize));
        }
    }

    /// The state of a row of `bodies`, and its lane, if it is a rigid state.
    pub(super) fn of_row(&mut self, row: usize) -> Option<(&mut WideRigidState, usize)> {
        let (group, lane) = (row / LANES, row % LANES);
        self.states.get_mut(group).filter(|state| state.lanes >> lane & 1 == 1).map(|s| (s, lane))
    }
}

/// Parameters of a step that rigid states depend on.
#[derive(Clone, Copy)]
pub(crate) struct RigidStep<'a> {
    pub(crate) bodies: &'a [BodySettings],
    pub(crate) pins: &'a [Pin],
    /// Length of a substep, seconds.
    pub(crate) h: f32,
}

/// Motion of a rigid state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidMotion {
    /// Its centre from the origin of its particles, and the displacement of that in this step, metres.
    pub(crate) centre: Vec3,
    pub(crate) gone: Vec3,
    /// Mean velocity of the last substep, m/s, and the length of that, seconds.
    pub(crate) velocity: Vec3,
    pub(crate) lag: f32,
    /// rad/s.
    pub(crate) angular_velocity: Vec3,
    /// kg, and kg·m² in world axes.
    pub(crate) mass: f32,
    pub(crate) inertia: Mat3,
}

impl BodyContactSolver {
    /// Finds the body colliders that have all particles of an island; `tied` returns whether the constraints of an island tie exactly a body collider's
    /// particles at their distances there, and nothing else. To be called when constraints or body colliders have changed.
    pub(crate) fn find_rigid_islands(
        &mut self,
        body_colliders: &[BodyCollider],
        islands: &Islands,
        tied: impl Fn(&BodyCollider, &Island) -> bool,
    ) {
        let Self { groups, rigid, .. } = self;
        rigid.islands.clear();
        rigid.islands.extend(groups.parts.iter().zip(body_colliders).enumerate().map(
            |(number, (part, solid))| {
                let is_alone = groups.is_alone(number) && part.sound && part.side.is_some();
                let island = solid.rows.first().and_then(|&row| islands.of.get(row as usize));
                let found = island
                    .copied()
                    .filter(|&island| is_alone && tied(solid, &islands.list[island as usize]));
                found.unwrap_or(NONE)
            },
        ));
        rigid.solids.clear();
        rigid.solids.resize(islands.list.len(), NONE);
        for (number, &island) in rigid.islands.iter().enumerate() {
            if let Some(solid) = rigid.solids.get_mut(island as usize) {
                *solid = number as u32;
            }
        }
        self.rigid.forces.forget_skins();
    }

    /// Reads the rigid states of this step from their particles, after the broad phase, and marks their islands; there are none if single particles are
    /// `held`.
    pub(crate) fn begin_rigid_states(
        &mut self,
        particles: &mut Particles,
        all: &mut Islands,
        step: RigidStep,
        held: bool,
    ) {
        all.list.iter_mut().for_each(|island| island.is_rigid_state = false);
        self.rigid.count = 0;
        self.rigid.idle = false;
        self.rigid.states.clear();
        particles.record_edits(false);
        if held
            || self.rigid.islands.iter().all(|&island| island == NONE)
            || self.bodies.rows.is_empty()
        {
            return;
        }
        let Self { groups, rigid, bodies, gathered, asleep, instructions, .. } = self;
        rigid.states.resize(groups.groups.len(), WideRigidState::default());
        let RigidIslands { islands, states, count, pinned, .. } = rigid;
        pinned.clear();
        let rows = step.pins.iter().map(|pin| pin.particle as usize);
        pinned.extend(rows.filter_map(|row| all.of.get(row).copied()));
        pinned.sort_unstable();
        for (number, (group, state)) in groups.groups.iter().zip(states).enumerate() {
            let (mut eligible, mut reach, mut tolerance) = (0, [0.0; LANES], [0.0; LANES]);
            let awake = group.sound & !asleep[number];
            for lane in (0..LANES).filter(|lane| awake >> lane & 1 == 1) {
                let Some(solid) = groups.sound_in(number, lane) else { continue };
                let Some(island) = all.list.get(islands[solid] as usize) else { continue };
                if pinned.binary_search(&islands[solid]).is_ok() {
                    continue;
                }
                let part = &groups.parts[solid];
                let rows = &groups.rows[part.entries.clone()];
                let Some(rate) = rate_of(rows, particles, island, &step) else { continue };
                eligible |= 1 << lane;
                (reach[lane], tolerance[lane]) = (part.reach, island.settings.tolerance);
                state.rate[lane] = rate;
            }
            if eligible == 0 {
                continue;
            }
            let read = ReadStates {
                mass: &group.mass,
                slots: &groups.slots[group.slots.clone()],
                position: &particles.position,
                velocity: &particles.velocity,
                rounding: &particles.rounding,
                bodies,
                first: number * LANES,
                reach,
                tolerance,
                state,
                h: step.h,
                gathered,
            };
            state.lanes = eligible & with(*instructions, read);
            *count += state.lanes.count_ones() as usize;
            for lane in (0..LANES).filter(|lane| state.lanes >> lane & 1 == 1) {
                if let Some(solid) = groups.sound_in(number, lane) {
                    all.list[islands[solid] as usize].is_rigid_state = true;
                }
            }
        }
        let sound = groups.parts.iter().filter(|part| part.sound).count();
        rigid.idle = *count == sound && self.contacts.is_empty() && self.loose.is_empty();
        particles.record_edits(*count > 0);
    }

    /// Whether there are rigid states in this step.
    pub(crate) fn has_rigid_states(&self) -> bool {
        self.rigid.count > 0
    }

    /// Whether the broad phase has found nothing that a body collider can touch in this step, so that each moves by itself.
    pub(crate) fn is_idle(&self) -> bool {
        self.rigid.idle
    }

    /// Continues islands with a particle that was moved from outside as particles. Clears the list of moved particles, and returns whether an island was
    /// released.
    pub(crate) fn release_moved(&mut self, particles: &mut Particles, all: &mut Islands) -> bool {
        let mut any = false;
        while let Some(row) = particles.pop_moved() {
            let Some(&number) = all.of.get(row as usize) else { continue };
            let island = &mut all.list[number as usize];
            if !core::mem::take(&mut island.is_rigid_state) {
                continue;
            }
            let solid = self.rigid.solids.get(number as usize).filter(|&&solid| solid != NONE);
            let place = solid.map(|&solid| self.groups.place(solid as usize));
            if let Some((state, lane)) = place.and_then(|place| self.rigid.of_row(place)) {
                state.lanes &= !(1 << lane);
                self.rigid.count -= 1;
                self.rigid.idle = false;
                any = true;
            }
        }
        any
    }

    /// Lays out the surface triangles of bodies that may be rigid states, if triangles or bodies have changed.
    pub(crate) fn find_skins(
        &mut self,
        surfaces: &Tracked<Vec<[u32; 3]>>,
        body_colliders: &[BodyCollider],
    ) {
        let RigidIslands { islands, forces, .. } = &mut self.rigid;
        forces.find_skins(&self.groups, islands, body_colliders, surfaces);
    }

    /// Marks the rigid states of this step with forces on single particles: those of `rows`, or all of them; and those with wind on their surface triangles.
    /// Appends to `others` the triangles that belong to particles that move by themselves.
    pub(crate) fn note_forces(
        &mut self,
        islands: &Islands,
        (all, rows): (bool, impl Iterator<Item = u32>),
        pressures: &Pressures,
        others: &mut Vec<Range<usize>>,
    ) {
        let Self { groups, rigid, asleep, .. } = self;
        rigid.forces.begin(groups.groups.len(), all);
        for row in rows {
            rigid.force(groups, islands, row);
        }
        if pressures.is_empty() {
            return;
        }
        for place in 0..rigid.forces.shared().len() {
            let row = rigid.forces.shared()[place];
            rigid.force(groups, islands, row);
        }
        rigid.forces.press_on(&rigid.states, asleep, pressures, others);
    }

    /// Marks the rigid states whose particles were pushed from outside.
    fn note_pushed(&mut self, particles: &mut Particles, islands: &Islands) {
        while let Some(row) = particles.pop_pushed() {
            self.rigid.force(&self.groups, islands, row);
        }
    }

    /// Whether the particles of a body collider that is a rigid state are accelerated one by one.
    pub(crate) fn is_forced(&self, number: usize) -> bool {
        self.rigid.forces.is_forced(self.groups.place(number))
    }

    /// Advances the rigid states by one substep of `h` seconds, with the sums of forces on their particles and of wind pressure on their surface triangles.
    pub(crate) fn predict_rigid_states(
        &mut self,
        particles: &mut Particles,
        islands: &Islands,
        pressures: &Pressures,
        h: f32,
        (substep, substeps): (u32, u32),
    ) {
        self.note_pushed(particles, islands);
        let Self { groups, rigid, wide_swept, instructions, .. } = self;
        let RigidIslands { states, forces, idle, times, .. } = rigid;
        note_times(times, substep..substep + 1, h, substeps);
        let groups = groups.groups.iter().map(|group| (group, &groups.slots[group.slots.clone()]));
        let each = states.iter_mut().zip(groups).zip(wide_swept).enumerate();
        for (number, ((state, (group, slots)), wide_swept)) in each {
            if state.lanes == 0 {
                continue;
            }
            state.note_losses(particles.uniform_damping, h);
            let acting = Acting { particles, pressures, h };
            let body = (&group.mass, slots);
            let sums = forces.sum(number, body, state, acting, *instructions);
            let advance = AdvanceStates {
                mass: &group.mass,
                state,
                common: particles.uniform_acceleration,
                sums,
                h,
                wide_swept,
                times,
            };
            *idle &= with(*instructions, advance) == 0;
        }
    }

    /// Advances them by all remaining substeps. If one leaves its swept bounds, the step is no longer idle, and states have to be read again.
    pub(crate) fn advance_idle_states(
        &mut self,
        particles: &Particles,
        h: f32,
        (substep, substeps): (u32, u32),
    ) {
        let Self { groups, rigid, wide_swept, instructions, .. } = self;
        let RigidIslands { states, idle, times, .. } = rigid;
        note_times(times, substep..substeps, h, substeps);
        for ((state, group), wide_swept) in states.iter_mut().zip(&groups.groups).zip(wide_swept) {
            state.note_losses(particles.uniform_damping, h);
            let advance = AdvanceStates {
                mass: &group.mass,
                state,
                common: particles.uniform_acceleration,
                sums: None,
                h,
                wide_swept,
                times,
            };
            *idle &= with(*instructions, advance) == 0;
        }
    }

    /// Ends the idle state: contacts are solved in the rest of this step.
    pub(crate) fn set_not_idle(&mut self) {
        self.rigid.idle = false;
    }

    /// The pose of a body collider that is a rigid state, from the origin of its particles; `None` of any other.
    pub(crate) fn rigid_pose(&self, number: usize) -> Option<Pose> {
        let (part, row) = (self.groups.parts.get(number)?, self.groups.place(number));
        let (group, lane) = (row / LANES, row % LANES);
        let state = self.rigid.states.get(group).filter(|state| state.lanes >> lane & 1 == 1)?;
        let (centre, q) = state.pose(lane);
        let q = q / q.length();
        let turn = Pose { translation: Vec3::ZERO, rotation: Quat::from_xyzw(q.x, q.y, q.z, q.w) };
        Some(Pose { translation: centre - turn.point(part.centre), ..turn })
    }

    /// The motion of a body collider that is a rigid state; `None` of any other.
    pub(crate) fn rigid_motion(&self, number: usize) -> Option<RigidMotion> {
        self.groups.parts.get(number)?;
        let row = self.groups.place(number);
        let (group, lane) = (row / LANES, row % LANES);
        let state = self.rigid.states.get(group).filter(|state| state.lanes >> lane & 1 == 1)?;
        let (centre, q) = state.pose(lane);
        let q = q / q.length();
        let r = Mat3::from_quat(Quat::from_xyzw(q.x, q.y, q.z, q.w));
        let mass = &self.groups.groups[group].mass;
        let own = |[xx, yy, zz, xy, xz, yz]: &[LaneArray; 6]| {
            let (xy, xz, yz) = (xy[lane], xz[lane], yz[lane]);
            Mat3::from_cols(
                Vec3::new(xx[lane], xy, xz),
                Vec3::new(xy, yy[lane], yz),
                Vec3::new(xz, yz, zz[lane]),
            )
        };
        let back = r.transpose();
        let (gone, lag) = state.gone(lane);
        Some(RigidMotion {
            centre,
            gone,
            velocity: state.velocity(lane),
            lag,
            angular_velocity: r * (own(&mass.inverse_inertia) * (back * state.momentum(lane))),
            mass: 1.0 / mass.inverse_mass[lane],
            inertia: r * own(&mass.inertia) * back,
        })
    }

    /// Writes the particles of the rigid states that `which` selects; `exact` as in [`write_states`].
    pub(crate) fn write_rigid_states(
        &self,
        particles: &mut Particles,
        which: Written,
        exact: bool,
    ) {
        let Self { groups, rigid, instructions, .. } = self;
        let RigidForces { forced, windy, .. } = &rigid.forces;
        for (number, (group, state)) in groups.groups.iter().zip(&rigid.states).enumerate() {
            let of = |bits: &[u32]| bits.get(number).copied().unwrap_or(0);
            let lanes = match which {
                Written::All => state.lanes,
                Written::Forced => state.lanes & of(forced),
                Written::ForcedAndWindy => state.lanes & (of(forced) | of(windy)),
            };
            if lanes != 0 {
                let Particles { position, start, velocity, rounding, .. } = &mut *particles;
                let slots = &groups.slots[group.slots.clone()];
                let columns = [position, start, velocity, rounding].map(|column| &mut column[..]);
                write_states(group, slots, state, lanes, exact, columns, *instructions);
            }
        }
    }
}

/// Selection of the rigid states whose particles are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Written {
    All,
    /// Those with forces on single particles.
    Forced,
    /// Those, and those with wind on their surface triangles.
    ForcedAndWindy,
}

/// End times of some substeps of `h` seconds, since the step began.
fn note_times(times: &mut Vec<f32>, which: core::ops::Range<u32>, h: f32, substeps: u32) {
    let dt = h * substeps as f32;
    times.clear();
    times.extend(which.map(|number| (number + 1) as f32 / substeps.max(1) as f32 * dt));
}

/// The damping of the particles of an island that may move as a rigid state in this step, 1/s; `None` if it may not.
fn rate_of(rows: &[u32], particles: &Particles, island: &Island, step: &RigidStep) -> Option<f32> {
    let settings = &island.settings;
    let first = *rows.first()? as usize;
    let rate = particles.damping[first];
    let alike = |&row: &u32| particles.damping[row as usize] == rate;
    // Particles of no body, and of bodies without settings, use the defaults.
    let body = step.bodies.get(particles.body[first] as usize).copied().unwrap_or_default();
    let is_auto = body.representation == Representation::Auto;
    let keeps_momenta = settings.keep_spin || settings.gradient_at == GradientAt::StepStart;
    let may = island.free
        && !island.asleep
        && !island.rigid
        && !island.measured
        && island.one_origin
        && is_auto
        && keeps_momenta
        && !settings.statics
        && settings.integrator == Integrator::Verlet
        && (particles.column_summary.damping.is_some() || rows.iter().all(alike));
    may.then_some(rate)
}
