//! Sheets of few triangles, and objects that fall on them.
//!
//! Whole simulations, because contacts must also work beside distance constraints and gravity.

mod bare;
mod bits;
mod chaos;
mod cloths;
mod marbles;

use glam::Vec3;

use crate::collide::{BodyContacts, Material};
use crate::constraints::Distance;
use crate::lanes::InstructionSet;
use crate::particles::ParticleSeed;
use crate::simulation::Simulation;
use crate::threads::ExecutionContext;

const DT: f32 = 1.0 / 60.0;

/// A single thread.
const ALONE: ExecutionContext<'static> =
    ExecutionContext { instructions: InstructionSet::Simd128, workers: None };

/// An empty world with ten substeps.
fn empty(gravity: f32) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = 10;
    world.forces.gravity = Vec3::Y * -gravity;
    world
}

/// Contacts of a body with a surface that collides with other bodies, and optionally with itself.
fn colliding(with_itself: bool) -> BodyContacts {
    BodyContacts { with_bodies: true, with_itself, surface: true, ..Default::default() }
}

fn with_material(contacts: BodyContacts, friction: f32, restitution: f32) -> BodyContacts {
    BodyContacts { material: Material { friction, restitution, ..Default::default() }, ..contacts }
}

/// Adds a body.
fn body(world: &mut Simulation, contacts: BodyContacts) -> u32 {
    world.bodies.push(Default::default());
    world.contacts.resize(world.bodies.len(), Default::default());
    world.contacts[world.bodies.len() - 1] = contacts;
    world.bodies.len() as u32 - 1
}

fn particle(world: &mut Simulation, seed: ParticleSeed, body: u32) -> usize {
    let row = world.particles.push(seed).unwrap() as usize;
    world.particles.set_body(row, Some(body));
    row
}

/// A sheet to be built: a number of square cells along two axes from a corner, of `size` metres each.
#[derive(Clone, Copy)]
struct Sheet {
    cells: [usize; 2],
    size: f32,
    corner: Vec3,
    axes: [Vec3; 2],
    radius: f32,
    /// Of each particle, kg.
    mass: f32,
    contacts: BodyContacts,
}

impl Sheet {
    /// A horizontal sheet at a height, centred at x = z = 0.
    fn flat(cells: usize, size: f32, height: f32) -> Self {
        let half = 0.5 * size * cells as f32;
        Self {
            cells: [cells; 2],
            size,
            corner: Vec3::new(-half, height, -half),
            axes: [Vec3::X, Vec3::Z],
            radius: 0.005,
            mass: 0.02,
            contacts: colliding(false),
        }
    }

    /// Builds it, with distance constraints along the edges of its triangles, and returns its rows, row by row of the sheet. `pinned` selects pinned particles.
    fn build(self, world: &mut Simulation, pinned: impl Fn(usize, usize) -> bool) -> Vec<usize> {
        let own = body(world, self.contacts);
        let [columns, rows] = self.cells.map(|cells| cells + 1);
        let mut found = Vec::new();
        for j in 0..rows {
            for i in 0..columns {
                let flat = [i as f32 * self.size, j as f32 * self.size];
                let at = self.corner + self.axes[0] * flat[0] + self.axes[1] * flat[1];
                let seed = ParticleSeed::at(at).with_mass(self.mass).with_radius(self.radius);
                let seed = if pinned(i, j) { seed.pinned() } else { seed };
                let row = particle(world, seed, own);
                world.particles.set_rest(row, Some(Vec3::new(flat[0], 0.0, flat[1])));
                found.push(row);
            }
        }
        let at = |i: usize, j: usize| found[j * columns + i];
        for j in 0..rows {
            for i in 0..columns {
                for (to_i, to_j) in [(i + 1, j), (i, j + 1), (i + 1, j + 1)] {
                    if to_i < columns && to_j < rows {
                        let (a, b) = (at(i, j), at(to_i, to_j));
                        let length = world.particles.separation(a, b).length();
                        world.distances_mut().push(Distance::new(a as u32, b as u32, length));
                    }
                }
                if i + 1 < columns && j + 1 < rows {
                    let cell = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let [a, b, c, d] = cell.map(|row| row as u32);
                    world.forces.surfaces.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        found
    }
}

/// Momentum of particles that can move, kg·m/s.
fn momentum(world: &Simulation) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for i in (0..world.particles.len()).filter(|&i| world.particles.inverse_mass(i) > 0.0) {
        let (mass, v) = (world.particles.mass(i), world.particles.velocity(i));
        (0..3).for_each(|k| sum[k] += f64::from(mass) * f64::from(v[k]));
    }
    sum
}

/// Number of edges that pass through triangles of the surfaces, by brute force: zero for meshes that began apart.
fn entangled(world: &Simulation) -> usize {
    let at = |row: u32| world.particles.position(row as usize).as_dvec3();
    let surfaces = &world.forces.surfaces;
    let mut count = 0;
    for triangle in surfaces {
        let [a, b, c] = triangle.map(at);
        let n = (b - a).cross(c - a);
        for edges in surfaces {
            for [i, j] in [[0, 1], [1, 2], [2, 0]] {
                let ends = [edges[i], edges[j]];
                if ends[0] > ends[1] || ends.iter().any(|end| triangle.contains(end)) {
                    continue;
                }
                let [p, q] = ends.map(at);
                let (over, under) = (n.dot(p - a), n.dot(q - a));
                if (over > 0.0) == (under > 0.0) {
                    continue;
                }
                let x = p.lerp(q, over / (over - under));
                let inside = [[a, b], [b, c], [c, a]]
                    .iter()
                    .all(|&[from, to]| n.dot((to - from).cross(x - from)) > 0.0);
                count += usize::from(inside);
            }
        }
    }
    count
}

fn bits(world: &Simulation, rows: &[usize]) -> Vec<[u32; 6]> {
    rows.iter()
        .map(|&i| {
            let (p, v) = (world.particles.position(i), world.particles.velocity(i));
            [p.x, p.y, p.z, v.x, v.y, v.z].map(f32::to_bits)
        })
        .collect()
}
