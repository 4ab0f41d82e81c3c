//! Hulls and fluids compared with analytic results (physics.md F6): drafts, heave periods and stability.

mod still;

use core::f32::consts::PI;

use glam::{DQuat, DVec3, Vec3};

use super::*;
use crate::constraints::Distance;
use crate::particles::ParticleSeed;
use crate::simulation::Simulation;

const G: f64 = 9.81;

/// Counter-clockwise seen from outside; corner `i` is on the positive side of x, y, z where bit 0, 1, 2 is set. The last two triangles are the top.
const BOX: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
];

fn corners(size: Vec3) -> [Vec3; 8] {
    let side = |i: usize, bit: usize| (i >> bit & 1) as f32 - 0.5;
    core::array::from_fn(|i| Vec3::new(side(i, 0), side(i, 1), side(i, 2)) * size)
}

fn turned(angle: f32, axis: Vec3) -> DQuat {
    let (sin, cos) = libm::sincos(f64::from(angle) * 0.5);
    let v = axis.normalize().as_dvec3() * sin;
    DQuat::from_xyzw(v.x, v.y, v.z, cos)
}

/// A box of eight particles: at its corners, with the particles as the skin's corners, or equimomental, with the skin following their pose.
#[derive(Clone, Copy)]
struct Floating {
    size: Vec3,
    mass: f32,
    posed: bool,
    at: Vec3,
    rotation: DQuat,
    triangles: &'static [[u32; 3]],
}

impl Floating {
    fn new(size: Vec3, mass: f32, posed: bool) -> Self {
        Self { size, mass, posed, at: Vec3::ZERO, rotation: DQuat::IDENTITY, triangles: &BOX }
    }

    fn at(self, at: Vec3) -> Self {
        Self { at, ..self }
    }

    fn turned(self, rotation: DQuat) -> Self {
        Self { rotation, ..self }
    }

    /// A world with this box, all its pairs connected, and water up to y = 0.
    fn world(&self, drag: f32) -> Simulation {
        let mut world = Simulation::default();
        world.settings.substeps = 8;
        world.forces.fluids.push(Fluid { drag, ..Fluid::water(0.0) });
        let rest = corners(self.size).map(|r| if self.posed { r / 3.0_f32.sqrt() } else { r });
        for r in rest {
            let at = self.at + (self.rotation * r.as_dvec3()).as_vec3();
            world.particles.push(ParticleSeed::at(at).with_mass(self.mass / 8.0)).unwrap();
        }
        for a in 0..8 {
            for b in a + 1..8 {
                let length = (rest[a] - rest[b]).length();
                world.distances_mut().push(Distance::new(a as u32, b as u32, length));
            }
        }
        let skin = if self.posed {
            Skin::Posed { vertices: corners(self.size).to_vec(), rest: rest.to_vec() }
        } else {
            Skin::Carriers
        };
        let hull = Hull::new((0..8).collect(), self.triangles.to_vec(), skin).unwrap();
        world.forces.hulls.push(hull);
        world
    }
}

/// Total force (N) and moment about the origin (N·m) of the fluids.
fn load(world: &mut Simulation) -> (DVec3, DVec3) {
    world.begin_substep();
    world.apply_buoyancy();
    let mut sum = (DVec3::ZERO, DVec3::ZERO);
    for i in 0..world.particles.len() {
        let f = world.particles.acceleration(i).as_dvec3() * f64::from(world.particles.mass(i));
        sum.0 += f;
        sum.1 += world.particles.position(i).as_dvec3().cross(f);
    }
    sum
}

fn centre(world: &Simulation) -> Vec3 {
    let n = world.particles.len();
    (0..n).map(|i| world.particles.position(i)).sum::<Vec3>() / n as f32
}

/// The y axis of the box.
fn mast(world: &Simulation) -> Vec3 {
    world.particles.separation(2, 0).normalize()
}

fn run(world: &mut Simulation, seconds: f32) {
    for _ in 0..(seconds * 60.0) as usize {
        world.step(1.0 / 60.0).unwrap();
    }
}

#[test]
fn a_floating_box_is_under_by_the_ratio_of_the_densities() {
    for posed in [false, true] {
        for ratio in [0.25, 0.5, 0.75] {
            let mut world =
                Floating::new(Vec3::new(3.0, 1.0, 3.0), 9000.0 * ratio, posed).world(0.95);
            run(&mut world, 25.0);
            let draft = 0.5 - centre(&world).y;
            println!("posed {posed}, {ratio}: draft {draft}");
            assert!((draft / ratio - 1.0).abs() < 0.01, "{posed} {ratio}: {draft}");
        }
    }
}

#[test]
fn a_box_heaves_in_the_time_of_a_pendulum_as_long_as_its_draft() {
    for posed in [false, true] {
        let draft = 0.5;
        let mut world =
            Floating::new(Vec3::new(3.0, 1.0, 3.0), 4500.0, posed).at(Vec3::Y * 0.1).world(0.0);
        let (mut crossings, mut last) = (Vec::new(), f64::NAN);
        for _ in 0..600 {
            let before = world.time;
            world.step(1.0 / 60.0).unwrap();
            let now = f64::from(centre(&world).y);
            if last < 0.0 && now >= 0.0 {
                crossings.push(before + (world.time - before) * last / (last - now));
            }
            last = now;
        }
        let count = crossings.len() - 1;
        let period = (crossings[count] - crossings[0]) / count as f64;
        let exact = 2.0 * core::f64::consts::PI * (draft / G).sqrt();
        println!("posed {posed}: period {period} s, exactly {exact} s");
        assert!((period / exact - 1.0).abs() < 0.02, "{posed}: {period} {exact}");
    }
}

#[test]
fn a_wide_box_rights_itself_and_a_tall_one_capsizes() {
    for posed in [false, true] {
        let rotation = turned(0.4, Vec3::new(1.0, 0.0, 0.3));
        let mut wide =
            Floating::new(Vec3::new(3.0, 1.0, 3.0), 4500.0, posed).turned(rotation).world(0.9);
        run(&mut wide, 10.0);
        assert!(mast(&wide).y > 0.9999, "{posed}: {}", mast(&wide));

        let rotation = turned(0.02, Vec3::new(1.0, 0.0, 0.3));
        let mut tall =
            Floating::new(Vec3::new(1.0, 3.0, 1.0), 1500.0, posed).turned(rotation).world(0.9);
        run(&mut tall, 20.0);
        assert!(mast(&tall).y.abs() < 0.2, "{posed}: {}", mast(&tall));
    }
}

#[test]
fn a_boat_floats_on_its_outside_and_sinks_when_it_weighs_more_than_it_can_push_aside() {
    // Steel of 900 kg as a tub of 2 m × 1 m × 2 m without a lid: its draft is 0.225 m. It can displace 4000 kg.
    let boat = |mass, posed| Floating {
        triangles: &BOX[..10],
        ..Floating::new(Vec3::new(2.0, 1.0, 2.0), mass, posed)
    };
    for posed in [false, true] {
        let mut light = boat(900.0, posed).world(0.95);
        assert!(light.forces.hulls[0].is_open());
        run(&mut light, 25.0);
        let draft = 0.5 - centre(&light).y;
        assert!((draft / 0.225 - 1.0).abs() < 0.01, "{posed}: {draft}");

        let mut full = boat(3900.0, posed).world(0.95);
        run(&mut full, 12.0);
        assert!((0.5 - centre(&full).y) < 1.0, "{posed}");

        let mut overloaded = boat(4100.0, posed).world(0.95);
        run(&mut overloaded, 30.0);
        assert!(centre(&overloaded).y < -3.0, "{posed}: {}", centre(&overloaded));
    }
}

#[test]
fn a_current_carries_what_floats_in_it_along() {
    let current = Vec3::new(1.5, 0.0, -0.5);
    for posed in [false, true] {
        let mut world = Floating::new(Vec3::new(3.0, 1.0, 3.0), 4500.0, posed).world(0.0);
        world.forces.fluids[0] = Fluid { drag: 0.9, current, ..Fluid::water(0.0) };
        let ball = ParticleSeed::at(Vec3::new(20.0, 0.0, 0.0)).with_radius(0.5).with_mass(260.0);
        world.particles.push(ball).unwrap();
        run(&mut world, 20.0);
        for i in [0, 7, 8] {
            let v = world.particles.velocity(i);
            assert!((v - current).length() < 0.01, "{posed} {i}: {v}");
        }
    }
}

#[test]
fn a_drag_of_one_takes_everything_along_at_once_and_stays_a_number() {
    let mut world = Simulation::default();
    let current = Vec3::X * 3.0;
    world.forces.fluids.push(Fluid { drag: 1.0, current, ..Fluid::water(0.0) });
    let ball = ParticleSeed::at(Vec3::Y * -5.0).with_radius(0.5).with_mass(4000.0 / 3.0 * PI / 8.0);
    world.particles.push(ball).unwrap();
    world.step(1.0 / 60.0).unwrap();
    world.step(1.0 / 60.0).unwrap();
    let v = world.particles.velocity(0);
    assert!((v - current).length() < 1e-3, "{v}");
}

#[test]
fn a_pool_carries_nothing_beside_itself() {
    for posed in [false, true] {
        let floats = |at: Vec3| {
            let mut world =
                Floating::new(Vec3::new(3.0, 1.0, 3.0), 4500.0, posed).at(at).world(0.5);
            let pool = Region::boxed(Vec3::new(0.0, -2.5, 0.0), Vec3::new(10.0, 5.0, 10.0));
            world.forces.fluids[0] = Fluid::water(0.0).within(pool);
            world.particles.push(ParticleSeed::at(at).with_radius(0.5)).unwrap();
            load(&mut world).0.y
        };
        // Half submerged; the top of the pool's box is the surface, so the centre of the submerged part is inside.
        let exact = 9.81 * (4500.0 + 1000.0 * 2.0 / 3.0 * core::f64::consts::PI * 0.125);
        assert!((floats(Vec3::ZERO) / exact - 1.0).abs() < 1e-5);
        assert_eq!(floats(Vec3::X * 20.0), 0.0);
    }
}
