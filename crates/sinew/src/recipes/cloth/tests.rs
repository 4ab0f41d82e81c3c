//! Tests of the cloth grid.

use super::super::blueprint::checks::assert_at_rest;
use super::*;

fn curtain() -> ClothSpec {
    ClothSpec { width: 3.0, height: 2.0, columns: 7, rows: 5, ..ClothSpec::default() }
}

#[test]
fn a_grid_of_128_by_128_particles_has_64770_threads() {
    let mut spec = ClothSpec { columns: 127, rows: 127, ..ClothSpec::default() };
    spec.material.bend_compliance = None;
    let body = cloth_grid(&spec).unwrap();
    assert_eq!((body.particles.len(), body.distances.len()), (128 * 128, 64_770));
    spec.shear = false;
    assert_eq!(cloth_grid(&spec).unwrap().distances.len(), 127 * 128 * 2);
}

#[test]
fn every_tie_is_at_rest_and_the_mass_is_that_of_the_area() {
    let smallest = ClothSpec { columns: 1, rows: 1, ..ClothSpec::default() };
    for spec in [curtain(), ClothSpec::default(), smallest] {
        let body = cloth_grid(&spec).unwrap();
        assert_at_rest(&body);
        let mass = 0.2 * spec.width * spec.height;
        assert!((body.total_mass() / mass - 1.0).abs() < 1e-6);
        let (n, m) = (spec.columns, spec.rows);
        let (columns, rows) = (n + 1, m + 1);
        let ties = n * rows + m * columns + 2 * n * m + (n - 1) * rows + (m - 1) * columns;
        assert_eq!(body.distances.len(), ties as usize);
        let soft = body.distances.iter().filter(|d| !d.softness.is_hard()).count();
        assert_eq!(soft, ((n - 1) * rows + (m - 1) * columns) as usize);
    }
}

#[test]
fn rows_run_from_the_top_left_and_triangles_face_the_viewer() {
    let spec = curtain();
    let body = cloth_grid(&spec).unwrap();
    let at = |i: u32| body.particles[i as usize].position;
    let expected = [(-1.5, 1.0), (1.5, 1.0), (-1.5, -1.0), (1.5, -1.0)];
    assert_eq!(spec.corners().map(at), expected.map(|(x, y)| Vec3::new(x, y, 0.0)));
    assert_eq!((spec.index(3, 2), spec.index(u32::MAX, u32::MAX)), (19, 47));
    let mut area = 0.0;
    for t in &body.triangles {
        let [a, b, c] = t.map(at);
        let normal = (b - a).cross(c - a);
        assert!(normal.z > 0.0);
        area += 0.5 * normal.z;
    }
    assert_eq!(body.triangles.len(), 70);
    assert!((area - 6.0).abs() < 1e-5);
    assert_eq!(body.vertices.len(), body.particles.len());
    let uvs = grid_uvs(&spec).unwrap();
    for (uv, particle) in uvs.iter().zip(&body.particles) {
        let drawn = Vec3::new(3.0 * (uv[0] - 0.5), 2.0 * (0.5 - uv[1]), 0.0);
        assert!(particle.position.abs_diff_eq(drawn, 1e-6));
    }
    assert_eq!(uvs.len(), body.particles.len());
}

#[test]
fn each_fault_is_told_apart() {
    let refused = |change: fn(&mut ClothSpec)| {
        let mut spec = ClothSpec::default();
        change(&mut spec);
        let fault = cloth_grid(&spec).unwrap_err();
        assert_eq!(grid_uvs(&spec), Err(fault));
        fault
    };
    assert_eq!(refused(|s| s.width = 0.0), RecipeFault::Size);
    assert_eq!(refused(|s| s.height = f32::NAN), RecipeFault::Size);
    assert_eq!(refused(|s| s.rows = 0), RecipeFault::NoCells);
    assert_eq!(refused(|s| s.columns = u32::MAX), RecipeFault::TooMany);
    assert_eq!(refused(|s| s.material.density = -0.2), RecipeFault::Density);
    assert_eq!(refused(|s| s.material.stretch_compliance = -1.0), RecipeFault::Compliance);
    assert_eq!(
        refused(|s| s.material.bend_compliance = Some(f32::NAN)),
        RecipeFault::BendCompliance
    );
    assert_eq!(refused(|s| s.material.radius = -1.0), RecipeFault::Radius);
    assert_eq!(refused(|s| s.material.drag = 2.0), RecipeFault::Drag);
}
