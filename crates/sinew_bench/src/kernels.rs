//! A table of simulations whose work is one kernel each. The micro benchmark `kernels` runs every line of it through the public API.
//!
//! A kernel that runs in a sweep is repeated in a hundred sweeps of one substep, so that the rest of the step is negligible. A kernel that runs in a substep,
//! and one that converges exactly within a few sweeps, is repeated in a hundred substeps instead, with the integration beside it: subtract the line
//! `integration alone`, which is per particle.

use std::fmt;
use std::sync::Arc;

use sinew::constraints::{Angle, Tetrahedron, Volume};
use sinew::glam::Vec3;
use sinew::recipes::{Blueprint, RopeSpec, rope};
use sinew::{
    Bound, Constraint, ConstraintKind, Distance, ParticleSeed, Pin, Plane, Simulation,
    SolverSettings, Spring, Wind,
};

use crate::scenes::bending::{self, Bending};
use crate::scenes::{charges, cloth, empty};

/// Number of sweeps, or of substeps, of a measured step.
const OFTEN: u32 = 100;

/// Particles along a side of the sheets: the working set fits into the L2 cache.
const SIDE: u32 = 64;

/// Charges in the kernel over all pairs.
const CHARGES: usize = 512;

/// A line of the table.
#[derive(Clone, Copy)]
pub struct Kernel {
    /// Name of the kernel.
    pub name: &'static str,
    build: fn() -> (Simulation, usize),
}

/// A simulation, and how many times the kernel runs in one of its steps.
pub struct Work {
    /// The simulation; step it by 1/60 s.
    pub world: Simulation,
    /// How many times the kernel runs in a step.
    pub count: usize,
}

/// All kernels.
pub const KERNELS: &[Kernel] = &[
    kernel("rods on a grid", || swept(cloth::sheet(SIDE))),
    kernel("rods on a shuffled mesh", || swept(cloth::scattered(SIDE))),
    kernel("rope (at most)", || swept(thread())),
    kernel("soft rods", || swept(soft())),
    kernel("bend", || swept(bends(Bending::Isometric))),
    kernel("hinge", || swept(bends(Bending::Dihedral))),
    kernel("angle", || stepped(angles())),
    kernel("tetrahedron", || swept(tetrahedra())),
    kernel("volume (of 12 triangles)", || stepped(volumes())),
    kernel("plane", || {
        let (mut world, count) = substeps(loose(), |_, _| {});
        world.boundaries.planes.push(Plane::ground(0.0));
        (world, count)
    }),
    kernel("pin", || {
        substeps(loose(), |world, i| {
            let target = world.particles.position(i);
            world.boundaries.pins.push(Pin { particle: i as u32, target });
        })
    }),
    kernel("spring", || {
        let sheet = cloth::sheet(SIDE);
        let springs = sheet.distances.iter().map(|d| Spring {
            a: d.a,
            b: d.b,
            rest: d.rest,
            stiffness: 0.1,
            damping: 0.0,
        });
        let springs: Vec<Spring> = springs.collect();
        let (mut world, _) = substeps(Blueprint { distances: Vec::new(), ..sheet }, |_, _| {});
        let count = springs.len();
        world.forces.springs = springs;
        (world, count * OFTEN as usize)
    }),
    kernel("wind (a triangle)", || {
        let sheet = Blueprint { distances: Vec::new(), ..cloth::sheet(SIDE) };
        let count = sheet.triangles.len();
        let (mut world, _) = substeps(sheet, |_, _| {});
        world.forces.winds.push(Wind::steady(Vec3::new(0.01, 0.01, 0.0)));
        (world, count * OFTEN as usize)
    }),
    kernel("charges, all pairs", || {
        let mut world = charges::cloud(CHARGES, CHARGES as u32);
        world.settings.substeps = OFTEN;
        (world, CHARGES * (CHARGES - 1) / 2 * OFTEN as usize)
    }),
    kernel("integration alone", || substeps(loose(), |_, _| {})),
];

const fn kernel(name: &'static str, build: fn() -> (Simulation, usize)) -> Kernel {
    Kernel { name, build }
}

impl Kernel {
    /// Builds its simulation.
    pub fn work(&self) -> Work {
        let (world, count) = (self.build)();
        Work { world, count }
    }
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// A simulation of a body with many sweeps in one substep.
fn swept(body: Blueprint) -> (Simulation, usize) {
    let count = (body.distances.len() + body.constraints.len()) * OFTEN as usize;
    (cloth::world(&body, 1, OFTEN), count)
}

/// A simulation of a body with one sweep in each of many substeps.
fn stepped(body: Blueprint) -> (Simulation, usize) {
    let count = (body.distances.len() + body.constraints.len()) * OFTEN as usize;
    (cloth::world(&body, OFTEN, 1), count)
}

/// A simulation of a body without constraints and with many substeps; `each` is called for every particle.
fn substeps(body: Blueprint, each: impl Fn(&mut Simulation, usize)) -> (Simulation, usize) {
    let settings = SolverSettings { substeps: OFTEN, max_sweeps: 1, ..Default::default() };
    let mut world = empty(settings);
    let rows = body.build(&mut world).expect("the recipe is sound");
    let count = rows.len() * OFTEN as usize;
    rows.for_each(|i| each(&mut world, i));
    (world, count)
}

fn thread() -> Blueprint {
    let spec =
        RopeSpec { segments: 4000, bound: Bound::AtMost, pin_start: true, ..Default::default() };
    rope(&RopeSpec { to: Vec3::X * 40.0, ..spec }).expect("the rope is sound")
}

fn soft() -> Blueprint {
    let mut sheet = cloth::sheet(SIDE);
    sheet.distances.iter_mut().for_each(|d| *d = d.with_compliance(1e-5));
    sheet
}

/// The bending constraints of a sheet, without its rods.
fn bends(bending: Bending) -> Blueprint {
    let world = bending::world(SIDE, bending, 1, 1);
    let constraints = world.constraints().to_vec();
    Blueprint { constraints, distances: Vec::new(), ..cloth::sheet(SIDE) }
}

/// A zigzag with angle constraints, held by its first two particles, so that they are violated in each step.
fn angles() -> Blueprint {
    let place = |i: u32| Vec3::new(i as f32, (i % 2) as f32, (i / 2 % 2) as f32) * 0.1;
    let law = |i: u32| {
        let rows = [i, i + 1, i + 2];
        Constraint::new(rows, ConstraintKind::Angle(Angle::rest(rows.map(place))))
    };
    let seed = |i: u32| {
        let seed = ParticleSeed::at(place(i));
        if i < 2 { seed.pinned() } else { seed }
    };
    Blueprint {
        particles: (0..4000).map(seed).collect(),
        constraints: (0..3998).map(law).collect(),
        ..Blueprint::default()
    }
}

/// A lattice of cubes, each split into the six tetrahedra along its diagonal.
fn tetrahedra() -> Blueprint {
    let mut body = lattice(12);
    let at = |i: u32| body.particles[i as usize].position;
    let step = [1, 12, 144];
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut laws = Vec::new();
    for corner in cells(12) {
        for [x, y, _] in orders {
            let (a, b) = (corner + step[x], corner + step[x] + step[y]);
            let rows = [corner, a, b, corner + 157];
            laws.push(Constraint::new(
                rows,
                ConstraintKind::Tetrahedron(Tetrahedron::of(rows.map(at))),
            ));
        }
    }
    body.constraints = laws;
    body
}

/// Cubes side by side with a volume constraint over their twelve triangles, each held by a corner.
fn volumes() -> Blueprint {
    const FACES: [[u32; 3]; 12] = [
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
    ];
    let triangles: Arc<[[u32; 3]]> = FACES.into();
    let mut body = Blueprint::default();
    for cube in 0..500_u32 {
        let first = body.particles.len() as u32;
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let places: Vec<Vec3> = (0..8).map(|i| corner(i) + Vec3::X * (2 * cube) as f32).collect();
        body.particles.extend(places.iter().map(|&p| ParticleSeed::at(p)));
        body.particles[first as usize] = body.particles[first as usize].pinned();
        let law = Volume::of(triangles.clone(), &places);
        body.constraints.push(Constraint::new(first..first + 8, ConstraintKind::Volume(law)));
    }
    body
}

/// Particles on the ground, a metre apart.
fn loose() -> Blueprint {
    let place = |i: u32| Vec3::new((i % SIDE) as f32, 0.0, (i / SIDE) as f32);
    let particles = (0..SIDE * SIDE).map(|i| ParticleSeed::at(place(i))).collect();
    Blueprint { particles, distances: Vec::<Distance>::new(), ..Blueprint::default() }
}

/// A cubic lattice of particles, a decimetre apart.
fn lattice(side: u32) -> Blueprint {
    let place =
        |i: u32| Vec3::new((i % side) as f32, (i / side % side) as f32, (i / side / side) as f32);
    let particles = (0..side * side * side).map(|i| ParticleSeed::at(place(i) * 0.1)).collect();
    Blueprint { particles, ..Blueprint::default() }
}

/// The lowest corners of the cells of a lattice.
fn cells(side: u32) -> impl Iterator<Item = u32> {
    let inside =
        move |i: &u32| [1, side, side * side].iter().all(|step| i / step % side < side - 1);
    (0..side * side * side).filter(inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::TICK;

    #[test]
    fn every_kernel_runs_and_stays_finite() {
        for kernel in KERNELS {
            let Work { mut world, count } = kernel.work();
            assert!(count > 1000, "{kernel}");
            for _ in 0..2 {
                assert!(world.step(TICK).is_ok(), "{kernel}");
            }
            assert!(world.report().frozen.is_empty(), "{kernel}");
        }
    }
}
