//! Contacts of two particles against analytic mechanics.

use glam::Vec3;

use super::{World, self_colliding};
use crate::particles::ParticleSeed;

const DT: f32 = 1.0 / 60.0;

fn ball(at: Vec3, velocity: Vec3) -> ParticleSeed {
    ParticleSeed::at(at).with_radius(0.01).with_velocity(velocity)
}

fn world(friction: f32, restitution: f32) -> World {
    World { contacts: vec![self_colliding(friction, restitution); 2], ..Default::default() }
}

#[test]
fn two_at_a_hundred_metres_a_second_do_not_pass_through_each_other() {
    // Each moves 17 cm a substep and is 2 cm wide. They start at all phases of that distance.
    for phase in 0..97 {
        let mut world = world(0.5, 0.0);
        let gap = 0.4 + phase as f32 * 0.0041;
        world.push(ball(Vec3::X * -gap, Vec3::X * 100.0), 0);
        world.push(ball(Vec3::X * gap, Vec3::X * -100.0), 1);
        for _ in 0..3 {
            world.step(DT);
            let d = world.particles.separation(1, 0);
            assert!(d.x >= 0.02 * 0.999, "phase {phase}: {d}");
        }
        assert!(world.particles.velocity(0).length() < 1e-2, "{}", world.particles.velocity(0));
    }
}

#[test]
fn a_fast_one_is_stopped_by_one_that_is_pinned_also_where_it_grazes_it() {
    for side in [0.0, 0.005, 0.01, 0.015, 0.0195] {
        let mut world = world(0.0, 0.0);
        world.push(ball(Vec3::ZERO, Vec3::ZERO).pinned(), 0);
        world.push(ball(Vec3::new(-0.9, side, 0.0), Vec3::X * 120.0), 1);
        let speed = 120.0 * side / 0.02;
        world.step(DT);
        let v = world.particles.velocity(1);
        // What is left is the motion along the wall at the point of impact, the last part of which is curved.
        assert!((v.length() - speed).abs() < 1.0 + 0.02 * speed, "{side}: {v} of {speed}");
        assert_eq!(world.particles.position(0), Vec3::ZERO);
        assert!(side > 0.0 || world.particles.position(1).x < -0.0199);
    }
}

#[test]
fn momentum_and_angular_momentum_are_kept_by_oblique_hits_of_unequal_masses() {
    for (friction, restitution) in [(0.0, 0.0), (0.0, 1.0), (0.7, 0.0), (0.7, 0.8)] {
        let mut world = world(friction, restitution);
        world.push(ball(Vec3::new(-0.05, 0.004, 0.0), Vec3::new(1.0, 0.3, -0.2)).with_mass(0.3), 0);
        world.push(ball(Vec3::new(0.05, 0.0, 0.003), Vec3::new(-1.0, 0.2, 0.0)).with_mass(2.0), 1);
        let (p, l, e) = (world.momentum(), world.angular_momentum(), world.energy());
        for _ in 0..12 {
            world.step(DT);
        }
        assert!(world.energy() < e * 0.999 || (friction, restitution) == (0.0, 1.0), "they met");
        assert!(world.energy() <= e * 1.000_01, "{} J of {e} J", world.energy());
        let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (now, then) = (world.momentum(), world.angular_momentum());
        let (dp, dl) = ([0, 1, 2].map(|k| now[k] - p[k]), [0, 1, 2].map(|k| then[k] - l[k]));
        println!(
            "μ {friction} e {restitution}: {:.1e} N·s, {:.2e} of {:.2e} N·m·s",
            size(dp),
            size(dl),
            size(l)
        );
        assert!(size(dp) < 1e-6 * size(p), "{dp:?} N·s");
        // The normal is that at the end of the substep, slightly off the one at the impact. Friction acts between the centres and not at the surfaces, and
        // removes angular momentum: a particle has no spin to receive it. With friction that is what its impulse removes.
        let (apart, past) = (Vec3::new(-0.1, 0.004, -0.003), Vec3::new(2.0, 0.1, -0.2));
        let aside = apart - past * (apart.dot(past) / past.length_squared());
        let back = (0.02 * 0.02 - aside.length_squared()).sqrt();
        let n = (aside - past.normalize() * back) / 0.02;
        let slip = past - n * past.dot(n);
        let taken = (-friction * (1.0 + restitution) * past.dot(n) / slip.length()).min(1.0);
        let lost = n.cross(slip * taken) * (0.02 * 0.3 * 2.0 / 2.3);
        let off = size([0, 1, 2].map(|k| dl[k] + f64::from(lost[k])));
        assert!(off < 0.1 * size(l), "{dl:?} N·m·s, not {lost}, of {l:?}");
    }
}

#[test]
fn equal_masses_exchange_their_velocities_head_on() {
    for speed in [0.5, 3.0, 40.0] {
        let mut world = world(0.5, 1.0);
        world.push(ball(Vec3::X * -0.1, Vec3::X * speed), 0);
        world.push(ball(Vec3::X * 0.1, Vec3::ZERO), 1);
        let steps = (0.3 / speed / DT) as u32 + 2;
        for _ in 0..steps {
            world.step(DT);
        }
        assert!(world.particles.velocity(0).length() < 1e-4 * speed);
        assert!((world.particles.velocity(1).x - speed).abs() < 1e-4 * speed);
    }
}

/// Restitution is one problem over all pairs that touch. Pair after pair, a ball into a row of four that touch left with 27 to 40 % of its energy, and with a
/// restitution of one half into a row with small gaps with 130 %.
#[test]
fn a_ball_into_a_row_keeps_its_energy_or_loses_a_part_of_it() {
    for (restitution, gap) in [(1.0, 0.0), (1.0, 1e-5), (1.0, 1e-4), (0.5, 0.0), (0.5, 1e-4)] {
        for h in [1.0 / 240.0, 1.0 / 600.0, 1.0 / 2400.0] {
            let mut world = world(0.0, restitution);
            world.push(ball(Vec3::NEG_X, Vec3::X * 5.0).with_radius(0.5), 0);
            for k in 0..4 {
                let at = Vec3::X * ((1.0 + gap) * (k + 1) as f32);
                world.push(ball(at, Vec3::ZERO).with_radius(0.5), 0);
            }
            let began = world.energy();
            for _ in 0..(1.2 / h) as u32 {
                world.find(h);
                world.substep(h);
                assert!(world.energy() <= began * 1.001, "{restitution} {gap} {h}");
            }
            let left = world.energy() / began;
            let least = if restitution == 1.0 { 1.0 - 1e-3 } else { 0.2 };
            let most = if restitution == 1.0 { 1.001 } else { 0.35 };
            assert!(least < left && left < most, "{restitution} {gap} {h}: {left}");
        }
    }
}

#[test]
fn a_ball_dropped_on_a_pinned_one_rises_to_its_share_of_the_height() {
    for restitution in [0.0_f32, 0.5, 0.8, 1.0] {
        let mut world = world(0.0, restitution);
        world.gravity = Vec3::Y * -9.81;
        world.push(ball(Vec3::ZERO, Vec3::ZERO).pinned(), 0);
        world.push(ball(Vec3::Y * 0.52, Vec3::ZERO), 1);
        // It falls for 0.319 s, and rises for that time times e.
        let mut highest = 0.0_f32;
        for step in 0..60 {
            world.step(DT);
            let y = world.particles.position(1).y;
            assert!(y > 0.0199, "{y}");
            if step > 20 {
                highest = highest.max(y);
            }
        }
        let expected = 0.02 + 0.5 * restitution * restitution;
        assert!((highest - expected).abs() < 0.012, "e {restitution}: {highest} of {expected}");
        assert!(highest < 0.52001, "it gained: {highest}");
    }
}

#[test]
fn friction_stops_what_slides_over_a_row_of_pinned_ones() {
    let slide = |friction: f32| {
        let mut world = world(friction, 0.0);
        world.gravity = Vec3::Y * -9.81;
        for i in 0..200 {
            world.push(ball(Vec3::X * (i as f32 * 0.002 - 0.05), Vec3::ZERO).pinned(), 0);
        }
        let row = world.push(ball(Vec3::Y * 0.02, Vec3::X * 0.5), 1);
        for _ in 0..30 {
            world.step(DT);
        }
        world.particles.velocity(row)
    };
    let (smooth, rough) = (slide(0.0), slide(0.8));
    // The row is bumpy, and each bump takes the normal component: (2/40)² of the energy.
    assert!(smooth.x > 0.2, "{smooth}");
    assert!(rough.length() < 1e-3, "{rough}");
}

/// Friction had only the impulse of the overlap at the end of the substep, anything between none and all of that of the impact, and none of a bounce.
#[test]
fn an_impact_has_the_friction_of_all_of_its_impulse_wherever_in_a_substep_it_is() {
    let h = DT / 10.0;
    for (restitution, phase) in
        [0.0, 0.5, 1.0].into_iter().flat_map(|e| (0..8).map(move |phase| (e, phase)))
    {
        let mut world = world(0.1, restitution);
        let big = |at, velocity| ParticleSeed::at(at).with_radius(2.0).with_velocity(velocity);
        let thrown = Vec3::new(4.0, -5.0, 0.0);
        world.push(big(Vec3::ZERO, Vec3::ZERO).pinned(), 0);
        let before = h * (2.0 + phase as f32 / 8.0);
        let row = world.push(big(Vec3::Y * 4.0 - thrown * before, thrown), 1);
        world.step(DT);
        let change = world.particles.velocity(row) - thrown;
        let expected = Vec3::new(-0.5, 5.0, 0.0) * (1.0 + restitution);
        // The line between the two is upright when they touch, and off that by 2 mm in a metre at the end of the substep.
        assert!(
            (change - expected).length() < 0.004 * change.length(),
            "e {restitution}, phase {phase}: {change}, {expected}"
        );
    }
}

#[test]
fn friction_of_a_fast_pair_follows_coulombs_law_once() {
    for (restitution, phase) in
        [0.0, 0.6].into_iter().flat_map(|e| (1..10).map(move |phase| (e, phase)))
    {
        // It touches with the normal -x within the substep, in which it moves 0.1 m along x and along z.
        let (mut world, h) = (world(0.2, restitution), DT / 10.0);
        world.push(ball(Vec3::ZERO, Vec3::ZERO).pinned(), 0);
        let way = Vec3::new(0.1, 0.0, 0.1);
        let row = world.push(ball(Vec3::X * -0.02 - way * (0.1 * phase as f32), way / h), 1);
        world.find(DT);
        world.substep(h);
        let left = world.particles.velocity(row) * h;
        let lost = 0.1 * (1.0 + restitution);
        let expected = Vec3::new(0.1 - lost, 0.0, 0.1 - 0.2 * lost);
        assert!((left - expected).length() < 1e-5, "{phase}: {left} m in a substep, {expected}");
    }
}

#[test]
fn coincident_ones_part_along_an_axis_that_their_rows_say() {
    for (before, axis) in [(0, Vec3::Y), (1, Vec3::X), (2, Vec3::Z)] {
        let mut world = world(0.5, 0.0);
        for i in 0..before {
            world.push(ball(Vec3::X * (10.0 + i as f32), Vec3::ZERO), 0);
        }
        let a = world.push(ball(Vec3::ONE, Vec3::ZERO), 0);
        let b = world.push(ball(Vec3::ONE, Vec3::ZERO), 1);
        world.find(DT);
        world.substep(DT / 10.0);
        let d = world.particles.separation(a, b);
        assert!((d - axis * 0.02).length() < 1e-6, "{d}");
    }
}

#[test]
fn pinned_pairs_stay_and_nan_does_not_spread() {
    let mut world = world(0.5, 0.5);
    let a = world.push(ball(Vec3::ZERO, Vec3::ZERO).pinned(), 0);
    let b = world.push(ball(Vec3::X * 0.001, Vec3::ZERO).pinned(), 1);
    let c = world.push(ball(Vec3::X * 0.01, Vec3::ZERO), 1);
    let d = world.push(ball(Vec3::X * 0.012, Vec3::ZERO), 0);
    world.particles.position[d].x = f32::NAN;
    for _ in 0..5 {
        world.step(DT);
    }
    assert_eq!(world.particles.position(a), Vec3::ZERO);
    assert_eq!(world.particles.position(b), Vec3::X * 0.001);
    assert!(world.particles.position(c).is_finite());
    assert!(world.particles.separation(c, b).length() > 0.0199);
}

#[test]
fn events_are_reported_where_a_body_enables_them() {
    let mut world = world(0.5, 0.0);
    world.contacts[1].events = true;
    world.push(ball(Vec3::X * -0.03, Vec3::X).with_mass(2.0), 0);
    world.push(ball(Vec3::ZERO, Vec3::ZERO).with_mass(2.0), 1);
    world.step(DT);
    let mut impacts = crate::collide::impact::Impacts::default();
    world.pairs.report(&mut impacts);
    let merged = impacts.merge();
    assert_eq!(merged.len(), 1);
    // Afterwards both move at half the speed: 1 N·s was exchanged.
    assert!((merged[0].impulse - 1.0).abs() < 1e-3, "{merged:?}");
    assert!((merged[0].normal + Vec3::X).length() < 1e-4, "it pushes the first one back");
    assert!((merged[0].point.x + 0.01).abs() < 0.01, "{}", merged[0].point);
}
