//! Forces on hulls that do not move, compared with sums over small cells and closed forms; and invalid input.

use super::*;
use crate::constraints::checks::sphere;
use crate::test_random::Random;

#[test]
fn the_force_on_a_box_is_that_of_its_submerged_volume_at_its_centroid_at_any_angle() {
    const N: i32 = 80;
    let (size, mut random) = (Vec3::new(2.0, 1.0, 3.0), Random::new(1));
    for _ in 0..10 {
        let mut draw = || 0.5 * random.number();
        let axis = Vec3::new(draw(), draw(), draw() + 0.01);
        let (rotation, at) = (turned(6.0 * draw(), axis), Vec3::new(draw(), draw(), draw()));
        // The submerged cells of the box, and their mean position.
        let (mut cells, mut first) = (0.0, DVec3::ZERO);
        let middle = |i: i32| (f64::from(i) + 0.5) / f64::from(N) - 0.5;
        for i in 0..N * N * N {
            let r = DVec3::new(middle(i % N), middle(i / N % N), middle(i / N / N));
            let x = at.as_dvec3() + rotation * (r * size.as_dvec3());
            if x.y < 0.0 {
                cells += 1.0;
                first += x;
            }
        }
        let volume = cells * 6.0 / f64::from(N * N * N);
        let force = DVec3::Y * (volume * 1000.0 * G);
        let moment = (first / cells).cross(force);
        for posed in [false, true] {
            let mut world = Floating::new(size, 3000.0, posed).at(at).turned(rotation).world(0.0);
            let (found, found_moment) = load(&mut world);
            let whole = 6000.0 * G;
            assert!((found - force).length() < 2e-3 * whole, "{posed}: {found} {force}");
            assert!(found.x.abs().max(found.z.abs()) < 1e-5 * whole, "{posed}: {found}");
            assert!((found_moment - moment).length() < 4e-3 * whole, "{found_moment} {moment}");
        }
    }
}

#[test]
fn the_moment_at_a_small_heel_is_the_metacentric_height_times_the_weight() {
    // GM = I_wp/V - BG: 3²/(12·0.5) - 0.25 = 1.25 m for the wide box, 1/(12·1.5) - 0.75 = -0.694 m for the tall one.
    for (size, height) in [(Vec3::new(3.0, 1.0, 3.0), 1.25), (Vec3::new(1.0, 3.0, 1.0), -0.69444)] {
        for posed in [false, true] {
            let angle = 0.01;
            let mass = 500.0 * size.x * size.y * size.z;
            let mut world =
                Floating::new(size, mass, posed).turned(turned(angle, Vec3::Z)).world(0.0);
            let (_, moment) = load(&mut world);
            let found = -moment.z / (f64::from(mass) * G * libm::sin(f64::from(angle)));
            println!("posed {posed}: GM {found} m, exactly {height} m");
            assert!((found / height - 1.0).abs() < 1e-3, "{posed}: {found} {height}");
        }
    }
}

#[test]
fn a_sphere_of_triangles_is_as_deep_as_a_ball() {
    let (vertices, triangles) = sphere(4);
    let mut world = Simulation::default();
    world.particles.push(ParticleSeed::at(Vec3::ZERO)).unwrap();
    world.forces.fluids.push(Fluid::water(0.0));
    let skin = Skin::Posed { vertices, rest: vec![Vec3::ZERO] };
    world.forces.hulls.push(Hull::new(vec![0], triangles, skin).unwrap());
    assert!(!world.forces.hulls[0].is_open());
    let ball = 4.0 / 3.0 * core::f64::consts::PI * 1000.0 * G;
    for (ratio, depth) in [(0.25, 0.6527), (0.5, 1.0), (0.75, 1.3473)] {
        let (mut low, mut high) = (-1.0_f32, 1.0);
        for _ in 0..30 {
            let level = (low + high) * 0.5;
            world.forces.fluids[0].level = level;
            if load(&mut world).0.y < ratio * ball { low = level } else { high = level }
        }
        println!("{ratio}: depth {} R", low + 1.0);
        assert!((f64::from(low + 1.0) / depth - 1.0).abs() < 0.01, "{ratio}: {low}");
    }
}

#[test]
fn carriers_of_a_hull_do_not_float_as_balls_too_but_those_of_a_faulty_one_do() {
    for posed in [false, true] {
        let mut world = Floating::new(Vec3::ONE, 500.0, posed).world(0.5);
        let alone = load(&mut world);
        world.particles.radius.fill(0.3);
        assert_eq!(load(&mut world), alone, "{posed}");
        assert!((world.particles.rate(0) - rate_of_drag(0.5) * 0.5).abs() < 1e-6);
        world.forces.hulls[0].rows.pop();
        assert!((load(&mut world).0 - alone.0).length() > 100.0, "{posed}");
        world.forces.hulls[0].rows.push(99);
        assert!((load(&mut world).0 - alone.0).length() > 100.0, "{posed}");
    }
}

#[test]
fn five_kilometres_away_the_forces_are_the_same() {
    for posed in [false, true] {
        let rotation = turned(0.5, Vec3::new(1.0, 2.0, 3.0));
        let place = |x: f32| {
            let mut world = Floating::new(Vec3::new(2.0, 1.0, 3.0), 3000.0, posed).world(0.5);
            // Directly in local positions and origins: a world position in f32 cannot resolve a thousandth of a metre there.
            for i in 0..8 {
                let r = (rotation * world.particles.position(i).as_dvec3()).as_vec3();
                world.particles.position[i] = r.extend(world.particles.position[i].w);
                world.particles.origin[i] = Vec3::new(x, 0.0, -x);
            }
            load(&mut world);
            (world.particles.acceleration.clone(), world.particles.medium.clone())
        };
        assert_eq!(place(0.0), place(5000.0), "{posed}");
    }
}

#[test]
fn what_is_inside_out_floats_as_well() {
    for posed in [false, true] {
        let mut box_ = Floating::new(Vec3::new(2.0, 1.0, 3.0), 3000.0, posed);
        let right = load(&mut box_.world(0.5));
        let mirrored: Vec<[u32; 3]> = BOX.iter().map(|&[a, b, c]| [a, c, b]).collect();
        box_.triangles = mirrored.leak();
        let (force, _) = load(&mut box_.world(0.5));
        assert!((force - right.0).length() < 1e-6 * right.0.length(), "{posed}");
    }
}

#[test]
fn a_tilted_surface_lifts_along_its_normal_by_the_gravity_against_it() {
    // As in a stream on a slope: for hull and ball alike, the pressure gradient is perpendicular to the surface.
    let up = Vec3::new(0.6, 0.8, 0.0);
    let mut world = Floating::new(Vec3::ONE, 500.0, false).world(0.0);
    world.forces.fluids[0] = Fluid { up, level: 10.0, ..Fluid::water(0.0) };
    let (force, _) = load(&mut world);
    assert!((force - up.as_dvec3() * (1000.0 * G * 0.8)).length() < 1e-2, "{force}");
    world.forces.hulls.clear();
    world.particles.radius.fill(0.5);
    let (force, _) = load(&mut world);
    let balls = 8.0 * 1000.0 * G * 0.8 * core::f64::consts::PI / 6.0;
    assert!((force - up.as_dvec3() * balls).length() < 1e-2, "{force}");
}

#[test]
fn degenerate_and_broken_triangles_feel_nothing_and_spoil_nothing() {
    for posed in [false, true] {
        let mut good = Floating::new(Vec3::ONE, 500.0, posed);
        let alone = load(&mut good.world(0.5));
        let more = [BOX.as_slice(), &[[0, 0, 0], [1, 1, 2], [3, 3, 3]]].concat();
        good.triangles = more.leak();
        assert_eq!(load(&mut good.world(0.5)), alone, "{posed}");

        let mut world = good.world(0.5);
        world.particles.position[3] = Vec3::NAN.extend(1.0 / 62.5);
        load(&mut world);
        let others = (0..8).filter(|&i| i != 3);
        assert!(others.clone().all(|i| world.particles.acceleration(i).is_finite()), "{posed}");

        // Flat, collinear and coincident: the pose is not determined.
        for flat in [Vec3::new(1.0, 0.0, 1.0), Vec3::X, Vec3::ZERO] {
            let mut world = good.world(0.5);
            for i in 0..8 {
                let p = world.particles.position[i];
                world.particles.position[i] = (p.truncate() * flat - Vec3::Y).extend(p.w);
            }
            load(&mut world);
            assert!(world.particles.acceleration.iter().all(|a| a.is_finite()), "{posed} {flat}");
        }

        // Partly pinned, then fully.
        let mut world = good.world(0.5);
        for i in 0..8 {
            world.particles.position[i].w = 0.0;
            load_finite(&mut world);
        }
    }
}

fn load_finite(world: &mut Simulation) {
    world.begin_substep();
    world.apply_buoyancy();
    assert!(world.particles.acceleration.iter().all(|a| a.is_finite()));
}

#[test]
fn an_invalid_fluid_carries_nothing() {
    let mut world = Floating::new(Vec3::ONE, 500.0, false).world(0.5);
    let water = Fluid::water(0.0);
    for fluid in [
        Fluid { density: -1.0, ..water },
        Fluid { up: Vec3::ZERO, ..water },
        Fluid { drag: 1.1, ..water },
        Fluid { current: Vec3::NAN, ..water },
        water.within(Region::sphere(Vec3::NAN, 1.0)),
    ] {
        world.forces.fluids[0] = fluid;
        assert_eq!(load(&mut world), (DVec3::ZERO, DVec3::ZERO), "{fluid:?}");
    }
}
