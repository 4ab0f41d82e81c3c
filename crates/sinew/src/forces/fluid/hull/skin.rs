//! The data of a hull: the particles that carry it, its skin, and its rim, which is computed once.

use glam::Vec3;

use crate::coincident::first_coincident;
use crate::hash::fnv;

/// The surface mesh of a body that floats by its shape, and the particles that carry it.
///
/// Its particles do not float as balls as well, whatever their radius. The skin should be closed, or open like a boat. Triangles are counter-clockwise seen
/// from outside; a skin that is inside out as a whole is handled too.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Rows of the carriers, in the order for which the skin was made. A program that moves particles to other rows has to update them.
    pub rows: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    skin: Skin,
    rim: Vec<[u32; 2]>,
    /// Hash of the triangles and the skin.
    hash: u64,
}

/// How the skin of a hull is attached to its carriers.
#[derive(Clone, Debug, PartialEq)]
pub enum Skin {
    /// The carriers are the corners of the triangles: for boats of cloth, soft bodies, boxes with a particle at each corner.
    Carriers,
    /// The skin follows the rigid [`pose`](crate::pose::pose) of the carriers: for boxes with interior particles, bones, detailed meshes.
    Posed {
        /// Corners of the triangles in the rest frame, metres.
        vertices: Vec<Vec3>,
        /// Position of each carrier in that frame, metres, in the order of [`Hull::rows`].
        rest: Vec<Vec3>,
    },
}

/// What is wrong with a hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HullFault {
    /// It has no triangle or no particle.
    #[error("it has no triangle, or no particle that carries it")]
    Empty,
    /// A row does not exist in the simulation.
    #[error("one of its particles does not exist")]
    MissingParticle,
    /// A triangle refers to a corner that does not exist.
    #[error("one of its triangles has a corner that does not exist")]
    MissingVertex,
    /// The number of carriers differs from that for which the skin was made.
    #[error("it has not one rest position for each particle that carries it")]
    Count,
    /// A vertex or a rest position is NaN or infinite.
    #[error("one of its vertices or rest positions is not finite")]
    Number,
}

impl Hull {
    /// A hull of triangles, each with three carriers (as indices into `rows`) or three vertices of a posed skin.
    ///
    /// Vertices at exactly the same position, which meshes have where normals differ, are merged.
    ///
    /// # Errors
    /// [`HullFault`]: no row or no triangle, a triangle with a corner that does not exist, positions that are not finite, or a number of rest positions that
    /// differs from that of the rows.
    pub fn new(
        rows: Vec<u32>,
        mut triangles: Vec<[u32; 3]>,
        skin: Skin,
    ) -> Result<Self, HullFault> {
        if rows.is_empty() || triangles.is_empty() {
            return Err(HullFault::Empty);
        }
        let corners = match &skin {
            Skin::Carriers => rows.len(),
            Skin::Posed { vertices, rest } => {
                if rest.len() != rows.len() {
                    return Err(HullFault::Count);
                }
                if !vertices.iter().chain(rest).all(|x| x.is_finite()) {
                    return Err(HullFault::Number);
                }
                vertices.len()
            }
        };
        if triangles.iter().flatten().any(|&v| v as usize >= corners) {
            return Err(HullFault::MissingVertex);
        }
        if let Skin::Posed { vertices, .. } = &skin {
            let one = first_coincident(vertices);
            triangles.iter_mut().flatten().for_each(|v| *v = one[*v as usize]);
        }
        let (rim, hash) = (rim_of(&triangles), content_hash(&triangles, &skin));
        Ok(Self { rows, triangles, skin, rim, hash })
    }

    /// Why this hull cannot float among `particles` rows, or `None` if it can.
    pub fn fault(&self, particles: usize) -> Option<HullFault> {
        let carriers = match &self.skin {
            Skin::Carriers => {
                1 + self.triangles.iter().flatten().fold(0, |most, &v| most.max(v as usize))
            }
            Skin::Posed { rest, .. } => rest.len(),
        };
        if self.rows.iter().any(|&i| i as usize >= particles) {
            Some(HullFault::MissingParticle)
        } else if self.rows.len() < carriers {
            Some(HullFault::Count)
        } else {
            None
        }
    }

    /// The triangles, as indices of carriers or of vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// How the skin is attached to its carriers.
    pub fn skin(&self) -> &Skin {
        &self.skin
    }

    /// Whether it has a rim: edges with a triangle on one side only.
    pub fn is_open(&self) -> bool {
        !self.rim.is_empty()
    }

    /// Hash of its shape, whatever carries it.
    pub(crate) fn content_hash(&self) -> u64 {
        self.hash
    }

    /// The edges of the rim, each in the direction of its triangle.
    pub(super) fn rim(&self) -> &[[u32; 2]] {
        &self.rim
    }
}

fn content_hash(triangles: &[[u32; 3]], skin: &Skin) -> u64 {
    let corners = triangles.iter().flatten().copied();
    match skin {
        Skin::Carriers => fnv(corners),
        Skin::Posed { vertices, rest } => {
            let places = vertices.iter().chain(rest).flat_map(Vec3::to_array);
            fnv(corners.chain(places.map(f32::to_bits)))
        }
    }
}

/// The directed edges without a triangle that has them in the opposite direction.
fn rim_of(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<([u32; 2], i32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| if a < b { ([a, b], 1) } else { ([b, a], -1) })
        .collect();
    edges.sort_unstable();
    let mut rim = Vec::new();
    for same in edges.chunk_by(|x, y| x.0 == y.0) {
        let ([a, b], _) = same[0];
        let net: i32 = same.iter().map(|edge| edge.1).sum();
        // A triangle that repeats a corner has an edge of no length, which does not count.
        if a != b {
            let edge = if net > 0 { [a, b] } else { [b, a] };
            rim.extend((0..net.unsigned_abs()).map(|_| edge));
        }
    }
    rim
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    #[test]
    fn a_closed_skin_has_no_rim_and_an_open_one_has_the_edges_of_its_holes() {
        let hull = |triangles: &[[u32; 3]]| {
            Hull::new(vec![0, 1, 2, 3], triangles.to_vec(), Skin::Carriers).unwrap()
        };
        assert!(!hull(&TETRAHEDRON).is_open());
        let open = hull(&TETRAHEDRON[1..]);
        assert_eq!(open.rim(), [[0, 1], [2, 0], [1, 2]]);
        assert!(!hull(&[TETRAHEDRON.as_slice(), &[[1, 1, 2]]].concat()).is_open());
    }

    #[test]
    fn vertices_at_the_same_place_are_one() {
        let corner = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let vertices: Vec<Vec3> =
            TETRAHEDRON.iter().flatten().map(|&v| corner[v as usize]).collect();
        let triangles = (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let skin = Skin::Posed { vertices, rest: vec![Vec3::ZERO] };
        assert!(!Hull::new(vec![0], triangles, skin).unwrap().is_open());
    }

    #[test]
    fn a_faulty_hull_is_refused() {
        let make = |rows: &[u32], triangles: &[[u32; 3]], skin| {
            Hull::new(rows.to_vec(), triangles.to_vec(), skin)
        };
        let posed = |vertex: Vec3, rest: usize| Skin::Posed {
            vertices: vec![vertex; 3],
            rest: vec![Vec3::ZERO; rest],
        };
        let one = [[0, 1, 2]];
        assert_eq!(make(&[], &one, Skin::Carriers), Err(HullFault::Empty));
        assert_eq!(make(&[0, 1, 2], &[], Skin::Carriers), Err(HullFault::Empty));
        assert_eq!(make(&[0, 1], &one, Skin::Carriers), Err(HullFault::MissingVertex));
        assert_eq!(make(&[0], &one, posed(Vec3::X, 2)), Err(HullFault::Count));
        assert_eq!(make(&[0], &one, posed(Vec3::NAN, 1)), Err(HullFault::Number));
        let mut hull = make(&[4, 5, 6], &one, Skin::Carriers).unwrap();
        assert_eq!(hull.fault(7), None);
        assert_eq!(hull.fault(6), Some(HullFault::MissingParticle));
        hull.rows.pop();
        assert_eq!(hull.fault(7), Some(HullFault::Count));
    }
}
