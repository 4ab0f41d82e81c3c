//! Scenes of body colliders: rest, towers, slopes, conveyors, bounces, conservation, heaps, ragdolls.

mod contact_cache;
mod drag;
mod ghosts;
mod heaps;
mod kept;
mod kinematic_geometry;
mod loose;
mod missed_pairs;
mod neighbour_lanes;
mod rest;
mod restitution;
mod rolling;
mod set_down;
mod slopes;
mod static_geometry;
mod twins;
mod wedged;

use glam::{Quat, Vec3};

use crate::collide::{BodyCollider, BodyContacts, Collider, Frame, Material, Shape};
use crate::recipes::{Blueprint, BoxLayout, BoxSpec, box_3d};
use crate::simulation::Simulation;
use crate::test_random::Random;

/// A world with gravity and ten substeps.
fn world() -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = 10;
    world
}

/// A level mesh of cells of a size, with a number of vertices along x and along z; its middle is at `far` along x in the coordinates of the mesh, metres.
fn tiles([columns, rows]: [u32; 2], size: [f32; 2], far: f32) -> Shape {
    let at = |i: u32, of: u32, size: f32| (i as f32 - 0.5 * (of - 1) as f32) * size;
    let vertex = |i: u32| {
        Vec3::new(far + at(i % columns, columns, size[0]), 0.0, at(i / columns, rows, size[1]))
    };
    let cells = (0..columns * (rows - 1)).filter(|i| i % columns + 1 < columns);
    let triangles =
        cells.flat_map(|i| [[i, i + columns, i + 1], [i + 1, i + columns, i + columns + 1]]);
    Shape::mesh((0..columns * rows).map(vertex).collect(), triangles.collect()).unwrap()
}

/// Adds a box and returns its first row.
fn add_box(world: &mut Simulation, size: Vec3, mass: f32, at: Vec3, turned: Quat) -> usize {
    let spec = BoxSpec { size, mass, layout: BoxLayout::Equimomental, ..BoxSpec::default() };
    let body = box_3d(&spec).unwrap();
    add(world, &body, Shape::cuboid(size).unwrap(), at, turned)
}

/// Adds a body of one part as a body collider, and returns its first row.
fn add(world: &mut Simulation, body: &Blueprint, shape: Shape, at: Vec3, turned: Quat) -> usize {
    let rows = body.transformed(turned, at).build(world).unwrap();
    let part = &body.parts[0];
    let rest = part.rest.clone().into();
    let first = rows.start;
    let rows = part.particles.iter().map(|&p| first as u32 + p).collect();
    let id = world.body_colliders().len() as u64;
    world.body_colliders_mut().push(BodyCollider { rows, rest, shape, id });
    first
}

/// A rotation about an axis by an angle, rad.
fn turn(axis: Vec3, angle: f32) -> Quat {
    let axis = axis.normalize() * libm::sinf(0.5 * angle);
    Quat::from_xyzw(axis.x, axis.y, axis.z, libm::cosf(0.5 * angle))
}

/// Adds a floor of a material, and gives it to all bodies.
fn floor(world: &mut Simulation, material: Material) {
    let floor = Collider::fixed(Shape::half_space(), Frame::IDENTITY).with_material(material);
    world.colliders.push(floor);
    set_material(world, material);
}

fn rough(friction: f32) -> Material {
    Material::default().with_friction(friction)
}

fn elastic(restitution: f32) -> Material {
    Material::default().with_friction(0.0).with_restitution(restitution)
}

/// Gives a material to all bodies.
fn set_material(world: &mut Simulation, material: Material) {
    *world.contacts = vec![BodyContacts { material, ..Default::default() }; 2000];
}

fn step(world: &mut Simulation, seconds: f32) {
    for _ in 0..(seconds * 60.0).round() as u32 {
        world.step(1.0 / 60.0).unwrap();
    }
}

/// Root mean square of the velocities, m/s.
fn speed(world: &Simulation) -> f32 {
    let particles = &world.particles;
    let sum: f32 = (0..particles.len()).map(|i| particles.velocity(i).length_squared()).sum();
    (sum / particles.len() as f32).sqrt()
}

/// Mean position of eight rows, metres.
fn centre(world: &Simulation, first: usize) -> Vec3 {
    (first..first + 8).map(|i| world.particles.position(i)).sum::<Vec3>() / 8.0
}

/// Mean velocity of eight rows, m/s.
fn velocity(world: &Simulation, first: usize) -> Vec3 {
    (first..first + 8).map(|i| world.particles.velocity(i)).sum::<Vec3>() / 8.0
}

/// Gives eight rows a velocity and a spin about their centre.
fn throw(world: &mut Simulation, first: usize, velocity: Vec3, spin: Vec3) {
    let centre = centre(world, first);
    for i in first..first + 8 {
        let arm = world.particles.position(i) - centre;
        world.particles.set_velocity(i, velocity + spin.cross(arm));
    }
}
