//! Support hash: a hash of what a sleeper is made of, lies on, hangs on and floats by. If it changes, something was changed, added or removed, and the sleeper wakes.

use glam::{Vec3, Vec4};

use crate::collide::{BodyContacts, Collider, ContactParticipant, Frame, Material};
use crate::constraints::{Boundaries, InsideBox, Plane, Points, Softness};
use crate::forces::{Forces, Hull, Spring};
use crate::hash::fnv;
use crate::islands::{Island, member_index};
use crate::simulation::Simulation;
use crate::solve::GroupKind;

/// Tags of the kinds of parts. The hashes of parts are added up, so that their order does not matter.
const PARTICLE: u32 = 1;
const DISTANCE: u32 = 2;
const CONSTRAINT: u32 = 3;
const SPRING: u32 = 4;
const COLLIDER: u32 = 5;
const PLANE: u32 = 6;
const BODY: u32 = 7;
const BOX: u32 = 8;
const HULL: u32 = 9;
const FLATLAND: u32 = 10;
const SHAPE: u32 = 11;
const IGNORED: u32 = 12;

/// The support hash of an island or a group.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SupportHash {
    /// Of positions and of the values of constraints.
    pub(super) positions: u64,
    /// Of everything else.
    pub(super) without_positions: u64,
}

impl SupportHash {
    pub(super) fn whole(self) -> u64 {
        self.positions.wrapping_add(self.without_positions)
    }
}

impl core::ops::AddAssign for SupportHash {
    fn add_assign(&mut self, other: Self) {
        self.positions = self.positions.wrapping_add(other.positions);
        self.without_positions = self.without_positions.wrapping_add(other.without_positions);
    }
}

/// A part that has no position.
impl core::ops::AddAssign<u64> for SupportHash {
    fn add_assign(&mut self, other: u64) {
        self.without_positions = self.without_positions.wrapping_add(other);
    }
}

impl Simulation {
    /// The hash of an island: positions and masses of its particles, and its constraints, independent of where they are in the columns. Of a constraint the
    /// hash takes the value at rest, which stands for its parameters; of colliders, planes and boxes it takes those that reach into `bounds`.
    pub(super) fn support_of(&self, island: &Island, bounds: (Vec3, Vec3)) -> SupportHash {
        let (particles, plan) = (&self.particles, &self.scratch.plan);
        let members = &plan.islands.members[island.members.clone()];
        let (mut sum, mut last) = (SupportHash::default(), None);
        for (rank, &row) in (0..).zip(members) {
            let i = row as usize;
            // Position and remainder, which do not depend on the origin.
            let (place, remainder) = (particles.position(i), particles.remainder(i));
            let places = [place, remainder].map(|it| it.to_array().map(f32::to_bits));
            let own = fnv([PARTICLE, rank].into_iter().chain(places.into_iter().flatten()));
            sum.positions = sum.positions.wrapping_add(own);
            let properties = [
                particles.position[i].w,
                particles.gravity_scale[i],
                particles.charge[i],
                particles.radius[i],
                particles.damping[i],
            ];
            sum += fnv([PARTICLE, rank].into_iter().chain(bits(properties)));
        }
        // How its bodies take part in contacts.
        for &row in members {
            let body = particles.body[row as usize];
            if last.replace(body) == Some(body) {
                continue;
            }
            let Some(contacts) = self.contacts.get(body as usize) else { continue };
            // Not whether its contacts are reported: looking at a body must not wake it.
            let BodyContacts {
                material, layers, with_bodies, with_itself, surface, disabled, ..
            } = contacts;
            let kind = [BODY, layers.memberships, layers.filters];
            let switches = [with_bodies, with_itself, surface, disabled].map(|&on| u32::from(on));
            let own = kind.into_iter().chain(switches).chain(numbers_of_material(material));
            sum += fnv(own);
        }
        let rank = member_index(members);
        let (mut now, mut gradients) = (Vec::new(), Vec::new());
        for group in &plan.groups[island.groups.clone()] {
            if group.kind != GroupKind::Constraints {
                for d in &plan.distances[group.range.clone()] {
                    let kind = [DISTANCE, rank(d.a), rank(d.b), d.bound as u32];
                    let numbers = bits([d.rest]).chain(softness(d.softness));
                    sum += fnv(kind.into_iter().chain(numbers));
                }
                continue;
            }
            for c in &plan.constraints[group.range.clone()] {
                now.clear();
                now.extend(c.rows.iter().map(|&row| particles.position[row as usize]));
                gradients.clear();
                gradients.resize(now.len(), Vec3::ZERO);
                let first =
                    c.rows.first().map_or(Vec3::ZERO, |&row| particles.origin[row as usize]);
                let points = points(&now, first, island);
                let equation = c.kind.equation();
                let value = equation.evaluate(&points, &mut gradients);
                let kind = [CONSTRAINT, c.kind.rank(), equation.bound() as u32];
                let rows = c.rows.iter().map(|&row| rank(row));
                let kind = kind.into_iter().chain(rows);
                let value = fnv(kind.clone().chain(bits([value])));
                sum.positions = sum.positions.wrapping_add(value);
                sum += fnv(kind.chain(softness(equation.softness())));
            }
        }
        let is_near = |collider: &&Collider| {
            let (low, high) = collider.shape.bounds_in(&collider.end);
            bounds.0.cmple(high).all() && bounds.1.cmpge(low).all()
        };
        let colliders = self.colliders.iter().filter(|one| !one.sensor && one.is_valid());
        let Boundaries { planes, boxes, plane_constraint, .. } = &self.boundaries;
        let flatland = plane_constraint.iter().map(of_flatland);
        let planes = planes.iter().filter(|plane| plane.is_valid() && reaches(plane, bounds));
        let boxes = boxes.iter().filter(|one| one.is_valid() && is_at_wall(one, bounds));
        let near = colliders.filter(is_near).map(of_collider);
        let standing = near.chain(planes.map(of_plane)).chain(boxes.map(of_box));
        standing.chain(flatland).for_each(|hash| sum += hash);
        sum
    }

    /// Adds to the hashes of all islands the shapes that their particles collide by.
    pub(super) fn add_shapes(&self, hashes: &mut [SupportHash]) {
        let islands = &self.scratch.plan.islands;
        for solid in &self.body_colliders {
            let first = solid.rows.first().and_then(|&row| islands.of.get(row as usize));
            let Some(&number) = first else { continue };
            let members = &islands.members[islands.list[number as usize].members.clone()];
            let rank = member_index(members);
            let hash = solid.shape.content_hash();
            let rows = solid.rows.iter().map(|&row| rank(row));
            let rest = solid.rest.iter().flat_map(Vec3::to_array).map(f32::to_bits);
            let own =
                fnv([SHAPE, hash as u32, (hash >> 32) as u32].into_iter().chain(rows).chain(rest));
            hashes[number as usize] += own;
        }
    }

    /// Adds to the hashes of the islands of bodies that they ignore a collider, or a body of their group: `first_of` is the first island of each body, and
    /// `root` identifies the group of an island.
    pub(super) fn add_ignored(
        &self,
        hashes: &mut [SupportHash],
        first_of: &[u32],
        mut root: impl FnMut(u32) -> u32,
    ) {
        use ContactParticipant::{Body, Collider};
        let island = |body: u32| first_of.get(body as usize).copied().filter(|&it| it != u32::MAX);
        for pair in &self.ignored {
            let (number, own) = match *pair {
                [Body(a), Body(b)] => {
                    let (Some(a), Some(b)) = (island(a), island(b)) else { continue };
                    if root(a) != root(b) {
                        continue;
                    }
                    (a, fnv([IGNORED, BODY]))
                }
                [Body(body), Collider(other)] | [Collider(other), Body(body)] => {
                    let collider = self.colliders.get(other as usize);
                    let (Some(number), Some(collider)) = (island(body), collider) else { continue };
                    // Not where it is: what is fastened to it may move with it.
                    let hash = collider.shape.content_hash();
                    (number, fnv([IGNORED, COLLIDER, hash as u32, (hash >> 32) as u32]))
                }
                _ => continue,
            };
            hashes[number as usize] += own;
        }
    }

    /// Adds to the hashes of all islands the springs that act on them, and the hulls that they float by.
    pub(super) fn add_springs_and_hulls(&self, hashes: &mut [SupportHash]) {
        let islands = &self.scratch.plan.islands;
        for hull in &self.forces.hulls {
            for &row in &hull.rows {
                let Some(&number) = islands.of.get(row as usize) else { continue };
                let members = &islands.members[islands.list[number as usize].members.clone()];
                let own = fnv([HULL, member_index(members)(row)]
                    .into_iter()
                    .chain(words(hull.content_hash())));
                hashes[number as usize] += own;
            }
        }
        for spring in &self.forces.springs {
            for end in [spring.a, spring.b] {
                let Some(&number) = islands.of.get(end as usize) else { continue };
                let members = &islands.members[islands.list[number as usize].members.clone()];
                let own =
                    fnv([SPRING, member_index(members)(end)].into_iter().chain(numbers_of(spring)));
                hashes[number as usize] += own;
            }
        }
    }
}

/// The hash of all ignored pairs.
pub(super) fn of_ignored(ignored: &[[ContactParticipant; 2]]) -> u64 {
    let words = |one: &ContactParticipant| match *one {
        ContactParticipant::Body(number) => [0, number],
        ContactParticipant::Particle(row) => [1, row],
        ContactParticipant::Collider(number) => [2, number],
        ContactParticipant::Plane(number) => [3, number],
        ContactParticipant::Box(number) => [4, number],
    };
    fnv(ignored.iter().flatten().flat_map(words))
}

/// The hash of all springs, by the rows that they connect, and of all hulls, by the rows that carry them.
pub(super) fn of_springs_and_hulls(Forces { springs, hulls, .. }: &Forces) -> u64 {
    let each = springs
        .iter()
        .map(|spring| fnv([SPRING, spring.a, spring.b].into_iter().chain(numbers_of(spring))));
    let of_hull = |hull: &Hull| {
        let rows = hull.rows.iter().copied();
        fnv([HULL].into_iter().chain(rows).chain(words(hull.content_hash())))
    };
    each.chain(hulls.iter().map(of_hull)).fold(0, u64::wrapping_add)
}

fn words(hash: u64) -> [u32; 2] {
    [hash as u32, (hash >> 32) as u32]
}

fn numbers_of(spring: &Spring) -> impl Iterator<Item = u32> {
    bits([spring.rest, spring.stiffness, spring.damping])
}

/// Whether bounds touch a plane or are behind it.
fn reaches(plane: &Plane, (low, high): (Vec3, Vec3)) -> bool {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    plane.normal.dot(centre) - plane.normal.abs().dot(half) <= plane.offset
}

/// Whether bounds touch a wall of a box or are outside.
fn is_at_wall(inside: &InsideBox, (low, high): (Vec3, Vec3)) -> bool {
    !(inside.min.cmplt(low) & high.cmplt(inside.max)).all()
}

fn of_plane(plane: &Plane) -> u64 {
    let numbers = [plane.offset, plane.friction, plane.restitution];
    let drag = [plane.drag.along, plane.drag.across];
    fnv([PLANE]
        .into_iter()
        .chain(bits(plane.normal.to_array()))
        .chain(bits(numbers))
        .chain(bits(drag)))
}

fn of_box(inside: &InsideBox) -> u64 {
    let corners = bits(inside.min.to_array()).chain(bits(inside.max.to_array()));
    fnv([BOX].into_iter().chain(corners).chain(bits([inside.friction, inside.restitution])))
}

fn of_flatland(plane: &Plane) -> u64 {
    let numbers = bits(plane.normal.to_array()).chain(bits([plane.offset]));
    fnv([FLATLAND].into_iter().chain(numbers))
}

/// The hash of all static geometry. Moving colliders wake sleepers by coming near; in the hash they would make every step compare all supports.
pub(super) fn of_surfaces(colliders: &[Collider], boundaries: &Boundaries) -> u64 {
    let planes = boundaries.planes.iter().map(of_plane);
    let boxes = boundaries.boxes.iter().map(of_box);
    let flatland = boundaries.plane_constraint.iter().map(of_flatland);
    let standing = colliders.iter().filter(|one| !one.sensor && one.start == one.end);
    planes.chain(boxes).chain(flatland).chain(standing.map(of_collider)).fold(0, u64::wrapping_add)
}

fn of_collider(collider: &Collider) -> u64 {
    let Collider { shape, end: Frame { translation: at, rotation }, material, layers, .. } =
        collider;
    let [low, high] = words(shape.content_hash());
    let asks = u32::from(collider.events);
    let kind = [COLLIDER, asks, low, high, layers.memberships, layers.filters];
    let (place, turn) = (bits(at.to_array()), bits(rotation.to_cols_array()));
    fnv(kind.into_iter().chain(numbers_of_material(material)).chain(place).chain(turn))
}

fn numbers_of_material(material: &Material) -> impl Iterator<Item = u32> {
    let Material { friction, restitution, friction_rule, restitution_rule, drag } = *material;
    let rules = [friction_rule as u32, restitution_rule as u32];
    rules.into_iter().chain(bits([friction, restitution, drag.along, drag.across]))
}

/// The particles of a constraint at their present positions.
fn points<'a>(now: &'a [Vec4], origin: Vec3, island: &Island) -> Points<'a> {
    Points { now, starts: now, origin, gradient_at: island.settings.gradient_at }
}

fn softness(softness: Softness) -> impl Iterator<Item = u32> {
    let [kind, a, b] = match softness {
        Softness::Hard => [0.0, 0.0, 0.0],
        Softness::Compliant { compliance, damping } => [1.0, compliance, damping],
        Softness::Frequency { hertz, ratio } => [2.0, hertz, ratio],
        Softness::Share(share) => [3.0, share, 0.0],
    };
    bits([kind, a, b])
}

fn bits<const N: usize>(numbers: [f32; N]) -> impl Iterator<Item = u32> {
    numbers.into_iter().map(f32::to_bits)
}
