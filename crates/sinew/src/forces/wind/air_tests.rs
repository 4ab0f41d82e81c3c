//! Tests of the air on sheets and balls: the analytic results of physics.md F5, and stability at any substep.

use glam::Vec3;

use super::air::{Air, AirFlow, apply, sample};
use super::surfaces::PackedSurfaces;
use crate::forces::Region;
use crate::lanes::InstructionSet;
use crate::particles::{ParticleSeed, Particles};
use crate::simulation::Simulation;
use crate::test_random::Random;

const H: f32 = 1.0 / 60.0;

/// A square metre of two triangles perpendicular to `normal`, centred at the origin, of `mass` kg and in motion.
fn sheet(normal: Vec3, mass: f32, velocity: Vec3) -> (Particles, Vec<[u32; 3]>) {
    let side = normal.any_orthonormal_vector();
    let up = normal.normalize().cross(side);
    let mut particles = Particles::default();
    for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
        // The two corners shared by both triangles get twice the mass of the others, so that the sheet does not rotate.
        let mass = if x * y > 0.0 { mass / 3.0 } else { mass / 6.0 };
        let seed = ParticleSeed::at(side * x + up * y).with_mass(mass).with_velocity(velocity);
        particles.push(seed).unwrap();
    }
    (particles, vec![[0, 1, 2], [0, 2, 3]])
}

/// Force on all particles, N, over a substep of `h` seconds.
fn total_force(
    particles: &mut Particles,
    surfaces: &[[u32; 3]],
    flows: &[AirFlow],
    h: f32,
) -> Vec3 {
    let mut air = Air::default();
    sample(particles, surfaces, flows, 0.0, &mut air, InstructionSet::best());
    particles.clear_sums(0.0);
    let packed = PackedSurfaces::of(surfaces, particles);
    apply(particles, &packed, &air, h, InstructionSet::best());
    (0..particles.len())
        .filter(|&i| particles.inverse_mass(i) > 0.0)
        .map(|i| particles.acceleration(i) * particles.mass(i))
        .sum()
}

/// A unit vector in the xy plane, by its angle from x in degrees.
fn direction(degrees: f64) -> Vec3 {
    let angle = degrees.to_radians();
    Vec3::new(libm::cos(angle) as f32, libm::sin(angle) as f32, 0.0)
}

#[test]
fn drag_is_dynamic_pressure_times_silhouette_and_depends_on_relative_velocity_alone() {
    for degrees in [0.0_f64, 20.0, 45.0, 70.0, 90.0, 130.0] {
        let normal = direction(degrees);
        let expected = 0.5 * 1.225 * 1.28 * 36.0 * libm::cos(degrees.to_radians()).abs() as f32;
        let moving =
            [(Vec3::X * 6.0, Vec3::ZERO), (Vec3::ZERO, Vec3::X * -6.0), (Vec3::X, Vec3::X * -5.0)];
        for (wind, own) in moving {
            let (mut particles, surfaces) = sheet(normal, 10.0, own);
            let flow = AirFlow { lift: 0.0, ..AirFlow::steady(wind) };
            let force = total_force(&mut particles, &surfaces, &[flow], H);
            assert!(force.abs_diff_eq(Vec3::X * expected, 2e-5 * 29.0), "{degrees}°: {force}");
        }
    }
}

#[test]
fn lift_is_across_the_wind_and_lifts_a_kite_whichever_way_round_its_triangles_are() {
    let wind = Vec3::X * 8.0;
    for degrees in [-80.0_f64, -45.0, -10.0, 10.0, 30.0, 45.0, 60.0, 80.0] {
        // The normal points downwind, and up for a kite: its upwind edge is the upper one.
        let normal = direction(degrees);
        for normal in [normal, -normal] {
            let (mut particles, mut surfaces) = sheet(normal, 10.0, Vec3::ZERO);
            surfaces[1].swap(1, 2);
            let of = |drag: f32, lift: f32| AirFlow { drag, lift, ..AirFlow::steady(wind) };
            let both = total_force(&mut particles, &surfaces, &[of(1.0, 1.3)], H);
            let lift = both - total_force(&mut particles, &surfaces, &[of(1.0, 0.0)], H);
            // The angle of attack is 90° minus the angle of the normal.
            let (sin, cos) = (libm::cos(degrees.to_radians()), libm::sin(degrees.to_radians()));
            let expected = 0.5 * 1.225 * 1.3 * 64.0 * sin.abs() * cos;
            assert!(lift.dot(wind).abs() < 1e-4 * wind.length() * expected.abs() as f32);
            assert!(
                (f64::from(lift.y) - expected).abs() < 1e-4 * 50.0,
                "{degrees}°: {lift} {expected}"
            );
        }
    }
}

#[test]
fn a_falling_sheet_reaches_the_terminal_speed_at_which_drag_carries_its_weight() {
    for (mass, h) in [(0.3_f32, H), (0.3, H / 8.0), (5.0, 1.0 / 30.0)] {
        let mut world = Simulation::default();
        let surfaces;
        (world.particles, surfaces) = sheet(Vec3::Y, mass, Vec3::ZERO);
        *world.forces.surfaces = surfaces;
        world.forces.air_flows.push(AirFlow::default());
        let exact = (2.0 * mass * 9.81 / (1.225 * 1.28)).sqrt();
        // It approaches that speed as tanh(g t/v). The four particles are not connected, and a free sheet is not steady for long.
        for _ in 0..(6.0 * exact / 9.81 / h) as u32 {
            world.step(h).unwrap();
        }
        let speed = -world.particles.velocity(0).y;
        assert!((speed / exact - 1.0).abs() < 1e-4, "{mass} kg, {h} s: {speed} m/s of {exact}");
    }
}

#[test]
fn a_falling_ball_reaches_its_terminal_speed_and_a_particle_of_a_sheet_is_no_ball() {
    let mut world = Simulation::default();
    let ball = ParticleSeed::at(Vec3::ZERO).with_mass(0.43).with_radius(0.11);
    world.particles.push(ball).unwrap();
    world.forces.air_flows.push(AirFlow::default());
    for _ in 0..60 * 30 {
        world.step(H).unwrap();
    }
    let area = core::f32::consts::PI * 0.11 * 0.11;
    let exact = (2.0 * 0.43 * 9.81 / (1.225 * 0.47 * area)).sqrt();
    let speed = -world.particles.velocity(0).y;
    assert!((speed / exact - 1.0).abs() < 1e-4, "{speed} of {exact}");

    let (mut particles, surfaces) = sheet(Vec3::Y, 1.0, Vec3::X * 9.0);
    particles.radius.fill(0.5);
    let edge_on = total_force(&mut particles, &surfaces, &[AirFlow::default()], H);
    assert!(edge_on.length() < 1e-4, "{edge_on}");
    let none = AirFlow { on_particles: false, ..AirFlow::default() };
    assert_eq!(total_force(&mut world.particles, &[], &[none], H), Vec3::ZERO);
}

/// Kinetic energy of the particles relative to air at `wind`, J.
fn energy(particles: &Particles, wind: Vec3) -> f64 {
    let of = |i| {
        0.5 * f64::from(particles.mass(i))
            * (particles.velocity(i) - wind).as_dvec3().length_squared()
    };
    (0..particles.len()).map(of).sum()
}

#[test]
fn a_feather_in_a_storm_is_carried_along_and_never_thrown_about() {
    // A tenth of a gram and 50 cm² in 40 m/s, at 1/60 s and at 1/10 s, far too long: the plain formula would push it to fifty times the wind's speed.
    let wind = Vec3::new(40.0, 0.0, 0.0);
    for (h, lift) in [(H, 0.0), (0.1, 0.0), (H, 1.28), (0.1, 5.0)] {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        for corner in [Vec3::ZERO, Vec3::new(0.0, 0.1, 0.03), Vec3::new(0.02, 0.0, 0.1)] {
            world.particles.push(ParticleSeed::at(corner).with_mass(1e-4 / 3.0)).unwrap();
        }
        world.forces.surfaces.push([0, 1, 2]);
        world.forces.air_flows.push(AirFlow { lift, ..AirFlow::steady(wind) });
        let mut last = energy(&world.particles, wind);
        for _ in 0..120 {
            world.step(h).unwrap();
            let now = energy(&world.particles, wind);
            assert!(now <= last * 1.000_01, "lift {lift}: {now} J after {last} J");
            let v = world.particles.velocity(0);
            assert!(lift > 0.0 || v.x <= 40.0 && v.y.abs() < 1e-4, "past the wind: {v}");
            last = now;
        }
        assert!(last < 0.05 * 0.5 * 1e-4 * 1600.0, "lift {lift}: it goes with the wind: {last} J");
    }
}

#[test]
fn a_crumpled_cloth_of_light_particles_never_gains_energy_from_still_air() {
    // Corners that share up to six triangles, masses from 1 mg to 1 g, all moving in different directions.
    let mut random = Random::new(3);
    let mut next = || 0.5 * random.number();
    let (mut particles, mut surfaces, n) = (Particles::default(), Vec::new(), 12_u32);
    for i in 0..n * n {
        let at = Vec3::new((i % n) as f32, (i / n) as f32, 2.0 * next());
        let velocity = Vec3::new(next(), next(), next()) * 60.0;
        let mass = 1e-6 * (1.0 + 999.0 * (next() + 0.5));
        particles.push(ParticleSeed::at(at * 0.1).with_velocity(velocity).with_mass(mass)).unwrap();
        if i % n + 1 < n && i / n + 1 < n {
            surfaces.extend([[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]);
        }
    }
    for lift in [0.0, 1.28, 20.0] {
        let mut particles = particles.clone();
        let (mut air, start) = (Air::default(), energy(&particles, Vec3::ZERO));
        let mut last = start;
        for step in 0..60 {
            let flow = AirFlow { lift, ..AirFlow::default() };
            sample(&particles, &surfaces, &[flow], 0.0, &mut air, InstructionSet::best());
            particles.clear_sums(0.0);
            let packed = PackedSurfaces::of(&surfaces, &particles);
            apply(&mut particles, &packed, &air, H, InstructionSet::best());
            for i in 0..particles.len() {
                let change = particles.acceleration(i).extend(0.0) * H;
                particles.velocity[i] += change;
            }
            let now = energy(&particles, Vec3::ZERO);
            assert!(now <= last * 1.000_01, "lift {lift}, step {step}: {now} after {last}");
            last = now;
        }
        assert!(last < 0.8 * start, "lift {lift}: {last} of {start}");
    }
}

#[test]
fn a_flow_blows_in_its_region_only_and_flows_that_overlap_are_one_air() {
    let fan = Region::sphere(Vec3::ZERO, 3.0);
    let flow = AirFlow::steady(Vec3::Y * 4.0);
    let at = |place: Vec3, flows: &[AirFlow]| {
        let (mut particles, surfaces) = sheet(Vec3::Y, 10.0, Vec3::ZERO);
        (0..4).for_each(|i| particles.displace(i, place));
        total_force(&mut particles, &surfaces, flows, H).y
    };
    let square = |v: f32| 0.5 * 1.225 * 1.28 * v * v;
    let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
    assert!(near(at(Vec3::X, &[flow.within(fan)]), square(4.0)));
    assert_eq!(at(Vec3::X * 5.0, &[flow.within(fan)]), 0.0);
    // The centroids of the triangles are 1/√18 m off, and so 2.5 m from the centre of the region. At half the fade, half of the velocity and half of the
    // density give an eighth of the force.
    let faded = at(Vec3::Y * 2.488_86, &[flow.within(fan.with_fade(1.0))]);
    assert!((faded / square(4.0) - 0.125).abs() < 1e-3, "{faded}");
    let breeze = AirFlow::steady(Vec3::Y);
    assert!(near(at(Vec3::X, &[flow.within(fan), breeze]), square(5.0)));
    assert!(near(at(Vec3::X * 5.0, &[flow.within(fan), breeze]), square(1.0)));
    assert_eq!(flow.within(fan).at(Vec3::X * 5.0, 1.0), Vec3::ZERO);
}

#[test]
fn broken_air_and_broken_triangles_are_left_out() {
    let good = AirFlow::steady(Vec3::Y * 4.0);
    let broken = [
        AirFlow::steady(Vec3::NAN),
        AirFlow { density: -1.0, ..good },
        AirFlow { lift: f32::INFINITY, ..good },
        AirFlow { gust_period: 0.0, ..good },
        good.within(Region::sphere(Vec3::NAN, 1.0)),
    ];
    assert!(good.is_valid() && broken.iter().all(|flow| !flow.is_valid()));
    let (mut particles, mut surfaces) = sheet(Vec3::Y, 10.0, Vec3::ZERO);
    assert_eq!(total_force(&mut particles, &surfaces, &broken, H), Vec3::ZERO);
    let whole = total_force(&mut particles, &surfaces, &[good], H);
    // A missing row, no area, no direction: no force, and no NaN.
    surfaces.extend([[0, 1, 99], [0, 0, 1], [2, 2, 2]]);
    assert!(total_force(&mut particles, &surfaces, &[good], H).abs_diff_eq(whole, 1e-4));
    particles.set_velocity(0, Vec3::splat(f32::MAX));
    assert!(total_force(&mut particles, &surfaces, &[good], H).is_finite());
    for i in 0..4 {
        particles.position[i].w = 0.0;
    }
    assert_eq!(total_force(&mut particles, &surfaces, &[good], H), Vec3::ZERO);
}

/// A crumpled, moving sheet of `n` by `n` particles, some pinned, some with origins of their own, and with triangles that have no area, have missing rows, or
/// are not finite.
fn crumpled(n: usize) -> (Particles, Vec<[u32; 3]>) {
    let mut random = Random::new(11);
    let mut next = || 0.5 * random.number();
    let (mut particles, mut surfaces) = (Particles::default(), vec![]);
    for i in 0..n * n {
        let grid = Vec3::new((i % n) as f32, (i / n) as f32, 0.0) * 0.3;
        let place = grid + Vec3::new(next(), next(), next()) * 0.2;
        let velocity = Vec3::new(next(), next(), next()) * 20.0;
        let seed = ParticleSeed::at(place).with_velocity(velocity).with_mass(0.01 + next().abs());
        particles.push(if i % 17 == 3 { seed.pinned() } else { seed }).unwrap();
        if i % n + 1 < n && i / n + 1 < n {
            let (i, n) = (i as u32, n as u32);
            surfaces.extend([[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]);
        }
    }
    surfaces.extend([[0, 0, 1], [2, 2, 2], [0, 1, u32::MAX], [4, 5, 6]]);
    (particles, surfaces)
}

#[test]
fn every_instruction_set_blows_with_the_same_bits_and_as_one_triangle_at_a_time_would() {
    use crate::forces::wind::pressure;
    let gusty = AirFlow { gusts: 0.3, ..AirFlow::steady(Vec3::new(9.0, 1.0, -4.0)) };
    let fan = AirFlow::steady(Vec3::Y * 6.0)
        .within(Region::boxed(Vec3::ONE, Vec3::new(1.6, 4.0, 2.0)).with_fade(0.5));
    let wind = crate::Wind::steady(Vec3::new(3.0, -1.0, 8.0)).with_gusts(0.4);
    for n in [2, 3, 5, 12] {
        let (mut particles, surfaces) = crumpled(n);
        let mut blown = |surfaces: &[[u32; 3]], set| {
            let (mut air, mut pressures) = (Air::default(), pressure::Pressures::default());
            sample(&particles, surfaces, &[gusty, fan], 7.3, &mut air, set);
            pressures.sample(&particles, surfaces, &wind, 7.3, set);
            particles.clear_sums(0.0);
            // A substep at which the limits are active for some triangles and not for others.
            let packed = PackedSurfaces::of(surfaces, &particles);
            apply(&mut particles, &packed, &air, 0.004, set);
            pressure::apply(&mut particles, &packed, &pressures, false, set);
            particles.acceleration.clone()
        };
        let truth = blown(&surfaces, InstructionSet::Scalar);
        assert!(truth.iter().all(|a| a.is_finite() && a.w == 0.0) && truth[0].x != 0.0);
        assert!(truth == blown(&surfaces, InstructionSet::Simd128), "{n}");
        assert!(truth == blown(&surfaces, InstructionSet::Avx2), "{n}");
    }
}

#[test]
fn a_triangle_that_is_not_finite_leaves_what_it_does_not_touch_alone() {
    let (mut particles, surfaces) = crumpled(5);
    let flow = AirFlow::steady(Vec3::new(9.0, 1.0, -4.0));
    let mut blown = |at: Vec3| {
        particles.set_position(24, at);
        let mut air = Air::default();
        sample(&particles, &surfaces, &[flow], 0.0, &mut air, InstructionSet::best());
        particles.clear_sums(0.0);
        let packed = PackedSurfaces::of(&surfaces, &particles);
        apply(&mut particles, &packed, &air, H, InstructionSet::best());
        particles.acceleration.clone()
    };
    let (good, bad) = (blown(Vec3::ONE), blown(Vec3::NAN));
    assert!(bad.iter().all(|a| a.is_finite()));
    // Particle 24 is the last corner; 18, 19 and 23 share triangles with it.
    assert!((0..18).chain(20..23).all(|i| good[i] == bad[i]) && good[19] != bad[19]);
}
