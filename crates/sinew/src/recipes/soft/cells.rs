//! How a box and a ball are cut into tetrahedra that share whole faces.

use std::collections::BTreeMap;

use glam::{DVec3, UVec3};

use super::lattice::Lattice;

/// Least stiffness of a tie, as a share of what a cubic cell would have: a cell that is too long asks for less than none.
const LEAST_TIE: f64 = 0.05;

/// A box about the origin, in `cells` of five tetrahedra.
///
/// Points whose numbers add up to an even one are the ends of all diagonals, so two cells draw the same diagonal in the face between them. Each
/// cell is the tetrahedron of its four even corners, and one at each of its odd corners, which reaches to the three next to it.
pub(super) fn block(size: DVec3, cells: UVec3) -> Lattice {
    let [nx, ny, nz] = cells.to_array();
    let row = |n: u32| 0..=n;
    let share = |i: u32, of: u32| f64::from(i) / f64::from(of) - 0.5;
    let point = |x, y, z| size * DVec3::new(share(x, nx), share(y, ny), share(z, nz));
    let points =
        row(nz).flat_map(|z| row(ny).flat_map(move |y| row(nx).map(move |x| point(x, y, z))));
    let mut lattice =
        Lattice { points: points.collect(), tetrahedra: Vec::new(), ties: BTreeMap::new() };
    let cell = size / cells.as_dvec3();
    let inverse = (cell * cell).recip();
    let volume = cell.x * cell.y * cell.z;
    let along = |axis: usize| {
        let ideal = 4.0 * inverse[axis] - inverse.x - inverse.y - inverse.z;
        volume * ideal.max(LEAST_TIE * inverse[axis])
    };
    // What all cells around an edge have together: four along an axis, two along a diagonal.
    let edges = [0, 1, 2].map(|axis| 0.25 * along(axis));
    let diagonal = |plane: u32| {
        let axes = (0..3).filter(|axis| plane >> axis & 1 == 1);
        0.5 * volume * axes.map(|axis: usize| inverse[axis]).sum::<f64>()
    };
    for (z, y, x) in
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x))))
    {
        let corner = |k: u32| {
            let (x, y, z) = (x + (k & 1), y + (k >> 1 & 1), z + (k >> 2 & 1));
            (z * (ny + 1) + y) * (nx + 1) + x
        };
        let odd = |k: &u32| (x + y + z + k.count_ones()) & 1 == 1;
        let mut even = [0; 4];
        (0..8).filter(|k| !odd(k)).zip(&mut even).for_each(|(k, place)| *place = k);
        lattice.push(even.map(corner));
        for k in (0..8).filter(odd) {
            lattice.push([k, k ^ 1, k ^ 2, k ^ 4].map(corner));
            for (axis, stiffness) in edges.iter().enumerate() {
                lattice.tie(corner(k), corner(k ^ 1 << axis), *stiffness);
            }
        }
        for (i, &a) in even.iter().enumerate() {
            for &b in &even[i + 1..] {
                lattice.tie(corner(a), corner(b), diagonal(a ^ b));
            }
        }
    }
    lattice
}

/// A ball about the origin, in shells: an icosahedron whose twenty sectors, nearly regular tetrahedra, are cut into as many layers as there are
/// shells, each pushed out to its sphere.
///
/// A layer between the triangle lattices of order `k` and `k + 1` has three kinds of cells: a tetrahedron on each upright triangle of the outer
/// one; an octahedron between an upright triangle of the inner and a hanging one of the outer; a tetrahedron below each hanging triangle of the
/// inner. Octahedra are cut into four around their shortest diagonal. The faces between sectors are triangles of both, whatever is inside.
pub(super) fn ball(radius: f64, shells: u32) -> Lattice {
    let (corners, faces) = icosahedron();
    let mut lattice = Lattice { points: Vec::new(), tetrahedra: Vec::new(), ties: BTreeMap::new() };
    let mut numbers: BTreeMap<[u32; 6], u32> = BTreeMap::new();
    for face in faces {
        let mut point = |shell: u32, i: u32, j: u32| {
            let mut shares = [(face[0], shell - i - j), (face[1], i), (face[2], j)];
            shares.sort_unstable_by_key(|&(corner, share)| (share == 0, corner));
            let used = |n: usize| {
                if shares[n].1 == 0 { [u32::MAX, 0] } else { [shares[n].0, shares[n].1] }
            };
            let [a, b, c] = [0, 1, 2].map(used);
            let next = lattice.points.len() as u32;
            *numbers.entry([a[0], a[1], b[0], b[1], c[0], c[1]]).or_insert_with(|| {
                let sum: DVec3 =
                    shares.iter().map(|&(c, n)| corners[c as usize] * f64::from(n)).sum();
                let out = radius * f64::from(shell) / f64::from(shells);
                lattice.points.push(sum.normalize_or_zero() * out);
                next
            })
        };
        let mut found = Vec::new();
        let mut octahedra = Vec::new();
        for k in 0..shells {
            for (i, j) in (0..=k).flat_map(|i| (0..=k - i).map(move |j| (i, j))) {
                let upright = [point(k + 1, i, j), point(k + 1, i + 1, j), point(k + 1, i, j + 1)];
                let here = point(k, i, j);
                found.push([here, upright[0], upright[1], upright[2]]);
                if i + j < k {
                    let [right, up] = [point(k, i + 1, j), point(k, i, j + 1)];
                    let across = point(k + 1, i + 1, j + 1);
                    // Opposite corners are three apart.
                    octahedra.push([here, right, up, across, upright[2], upright[1]]);
                    if i + j + 1 < k {
                        found.push([right, up, point(k, i + 1, j + 1), across]);
                    }
                }
            }
        }
        found.iter().for_each(|&t| lattice.push(t));
        octahedra.iter().for_each(|&o| quarter(&mut lattice, o));
    }
    for t in lattice.tetrahedra.clone() {
        let volume = lattice.volume(&t);
        for (i, &a) in t.iter().enumerate() {
            for &b in &t[i + 1..] {
                let apart = lattice.points[a as usize].distance_squared(lattice.points[b as usize]);
                lattice.tie(a, b, 2.5 * volume / apart);
            }
        }
    }
    lattice
}

/// Cuts an octahedron, whose opposite corners are three apart, into four tetrahedra around its shortest diagonal; the first of equal ones.
fn quarter(lattice: &mut Lattice, o: [u32; 6]) {
    let long = |&d: &usize| {
        let [a, b] = [o[d], o[d + 3]].map(|i| lattice.points[i as usize]);
        a.distance_squared(b)
    };
    let shortest = [1, 2]
        .iter()
        .fold(0, |best, d| if long(d) < long(&best) * (1.0 - 1e-9) { *d } else { best });
    let [a, b] = [(shortest + 1) % 3, (shortest + 2) % 3];
    let ring = [o[a], o[b], o[a + 3], o[b + 3]];
    for side in 0..4 {
        lattice.push([o[shortest], o[shortest + 3], ring[side], ring[(side + 1) % 4]]);
    }
}

/// Corners at distance 1 from the origin, and faces.
fn icosahedron() -> ([DVec3; 12], [[u32; 3]; 20]) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let corners = [
        [-1.0, golden, 0.0],
        [1.0, golden, 0.0],
        [-1.0, -golden, 0.0],
        [1.0, -golden, 0.0],
        [0.0, -1.0, golden],
        [0.0, 1.0, golden],
        [0.0, -1.0, -golden],
        [0.0, 1.0, -golden],
        [golden, 0.0, -1.0],
        [golden, 0.0, 1.0],
        [-golden, 0.0, -1.0],
        [-golden, 0.0, 1.0],
    ];
    let faces = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    (corners.map(|c| DVec3::from_array(c).normalize()), faces)
}
