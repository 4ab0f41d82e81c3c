//! What is round rolls: its contact stays below it however it has turned (physics.md K1 to K3).

use super::*;
use crate::recipes::{BoxLayout, BoxSpec, box_3d};

/// Adds what has the moments of inertia of a solid sphere, 2/5 m r², about all axes.
fn add_ball(world: &mut Simulation, shape: Shape, radius: f32, at: Vec3, turned: Quat) -> usize {
    let size = Vec3::splat(radius * libm::sqrtf(2.4));
    let spec = BoxSpec { size, mass: 2.0, layout: BoxLayout::Equimomental, ..BoxSpec::default() };
    add(world, &box_3d(&spec).unwrap(), shape, at, turned)
}

/// How fast eight rows turn, rad/s.
fn spin(world: &Simulation, first: usize) -> Vec3 {
    let (at, moves) = (centre(world, first), velocity(world, first));
    let (mut moment, mut square) = (Vec3::ZERO, 0.0);
    for i in first..first + 8 {
        let arm = world.particles.position(i) - at;
        moment += arm.cross(world.particles.velocity(i) - moves);
        square += arm.length_squared();
    }
    // Of something round the moment about any axis is two thirds of Σ m r².
    moment / (square * (2.0 / 3.0))
}

/// A ball and a capsule that lies across the slope, of 0.5 m radius, on slopes of so many degrees down x (a half-space, a box, two triangles) with a
/// friction of so much of what they need to roll: tick by tick for two seconds at several numbers of substeps. Hands out how far and how fast they went
/// along the slope, and how they turn; and how far off it they got.
fn on_slopes(
    degrees: f32,
    share: f32,
    substeps: &[u32],
    mut each: impl FnMut(&str, [f32; 2], Vec3, f32),
) {
    let radius = 0.5;
    let tangent = libm::tanf(degrees.to_radians());
    let friction = share * 2.0 / 7.0 * tangent;
    let slope = turn(Vec3::Z, -degrees.to_radians());
    let frame = Frame::new(Vec3::ZERO, slope);
    let corners = [(-40.0, -20.0), (40.0, -20.0), (40.0, 20.0), (-40.0, 20.0)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec();
    let plates = [
        (Shape::half_space(), 0.0),
        (Shape::cuboid(Vec3::new(80.0, 1.0, 20.0)).unwrap(), -0.5),
        (Shape::mesh(corners, vec![[0, 2, 1], [0, 3, 2]]).unwrap(), 0.0),
    ];
    let shapes = [Shape::sphere(radius).unwrap(), Shape::capsule(radius, 2.0).unwrap()];
    for (plate, height) in &plates {
        for (shape, &substeps) in
            shapes.iter().flat_map(|shape| substeps.iter().map(move |substeps| (shape, substeps)))
        {
            let mut world = world();
            world.settings.substeps = substeps;
            let below = Frame::new(frame.point(Vec3::Y * *height), slope);
            let plate = Collider::fixed(plate.clone(), below).with_material(rough(friction));
            world.colliders.push(plate);
            contacts(&mut world, rough(friction));
            let (at, lies) = (frame.point(Vec3::Y * radius), core::f32::consts::FRAC_PI_2);
            let first = add_ball(&mut world, shape.clone(), radius, at, turn(Vec3::X, lies));
            step(&mut world, 2.0);
            let gone = frame.turn_back(centre(&world, first) - at);
            let speed = frame.turn_back(velocity(&world, first)).x;
            let off = gone.y.abs().max(gone.z.abs());
            let name = format!("{degrees} degrees, {substeps} substeps, {:?}", shape.kind());
            each(&name, [gone.x, speed], spin(&world, first), off);
        }
    }
}

#[test]
fn what_is_round_rolls_down_a_slope_at_five_sevenths_of_what_slides() {
    for degrees in [5.0, 20.0, 45.0] {
        let exact = 5.0 / 7.0 * 9.81 * libm::sinf(degrees * core::f32::consts::PI / 180.0);
        on_slopes(degrees, 1.2, &[4, 10, 40], |name, [gone, speed], spin, off| {
            assert!((gone / (2.0 * exact) - 1.0).abs() < 0.02, "{name}: {gone}");
            assert!((speed / (2.0 * exact) - 1.0).abs() < 0.02, "{name}: {speed}");
            assert!(
                (spin + Vec3::Z * (speed / 0.5)).length() < 0.01 * speed / 0.5,
                "{name}: {spin}"
            );
            assert!(off < 1e-3, "{name}: {off}");
        });
    }
}

#[test]
fn where_friction_is_too_little_it_slips_and_turns_as_that_has_it() {
    for degrees in [5.0, 20.0, 45.0] {
        let (sine, cosine) = libm::sincosf(degrees * core::f32::consts::PI / 180.0);
        let friction = 0.8 * 2.0 / 7.0 * sine / cosine;
        let exact = 9.81 * (sine - friction * cosine);
        let turns = friction * 9.81 * cosine / (0.4 * 0.5);
        // What presses in one of 40 substeps, 1.2e-6 m, is the rounding of a place that is so far down 45 degrees: K9.
        let substeps: &[u32] = if degrees < 45.0 { &[4, 10, 40] } else { &[4, 10] };
        on_slopes(degrees, 0.8, substeps, |name, [gone, speed], spin, off| {
            assert!((gone / (2.0 * exact) - 1.0).abs() < 0.02, "{name}: {gone}");
            assert!((speed / (2.0 * exact) - 1.0).abs() < 0.02, "{name}: {speed}");
            assert!((spin.z / (-2.0 * turns) - 1.0).abs() < 0.02, "{name}: {spin}");
            // A capsule that slips is steered by nothing, and by rounding: a millimetre on six metres.
            assert!(off < 3e-3, "{name}: {off}");
        });
    }
}

#[test]
fn a_ball_rolls_on_over_the_level_and_gains_nothing() {
    for substeps in [4, 10, 40] {
        let mut world = world();
        world.settings.substeps = substeps;
        floor(&mut world, rough(0.5));
        let ball = Shape::sphere(0.5).unwrap();
        let first = add_ball(&mut world, ball, 0.5, Vec3::Y * 0.5, Quat::IDENTITY);
        throw(&mut world, first, Vec3::X, Vec3::Z * -2.0);
        step(&mut world, 10.0);
        let v = velocity(&world, first);
        assert!((v.x - 1.0).abs() < 0.01 && v.with_x(0.0).length() < 0.01, "{substeps}: {v}");
    }
}

#[test]
fn a_ball_that_slides_is_slowed_as_coulomb_has_it_and_rolls_from_five_sevenths_on() {
    for (friction, substeps) in [(0.3, 4), (0.3, 10), (0.3, 40), (0.1, 10)] {
        let mut world = world();
        world.settings.substeps = substeps;
        floor(&mut world, rough(friction));
        let ball = Shape::sphere(0.5).unwrap();
        let first = add_ball(&mut world, ball, 0.5, Vec3::Y * 0.5, Quat::IDENTITY);
        throw(&mut world, first, Vec3::X * 5.0, Vec3::ZERO);
        let slides = 2.0 / 7.0 * 5.0 / (friction * 9.81);
        let ticks = libm::floorf(0.8 * slides * 60.0);
        step(&mut world, ticks / 60.0);
        let (v, w) = (velocity(&world, first), spin(&world, first));
        let slowed = friction * 9.81 * ticks / 60.0;
        assert!((v.x - (5.0 - slowed)).abs() < 0.02 * slowed, "{substeps}: {v}");
        assert!((w.z + 2.5 * slowed / 0.5).abs() < 0.02 * 5.0 * slowed, "{substeps}: {w}");
        step(&mut world, slides);
        let (v, w) = (velocity(&world, first), spin(&world, first));
        assert!((v.x - 25.0 / 7.0).abs() < 0.02 && (w.z + v.x / 0.5).abs() < 0.02, "{v} {w}");
    }
}

#[test]
fn without_friction_a_ball_keeps_its_spin() {
    let mut world = world();
    floor(&mut world, rough(0.0));
    let ball = Shape::sphere(0.5).unwrap();
    let first = add_ball(&mut world, ball, 0.5, Vec3::Y * 0.5, Quat::IDENTITY);
    throw(&mut world, first, Vec3::X, Vec3::new(5.0, 1.0, -3.0));
    step(&mut world, 10.0);
    let (v, w) = (velocity(&world, first), spin(&world, first));
    assert!(
        (v - Vec3::X).length() < 1e-3 && (w - Vec3::new(5.0, 1.0, -3.0)).length() < 0.01,
        "{v} {w}"
    );
}

#[test]
fn a_ball_that_rolls_is_the_same_on_a_box_and_under_one() {
    // A plate on four balls, pushed: all of them roll at half its speed.
    let mut world = world();
    floor(&mut world, rough(0.8));
    let ball = Shape::sphere(0.25).unwrap();
    let mut balls = Vec::new();
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let at = Vec3::new(x, 0.25, z);
        balls.push(add_ball(&mut world, ball.clone(), 0.25, at, Quat::IDENTITY));
    }
    let plate = add_box(&mut world, Vec3::new(4.0, 0.2, 4.0), 4.0, Vec3::Y * 0.6, Quat::IDENTITY);
    throw(&mut world, plate, Vec3::X, Vec3::ZERO);
    for &first in &balls {
        throw(&mut world, first, Vec3::X * 0.5, Vec3::Z * -2.0);
    }
    step(&mut world, 1.0);
    let v = velocity(&world, plate);
    assert!((v.x - 1.0).abs() < 0.02 && v.with_x(0.0).length() < 0.02, "{v}");
    for &first in &balls {
        let v = velocity(&world, first);
        assert!((v.x - 0.5).abs() < 0.02 && v.with_x(0.0).length() < 0.02, "{v}");
    }
}

#[test]
fn two_balls_that_spin_and_hit_each_other_keep_momentum_and_angular_momentum() {
    for material in [rough(0.0), rough(0.6), elastic(1.0), rough(0.4).with_restitution(0.5)] {
        let mut world = world();
        world.forces.gravity = Vec3::ZERO;
        contacts(&mut world, material);
        let ball = Shape::sphere(0.5).unwrap();
        let a = add_ball(&mut world, ball.clone(), 0.5, Vec3::ZERO, Quat::IDENTITY);
        let b = add_ball(&mut world, ball, 0.5, Vec3::new(1.5, 0.3, 0.1), Quat::IDENTITY);
        throw(&mut world, a, Vec3::X * 2.0, Vec3::new(1.0, 3.0, -2.0));
        throw(&mut world, b, Vec3::X * -1.0, Vec3::new(0.0, 2.0, 4.0));
        let (before, spins) = (super::kept::sums(&world), [spin(&world, a), spin(&world, b)]);
        step(&mut world, 1.0);
        let after = super::kept::sums(&world);
        assert!(velocity(&world, a).x < 1.5, "they must have met");
        let (p, l) = ((after.0 - before.0).length(), (after.1 - before.1).length());
        assert!(p < 3e-4 && l < 3e-4, "{p} {l}");
        if material.friction == 0.0 {
            // Nothing turns a ball that it only presses.
            let turned =
                (spin(&world, a) - spins[0]).length() + (spin(&world, b) - spins[1]).length();
            assert!(turned < 2e-3, "{turned}");
        }
    }
}

#[test]
fn a_ball_stays_on_a_ball_that_spins_below_it() {
    // Without friction the lower one's spin is none of the upper one's business, which stands on its top for as long as its balance is.
    let mut world = world();
    floor(&mut world, rough(0.0));
    let ball = Shape::sphere(0.5).unwrap();
    let low = add_ball(&mut world, ball.clone(), 0.5, Vec3::Y * 0.5, Quat::IDENTITY);
    let high = add_ball(&mut world, ball, 0.5, Vec3::Y * 1.5, Quat::IDENTITY);
    throw(&mut world, low, Vec3::ZERO, Vec3::new(3.0, 0.0, 1.0));
    step(&mut world, 0.5);
    let at = centre(&world, high);
    assert!((at - Vec3::Y * 1.5).length() < 2e-3, "{at}");
}
