//! A block of springs: soft forces alone, no constraint but the ground.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ConstraintOf, MeshFollow, ParticleBody, ParticleOf, WindSurface};

use super::{Scene, mesh};
use crate::{Heading, InScene, Look};

pub(super) const SCENE: Scene = Scene {
    name: "jelly",
    heading: Heading::Soft,
    title: "A jelly of springs",
    about: "125 particles and some 700 damped springs; its skin is a mesh that follows the outer ones",
    eye: Vec3::new(1.6, 1.9, 4.6),
    target: Vec3::new(0.0, 0.75, -0.2),
    seconds: 5.0,
    moment: 0.62,
    lesson: None,
    spawn,
};

/// Particles along each edge.
const SIDE: usize = 5;
/// Distance between neighbours, metres.
const GAP: f32 = 0.22;

fn spawn(world: &mut World) {
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    for (place, turn, color) in [
        (Vec3::new(-0.7, 1.9, 0.3), Vec3::new(0.4, 0.3, 0.5), 0xd1495b),
        (Vec3::new(1.0, 1.3, -1.0), Vec3::new(0.1, 0.5, 0.9), 0x66a182),
    ] {
        let rotation = Quat::from_euler(EulerRot::XYZ, turn.x, turn.y, turn.z);
        block(world, Transform::from_translation(place).with_rotation(rotation), color);
    }
}

fn block(world: &mut World, frame: Transform, color: u32) {
    let body = world
        .spawn((
            InScene,
            Name::new("jelly"),
            ParticleBody,
            Look::color(color).roughness(0.25),
            Interpolate,
        ))
        .id();
    let cells: Vec<UVec3> = (0..SIDE * SIDE * SIDE)
        .map(|i| UVec3::new((i % SIDE) as u32, (i / SIDE % SIDE) as u32, (i / SIDE / SIDE) as u32))
        .collect();
    let middle = Vec3::splat((SIDE - 1) as f32 * 0.5);
    let place = |cell: UVec3| frame.transform_point((cell.as_vec3() - middle) * GAP);
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
            // 90 N/m on 30 g: ω h = √(90·26/0.03)/1200 is far below 2, and the block sags by a centimetre or two.
            let spring = Spring::new(particles[i], particles[j], rest, 90.0).with_damping(0.04);
            springs.push((spring, ConstraintOf(body)));
        }
    }
    world.spawn_batch(springs);
    let (skin, vertices, triangles) = skin(&particles);
    let skin = mesh(world, skin);
    let surface = WindSurface { triangles };
    world.entity_mut(body).insert((skin, MeshFollow { vertices }, surface));
}

/// The outer faces as a mesh: its own vertices on every face, so that edges stay sharp, each following a particle. And as triangles of particles, by which
/// it meets what is smaller than its cells.
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
