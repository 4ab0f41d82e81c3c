//! Contacts of body colliders: boxes of eight particles, hulls of four, bones of two or three, which collide by a shape instead of particle by particle.
//!
//! A body collider is a set of particles and a shape in their common frame. It has no motion state of its own: in each substep its pose is extracted from the
//! predicted positions of its particles, contacts correct that pose, and the change of the pose is applied to the particles. What the particles do to each
//! other is left to constraints.
//!
//! This file has the order of a substep over all body colliders, and the contact events. A rope collides by its segments, a capsule between each two
//! neighbours, so that nothing thinner than their gap passes between them. The other parts:
//!
//! | file | what it is |
//! |---|---|
//! | `groups` | mass properties in groups of eight body colliders: shared particles, pinned particles, rods |
//! | `pose` | extracts poses from particles, from scratch or from the last substep's; applies pose deltas to the particles and keeps momentum |
//! | `bodies` | the rows that contacts read of body colliders and of static geometry |
//! | `rigid_islands`, `rigid_state`, `rigid_rotation` | body colliders that are integrated as one rigid state: which, and how |
//! | `rigid_forces` | forces on the particles of rigid states, and the wind on their surface triangles |
//! | `sensors` | sensors among static geometry: what is in one, and what passes through one in a step |
//! | `static_geometry` | static and kinematic geometry: colliders, planes and boxes |
//! | `swept_bounds` | swept AABB and speculative margin of a body collider in a step |
//! | `broad_phase` | pairs whose swept bounds overlap, and missed pairs of body colliders that left theirs |
//! | `narrow_phase` | manifolds of a pair: cached, computed afresh, or refreshed within a step |
//! | `ghosts` | drops contacts with inner edges of a floor made of several colliders |
//! | `rest_overlaps` | parts of a body that overlap in its rest shape and never collide |
//! | `dormant` | body colliders of dormant islands, whose poses, bounds and manifolds are kept |
//! | `contact_cache` | manifolds and friction anchors that are kept from step to step |
//! | `wide_contact` | contacts of a step, coloured and packed in eights; number of sweeps under high mass ratios |
//! | `normal_solve` | normal impulses; the points of one manifold are solved together |
//! | `friction` | friction solve: slip, friction anchors, and the constraint residual at shared particles |
//! | `deep_overlap` | limit of the speed at which particles leave a deep overlap |
//! | `sudden` | islands with an abruptly stopped body collider, whose constraints are swept once more |
//! | `restitution` | restitution as one problem over all contacts; planar drag |
//! | `loose` | contacts of body colliders with single particles |
//! | `turn` | rotations, symmetric matrices and tangents in eight lanes |

mod bodies;
mod broad_phase;
mod contact_cache;
mod deep_overlap;
mod dormant;
mod friction;
mod ghosts;
mod groups;
mod loose;
mod narrow_phase;
mod normal_solve;
mod pose;
mod rest_overlaps;
mod restitution;
mod rigid_forces;
mod rigid_islands;
mod rigid_rotation;
mod rigid_state;
mod sensors;
mod static_geometry;
mod sudden;
mod swept_bounds;
#[cfg(test)]
mod tests;
mod turn;
mod wide_contact;

use glam::Vec3;

use super::body_collider::BodyCollider;
use super::features::Features;
use super::impact::{ContactParticipant, Impacts};
use super::manifold::ClusterSearch;
use super::nearby::Nearby;
use super::particle_contact::{NormalImpulse, ParticleContacts};
use super::pressed::PressedCloth;
use super::recovery::{MAX_DEPENETRATION, in_substep, recovery};
use super::shape::Shape;
use super::world::World;
use crate::lanes::{InstructionSet, LANES, get, with};
use crate::not_cloned::NotCloned;
use crate::particles::Particles;
use bodies::{Bodies, CENTRE};
use broad_phase::MissedPairs;
use contact_cache::CacheBuilder;
use deep_overlap::DeepOverlaps;
use dormant::DormantColliders;
use friction::{predict_impulses, solve_all_friction};
use ghosts::GhostScratch;
use groups::BodyGroups;
use loose::Loose;
use narrow_phase::NarrowPhase;
use normal_solve::solve_normals;
use pose::{Gathered, OriginOffsets, PoseSums, SharedDeltas};
use rest_overlaps::RestOverlaps;
use restitution::ImpactScratch;
use rigid_islands::RigidIslands;
use rigid_state::{ShowStates, correct_states};
use sensors::Sensors;
use static_geometry::StaticGeometry;
pub(crate) use static_geometry::half_spaces;
use swept_bounds::{SweptBounds, WideSweptBounds};
use wide_contact::{Contact, WideContact};

pub use contact_cache::{CachedManifold, ContactCache};
pub(crate) use rigid_islands::{RigidStep, Written};

/// Overlap that is recovered in a substep, in metres `a g h² + b h`: the multiple `a` of what gravity adds to it in a substep, and the speed `b`, m/s. The
/// lowest of a tower of `a` boxes needs the overlap `a g h²`, since one sweep passes an impulse on by one body; more at once would be visible as a jump. With
/// the multiple 20 of single particles, which pass nothing on, ropes that lie across each other pass through each other, and a rope that is pinned inside
/// posts trembles at 0.2 m/s.
const RECOVERED: (f32, f32) = (200.0, 2.0);
/// Overlap that takes longer than this to be recovered, seconds, was not caused by an impact and counts as deep: 2 cm at ten substeps.
const DEEP: f32 = 4e-3;

/// How often per substep contacts with single particles are solved, with the constraints of the pressed cloth in between. Measured with 1, 2 and 4 passes on
/// cloths of 64 × 64, six starts each, as the mean of each frame's worst strain and as milliseconds a frame, in the second after a crate of 5 kg has fallen
/// in: a cloth held at its corners 8.4, 3.3 and 3.1 %, in 1.8, 2.4 and 3.5 ms; a slack one 8.3, 4.2 and 3.9 %, in 2.4, 3.4 and 4.8 ms.
const TURNS: u32 = 2;

/// A contact of this step for which events are requested.
#[derive(Clone, Copy, Debug)]
struct ContactEvent {
    participants: [ContactParticipant; 2],
    point: Vec3,
    normal: Vec3,
    /// N·s.
    impulse: f32,
}

/// Contact solver of body colliders for one step. Scratch, except for what follows from body colliders and masses alone, and for the contact cache, which is
/// lent to it for a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyContactSolver {
    /// Instruction set of its kernels. It never changes a result.
    pub(crate) instructions: InstructionSet,
    groups: BodyGroups,
    overlaps: RestOverlaps,
    origin_offsets: OriginOffsets,
    bodies: Bodies,
    sums: Vec<PoseSums>,
    wide_swept: Vec<WideSweptBounds>,
    gathered: Vec<Gathered>,
    static_geometry: Vec<StaticGeometry>,
    floor: Option<Shape>,
    swept: Vec<SweptBounds>,
    clusters: NotCloned<ClusterSearch>,
    narrow_phase: NotCloned<NarrowPhase>,
    bounds: Vec<(Vec3, Vec3)>,
    /// Body colliders that have left their swept bounds in this substep.
    outside_bounds: Vec<u32>,
    missed: MissedPairs,
    nearby: Vec<[u32; 2]>,
    pairs: Vec<[u32; 2]>,
    contacts: Vec<Contact>,
    ghosts: GhostScratch,
    sensors: Sensors,
    wide_contacts: Vec<WideContact>,
    cache: CacheBuilder,
    loose: Loose,
    shared: SharedDeltas,
    contact_events: Vec<ContactEvent>,
    used: Vec<u64>,
    order: Vec<u32>,
    begins: Vec<u32>,
    loads: Vec<f32>,
    /// For each row of a body collider its depth in another one or in static geometry, metres. Scratch of the method `overlaps`.
    deepest: Vec<f32>,
    deep_overlaps: DeepOverlaps,
    /// Islands of which a part was stopped abruptly in this substep, ascending.
    stopped: Vec<u32>,
    impacts: ImpactScratch,
    rigid: RigidIslands,
    /// For each group a bit for each body collider that has a contact in this step; and for each whose pose was extracted in this substep.
    in_contact: Vec<u32>,
    extracted: Vec<u32>,
    /// For each group whether one of its body colliders sticks. Scratch of friction.
    sticking: Vec<bool>,
    /// For each group a bit for each body collider that sleeps. It keeps the pose that was extracted when the step began.
    asleep: Vec<u32>,
    dormant: NotCloned<DormantColliders>,
    /// Whether the broad phase has run since the last substep.
    fresh: bool,
    /// Length of the last substep, seconds.
    h: f32,
}

impl BodyContactSolver {
    /// Lays out the body colliders and their rows. Invalid body colliders are left out.
    pub(crate) fn compile(&mut self, body_colliders: &[BodyCollider], particles: &Particles) {
        self.groups.compile(body_colliders, particles);
        self.overlaps.reset();
        self.dormant.0.invalidate();
        self.wide_contacts.clear();
        self.contacts.clear();
        self.loose.clear();
    }

    /// For each row whether it belongs to a body collider.
    pub(crate) fn rows(&self) -> &[bool] {
        &self.groups.solid
    }

    /// Whether there are no body colliders.
    pub(crate) fn is_empty(&self) -> bool {
        self.groups.parts.is_empty()
    }

    /// Solves contacts in a substep of `h` seconds, between the constraints and the derivation of velocities. Contacts with single particles are solved in
    /// turns with the constraints of the cloth that they press on and with its particle contacts.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        (world, nearby, features): (&World, &Nearby, &Features),
        (h, substep): (f32, u32),
        (cloth, particle_contacts, normal_impulses): (
            &mut impl PressedCloth,
            &ParticleContacts,
            &mut [NormalImpulse],
        ),
    ) {
        self.deep_overlaps.clear();
        self.stopped.clear();
        if self.is_empty() || self.swept.len() != self.groups.parts.len() {
            return;
        }
        self.h = h;
        let share = |number: u32| number as f32 / world.substeps.max(1) as f32;
        let (from, to) = (share(substep), share(substep + 1));
        self.extract_poses(particles, to * world.dt);
        if !self.outside_bounds.is_empty() {
            self.find_missed_pairs(particles, world, (nearby, features), from);
        }
        if self.wide_contacts.is_empty() && self.loose.is_empty() {
            return;
        }
        self.place_static_geometry(world, from, to);
        self.refresh_manifolds(world, from);
        self.follow_kinematic_geometry(world, from);
        let most = |share: (f32, f32)| in_substep(share, h, world.g());
        let (recover, max_depenetration) = (most(RECOVERED), most(MAX_DEPENETRATION));
        let recovery_limits = [recover, recovery(h, world.g())];
        let elastic_depenetration = MAX_DEPENETRATION.0 * world.g() * h * h;
        let Self { wide_contacts, bodies, instructions, fresh, .. } = self;
        if core::mem::take(fresh) {
            predict_impulses(wide_contacts, bodies, *instructions);
        }
        solve_all_friction(wide_contacts, false, max_depenetration, bodies, *instructions);
        let limits = [max_depenetration, elastic_depenetration];
        let sweeps = wide_contacts.iter().map(|wide| wide.sweeps).max().unwrap_or(0);
        for sweep in 0..sweeps {
            solve_normals(wide_contacts, bodies, h, recovery_limits, limits, sweep, *instructions);
        }
        self.note_stopped(world.islands, (h, world.g()));
        let Self { wide_contacts, bodies, instructions, .. } = self;
        solve_all_friction(wide_contacts, true, max_depenetration, bodies, *instructions);
        for turn in 0..TURNS {
            let Self { loose, groups, bodies, .. } = self;
            let most = max_depenetration;
            loose.project(particles, groups, bodies, world, (h, most), (turn, &mut *cloth));
            let pressed = loose.pressed();
            let beside = (particle_contacts, &mut *normal_impulses);
            if pressed.is_empty() || turn + 1 == TURNS || !cloth.project(particles, beside, pressed)
            {
                break;
            }
        }
        let depth = recover * (DEEP / h).max(1.0);
        let speeds = (recover / h, world.g() * h);
        self.note_deep_overlaps(particles, world.islands, depth, speeds);
        self.apply_pose_deltas(particles);
        self.measure_residual(particles);
    }

    /// Rows of single particles that body colliders have pressed on in this substep.
    pub(crate) fn pressed_rows(&self) -> impl Iterator<Item = u32> {
        self.loose.pressed_in_substep()
    }

    /// Rows of single particles that are near body colliders in this step, once for each pair.
    pub(crate) fn rows_near_shapes(&self) -> impl Iterator<Item = u32> {
        self.loose.rows()
    }

    /// Returns the contact cache at the end of a step.
    pub(crate) fn keep(&mut self, cache: &mut ContactCache) {
        self.note_friction_anchors(self.h);
        self.cache.give(cache);
    }

    /// Reports contact events and sensor overlaps of a step that has ended.
    pub(crate) fn report(&mut self, particles: &Particles, impacts: &mut Impacts) {
        self.note_contact_events();
        for event in self.contact_events.drain(..) {
            impacts.add(event.participants, event.point, event.normal, event.impulse, false);
        }
        self.sensors.report(&self.groups, particles, impacts);
    }

    /// Depth at which body colliders were in each other or in static geometry when the last substep began, metres: the first row of each body collider with
    /// an overlap, and the greatest overlap that the substep before has left.
    pub(crate) fn overlaps(&mut self) -> impl Iterator<Item = (u32, f32)> {
        let Self { wide_contacts, groups, deepest, .. } = self;
        deepest.clear();
        deepest.resize(groups.padded(), 0.0);
        for wide in wide_contacts.iter() {
            for (&row, &left) in
                wide.a.iter().chain(&wide.b).zip(wide.remaining_overlap.iter().cycle())
            {
                // Static geometry and the null row come after the rows of body colliders.
                if let Some(deepest) = deepest.get_mut(row as usize) {
                    *deepest = deepest.max(left);
                }
            }
        }
        let groups = &*groups;
        deepest.iter().enumerate().filter(|(_, left)| **left > 0.0).filter_map(|(row, &left)| {
            let solid = groups.sound_in(row / LANES, row % LANES)?;
            Some((groups.rows[groups.parts[solid].entries.start], left))
        })
    }

    /// Adds the contact events that the wide contacts have accumulated.
    fn note_contact_events(&mut self) {
        let Self { contacts, wide_contacts, swept, bodies, groups, contact_events, h, .. } = self;
        for wide in wide_contacts.iter_mut().filter(|wide| wide.kept) {
            for lane in 0..LANES {
                let Some(one) = contacts.get(wide.number[lane] as usize) else { continue };
                if !one.reports_events || wide.total[lane] <= 0.0 {
                    continue;
                }
                let a = one.a as usize;
                let centre = bodies[groups.place(a)][CENTRE].truncate();
                let point = swept[a].origin + (centre + get(&wide.arm, lane));
                let (normal, impulse) = (get(&wide.up, lane), wide.total[lane] / *h);
                contact_events.push(ContactEvent {
                    participants: one.participants,
                    point,
                    normal,
                    impulse,
                });
            }
            wide.total = [0.0; LANES];
        }
        self.loose.note_contact_events(contact_events, *h);
    }

    /// Stores the friction anchors in the contact cache after a substep of `h` seconds.
    fn note_friction_anchors(&mut self, h: f32) {
        let Self { wide_contacts, contacts, cache, .. } = self;
        for wide in &*wide_contacts {
            for (lane, number) in wide.number.iter().enumerate() {
                if let Some(one) = contacts.get(*number as usize) {
                    cache.now[one.cache_index as usize].friction_anchor =
                        wide.friction_anchor(lane, h);
                }
            }
        }
    }

    /// Extracts poses as predicted and their motion since the substep began, `time` seconds after the step began; lists the body colliders that have left
    /// their swept bounds.
    fn extract_poses(&mut self, particles: &Particles, time: f32) {
        self.outside_bounds.clear();
        self.extracted.clear();
        self.extracted.resize(self.groups.groups.len(), !0);
        for number in 0..self.groups.groups.len() {
            let first = number * LANES;
            let (mut left, lanes, asleep) = (0, self.rigid.lanes(number), self.asleep[number]);
            let mut read = !0;
            if self.groups.groups[number].lines {
                left = self.lines_outside(number, &particles.position, time) & !(lanes | asleep);
                read = (self.in_contact[number] | left) & !(lanes | asleep);
                self.extracted[number] = read;
            }
            if read != 0 && lanes | asleep != self.groups.groups[number].sound {
                let before = (asleep != 0).then(|| self.bodies.eight(first));
                let columns = [&particles.position[..], &particles.start];
                left |= self.extract_pose(number, columns, Some(time), read) & !(lanes | asleep);
                if let Some(before) = before {
                    self.bodies.put_back(first, asleep, before);
                }
            }
            let Self { groups, bodies, wide_swept, outside_bounds, instructions, .. } = self;
            if lanes != 0 {
                let (state, mass) = (&self.rigid.states[number], &groups.groups[number].mass);
                let wide_swept = Some((&wide_swept[number], time));
                let h = self.h;
                let show =
                    ShowStates { mass, state, bodies, first, h, at_start: false, wide_swept };
                left |= with(*instructions, show);
            }
            if left != 0 {
                let lanes = (0..LANES).filter(|lane| left >> lane & 1 == 1);
                let body_colliders = lanes.filter_map(|lane| groups.sound_in(number, lane));
                outside_bounds.extend(body_colliders.map(|number| number as u32));
            }
        }
    }

    /// Applies the pose deltas of body colliders to their particles.
    fn apply_pose_deltas(&mut self, particles: &mut Particles) {
        self.shared.clear();
        for number in 0..self.groups.groups.len() {
            let Self { groups, bodies, rigid, instructions, h, .. } = self;
            let (lanes, group) = (rigid.lanes(number), &groups.groups[number]);
            if lanes != 0 {
                let (state, mass) = (&mut rigid.states[number], &group.mass);
                let first = number * LANES;
                correct_states(mass, state, bodies, first, *h, *instructions);
            }
            let lanes = lanes | self.asleep[number];
            if lanes != group.sound && self.extracted[number] != 0 {
                self.apply_pose_delta(number, !lanes, &mut particles.position, None);
            }
        }
        for (row, by) in self.shared.iter() {
            particles.position[row as usize] += by;
        }
    }
}
