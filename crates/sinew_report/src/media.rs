//! Rows F6 to F9: fluids, friction, and the statics of a hanging chain.

use sinew::glam::Vec3;
use sinew::recipes::{BoxSpec, RopeSpec, box_3d, rope};
use sinew::{Fluid, Hull, ParticleSeed, PlanarDrag, Plane, Simulation, Skin};

use crate::Row;
use crate::case::cases;
use crate::measure::{G, TICK, at, largest, period, rises, steps};

cases! {
    "F6" a_ball_floats_as_deep_as_its_density_says;
    "F6" a_box_floats_as_deep_as_its_density_says_closed_or_open;
    "F6" a_box_heaves_in_the_time_of_a_pendulum_as_long_as_its_draft;
    "F7" a_fluid_damps_by_the_submerged_share;
    "F8" a_block_slides_exactly_if_the_slope_is_steeper_than_friction_holds;
    "F8" a_sliding_block_stops_after_the_distance_that_friction_gives;
    "F8" a_drag_along_the_plane_takes_its_share_each_second;
    "F9" a_chain_hangs_as_its_catenary;
}

/// Depth relative to the radius at which a ball of `ratio` of the fluid's density floats: solves `d²(3 - d) = 4·ratio` by bisection.
fn floating_depth(ratio: f64) -> f64 {
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..60 {
        let d = 0.5 * (low + high);
        if d * d * (3.0 - d) < 4.0 * ratio { low = d } else { high = d }
    }
    low
}

/// At rest two forces of `f32` cancel, which determines the depth to 1e-6 of the radius. A quarter of the drag's rate leaves e⁻²² of the initial amplitude.
fn a_ball_floats_as_deep_as_its_density_says() -> Vec<Row> {
    let row = |ratio: f32| {
        let radius = 0.2_f32;
        let volume = 4.0 / 3.0 * core::f32::consts::PI * radius * radius * radius;
        let mut world = Simulation::default();
        world.forces.fluids.push(Fluid { drag: 0.95, ..Fluid::water(1.0) });
        let mass = 1000.0 * ratio * volume;
        let seed = ParticleSeed::at(Vec3::Y * 1.1).with_mass(mass).with_radius(radius);
        world.particles.push(seed).expect("a sound particle");
        steps(&mut world, TICK, 60 * 60);
        let depth = (1.0 - at(&world, 0).y) / f64::from(radius) + 1.0;
        let what = format!("depth over radius of a ball of {ratio} of the water's density");
        Row::relative(what, "", floating_depth(f64::from(ratio)), depth, 1e-4)
    };
    [0.25, 0.5, 0.75].map(row).into()
}

/// A box of 3×1×3 m with a hull, level, with its centre at `height` above the water; without its top if it is open.
fn boat(ratio: f32, height: f32, drag: f32, open: bool) -> Simulation {
    let mut world = Simulation::default();
    world.forces.fluids.push(Fluid { drag, ..Fluid::water(0.0) });
    let spec =
        BoxSpec { size: Vec3::new(3.0, 1.0, 3.0), mass: 9000.0 * ratio, ..BoxSpec::default() };
    let body =
        box_3d(&spec).expect("a sound box").transformed(Default::default(), Vec3::Y * height);
    let rows = body.build(&mut world).expect("room");
    let high = |v: &u32| body.particles[*v as usize].position.y > height;
    let skin = body.triangles.iter().copied().filter(|t| !(open && t.iter().all(high)));
    let rows = rows.map(|i| i as u32).collect();
    let hull = Hull::new(rows, skin.collect(), Skin::Carriers).expect("a sound hull");
    world.forces.hulls.push(hull);
    world
}

/// Height of its centre, m.
fn middle(world: &Simulation) -> f64 {
    (0..8).map(|i| at(world, i).y).sum::<f64>() / 8.0
}

/// At rest two forces of `f32` cancel, and e⁻²² is left of the initial amplitude.
fn a_box_floats_as_deep_as_its_density_says_closed_or_open() -> Vec<Row> {
    let row = |(ratio, open): (f32, bool)| {
        let mut world = boat(ratio, 0.6 - ratio, 0.95, open);
        steps(&mut world, TICK, 60 * 60);
        let kind = if open { "an open" } else { "a closed" };
        let what = format!("draft over height of {kind} box of {ratio} of the water's density");
        Row::relative(what, "", f64::from(ratio), 0.5 - middle(&world), 1e-4)
    };
    [(0.25, false), (0.5, false), (0.75, false), (0.25, true), (0.5, true)].map(row).into()
}

/// Vertical walls make it a harmonic oscillator. Verlet shifts the period by (ωh)²/24 = 2e-6 at 600 substeps a second.
fn a_box_heaves_in_the_time_of_a_pendulum_as_long_as_its_draft() -> Vec<Row> {
    let mut world = boat(0.5, 0.1, 0.0, false);
    let measured = period(&rises(&mut world, TICK, 20.0, middle));
    let exact = core::f64::consts::TAU * libm::sqrt(0.5 / G);
    vec![Row::relative(
        "heave of a box with a draft of 0.5 m: 2π√(draft/g)",
        "s",
        exact,
        measured,
        1e-4,
    )]
}

/// A ball that floats in equilibrium moves sideways: along that direction only the drag acts.
fn a_fluid_damps_by_the_submerged_share() -> Vec<Row> {
    let row = |(name, height, ratio, share): (&str, f32, f32, f64)| {
        let radius = 0.2_f32;
        let volume = 4.0 / 3.0 * core::f32::consts::PI * radius * radius * radius;
        let mut world = Simulation::default();
        world.forces.fluids.push(Fluid::water(0.0));
        let seed = ParticleSeed::at(Vec3::Y * height)
            .with_mass(1000.0 * ratio * volume)
            .with_radius(radius)
            .with_velocity(Vec3::X * 2.0);
        world.particles.push(seed).expect("a sound particle");
        steps(&mut world, TICK, 120);
        let t = 2.0 - 0.5 / 600.0;
        let exact = 2.0 * libm::pow(0.2, t * share);
        let measured = f64::from(world.particles.velocity(0).x);
        Row::relative(
            format!("2 m/s after 2 s in water of drag 0.8, {name}"),
            "m/s",
            exact,
            measured,
            1e-4,
        )
    };
    [("wholly under", -1.0, 1.0, 1.0), ("half under", 0.0, 0.5, 0.5), ("above it", 99.0, 0.01, 0.0)]
        .map(row)
        .into()
}

/// Distance, metres, that a particle slides in 2 s down a slope of `slope` (tan θ) with friction 0.4.
fn slid(slope: f32) -> f64 {
    let mut world = Simulation::default();
    let normal = Vec3::new(slope, 1.0, 0.0);
    let plane = Plane::new(Vec3::ZERO, normal).expect("a plane with a direction");
    world.boundaries.planes.push(plane.with_friction(0.4));
    world.particles.push(ParticleSeed::at(Vec3::ZERO)).expect("a sound particle");
    steps(&mut world, TICK, 120);
    at(&world, 0).length()
}

/// The corrections obey Coulomb's law in every substep, so only round-off is left: a particle is pressed into the plane by 3e-5 m a substep, and a position of
/// 1 m is rounded by 6e-8 m, either way.
fn a_block_slides_exactly_if_the_slope_is_steeper_than_friction_holds() -> Vec<Row> {
    let exact = |slope: f64| G * (slope - 0.4) / libm::sqrt(1.0 + slope * slope) * 2.0;
    vec![
        Row::absolute("distance in 2 s, μ = 0.4, tan θ = 0.39", "m", 0.0, slid(0.39), 1e-4),
        Row::relative("the same, tan θ = 0.41", "m", exact(0.41), slid(0.41), 5e-3),
        Row::relative("the same, tan θ = 0.5", "m", exact(0.5), slid(0.5), 5e-3),
    ]
}

/// Planar drag is an exponential, applied in each substep: exact but for round-off.
fn a_drag_along_the_plane_takes_its_share_each_second() -> Vec<Row> {
    let speed = |along: f32| {
        let mut world = Simulation::default();
        let drag = PlanarDrag { along, across: 0.0 };
        let plane = Plane { drag, ..Plane::ground(0.0).with_friction(0.0) };
        world.boundaries.planes.push(plane);
        let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::X * 3.0);
        world.particles.push(seed).expect("a sound particle");
        steps(&mut world, TICK, 120);
        f64::from(world.particles.velocity(0).x)
    };
    [0.2, 0.6]
        .map(|along| {
            let left = 1.0 - f64::from(along);
            let what = format!("3 m/s after 2 s on a plane of drag {along} along it");
            Row::relative(what, "m/s", 3.0 * left * left, speed(along), 1e-5)
        })
        .into()
}

fn a_sliding_block_stops_after_the_distance_that_friction_gives() -> Vec<Row> {
    let row = |(speed, friction): (f32, f32)| {
        let mut world = Simulation::default();
        world.boundaries.planes.push(Plane::ground(0.0).with_friction(friction));
        let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::X * speed);
        world.particles.push(seed).expect("a sound particle");
        steps(&mut world, TICK, 180);
        let exact = f64::from(speed * speed) / (2.0 * f64::from(friction) * G);
        let what = format!("stopping distance from {speed} m/s, μ = {friction}: v²/2μg");
        // The particle stops at the end of a substep, not within it: an error of less than v·h = μg·h².
        Row::relative(what, "m", exact, at(&world, 0).x, 1e-3)
    };
    [(3.0, 0.5), (2.0, 0.2)].map(row).into()
}

/// A chain of `links` links, 1.5 m long, between two points 1 m apart, at rest.
pub(crate) fn hanging_chain(links: u32) -> Simulation {
    let mut world = Simulation::default();
    let spec = RopeSpec {
        from: Vec3::ZERO,
        to: Vec3::X,
        segments: links,
        slack: 0.5,
        pin_start: true,
        pin_end: true,
        ..RopeSpec::default()
    };
    rope(&spec).expect("a sound rope").build(&mut world).expect("room for it");
    world.settings.statics = true;
    world.settings.substeps = 1;
    world.settings.tolerance = 0.0;
    world.settings.max_sweeps = 1000;
    // Long steps move the chain far and leave the links stretched by the distance that they fall in a step; shorter steps refine from there.
    steps(&mut world, 1.0 / 30.0, 100);
    steps(&mut world, 1.0 / 120.0, 500);
    world
}

/// The sag of a chain of N links, computed link by link from the balance of forces (physics.md F9); the catenary itself sags by 0.5026 m. 0.5 % is the required
/// accuracy: a sweep propagates a force by one link, so after a thousand sweeps a hundred links are still about 0.1 % too long.
fn a_chain_hangs_as_its_catenary() -> Vec<Row> {
    let mut rows = Vec::new();
    for (links, exact) in [(10, 0.50595), (20, 0.50345), (50, 0.50276), (100, 0.50267)] {
        let world = hanging_chain(links);
        let n = world.particles.len();
        let sag = largest((0..n).map(|i| -at(&world, i).y));
        let lengths = (1..n).map(|i| (at(&world, i) - at(&world, i - 1)).length());
        let length: f64 = lengths.sum();
        rows.push(Row::relative(format!("sag of {links} links"), "m", exact, sag, 0.005));
        rows.push(Row::relative(format!("length of {links} links"), "m", 1.5, length, 0.001));
    }
    rows
}
