//! Dormant islands: sleepers that a step does not visit.
//!
//! A group that has slept for as long as is counted sleeps on unless one of its particles is written to, something that it depends on changes, or something
//! awake comes near. Writes and changes are recorded elsewhere, so checking them takes a few comparisons; and each awake island queries a grid of the bounds of
//! all dormant ones. If any check fails, all islands are visited, as in a step without dormancy, and with the same result.

use core::ops::Range;

use glam::{Vec3, Vec4};

use super::{SleepScratch, TIME_TO_SLEEP, gusts};
use crate::collide::Broad;
use crate::islands::Islands;
use crate::particles::Particles;
use crate::simulation::Simulation;

/// What dormancy depends on, besides writes to particles and what comes near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SleepInputs {
    /// Lengths of the step and of a substep, seconds: bounds depend on the first, and the velocity of a sleeper is the mean over the second.
    dt: f32,
    lag: f32,
    /// Magnitude of gravity, m/s².
    gravity: f32,
    /// [Edits](crate::Particles::edits), the revision of `contacts`, and the hashes of static geometry, of springs and of ignored pairs.
    support: [u64; 5],
    /// Revision of `sleep`.
    sleep: u64,
    /// Coulomb constant: charges repel each other.
    electric: f32,
}

/// Dormant islands.
#[derive(Default)]
pub(super) struct Dormant {
    /// Inputs of the last step; `None` if no island is dormant.
    inputs: Option<SleepInputs>,
    /// Counts the sets of dormant islands found so far.
    count: u64,
    /// For each island whether it is dormant, and for each body whether one of its islands is.
    of: Vec<bool>,
    of_bodies: Vec<bool>,
    /// Ranges of rows of dormant islands that can move when awake, and their inverse masses, one after the other.
    rows: Vec<Range<usize>>,
    masses: Vec<f32>,
    /// Bounds of the dormant islands, and a grid over them.
    bounds: Vec<(Vec3, Vec3)>,
    broad: Broad,
    near: Vec<u32>,
}

impl Dormant {
    /// Makes the next step visit all islands.
    pub(super) fn forget(&mut self) {
        self.inputs = None;
    }

    /// Whether no island is dormant.
    pub(super) fn is_empty(&self) -> bool {
        self.inputs.is_none()
    }

    /// A number that identifies the present set of dormant islands; 0 if there are none.
    pub(super) fn number(&self) -> u64 {
        if self.is_empty() { 0 } else { self.count }
    }

    /// Pins the rows, with zero velocity. Everything else is as the step before left it.
    pub(super) fn stop(&self, particles: &mut Particles, still: Vec4) {
        for rows in self.rows() {
            particles.position[rows.clone()].iter_mut().for_each(|position| position.w = 0.0);
            particles.velocity[rows.clone()].fill(still);
        }
    }

    /// Restores their masses.
    pub(super) fn wake(&self, particles: &mut Particles) {
        let mut masses = self.masses.iter();
        for rows in self.rows() {
            for (position, &w) in particles.position[rows.clone()].iter_mut().zip(&mut masses) {
                position.w = w;
            }
        }
    }

    /// Whether an island of this body is dormant: then its visited islands, which are loose pins, do not decide whether the body sleeps.
    pub(super) fn is_of_body(&self, body: u32) -> bool {
        !self.is_empty() && self.of_bodies.get(body as usize).is_some_and(|&own| own)
    }

    fn rows(&self) -> &[Range<usize>] {
        if self.is_empty() { &[] } else { &self.rows }
    }

    /// Lists the islands that are not dormant, and ranges of rows that contain theirs.
    pub(super) fn others(
        &self,
        islands: &Islands,
        others: &mut Vec<u32>,
        rows: &mut Vec<Range<usize>>,
    ) {
        let count = islands.list.len() as u32;
        if self.is_empty() {
            others.clear();
            others.extend(0..count);
            rows.clear();
            rows.push(0..islands.of.len());
        } else if others.len() == count as usize {
            others.retain(|&number| !self.of[number as usize]);
            rows.clear();
            for (row, &number) in islands.of.iter().enumerate() {
                if self.of[number as usize] {
                    continue;
                }
                lengthen(rows, row);
            }
        }
    }

    /// Whether one of these islands comes near a dormant one; `bounds` are those of all islands.
    pub(super) fn is_near(&mut self, these: &[u32], bounds: &[(Vec3, Vec3)]) -> bool {
        let Self { inputs, bounds: own, broad, near, .. } = self;
        near.clear();
        inputs.is_some()
            && these.iter().any(|&number| {
                broad.query(&bounds[number as usize], own, near);
                !near.is_empty()
            })
    }
}

/// Appends a row to ascending ranges.
fn lengthen(rows: &mut Vec<Range<usize>>, row: usize) {
    match rows.last_mut() {
        Some(last) if last.end == row => last.end += 1,
        _ => rows.push(row..row + 1),
    }
}

impl Simulation {
    /// What sleepers depend on in a step of `dt` seconds.
    pub(super) fn sleep_inputs(&self, dt: f32, support: [u64; 5]) -> SleepInputs {
        SleepInputs {
            dt,
            lag: self.settings.integrator.lag(self.scratch.substep.length),
            gravity: self.forces.gravity.length(),
            support,
            sleep: self.sleep.revision(),
            electric: self.forces.electric.constant,
        }
    }

    /// Whether the dormant islands of the last step need no visit in this one, unless something comes near them.
    pub(super) fn stays_dormant(&self, dormant: &Dormant, inputs: &SleepInputs) -> bool {
        let Self { particles, forces, boundaries, settings, .. } = self;
        let islands = &self.scratch.plan.islands.of;
        let is_dormant = |row: u32| {
            let island = islands.get(row as usize);
            island.is_some_and(|&island| dormant.of[island as usize])
        };
        let controls = forces.controls.iter().filter(|control| !control.is_idle());
        dormant.inputs.as_ref() == Some(inputs)
            && !settings.statics
            && self.compounds.is_empty()
            && forces.springs.is_empty()
            && gusts::max_gust_pressure(forces) == 0.0
            && self.colliders.iter().all(|collider| collider.start == collider.end)
            && particles.touched().is_some_and(|rows| !rows.iter().any(|&row| is_dormant(row)))
            && !controls.flat_map(|control| &control.rows).any(|&row| is_dormant(row))
            && !boundaries.pins.iter().any(|pin| is_dormant(pin.particle))
    }

    /// Records which islands are dormant from this step on, if all islands were visited.
    pub(super) fn note_dormant(&mut self, sleepers: &mut SleepScratch, inputs: SleepInputs) {
        let SleepScratch { dormant, masses, activities, groups, bounds, visited, .. } = sleepers;
        let islands = &mut self.scratch.plan.islands;
        let mut is_long_asleep = |number: u32| {
            let group = activities[groups.root(number) as usize];
            // At this limit `still` is not counted up any more, so that `sleep` stays unchanged.
            islands.list[number as usize].asleep && group.still >= 2.0 * TIME_TO_SLEEP
        };
        let now = SleepInputs { sleep: self.sleep.revision(), ..inputs };
        if !dormant.is_empty() {
            // When others have slept for as long, all are visited again.
            dormant.inputs = (!visited.iter().any(|&number| is_long_asleep(number))).then_some(now);
            if dormant.is_empty() {
                let rows = dormant.rows.iter().flat_map(Clone::clone).map(|row| row as u32);
                masses.extend(rows.zip(dormant.masses.iter().copied()));
            }
            return;
        }
        let Dormant { count, of, of_bodies, rows, masses: own, bounds: boxes, broad, .. } = dormant;
        of.clear();
        of.extend((0..islands.list.len() as u32).map(is_long_asleep));
        if !of.contains(&true) {
            return;
        }
        boxes.clear();
        boxes.extend(of.iter().zip(&*bounds).filter(|(own, _)| **own).map(|(_, bounds)| *bounds));
        broad.fill(boxes);
        masses.sort_unstable_by_key(|&(row, _)| row);
        rows.clear();
        own.clear();
        masses.retain(|&(row, w)| {
            let is_own = of[islands.of[row as usize] as usize];
            if is_own {
                lengthen(rows, row as usize);
                own.push(w);
            }
            !is_own
        });
        of_bodies.clear();
        of_bodies.resize(self.sleep.len(), false);
        for row in rows.iter().flat_map(Clone::clone) {
            if let Some(own) = of_bodies.get_mut(self.particles.body[row] as usize) {
                *own = true;
            }
        }
        *count += 1;
        islands.dormant.clone_from(of);
        dormant.inputs = Some(now);
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::collide::{BodyContacts, Collider, Combine, ContactParticipant, Frame, Shape};
    use crate::constraints::{Distance, InsideBox, Pin, Plane};
    use crate::forces::{Control, Hull, Skin, Spring, Wind};
    use crate::particles::ParticleSeed;
    use crate::recipes::{BoxSpec, box_3d};
    use crate::rigid::Compound;
    use crate::simulation::Sleep;

    /// One box on another, two beside them, a static ball, and a box that stays awake.
    fn level() -> Simulation {
        let mut world = Simulation::default();
        world.boundaries.planes.push(Plane::ground(0.0));
        let contacts = BodyContacts { with_bodies: true, ..Default::default() };
        for (x, y) in [(0.0, 0.5), (0.05, 1.5), (2.0, 0.5), (3.02, 0.5), (12.0, 0.5)] {
            let at = Vec3::new(x, y, 0.0);
            let cube = box_3d(&BoxSpec::default()).unwrap().transformed(Quat::IDENTITY, at);
            cube.build_colliding(&mut world, contacts).unwrap();
        }
        let ball = Frame::at(Vec3::new(-3.0, 0.5, 0.0));
        world.colliders.push(Collider::fixed(Shape::sphere(0.5).unwrap(), ball));
        world.sleep.resize(5, Sleep::allowed());
        world.sleep[4].keeps_awake = true;
        for _ in 0..150 {
            world.step(1.0 / 60.0).unwrap();
        }
        world
    }

    fn count(world: &Simulation) -> usize {
        let dormant = &world.scratch.sleep_scratch.0.dormant;
        if dormant.is_empty() { 0 } else { dormant.of.iter().filter(|own| **own).count() }
    }

    #[test]
    fn long_sleepers_are_dormant_until_something_comes_near() {
        let mut world = level();
        assert_eq!(count(&world), 4);
        (32..40).for_each(|row| world.particles.set_velocity(row, Vec3::X * -14.0));
        let mut visited_again = false;
        for _ in 0..90 {
            world.step(1.0 / 60.0).unwrap();
            visited_again |= count(&world) == 0;
        }
        assert!(visited_again);
        assert!(world.particles.position(24).x < 2.5, "the last one was hit");
    }

    /// A door's post of pinned particles was all that was visited while the door slept, and the door was reported awake; in a copy of the world it was asleep.
    #[test]
    fn pins_alone_do_not_decide_how_their_body_sleeps_until_they_are_moved() {
        let mut world = level();
        let at = Vec3::new(0.0, 3.0, 4.0);
        let post = world.particles.push(ParticleSeed::at(at).pinned()).unwrap();
        world.particles.set_body(post as usize, Some(0));
        for step in 0..150 {
            world.step(1.0 / 60.0).unwrap();
            assert!(world.sleep[0].asleep || step < 90, "{step}");
        }
        assert_eq!(count(&world), 4);
        world.boundaries.pins.push(Pin { particle: post, target: at + Vec3::X });
        world.step(1.0 / 60.0).unwrap();
        assert!(!world.sleep[0].asleep && world.sleep[0].still == 0.0);
    }

    /// The step wrote to the particles of rigid bodies in the way that outside writes do, and so woke them once anything slept.
    #[test]
    fn rigid_bodies_fall_asleep_beside_sleepers() {
        let mut world = Simulation::default();
        world.boundaries.planes.push(Plane::ground(0.0));
        for (number, y) in [0.5, 3.0].into_iter().enumerate() {
            let at = Vec3::new(4.0 * number as f32, y, 0.0);
            let cube = box_3d(&BoxSpec::default()).unwrap();
            let rest = cube.parts[0].rest.clone();
            let rows = cube.transformed(Quat::IDENTITY, at).build(&mut world).unwrap();
            world.compounds_mut().push(Compound::new(rows, rest));
        }
        world.sleep.resize(2, Sleep::allowed());
        let mut first = None;
        for step in 0..400 {
            world.step(1.0 / 60.0).unwrap();
            first = first.or((world.sleep[0].asleep && !world.sleep[1].asleep).then_some(step));
        }
        assert!(first.is_some(), "one slept while the other fell");
        assert!(world.sleep.iter().all(|body| body.asleep), "{:?}", world.sleep);
    }

    /// A triangle between three corners of a box.
    fn hull(first: u32) -> Hull {
        let rows = vec![first, first + 1, first + 2];
        Hull::new(rows, vec![[0, 1, 2]], Skin::Carriers).unwrap()
    }

    /// Planes and boxes, the rules by which materials combine, and drags were missing in the support hash: sleepers stayed in the air when the ground was gone.
    /// So were the plane of a 2D world, which did not move sleepers into it, and hulls: what floated asleep did not sink when it lost its hull.
    #[test]
    fn a_change_of_bounds_or_of_materials_wakes_sleepers() {
        type Change = fn(&mut Simulation);
        let changes: [(&str, Change, bool); 12] = [
            ("nothing", |_| {}, false),
            ("no ground", |world| world.boundaries.planes.clear(), true),
            ("lower ground", |world| world.boundaries.planes[0].offset = -1.0, true),
            ("a plane far below", |world| world.boundaries.planes.push(Plane::ground(-9.0)), false),
            ("a smaller box", |world| world.boundaries.boxes[0].max.y = 0.5, true),
            ("a smoother wall far away", |world| world.boundaries.boxes[0].friction = 0.1, false),
            ("a sticky ground", |world| world.boundaries.planes[0].drag.along = 0.9, true),
            ("a rule", |world| world.contacts[0].material.friction_rule = Combine::Max, true),
            ("a drag", |world| world.contacts[0].material.drag.across = 0.5, true),
            (
                "two dimensions",
                |world| world.boundaries.plane_constraint = Plane::new(Vec3::Z, Vec3::Z),
                true,
            ),
            ("a hull", |world| world.forces.hulls.push(hull(0)), true),
            ("another body's hull", |world| world.forces.hulls.push(hull(16)), false),
        ];
        for (name, change, wakes) in changes {
            let mut world = level();
            world.boundaries.boxes.push(InsideBox::new(Vec3::splat(-90.0), Vec3::splat(90.0)));
            for _ in 0..150 {
                world.step(1.0 / 60.0).unwrap();
            }
            assert!(world.sleep[0].asleep, "{name}");
            change(&mut world);
            world.step(1.0 / 60.0).unwrap();
            assert_eq!(world.sleep[0].asleep, !wakes, "{name}");
        }
    }

    /// Shapes and ignored pairs were missing in the support hash, and all meshes had one hash, and all heightfields: a box slept on in the air when the ground
    /// below it was dug away, when its own shape or that of the box below shrank, and when it ignored what it lay on.
    #[test]
    fn a_change_of_shapes_or_of_ignored_pairs_wakes_sleepers() {
        use ContactParticipant::{Body, Collider as Ground};
        type Change = fn(&mut Simulation);
        let field = |height: f32| {
            Shape::height_field(2, 2, &[height; 4], Vec3::new(30.0, 1.0, 30.0)).unwrap()
        };
        let mesh = |height: f32| {
            let corner = |x: f32, z: f32| Vec3::new(x, height, z);
            let corners = [corner(-30.0, -30.0), corner(-30.0, 90.0), corner(90.0, -30.0)];
            Shape::mesh(corners.to_vec(), vec![[0, 1, 2]]).unwrap()
        };
        fn cube(size: f32) -> Shape {
            Shape::cuboid(Vec3::splat(size)).unwrap()
        }
        let grounds: [&dyn Fn(f32) -> Shape; 2] = [&field, &mesh];
        let changes: [(&str, Change, bool); 7] = [
            ("nothing", |_| {}, false),
            ("a smaller box", |world| world.body_colliders_mut()[0].shape = cube(0.9), true),
            ("a smaller box on it", |world| world.body_colliders_mut()[1].shape = cube(0.9), true),
            ("another smaller box", |world| world.body_colliders_mut()[2].shape = cube(0.9), false),
            ("a box ignores the ground", |world| world.ignored.push([Body(0), Ground(0)]), true),
            ("a box ignores a box", |world| world.ignored.push([Body(1), Body(0)]), true),
            ("others ignore each other", |world| world.ignored.push([Body(2), Body(3)]), false),
        ];
        for ground in grounds {
            let mut level = level();
            level.boundaries.planes.clear();
            level.colliders[0] = Collider::fixed(ground(0.0), Frame::IDENTITY);
            for _ in 0..150 {
                level.step(1.0 / 60.0).unwrap();
            }
            let is_awake = |world: &Simulation| !world.sleep[0].asleep && !world.sleep[1].asleep;
            for (name, change, wakes) in &changes {
                let mut world = level.clone();
                assert!(world.sleep[0].asleep && world.sleep[1].asleep, "{name}");
                change(&mut world);
                world.step(1.0 / 60.0).unwrap();
                assert_eq!(is_awake(&world), *wakes, "{name}");
            }
            level.colliders[0].shape = ground(-1.0);
            level.step(1.0 / 60.0).unwrap();
            assert!(is_awake(&level));
        }
    }

    /// A spring between two sleepers woke a copy of the world at once, and the world itself only when something else happened: a rollback to a saved state gave
    /// another result.
    #[test]
    fn a_spring_wakes_sleepers_of_a_world_and_of_its_copy_in_the_same_step() {
        for (change, wakes) in [("one more", true), ("a stiffer one", true), ("the same", false)] {
            let mut world = level();
            let spring = Spring { a: 0, b: 8, rest: 1.0, stiffness: 10.0, damping: 0.1 };
            if change != "one more" {
                world.forces.springs.push(spring);
                for _ in 0..150 {
                    world.step(1.0 / 60.0).unwrap();
                }
            }
            assert!(world.sleep[0].asleep && world.sleep[1].asleep, "{change}");
            match change {
                "one more" => world.forces.springs.push(spring),
                "a stiffer one" => world.forces.springs[0].stiffness = 1e3,
                _ => {}
            }
            let mut copy = world.clone();
            world.step(1.0 / 60.0).unwrap();
            copy.step(1.0 / 60.0).unwrap();
            assert_eq!(world.sleep[0].asleep, !wakes, "{change}");
            assert!(world.sleep == copy.sleep, "{change}");
        }
    }

    /// A rollback that puts earlier particles into a world must give what a copy of it gives, which has no record of dormant islands: for sleepers that have
    /// been elsewhere meanwhile, and for pins.
    #[test]
    fn particles_that_are_restored_sleep_as_in_a_copy() {
        let pin = |world: &mut Simulation, row: usize| {
            let body = world.particles.body(row);
            world.particles.set(row, world.particles.seed(row).pinned()).unwrap();
            world.particles.set_body(row, body);
        };
        let step = |world: &mut Simulation| world.step(1.0 / 60.0).map(drop).unwrap();
        for what in ["a sleeper was elsewhere", "another one was pinned"] {
            let mut world = level();
            let earlier = world.particles.clone();
            if what == "a sleeper was elsewhere" {
                let rows: Vec<u32> = (24..32).collect();
                world.particles.teleport(&rows, Vec3::Z * 3.0, Quat::IDENTITY);
                world.check_sleepers();
                (0..200).for_each(|_| step(&mut world));
                assert_eq!(count(&world), 4, "{what}: all lie still");
                world.particles = earlier;
            } else {
                pin(&mut world, 32);
                step(&mut world);
                world.particles = earlier;
                pin(&mut world, 8);
                world.particles.set_velocity(33, Vec3::new(-3.0, 1.0, 0.0));
            }
            let mut copy = world.clone();
            copy.scratch.settings_inputs = None;
            for tick in 0..60 {
                step(&mut world);
                step(&mut copy);
                let same = world.particles.position == copy.particles.position
                    && world.particles.velocity == copy.particles.velocity
                    && world.contact_cache == copy.contact_cache
                    && world.sleep == copy.sleep;
                assert!(same, "{what}, tick {tick}");
                let free = |world: &Simulation, row: usize| {
                    let islands = &world.scratch.plan.islands;
                    islands.list[islands.of[row] as usize].free
                };
                assert!([8, 32].iter().all(|&row| free(&world, row) == free(&copy, row)), "{what}");
            }
        }
    }

    /// Writes, changes around them, and things that come near: the result is the same, to the last bit, as where all islands are visited.
    #[test]
    fn dormancy_changes_no_bit() {
        type Edit = fn(&mut Simulation);
        let edits: [(&str, Edit); 25] = [
            ("nothing", |_| {}),
            ("a velocity", |world| world.particles.set_velocity(0, Vec3::X)),
            ("none", |world| world.particles.set_velocity(0, Vec3::ZERO)),
            ("an impulse", |world| world.particles.apply_impulse(&[8, 9], Vec3::X)),
            ("a place", |world| world.particles.displace(9, Vec3::Y * 0.1)),
            ("a teleport", |world| {
                let rows: Vec<u32> = (16..24).collect();
                world.particles.teleport(&rows, Vec3::Y, Quat::IDENTITY);
                world.check_sleepers();
            }),
            ("a force", |world| world.particles.set_external_force(0, Vec3::Y * 100.0)),
            ("a mass", |world| {
                let seed = ParticleSeed { mass: 9.0, ..world.particles.seed(0) };
                world.particles.set(0, seed).unwrap();
                world.particles.set_body(0, Some(0));
            }),
            ("a wake", |world| world.particles.wake(20)),
            ("a particle", |world| {
                let seed = ParticleSeed::at(Vec3::new(2.0, 3.0, 0.0)).with_radius(0.1);
                world.particles.push(seed).unwrap();
            }),
            ("gravity", |world| world.forces.gravity = Vec3::new(8.0, -9.81, 0.0)),
            ("a wind", |world| world.forces.winds.push(Wind::steady(Vec3::X * 100.0))),
            ("a spring", |world| {
                let (rest, stiffness, damping) = (0.1, 1e4, 1.0);
                world.forces.springs.push(Spring { a: 0, b: 39, rest, stiffness, damping });
            }),
            ("a control", |world| {
                let jet = Control::force("jet", [0_u32, 1, 2, 3], Vec3::Y * 500.0);
                world.forces.controls.push(jet);
            }),
            ("a tie", |world| world.distances_mut().push(Distance::new(0, 39, 5.0))),
            ("a lower ground", |world| world.boundaries.planes[0].offset = -1.0),
            ("a pin", |world| {
                let target = world.particles.position(26) + Vec3::Y;
                world.boundaries.pins.push(Pin { particle: 26, target });
            }),
            ("a ball that comes", |world| {
                world.colliders[0].end = Frame::at(Vec3::new(-0.6, 0.5, 0.0));
            }),
            ("a body that touches nothing", |world| world.contacts[0].disabled = true),
            ("a pair that is ignored", |world| {
                world.ignored.push([0, 1].map(ContactParticipant::Body));
            }),
            ("a lost cache", |world| world.contact_cache.clear()),
            ("one that wakes", |world| world.sleep[2].still = 0.0),
            ("other substeps", |world| world.settings.substeps = 7),
            ("a box that comes near", |world| {
                (32..40).for_each(|row| world.particles.set_velocity(row, Vec3::X * -14.0));
            }),
            ("a box that falls on them", |world| {
                let rows: Vec<u32> = (32..40).collect();
                let by = Vec3::new(-9.4, 2.5, 0.1);
                world.particles.teleport(&rows, by, Quat::from_rotation_z(0.3));
            }),
        ];
        let bits = |world: &Simulation| -> Vec<u32> {
            let all = world.particles.position.iter().chain(&world.particles.velocity);
            all.flat_map(Vec4::to_array).map(f32::to_bits).collect()
        };
        let (level, mut moved) = (level(), 0);
        for (what, edit) in edits {
            let (mut world, mut all_visited) = (level.clone(), level.clone());
            let mut before = Vec::new();
            for tick in 0..100 {
                if tick == 5 {
                    assert_eq!((count(&world), count(&all_visited)), (4, 0), "{what}");
                    before = bits(&world);
                    edit(&mut world);
                    edit(&mut all_visited);
                }
                world.step(1.0 / 60.0).unwrap();
                all_visited.step(1.0 / 60.0).unwrap();
                assert_eq!(bits(&world), bits(&all_visited), "{what}, tick {tick}");
                assert!(world.sleep == all_visited.sleep, "{what}, tick {tick}");
                assert!(world.contact_cache == all_visited.contact_cache, "{what}, tick {tick}");
                let error = |world: &Simulation| world.report().error.to_bits();
                assert_eq!(error(&world), error(&all_visited), "{what}, tick {tick}");
                all_visited.scratch.sleep_scratch.0.dormant.forget();
            }
            moved += usize::from(bits(&world) != before);
        }
        assert!(moved > 12, "{moved} of them move something");
    }
}
