//! Rows K1 to K3: rolling, slipping and spinning of round shapes, on what stands still and on what turns.

use sinew::glam::{Quat, Vec3};
use sinew::pose::{Motion, motion};
use sinew::recipes::{BoxLayout, BoxSpec, box_3d};
use sinew::{BodyContacts, Collider, Frame, Material, Shape, Simulation};

use crate::Row;
use crate::case::cases;
use crate::measure::{G, TICK, largest, spin, steps};

cases! {
    "K1" round_shapes_roll_down_a_slope_by_their_inertia;
    "K2" with_too_little_friction_they_slip_and_spin_by_coulombs_law;
    "K3" a_ball_rolls_on_over_the_level;
    "K3" a_ball_without_friction_keeps_its_spin;
    "K3" a_ball_on_a_turntable_circles_at_two_sevenths_of_its_rate;
    "K3" a_box_on_a_turntable_stays_where_it_was_set_down;
}

/// Radius of all round shapes here, metres.
const RADIUS: f32 = 0.5;

/// A round shape: its name, its collision shape, the size of the box with the same moments of inertia, and its moment of inertia about the rolling axis divided
/// by `m r²`.
struct Round {
    name: &'static str,
    shape: Shape,
    size: Vec3,
    inertia: f64,
}

/// A ball, a capsule with the inertia of a solid ball, and a solid cylinder; the axes of the last two are y.
fn round() -> [Round; 3] {
    // A cube of side s has m s²/6, a ball 2/5 m r², a cylinder 1/2 m r² about its axis. Across the axis a cylinder of the same height as the box has the same
    // moment as the box.
    let (ball, cylinder) = (RADIUS * libm::sqrtf(2.4), RADIUS * libm::sqrtf(3.0));
    let shape = |shape: Result<Shape, _>| shape.expect("a sound shape");
    [
        Round {
            name: "ball",
            shape: shape(Shape::sphere(RADIUS)),
            size: Vec3::splat(ball),
            inertia: 0.4,
        },
        Round {
            name: "capsule",
            shape: shape(Shape::capsule(RADIUS, 2.0)),
            size: Vec3::new(ball, 2.0, ball),
            inertia: 0.4,
        },
        Round {
            name: "cylinder",
            shape: shape(Shape::cylinder(RADIUS, 1.5)),
            size: Vec3::new(cylinder, 1.5, cylinder),
            inertia: 0.5,
        },
    ]
}

impl Round {
    /// A simulation with the shape on a ground, both with the same friction.
    fn on(&self, ground: &Shape, frames: [&Frame; 2], friction: f32, substeps: u32) -> Simulation {
        let [ground_at, at] = frames;
        let mut world = Simulation::default();
        world.settings.substeps = substeps;
        let material = Material::default().with_friction(friction);
        world.colliders.push(Collider::fixed(ground.clone(), *ground_at).with_material(material));
        let layout = BoxLayout::Equimomental;
        let spec = BoxSpec { size: self.size, mass: 2.0, layout, ..BoxSpec::default() };
        let mut body = box_3d(&spec).expect("a sound box");
        body.parts[0].shape = Some(self.shape.clone());
        // The axis lies horizontally, across the slope.
        let lies = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let body = body.transformed(lies, at.translation);
        let contacts = BodyContacts { material, ..Default::default() };
        body.build_colliding(&mut world, contacts).expect("room");
        world
    }
}

/// A slope down x: its frame, and three grounds with their frames: a plane, a box and a mesh.
fn slopes(degrees: f64) -> (Frame, [(Shape, Frame); 3]) {
    let half = 0.5 * degrees.to_radians();
    let turned = Quat::from_xyzw(0.0, 0.0, -libm::sin(half) as f32, libm::cos(half) as f32);
    let frame = Frame::new(Vec3::ZERO, turned);
    let corners = [(-40.0, -20.0), (40.0, -20.0), (40.0, 20.0), (-40.0, 20.0)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec();
    let plate = Shape::cuboid(Vec3::new(80.0, 1.0, 40.0)).expect("a sound box");
    let mesh = Shape::mesh(corners, vec![[0, 2, 1], [0, 3, 2]]).expect("two triangles");
    let below = Frame::new(frame.point(Vec3::Y * -0.5), turned);
    (frame, [(Shape::half_space(), frame), (plate, below), (mesh, frame)])
}

/// Distance in two seconds, metres; speed then, m/s; and angular speed, rad/s. Of each the value farthest from the expected one, over all grounds and numbers
/// of substeps.
fn down(
    round: &Round,
    degrees: f64,
    friction: f64,
    substeps: &[u32],
    expected: [f64; 3],
) -> [f64; 3] {
    let (frame, grounds) = slopes(degrees);
    let at = Frame::new(frame.point(Vec3::Y * RADIUS), Quat::IDENTITY);
    let mut worst = expected;
    for (ground, ground_at) in &grounds {
        for &substeps in substeps {
            let mut world = round.on(ground, [ground_at, &at], friction as f32, substeps);
            let axis = frame.turn(Vec3::X);
            let from = all(&world).barycentre.dot(axis);
            steps(&mut world, TICK, 120);
            let now = all(&world);
            let seen =
                [now.barycentre.dot(axis) - from, now.velocity.dot(axis), -now.angular_velocity.z]
                    .map(f64::from);
            for ((worst, seen), expected) in worst.iter_mut().zip(seen).zip(expected) {
                let off = (seen - expected).abs();
                if off.is_nan() || off > (*worst - expected).abs() {
                    *worst = seen;
                }
            }
        }
    }
    worst
}

/// The worst of a plane, a box and a mesh, with 4, 10 and 40 substeps; with 1.2 times the friction that rolling requires, `tan θ k / (1 + k)`, where `k` is the
/// moment of inertia divided by `m r²`.
fn round_shapes_roll_down_a_slope_by_their_inertia() -> Vec<Row> {
    let rows = round().into_iter().flat_map(|round| {
        [5.0, 20.0, 45.0].into_iter().flat_map(move |degrees: f64| {
            let k = round.inertia;
            let friction = 1.2 * libm::tan(degrees.to_radians()) * k / (1.0 + k);
            let a = G * libm::sin(degrees.to_radians()) / (1.0 + k);
            let expected = [2.0 * a, 2.0 * a, 2.0 * a / f64::from(RADIUS)];
            let [gone, _, spin] = down(&round, degrees, friction, &[4, 10, 40], expected);
            let name = round.name;
            [
                Row::relative(
                    format!("acceleration of a {name} that rolls down {degrees}°"),
                    "m/s²",
                    a,
                    gone / 2.0,
                    0.02,
                ),
                Row::relative(
                    "its angular speed after two seconds",
                    "rad/s",
                    expected[2],
                    spin,
                    0.02,
                ),
            ]
        })
    });
    rows.collect()
}

/// With 0.8 times that friction. From 20° on with 4 and 10 substeps only: at 40 the depth by which gravity presses the body in, 1.6e-6 m, is the rounding of a
/// position five metres down.
fn with_too_little_friction_they_slip_and_spin_by_coulombs_law() -> Vec<Row> {
    let rows = round().into_iter().flat_map(|round| {
        [5.0, 20.0, 45.0].into_iter().flat_map(move |degrees: f64| {
            let (k, angle) = (round.inertia, degrees.to_radians());
            let friction = 0.8 * libm::tan(angle) * k / (1.0 + k);
            let a = G * (libm::sin(angle) - friction * libm::cos(angle));
            let turns = friction * G * libm::cos(angle) / (k * f64::from(RADIUS));
            let expected = [2.0 * a, 2.0 * a, 2.0 * turns];
            let substeps: &[u32] = if degrees < 20.0 { &[4, 10, 40] } else { &[4, 10] };
            let [gone, _, spin] = down(&round, degrees, friction, substeps, expected);
            let name = round.name;
            [
                Row::relative(
                    format!("acceleration of a {name} that slips down {degrees}°"),
                    "m/s²",
                    a,
                    gone / 2.0,
                    0.02,
                ),
                Row::relative("its angular acceleration", "rad/s²", turns, spin / 2.0, 0.02),
            ]
        })
    });
    rows.collect()
}

/// A ball of 1 m/s on a floor: the largest error of its speed in ten seconds.
fn a_ball_rolls_on_over_the_level() -> Vec<Row> {
    let [ball, ..] = round();
    let at = Frame::new(Vec3::Y * RADIUS, Quat::IDENTITY);
    let row = |substeps: u32| {
        let floor = Shape::half_space();
        let mut world = ball.on(&floor, [&Frame::IDENTITY, &at], 0.5, substeps);
        thrown(&mut world, Vec3::X, Vec3::Z * (-1.0 / RADIUS));
        let off = (0..600).map(|_| {
            steps(&mut world, TICK, 1);
            f64::from((all(&world).velocity - Vec3::X).length())
        });
        let what =
            format!("change of the speed of a ball that rolls, in 10 s, {substeps} substeps");
        Row::at_most(what, "m/s", 0.01, largest(off))
    };
    [4, 10, 40].map(row).into()
}

/// Ten seconds on a floor without friction. With 40 substeps the error is 1.2e-3 at worst, because positions are rounded 24 000 times.
fn a_ball_without_friction_keeps_its_spin() -> Vec<Row> {
    let [ball, ..] = round();
    let at = Frame::new(Vec3::Y * RADIUS, Quat::IDENTITY);
    let row = |substeps: u32| {
        let floor = Shape::half_space();
        let mut world = ball.on(&floor, [&Frame::IDENTITY, &at], 0.0, substeps);
        let spins = Vec3::new(5.0, 1.0, -3.0);
        thrown(&mut world, Vec3::X, spins);
        let size = f64::from(spins.length());
        let off = (0..600).map(|_| {
            steps(&mut world, TICK, 1);
            f64::from((all(&world).angular_velocity - spins).length()) / size
        });
        let what = format!("change of the spin of a ball without friction, {substeps} substeps");
        Row::at_most(what, "", 1e-3, largest(off))
    };
    [4, 10].map(row).into()
}

/// The plate of a turntable with its surface at the height 0, and its frame after a number of ticks at a rate in rad/s.
fn turntable(radius: f32) -> Shape {
    Shape::cylinder(radius, 0.2).expect("a sound cylinder")
}

fn turned(rate: f64, tick: u32) -> Frame {
    let half = 0.5 * libm::fmod(rate * f64::from(tick) * f64::from(TICK), core::f64::consts::TAU);
    let turn = Quat::from_xyzw(0.0, libm::sin(half) as f32, 0.0, libm::cos(half) as f32);
    Frame::new(Vec3::Y * -0.1, turn)
}

/// Simulates one tick on a turntable.
fn turn_on(world: &mut Simulation, rate: f64, tick: u32) {
    let [start, end] = [tick, tick + 1].map(|tick| turned(rate, tick));
    (world.colliders[0].start, world.colliders[0].end) = (start, end);
    steps(world, TICK, 1);
}

/// It keeps `v - (2/7) ω × r`, so it runs in a circle wherever it is, here about the axis: released at 1 m with `v = (2/7) ω × r`, and with the spin with which it
/// does not slip.
fn a_ball_on_a_turntable_circles_at_two_sevenths_of_its_rate() -> Vec<Row> {
    let [ball, ..] = round();
    let (rate, at) = (2.0, Frame::new(Vec3::new(1.0, RADIUS, 0.0), Quat::IDENTITY));
    let rows = [4, 10, 40].into_iter().flat_map(|substeps| {
        let mut world = ball.on(&turntable(20.0), [&turned(rate, 0), &at], 0.5, substeps);
        let surface = Vec3::Y.cross(at.translation) * rate as f32;
        let velocity = surface * (2.0 / 7.0);
        let turns = Vec3::Y.cross(velocity - surface) / RADIUS;
        set_off(&mut world, at.translation, velocity, turns);
        let (mut angle, mut last) = (0.0, 0.0);
        let ticks = 1320;
        for tick in 0..ticks {
            turn_on(&mut world, rate, tick);
            let at = all(&world).barycentre.as_dvec3();
            let now = libm::atan2(-at.z, at.x);
            angle += libm::remainder(now - last, core::f64::consts::TAU);
            last = now;
        }
        let at = all(&world).barycentre.as_dvec3();
        let seconds = f64::from(ticks) * f64::from(TICK);
        // It is released between two substeps.
        let off = 0.02 / f64::from(substeps);
        let what = format!("circles of a ball for each turn of its turntable, {substeps} substeps");
        [
            Row::relative(what, "", 2.0 / 7.0, angle / (rate * seconds), 1e-3),
            Row::relative(
                "its distance from the axis after 22 s",
                "m",
                1.0,
                libm::hypot(at.x, at.z),
                off,
            ),
        ]
    });
    rows.collect()
}

/// At 1.5 m from the axis, for half a minute, at rates that use shares of the friction.
fn a_box_on_a_turntable_stays_where_it_was_set_down() -> Vec<Row> {
    let size = Vec3::splat(0.3);
    let shape = Shape::cuboid(size).expect("a sound box");
    let cube = Round { name: "box", shape, size, inertia: 0.0 };
    let at = Frame::new(Vec3::new(1.5, 0.15, 0.0), Quat::IDENTITY);
    let rows = [0.5, 0.9].into_iter().flat_map(|share| {
        let rate = libm::sqrt(share * 0.5 * G / f64::from(at.translation.x));
        let (cube, at) = (&cube, &at);
        [(4, 6e-3), (10, 1e-3), (40, 1e-3)].into_iter().map(move |(substeps, limit)| {
            let mut world = cube.on(&turntable(3.0), [&turned(rate, 0), at], 0.5, substeps);
            let turns = Vec3::Y * rate as f32;
            set_off(&mut world, at.translation, turns.cross(at.translation), turns);
            (0..1800).for_each(|tick| turn_on(&mut world, rate, tick));
            let now = turned(rate, 1800).rotation.transpose() * all(&world).barycentre;
            let moved = f64::from((now - at.translation).length());
            let what = format!(
                "way of a box on a turntable in 30 s, {share} of its friction, {substeps} substeps"
            );
            Row::at_most(what, "m", limit, moved)
        })
    });
    rows.collect()
}

/// Motion of the body, from the mean velocities of the last substep.
fn all(world: &Simulation) -> Motion {
    let particles = &world.particles;
    let point = |i| (particles.position(i), particles.velocity(i), particles.mass(i));
    motion((0..8).map(point)).expect("a compound of finite particles")
}

/// Sets a body that lies at the origin on the floor in motion with a velocity, m/s, and a spin about its centre, rad/s.
fn thrown(world: &mut Simulation, velocity: Vec3, turns: Vec3) {
    set_off(world, Vec3::Y * RADIUS, velocity, turns);
}

/// Sets a body with this centre in motion with a velocity, m/s, and a spin about its centre, rad/s.
fn set_off(world: &mut Simulation, centre: Vec3, velocity: Vec3, turns: Vec3) {
    // `spin` rotates about the origin.
    spin(world, 0..8, turns);
    for i in 0..8 {
        let about_centre = world.particles.velocity(i) - turns.cross(centre);
        world.particles.set_velocity(i, about_centre + velocity);
    }
}
