//! The particles of a solid have its mass and inertia.

use super::super::blueprint::checks::assert_at_rest;
use super::super::mass;
use super::super::{BoxLayout, BoxSpec, ConvexHullFault, MassFault, box_3d};
use super::*;
use crate::particles::ParticleSeed;
use crate::pose::{Motion, motion};
use crate::test_random::Random;
use glam::DVec3;

const LAYOUTS: [SolidLayout; 2] = [SolidLayout::Eight, SolidLayout::Four];

fn cuboid(size: Vec3, middle: Vec3) -> Vec<Vec3> {
    let side = |i: u8| f32::from(i & 1) - 0.5;
    (0..8).map(|i| Vec3::new(side(i), side(i >> 1), side(i >> 2)) * size + middle).collect()
}

fn hull(points: Vec<Vec3>) -> SolidSpec {
    SolidSpec { shape: SolidShape::Hull(points), ..SolidSpec::default() }
}

/// Mass, barycentre and inertia of the particles.
fn measured(body: &Blueprint) -> Motion {
    motion(body.particles.iter().map(|p| (p.position, p.velocity, p.mass))).unwrap()
}

/// The shapes that `mass.rs` compares with closed forms, and others.
fn shapes() -> Vec<SolidShape> {
    let (vertices, triangles) = mass::tests::letter();
    let mut random = Random::new(9);
    let mut cloud = || random.vector() * Vec3::new(1.5, 0.5, 0.25);
    vec![
        SolidShape::Mesh { vertices, triangles },
        SolidShape::Hull((0..60).map(|_| cloud()).collect()),
        SolidShape::Hull(vec![Vec3::ZERO, Vec3::X, Vec3::Y * 2.0, Vec3::Z * 3.0]),
        SolidShape::Hull(cuboid(Vec3::new(0.01, 2.0, 1.0), Vec3::ONE)),
    ]
}

#[test]
fn four_or_eight_particles_have_the_mass_the_barycentre_and_the_inertia_of_any_solid() {
    let mut worst = 0.0_f32;
    for shape in shapes() {
        for layout in LAYOUTS {
            let spec = SolidSpec {
                shape: shape.clone(),
                bulk: Bulk::Density(700.0),
                layout,
                ..SolidSpec::default()
            };
            let body = solid(&spec).unwrap();
            assert_at_rest(&body);
            let (found, wanted) = (measured(&body), shape.mass_properties().unwrap());
            let mass = (wanted.volume * 700.0) as f32;
            assert!((found.mass / mass - 1.0).abs() < 1e-6);
            assert!((found.barycentre - wanted.barycentre.as_vec3()).length() < 1e-6);
            let inertia = wanted.inertia(mass);
            let size = inertia.to_cols_array().into_iter().fold(0.0, f32::max);
            for (a, b) in found.inertia.to_cols_array().iter().zip(inertia.to_cols_array()) {
                worst = worst.max((a - b).abs() / size);
            }
        }
    }
    println!("inertia is off by {worst:.1e} of the largest element at most");
    assert!(worst < 1e-5, "{worst}");
}

#[test]
fn a_box_of_any_size_gives_its_own_equimomental_particles() {
    for size in [Vec3::ONE, Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.01, 5.0, 0.3), Vec3::splat(1e5)] {
        let own =
            BoxSpec { size, mass: 5.0, layout: BoxLayout::Equimomental, ..BoxSpec::default() };
        let own = box_3d(&own).unwrap();
        let spec = SolidSpec { bulk: Bulk::Mass(5.0), ..hull(cuboid(size, Vec3::ZERO)) };
        let body = solid(&spec).unwrap();
        assert_eq!(body.distances.len(), 28);
        for (a, b) in body.particles.iter().zip(&own.particles) {
            assert!(((a.position - b.position) / size).abs().max_element() < 1e-6, "{a:?} {b:?}");
            assert_eq!(a.mass, b.mass);
        }
        assert_eq!(body.parts[0].size, size);
        let four = solid(&SolidSpec { layout: SolidLayout::Four, ..spec }).unwrap();
        assert_eq!((four.particles.len(), four.distances.len()), (4, 6));
        assert!(
            four.particles.iter().all(|p| body.particles.iter().any(|q| p.position == q.position))
        );
    }
}

#[test]
fn the_transform_that_is_read_back_is_that_of_the_mesh() {
    let shape = shapes().swap_remove(0);
    let body =
        solid(&SolidSpec { shape, layout: SolidLayout::Four, ..SolidSpec::default() }).unwrap();
    let part = &body.parts[0];
    assert_eq!((part.name, part.size), ("solid", Vec3::new(2.0, 3.0, 1.0)));
    let rotation = glam::Quat::from_xyzw(0.48, 0.0, 0.6, 0.64);
    let moved = body.transformed(rotation, Vec3::new(1.0, -2.0, 0.5));
    let points = moved.particles.iter().zip(&part.rest).map(|(p, &r)| (p.position, r, p.mass));
    let pose = crate::pose::pose(points, glam::Quat::IDENTITY).unwrap();
    assert!((pose.translation - Vec3::new(1.0, -2.0, 0.5)).length() < 1e-5);
    assert!(pose.rotation.dot(rotation).abs() > 1.0 - 1e-6);
}

#[test]
fn each_fault_is_told_apart_and_the_ends_of_the_ranges_are_accepted() {
    let good = || hull(cuboid(Vec3::ONE, Vec3::ZERO));
    let refused = |change: fn(&mut SolidSpec)| {
        let mut spec = good();
        change(&mut spec);
        solid(&spec).unwrap_err()
    };
    assert_eq!(solid(&SolidSpec::default()), Err(RecipeFault::Hull(ConvexHullFault::TooFew)));
    assert_eq!(solid(&hull(vec![Vec3::ONE; 8])), Err(RecipeFault::Hull(ConvexHullFault::Flat)));
    let plate = cuboid(Vec3::new(1.0, 1.0, 0.0), Vec3::ZERO);
    assert_eq!(solid(&hull(plate)), Err(RecipeFault::Hull(ConvexHullFault::Flat)));
    let nan = vec![Vec3::X, Vec3::NAN, Vec3::Y, Vec3::Z];
    assert_eq!(solid(&hull(nan)), Err(RecipeFault::Hull(ConvexHullFault::NotFinite(1))));
    let open =
        SolidShape::Mesh { vertices: cuboid(Vec3::ONE, Vec3::ZERO), triangles: vec![[0, 1, 3]] };
    let open = SolidSpec { shape: open, ..SolidSpec::default() };
    assert_eq!(solid(&open), Err(RecipeFault::Inside(MassFault::Open(0, 1))));
    assert_eq!(solid(&hull(cuboid(Vec3::splat(1e-7), Vec3::ZERO))), Err(RecipeFault::Size));
    assert_eq!(solid(&hull(cuboid(Vec3::splat(2e6), Vec3::ZERO))), Err(RecipeFault::Size));
    assert_eq!(solid(&hull(cuboid(Vec3::ONE, Vec3::X * 1e6))), Err(RecipeFault::Size));
    let sheet = cuboid(Vec3::new(1.0, 1.0, 5e-6), Vec3::ZERO);
    assert_eq!(solid(&hull(sheet)), Err(RecipeFault::Size));
    assert_eq!(refused(|s| s.bulk = Bulk::Mass(0.0)), RecipeFault::Mass);
    assert_eq!(refused(|s| s.bulk = Bulk::Mass(f32::NAN)), RecipeFault::Mass);
    assert_eq!(refused(|s| s.bulk = Bulk::Density(-1.0)), RecipeFault::Mass);
    assert_eq!(refused(|s| s.bulk = Bulk::Density(f32::INFINITY)), RecipeFault::Mass);
    assert_eq!(refused(|s| s.radius = -0.1), RecipeFault::Radius);
    assert_eq!(refused(|s| s.drag = 1.5), RecipeFault::Drag);
    for (size, mass) in [(1e-6, 1e12), (1e6, 1e-9)] {
        for layout in LAYOUTS {
            let spec = hull(cuboid(Vec3::splat(size), Vec3::ZERO));
            assert_at_rest(&solid(&SolidSpec { bulk: Bulk::Mass(mass), layout, ..spec }).unwrap());
        }
    }
}

#[test]
fn round_solids_weigh_and_turn_as_formulas_have_it_and_collide_as_what_they_are() {
    let (r, h) = (0.5_f32, 2.0_f32);
    let capsule = {
        // A cylinder of length h with half a ball at each end, whose centroid is 3r/8 farther out.
        let (r, h) = (f64::from(r), f64::from(h));
        let (tube, ball) = (r * r * h, 4.0 / 3.0 * r * r * r);
        let (tube, ball) = (tube / (tube + ball), ball / (tube + ball));
        let across = tube * (r * r / 4.0 + h * h / 12.0)
            + ball * (0.4 * r * r + h * h / 4.0 + 3.0 * h * r / 8.0);
        DVec3::new(across, tube * r * r / 2.0 + ball * 0.4 * r * r, across)
    };
    let [r2, h2] = [f64::from(r * r), f64::from(h * h)];
    let across = r2 / 4.0 + h2 / 12.0;
    let cases = [
        (Shape::sphere(r).unwrap(), DVec3::splat(0.4 * r2)),
        (Shape::cylinder(r, h).unwrap(), DVec3::new(across, r2 / 2.0, across)),
        (Shape::capsule(r, h).unwrap(), capsule),
        (Shape::cuboid(Vec3::new(1.0, 2.0, 3.0)).unwrap(), DVec3::new(13.0, 10.0, 5.0) / 12.0),
    ];
    for (shape, expected) in cases {
        for layout in [SolidLayout::Eight, SolidLayout::Four] {
            let spec = SolidSpec {
                shape: SolidShape::Collider(shape.clone()),
                bulk: Bulk::Mass(3.0),
                layout,
                ..SolidSpec::default()
            };
            let body = solid(&spec).unwrap();
            let moment = |p: &ParticleSeed| {
                let s = p.position.as_dvec3() * p.position.as_dvec3();
                DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y) * f64::from(p.mass)
            };
            let inertia: DVec3 = body.particles.iter().map(moment).sum();
            assert!(
                (inertia / 3.0 / expected - 1.0).abs().max_element() < 1e-5,
                "{shape:?}: {inertia}"
            );
            assert_eq!(body.parts[0].shape.as_ref(), Some(&shape));
        }
    }
    let flat =
        SolidSpec { shape: SolidShape::Collider(Shape::half_space()), ..SolidSpec::default() };
    assert_eq!(solid(&flat), Err(RecipeFault::Shape));
}
