//! Sensors report what they overlap, whatever its kind and its speed.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{SolidShape, SolidSpec, solid};
use sinew::{
    BodyContacts, Collider, ContactParticipant, Frame, Material, ParticleSeed, Shape, Simulation,
};

const DT: f32 = 1.0 / 60.0;

/// The surface of a box, closed, as a mesh.
fn mesh_box(size: Vec3) -> Shape {
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        Vec3::new(sign(0), sign(1), sign(2)) * size
    };
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Shape::mesh(corners, triangles.as_flattened().to_vec()).unwrap()
}

fn sheet(size: f32) -> Shape {
    let half = 0.5 * size;
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let corners = corners.map(|(y, z)| Vec3::new(0.0, y, z));
    Shape::mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()
}

fn sensor(shape: Shape, frame: Frame) -> Collider {
    Collider { sensor: true, events: true, ..Collider::fixed(shape, frame) }
}

/// Shapes of a size of some 0.2 m; `None` is a single particle.
fn shapes() -> [Option<Shape>; 5] {
    let tip = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].map(|v| v * 0.1);
    [
        None,
        Some(Shape::sphere(0.1).unwrap()),
        Some(Shape::cuboid(Vec3::splat(0.2)).unwrap()),
        Some(Shape::capsule(0.1, 0.2).unwrap()),
        Some(Shape::hull(&tip).unwrap()),
    ]
}

fn throw(
    world: &mut Simulation,
    shape: Option<&Shape>,
    at: Vec3,
    velocity: Vec3,
    material: Material,
) -> core::ops::Range<usize> {
    let contacts = BodyContacts { material, ..Default::default() };
    let rows = if let Some(shape) = shape {
        let spec = SolidSpec { shape: SolidShape::Collider(shape.clone()), ..Default::default() };
        let body = solid(&spec).unwrap().transformed(Quat::IDENTITY, at);
        body.build_colliding(world, contacts).unwrap()
    } else {
        let row = world.particles.push(ParticleSeed::at(at).with_radius(0.1)).unwrap() as usize;
        world.particles.set_body(row, Some(world.contacts.len() as u32));
        world.bodies.push(Default::default());
        world.contacts.push(contacts);
        row..row + 1
    };
    rows.clone().for_each(|row| world.particles.set_velocity(row, velocity));
    rows
}

/// Number of steps in which the sensor was reported.
fn reported(world: &mut Simulation, steps: u32) -> u32 {
    let mut count = 0;
    for _ in 0..steps {
        let impacts = &world.step(DT).unwrap().impacts;
        for impact in impacts.iter().filter(|impact| impact.sensor) {
            let two = (impact.first, impact.second);
            assert_eq!(two, (ContactParticipant::Body(0), ContactParticipant::Collider(0)));
            assert!(impact.normal.is_normalized() && impact.impulse == 0.0, "{impact:?}");
            count += 1;
        }
    }
    count
}

fn weightless() -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    world
}

/// The narrow phase finds overlaps with the triangles of a mesh, and what was wholly inside touched none.
#[test]
fn a_closed_mesh_reports_what_is_wholly_inside() {
    let turned = Quat::from_rotation_y(0.7);
    for shape in shapes() {
        for (size, at) in [
            (4.0, Vec3::ZERO),
            (4.0, Vec3::new(1.3, -1.2, 0.4)),
            (0.5, Vec3::splat(0.02)),
            (0.2, Vec3::ZERO),
            (40.0, Vec3::new(15.0, 3.0, 0.0)),
        ] {
            let place = Vec3::new(20.0, 5.0, -3.0);
            let mut world = weightless();
            world.colliders.push(sensor(mesh_box(Vec3::splat(size)), Frame::new(place, turned)));
            throw(&mut world, shape.as_ref(), place + turned * at, Vec3::ZERO, Material::default());
            assert_eq!(reported(&mut world, 10), 10, "{shape:?} at {at} in {size} m");
        }
        for at in [Vec3::X * 2.2, Vec3::new(-2.0, 2.3, 0.0), Vec3::splat(2.2)] {
            let mut world = weightless();
            world.colliders.push(sensor(mesh_box(Vec3::splat(4.0)), Frame::IDENTITY));
            throw(&mut world, shape.as_ref(), at, Vec3::ZERO, Material::default());
            assert_eq!(reported(&mut world, 10), 0, "{shape:?} at {at} is outside");
        }
    }
}

/// A body was compared with sensors where it was when a step began: at 60 m/s it is a metre further in the next one, and a thin sensor was in between.
#[test]
fn a_sensor_reports_what_passes_through_it_within_a_step() {
    let sensors = [
        Shape::cuboid(Vec3::new(0.02, 4.0, 4.0)).unwrap(),
        mesh_box(Vec3::new(0.02, 4.0, 4.0)),
        sheet(4.0),
        Shape::sphere(0.05).unwrap(),
    ];
    for (shape, sensing) in
        shapes().iter().flat_map(|shape| sensors.iter().map(move |sensing| (shape, sensing)))
    {
        for (speed, phase) in
            [3.0, 60.0, 400.0].into_iter().flat_map(|v| [0, 3, 5, 8].map(|phase| (v, phase)))
        {
            let before = speed * DT * (2.0 + phase as f32 * 0.1) + 0.2;
            for (moves, turned) in [(false, 0.0), (false, 0.5), (true, 0.0), (true, 0.5)] {
                let mut world = weightless();
                let rotation = Quat::from_rotation_y(turned);
                let (start, velocity) = if moves {
                    (Vec3::X * before, Vec3::ZERO)
                } else {
                    (Vec3::ZERO, Vec3::X * speed)
                };
                world.colliders.push(sensor(sensing.clone(), Frame::new(start, rotation)));
                let at = if moves { Vec3::ZERO } else { Vec3::X * -before };
                throw(&mut world, shape.as_ref(), at, velocity, Material::default());
                let mut count = 0;
                for step in 1..=((0.5 / (speed * DT)) as u32 + 6) {
                    if moves {
                        let to = start + Vec3::NEG_X * (speed * DT * step as f32);
                        let collider = &mut world.colliders[0];
                        (collider.start, collider.end) = (collider.end, Frame::new(to, rotation));
                    }
                    count += reported(&mut world, 1);
                }
                assert!(
                    count > 0,
                    "{shape:?} at {speed} m/s, {phase}, through {sensing:?}, moving {moves}, {turned}"
                );
            }
        }
    }
}

/// The path counts that a body took, and not the one that it would have taken.
#[test]
fn a_sensor_behind_a_wall_reports_nothing() {
    for shape in shapes() {
        for phase in 0..5 {
            let mut world = weightless();
            let thin = Shape::cuboid(Vec3::new(0.02, 4.0, 4.0)).unwrap();
            world.colliders.push(sensor(thin.clone(), Frame::at(Vec3::X * 0.3)));
            world.colliders.push(Collider::fixed(thin, Frame::IDENTITY));
            let at = Vec3::X * (-2.2 - 0.2 * phase as f32);
            throw(&mut world, shape.as_ref(), at, Vec3::X * 60.0, Material::default());
            assert_eq!(reported(&mut world, 12), 0, "{shape:?}, {phase}");
        }
    }
}
