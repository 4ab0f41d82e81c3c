//! What is between the particles of a surface meets shapes, too: posts, corners and edges, and small bodies, which are smaller than the cells of a sheet.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{
    Blueprint, BoxSpec, ClothMaterial, ClothSpec, box_3d, cloth_grid, convex_hull,
};
use sinew::{BodyContacts, Collider, Frame, InstructionSet, Plane, Shape, Simulation};

const DT: f32 = 1.0 / 60.0;

/// Thickness of a sheet.
const RADIUS: f32 = 0.01;

/// A level sheet of 1 m with this many cells along a side, at a height, pinned at its corners or not.
fn sheet(world: &mut Simulation, cells: u32, height: f32, pinned: bool) -> Vec<[u32; 3]> {
    let material = ClothMaterial { bend_compliance: None, radius: RADIUS, ..Default::default() };
    let spec = ClothSpec { columns: cells, rows: cells, material, ..ClothSpec::default() };
    let mut cloth = cloth_grid(&spec).unwrap();
    if pinned {
        spec.corners().iter().for_each(|&corner| cloth.pin(corner).unwrap());
    }
    let level = Quat::from_xyzw(1.0, 0.0, 0.0, -1.0).normalize();
    let first = add(world, &cloth, level, Vec3::Y * height, true);
    let triangles: Vec<[u32; 3]> =
        cloth.triangles.iter().map(|corners| corners.map(|i| i + first)).collect();
    world.forces.surfaces.extend(triangles.iter().copied());
    triangles
}

/// A sheet of 4 × 4 cells whose pinned corners are closer than it is wide, so that it sags by some 20 cm, at rest.
fn slack(world: &mut Simulation) -> Vec<[u32; 3]> {
    let triangles = sheet(world, 4, 0.0, true);
    for i in 0..world.particles.len() {
        let at = world.particles.position(i);
        let sag = 0.3 * (0.25 - at.x * at.x).max(0.25 - at.z * at.z).sqrt();
        world.particles.set_position(i, at * Vec3::new(0.85, 1.0, 0.85) - Vec3::Y * sag);
    }
    for _ in 0..90 {
        world.step(DT).unwrap();
    }
    triangles
}

/// Adds a body; returns its first row.
fn add(world: &mut Simulation, body: &Blueprint, turn: Quat, at: Vec3, surface: bool) -> u32 {
    let contacts = BodyContacts { with_bodies: true, surface, ..BodyContacts::default() };
    let rows = body.transformed(turn, at).build_colliding(world, contacts).unwrap();
    rows.start as u32
}

/// Points of all triangles, spread over them, metres in the world.
fn points<'a>(
    world: &'a Simulation,
    triangles: &'a [[u32; 3]],
) -> impl Iterator<Item = Vec3> + use<'a> {
    const PARTS: u32 = 12;
    let weights = (0..=PARTS).flat_map(|i| (0..=PARTS - i).map(move |j| [i, j, PARTS - i - j]));
    triangles.iter().flat_map(move |corners| {
        let at = corners.map(|row| world.particles.position(row as usize));
        weights.clone().map(move |[a, b, c]| {
            (at[0] * a as f32 + at[1] * b as f32 + at[2] * c as f32) / PARTS as f32
        })
    })
}

/// How deep the sheet is in a shape, metres; negative if it is away from it.
fn depth(world: &Simulation, triangles: &[[u32; 3]], shape: &Shape, frame: &Frame) -> f32 {
    let depths = points(world, triangles).map(|at| -shape.nearest(frame.local(at)).distance);
    depths.fold(f32::NEG_INFINITY, f32::max)
}

/// How many edges of the sheet go through a shape.
fn edges_through(
    world: &Simulation,
    triangles: &[[u32; 3]],
    shape: &Shape,
    frame: &Frame,
) -> usize {
    let at = |row: u32| frame.local(world.particles.position(row as usize));
    let is_through = |[a, b]: &[u32; 2]| {
        let (start, way) = (at(*a), at(*b) - at(*a));
        shape.cast_ray(start, way.normalize(), way.length()).is_some()
    };
    let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.filter(is_through).count()
}

/// A pyramid with its tip up.
fn pyramid() -> [Vec3; 5] {
    let base = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let [a, b, c, d] = base.map(|(x, z)| Vec3::new(0.05 * x, -0.25, 0.05 * z));
    [a, b, c, d, Vec3::Y * 0.05]
}

/// Shapes that fit in between the particles of a coarse sheet, with the height of their tops.
fn thin_shapes() -> Vec<(&'static str, Shape, Quat, f32)> {
    let edge_up = Quat::from_xyzw(0.382_683_43, 0.0, 0.0, 0.923_879_5);
    vec![
        ("capsule", Shape::capsule(0.03, 0.4).unwrap(), Quat::IDENTITY, 0.23),
        ("ball", Shape::sphere(0.04).unwrap(), Quat::IDENTITY, 0.04),
        ("cylinder", Shape::cylinder(0.03, 0.4).unwrap(), Quat::IDENTITY, 0.2),
        ("post", Shape::cuboid(Vec3::new(0.05, 0.4, 0.05)).unwrap(), Quat::IDENTITY, 0.2),
        ("edge", Shape::cuboid(Vec3::new(0.15, 0.2, 0.2)).unwrap(), edge_up, 0.141_421),
        ("hull", Shape::hull(&pyramid()).unwrap(), Quat::IDENTITY, 0.05),
    ]
}

/// Corners of a box of a size.
fn box_corners(size: Vec3, at: Vec3) -> Vec<Vec3> {
    let sign = |bit: u32, i: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
    (0..8).map(|i| at + size * Vec3::new(sign(0, i), sign(1, i), sign(2, i))).collect()
}

/// The surfaces of convex parts with these corners as one mesh.
fn mesh(parts: &[Vec<Vec3>]) -> Shape {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for part in parts {
        let first = vertices.len() as u32;
        vertices.extend(part);
        triangles.extend(convex_hull(part).unwrap().iter().map(|face| face.map(|i| i + first)));
    }
    Shape::mesh(vertices, triangles).unwrap()
}

/// Meshes and heightfields that are thin, and not all convex, with the height of their tops.
fn thin_meshes() -> Vec<(&'static str, Shape, Quat, f32)> {
    let edge_up = Quat::from_xyzw(0.382_683_43, 0.0, 0.0, 0.923_879_5);
    let post = Vec3::new(0.05, 0.4, 0.05);
    let round = |radius: f32, height: f32| {
        let at = move |i: u32| {
            let angle = core::f64::consts::TAU * f64::from(i) / 16.0;
            Vec3::new(libm::cos(angle) as f32 * radius, height, libm::sin(angle) as f32 * radius)
        };
        (0..16).map(at)
    };
    let pole: Vec<Vec3> = round(0.03, -0.2).chain(round(0.03, 0.2)).collect();
    // A sheet, which has no inside.
    let fence = [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)];
    let fence: Vec<Vec3> = fence.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect();
    let ridged: Vec<f32> = (0..9 * 9).map(|i| if i % 9 == 4 { 0.15 } else { -0.1 }).collect();
    vec![
        ("post", mesh(&[box_corners(post, Vec3::ZERO)]), Quat::IDENTITY, 0.2),
        (
            "fork",
            mesh(&[-0.05, 0.07].map(|x| box_corners(post * Vec3::new(0.5, 1.0, 0.5), Vec3::X * x))),
            Quat::IDENTITY,
            0.2,
        ),
        ("edge", mesh(&[box_corners(Vec3::new(0.15, 0.2, 0.2), Vec3::ZERO)]), edge_up, 0.141_421),
        ("pyramid", mesh(&[pyramid().to_vec()]), Quat::IDENTITY, 0.05),
        ("pole", mesh(&[pole]), Quat::IDENTITY, 0.2),
        ("fence", Shape::mesh(fence, vec![[0, 1, 2], [0, 2, 3]]).unwrap(), Quat::IDENTITY, 0.2),
        (
            "heights",
            Shape::height_field(9, 9, &ridged, Vec3::new(0.4, 1.0, 0.4)).unwrap(),
            Quat::IDENTITY,
            0.15,
        ),
    ]
}

/// Regression: all of these went through between the particles of a sheet, those that are meshes and heightfields for longer than the others.
#[test]
fn nothing_thin_is_pushed_through_a_coarse_sheet() {
    for (name, shape, turn, top) in thin_shapes().into_iter().chain(thin_meshes()) {
        for (x, z) in [(0.1, 0.16), (0.125, 0.125), (0.125, 0.0), (0.02, 0.2)] {
            let mut world = Simulation::default();
            let triangles = slack(&mut world);
            let mut at = Vec3::new(x, -top - 0.4, z);
            world.colliders.push(Collider::fixed(shape.clone(), Frame::new(at, turn)));
            let mut deepest = f32::NEG_INFINITY;
            for tick in 0..120 {
                let start = Frame::new(at, turn);
                at.y += if tick < 30 { 0.01 } else { 0.0 };
                let end = Frame::new(at, turn);
                (world.colliders[0].start, world.colliders[0].end) = (start, end);
                world.step(DT).unwrap();
                deepest = deepest.max(depth(&world, &triangles, &shape, &end));
            }
            // What sweeps leave; of a thread along a blade they hold one point at a time.
            let most = if name == "edge" { 0.5 * RADIUS } else { 0.2 * RADIUS };
            assert!(deepest < most, "{name} at {x} {z}: {deepest} m deep");
            assert!(deepest > -2.0 * RADIUS, "{name} at {x} {z}: they touch");
            let through = edges_through(&world, &triangles, &shape, &Frame::new(at, turn));
            assert!(through == 0, "{name} at {x} {z}: {through} edges go through");
        }
    }
}

/// Things to drape a sheet over: a box; the same as a mesh; and one that is not convex, a bin whose walls are 3 cm wide.
fn to_drape_over() -> Vec<(&'static str, Shape)> {
    let size = Vec3::new(0.4, 0.5, 0.4);
    let wall = |x: f32, z: f32| {
        let thin =
            Vec3::new(if x == 0.0 { 0.4 } else { 0.03 }, 0.5, if z == 0.0 { 0.4 } else { 0.03 });
        box_corners(thin, Vec3::new(x, 0.0, z) * 0.185)
    };
    vec![
        ("box", Shape::cuboid(size).unwrap()),
        ("mesh", mesh(&[box_corners(size, Vec3::ZERO)])),
        ("bin", mesh(&[wall(1.0, 0.0), wall(-1.0, 0.0), wall(0.0, 1.0), wall(0.0, -1.0)])),
    ]
}

/// Regression: a sheet that was draped over a box was cut by its edges and corners.
#[test]
fn a_coarse_sheet_is_draped_over_edges_and_corners() {
    for (name, shape) in to_drape_over() {
        for turn in [Quat::IDENTITY, Quat::from_rotation_y(0.6)] {
            let mut world = Simulation::default();
            let triangles = sheet(&mut world, 7, 0.3, false);
            let frame = Frame::new(Vec3::new(0.03, 0.0, 0.05), turn);
            world.colliders.push(Collider::fixed(shape.clone(), frame));
            let mut fastest = 0.0_f32;
            for tick in 0..240 {
                let before: Vec<Vec3> = points(&world, &triangles).collect();
                world.step(DT).unwrap();
                let deep = depth(&world, &triangles, &shape, &frame);
                let moved = before.iter().zip(points(&world, &triangles));
                let moved = moved.map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
                fastest = fastest.max(if tick < 180 { 0.0 } else { moved / DT });
                // Sweeps leave something while it lands.
                let most = if tick < 60 { 0.2 * RADIUS } else { 0.0 };
                assert!(deep < most, "{name}: {deep} m deep in tick {tick}");
            }
            let lowest = points(&world, &triangles).map(|at| at.y).fold(f32::MAX, f32::min);
            assert!(fastest < 0.5, "{name}: it swings at {fastest} m/s");
            assert!(lowest < 0.1, "{name}: it hangs down");
        }
    }
}

/// A fence that is 7 m high and 5 cm wide, as a box, and without any width as a mesh.
fn fences() -> [(&'static str, Shape); 2] {
    let size = Vec3::new(8.0, 7.0, 0.05);
    let corners = box_corners(size.with_z(0.0), Vec3::ZERO)[..4].to_vec();
    let mesh = Shape::mesh(corners, vec![[0, 1, 3], [0, 3, 2]]).unwrap();
    [("box", Shape::cuboid(size).unwrap()), ("mesh", mesh)]
}

/// Regression: threads got into the fence by the impact, left it through a side, which was nearer than its top, and stayed cut.
#[test]
fn a_sheet_that_falls_onto_a_fence_is_not_cut() {
    for (name, shape) in fences() {
        for (cells, radius) in [(20, 0.005), (20, 0.01), (30, 0.01)] {
            let mut world = Simulation::default();
            let spec = ClothSpec {
                width: 10.0,
                height: 10.0,
                columns: cells,
                rows: cells,
                material: ClothMaterial { radius, ..ClothMaterial::default() },
                ..ClothSpec::default()
            };
            let cloth = cloth_grid(&spec).unwrap();
            let level = Quat::from_xyzw(1.0, 0.0, 0.0, -1.0).normalize();
            let first = add(&mut world, &cloth, level, Vec3::new(0.3, 6.0, 0.2), true);
            let triangles: Vec<[u32; 3]> =
                cloth.triangles.iter().map(|corners| corners.map(|i| i + first)).collect();
            world.forces.surfaces.extend(triangles.iter().copied());
            world.colliders.push(Collider::fixed(shape.clone(), Frame::IDENTITY));
            for _ in 0..150 {
                world.step(DT).unwrap();
            }
            let through = edges_through(&world, &triangles, &shape, &Frame::IDENTITY);
            let lowest = points(&world, &triangles).map(|at| at.y).fold(f32::MAX, f32::min);
            let sheet = format!("{cells} cells, {radius} m thick");
            assert!(through == 0, "{name}, {sheet}: {through} edges go through");
            assert!(lowest > -2.0 && lowest < 0.0, "{name}, {sheet}: down to {lowest} m");
        }
    }
}

/// Regression: what is pinned in a solid is attached to it, however deep, and edges of a mesh that its threads come out past do not push them.
#[test]
fn a_sheet_that_is_pinned_in_posts_is_not_torn_by_their_edges() {
    let hang = |post: Option<(f32, bool)>| {
        let mut world = Simulation::default();
        let triangles = sheet(&mut world, 4, 1.0, true);
        let length = |world: &Simulation, [a, b]: [u32; 2]| {
            world.particles.position(a as usize).distance(world.particles.position(b as usize))
        };
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let sides: Vec<_> = sides.map(|side| (side, length(&world, side))).collect();
        for (x, z) in [(0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)] {
            let Some((width, is_mesh)) = post else { continue };
            let (size, at) = (Vec3::new(width, 1.0, width), Vec3::new(x, 0.6, z));
            world.colliders.push(if is_mesh {
                Collider::fixed(mesh(&[box_corners(size, at)]), Frame::IDENTITY)
            } else {
                Collider::fixed(Shape::cuboid(size).unwrap(), Frame::at(at))
            });
        }
        for _ in 0..120 {
            world.step(DT).unwrap();
        }
        let strains = sides.iter().map(|&(side, rest)| length(&world, side) / rest - 1.0);
        strains.fold(0.0, f32::max)
    };
    let free = hang(None);
    for width in [0.1, 0.2, 0.24, 0.3, 0.4] {
        // Wider ones hold more than the pins.
        let of_box = hang(Some((width, false)));
        let expected = if width < 0.25 { free } else { of_box };
        let held = hang(Some((width, true)));
        assert!(held < expected + 0.01, "{width} m: stretched by {held} instead of {expected}");
    }
}

/// Regression: a small body fell through a sheet between its particles.
#[test]
fn a_small_body_is_caught_by_a_coarse_sheet() {
    for speed in [0.0, 5.0, 10.0, 15.0] {
        for (size, mass) in [(0.06, 0.02), (0.06, 0.2), (0.1, 1.0)] {
            let mut world = Simulation::default();
            let triangles = slack(&mut world);
            let spec = BoxSpec { size: Vec3::splat(size), mass, ..BoxSpec::default() };
            let turn = Quat::from_xyzw(0.3, 0.1, 0.2, 0.9).normalize();
            let body = box_3d(&spec).unwrap();
            let first = add(&mut world, &body, turn, Vec3::new(0.11, 0.3, 0.14), false) as usize;
            (first..first + 8).for_each(|i| world.particles.set_velocity(i, Vec3::Y * -speed));
            let mut deepest = f32::NEG_INFINITY;
            for tick in 0..240 {
                world.step(DT).unwrap();
                let corners = (first..first + 8).map(|i| world.particles.position(i));
                let at = corners.sum::<Vec3>() / 8.0;
                let flat = |p: &Vec3| (*p - at).with_y(0.0).length();
                let below =
                    points(&world, &triangles).min_by(|a, b| flat(a).total_cmp(&flat(b))).unwrap();
                deepest = deepest.max(below.y - at.y);
                if at.x.abs().max(at.z.abs()) > 0.42 {
                    // It slides off.
                    break;
                }
                assert!(
                    at.y > below.y,
                    "{size} m, {mass} kg at {speed} m/s: below the sheet at {at} in tick {tick}"
                );
            }
        }
    }
}

/// Regression: what rounding left of the load of a crate at rest, times the ratio of its mass and that of a particle, counted as a push that takes the
/// neighbours of a particle along; and so did what the sheet weighs. At four substeps it was flung about at 2 m/s.
#[test]
fn a_sheet_on_crates_lies_still() {
    for (mass, substeps) in [(0.5, 4), (50.0, 4), (50.0, 10)] {
        let mut world = Simulation::default();
        world.settings.substeps = substeps;
        world.boundaries.planes.push(Plane::ground(0.0));
        sheet(&mut world, 30, 0.5, false);
        let count = world.particles.len();
        let spec = BoxSpec { size: Vec3::splat(0.2), mass, ..BoxSpec::default() };
        for (x, z) in [(-0.17, -0.17), (0.18, -0.17), (-0.17, 0.18), (0.18, 0.18)] {
            let at = Vec3::new(x, 0.1, z);
            add(&mut world, &box_3d(&spec).unwrap(), Quat::IDENTITY, at, false);
        }
        let places = |world: &Simulation| -> Vec<Vec3> {
            (0..count).map(|i| world.particles.position(i)).collect()
        };
        let mut fastest = 0.0_f32;
        for tick in 0..360 {
            let before = places(&world);
            world.step(DT).unwrap();
            let moved = before.iter().zip(places(&world)).map(|(a, b)| a.distance_squared(b));
            let speed = (moved.sum::<f32>() / count as f32).sqrt() / DT;
            fastest = fastest.max(if tick < 240 { 0.0 } else { speed });
        }
        assert!(fastest < 0.15, "{mass} kg, {substeps} substeps: {fastest} m/s, root mean square");
    }
}

/// A sheet that is held by two posts from below, one of which is a mesh, with a small crate on it.
fn held_up() -> Simulation {
    let mut world = Simulation::default();
    slack(&mut world);
    let post = Shape::cuboid(Vec3::new(0.05, 0.4, 0.05)).unwrap();
    world.colliders.push(Collider::fixed(post, Frame::at(Vec3::new(-0.2, -0.35, 0.1))));
    let post = mesh(&[box_corners(Vec3::new(0.05, 0.4, 0.05), Vec3::ZERO)]);
    world.colliders.push(Collider::fixed(post, Frame::at(Vec3::new(0.0, -0.3, -0.2))));
    let spec = BoxSpec { size: Vec3::splat(0.06), mass: 0.1, ..BoxSpec::default() };
    let body = box_3d(&spec).unwrap();
    add(&mut world, &body, Quat::IDENTITY, Vec3::new(0.11, 0.2, 0.14), false);
    world
}

/// Bits of the first particles of a world after some ticks.
fn bits(mut world: Simulation, count: usize, ticks: usize) -> Vec<[u32; 3]> {
    (0..ticks).for_each(|_| {
        world.step(DT).unwrap();
    });
    (0..count).map(|i| world.particles.position(i).to_array().map(f32::to_bits)).collect()
}

/// What is far away does not matter, not even where it makes contacts be searched for again within a step; nor do instruction sets and the past.
#[test]
fn edges_and_triangles_depend_on_nothing_else() {
    let count = held_up().particles.len();
    let alone = bits(held_up(), count, 200);
    let mut beside = held_up();
    let spec = BoxSpec { size: Vec3::splat(0.3), mass: 1.0, ..BoxSpec::default() };
    for (i, speed) in [(0, 0.0), (1, 60.0), (2, -40.0)] {
        let at = Vec3::new(30.0 + 0.4 * i as f32, 0.5 - 0.2 * i as f32, 0.0);
        let first = add(&mut beside, &box_3d(&spec).unwrap(), Quat::IDENTITY, at, false) as usize;
        let spin = Vec3::new(-speed, 0.3 * speed, 0.0);
        (first..first + 8).for_each(|i| beside.particles.set_velocity(i, spin));
    }
    assert!(bits(beside, count, 200) == alone, "what is far away");
    let mut plain = held_up();
    plain.instructions = InstructionSet::Simd128;
    assert!(bits(plain, count, 200) == alone, "instruction sets");
    // A copy of the state alone, in a world that has just been made.
    let mut past = held_up();
    (0..100).for_each(|_| {
        past.step(DT).unwrap();
    });
    let mut fresh = held_up();
    fresh.particles = past.particles.clone();
    fresh.contact_cache = past.contact_cache.clone();
    fresh.time = past.time;
    assert!(bits(fresh, count, 100) == alone, "the past");
}
