//! What is within reach in a step, and what is flung beyond that.

use glam::Vec3;

use crate::particles::Places;
use crate::recipes::{ClothSpec, cloth_grid};
use crate::{Collider, Frame, Plane, Shape, Simulation, Wind};

/// A cloth of 1 m × 1 m, hung by two corners 3 m above the ground there may be, in a wind.
fn hung() -> Simulation {
    let spec = ClothSpec::default();
    let mut cloth = cloth_grid(&spec).unwrap();
    for corner in [spec.index(0, 0), spec.index(spec.columns, 0)] {
        cloth.pin(corner).unwrap();
    }
    let mut world = Simulation::default();
    for mut seed in cloth.particles {
        seed.position.y += 3.0;
        world.particles.push(seed).unwrap();
    }
    world.distances_mut().extend(cloth.distances);
    world.forces.surfaces = cloth.triangles;
    world.forces.winds.push(Wind::steady(Vec3::Z * 3.0));
    world
}

fn ball(at: Vec3) -> Collider {
    Collider::fixed(Shape::sphere(0.2).unwrap(), Frame { translation: at, ..Frame::IDENTITY })
}

/// Which rows of the cloth are asked for contacts, right after a step has begun.
fn asked(world: &mut Simulation) -> Vec<u32> {
    world.begin_step(1.0 / 60.0).unwrap();
    let (contacts, plan) = (world.particle_contacts().clone(), world.plan().clone());
    let number = plan.island_of[0] as usize;
    let rows = &plan.members[plan.islands[number].members.clone()];
    contacts.in_reach(&Places::all(&mut world.particles), number, rows).0.to_vec()
}

#[test]
fn only_rows_that_may_touch_something_are_asked() {
    let mut world = hung();
    world.boundaries.planes.push(Plane::ground(0.0));
    world.colliders.push(ball(Vec3::new(0.0, 30.0, 0.0)));
    assert_eq!(asked(&mut world), [0; 0], "nothing is near");
    // In front of its lower edge, which is at 2.5 m.
    world.colliders.push(ball(Vec3::new(0.0, 2.4, 0.15)));
    let near = asked(&mut world);
    assert!(!near.is_empty() && near.len() < 100, "{}", near.len());
    assert!(near.iter().all(|&row| row >= 10 * 21), "{near:?}");
    // A ground right below it is for its lowest row, too.
    world.boundaries.planes.push(Plane::ground(2.495));
    let low = asked(&mut world);
    assert!(low.len() < 100 && (20 * 21..21 * 21).all(|row| low.contains(&row)), "{low:?}");
    world.boundaries.planes.pop();
    world.boundaries.plane_constraint = Plane::new(Vec3::ZERO, Vec3::Z);
    assert_eq!(asked(&mut world).len(), 21 * 21, "a world in 2D");
}

#[test]
fn what_is_out_of_reach_changes_no_bit() {
    let run = |mut world: Simulation| -> Vec<Vec3> {
        (0..60).for_each(|_| {
            world.step(1.0 / 60.0).unwrap();
        });
        (0..world.particles.len()).map(|i| world.particles.position(i)).collect()
    };
    let alone = run(hung());
    let mut world = hung();
    world.boundaries.planes.push(Plane::ground(0.0));
    world.boundaries.boxes.push(crate::InsideBox::new(Vec3::splat(-9.0), Vec3::splat(9.0)));
    world.colliders.push(ball(Vec3::new(0.0, -5.0, 0.0)));
    assert_eq!(run(world), alone);
}

#[test]
fn what_is_flung_out_of_reach_meets_what_is_there() {
    for plate in [false, true] {
        let mut world = hung();
        if plate {
            let thin = Shape::cuboid(Vec3::new(4.0, 0.01, 4.0)).unwrap();
            world.colliders.push(Collider::fixed(thin, Frame::IDENTITY));
        } else {
            world.boundaries.planes.push(Plane::ground(0.0));
        }
        // Loose, so that nothing holds it back.
        let last = world.particles.len() - 1;
        world.distances_mut().retain(|d| d.a as usize != last && d.b as usize != last);
        let substeps = world.begin_step(1.0 / 60.0).unwrap();
        for substep in 0..substeps {
            world.begin_substep();
            world.accumulate_forces();
            if substep == 3 {
                world.particles.set_velocity(last, Vec3::Y * -3000.0);
            }
            world.integrate();
            world.solve_constraints();
        }
        world.end_step();
        assert!(world.particles.position(last).y > 0.0, "{}", world.particles.position(last));
    }
}
