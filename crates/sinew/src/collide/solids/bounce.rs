//! What is left to do after the velocities are derived: restitution, drags (`drag`), and to take off speed that is none of anybody's.
//!
//! Positions know nothing of elasticity: what is put on a surface leaves it with the speed that it lacked to get there. So where a point pressed in
//! this substep and its speed of approach before was above `2gh`, which gravity alone gives to what lies still, the speed along the normal becomes
//! `-e` times that, by an impulse between the two that conserves momentum and angular momentum. What came out of a deep overlap (see `contact`) is
//! left with no speed along the normal: of the impulse that it got, so much is taken back. Approach is taken before the last bit of the way, which is
//! less than at the surface: `e = 1` gains nothing.

use super::Solids;
use super::block::{Patch, Side, press};
use super::bodies::{Bodies, Eight as Rows};
use super::contact::{anchors, round_normals, skins};
use super::drag::{drag, dragged};
use super::found::Found;
use super::pack::{FAR, Pack};
use super::read::Read;
use super::slip::tangents;
use super::turn::{Matrix, load};
use super::write::Write;
use crate::lanes::{LANES, Lanes, Vector, Work, with};
use crate::particles::Particles;

impl Solids {
    /// Gives what bounced its velocity.
    pub(crate) fn bounce(&mut self, particles: &mut Particles, h: f32, gravity: f32) {
        let least = 2.0 * gravity * h;
        self.loose.bounce(particles, &self.groups, &self.bodies, least);
        let Self { groups, lifts, bodies, sums, instructions, shared, packs, found, .. } = self;
        let Self { bouncing, bounced, kept, gathered, .. } = self;
        bouncing.clear();
        bouncing.resize(groups.groups.len(), 0);
        bounced.clear();
        kept.clear();
        for pack in packs.iter() {
            let fast = if pack.kept { fast(pack, found, least) } else { 0 };
            let (lanes, slow) =
                (pack.popped | fast, if pack.kept { dragged(pack, found) } else { 0 });
            bounced.push([lanes, slow]);
            for lane in (0..LANES).filter(|lane| (lanes | slow) >> lane & 1 == 1) {
                for row in [pack.a[lane], pack.b[lane]] {
                    if let Some(bouncing) = bouncing.get_mut(row as usize / LANES) {
                        *bouncing |= 1 << (row as usize % LANES);
                    }
                }
            }
        }
        if bouncing.iter().all(|&lanes| lanes == 0) {
            return;
        }
        for (number, group) in groups.groups.iter().enumerate() {
            if bouncing[number] == 0 {
                continue;
            }
            kept.extend_from_slice(&bodies.rows[number * LANES..(number + 1) * LANES]);
            let read = Read {
                group,
                slots: &groups.slots[group.slots.clone()],
                lifts: lifts.of(group),
                position: &particles.position,
                other: &particles.velocity,
                fresh: true,
                bodies,
                first: number * LANES,
                sums: &mut sums[number],
                ways: None,
                gathered,
            };
            with(*instructions, read);
        }
        for (pack, &mut [lanes, _]) in
            packs.iter().zip(&mut *bounced).filter(|(_, [lanes, _])| *lanes != 0)
        {
            let restitution = core::array::from_fn(|lane| {
                found.get(pack.number[lane] as usize).map_or(0.0, |one| one.grip.restitution)
            });
            let stands = (0..LANES).filter(|&lane| {
                found.get(pack.number[lane] as usize).is_some_and(|one| one.stand.is_some())
            });
            let stands = stands.fold(0, |bits, lane| bits | 1 << lane);
            with(*instructions, Bounce { pack, lanes, stands, bodies, restitution, least, h });
        }
        for (pack, [_, slow]) in packs.iter().zip(bounced) {
            for lane in (0..LANES).filter(|lane| *slow >> lane & 1 == 1) {
                if let Some(one) = found.get(pack.number[lane] as usize) {
                    drag(pack, lane, one, bodies, h);
                }
            }
        }
        shared.clear();
        let Particles { position, velocity, .. } = particles;
        for (number, group) in groups.groups.iter().enumerate() {
            if bouncing[number] == 0 {
                continue;
            }
            let write = Write {
                group,
                slots: &groups.slots[group.slots.clone()],
                lifts: lifts.of(group),
                position,
                velocity: Some(velocity),
                bodies,
                first: number * LANES,
                sums: &sums[number],
                shared,
            };
            with(*instructions, write);
        }
        for (row, by) in shared.iter() {
            velocity[row as usize] += by;
        }
        // Those that do not bounce are left as they were read in the substep: it must not matter to them who is beside them.
        let mut kept = kept.chunks(LANES);
        for (number, lanes) in bouncing.iter().enumerate().filter(|(_, lanes)| **lanes != 0) {
            for (lane, row) in kept.next().unwrap_or_default().iter().enumerate() {
                if lanes >> lane & 1 == 0 {
                    bodies.rows[number * LANES + lane] = *row;
                }
            }
        }
    }
}

/// A bit for each manifold of a pack that bounces.
fn fast(pack: &Pack, found: &[Found], least: f32) -> u32 {
    let is_fast = |lane: usize| {
        let pressed = |i: usize| pack.force[i][lane] > 0.0 && pack.approach[i][lane] < -least;
        let one = found.get(pack.number[lane] as usize);
        one.is_some_and(|one| one.grip.restitution > 0.0) && (0..4).any(pressed)
    };
    (0..LANES).fold(0, |bits, lane| bits | u32::from(is_fast(lane)) << lane)
}

/// Points of a manifold, at the most.
const POINTS: usize = 4;

/// A pack whose solids have been read with their velocities.
struct Bounce<'a> {
    pack: &'a Pack,
    /// A bit for each manifold that it is about; those beside it are left alone.
    lanes: u32,
    /// And one for each whose second one stands.
    stands: u32,
    bodies: &'a mut Bodies,
    restitution: [f32; LANES],
    least: f32,
    h: f32,
}

impl Work for Bounce<'_> {
    type Output = ();

    /// Written out once for all: few bounce, and what is left out in `contact` (a third point, a second one that stays where it is) is the same bits.
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { pack, lanes, stands, bodies, restitution, least, h } = self;
        let (none, lanes) = (L::zero(), L::mask(lanes));
        let mut a = Rows::<L>::load(bodies, &pack.a);
        let mut b = Rows::<L>::load(bodies, &pack.b);
        if pack.still {
            // Its anchors are in the world's axes.
            b.rotation = Matrix::of([none, none, none, L::splat(1.0)]);
        }
        let (stands, share) = (L::mask(stands), L::load(&pack.own));
        let mut n = load::<L>(&pack.up);
        let restitution = L::load(&restitution);
        let apart = b.centre + load::<L>(&pack.offset) - a.centre;
        let (on_a, on_b) = anchors::<L, POINTS>(pack, &a, Some(&b), apart);
        let radii = [L::load(&pack.radii[0]), L::load(&pack.radii[1])];
        if pack.round {
            n = round_normals(pack, &a, n, &radii, (&on_a, &on_b));
        }
        let (t, u) = tangents(n);
        // What stands was noted with its displacement.
        let rate = stands.select(L::splat(1.0 / h), L::splat(1.0));
        let along = n.dot(a.step + a.shift - b.step * rate - b.shift);
        let (turn_a, turn_b) = (a.spin + a.turn, b.spin * rate + b.turn);
        let turn_a = (turn_a.dot(t), turn_a.dot(u));
        let turn_b = (turn_b.dot(t), turn_b.dot(u));
        let (apart_t, apart_u) = (apart.dot(t), apart.dot(u));
        let own = Side::of(&a.inverse_inertia, t, u);
        let weight = a.inverse_mass + b.inverse_mass;
        let theirs = Side::of(&b.inverse_inertia, t, u);
        let patch = Patch { weight, a: own, b: Some(theirs), apart: (apart_t, apart_u) };
        let stiff = patch.about(none, none);
        let (mut c, mut force) = ([none; POINTS], [none; POINTS]);
        let mut at = [(none, none); POINTS];
        let mut had = Vector::new(none, none, none);
        let skins = skins(pack, n, &radii, (&a, Some(&b)));
        for i in 0..POINTS {
            let (on_a, on_b) = (on_a[i] - skins[0], on_b[i] + skins[1]);
            let arm = on_a.or_else(stands, on_b + (on_a - on_b) * share);
            let (x, y) = (arm.dot(t), arm.dot(u));
            at[i] = (x, y);
            let speed = along + (y * turn_a.0 - x * turn_a.1);
            let speed = speed - ((y - apart_u) * turn_b.0 - (x - apart_t) * turn_b.1);
            let approach = L::load(&pack.approach[i]);
            let had_force = lanes.and(L::load(&pack.force[i]));
            let presses = none.lt(had_force);
            let bounces = none.lt(restitution).and(approach.lt(L::splat(-least)));
            let wanted = bounces.and(none - restitution * approach);
            force[i] = had_force * L::splat(1.0 / h);
            had += Vector::new(force[i], force[i] * x, force[i] * y);
            c[i] = presses.select(wanted - speed, L::splat(-FAR));
        }
        // What pressed may press less, but not pull.
        let had = stiff.times(had);
        for i in 0..POINTS {
            c[i] = c[i] + (had.x + at[i].0 * had.y + at[i].1 * had.z);
        }
        let all = press(&patch, &c, &at);
        let (mut sum, mut x, mut y) = (none, none, none);
        for i in 0..POINTS {
            let more = all[i] - force[i];
            sum = sum + more;
            x = x + more * at[i].0;
            y = y + more * at[i].1;
        }
        let good = sum.abs().lt(L::splat(1e30));
        let (sum, x, y) = (good.and(sum), good.and(x), good.and(y));
        a.shift += n * (sum * a.inverse_mass);
        a.turn += patch.a.turned(x, y);
        let first = [a.shift.with(a.inverse_mass), a.turn.with(none)];
        L::put_records(&mut bodies.rows, &pack.a, first);
        if let Some(side) = &patch.b {
            b.shift -= n * (sum * b.inverse_mass);
            b.turn -= side.turned(x - apart_t * sum, y - apart_u * sum);
            let second = [b.shift.with(b.inverse_mass), b.turn.with(none)];
            L::put_records(&mut bodies.rows, &pack.b, second);
        }
    }
}
