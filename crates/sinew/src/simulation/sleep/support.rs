//! Support hash: a hash of what a sleeper is made of, lies on and hangs on. If it changes, something was changed, added or removed, and the sleeper wakes.

use glam::{Vec3, Vec4};

use crate::collide::{BodyContacts, Collider, Frame};
use crate::constraints::{Boundaries, Points, Softness};
use crate::forces::Spring;
use crate::hash::fnv;
use crate::islands::Island;
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

impl Simulation {
    /// The hash of an island: positions and masses of its particles, and its constraints, independent of where they are in the columns. Of a constraint the
    /// hash takes the value at rest, which stands for its parameters; of colliders it takes those that reach into `bounds`.
    pub(super) fn support_of(&self, island: &Island, bounds: (Vec3, Vec3)) -> u64 {
        let (particles, plan) = (&self.particles, &self.scratch.plan);
        let members = &plan.islands.members[island.members.clone()];
        let (mut sum, mut last) = (0_u64, None);
        for (rank, &row) in (0..).zip(members) {
            let i = row as usize;
            // Position and remainder, which do not depend on the origin.
            let (place, remainder) = (particles.position(i), particles.remainder(i));
            let properties = [
                place.x,
                place.y,
                place.z,
                remainder.x,
                remainder.y,
                remainder.z,
                particles.position[i].w,
                particles.gravity_scale[i],
                particles.charge[i],
                particles.radius[i],
                particles.damping[i],
            ];
            sum = sum.wrapping_add(fnv([PARTICLE, rank].into_iter().chain(bits(properties))));
        }
        // How its bodies take part in contacts.
        for &row in members {
            let body = particles.body[row as usize];
            if last.replace(body) == Some(body) {
                continue;
            }
            let Some(contacts) = self.contacts.get(body as usize) else { continue };
            let BodyContacts { material, layers, with_bodies, disabled, .. } = contacts;
            let kind = [BODY, layers.memberships, layers.filters];
            let switches = [u32::from(*with_bodies), u32::from(*disabled)];
            let numbers = bits([material.friction, material.restitution]);
            let own = fnv(kind.into_iter().chain(switches).chain(numbers));
            sum = sum.wrapping_add(own);
        }
        let rank = |row: u32| members.partition_point(|&member| member < row) as u32;
        let (mut now, mut gradients) = (Vec::new(), Vec::new());
        for group in &plan.groups[island.groups.clone()] {
            if group.kind != GroupKind::Constraints {
                for d in &plan.distances[group.range.clone()] {
                    let kind = [DISTANCE, rank(d.a), rank(d.b), d.bound as u32];
                    let numbers = bits([d.rest]).chain(softness(d.softness));
                    sum = sum.wrapping_add(fnv(kind.into_iter().chain(numbers)));
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
                let numbers = bits([value]).chain(softness(equation.softness()));
                sum = sum.wrapping_add(fnv(kind.into_iter().chain(rows).chain(numbers)));
            }
        }
        let is_near = |collider: &&Collider| {
            let (low, high) = collider.shape.bounds_in(&collider.end);
            bounds.0.cmple(high).all() && bounds.1.cmpge(low).all()
        };
        let near = self.colliders.iter().filter(|one| !one.sensor && one.is_valid());
        near.filter(is_near).fold(sum, |sum, collider| sum.wrapping_add(of_collider(collider)))
    }

    /// Adds to the hashes of all islands the springs that act on them.
    pub(super) fn add_springs(&self, hashes: &mut [u64]) {
        let islands = &self.scratch.plan.islands;
        for spring in &self.forces.springs {
            for end in [spring.a, spring.b] {
                let Some(&number) = islands.of.get(end as usize) else { continue };
                let members = &islands.members[islands.list[number as usize].members.clone()];
                let rank = members.partition_point(|&member| member < end) as u32;
                let own = fnv([SPRING, rank].into_iter().chain(numbers_of(spring)));
                hashes[number as usize] = hashes[number as usize].wrapping_add(own);
            }
        }
    }
}

/// The hash of all springs, by the rows that they connect.
pub(super) fn of_springs(springs: &[Spring]) -> u64 {
    let each = springs
        .iter()
        .map(|spring| fnv([SPRING, spring.a, spring.b].into_iter().chain(numbers_of(spring))));
    each.fold(0, u64::wrapping_add)
}

fn numbers_of(spring: &Spring) -> impl Iterator<Item = u32> {
    bits([spring.rest, spring.stiffness, spring.damping])
}

/// The hash of all static geometry. Moving colliders wake sleepers by coming near; in the hash they would make every step compare all supports.
pub(super) fn of_surfaces(colliders: &[Collider], boundaries: &Boundaries) -> u64 {
    let planes = boundaries.planes.iter().map(|plane| {
        let n = plane.normal;
        let numbers = [n.x, n.y, n.z, plane.offset, plane.friction, plane.restitution];
        fnv([PLANE].into_iter().chain(bits(numbers)))
    });
    let standing = colliders.iter().filter(|one| !one.sensor && one.start == one.end);
    planes.chain(standing.map(of_collider)).fold(0, u64::wrapping_add)
}

fn of_collider(collider: &Collider) -> u64 {
    let Collider { shape, end: Frame { translation: at, rotation }, material, layers, .. } =
        collider;
    let hash = shape.content_hash();
    let asks = u32::from(collider.events);
    let kind =
        [COLLIDER, asks, hash as u32, (hash >> 32) as u32, layers.memberships, layers.filters];
    let surface = [
        material.friction,
        material.restitution,
        material.drag.along,
        material.drag.across,
        at.x,
        at.y,
        at.z,
    ];
    let turn = rotation.to_cols_array();
    fnv(kind.into_iter().chain(bits(surface)).chain(bits(turn)))
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
