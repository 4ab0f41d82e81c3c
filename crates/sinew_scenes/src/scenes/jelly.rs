//! A block of springs: spring forces alone, without constraints except contact with the ground.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ConstraintOf, MeshFollow, ParticleBody, ParticleOf, WindSurface};

use crate::look::Look;
use crate::props::mesh;
use crate::readings::{is_in_flight, thrown};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};

pub(super) const SCENE: Scene = Scene {
    name: "jelly",
    heading: Heading::Soft,
    title: "A jelly of springs",
    about: "125 particles and some 700 damped springs; a mesh follows the outer particles",
    eye: Vec3::new(1.6, 1.9, 4.6),
    target: Vec3::new(0.0, 0.75, -0.2),
    seconds: 5.0,
    moment: 0.62,
    lesson: Some(Lesson {
        try_this: "release the red block squeezed, with stiffer springs, or throw it up: in the air it swells and shrinks",
        watch: "each spring pulls both ends equally, so all springs together exert no net force: the block wobbles, and its barycentre falls like a stone",
        formula: "f_a = −f_b, so v = (v₀ + g/c) e^(−c t) − g/c, with e^(−c) = 1 − drag",
        sliders: &[
            SceneSlider { label: "Squeezed to", unit: "", range: [0.75, 1.0], default: 0.85 },
            SceneSlider { label: "Stiffness", unit: "N/m", range: [50.0, 140.0], default: 90.0 },
            SceneSlider { label: "Thrown up at", unit: "m/s", range: [0.0, 3.0], default: 1.0 },
        ],
        number: "Upward velocity of the barycentre",
        unit: "m/s",
        after: 0.35,
        measure: |world| {
            let velocity: LinearVelocity = component_of(world, "red jelly")?;
            is_in_flight(world, "red jelly").then_some(f64::from(velocity.0.y))
        },
        expect: |values, seconds| thrown(f64::from(values[2]), 9.81, f64::from(DRAG), seconds),
        tolerance: [0.01, 0.005],
    }),
    spawn,
};

/// Particles along each edge.
const SIDE: usize = 5;
/// Distance between neighbours, metres.
const GAP: f32 = 0.22;

/// Fraction of the velocity that air drag takes in a second.
const DRAG: f32 = 0.1;

fn spawn(world: &mut World) {
    let [squeezed, stiffness, speed] = values(world);
    world.insert_resource(AirDrag(DRAG));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    let (red, green) = (Vec3::new(-0.7, 1.9, 0.3), Vec3::new(1.0, 1.3, -1.0));
    for (name, place, turn, gap, stiffness, speed, color) in [
        ("red jelly", red, Vec3::new(0.4, 0.3, 0.5), squeezed * GAP, stiffness, speed, 0xd1495b),
        ("jelly", green, Vec3::new(0.1, 0.5, 0.9), GAP, 90.0, 0.0, 0x66a182),
    ] {
        let rotation = Quat::from_euler(EulerRot::XYZ, turn.x, turn.y, turn.z);
        let frame = Transform::from_translation(place).with_rotation(rotation);
        let body = block(world, name, frame, gap, stiffness, color);
        world.commands().entity(body).set_linear_velocity(Vec3::Y * speed);
    }
}

/// A block of springs of this stiffness, N/m, whose particles start `gap` metres apart.
fn block(
    world: &mut World,
    name: &'static str,
    frame: Transform,
    gap: f32,
    stiffness: f32,
    color: u32,
) -> Entity {
    let body = world
        .spawn((
            InScene,
            Name::new(name),
            ParticleBody,
            Look::color(color).roughness(0.25),
            Interpolate,
        ))
        .id();
    let cells: Vec<UVec3> = (0..SIDE * SIDE * SIDE)
        .map(|i| UVec3::new((i % SIDE) as u32, (i / SIDE % SIDE) as u32, (i / SIDE / SIDE) as u32))
        .collect();
    let middle = Vec3::splat((SIDE - 1) as f32 * 0.5);
    let place = |cell: UVec3| frame.transform_point((cell.as_vec3() - middle) * gap);
    let particles: Vec<Entity> = cells
        .iter()
        .map(|&cell| {
            let particle = (Particle::at(place(cell)), Mass(0.03), Radius(0.02), ParticleOf(body));
            world.spawn(particle).id()
        })
        .collect();
    let mut springs = Vec::new();
    for (i, &a) in cells.iter().enumerate() {
        for (j, &b) in cells.iter().enumerate().skip(i + 1) {
            let apart = a.as_ivec3() - b.as_ivec3();
            if apart.abs().max_element() > 1 {
                continue;
            }
            let rest = apart.as_vec3().length() * GAP;
            // Stable: 26 springs of 90 N/m on 30 g give ω h = √(90·26/0.03)/600 = 0.5 for substeps of 1/600 s, far below 2. The block sags by a centimetre or
            // two.
            let spring =
                Spring::new(particles[i], particles[j], rest, stiffness).with_damping(0.04);
            springs.push((spring, ConstraintOf(body)));
        }
    }
    world.spawn_batch(springs);
    let (skin, vertices, triangles) = skin(&particles);
    let skin = mesh(world, skin);
    let surface = WindSurface { triangles };
    world.entity_mut(body).insert((skin, MeshFollow { vertices }, surface));
    body
}

/// The outer faces as a mesh: each face has vertices of its own, so that edges stay sharp, each following a particle. Also as triangles of particles, by which
/// the block collides with bodies smaller than its cells.
fn skin(particles: &[Entity]) -> (Mesh, Vec<Entity>, Vec<[Entity; 3]>) {
    let at = |cell: [usize; 3]| particles[cell[0] + SIDE * (cell[1] + SIDE * cell[2])];
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    let mut numbers = std::collections::BTreeMap::new();
    for axis in 0..3 {
        for side in [0, SIDE - 1] {
            let corner = |u: usize, v: usize| {
                let mut cell = [0; 3];
                (cell[axis], cell[(axis + 1) % 3], cell[(axis + 2) % 3]) = (side, u, v);
                cell
            };
            for u in 0..SIDE - 1 {
                for v in 0..SIDE - 1 {
                    let around = [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)];
                    let mut quad = around.map(|(u, v)| {
                        let cell = corner(u, v);
                        *numbers.entry(cell).or_insert_with(|| {
                            vertices.push(at(cell));
                            vertices.len() as u32 - 1
                        })
                    });
                    if side == 0 {
                        quad.reverse();
                    }
                    let [a, b, c, d] = quad;
                    indices.extend([a, b, c, a, c, d]);
                }
            }
        }
    }
    let corner = |&i: &u32| vertices[i as usize];
    let triangles = indices.chunks_exact(3).map(|t| [0, 1, 2].map(|i| corner(&t[i]))).collect();
    let skin = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; vertices.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0_f32, 1.0, 0.0]; vertices.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0_f32; 2]; vertices.len()])
        .with_inserted_indices(Indices::U32(indices));
    (skin, vertices, triangles)
}
