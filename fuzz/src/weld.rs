//! Meshes, possibly invalid: a cloth made from one is valid, or refused for a reason that applies.

use std::collections::BTreeSet;

use sinew::Simulation;
use sinew::glam::Vec3;
use sinew::recipes::{ClothMaterial, MeshFault, RecipeFault, Weld, cloth_from_mesh};

use crate::input::Input;

const MAX_VERTICES: u32 = 48;
const MAX_INDICES: u32 = 240;

/// Welds a mesh and makes cloth of it. Panics if the recipe breaks a guarantee.
pub fn weld(data: &[u8]) {
    let mut input = Input::new(data);
    let material = material(&mut input);
    let (positions, indices) = mesh(&mut input);
    match sinew::recipes::weld(&positions, &indices, material.weld_tolerance) {
        Ok(welded) => check_weld(&welded, &positions, material.weld_tolerance),
        Err(fault) => check_fault(fault, &positions, &indices, material.weld_tolerance),
    }
    match cloth_from_mesh(&positions, &indices, &material) {
        Ok(cloth) => {
            assert_eq!(cloth.validate(), Ok(()));
            assert_eq!(cloth.vertices.len(), positions.len());
            assert!(cloth.particles.iter().all(|p| p.mass.is_normal() && p.mass > 0.0));
            assert!(cloth.distances.iter().all(|d| d.rest > 0.0));
            let mut world = Simulation::default();
            let rows = cloth.build(&mut world).expect("a valid blueprint was not built");
            world.settings.substeps = 2;
            world.step(1.0 / 60.0).expect("a step of 1/60 s was refused");
            assert!(rows.into_iter().all(|i| world.particles.is_finite(i)));
        }
        Err(RecipeFault::Mesh(fault)) => {
            check_fault(fault, &positions, &indices, material.weld_tolerance);
        }
        Err(_) => {}
    }
}

fn material(input: &mut Input) -> ClothMaterial {
    let usual = ClothMaterial::default();
    ClothMaterial {
        density: input.mostly(|_| usual.density),
        stretch_compliance: input.mostly(|_| 0.0),
        bend_compliance: if input.flag() { Some(input.mostly(|_| 1.0)) } else { None },
        radius: input.mostly(|_| usual.radius),
        drag: input.mostly(|_| 0.0),
        weld_tolerance: if input.flag() { usual.weld_tolerance } else { input.any() },
    }
}

/// Vertices on a coarse lattice, so that many coincide, near it, or anywhere; indices that exist in most cases.
fn mesh(input: &mut Input) -> (Vec<Vec3>, Vec<u32>) {
    let (vertices, triangles) = (input.below(MAX_VERTICES), input.below(MAX_INDICES / 3));
    let spare = if input.rarely(16) { input.below(3) } else { 0 };
    let wild = input.rarely(4);
    let coordinate = |input: &mut Input| match input.below(8) {
        0 if wild => input.any(),
        0 | 1 => input.ordinary(),
        2 => input.below(4) as f32 + input.ordinary() * 1e-6,
        _ => input.below(4) as f32,
    };
    let positions: Vec<Vec3> = (0..vertices)
        .map(|_| Vec3::new(coordinate(input), coordinate(input), coordinate(input)))
        .collect();
    let index = |input: &mut Input| match input.below(256) {
        255 if wild => input.bits(),
        _ => input.below(vertices),
    };
    let indices = (0..triangles * 3 + spare).map(|_| index(input)).collect();
    (positions, indices)
}

/// Checks the documented properties of [`Weld`]'s fields.
fn check_weld(welded: &Weld, vertices: &[Vec3], tolerance: f32) {
    let count = welded.positions.len();
    let exists = |i: &u32| (*i as usize) < count;
    assert_eq!(welded.vertices.len(), vertices.len());
    assert!(welded.vertices.iter().all(exists));
    let mut used = vec![false; count];
    for t @ [a, b, c] in &welded.triangles {
        assert!(a != b && b != c && c != a && t.iter().all(exists), "{t:?}");
        t.iter().for_each(|&i| used[i as usize] = true);
    }
    assert!(!welded.triangles.is_empty() && used.iter().all(|&used| used));
    let reach = f64::from(tolerance);
    for (i, a) in welded.positions.iter().enumerate() {
        for b in &welded.positions[..i] {
            let away = a.as_dvec3().distance_squared(b.as_dvec3());
            assert!(away > reach * reach, "{a} and {b} are one particle");
        }
    }
    let set = |t: &[u32; 3]| {
        let mut sorted = *t;
        sorted.sort_unstable();
        sorted
    };
    let distinct: BTreeSet<_> = welded.triangles.iter().map(set).collect();
    assert_eq!(distinct.len(), welded.triangles.len(), "a triangle is there twice");
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    let edges: BTreeSet<[u32; 2]> = welded.triangles.iter().flat_map(sides).collect();
    assert!(welded.edges.iter().eq(edges.iter()), "the edges are not those of the triangles");
    assert!(welded.bends.is_sorted_by(|a, b| a.edge < b.edge));
    for bend in &welded.bends {
        assert!(edges.contains(&bend.edge) && bend.opposite[0] < bend.opposite[1], "{bend:?}");
    }
}

/// Checks that the stated reason applies.
fn check_fault(fault: MeshFault, positions: &[Vec3], indices: &[u32], tolerance: f32) {
    let reason = match fault {
        MeshFault::Empty => positions.is_empty() || indices.is_empty(),
        MeshFault::NotTriangles(n) => n == indices.len() && n % 3 != 0,
        MeshFault::TooMany => positions.len() > 1 << 24,
        MeshFault::NotFinite(i) => !positions[i].is_finite(),
        MeshFault::IndexOutOfRange { index, vertices } => {
            index as usize >= vertices && vertices == positions.len() && indices.contains(&index)
        }
        MeshFault::Tolerance => !(tolerance.is_finite() && tolerance >= 0.0),
        // Not checked independently; trusted for every mesh that got this far.
        MeshFault::AllDegenerate => !positions.is_empty(),
    };
    assert!(reason, "refused without a reason: {fault}");
}
