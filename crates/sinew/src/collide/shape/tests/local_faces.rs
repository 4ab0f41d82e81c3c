//! The face that a sphere may meet, against the search through all triangles.

use glam::Vec3;

use super::super::local_face::{LaneFaces, LocalFace, Reachable};
use super::super::{Shape, ShapeTouch};
use super::{hills, torus, waves};
use crate::lanes::{InstructionSet, LANES, LaneArray, Lanes, Vector, kernel};
use crate::test_random::Random;

/// Surfaces with convex and concave edges, thin walls, several sheets and flat faces of several triangles.
fn surfaces() -> Vec<(&'static str, Shape)> {
    let mut random = Random::new(11);
    let rough: Vec<f32> = (0..400).map(|_| random.fraction()).collect();
    let stairs: Vec<f32> = (0..400).map(|i| (i % 20 / 4) as f32).collect();
    let block = |low: Vec3, high: Vec3| {
        let at = |i: u32| {
            let pick = |bit: u32, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
            Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
        };
        let faces =
            [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [b, d, c]]);
        ((0..8).map(at).collect::<Vec<_>>(), triangles.collect::<Vec<[u32; 3]>>())
    };
    let (mut vertices, mut triangles) =
        block(Vec3::new(-1.0, -0.2, -1.0), Vec3::new(1.0, 0.0, 1.0));
    let (wall, sides) = block(Vec3::new(-0.5, 0.0, -0.01), Vec3::new(0.5, 0.6, 0.01));
    triangles.extend(sides.iter().map(|side| side.map(|i| i + 8)));
    vertices.extend(wall);
    vec![
        ("torus", torus(40, 20)),
        ("waves", waves(12)),
        ("hills", hills()),
        ("rough", Shape::height_field(20, 20, &rough, Vec3::new(2.0, 0.2, 2.0)).unwrap()),
        ("stairs", Shape::height_field(20, 20, &stairs, Vec3::new(2.0, 0.1, 2.0)).unwrap()),
        ("wall", Shape::mesh(vertices, triangles).unwrap()),
    ]
}

/// A place near a surface, a radius and a way.
fn near(shape: &Shape, random: &mut Random) -> (Vec3, f32, f32) {
    let radius = [0.0, 0.01, 0.05][random.below(3)];
    let way = [0.003, 0.02, 0.1][random.below(3)];
    let nearest = shape.nearest(random.vector() * Vec3::new(1.2, 0.7, 1.2));
    let height = radius + 3.0 * way * random.number();
    (nearest.point + nearest.normal * height, radius, way)
}

/// A point that the centre of such a sphere may get to.
fn reached(random: &mut Random, at: Vec3, way: f32) -> Vec3 {
    let by = random.vector();
    at + by * (way * random.fraction() / by.length().max(1e-3))
}

/// Whether two contacts are equal up to rounding. The search may take an edge beside the point below for nearest: a hundredth of a millimetre aside, the distance
/// differs by less than its rounding, and the normal by a thousandth.
fn agree(found: Option<ShapeTouch>, other: Option<ShapeTouch>, radius: f32) -> bool {
    let tolerance = 3e-6 + 2e-5 * radius;
    match (found, other) {
        (Some(one), Some(other)) => {
            let tilt = one.normal.distance(other.normal);
            (one.depth - other.depth).abs() <= tolerance
                && tilt * one.depth <= tolerance.max(5e-3 * one.depth)
        }
        (Some(only), None) | (None, Some(only)) => only.depth <= tolerance,
        (None, None) => true,
    }
}

#[test]
fn the_face_is_met_as_the_search_meets_it_and_where_nothing_is_found_nothing_is_met() {
    for (name, shape) in surfaces() {
        let mut random = Random::new(3);
        let (mut nothing, mut certain, mut touching) = (0, 0, 0);
        for _ in 0..6000 {
            let (at, radius, way) = near(&shape, &mut random);
            let found = shape.reachable(at, way, radius);
            for _ in 0..8 {
                let (from, to) = (reached(&mut random, at, way), reached(&mut random, at, way));
                let searched = shape.touch(from, to, radius);
                let case = format!("{name}: {at} {radius} {way}: {from} to {to}: {searched:?}");
                match &found {
                    Reachable::Several => {}
                    Reachable::Nothing => {
                        nothing += 1;
                        assert!(searched.is_none(), "{case}");
                    }
                    Reachable::Face(face) => {
                        let Some(touch) = face.touch_one(from, to) else { continue };
                        certain += 1;
                        touching += usize::from(touch.is_some());
                        assert!(agree(touch, searched, radius), "{case}, {touch:?}");
                    }
                }
            }
        }
        println!("{name}: {nothing} {certain} {touching}");
        let enough = nothing > 500 && certain > 1000 && touching > 400;
        assert!(enough, "{name}: {nothing} {certain} {touching}");
    }
}

/// Particles that lie on a terrain move less in a step than its triangles are wide: then most of them meet one triangle.
#[test]
fn what_lies_on_a_terrain_meets_one_face() {
    for (name, shape) in surfaces().into_iter().take(4) {
        let mut random = Random::new(5);
        let (mut known, mut all) = (0, 0);
        for _ in 0..2000 {
            let above = (random.vector() * 0.9).with_y(2.0);
            let Some(hit) = shape.cast_ray(above, Vec3::NEG_Y, 5.0) else { continue };
            let (radius, way) = (0.01, 0.004);
            let at = above - Vec3::Y * hit.distance + hit.normal * radius;
            let to = at + random.vector() * 1e-4;
            let Reachable::Face(face) = shape.reachable(at, way, radius) else {
                all += 1;
                continue;
            };
            known += usize::from(face.touch_one(at, to).is_some());
            all += 1;
        }
        assert!(known as f32 > 0.75 * all as f32, "{name}: {known} of {all}");
    }
}

kernel!(
    /// Depth, and masks of touching and of certainty, of eight spheres.
    fn touch_lanes<L: Lanes>(
        faces: &LaneFaces,
        ends: [[LaneArray; 3]; 2],
    ) -> (LaneArray, [u32; 2]) {
        let [from, to] = ends;
        let from = Vector::new(L::load(&from[0]), L::load(&from[1]), L::load(&from[2]));
        let to = Vector::new(L::load(&to[0]), L::load(&to[1]), L::load(&to[2]));
        let found = faces.load::<L>().touch(from, to);
        (found.depth.array(), [found.touching.bits(), found.certain.bits()])
    }
);

#[test]
fn eight_faces_are_met_as_one_is_to_the_last_bit() {
    let mut random = Random::new(7);
    let mut faces: Vec<(LocalFace, Vec3, f32)> = Vec::new();
    for (_, shape) in surfaces() {
        for _ in 0..200 {
            let (at, radius, way) = near(&shape, &mut random);
            if let Reachable::Face(face) = shape.reachable(at, way, radius) {
                faces.push((face, at, way));
            }
        }
    }
    assert!(faces.len() > 200);
    for eight in faces.chunks(LANES) {
        let lanes = LaneFaces::of(eight.iter().map(|(face, ..)| face));
        let mut ends = [[[0.0; LANES]; 3]; 2];
        for (lane, (_, at, way)) in eight.iter().enumerate() {
            for end in &mut ends {
                let p = reached(&mut random, *at, *way).to_array();
                (0..3).for_each(|axis| end[axis][lane] = p[axis]);
            }
        }
        for instructions in InstructionSet::ALL {
            let (depths, [touching, certain]) = touch_lanes(&lanes, ends, instructions);
            for (lane, (face, ..)) in eight.iter().enumerate() {
                let [from, to] = ends.map(|[x, y, z]| Vec3::new(x[lane], y[lane], z[lane]));
                let single = face.touch(from.into(), to.into());
                let bits = [single.touching.to_bits() != 0, single.certain.to_bits() != 0];
                assert_eq!([touching, certain].map(|mask| mask >> lane & 1 == 1), bits);
                assert_eq!(depths[lane].to_bits(), single.depth.to_bits());
            }
        }
    }
}
