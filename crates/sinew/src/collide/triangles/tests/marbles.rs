//! Balls on coarse sheets.

use glam::Vec3;

use super::{DT, Sheet, body, colliding, empty, momentum, particle, with_material};
use crate::collide::{BodyContacts, ContactParticipant};
use crate::particles::ParticleSeed;
use crate::simulation::Simulation;

/// A ball of 1 cm radius above a sheet of 5 × 5 cells of 20 cm that is pinned along its rim, with triangle contacts if `surface`.
fn over(surface: bool, at: Vec3, velocity: Vec3) -> (Simulation, usize) {
    let mut world = empty(9.81);
    let contacts = BodyContacts { surface, ..colliding(false) };
    let sheet = Sheet { contacts, ..Sheet::flat(5, 0.2, 0.0) };
    sheet.build(&mut world, |i, j| i == 0 || j == 0 || i == 5 || j == 5);
    let own = body(&mut world, BodyContacts { surface: false, ..colliding(false) });
    let ball = ParticleSeed::at(at).with_mass(0.01).with_radius(0.01).with_velocity(velocity);
    let ball = particle(&mut world, ball, own);
    (world, ball)
}

/// Lowest height of a ball in a number of steps, metres. The sheet sags.
fn lowest(world: &mut Simulation, ball: usize, steps: u32) -> f32 {
    let mut least = f32::MAX;
    for _ in 0..steps {
        world.step(DT).unwrap();
        least = least.min(world.particles.position(ball).y);
    }
    least
}

#[test]
fn a_ball_dropped_on_a_coarse_sheet_stays_on_it_and_falls_through_its_particles_alone() {
    for at in [Vec3::new(0.03, 0.3, 0.06), Vec3::new(-0.31, 0.3, 0.22), Vec3::new(0.0, 0.3, 0.05)] {
        let (mut world, ball) = over(true, at, Vec3::ZERO);
        let least = lowest(&mut world, ball, 300);
        let (mut loose, falls) = over(false, at, Vec3::ZERO);
        let through = lowest(&mut loose, falls, 60);
        println!("{at}: {least:.3} m by triangles, {through:.3} m by particles");
        assert!(least > -0.12, "{least}");
        assert!(through < -1.0, "{through}");
        assert!(world.particles.velocity(ball).length() < 0.3, "it comes to rest");
    }
}

#[test]
fn a_ball_shot_at_a_coarse_sheet_does_not_pass_however_fast_it_is() {
    for speed in [30.0, 300.0, 3000.0] {
        for (x, z) in [(0.03, 0.06), (0.0, 0.0), (0.1, 0.1), (0.05, 0.05), (-0.2, 0.13)] {
            let at = Vec3::new(x, 0.47, z);
            for way in [Vec3::NEG_Y, Vec3::new(0.2, -1.0, 0.1)] {
                let (mut world, ball) = over(true, at, way * speed);
                // Height above the triangle below or above it: a ball that has passed may still be higher than the sheet's lowest particles.
                let mut worst = f32::MAX;
                for _ in 0..30 {
                    world.step(DT).unwrap();
                    worst = worst.min(above(&world, ball));
                }
                assert!(worst > 0.0, "{speed} m/s at {at}: {worst}");
            }
            let (mut loose, falls) = over(false, Vec3::new(0.03, 0.47, 0.06), Vec3::NEG_Y * speed);
            assert!(lowest(&mut loose, falls, 60) < -1.0, "by particles alone it passes");
        }
    }
}

/// Height above the triangle over or under it, metres; `f32::MAX` beside all of them.
fn above(world: &Simulation, ball: usize) -> f32 {
    let p = world.particles.position(ball);
    for triangle in &world.forces.surfaces {
        let [a, b, c] = triangle.map(|row| world.particles.position(row as usize));
        let flat = |v: Vec3| Vec3::new(v.x, 0.0, v.z);
        let n = flat(b - a).cross(flat(c - a)).y;
        let of_b = flat(p - a).cross(flat(c - a)).y / n;
        let of_c = flat(b - a).cross(flat(p - a)).y / n;
        if of_b >= 0.0 && of_c >= 0.0 && of_b + of_c <= 1.0 {
            return p.y - (a.y + (b.y - a.y) * of_b + (c.y - a.y) * of_c);
        }
    }
    f32::MAX
}

#[test]
fn a_ball_comes_back_as_fast_as_its_material_says() {
    for restitution in [0.0, 0.5, 1.0] {
        let mut world = empty(0.0);
        let contacts = with_material(colliding(false), 0.0, restitution);
        let contacts = BodyContacts { events: true, ..contacts };
        // Pinned everywhere: a wall.
        Sheet { contacts, ..Sheet::flat(1, 0.5, 0.0) }.build(&mut world, |_, _| true);
        let own = body(&mut world, contacts);
        let ball = ParticleSeed::at(Vec3::new(0.05, 0.3, 0.1)).with_radius(0.01);
        let ball = particle(&mut world, ball.with_velocity(Vec3::new(1.0, -3.0, 0.0)), own);
        let mut impulse = 0.0;
        for _ in 0..12 {
            impulse += world.step(DT).unwrap().impacts.iter().map(|one| one.impulse).sum::<f32>();
        }
        assert!((impulse - 3.0 * (1.0 + restitution)).abs() < 1e-3, "{impulse} N·s on 1 kg");
        let velocity = world.particles.velocity(ball);
        let wanted = Vec3::new(1.0, 3.0 * restitution, 0.0);
        assert!((velocity - wanted).length() < 1e-4, "{restitution}: {velocity}");
    }
}

/// Friction had only the impulse of the overlap at the end of the substep, anything between none and all of that of the impact, and none of a bounce.
#[test]
fn an_impact_has_the_friction_of_all_of_its_impulse_wherever_in_a_substep_it_is() {
    for (substeps, speed) in [(4, 2.0), (10, 2.0), (40, 2.0), (4, 20.0), (10, 20.0)] {
        for (restitution, phase) in
            [0.0, 0.5, 1.0].into_iter().flat_map(|e| (0..8).map(move |phase| (e, phase)))
        {
            let mut world = empty(0.0);
            world.settings.substeps = substeps;
            let contacts = with_material(colliding(false), 0.1, restitution);
            Sheet { contacts, ..Sheet::flat(1, 2.0, 0.0) }.build(&mut world, |_, _| true);
            let own = body(&mut world, contacts);
            let thrown = Vec3::new(0.8, -1.0, 0.0) * speed;
            let before = DT / substeps as f32 * (2.0 + phase as f32 / 8.0);
            let at = Vec3::new(0.1, 0.015, 0.2) - thrown * before;
            let seed = ParticleSeed::at(at).with_radius(0.01).with_velocity(thrown);
            let ball = particle(&mut world, seed, own);
            world.step(DT).unwrap();
            let change = world.particles.velocity(ball) - thrown;
            let expected = Vec3::new(-0.1, 1.0, 0.0) * (speed * (1.0 + restitution));
            assert!(
                (change - expected).length() < 1e-3 * speed,
                "{substeps}, {speed} m/s, e {restitution}, phase {phase}: {change}, {expected}"
            );
        }
    }
}

#[test]
fn what_lies_on_a_slope_slides_if_it_is_steeper_than_friction_holds() {
    for (friction, slides) in [(0.7, false), (0.3, true)] {
        let mut world = empty(9.81);
        let contacts = with_material(colliding(false), friction, 0.0);
        // tan θ = 0.5.
        let slope = Vec3::new(2.0, -1.0, 0.0).normalize();
        let sheet = Sheet { contacts, axes: [slope, Vec3::Z], ..Sheet::flat(2, 1.0, 0.0) };
        Sheet { corner: Vec3::new(0.0, 0.0, -1.0), ..sheet }.build(&mut world, |_, _| true);
        let own = body(&mut world, contacts);
        let normal = Vec3::new(1.0, 2.0, 0.0).normalize();
        let at = slope * 0.3 + normal * 0.0149 + Vec3::Z * 0.23;
        let ball = particle(&mut world, ParticleSeed::at(at).with_radius(0.01), own);
        for _ in 0..60 {
            world.step(DT).unwrap();
        }
        let gone = (world.particles.position(ball) - at).dot(slope);
        // s = ½ g (sin θ - μ cos θ) t²
        let wanted =
            if slides { 0.5 * 9.81 * (0.5 - friction) * 2.0 / 5.0_f32.sqrt() } else { 0.0 };
        println!("μ = {friction}: {gone:.4} m, by Coulomb {wanted:.4} m");
        assert!((gone - wanted).abs() < 0.01 + 0.03 * wanted, "{gone} {wanted}");
    }
}

#[test]
fn free_bodies_keep_their_momentum_and_report_their_contact() {
    let mut world = empty(0.0);
    let mut contacts = with_material(colliding(false), 0.5, 0.3);
    contacts.events = true;
    Sheet { contacts, ..Sheet::flat(3, 0.2, 0.0) }.build(&mut world, |_, _| false);
    let own = body(&mut world, contacts);
    for (x, v) in [(0.03, -4.0), (0.11, -6.0), (-0.17, -30.0)] {
        let seed = ParticleSeed::at(Vec3::new(x, 0.2, 0.5 * x)).with_mass(0.05).with_radius(0.01);
        particle(&mut world, seed.with_velocity(Vec3::new(0.3, v, 0.1)), own);
    }
    let before = momentum(&world);
    let mut impulse = 0.0_f64;
    for _ in 0..20 {
        let report = world.step(DT).unwrap();
        for impact in &report.impacts {
            assert_eq!(
                (impact.first, impact.second),
                (ContactParticipant::Body(0), ContactParticipant::Body(1))
            );
            // The sheet is pushed down when it is first hit.
            assert!(impulse > 0.0 || impact.normal.y < -0.9, "{impact:?}");
            impulse += f64::from(impact.impulse);
        }
    }
    let after = momentum(&world);
    // Positions are `f32`: at 0.2 m the error of 1e-8 m, in 1/600 s, is 1e-5 m/s.
    let size = 0.05 * 40.0;
    for k in 0..3 {
        assert!((after[k] - before[k]).abs() < 1e-5 * size, "{before:?} {after:?}");
    }
    assert!(impulse > 0.5 * size, "{impulse} N·s of {size}");
}
