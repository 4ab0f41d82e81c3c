//! Row F5: wind as a pressure, and air with drag and lift.

use sinew::glam::{DVec3, Vec3};
use sinew::recipes::{BoxSpec, box_3d};
use sinew::{AirFlow, ParticleSeed, Simulation, Wind};

use crate::Row;
use crate::case::cases;
use crate::measure::{Dice, G, TICK, empty, force, rotation, steps};

cases! {
    "F5" wind_force_on_a_sheet_is_proportional_to_its_projected_area;
    "F5" the_front_of_a_closed_body_gets_the_wind_force_of_its_silhouette;
    "F5" drag_and_lift_follow_the_angle_of_attack;
    "F5" a_falling_sheet_reaches_its_terminal_speed;
    "F5" a_storm_never_reverses_what_moves_in_it;
}

/// A square sheet of 2 m² and `mass` kg, turned by `angle` (radians) about x from the horizontal. Each corner has the share of the mass that belongs to its
/// triangles, so the sheet moves as a whole without constraints.
fn sheet(mass: f32, angle: f64) -> Simulation {
    let mut world = empty(1);
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    for (x, y, share) in [(-1.0, -1.0, 3.0), (1.0, -1.0, 6.0), (1.0, 1.0, 3.0), (-1.0, 1.0, 6.0)] {
        let (x, y) = (x / core::f64::consts::SQRT_2, y / core::f64::consts::SQRT_2);
        let at = DVec3::new(x, y * s, y * c).as_vec3();
        world
            .particles
            .push(ParticleSeed::at(at).with_mass(mass / share))
            .expect("a sound particle");
    }
    *world.forces.surfaces = vec![[0, 1, 2], [0, 2, 3]];
    world
}

/// Tolerance: ten roundings of `f32` on the way to a force of about 20 N.
fn wind_force_on_a_sheet_is_proportional_to_its_projected_area() -> Vec<Row> {
    [0.0, 30.0, 60.0, 90.0]
        .map(|degrees: f64| {
            let angle = degrees * core::f64::consts::PI / 180.0;
            let mut world = sheet(1.0, angle);
            world.forces.winds.push(Wind::steady(Vec3::Y * 10.0));
            let exact = 2.0 * 10.0 * libm::cos(angle);
            let what = format!("force of 10 Pa on 2 m² turned away by {degrees}°: A‖w‖cos θ");
            Row::absolute(what, "N", exact, force(&mut world).y, 1.2e-5)
        })
        .into()
}

/// The back has the same projected area as the front, so the front takes half of the force.
fn the_front_of_a_closed_body_gets_the_wind_force_of_its_silhouette() -> Vec<Row> {
    let size = Vec3::new(1.0, 2.0, 3.0);
    let body = box_3d(&BoxSpec { size, ..BoxSpec::default() }).expect("a sound box");
    let mut dice = Dice(2);
    [(); 3]
        .map(|()| {
            let turn = rotation(&mut dice);
            let mut world = empty(1);
            for seed in &body.particles {
                let at = (turn * seed.position.as_dvec3()).as_vec3();
                world.particles.push(ParticleSeed::at(at)).expect("a sound particle");
            }
            *world.forces.surfaces = body.triangles.clone();
            world.forces.winds.push(Wind::steady(Vec3::X * 10.0));
            // The projected area of each of the three pairs of faces is its area times the cosine of its normal.
            let shown = |axis: DVec3, area: f64| (turn * axis).x.abs() * area;
            let exact = 10.0 * (shown(DVec3::X, 6.0) + shown(DVec3::Y, 3.0) + shown(DVec3::Z, 2.0));
            let front = 0.5 * force(&mut world).x;
            Row::relative(
                "10 Pa on the front of a 1×2×3 m box, turned at random",
                "N",
                exact,
                front,
                2e-6,
            )
        })
        .into()
}

fn drag_and_lift_follow_the_angle_of_attack() -> Vec<Row> {
    let mut rows = Vec::new();
    for degrees in [15.0, 45.0, 90.0] {
        let attack = degrees * core::f64::consts::PI / 180.0;
        // A heavy sheet, on which the bound against overshooting does not act.
        let mut world = sheet(100.0, core::f64::consts::FRAC_PI_2 - attack);
        let flow = AirFlow { lift: 1.0, ..AirFlow::steady(Vec3::Y * 5.0) };
        world.forces.air_flows.push(flow);
        let dynamic = 0.5 * f64::from(flow.density) * 25.0 * 2.0;
        let (s, c) = (libm::sin(attack), libm::cos(attack));
        let felt = force(&mut world);
        let what = format!("drag on 2 m² at 5 m/s, angle of attack {degrees}°");
        rows.push(Row::relative(what, "N", dynamic * f64::from(flow.drag) * s, felt.y, 2e-6));
        let across = (felt.x * felt.x + felt.z * felt.z).sqrt();
        let what = format!("lift on it at {degrees}°: ½ρC_L A v² sin α cos α");
        rows.push(Row::absolute(what, "N", dynamic * s * c, across, 3e-5));
    }
    rows
}

/// The force does not depend on the step, so the speed at which it balances the weight is exact but for about ten roundings.
fn a_falling_sheet_reaches_its_terminal_speed() -> Vec<Row> {
    let mut world = sheet(0.5, 0.0);
    world.settings.substeps = 10;
    world.forces.gravity = Vec3::Y * -9.81;
    let air = AirFlow::steady(Vec3::ZERO);
    world.forces.air_flows.push(air);
    steps(&mut world, TICK, 600);
    let exact = libm::sqrt(2.0 * 0.5 * G / (f64::from(air.density) * f64::from(air.drag) * 2.0));
    let speed = -f64::from(world.particles.velocity(0).y);
    vec![Row::relative("terminal speed of 2 m², 0.5 kg: √(2mg/ρC_D A)", "m/s", exact, speed, 1e-5)]
}

fn a_storm_never_reverses_what_moves_in_it() -> Vec<Row> {
    let mut world = sheet(1e-4, 0.0);
    world.forces.air_flows.push(AirFlow::steady(Vec3::Y * 40.0));
    let (mut most, mut least) = (0.0_f64, f64::INFINITY);
    for n in 0..120 {
        steps(&mut world, TICK, 1);
        let speed = f64::from(world.particles.velocity(0).y);
        most = most.max(speed);
        if n > 0 {
            least = least.min(speed);
        }
    }
    vec![
        // One or two roundings at 40 m/s.
        Row::at_most(
            "highest speed of a sheet of 0.1 g in a wind of 40 m/s, 1/60 s",
            "m/s",
            40.0 + 1e-5,
            most,
        ),
        Row::at_least("its speed is never below 0 after the first step", "m/s", 0.0, least),
    ]
}
