//! Participants: the triangles of bodies with surfaces, their corners and edges, and the particles that may touch them.

use glam::{DVec3, Vec3};

use super::super::filter::ContactFilter;
use super::super::nearby::Nearby;
use crate::particles::Particles;

/// The participants. Members (particles) are numbered in the order of their rows, and triangles are sorted by their members: neither the order in which
/// triangles are given nor their orientation has an effect.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleParticipants {
    /// Row of each member, ascending.
    pub(super) rows: Vec<u32>,
    /// Body of each member.
    pub(super) body: Vec<u32>,
    /// Metres.
    pub(super) radius: Vec<f32>,
    /// Position in the rest shape of the body, metres; NaN where there is none. Empty if no particle has any.
    pub(super) rest: Vec<Vec3>,
    /// Members of each triangle, ascending; sorted, without duplicates.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Features that each triangle owns, a bit each: those of its corners and then of its [`EDGES`] that no triangle before it has.
    pub(super) own: Vec<u8>,
    /// Members that are not corners of a triangle.
    pub(super) loose: Vec<u32>,
    /// Member number of each row.
    number: Vec<u32>,
    /// Where the edges of each lower end begin; and the higher end of each edge, with the bit in `own` that stands for it.
    begins: Vec<u32>,
    edges: Vec<(u32, u32)>,
    /// Triangles sorted by each corner, and where those of each member begin; both empty until [`index_triangles`](Self::index_triangles).
    of_corners: Vec<u32>,
    corner_begins: Vec<u32>,
}

/// The corners that each edge of a triangle joins.
pub(super) const EDGES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

/// Upper bound of the sum of a quantity at a point of each feature: of the particle and any corner of the triangle, or of any end of either edge.
#[inline(always)]
pub(super) fn largest(of: &[f32], [i, j, k, l]: [u32; 4], edges: bool) -> f32 {
    let (a, b, c, d) = (of[i as usize], of[j as usize], of[k as usize], of[l as usize]);
    if edges { a.max(b) + c.max(d) } else { a + b.max(c).max(d) }
}

/// Number of a row that is not a member.
const NOT_A_MEMBER: u32 = u32::MAX;

/// Number of a row that is a corner, before it is numbered.
const CORNER: u32 = u32::MAX - 1;

impl TriangleParticipants {
    /// Collects the participants of the bodies that are near others. Keeps allocations. There are none if there is no triangle.
    pub(super) fn collect(
        &mut self,
        particles: &Particles,
        surfaces: &[[u32; 3]],
        (filter, nearby): (&ContactFilter, &Nearby),
        excluded: &[bool],
    ) {
        for column in [&mut self.rows, &mut self.body, &mut self.loose] {
            column.clear();
        }
        self.radius.clear();
        self.rest.clear();
        self.triangles.clear();
        self.own.clear();
        self.of_corners.clear();
        self.corner_begins.clear();
        let has_surface = |body: u32| nearby.to_particles().has(body) && filter.body(body).surface;
        let any = (0..filter.bodies().len() as u32).any(has_surface);
        if surfaces.is_empty() || !any {
            return;
        }
        let is_loose = |row: usize| excluded.get(row) != Some(&true);
        for corners in surfaces {
            let mut corners = *corners;
            corners.sort_unstable();
            let [a, b, c] = corners.map(|row| row as usize);
            if a == b || b == c || c >= particles.len() {
                continue;
            }
            let body = particles.body[a];
            let one = particles.body[b] == body && particles.body[c] == body;
            if !(one && has_surface(body) && [a, b, c].iter().all(|&row| is_loose(row))) {
                continue;
            }
            let place = |row: usize| particles.origin[row] + particles.position[row].truncate();
            if nearby.to_particles().has_hull(body, [place(a), place(b), place(c)]) {
                self.triangles.push(corners);
            }
        }
        if self.triangles.is_empty() {
            return;
        }
        self.triangles.sort_unstable();
        self.triangles.dedup();
        self.number_rows(particles, nearby, is_loose);
        self.share_out();
    }

    /// Numbers the members, and replaces the rows of triangles by them.
    fn number_rows(
        &mut self,
        particles: &Particles,
        nearby: &Nearby,
        is_loose: impl Fn(usize) -> bool,
    ) {
        let Self { rows, body, radius, rest, triangles, loose, number, .. } = self;
        number.clear();
        number.resize(particles.len(), NOT_A_MEMBER);
        for &row in triangles.iter().flatten() {
            number[row as usize] = CORNER;
        }
        let columns = particles.body.iter().zip(&particles.radius);
        for (row, ((&its_body, &its_radius), number)) in columns.zip(&mut *number).enumerate() {
            if *number != CORNER {
                // A NaN radius excludes a particle, too.
                let takes_part = nearby.to_particles().has_particle(row, its_body);
                if !(takes_part && its_radius > 0.0 && is_loose(row)) {
                    continue;
                }
                loose.push(rows.len() as u32);
            }
            *number = rows.len() as u32;
            rows.push(row as u32);
            body.push(its_body);
            radius.push(if its_radius > 0.0 { its_radius } else { 0.0 });
        }
        for corner in triangles.iter_mut().flatten() {
            *corner = number[*corner as usize];
        }
        if !particles.rest.is_empty() {
            rest.extend(rows.iter().map(|&row| particles.rest[row as usize]));
        }
    }

    /// Whether these participants equal others in everything that the neighbour list depends on, except positions.
    pub(super) fn is_same_as(&self, others: &Self) -> bool {
        // What each triangle owns follows from the triangles; NaN equals itself here.
        let bits = |rest: &[Vec3]| -> bool {
            let each = rest.iter().zip(&others.rest);
            rest.len() == others.rest.len()
                && each
                    .into_iter()
                    .all(|(a, b)| a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits))
        };
        self.rows == others.rows
            && self.body == others.body
            && self.radius == others.radius
            && self.triangles == others.triangles
            && self.loose == others.loose
            && bits(&self.rest)
    }

    /// Sorts the triangles by their corners, unless they are.
    pub(super) fn index_triangles(&mut self) {
        let Self { rows, triangles, of_corners, corner_begins, .. } = self;
        if !corner_begins.is_empty() {
            return;
        }
        corner_begins.resize(rows.len() + 2, 0);
        for &corner in triangles.iter().flatten() {
            corner_begins[corner as usize + 2] += 1;
        }
        for i in 2..corner_begins.len() {
            corner_begins[i] += corner_begins[i - 1];
        }
        of_corners.resize(3 * triangles.len(), 0);
        for (triangle, corners) in (0..).zip(&*triangles) {
            for &corner in corners {
                // Filling advances each beginning to the next one's.
                let at = &mut corner_begins[corner as usize + 1];
                of_corners[*at as usize] = triangle;
                *at += 1;
            }
        }
    }

    /// The triangles of a member, ascending, once they are [indexed](Self::index_triangles).
    pub(super) fn triangles_of(&self, member: u32) -> &[u32] {
        let ends = [0, 1].map(|next| self.corner_begins[member as usize + next] as usize);
        &self.of_corners[ends[0]..ends[1]]
    }

    /// Assigns each corner and each edge to the first triangle that has it.
    fn share_out(&mut self) {
        let Self { rows, triangles, own, number, begins, edges, .. } = self;
        own.resize(triangles.len(), 0);
        // Corners. `number` is no longer needed, and serves as scratch.
        number.clear();
        number.resize(rows.len(), NOT_A_MEMBER);
        begins.clear();
        begins.resize(rows.len() + 1, 0);
        for (triangle, own) in triangles.iter().zip(&mut *own) {
            for (place, &corner) in triangle.iter().enumerate() {
                let owner = &mut number[corner as usize];
                if *owner == NOT_A_MEMBER {
                    *owner = corner;
                    *own |= 1 << place;
                }
            }
            for [low, _] in EDGES {
                begins[triangle[low] as usize + 1] += 1;
            }
        }
        // Edges: counting sort by their lower end, then each group by its higher end.
        let mut sum = 0;
        for begin in begins.iter_mut() {
            sum += *begin;
            *begin = sum;
        }
        edges.clear();
        edges.resize(3 * triangles.len(), (0, 0));
        for (which, triangle) in triangles.iter().enumerate() {
            for (place, [low, high]) in EDGES.into_iter().enumerate() {
                let at = &mut begins[triangle[low] as usize];
                edges[*at as usize] = (triangle[high], (3 * which + place) as u32);
                *at += 1;
            }
        }
        let mut begin = 0;
        // Filling has advanced each beginning to the next one's.
        for &end in &begins[..rows.len()] {
            let of_one = &mut edges[begin..end as usize];
            begin = end as usize;
            of_one.sort_unstable();
            let mut last = NOT_A_MEMBER;
            for &(high, bit) in of_one.iter() {
                if high != last {
                    own[bit as usize / 3] |= 8 << (bit % 3);
                }
                last = high;
            }
        }
    }

    /// Whether two members may touch.
    pub(super) fn may_touch(&self, filter: &ContactFilter, i: u32, j: u32) -> bool {
        let of = |i: u32| (self.body[i as usize], self.rows[i as usize]);
        filter.rows_may_touch(of(i), of(j))
    }

    /// Rest positions of members of one body, metres; `None` for two bodies, or if a member has no rest position.
    #[inline(always)]
    pub(super) fn rest_of(&self, four: [u32; 4]) -> Option<[DVec3; 4]> {
        let body = self.body[four[0] as usize];
        if self.rest.is_empty() || self.body[four[3] as usize] != body {
            return None;
        }
        let [a, b, c, d] = four;
        let at = |i: u32| self.rest[i as usize];
        let (a, b, c, d) = (at(a), at(b), at(c), at(d));
        let good = a.is_finite() && b.is_finite() && c.is_finite() && d.is_finite();
        good.then(|| [a.as_dvec3(), b.as_dvec3(), c.as_dvec3(), d.as_dvec3()])
    }
}
