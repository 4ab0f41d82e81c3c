//! Contacts of eight bodies with planes and surfaces, by the same formulas as [`project_island`](crate::collide::ParticleContacts::project_island).
//!
//! Every particle is tested against every plane, so planes are solved in lanes, operation by operation as for one particle. Surfaces of colliders touch few
//! rows of few bodies. Those rows are copied out of the lanes, projected by the same code as any other row, and copied back. If a particle of a body has left
//! its skin since contacts were last searched for, all rows of that body are tested.

use core::ops::Range;

use glam::{Vec3, Vec4};

use super::lane_storage::LaneStorage;
use crate::collide::{NormalImpulses, contact_correction};
use crate::constraints::Plane;
use crate::lanes::{LANES, Lanes, SetLanes, Vector, kernel};
use crate::particles::Places;
use crate::solve::context::{SolveContext, SubstepParameters};
use crate::solve::lane_particles::LaneParticles;

/// What is needed to project rows out of surfaces.
#[derive(Clone, Copy)]
pub(super) struct SurfaceContext<'a> {
    pub(super) context: SolveContext<'a>,
    /// The row with which the columns below begin.
    pub(super) begin: u32,
    pub(super) origin: &'a [Vec3],
    pub(super) radius: &'a [f32],
    /// Velocities of the rows before the substep, m/s; `None` if they are in the lane storage.
    pub(super) velocity: Option<&'a [Vec4]>,
}

impl SurfaceContext<'_> {
    /// Whether a row of a body in this storage may touch a surface, as long as no particle leaves its skin.
    pub(super) fn touches(&self, storage: &LaneStorage) -> bool {
        let touching = |&island: &u32| self.context.contacts.touching(island as usize);
        storage.islands[..storage.bodies]
            .iter()
            .any(|island| touching(island).is_none_or(|rows| !rows.is_empty()))
    }

    /// Projects the rows of the bodies in `going` out of all surfaces once, with friction. Returns the deepest penetration of each body, metres.
    pub(super) fn project(
        &self,
        storage: &mut LaneStorage,
        normal_impulses: &mut NormalImpulses,
        going: u32,
    ) -> [f32; LANES] {
        let SolveContext { contacts, execution, .. } = self.context;
        let interval = self.context.interval();
        let exceeded = skin_exceeded(storage, execution.instructions);
        let mut deepest = [0.0; LANES];
        for lane in SetLanes(going & storage.mask()) {
            let own = self.rows(storage, lane);
            let touching = contacts.touching(storage.islands[lane] as usize);
            let touching = touching.filter(|_| exceeded >> lane & 1 == 0);
            let (first, count) = (own.start, touching.map_or(own.len(), <[u32]>::len));
            let mut depth = 0.0_f32;
            for n in 0..count {
                let row = touching.map_or(first + n as u32, |touching| touching[n]);
                let found = self.at_row(storage, (lane, row, first), |places| {
                    contacts.project_row(places, normal_impulses, row, interval)
                });
                depth = depth.max(found);
            }
            deepest[storage.copies(lane)].fill(depth);
        }
        deepest
    }

    /// Applies restitution to the rows that touched something, after the velocities in the lanes have been derived.
    pub(super) fn bounce(&self, storage: &mut LaneStorage, normal_impulses: &mut NormalImpulses) {
        let SolveContext { contacts, substep: SubstepParameters { h, .. }, .. } = self.context;
        for lane in 0..storage.bodies {
            let own = self.rows(storage, lane);
            let touching = contacts.touching(storage.islands[lane] as usize).unwrap_or_default();
            let mut bounce = |row| {
                self.at_row(storage, (lane, row, own.start), |places| {
                    contacts.bounce(places, normal_impulses, row..row + 1, h);
                });
            };
            if contacts.any_late() {
                own.clone().for_each(bounce);
            } else {
                touching.iter().for_each(|&row| bounce(row));
            }
        }
    }

    /// The rows of the body in a lane.
    fn rows(&self, storage: &LaneStorage, lane: usize) -> Range<u32> {
        let plan = self.context.plan;
        let island = &plan.islands.list[storage.islands[lane] as usize];
        let first = plan.islands.members[island.members.start];
        first..first + island.members.len() as u32
    }

    /// Copies a `row` of the body in `lane` out of the storage, calls `work` with it, and writes its position and velocity back. `first` is the body's first
    /// row.
    #[inline]
    fn at_row<T>(
        &self,
        storage: &mut LaneStorage,
        (lane, row, first): (usize, u32, u32),
        work: impl FnOnce(&mut Places) -> T,
    ) -> T {
        let (member, place) = ((row - first) as usize, (row - self.begin) as usize);
        let was = storage.now[member].lane(lane);
        let mut now = [was];
        let mut start = [storage.start[member].lane(lane)];
        // Compacted lanes have no velocities; nothing that runs on them reads any.
        let column = self.velocity.is_none().then(|| storage.velocity.get(member)).flatten();
        let own = column.map(|column| column.lane(lane));
        let outside = self.velocity.map(|column| column[place]);
        let before = own.or(outside).unwrap_or_default();
        let mut velocity = [before];
        let mut places = Places {
            first: row,
            position: &mut now,
            start: &mut start,
            origin: &self.origin[place..=place],
            radius: &self.radius[place..=place],
            velocity: &mut velocity,
        };
        let out = work(&mut places);
        let copies = storage.copies(lane);
        let put = |column: &mut LaneParticles, to: Vec4| {
            copies.clone().for_each(|lane| column.set_lane(lane, to.truncate()));
        };
        if now[0] != was {
            put(&mut storage.now[member], now[0]);
        }
        if own.is_some() && velocity[0] != before {
            put(&mut storage.velocity[member], velocity[0]);
        }
        out
    }
}

kernel!(
    /// One bit for each body with a particle that has left its skin.
    fn skin_exceeded<L: Lanes>(storage: &LaneStorage) -> u32 {
        let LaneStorage { now, reference, .. } = storage;
        let mut exceeded = L::zero();
        for (now, reference) in now.iter().zip(reference) {
            let (now, (reference, most)) =
                (Vector::of(now.load::<L>()).0, Vector::of(reference.load::<L>()));
            exceeded = exceeded.or(most.lt((now - reference).length_squared()));
        }
        exceeded.bits()
    }
);

kernel!(
    /// Projects all particles of the bodies in `going` out of all planes once, with friction. Returns the deepest penetration of each body, metres.
    pub(super) fn project_planes<L: Lanes>(
        planes: &[Plane],
        // How much of an overlap is recovered in a substep, metres.
        recover: f32,
        storage: &mut LaneStorage,
        going: u32,
    ) -> [f32; LANES] {
        let (going, mut deepest) = (L::mask(going), L::zero());
        let LaneStorage { now, start, radius, ground, .. } = storage;
        for ((now, start), radius) in now.iter_mut().zip(start).zip(radius) {
            for (plane, ground) in planes.iter().zip(ground.iter()) {
                let (p, w) = Vector::of(now.load::<L>());
                let movable = L::zero().lt(w).and(going);
                let out = plane.correction(p, L::load(radius), L::load(ground));
                let out = out.or_else(movable, Vector::zero());
                if !L::zero().lt(out.length_squared()).any() {
                    continue;
                }
                let moved = p - Vector::of(start.load::<L>()).0;
                let limits = (L::splat(plane.friction), L::splat(recover));
                let (by, depth) = contact_correction(out, moved, limits);
                now.put((p + by).or_else(L::zero().lt(depth), p).with(w));
                deepest = depth.max(deepest);
            }
        }
        deepest.array()
    }
);
