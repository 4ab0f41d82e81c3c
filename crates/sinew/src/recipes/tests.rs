//! Equal bodies are bitwise equal wherever they are: a recipe measures lengths in the body's own coordinates, before the body is placed. The solver puts such
//! bodies side by side into SIMD lanes.

use glam::{Quat, UVec3, Vec3};

use super::*;
use crate::{Simulation, Softness};

/// One body of each recipe.
fn bodies() -> Vec<(&'static str, Blueprint)> {
    let brick = BoxSpec { size: Vec3::new(0.3, 0.7, 1.1), mass: 0.37, ..BoxSpec::default() };
    let inner = BoxSpec { layout: BoxLayout::Equimomental, ..brick };
    let sagging = RopeSpec {
        from: Vec3::new(0.1, 0.2, 0.3),
        to: Vec3::new(1.3, 0.7, -0.2),
        slack: 0.3,
        segments: 31,
        ..RopeSpec::default()
    };
    let sheet =
        ClothSpec { width: 0.77, height: 1.3, columns: 9, rows: 14, ..ClothSpec::default() };
    let ball = soft_lattice_mesh(&SoftLatticeSpec {
        shape: SoftShape::Ball { radius: 0.3, cells: 6 },
        ..SoftLatticeSpec::default()
    });
    let ball = ball.unwrap();
    let skin = SoftMeshSpec {
        pressure: 1.1,
        softness: Softness::frequency(5.0, 0.3),
        ..SoftMeshSpec::default()
    };
    let block = SoftShape::Box { size: Vec3::new(0.3, 0.5, 0.7), cells: UVec3::new(2, 3, 4) };
    let hull =
        SolidShape::Hull(ball.positions.iter().map(|p| *p * Vec3::new(1.0, 2.0, 0.3)).collect());
    let arm = |head: f32, parent, joint| Bone {
        head: Vec3::new(0.1, 0.2 - head, 0.3),
        tail: Vec3::new(0.15, -0.1 - head, 0.3),
        parent,
        joint,
        ..Bone::default()
    };
    let bones = vec![
        arm(0.0, None, Joint::default()),
        arm(0.3, Some(0), Joint::Hinge { axis: Vec3::X, min: -0.1, max: 2.0 }),
        arm(0.6, Some(1), Joint::Ball { cone: 0.5, twist: 0.3 }),
    ];
    vec![
        ("box", box_3d(&brick).unwrap()),
        ("equimomental box", box_3d(&inner).unwrap()),
        ("rectangle", box_2d(&brick).unwrap()),
        ("rope", rope(&sagging).unwrap()),
        ("cloth", cloth_grid(&sheet).unwrap()),
        (
            "cloth from a mesh",
            cloth_from_mesh(&ball.positions, &ball.indices, &sheet.material).unwrap(),
        ),
        ("skin", soft_mesh(&skin, &ball.positions, &ball.indices).unwrap()),
        (
            "soft block",
            soft_lattice(&SoftLatticeSpec { shape: block, ..SoftLatticeSpec::default() }).unwrap(),
        ),
        ("solid", solid(&SolidSpec { shape: hull, ..SolidSpec::default() }).unwrap()),
        (
            "ragdoll",
            ragdoll(&RagdollSpec { height: 1.83, mass: 71.0, ..RagdollSpec::default() }).unwrap(),
        ),
        ("arm", articulated(&ArticulatedSpec { bones, drag: 0.1 }).unwrap()),
    ]
}

#[test]
fn equal_bodies_in_different_places_are_held_by_the_same_bits() {
    let places = [
        (Quat::IDENTITY, Vec3::ZERO),
        (Quat::IDENTITY, Vec3::new(0.1, 17.3, -1234.567)),
        (Quat::from_xyzw(0.1, -0.7, 0.3, 0.5), Vec3::new(-4321.1, 0.3, 77.7)),
    ];
    for (name, body) in bodies() {
        let mut world = Simulation::default();
        for (turn, to) in places {
            body.transformed(turn, to).build(&mut world).unwrap();
        }
        let rows = body.particles.len();
        assert!(!body.distances.is_empty() || !body.constraints.is_empty(), "{name}");
        for copy in 0..3 {
            let first = (copy * rows) as u32;
            for i in 0..rows {
                let bits = |row: usize| {
                    let column = [world.particles.inverse_mass(row), world.particles.radius(row)];
                    column.map(f32::to_bits)
                };
                assert_eq!(bits(i), bits(i + copy * rows), "{name}: particle {i}");
            }
            let own = |count: usize| count * copy..count * (copy + 1);
            for (one, other) in
                world.distances()[own(body.distances.len())].iter().zip(&body.distances)
            {
                assert_eq!([one.a, one.b], [other.a + first, other.b + first]);
                assert_eq!(one.rest.to_bits(), other.rest.to_bits(), "{name}: {other:?}");
                assert_eq!((one.softness, one.bound), (other.softness, other.bound));
            }
            for (one, other) in
                world.constraints()[own(body.constraints.len())].iter().zip(&body.constraints)
            {
                assert_eq!(one.kind, other.kind, "{name}");
                assert!(one.rows.iter().zip(&other.rows).all(|(a, b)| *a == b + first));
            }
        }
    }
}

#[test]
fn what_is_built_twice_is_the_same() {
    for ((name, one), (_, other)) in bodies().into_iter().zip(bodies()) {
        assert_eq!(one, other, "{name}");
    }
}
