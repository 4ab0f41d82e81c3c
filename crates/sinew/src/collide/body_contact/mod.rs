//! Contacts of body colliders: boxes of eight particles, hulls of four, bones of two or three, that collide by a shape instead of particle by
//! particle.
//!
//! A body collider is a set of particles and a shape in their common frame. Nothing of it moves by itself: in each substep its pose is extracted from
//! where the particles were predicted, contacts correct that pose, and the particles are displaced as the pose was. What is between (what the
//! particles do to each other) is the business of constraints.
//!
//! Here is what a substep does with all of them, and what they have touched, for the report. A rope collides by its segments:
//! a capsule between each two neighbours, so that nothing that is thinner than their gap passes between them. The rest is in files of its own:
//!
//! | file | what it is |
//! |---|---|
//! | `groups` | eight body colliders at a time: particles that several share, what one weighs, pinned particles, rods |
//! | `pose` | poses out of particles, from nothing and from the last substep's; and the change of a pose back to them, with momentum |
//! | `bodies` | what contacts know of a body collider, or of static geometry: columns |
//! | `rigid_islands`, `rigid_state`, `rigid_rotation` | body colliders that move as one rigid state, and their particles follow: which, and how |
//! | `rigid_forces` | what acts on those, particle by particle, and the wind on their skins |
//! | `static_geometry` | colliders, planes and boxes |
//! | `swept_bounds` | where a body collider goes in a step |
//! | `broad_phase` | what it may come to touch there, and what does that has left those bounds |
//! | `narrow_phase` | the manifolds of a pair: cached, or computed afresh, or within a step once it has turned |
//! | `rest_overlaps` | which parts of a body overlap at rest, and never touch |
//! | `dormant` | those of sleepers to which nothing was done, and what is kept of them |
//! | `contact_cache` | what is kept from one step to the next |
//! | `wide_contact` | contacts of a step: coloured, packed by eight, and which are pressed more than once in a substep |
//! | `normal_solve` | their normal impulses, those of one manifold solved together |
//! | `friction` | their friction: how far they have slid, what holds them, and what joints take back of it where body colliders share particles |
//! | `deep_overlap` | how fast what was deep in something may leave |
//! | `sudden` | who was stopped suddenly, so that the constraints of its island are swept once more |
//! | `restitution` | restitution, as one problem; and drags, the lectures' friction |
//! | `loose` | body colliders and single particles |
//! | `turn` | rotations, symmetric matrices and directions of eight body colliders |

mod bodies;
mod broad_phase;
mod contact_cache;
mod deep_overlap;
mod dormant;
mod friction;
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
mod static_geometry;
mod sudden;
mod swept_bounds;
#[cfg(test)]
mod tests;
mod turn;
mod wide_contact;

use glam::Vec3;

use super::body_collider::BodyCollider;
use super::impact::{ContactParticipant, Impacts};
use super::manifold::ClusterSearch;
use super::nearby::Nearby;
use super::particle_contact::{NormalImpulse, ParticleContacts};
use super::pressed::PressedCloth;
use super::recovery::in_substep;
use super::shape::Shape;
use super::world::World;
use crate::kept::Kept;
use crate::lanes::{InstructionSet, LANES, with};
use crate::particles::Particles;
use bodies::{Bodies, CENTRE};
use broad_phase::MissedPairs;
use contact_cache::CacheBuilder;
use deep_overlap::DeepOverlaps;
use dormant::DormantColliders;
use friction::{predict_impulses, solve_all_friction};
use groups::BodyGroups;
use loose::Loose;
use narrow_phase::NarrowPhase;
use normal_solve::solve_normals;
use pose::{Gathered, OriginOffsets, PoseSums, SharedDeltas};
use rest_overlaps::RestOverlaps;
use restitution::ImpactScratch;
use rigid_islands::RigidIslands;
use rigid_state::{ShowStates, correct_states};
use static_geometry::StaticGeometry;
pub(crate) use static_geometry::half_spaces;
use swept_bounds::{SweptBounds, WideSweptBounds};
use turn::LaneArray;
use wide_contact::{Contact, SensorOverlap, WideContact};

pub use contact_cache::{CachedManifold, ContactCache};
pub(crate) use rigid_islands::{RigidStep, Written};

/// How much overlap is recovered in a substep: so many times what gravity adds to it, and what this speed is, m/s. A tower of so many boxes needs
/// that much, since a sweep hands a push on by one; more at once would be seen as a jump. With the 20 of single particles, which hand on nothing, ropes that
/// lie across each other pass through, and one that is pinned in posts trembles at 0.2 m/s.
const RECOVERED: (f32, f32) = (200.0, 2.0);
/// How much of that may turn into speed.
const MAX_DEPENETRATION: (f32, f32) = (20.0, 0.1);
/// What is so deep that it takes so long to come out, seconds, did not get there by an impact: 2 cm at ten substeps.
const DEEP: f32 = 4e-3;

/// So often single particles and body colliders are parted in a substep, where what is pressed on is held by its constraints in between. Of sheets of 64 × 64, six starts
/// each, the mean of each frame's worst strain, and milliseconds a frame, by 1, 2 and 4: in the second after a crate of 5 kg has fallen into one held at its corners 8.4, 3.3 and 3.1 %, in 1.8,
/// 2.4 and 3.5 ms; into a slack one 8.3, 4.2 and 3.9 %, in 2.4, 3.4 and 4.8 ms.
const TURNS: u32 = 2;

/// A contact of this step that somebody listens to.
#[derive(Clone, Copy, Debug)]
struct ContactEvent {
    participants: [ContactParticipant; 2],
    point: Vec3,
    normal: Vec3,
    /// N·s.
    impulse: f32,
}

/// Contacts of body colliders in a step. Scratch: nothing of it lasts from one step to the next but what follows from body colliders and masses
/// alone, and the memory, which is lent for a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyContactSolver {
    /// Which instructions its kernels use. It never changes a result.
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
    clusters: Kept<ClusterSearch>,
    narrow_phase: Kept<NarrowPhase>,
    bounds: Vec<(Vec3, Vec3)>,
    /// Who has left its swept bounds in this substep.
    outside_bounds: Vec<u32>,
    missed: MissedPairs,
    nearby: Vec<[u32; 2]>,
    pairs: Vec<[u32; 2]>,
    contacts: Vec<Contact>,
    sensor_overlaps: Vec<SensorOverlap>,
    wide_contacts: Vec<WideContact>,
    cache: CacheBuilder,
    loose: Loose,
    shared: SharedDeltas,
    contact_events: Vec<ContactEvent>,
    used: Vec<u64>,
    order: Vec<u32>,
    begins: Vec<u32>,
    loads: Vec<f32>,
    /// Of each row of a body collider, how deep it is in another, metres.
    deepest: Vec<f32>,
    deep_overlaps: DeepOverlaps,
    /// Islands of which a part was stopped suddenly in this substep, ascending.
    stopped: Vec<u32>,
    impacts: ImpactScratch,
    rigid: RigidIslands,
    /// For each group a bit for each body collider that is in a contact of this step; and for each that was read in this substep.
    met: Vec<u32>,
    read: Vec<u32>,
    /// Groups of which one sticks. Scratch of friction.
    sticking: Vec<bool>,
    /// For each group a bit for each body collider that sleeps: it stays where it was read when the step began.
    asleep: Vec<u32>,
    dormant: Kept<DormantColliders>,
    /// Whether contacts were looked for since the last substep.
    fresh: bool,
    /// Length of the last substep, seconds.
    h: f32,
}

impl BodyContactSolver {
    /// Notes which rows belong to which body colliders. Faulty ones are left out.
    pub(crate) fn compile(&mut self, body_colliders: &[BodyCollider], particles: &Particles) {
        self.groups.compile(body_colliders, particles);
        self.overlaps.reset();
        self.dormant.0.forget();
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

    /// Between the constraints of a substep of `h` seconds and its velocities: moves body colliders out of what they ran into. Where they press on cloth, that
    /// is held by its constraints in between, and leaves what its particles touch by themselves.
    pub(crate) fn project(
        &mut self,
        particles: &mut Particles,
        (world, nearby): (&World, &Nearby),
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
            self.find_missed_pairs(particles, world, nearby, from);
        }
        if self.wide_contacts.is_empty() && self.loose.is_empty() {
            return;
        }
        self.place_static_geometry(world, from, to);
        self.refresh_manifolds(world, from);
        self.follow_kinematic_geometry(world, from);
        let most = |share: (f32, f32)| in_substep(share, h, world.g());
        let (recover, max_depenetration) = (most(RECOVERED), most(MAX_DEPENETRATION));
        let elastic_pop = MAX_DEPENETRATION.0 * world.g() * h * h;
        let Self { wide_contacts, bodies, instructions, fresh, .. } = self;
        if core::mem::take(fresh) {
            predict_impulses(wide_contacts, bodies, *instructions);
        }
        solve_all_friction(wide_contacts, false, max_depenetration, bodies, *instructions);
        let pops = [max_depenetration, elastic_pop];
        let sweeps = wide_contacts.iter().map(|wide| wide.sweeps).max().unwrap_or(0);
        for sweep in 0..sweeps {
            solve_normals(wide_contacts, bodies, h, recover, pops, sweep, *instructions);
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
            if pressed.is_empty() || turn + 1 == TURNS || !cloth.hold(particles, beside, pressed) {
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

    /// Rows of single particles that body colliders may come to touch in this step, each as often as there are such.
    pub(crate) fn rows_near_shapes(&self) -> impl Iterator<Item = u32> {
        self.loose.rows()
    }

    /// Gives the contact cache back at the end of a step.
    pub(crate) fn keep(&mut self, cache: &mut ContactCache) {
        self.note_friction_anchors(self.h);
        self.cache.give(cache);
    }

    /// What has touched what.
    pub(crate) fn report(&mut self, impacts: &mut Impacts) {
        self.note_contact_events();
        for contact_events in self.contact_events.drain(..) {
            impacts.add(
                contact_events.participants,
                contact_events.point,
                contact_events.normal,
                contact_events.impulse,
                false,
            );
        }
        for sensor_overlaps in self.sensor_overlaps.drain(..) {
            impacts.add(
                sensor_overlaps.participants,
                sensor_overlaps.point,
                sensor_overlaps.normal,
                0.0,
                true,
            );
        }
    }

    /// How deep body colliders were in each other or in static geometry when the last substep began, metres: the first row of each that was, and the most
    /// that the substep before has left.
    pub(crate) fn overlaps(&mut self) -> impl Iterator<Item = (u32, f32)> {
        let Self { wide_contacts, groups, deepest, .. } = self;
        deepest.clear();
        deepest.resize(groups.padded(), 0.0);
        for wide in wide_contacts.iter() {
            for (&row, &left) in wide.a.iter().chain(&wide.b).zip(wide.left.iter().cycle()) {
                // What stands, and nothing, have the rows behind those of body colliders.
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

    /// Adds the contact events of the wide contacts so far.
    fn note_contact_events(&mut self) {
        let Self { contacts, wide_contacts, swept, bodies, groups, contact_events, h, .. } = self;
        for wide in wide_contacts.iter_mut().filter(|wide| wide.kept) {
            for lane in 0..LANES {
                let Some(one) = contacts.get(wide.number[lane] as usize) else { continue };
                if !one.reports_events || wide.total[lane] <= 0.0 {
                    continue;
                }
                let vector = |v: &[LaneArray; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
                let a = one.a as usize;
                let centre = bodies[groups.place(a)][CENTRE].truncate();
                let point = swept[a].origin + (centre + vector(&wide.arm));
                let (normal, impulse) = (vector(&wide.up), wide.total[lane] / *h);
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

    /// Notes the friction anchors after a substep of `h` seconds.
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

    /// Poses as predicted, and how they got there, so many seconds after the step began; and who has left its swept bounds.
    fn extract_poses(&mut self, particles: &Particles, time: f32) {
        self.outside_bounds.clear();
        self.read.clear();
        self.read.resize(self.groups.groups.len(), !0);
        for number in 0..self.groups.groups.len() {
            let first = number * LANES;
            let (mut left, lanes, asleep) = (0, self.rigid.lanes(number), self.asleep[number]);
            let mut read = !0;
            if self.groups.groups[number].lines {
                left = self.lines_left(number, &particles.position, time) & !(lanes | asleep);
                read = (self.met[number] | left) & !(lanes | asleep);
                self.read[number] = read;
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

    /// Displaces the particles as their body colliders were.
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
            if lanes != group.sound && self.read[number] != 0 {
                self.apply_pose_delta(number, !lanes, &mut particles.position, None);
            }
        }
        for (row, by) in self.shared.iter() {
            particles.position[row as usize] += by;
        }
    }
}
