//! What is left to do after the velocities are derived: restitution, and to take off speed that is none of anybody's.
//!
//! Positions know nothing of elasticity: what is put on a surface leaves it with the speed that it lacked to get there. So where a point pressed in
//! this substep and its speed of approach before was above `2gh`, which gravity alone gives to what lies still, the speed along the normal becomes
//! `-e` times that, by an impulse between the two that conserves momentum and angular momentum. What came out of a deep overlap (see `contact`) is
//! left with no speed along the normal: of the impulse that it got, so much is taken back. Approach is taken before the last bit of the way, which is
//! less than at the surface: `e = 1` gains nothing.

use super::Solids;
use super::block::press;
use super::bodies::{Bodies, Eight as Rows};
use super::contact::Pack;
use super::found::Found;
use super::read::Read;
use super::turn::load;
use super::write::Write;
use crate::lanes::{LANES, Lanes, Work, with};
use crate::particles::Particles;

impl Solids {
    /// Gives what bounced its velocity.
    pub(crate) fn bounce(&mut self, particles: &mut Particles, h: f32, gravity: f32) {
        let least = 2.0 * gravity * h;
        self.loose.bounce(particles, &self.groups, &self.bodies, least);
        let Self { groups, lifts, bodies, sums, instructions, shared, packs, found, .. } = self;
        let Self { bouncing, bounced, .. } = self;
        bouncing.clear();
        bouncing.resize(groups.groups.len(), false);
        bounced.clear();
        for pack in packs.iter() {
            let any = pack.popped || pack.kept && is_fast(pack, found, least);
            bounced.push(any);
            for row in pack.a.iter().chain(&pack.b).filter(|_| any) {
                if let Some(bouncing) = bouncing.get_mut(*row as usize / LANES) {
                    *bouncing = true;
                }
            }
        }
        if !bouncing.contains(&true) {
            return;
        }
        for (number, group) in groups.groups.iter().enumerate().filter(|(i, _)| bouncing[*i]) {
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
            };
            with(*instructions, read);
        }
        for (pack, _) in packs.iter().zip(bounced).filter(|(_, bounced)| **bounced) {
            let restitution = core::array::from_fn(|lane| {
                found.get(pack.number[lane] as usize).map_or(0.0, |one| one.grip.restitution)
            });
            with(*instructions, Bounce { pack, bodies, restitution, least, h });
        }
        shared.clear();
        let Particles { position, velocity, .. } = particles;
        for (number, group) in groups.groups.iter().enumerate().filter(|(i, _)| bouncing[*i]) {
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
        for &(row, by) in shared.iter() {
            velocity[row as usize] += by;
        }
    }
}

/// Whether something in a pack bounces.
fn is_fast(pack: &Pack, found: &[Found], least: f32) -> bool {
    (0..LANES).any(|lane| {
        let pressed = |i: usize| pack.force[i][lane] > 0.0 && pack.approach[i][lane] < -least;
        let one = found.get(pack.number[lane] as usize);
        one.is_some_and(|one| one.grip.restitution > 0.0) && (0..4).any(pressed)
    })
}

/// A pack whose solids have been read with their velocities.
struct Bounce<'a> {
    pack: &'a Pack,
    bodies: &'a mut Bodies,
    restitution: [f32; LANES],
    least: f32,
    h: f32,
}

impl Work for Bounce<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { pack, bodies, restitution, least, h } = self;
        let none = L::zero();
        let (mut a, mut b) = (Rows::<L>::load(bodies, &pack.a), Rows::<L>::load(bodies, &pack.b));
        let own = L::load(&pack.own);
        // What stands was noted with its displacement.
        let rate = L::splat(0.75).lt(own).select(L::splat(1.0 / h), L::splat(1.0));
        let (b_velocity, b_spin) = (b.step * rate, b.spin * rate);
        let apart = b.centre + load::<L>(&pack.offset) - a.centre;
        let n = load::<L>(&pack.up);
        let restitution = L::load(&restitution);
        let (mut c, mut force) = ([none; 4], [none; 4]);
        let mut at = [(none, none); 4];
        let (mut ja, mut jb, mut ia, mut ib) = ([n; 4], [n; 4], [n; 4], [n; 4]);
        let mut arms = [n; 4];
        let weight = a.inverse_mass + b.inverse_mass;
        let along = n.dot(a.step + a.shift - b_velocity - b.shift);
        for i in 0..4 {
            let on_a = a.rotation.times(load(&pack.on_a[i]));
            let on_b = b.rotation.times(load(&pack.on_b[i])) + apart;
            let arm = on_a.or_else(L::splat(0.75).lt(own), (on_a + on_b) * L::splat(0.5));
            arms[i] = arm;
            ja[i] = arm.cross(n);
            jb[i] = (arm - apart).cross(n);
            ia[i] = a.inverse_inertia.times(ja[i]);
            ib[i] = b.inverse_inertia.times(jb[i]);
            let speed = along + ja[i].dot(a.spin + a.turn) - jb[i].dot(b_spin + b.turn);
            let approach = L::load(&pack.approach[i]);
            let presses = none.lt(L::load(&pack.force[i]));
            let bounces = none.lt(restitution).and(approach.lt(L::splat(-least)));
            let wanted = bounces.and(none - restitution * approach);
            force[i] = L::load(&pack.force[i]) * L::splat(1.0 / h);
            c[i] = presses.select(wanted - speed, L::splat(-1e9));
        }
        // Any two axes across each other in the patch do to say where its points are.
        let first = arms[1] - arms[0];
        let second = n.cross(first);
        for i in 0..4 {
            at[i] = ((arms[i] - arms[0]).dot(first), (arms[i] - arms[0]).dot(second));
        }
        let mut k = [[none; 4]; 4];
        for i in 0..4 {
            for j in 0..=i {
                k[i][j] = weight + ja[i].dot(ia[j]) + jb[i].dot(ib[j]);
                k[j][i] = k[i][j];
            }
        }
        // What pressed may press less, but not pull.
        for i in 0..4 {
            let had =
                k[i][0] * force[0] + k[i][1] * force[1] + k[i][2] * force[2] + k[i][3] * force[3];
            c[i] = c[i] + had;
        }
        let all = press(&k, c, at);
        for i in 0..4 {
            force[i] = all[i] - force[i];
        }
        let sum = force[0] + force[1] + force[2] + force[3];
        let good = sum.abs().lt(L::splat(1e30));
        a.shift += n * good.and(sum * a.inverse_mass);
        b.shift -= n * good.and(sum * b.inverse_mass);
        for i in 0..4 {
            let force = good.and(force[i]);
            a.turn += ia[i] * force;
            b.turn -= ib[i] * force;
        }
        L::put_rows(&mut bodies.shift, &pack.a, a.shift.with(a.inverse_mass));
        L::put_rows(&mut bodies.turn, &pack.a, a.turn.with(none));
        L::put_rows(&mut bodies.shift, &pack.b, b.shift.with(b.inverse_mass));
        L::put_rows(&mut bodies.turn, &pack.b, b.turn.with(none));
    }
}
