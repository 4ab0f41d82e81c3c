//! A grid is detected and numbered by rows, and anything else gets an order of small bandwidth.

use super::super::super::blueprint::checks::assert_at_rest;
use super::super::super::{Blueprint, ClothMaterial, cloth_from_mesh};
use super::*;
use crate::constraints::Softness;

/// Which diagonal the cell at a column and row has: true for that down to the right.
type Diagonal = fn(u32, u32) -> bool;
const DIAGONALS: [Diagonal; 5] = [
    |_, _| true,
    |_, _| false,
    |x, y| (x + y) % 2 == 0,
    |x, _| x % 2 == 0,
    |x, y| (x.wrapping_mul(747_796_405) ^ y.wrapping_mul(2_891_336_453)).count_ones() % 2 == 0,
];

struct Drawn {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Drawn {
    /// A grid of `w × h` particles, row by row, with cells of 0.1 m × 0.1 m.
    fn grid(w: u32, h: u32, diagonal: Diagonal) -> Self {
        let place = |i: u32| Vec3::new((i % w) as f32 * 0.1, (i / w) as f32 * -0.1, 0.0);
        let mut triangles = Vec::new();
        for (x, y) in (0..h - 1).flat_map(|y| (0..w - 1).map(move |x| (x, y))) {
            let a = y * w + x;
            let (b, c, d) = (a + 1, a + w, a + w + 1);
            triangles.extend(if diagonal(x, y) {
                [[a, c, d], [a, d, b]]
            } else {
                [[a, c, b], [b, c, d]]
            });
        }
        Self { positions: (0..w * h).map(place).collect(), triangles }
    }

    /// Rings about the y axis between two poles.
    fn globe(around: u32, rings: u32) -> Self {
        let angle = |i: u32, of: u32| 2.0 * core::f32::consts::PI * i as f32 / of as f32;
        let mut positions = vec![Vec3::Y];
        for (ring, i) in (1..=rings).flat_map(|ring| (0..around).map(move |i| (ring, i))) {
            let (down, round) = (0.5 * angle(ring, rings + 1), angle(i, around));
            let flat = Vec3::new(libm::cosf(round), 0.0, libm::sinf(round)) * libm::sinf(down);
            positions.push(flat.with_y(libm::cosf(down)));
        }
        positions.push(Vec3::NEG_Y);
        let last = rings * around + 1;
        let at = |ring: u32, i: u32| ring * around + i % around + 1;
        let mut triangles = Vec::new();
        for i in 0..around {
            triangles.push([0, at(0, i + 1), at(0, i)]);
            triangles.push([last, at(rings - 1, i), at(rings - 1, i + 1)]);
            for ring in 1..rings {
                let [a, b] = [at(ring - 1, i), at(ring - 1, i + 1)];
                let [c, d] = [at(ring, i), at(ring, i + 1)];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        Self { positions, triangles }
    }

    fn bent(mut self, bend: impl Fn(Vec3) -> Vec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p = bend(*p));
        self
    }

    /// The same with vertices and triangles in another order, and triangles rotated.
    fn shuffled(&self, random: &mut Random) -> Self {
        let count = self.positions.len() as u32;
        let mut order: Vec<u32> = (0..count).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, random.below(i + 1));
        }
        let mut positions = vec![Vec3::ZERO; count as usize];
        for (p, &to) in self.positions.iter().zip(&order) {
            positions[to as usize] = *p;
        }
        let mut triangles: Vec<[u32; 3]> =
            self.triangles.iter().map(|t| t.map(|i| order[i as usize])).collect();
        for i in (1..triangles.len()).rev() {
            triangles.swap(i, random.below(i + 1));
            triangles[i].rotate_left(random.below(3));
        }
        Self { positions, triangles }
    }

    fn weld(&self) -> Weld {
        weld(&self.positions, self.triangles.as_flattened(), 1e-5).unwrap()
    }

    fn cloth(&self) -> Blueprint {
        let material = ClothMaterial::default();
        cloth_from_mesh(&self.positions, self.triangles.as_flattened(), &material).unwrap()
    }
}

fn bandwidth(edges: &[[u32; 2]]) -> u32 {
    edges.iter().map(|[a, b]| b - a).max().unwrap()
}

/// Asserts that all edges of a piece go along a row, to the next row, or along a diagonal.
fn assert_rows(welded: &Weld, w: u32, h: u32) {
    let piece = Piece { particles: 0..w * h, columns: Some(w) };
    assert_eq!(welded.pieces, [piece], "{w} x {h}");
    let row = |i: u32| [i / w, i % w];
    for &[a, b] in &welded.edges {
        let ([ya, xa], [yb, xb]) = (row(a), row(b));
        assert!(yb - ya <= 1 && xa.abs_diff(xb) <= 1, "{a} {b} in rows of {w}");
    }
    assert_eq!(welded.edges.len() as u32, (w - 1) * h + w * (h - 1) + (w - 1) * (h - 1));
}

/// Number of pairs of particles that are an edge or opposite each other across one.
fn ties(drawn: &Drawn) -> usize {
    let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
    let welded = drawn.weld();
    let folds = welded.bends.iter().map(|bend| sorted(bend.opposite[0], bend.opposite[1]));
    welded.edges.iter().copied().chain(folds).collect::<BTreeSet<_>>().len()
}

#[test]
fn grids_of_any_size_and_any_diagonals_are_numbered_row_by_row() {
    let mut random = Random::new(5);
    for (w, h) in [(2, 2), (3, 2), (3, 3), (5, 2), (7, 3), (8, 8), (13, 9), (40, 40), (64, 17)] {
        for diagonal in DIAGONALS {
            for drawn in [Drawn::grid(w, h, diagonal), Drawn::grid(h, w, diagonal)] {
                assert_rows(&drawn.weld(), w, h);
                let cloth = drawn.cloth();
                assert_at_rest(&cloth);
                assert_eq!(cloth.distances.len(), ties(&drawn), "{w} x {h}");
                for _ in 0..4 {
                    assert_rows(&drawn.shuffled(&mut random).weld(), w, h);
                }
            }
        }
    }
}

#[test]
fn a_shuffled_grid_becomes_the_same_cloth_to_the_bit() {
    let mut random = Random::new(6);
    for (w, h) in [(3, 3), (24, 24), (31, 12), (12, 31)] {
        for diagonal in DIAGONALS {
            let drawn = Drawn::grid(w, h, diagonal);
            let straight = drawn.cloth();
            for _ in 0..5 {
                let shuffled = drawn.shuffled(&mut random);
                let mut cloth = shuffled.cloth();
                for (vertex, p) in cloth.vertices.iter().zip(&shuffled.positions) {
                    assert_eq!(cloth.particles[*vertex as usize].position, *p);
                }
                cloth.vertices.clone_from(&straight.vertices);
                assert_eq!(cloth.particles, straight.particles);
                assert_eq!(cloth.distances, straight.distances);
                assert_eq!(cloth.triangles, straight.triangles);
            }
        }
    }
}

#[test]
fn a_square_grid_is_numbered_as_the_recipe_of_a_rectangle_numbers_it() {
    let drawn = Drawn::grid(20, 20, DIAGONALS[0]).shuffled(&mut Random::new(1));
    let welded = drawn.weld();
    for (i, p) in welded.positions.iter().enumerate() {
        let (column, row) = (i % 20, i / 20);
        assert_eq!(*p, Vec3::new(column as f32 * 0.1, row as f32 * -0.1, 0.0));
    }
}

#[test]
fn a_grid_is_one_however_it_is_bent_stretched_or_sheared() {
    let bends: [fn(Vec3) -> Vec3; 6] = [
        |p| Vec3::new(libm::sinf(p.x) * 2.0, p.y, libm::cosf(p.x) * 2.0),
        |p| Vec3::new(p.x * 0.01, p.y * 100.0, 0.0),
        |p| Vec3::new(p.x + 3.0 * p.y, p.y, 0.0),
        |p| Vec3::new(p.x * p.x, -p.y * p.y, p.x * p.y),
        // A disc, where the corners have no right angles.
        |p| {
            let q = Vec3::new(p.x - 1.0, p.y + 0.7, 0.0) * Vec3::new(1.0, 1.0 / 0.7, 1.0);
            let edge = q.abs().max_element();
            if edge == 0.0 { q } else { q / q.length() * edge }
        },
        |p| p + 0.03 * Vec3::new(libm::sinf(91.0 * p.y), libm::sinf(77.0 * p.x), 0.0),
    ];
    let mut random = Random::new(7);
    for bend in bends {
        for diagonal in DIAGONALS {
            let drawn = Drawn::grid(21, 15, diagonal).bent(bend);
            let straight = drawn.weld();
            assert_rows(&straight, 21, 15);
            let shuffled = drawn.shuffled(&mut random).weld();
            assert_eq!(shuffled, Weld { vertices: shuffled.vertices.clone(), ..straight });
        }
    }
}

#[test]
fn the_distances_of_a_grid_run_in_step() {
    let cloth = Drawn::grid(64, 64, DIAGONALS[0]).shuffled(&mut Random::new(8)).cloth();
    let breaks = cloth.distances.windows(2).filter(|two| {
        let same = two[0].b - two[0].a == two[1].b - two[1].a;
        !same || two[1].a < two[0].a
    });
    // Three families of threads and three of folds.
    assert_eq!(breaks.count(), 5);
    let soft = cloth.distances.iter().position(|d| d.softness != Softness::Hard).unwrap();
    assert_eq!(soft, 63 * 64 * 2 + 63 * 63, "threads come first");
}

#[test]
fn what_is_not_quite_a_grid_comes_in_an_order_of_short_ties() {
    let mut random = Random::new(9);
    let full = Drawn::grid(24, 24, DIAGONALS[0]);
    let without = |gone: &[usize]| Drawn {
        positions: full.positions.clone(),
        triangles: (0..)
            .zip(&full.triangles)
            .filter(|(i, _)| !gone.contains(i))
            .map(|(_, t)| *t)
            .collect(),
    };
    let cell = |x: usize, y: usize| [2 * (y * 23 + x), 2 * (y * 23 + x) + 1];
    let mut seam = full.shuffled(&mut random);
    seam.positions = full.positions.clone();
    seam.triangles = full.triangles.clone();
    // A cylinder: the last column is identified with the first.
    let tube = |i: u32| if i % 24 == 23 { i - 23 } else { i };
    seam.triangles.iter_mut().flatten().for_each(|i| *i = tube(*i));
    let cases = [
        ("a cell inside is missing", without(&cell(10, 12)), 26),
        ("a cell at the border is missing", without(&cell(10, 0)), 26),
        ("a corner cell is missing", without(&cell(0, 0)), 26),
        ("half a cell is missing", without(&[700]), 26),
        ("half a corner is missing", without(&[0]), 26),
        ("a cylinder", seam, 40),
        ("a globe", Drawn::globe(24, 22), 40),
    ];
    for (name, drawn, most) in cases {
        for shuffled in [drawn.shuffled(&mut random), drawn.shuffled(&mut random)] {
            let welded = shuffled.weld();
            assert_eq!(welded.pieces.len(), 1);
            assert_eq!(welded.pieces[0].columns, None, "{name}");
            let before = bandwidth(&numbered_as_they_come(&shuffled));
            let after = bandwidth(&welded.edges);
            println!("{name}: bandwidth {before} before, {after} after");
            assert!(before > 400 && after <= most, "{name}: {before} {after}");
            for (vertex, p) in welded.vertices.iter().zip(&shuffled.positions) {
                if shuffled
                    .triangles
                    .iter()
                    .flatten()
                    .any(|&i| shuffled.positions[i as usize] == *p)
                {
                    assert_eq!(welded.positions[*vertex as usize], *p);
                }
            }
            assert_eq!(welded, shuffled.weld());
        }
    }
}

fn numbered_as_they_come(drawn: &Drawn) -> Vec<[u32; 2]> {
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    drawn.triangles.iter().flat_map(sides).map(sorted).collect()
}

#[test]
fn a_globe_that_comes_in_rings_stays_in_rings() {
    let drawn = Drawn::globe(24, 22);
    let welded = drawn.weld();
    assert_eq!(welded.positions, drawn.positions);
    assert!(bandwidth(&welded.edges) <= 48);
}

#[test]
fn several_pieces_are_numbered_each_by_itself() {
    let [mut all, low, globe] =
        [Drawn::grid(9, 12, DIAGONALS[2]), Drawn::grid(20, 3, DIAGONALS[0]), Drawn::globe(8, 6)];
    for (number, other) in (1..).zip([low, globe]) {
        let first = all.positions.len() as u32;
        all.positions.extend(other.positions.iter().map(|p| *p + Vec3::Z * 10.0 * number as f32));
        all.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    let mut random = Random::new(10);
    for _ in 0..10 {
        let welded = all.shuffled(&mut random).weld();
        let mut sizes: Vec<_> =
            welded.pieces.iter().map(|p| (p.particles.len(), p.columns)).collect();
        sizes.sort_unstable();
        assert_eq!(sizes, [(50, None), (60, Some(20)), (108, Some(12))]);
        let ends = welded.pieces.iter().map(|p| p.particles.end);
        assert!(
            welded.pieces.iter().map(|p| p.particles.start).eq([0].into_iter().chain(ends).take(3))
        );
        for [a, b] in &welded.edges {
            let home = |i: &u32| welded.pieces.iter().position(|p| p.particles.contains(i));
            assert_eq!(home(a), home(b));
        }
    }
}

#[test]
fn fans_and_strips_take_no_longer_than_they_should() {
    // A fan of 20 000 triangles about one particle, so that all other particles are on the border.
    let corners = 20_000_u32;
    let angle = |i: u32| 2.0 * core::f32::consts::PI * i as f32 / corners as f32;
    let mut positions = vec![Vec3::ZERO];
    positions.extend(
        (0..corners).map(|i| Vec3::new(libm::cosf(angle(i)), libm::sinf(angle(i)), 0.0) * 100.0),
    );
    let triangles = (0..corners).map(|i| [0, 1 + i, 1 + (i + 1) % corners]).collect();
    let fan = Drawn { positions, triangles };
    assert_eq!(fan.weld().pieces[0].columns, None);
    assert_eq!(fan.shuffled(&mut Random::new(2)).weld().edges.len(), 40_000);
    let ribbon = Drawn::grid(10_000, 2, DIAGONALS[2]).shuffled(&mut Random::new(3)).weld();
    assert_rows(&ribbon, 10_000, 2);
}
