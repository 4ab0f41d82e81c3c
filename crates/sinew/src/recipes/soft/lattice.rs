//! A body that is soft throughout: a lattice of tetrahedra, with springs along the edges and volume constraints.

use std::collections::BTreeMap;

use glam::{DVec3, UVec3, Vec3};

use super::{DAMPING_RATIOS, damped, sound};
use crate::constraints::{Constraint, ConstraintKind, Distance, Tetrahedron};
use crate::particles::ParticleSeed;
use crate::recipes::blueprint::{Blueprint, rest_length};
use crate::recipes::fault::{RecipeFault, check_particles, ensure};
use crate::recipes::limits::{LENGTHS, MAX_PARTICLES};
use crate::recipes::solid::Bulk;
use crate::settings::BodySettings;

/// A soft box or ball. The default is a cube of jelly, 1 m and 100 kg, in 4×4×4 cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftLatticeSpec {
    /// Shape and resolution; centred on the origin.
    pub shape: SoftShape,
    /// Mass or density. Default 100 kg.
    pub bulk: Bulk,
    /// Young's modulus, Pa, 1e-3 to 1e12. Default 2e4 (gelatine 1e3 to 1e5, rubber 1e6).
    ///
    /// Let sound travel at `√(E/ρ)` for the density ρ. In substeps in which it crosses less than an eighth of the shortest edge (the Courant number), the body
    /// needs only [one sweep](BodySettings::single_sweep_below), which gives the same motion as more would: the strain of a pile of jelly cubes agrees to a
    /// fortieth. In longer substeps it uses the world's sweeps. Where sound crosses more than half of an edge in a substep, the body needs more sweeps, or is
    /// softer than specified.
    pub stiffness: f32,
    /// Poisson's ratio: sideways expansion when it is squashed, 0.25 to 0.49. Default 0.35. Near 0.5 the material keeps its volume, and a coarse lattice
    /// becomes too stiff.
    pub poisson: f32,
    /// Damping ratio of every constraint, 0 (undamped) to 10. Default 0.3.
    pub damping: f32,
    /// Radius of every particle, metres, 0 or more. Default 0.
    pub radius: f32,
    /// Share of the velocity lost per second, 0 to 1. Default 0.
    pub drag: f32,
}

/// The shape of a soft lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SoftShape {
    /// A box.
    Box {
        /// Lengths of its edges, metres, 1e-6 to 1e6.
        size: Vec3,
        /// Cells along each axis, at least 1. Best near cubes: a cell more than 1.2 times as long as it is wide is too stiff in its long direction.
        cells: UVec3,
    },
    /// A ball of shells around a central particle.
    Ball {
        /// Radius, metres, 1e-6 to 1e6.
        radius: f32,
        /// Cells across the diameter, at least 1; rounded up to an even number.
        cells: u32,
    },
}

/// The surface of a soft lattice as a render mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoftSurface {
    /// Its vertices, metres.
    pub positions: Vec<Vec3>,
    /// Vertex indices, three for each triangle, counter-clockwise from outside.
    pub indices: Vec<u32>,
    /// The particle that each vertex follows.
    pub vertices: Vec<u32>,
}

/// Points, and the tetrahedra between them, each with positive volume.
struct Lattice {
    /// Positions, metres.
    points: Vec<DVec3>,
    tetrahedra: Vec<[u32; 4]>,
    /// Stiffness of each edge for a shear modulus of 1 Pa, metres.
    ties: BTreeMap<[u32; 2], f64>,
}

impl Default for SoftLatticeSpec {
    fn default() -> Self {
        Self {
            shape: SoftShape::Box { size: Vec3::ONE, cells: UVec3::splat(4) },
            bulk: Bulk::Mass(100.0),
            stiffness: 2e4,
            poisson: 0.35,
            damping: 0.3,
            radius: 0.0,
            drag: 0.0,
        }
    }
}

/// The Courant number below which a single sweep is enough. With one sweep the sag is larger by some twice the square of it: for a cube of jelly by 22 % at a
/// half, by 8 % at a quarter, by 3.5 % here.
const COURANT: f64 = 1.0 / 8.0;

/// Builds a lattice of tetrahedra that is soft throughout.
///
/// A box has a particle at each corner of each cell, x fastest, then y, then z, and five tetrahedra a cell, oriented such that neighbouring cells share whole
/// faces. A ball has shells of particles, the central one first. A particle has a quarter of the mass of each tetrahedron around it. [`Blueprint::triangles`]
/// are the surface, and [`Blueprint::vertices`] the particles of [`soft_lattice_mesh`].
///
/// # Stiffness of the edges
///
/// Springs along the edges of a lattice alone make a material with equal Lamé constants, `λ = μ` (Cauchy: central forces cannot distinguish them), that is,
/// with a Poisson's ratio of 1/4. The energy of the springs `kₑ` in a strain `ε` is `½ Σ kₑ Lₑ² (n·εn)²`.
///
/// For a cell `a × b × c` of volume `V` with one diagonal in each face, averaged over the two choices, that equals the energy of the material, `V μ (ε:ε + ½
/// (tr ε)²)`, for every strain at once, if
///
/// ```text
/// k_xy = μ V (1/a² + 1/b²)   along the diagonals in xy     k_x = μ V (3/a² - 1/b² - 1/c²)   along the edges in x
/// ```
///
/// and likewise for the others; for a cube, `2μa` and `μa`. An edge at the surface belongs to fewer cells and gets less. In a ball, where edges point in all
/// directions, the mean of `(n·εn)²` over all directions, `((tr ε)² + 2 ε:ε)/15`, gives `kₑ = 2.5 μ V/Lₑ²` for each of the six edges of each tetrahedron.
///
/// A tetrahedron cannot bend by itself, so a body `n` cells thick is too stiff in bending by a share of about `1/n²`.
///
/// The remainder, `λ - μ`, comes from the volumes: `½ (λ - μ) (V - V₀)²/V₀` is the energy of a volume constraint of compliance `V₀/(λ - μ)`.
///
/// # Errors
/// A [`RecipeFault`] if a value is out of range.
pub fn soft_lattice(spec: &SoftLatticeSpec) -> Result<Blueprint, RecipeFault> {
    let lattice = lattice_of(spec)?;
    let places: Vec<Vec3> = lattice.points.iter().map(|p| p.as_vec3()).collect();
    let volumes: Vec<f64> = lattice.tetrahedra.iter().map(|t| lattice.volume(t)).collect();
    let volume = volumes.iter().sum::<f64>();
    let density = spec.bulk.mass_of(volume)? / volume;
    let mut masses = vec![0.0; places.len()];
    for (t, volume) in lattice.tetrahedra.iter().zip(&volumes) {
        t.iter().for_each(|&i| masses[i as usize] += 0.25 * density * volume);
    }
    let seed = |(p, m): (&Vec3, &f64)| {
        let seed = ParticleSeed::at(*p).with_mass(*m as f32);
        seed.with_radius(spec.radius).with_drag(spec.drag)
    };
    let mut body = Blueprint {
        particles: places.iter().zip(&masses).map(seed).collect(),
        ..Blueprint::default()
    };
    let (young, poisson) = (f64::from(spec.stiffness), f64::from(spec.poisson));
    let shear = young / (2.0 * (1.0 + poisson));
    // At a Poisson's ratio of 1/4 nothing is left for the volumes, but they also restore an inverted tetrahedron, so a minimum is kept.
    let bulk = (shear * (4.0 * poisson - 1.0) / (1.0 - 2.0 * poisson)).max(0.05 * shear);
    for (&[a, b], tie) in &lattice.ties {
        let inverse = [a, b].iter().map(|&i| 1.0 / masses[i as usize]).sum();
        let softness = damped(1.0 / (shear * tie), inverse, spec.damping);
        let rest = rest_length(places[a as usize], places[b as usize]);
        body.distances.push(Distance::new(a, b, rest).with_softness(softness));
    }
    for (&t, &volume) in lattice.tetrahedra.iter().zip(&volumes) {
        let corners = t.map(|i| places[i as usize]);
        let faces = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]].map(|f| f.map(|k| corners[k]));
        // The gradient by a corner has a third of the area of the opposite face as its length.
        let gradients =
            faces.map(|[a, b, c]| (b - a).as_dvec3().cross((c - a).as_dvec3()).length() / 6.0);
        let inverse = t.iter().zip(gradients).map(|(&i, g)| g * g / masses[i as usize]).sum();
        let softness = damped(volume / bulk, inverse, spec.damping);
        let kind = ConstraintKind::Tetrahedron(Tetrahedron::of(corners).with_softness(softness));
        body.constraints.push(Constraint::new(t, kind));
    }
    let shortest = body.distances.iter().map(|d| f64::from(d.rest)).fold(f64::INFINITY, f64::min);
    let below = COURANT * shortest / (young / density).sqrt();
    body.settings =
        BodySettings { single_sweep_below: Some(below as f32), ..BodySettings::default() };
    let surface = lattice.surface();
    body.triangles = surface;
    body.vertices = outer(&body.triangles);
    sound(body)
}

/// The surface of [`soft_lattice`] as a render mesh, with one vertex for each particle on it, in the order of [`Blueprint::vertices`]. Fails for the same
/// specs.
pub fn soft_lattice_mesh(spec: &SoftLatticeSpec) -> Result<SoftSurface, RecipeFault> {
    let body = soft_lattice(spec)?;
    let positions = body.vertices.iter().map(|&i| body.particles[i as usize].position).collect();
    // Every corner is among the vertices, which are sorted.
    let number = |i: &u32| body.vertices.partition_point(|v| v < i) as u32;
    let indices = body.triangles.iter().flatten().map(number).collect();
    Ok(SoftSurface { positions, indices, vertices: body.vertices })
}

fn lattice_of(spec: &SoftLatticeSpec) -> Result<Lattice, RecipeFault> {
    ensure((1e-3..=1e12).contains(&spec.stiffness), RecipeFault::Stiffness)?;
    ensure((0.25..=0.49).contains(&spec.poisson), RecipeFault::Poisson)?;
    ensure(DAMPING_RATIOS.contains(&spec.damping), RecipeFault::DampingRatio)?;
    check_particles(spec.radius, spec.drag)?;
    let check = |lengths: &[f32], cells: u32, count: u64| {
        ensure(lengths.iter().all(|length| LENGTHS.contains(length)), RecipeFault::Size)?;
        ensure(cells > 0, RecipeFault::NoCells)?;
        ensure(count <= MAX_PARTICLES, RecipeFault::TooMany)
    };
    match spec.shape {
        SoftShape::Box { size, cells } => {
            let count =
                cells.to_array().iter().map(|&n| u64::from(n) + 1).fold(1, u64::saturating_mul);
            check(&size.to_array(), cells.min_element(), count)?;
            Ok(block(size.as_dvec3(), cells))
        }
        SoftShape::Ball { radius, cells } => {
            let shells = cells.div_ceil(2);
            // Shell k has 10 k² + 2 particles.
            let n = u64::from(shells);
            let squares = n.saturating_mul(n + 1).saturating_mul(2 * n + 1) / 6;
            let count = squares.saturating_mul(10).saturating_add(2 * n + 1);
            check(&[radius], cells, count)?;
            Ok(ball(f64::from(radius), shells))
        }
    }
}

impl Lattice {
    /// Adds a tetrahedron, oriented such that its volume is positive.
    pub(super) fn push(&mut self, [a, b, c, d]: [u32; 4]) {
        let t = [a, b, c, d];
        self.tetrahedra.push(if self.volume(&t) < 0.0 { [b, a, c, d] } else { t });
    }

    /// Adds to the stiffness of the edge between two points.
    pub(super) fn tie(&mut self, a: u32, b: u32, stiffness: f64) {
        *self.ties.entry([a.min(b), a.max(b)]).or_insert(0.0) += stiffness;
    }

    /// Signed volume, m³.
    pub(super) fn volume(&self, t: &[u32; 4]) -> f64 {
        let [a, b, c, d] = t.map(|i| self.points[i as usize]);
        (b - a).cross(c - a).dot(d - a) / 6.0
    }

    /// The faces that belong to only one tetrahedron, with outward winding, sorted by their corners.
    fn surface(&self) -> Vec<[u32; 3]> {
        let outward = |&[a, b, c, d]: &[u32; 4]| [[a, c, b], [a, b, d], [a, d, c], [b, c, d]];
        let key = |face: [u32; 3]| {
            let mut sorted = face;
            sorted.sort_unstable();
            (sorted, face)
        };
        let mut faces: Vec<_> = self.tetrahedra.iter().flat_map(outward).map(key).collect();
        faces.sort_unstable();
        let alone = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
        alone.map(|same| same[0].1).collect()
    }
}

/// The corners of some triangles, without duplicates, sorted.
fn outer(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut corners: Vec<u32> = triangles.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// Minimum stiffness of an edge, as a share of that in a cubic cell: the formula gives a negative value for a cell that is too long.
const MIN_STIFFNESS: f64 = 0.05;

/// A box centred on the origin, in `cells` of five tetrahedra.
///
/// All diagonals end at points whose coordinates in cells have an even sum, so two neighbouring cells have the same diagonal in their common face. Each cell
/// consists of the tetrahedron of its four even corners, and one at each of its odd corners with the three corners next to it.
fn block(size: DVec3, cells: UVec3) -> Lattice {
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
        volume * ideal.max(MIN_STIFFNESS * inverse[axis])
    };
    // Shares of one cell: an inner edge along an axis belongs to four cells, a diagonal to two.
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

/// A ball centred on the origin, in shells: an icosahedron whose twenty sectors, nearly regular tetrahedra, are cut into as many layers as there are shells,
/// each layer projected onto its sphere.
///
/// A layer between the triangle lattices of order `k` and `k + 1` has three kinds of cells: a tetrahedron on each upright triangle of the outer lattice; an
/// octahedron between an upright triangle of the inner and an inverted one of the outer; a tetrahedron below each inverted triangle of the inner. Octahedra are
/// cut into four around their shortest diagonal. The faces between sectors are triangles of both sectors, whatever the interior is.
fn ball(radius: f64, shells: u32) -> Lattice {
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
                    // Opposite corners are three places apart.
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

/// Cuts an octahedron, whose opposite corners are three places apart, into four tetrahedra around its shortest diagonal; the first of equally short ones.
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
