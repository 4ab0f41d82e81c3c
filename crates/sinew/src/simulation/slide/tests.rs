//! Move and slide: walls, corners, slopes, steps, floors with inner edges, every shape, a range of speeds, and rest.

use glam::Quat;

use super::*;
use crate::collide::{Collider, ContactParticipant};
use crate::constraints::{InsideBox, Plane};
use crate::recipes::{BoxSpec, ClothSpec, box_3d, cloth_grid};
use crate::test_random::Random;

const SKIN: f32 = 0.01;

fn world(solids: &[(Shape, Frame)]) -> Simulation {
    let mut world = Simulation::default();
    let fixed = solids.iter().map(|(shape, frame)| Collider::fixed(shape.clone(), *frame));
    world.colliders.extend(fixed);
    world
}

fn block(size: Vec3, at: Vec3) -> (Shape, Frame) {
    (Shape::cuboid(size).unwrap(), Frame::at(at))
}

/// Turned about z, in degrees.
fn turned((shape, frame): (Shape, Frame), degrees: f32) -> (Shape, Frame) {
    (shape, Frame::new(frame.translation, about_z(degrees)))
}

fn about_z(degrees: f32) -> Quat {
    let half = 0.5 * degrees.to_radians();
    Quat::from_xyzw(0.0, 0.0, libm::sinf(half), libm::cosf(half))
}

fn about_y(degrees: f32) -> Quat {
    let half = 0.5 * degrees.to_radians();
    Quat::from_xyzw(0.0, libm::sinf(half), 0.0, libm::cosf(half))
}

/// A floor whose top is at 0.
fn floor() -> (Shape, Frame) {
    block(Vec3::new(40.0, 1.0, 40.0), Vec3::NEG_Y * 0.5)
}

fn shapes() -> [(&'static str, Shape); 4] {
    [
        ("ball", Shape::sphere(0.4).unwrap()),
        ("capsule", Shape::capsule(0.3, 1.2).unwrap()),
        ("box", Shape::cuboid(Vec3::new(0.5, 1.8, 0.6)).unwrap()),
        ("cylinder", Shape::cylinder(0.3, 1.6).unwrap()),
    ]
}

/// Distance from a shape's origin down to its lowest point.
fn foot(shape: &Shape) -> f32 {
    -shape.bounds().0.y
}

fn go(world: &Simulation, shape: &Shape, at: Vec3, velocity: Vec3, dt: f32) -> SlideOutput {
    let (config, all) = (SlideConfig::default(), Filter::default());
    world.move_and_slide(shape, &Frame::at(at), velocity, dt, &config, &all)
}

/// Least distance to anything within a metre.
fn clear(world: &Simulation, shape: &Shape, at: Vec3) -> f32 {
    let frame = Frame::at(at);
    let (low, high) = shape.bounds_in(&frame);
    let mut least = f32::INFINITY;
    world.obstacles((low - 1.0, high + 1.0), &Filter::default(), &mut |_, _, obstacle| {
        shape.contacts(&frame, 1.0, obstacle, &mut |hit| least = least.min(hit.distance));
    });
    least
}

/// A character as a game writes it: it keeps the remaining velocity, and falls.
fn fall(
    world: &Simulation,
    shape: &Shape,
    (mut at, mut velocity): (Vec3, Vec3),
    dt: f32,
    seconds: f32,
    mut each: impl FnMut(&SlideOutput),
) -> (Vec3, Vec3) {
    for _ in 0..(seconds / dt) as u32 {
        velocity.y -= 9.81 * dt;
        let out = go(world, shape, at, velocity, dt);
        (at, velocity) = (out.translation, out.velocity);
        each(&out);
    }
    (at, velocity)
}

#[test]
fn what_rests_stays_to_the_last_bit_on_the_level_and_on_slopes() {
    for (name, shape) in shapes() {
        for slope in [0.0_f32, 10.0, 30.0, 44.0] {
            for (dt, aside) in [(1.0 / 60.0, 0.0), (1.0 / 30.0, 2.7), (1.0 / 240.0, 0.0)] {
                let ramp = block(Vec3::new(60.0, 2.0, 20.0), Vec3::NEG_Y * 2.0);
                let world = world(&[turned(ramp, slope)]);
                let start = Vec3::new(aside, 4.0 + foot(&shape), 0.3 * aside);
                let (at, _) = fall(&world, &shape, (start, Vec3::ZERO), dt, 2.0, |_| {});
                assert!((clear(&world, &shape, at) - SKIN).abs() < 0.03 * SKIN, "{name} {slope}");
                let (later, velocity) = fall(&world, &shape, (at, Vec3::ZERO), dt, 10.0, |out| {
                    let ground = out.ground.unwrap();
                    assert_eq!(ground.participant, ContactParticipant::Collider(0));
                    let up = libm::cosf(slope.to_radians());
                    assert!((ground.normal.y - up).abs() < 1e-4, "{name} {slope} {ground:?}");
                });
                assert_eq!(later, at, "{name} {slope} {dt}");
                assert_eq!(velocity, Vec3::ZERO, "{name} {slope} {dt}");
                let still = go(&world, &shape, at, Vec3::ZERO, dt);
                assert_eq!((still.translation, still.ground.is_some()), (at, true));
            }
        }
    }
}

/// In a short step it falls by less than the skin pushes back, yet must not sink in bit by bit.
#[test]
fn what_rests_does_not_sink_in_steps_of_a_tenth_of_a_millisecond() {
    for (name, shape) in shapes() {
        let world = world(&[floor()]);
        let start = Vec3::new(0.2, foot(&shape) + SKIN, 0.1);
        let (at, _) = fall(&world, &shape, (start, Vec3::ZERO), 1e-4, 0.2, |_| {});
        let (later, _) = fall(&world, &shape, (at, Vec3::ZERO), 1e-4, 1.0, |_| {});
        let sunk = start.y - later.y;
        assert!((at.y - later.y).abs() < 1e-5 && sunk < 0.05 * SKIN, "{name}: {sunk}");
    }
}

#[test]
fn what_rests_on_triangles_between_blocks_and_far_out_stays_too() {
    let (mesh, field) = grids(0.37);
    let half = |x: f32| block(Vec3::new(2.0, 1.0, 4.0), Vec3::new(x, -0.5, 0.0));
    let far = Vec3::new(800.0, 0.0, -500.0);
    let moved = (floor().0, Frame::at(far - Vec3::Y * 0.5));
    let grounds = [
        (vec![(mesh, Frame::IDENTITY)], Vec3::ZERO),
        (vec![(field, Frame::IDENTITY)], Vec3::ZERO),
        (vec![half(-1.0), half(1.0)], Vec3::ZERO),
        (vec![moved], far),
    ];
    for (number, (solids, centre)) in grounds.into_iter().enumerate() {
        let world = world(&solids);
        for (name, shape) in shapes() {
            for aside in [0.0, 0.185, 0.37, 0.011] {
                let start = centre + Vec3::new(aside, 0.5 + foot(&shape), 0.7 * aside);
                let (at, _) = fall(&world, &shape, (start, Vec3::ZERO), 1.0 / 60.0, 1.0, |_| {});
                assert!((at - start).with_y(0.0).length() < 1e-5, "{number} {name} {at} {start}");
                let (later, _) = fall(&world, &shape, (at, Vec3::ZERO), 1.0 / 60.0, 10.0, |_| {});
                assert_eq!(later, at, "{number} {name} {aside}");
            }
        }
    }
}

/// The same flat floor as a mesh and as a heightfield, with squares of a given width.
fn grids(width: f32) -> (Shape, Shape) {
    let count = 61;
    let at = |i: usize| (i as f32 - 30.0) * width;
    let vertices = (0..count * count).map(|i| Vec3::new(at(i % count), 0.0, at(i / count)));
    let corner = |i: usize, j: usize| (j * count + i) as u32;
    let mut triangles = Vec::new();
    for i in 0..count - 1 {
        for j in 0..count - 1 {
            triangles.push([corner(i, j), corner(i, j + 1), corner(i + 1, j)]);
            triangles.push([corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)]);
        }
    }
    let mesh = Shape::mesh(vertices.collect(), triangles).unwrap();
    let size = Vec3::new(60.0 * width, 1.0, 60.0 * width);
    let field = Shape::height_field(count, count, &vec![0.0; count * count], size).unwrap();
    (mesh, field)
}

#[test]
fn no_wall_is_passed_at_any_speed_in_any_step() {
    let thin = block(Vec3::new(1e-3, 8.0, 8.0), Vec3::new(100.0005, 0.0, 0.0));
    let sheet = Shape::mesh(
        vec![Vec3::new(100.0, -9.0, -9.0), Vec3::new(100.0, 9.0, -9.0), Vec3::new(100.0, 0.0, 9.0)],
        vec![[0, 1, 2]],
    );
    let plane = (Shape::half_space(), Frame::new(Vec3::X * 100.0, about_z(90.0)));
    let ball = (Shape::sphere(3.0).unwrap(), Frame::at(Vec3::X * 103.0));
    for (number, wall) in
        [thin, (sheet.unwrap(), Frame::IDENTITY), plane, ball].into_iter().enumerate()
    {
        let world = world(&[wall]);
        for (name, shape) in shapes() {
            let reach = shape.bounds().1.x;
            for speed in [0.01_f32, 1.0, 30.0, 1e3, 1e5] {
                for dt in [1.0 / 240.0, 1.0 / 60.0, 0.1, 1.0] {
                    // Starts where a tenth of the way would lead beyond the wall, or at least 2 cm before it.
                    let start = 100.0 - reach - SKIN - (0.9 * speed * dt).max(0.02);
                    let start = Vec3::new(start, 0.0, 0.0);
                    let meets = 0.9 * speed * dt >= 0.02;
                    let out = go(&world, &shape, start, Vec3::X * speed, dt);
                    let gap = 100.0 - reach - out.translation.x;
                    let case = format!("{number} {name} {speed} {dt}: {gap}");
                    let grain = 1e-6 * start.x.abs().max(100.0);
                    if meets {
                        assert!((gap - SKIN).abs() < 0.03 * SKIN + grain, "{case}");
                        assert!(out.velocity.length() < 1e-4 * speed, "{case} {}", out.velocity);
                        assert_eq!(out.hits.len(), 1, "{case}");
                    } else {
                        assert!(out.hits.is_empty() && out.velocity == Vec3::X * speed, "{case}");
                    }
                    // The same once more, from the new position.
                    let again = go(&world, &shape, out.translation, Vec3::X * speed, dt);
                    let gap = 100.0 - reach - again.translation.x;
                    assert!(gap > 0.97 * SKIN - grain, "{case} {gap}");
                }
            }
        }
    }
}

/// A room with obstacles, and random velocities for many ticks: the shape never leaves the room or overlaps anything.
#[test]
fn nothing_leaves_a_room_at_any_speed() {
    let wall = |axis: Vec3| block(Vec3::splat(10.2) - axis.abs() * 10.15, axis * 5.025);
    let mut solids: Vec<(Shape, Frame)> =
        Vec3::AXES.iter().flat_map(|&axis| [wall(axis), wall(-axis)]).collect();
    solids.push(turned(block(Vec3::new(3.0, 1.0, 2.0), Vec3::new(1.0, -4.0, 1.0)), 20.0));
    solids.push((Shape::capsule(0.5, 3.0).unwrap(), Frame::at(Vec3::new(-3.0, -3.0, 2.0))));
    let cone: Vec<Vec3> = (0..7)
        .map(|i| Vec3::new(libm::cosf(0.9 * i as f32), 0.0, libm::sinf(0.9 * i as f32)))
        .chain([Vec3::Y * 1.5])
        .collect();
    solids.push((Shape::hull(&cone).unwrap(), Frame::at(Vec3::new(2.0, -5.0, -3.0))));
    solids.push(turned((Shape::cylinder(0.6, 4.0).unwrap(), Frame::at(Vec3::Z * -2.0)), 70.0));
    let world = world(&solids);
    let mut random = Random::new(12345);
    for (name, shape) in shapes() {
        let mut at = Vec3::new(-1.0, 2.0, 2.0);
        for tick in 0..1500 {
            let speed = libm::powf(10.0, 1.5 + 3.5 * random.number());
            let velocity = random.vector() * speed;
            let dt = [1.0 / 60.0, 1.0 / 240.0, 0.1][tick % 3];
            let out = go(&world, &shape, at, velocity, dt);
            let way = (out.translation - at).length();
            at = out.translation;
            assert!(way <= 1.001 * velocity.length() * dt + 0.2 * SKIN, "{name} {tick}: {way}");
            assert!(at.abs().max_element() < 5.0, "{name} {tick}: {at}");
            let gap = clear(&world, &shape, at);
            assert!(gap > 0.9 * SKIN, "{name} {tick}: {gap} at {at} by {velocity} {out:?}");
            assert!(out.velocity.length() <= 1.001 * velocity.length(), "{name} {tick}");
            for hit in &out.hits {
                assert!(hit.normal.is_normalized() && hit.point.is_finite(), "{hit:?}");
            }
        }
    }
}

#[test]
fn along_a_wall_it_keeps_what_leads_along() {
    let wall = block(Vec3::new(1.0, 8.0, 60.0), Vec3::X * 3.5);
    let world = world(&[wall]);
    for (name, shape) in shapes() {
        for (speed, dt) in [(1.0, 1.0 / 60.0), (5.0, 1.0 / 30.0), (40.0, 0.1)] {
            let mut at = Vec3::new(3.0 - shape.bounds().1.x - 0.02, 0.0, -10.0);
            let start = at;
            let wish = Vec3::new(0.6, 0.0, 0.8) * speed;
            for tick in 0..60.min((15.0 / (speed * dt)) as u32) {
                let out = go(&world, &shape, at, wish, dt);
                let along = out.translation.z - at.z;
                assert!(
                    (along - 0.8 * speed * dt).abs() < 1e-3 * speed * dt + 1e-5,
                    "{name} {tick}"
                );
                at = out.translation;
            }
            assert!(at.z > start.z && (clear(&world, &shape, at) - SKIN).abs() < 0.03 * SKIN);
        }
    }
}

/// Two walls that meet at an angle, along y; the motion is along x into the edge between them.
fn corner(degrees: f32) -> Simulation {
    let wall = |side: f32| {
        let half = about_y(0.5 * side * degrees);
        let away = Frame::new(Vec3::ZERO, half);
        let inner = Vec3::new(-10.0, 0.0, side * 0.5);
        (
            Shape::cuboid(Vec3::new(20.0, 8.0, 1.0)).unwrap(),
            Frame { translation: away.turn(inner), ..away },
        )
    };
    world(&[wall(1.0), wall(-1.0)])
}

#[test]
fn in_a_corner_of_any_angle_it_stops_and_stays() {
    for degrees in [30.0, 60.0, 90.0, 120.0, 150.0, 175.0] {
        let world = corner(degrees);
        for (name, shape) in shapes() {
            for (aside, speed) in [(0.0, 2.0), (0.3, 2.0), (-0.2, 50.0), (0.4, 1e4)] {
                let wish = Vec3::new(1.0, 0.0, aside).normalize() * speed;
                let mut at = Vec3::new(-6.0, 0.0, 0.1);
                let mut places = Vec::new();
                for _ in 0..400 {
                    let out = go(&world, &shape, at, wish, 1.0 / 60.0);
                    at = out.translation;
                    places.push(at);
                }
                let case = format!("{degrees} {name} {aside} {speed}: {at}");
                // A velocity that leads into one wall but not into the other continues along the other, if the corner is obtuse.
                let into = libm::sinf((0.5 * degrees).to_radians()) * aside.abs();
                let against = libm::cosf((0.5 * degrees).to_radians());
                if into < 0.9 * against || aside == 0.0 {
                    assert_eq!(places[399], places[380], "{case}");
                    assert!((clear(&world, &shape, at) - SKIN).abs() < 0.03 * SKIN, "{case}");
                    assert!(at.x < 0.0, "{case}");
                }
                assert!(clear(&world, &shape, at) > 0.94 * SKIN || at.x > 0.0, "{case}");
            }
        }
    }
}

/// Two posts with too small a gap between them.
#[test]
fn between_two_posts_it_stops_and_stays() {
    let post = |z: f32| (Shape::cylinder(0.2, 8.0).unwrap(), Frame::at(Vec3::Z * z));
    let edge = |z: f32| block(Vec3::new(1.0, 8.0, 0.3), Vec3::new(0.4, 0.0, z));
    for (number, solids) in
        [[post(0.4), post(-0.4)], [edge(0.35), edge(-0.35)], [post(0.4), edge(-0.35)]]
            .iter()
            .enumerate()
    {
        let world = world(solids);
        for (name, shape) in shapes() {
            for (aside, speed) in [(0.0, 2.0), (0.1, 2.0), (-0.2, 50.0), (0.05, 0.1)] {
                if name == "box" && aside != 0.0 {
                    // A flat face in contact with a face slides along it and past it.
                    continue;
                }
                let wish = Vec3::new(1.0, 0.0, aside).normalize() * speed;
                let mut at = Vec3::new(-1.0, 0.0, 0.02 - aside);
                let mut before = at;
                for _ in 0..(6.0 / speed * 60.0) as u32 + 60 {
                    before = at;
                    at = go(&world, &shape, at, wish, 1.0 / 60.0).translation;
                }
                let case = format!("{number} {name} {aside} {speed}: {at} {before}");
                assert!((at - before).length() < 1e-5 * (1.0 + speed), "{case}");
                assert!(clear(&world, &shape, at) > 0.94 * SKIN && at.x < 0.0, "{case}");
            }
        }
    }
}

#[test]
fn in_a_corner_of_a_room_it_falls_along_the_edge_and_lands() {
    let walls = [
        block(Vec3::new(1.0, 30.0, 20.0), Vec3::new(3.5, 0.0, 0.0)),
        block(Vec3::new(20.0, 30.0, 1.0), Vec3::new(0.0, 0.0, 3.5)),
        floor(),
    ];
    let world = world(&walls);
    for (name, shape) in shapes() {
        let (mut at, mut velocity, mut stands) = (Vec3::new(0.0, 8.0, 0.4), Vec3::ZERO, false);
        let mut last = at;
        for tick in 0..240 {
            velocity = Vec3::new(4.0, velocity.y - 9.81 / 60.0, 4.0);
            let out = go(&world, &shape, at, velocity, 1.0 / 60.0);
            assert!(stands || out.velocity.y < 0.0 || tick > 60, "{name} {tick}");
            stands = out.ground.is_some();
            last = at;
            (at, velocity) = (out.translation, out.velocity);
        }
        assert!(stands && at == last, "{name}: {at} {last}");
        let high = shape.bounds().1;
        let corner = Vec3::new(3.0 - high.x - SKIN, foot(&shape) + SKIN, 3.0 - high.z - SKIN);
        assert!((at - corner).length() < 0.05 * SKIN, "{name} {at} {corner}");
    }
}

/// Walks with a given horizontal velocity, as in a game; the vertical velocity carries over from tick to tick.
fn walk(
    world: &Simulation,
    shape: &Shape,
    (mut at, wish): (Vec3, Vec3),
    dt: f32,
    seconds: f32,
    mut each: impl FnMut(&SlideOutput),
) -> Vec3 {
    let mut fall = 0.0;
    for _ in 0..(seconds / dt) as u32 {
        fall -= 9.81 * dt;
        let out = go(world, shape, at, wish + Vec3::Y * fall, dt);
        at = out.translation;
        fall = out.velocity.y;
        each(&out);
    }
    at
}

#[test]
fn a_slope_below_the_limit_is_walked_up_and_down() {
    for (name, shape) in shapes() {
        for slope in [5.0_f32, 20.0, 30.0, 43.0] {
            for dt in [1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0] {
                let ramp = block(Vec3::new(60.0, 2.0, 20.0), Vec3::NEG_Y * 2.0);
                let world = world(&[turned(ramp, slope)]);
                let start = Vec3::new(0.0, 2.0 + foot(&shape), 0.0);
                let (start, _) = fall(&world, &shape, (start, Vec3::ZERO), dt, 2.0, |_| {});
                let tan = libm::tanf(slope.to_radians());
                let up = walk(&world, &shape, (start, Vec3::X * 2.0), dt, 2.0, |out| {
                    assert!(out.ground.is_some(), "{name} {slope} {dt} {out:?}");
                });
                let gone = up - start;
                assert!(gone.x > 1.9, "{name} {slope} {dt}: {gone}");
                assert!((gone.y - gone.x * tan).abs() < 2e-3, "{name} {slope} {dt}: {gone}");
                let mut air = 0;
                let down = walk(&world, &shape, (up, Vec3::NEG_X * 2.0), dt, 2.0, |out| {
                    air += u32::from(out.ground.is_none());
                });
                let gone = down - up;
                assert!(gone.x < -3.9 && gone.x > -4.1, "{name} {slope} {dt}: {gone}");
                assert!((gone.y - gone.x * tan).abs() < 0.15, "{name} {slope} {dt}: {gone}");
                // It turns round with the upward velocity that it has, and so jumps.
                assert!((air as f32) < 0.5 / dt, "{name} {slope} {dt}: {air} ticks in the air");
            }
        }
    }
}

#[test]
fn a_slope_above_the_limit_is_a_wall_from_below_and_a_slide_from_above() {
    for (name, shape) in shapes() {
        for slope in [50.0_f32, 65.0, 80.0] {
            let ramp = turned(block(Vec3::new(20.0, 2.0, 20.0), Vec3::ZERO), slope);
            let foothill = libm::sinf(slope.to_radians());
            let world = world(&[floor(), ramp]);
            let start = Vec3::new(-8.0, foot(&shape) + SKIN, 0.0);
            let wish = Vec3::new(3.0, 0.0, 0.5);
            let at = walk(&world, &shape, (start, wish), 1.0 / 60.0, 4.0, |_| {});
            assert!((at.y - start.y).abs() < 0.05 * SKIN, "{name} {slope} {foothill}: {at}");
            assert!(at.z > 1.9, "along it: {name} {slope} {at}");
            let onto = Vec3::new(0.3, 12.0, 0.0);
            let (down, _) = fall(&world, &shape, (onto, Vec3::ZERO), 1.0 / 60.0, 4.0, |_| {});
            assert!((down.y - start.y).abs() < 0.05 * SKIN, "{name} {slope}: {down}");
            assert!(down.x < onto.x, "{name} {slope}: {down}");
        }
    }
}

#[test]
fn a_ceiling_ends_a_leap_and_nothing_else() {
    let world = world(&[floor(), block(Vec3::new(40.0, 1.0, 40.0), Vec3::Y * 3.5)]);
    for (name, shape) in shapes() {
        let start = Vec3::new(0.0, foot(&shape) + SKIN, 0.0);
        let out = go(&world, &shape, start, Vec3::new(2.0, 300.0, 0.0), 1.0 / 60.0);
        assert!(out.velocity.abs_diff_eq(Vec3::X * 2.0, 1e-3), "{name} {out:?}");
        assert!(out.ground.is_none(), "{name}");
        assert!((out.translation.x - 2.0 / 60.0).abs() < 1e-4, "{name} {out:?}");
        assert!(
            (3.0 - shape.bounds().1.y - SKIN - out.translation.y).abs() < 0.03 * SKIN,
            "{name}"
        );
        // After a jump it has no ground, however short the tick.
        let out = go(&world, &shape, start, Vec3::Y * 3.0, 1e-4);
        assert!(out.ground.is_none() && out.velocity == Vec3::Y * 3.0, "{name}");
    }
}

#[test]
fn steps_stop_what_is_not_round_enough_to_roll_over_them() {
    for (name, shape) in shapes() {
        for (height, climbed) in [(0.35, false), (0.2, false), (0.05, true)] {
            let step = block(Vec3::new(10.0, 2.0, 10.0), Vec3::new(7.0, height - 1.0, 0.0));
            let world = world(&[floor(), step]);
            let start = Vec3::new(0.0, foot(&shape) + SKIN, 0.0);
            let at = walk(&world, &shape, (start, Vec3::X * 2.0), 1.0 / 60.0, 3.0, |_| {});
            let round = matches!(name, "ball" | "capsule");
            let rise = if climbed && round { height } else { 0.0 };
            assert!((at.y - start.y - rise).abs() < 0.05 * SKIN, "{name} {height}: {at}");
            assert!((at.x > 5.0) == (rise > 0.0), "{name} {height}: {at}");
            // And down again, without a stop at the edge.
            let top = Vec3::new(5.0, height + foot(&shape) + SKIN, 0.0);
            let down = walk(&world, &shape, (top, Vec3::NEG_X * 2.0), 1.0 / 60.0, 3.0, |_| {});
            assert!(
                (down.y - start.y).abs() < 0.05 * SKIN && down.x < -0.9,
                "{name} {height}: {down}"
            );
        }
    }
}

#[test]
fn edges_within_a_floor_are_no_bumps() {
    let (mesh, field) = grids(0.31);
    let tiles: Vec<_> = (0..20)
        .flat_map(|i| (0..20).map(move |j| (i, j)))
        .map(|(i, j)| {
            let at = Vec3::new(i as f32 - 9.5, -0.5, j as f32 - 9.5) * Vec3::new(0.93, 1.0, 0.93);
            block(Vec3::new(0.93, 1.0, 0.93), at)
        })
        .collect();
    let floors = [vec![(mesh, Frame::IDENTITY)], vec![(field, Frame::IDENTITY)], tiles];
    for (number, solids) in floors.iter().enumerate() {
        let world = world(solids);
        for (name, shape) in shapes() {
            for (speed, dt) in
                [(0.3, 1.0 / 60.0), (2.0, 1.0 / 60.0), (9.0, 1.0 / 30.0), (3.0, 1e-3)]
            {
                let wish = Vec3::new(0.83, 0.0, 0.557_76).normalize() * speed;
                let start = Vec3::new(-5.0, foot(&shape) + SKIN, -3.0);
                let seconds = 300.0 * dt;
                let seconds = if speed * seconds > 10.0 { 10.0 / speed } else { seconds };
                let at = walk(&world, &shape, (start, wish), dt, seconds, |out| {
                    let case = format!("{number} {name} {speed} {dt} {out:?}");
                    assert!((out.translation.y - start.y).abs() < 0.04 * SKIN, "{case}");
                    assert!(out.ground.is_some_and(|ground| ground.normal.y > 0.999), "{case}");
                    let level = out.velocity.with_y(0.0);
                    assert!((level - wish).length() < 2e-3 * speed, "{case}");
                });
                let ticks = (seconds / dt) as u32 as f32;
                let expected = start + wish * ticks * dt;
                assert!(
                    (at - expected).with_y(0.0).length() < 2e-3 * speed * seconds,
                    "{number} {name}"
                );
            }
        }
    }
}

#[test]
fn what_overlaps_it_pushes_it_out_and_too_narrow_a_place_leaves_it_in_the_middle() {
    for (name, shape) in shapes() {
        let only_floor = world(&[floor()]);
        for depth in [0.005, 0.1, 0.3] {
            let start = Vec3::new(1.0, foot(&shape) - depth, 0.0);
            let out = go(&only_floor, &shape, start, Vec3::ZERO, 1.0 / 60.0);
            let gap = clear(&only_floor, &shape, out.translation);
            assert!((gap - SKIN).abs() < 0.06 * SKIN, "{name} {depth}: {gap}");
            assert!((out.translation - start).with_y(0.0).length() < 1e-3, "{name} {out:?}");
        }
        let high = shape.bounds().1;
        for room in [0.012, 0.0, -0.02] {
            let side =
                |s: f32| block(Vec3::new(1.0, 8.0, 8.0), Vec3::X * s * (0.5 + high.x + 0.5 * room));
            let world = world(&[side(1.0), side(-1.0)]);
            let mut at = Vec3::X * 0.3 * room.abs();
            for _ in 0..30 {
                at = go(&world, &shape, at, Vec3::Z, 1.0 / 60.0).translation;
            }
            assert!(at.x.abs() < 0.02 * SKIN, "{name} {room}: {at}");
            let before = at;
            at = go(&world, &shape, at, Vec3::ZERO, 1.0 / 60.0).translation;
            assert_eq!(at, before, "{name} {room}");
        }
    }
}

#[test]
fn planes_boxes_bodies_cloth_and_particles_are_in_the_way() {
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    let room = InsideBox {
        min: Vec3::splat(-8.0),
        max: Vec3::splat(8.0),
        friction: 0.5,
        restitution: 0.0,
    };
    world.boundaries.boxes.push(room);
    let cube = box_3d(&BoxSpec::default()).unwrap();
    let cube = cube.transformed(Quat::IDENTITY, Vec3::new(4.0, 0.5, 0.0));
    cube.build_colliding(&mut world, Default::default()).unwrap();
    let sheet = Quat::from_xyzw(0.0, 1.0, 0.0, 1.0);
    let cloth = cloth_grid(&ClothSpec::default()).unwrap();
    let cloth = cloth.transformed(sheet, Vec3::new(-4.0, 0.8, 0.0));
    cloth.build_colliding(&mut world, Default::default()).unwrap();
    let seed = crate::particles::ParticleSeed::at(Vec3::new(0.0, 0.6, 4.0)).with_radius(0.3);
    world.particles.push(seed).unwrap();
    world.forces.gravity = Vec3::ZERO;
    world.step(1e-3).unwrap();
    let ball = Shape::sphere(0.4).unwrap();
    let start = Vec3::new(0.0, 0.45, 0.0);
    let met = |velocity: Vec3| {
        let out = go(&world, &ball, start, velocity, 1.0);
        assert!(clear(&world, &ball, out.translation) > 0.95 * SKIN, "{velocity} {out:?}");
        out.hits.first().map(|hit| hit.participant)
    };
    assert_eq!(met(Vec3::NEG_Y * 1e3), Some(ContactParticipant::Plane(0)));
    assert_eq!(met(Vec3::Y * 1e3), Some(ContactParticipant::Box(0)));
    assert_eq!(met(Vec3::X * 1e3), Some(ContactParticipant::Body(0)));
    assert_eq!(met(Vec3::NEG_X * 1e3), Some(ContactParticipant::Body(1)));
    assert!(matches!(met(Vec3::Z * 1e3), Some(ContactParticipant::Particle(_))));
    assert_eq!(met(Vec3::NEG_Z * 1e3), Some(ContactParticipant::Box(0)));
    // A ray cast and an overlap query find the same.
    let all = Filter::default();
    let ray = world.cast_ray(start, Vec3::NEG_Y, 9.0, &all).unwrap();
    assert_eq!(ray.participant, ContactParticipant::Plane(0));
    assert!((ray.distance - 0.45).abs() < 1e-6 && ray.normal.abs_diff_eq(Vec3::Y, 1e-6));
    let mut found = Vec::new();
    let low = Frame::at(Vec3::new(7.8, 0.1, 0.0));
    world.overlaps(&ball, &low, &all, |participant, _| found.push(participant));
    assert_eq!(found, [ContactParticipant::Plane(0), ContactParticipant::Box(0)]);
    let bodies = Filter { colliders: false, ..all };
    assert_eq!(world.cast_ray(start, Vec3::NEG_Y, 9.0, &bodies), None);
    let not_it = Filter { except: Some(ContactParticipant::Plane(0)), ..all };
    let past = world.cast_ray(start, Vec3::NEG_Y, 9.0, &not_it).unwrap();
    assert_eq!(past.participant, ContactParticipant::Box(0));
}

/// A crate thrown at the character pushes it aside, tick by tick; it never ends up inside the crate.
#[test]
fn what_comes_at_it_pushes_it_away() {
    for (name, shape) in shapes() {
        for speed in [0.5, 3.0, 12.0] {
            let mut world = Simulation::default();
            world.boundaries.planes.push(Plane::ground(0.0).with_friction(0.0));
            let cube = box_3d(&BoxSpec::default()).unwrap();
            let cube = cube.transformed(Quat::IDENTITY, Vec3::new(-2.0, 0.5, 0.1));
            let rows = cube.build_colliding(&mut world, Default::default()).unwrap();
            for row in rows {
                world.particles.set_velocity(row, Vec3::X * speed);
            }
            let (mut at, mut velocity) = (Vec3::new(0.0, foot(&shape) + SKIN, 0.0), Vec3::ZERO);
            for tick in 0..(4.0 / speed * 60.0) as u32 {
                world.step(1.0 / 60.0).unwrap();
                velocity.y -= 9.81 / 60.0;
                let out = go(&world, &shape, at, velocity, 1.0 / 60.0);
                (at, velocity) = (out.translation, out.velocity);
                let gap = clear(&world, &shape, at);
                assert!(gap > 0.9 * SKIN, "{name} {speed} {tick}: {gap}");
                assert!((at.y - foot(&shape) - SKIN).abs() < 0.1 * SKIN, "{name} {tick} {at}");
            }
            assert!(at.x > 0.5, "{name} {speed}: {at}");
        }
    }
}

#[test]
fn broken_numbers_move_nothing_and_settings_are_clamped() {
    let world = world(&[floor()]);
    let (shape, all) = (Shape::capsule(0.3, 1.2).unwrap(), Filter::default());
    let (at, config) = (Vec3::Y * 2.0, SlideConfig::default());
    let ask = |shape: &Shape, at: Vec3, velocity: Vec3, dt: f32, config: &SlideConfig| {
        world.move_and_slide(shape, &Frame::at(at), velocity, dt, config, &all)
    };
    let still = SlideOutput { translation: at, ..SlideOutput::default() };
    for velocity in [Vec3::NAN, Vec3::INFINITY, Vec3::X * f32::NAN] {
        assert_eq!(ask(&shape, at, velocity, 0.1, &config), still);
    }
    for dt in [f32::NAN, f32::INFINITY, -1.0] {
        assert_eq!(ask(&shape, at, Vec3::X, dt, &config), still);
    }
    for up in [Vec3::ZERO, Vec3::NAN] {
        assert_eq!(ask(&shape, at, Vec3::X, 0.1, &SlideConfig { up, ..config }), still);
    }
    assert!(ask(&shape, Vec3::NAN, Vec3::X, 0.1, &config).translation.is_nan());
    assert_eq!(ask(&shape, at, Vec3::ZERO, 0.1, &config), still);
    assert_eq!(ask(&shape, at, Vec3::X, 0.0, &config).translation, at);
    for dents in [Shape::half_space(), grids(0.5).0] {
        assert_eq!(ask(&dents, at, Vec3::X, 0.1, &config), still, "{dents:?}");
    }
    // Found by fuzzing: it was pushed out of something too large for `f32`, to NaN.
    let huge = Frame::at(Vec3::new(1e38, -3e38, 2e38));
    let out = world.move_and_slide(&shape, &huge, Vec3::ONE, 1.0, &config, &all);
    assert!(out.translation.is_finite(), "{out:?}");
    let broken = SlideConfig {
        max_slope: f32::NAN,
        skin_width: f32::NAN,
        iterations: 0,
        depenetration_iterations: u32::MAX,
        up: Vec3::Y * 7.0,
    };
    let out = ask(&shape, at, Vec3::NEG_Y * 1e4, 0.1, &broken);
    assert!(out.translation.y > 0.9 && out.translation.y < 0.91, "{out:?}");
    assert!(config.is_floor(Vec3::Y) && !config.is_floor(Vec3::X));
    let slope = |degrees: f32| about_z(degrees) * Vec3::Y;
    assert!(config.is_floor(slope(45.0)) && !config.is_floor(slope(46.0)));
    // Gravity along x.
    let aside = SlideConfig { up: Vec3::X, ..config };
    assert!(aside.is_floor(Vec3::X) && !aside.is_floor(Vec3::Y));
}
