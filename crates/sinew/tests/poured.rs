//! A thousand boxes, poured in random poses: a heap with all kinds of contacts, wedges, thin corners and boxes that lean on three others.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{BoxSpec, box_3d};
use sinew::{BodyContacts, Collider, Frame, Shape, Simulation};

/// Random numbers from -1 to 1, the same in every run.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    fn rotation(&mut self) -> Quat {
        Quat::from_xyzw(self.next(), self.next(), self.next(), self.next()).normalize()
    }
}

/// Speed of a heap of a thousand boxes twenty seconds after it was poured, m/s, and the height of its lowest particle, m. Nothing sleeps and nothing is damped:
/// the heap rests by friction alone.
fn poured(seed: u64) -> (f32, f32) {
    let mut world = Simulation::default();
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::IDENTITY));
    let spec = BoxSpec { size: Vec3::splat(0.5), mass: 5.0, ..BoxSpec::default() };
    let cube = box_3d(&spec).unwrap();
    let contacts = BodyContacts { with_bodies: true, ..Default::default() };
    let mut dice = Dice(seed);
    for _ in 0..5 {
        dice.next();
    }
    for n in 0..1000 {
        let (layer, place) = (n / 25, n % 25);
        let [x, z] = [place % 5, place / 5].map(|i| 0.9 * i as f32);
        let at = Vec3::new(x + 0.1 * dice.next(), 0.8 + 0.95 * layer as f32, z + 0.1 * dice.next());
        let turned = dice.rotation();
        cube.transformed(turned, at).build_colliding(&mut world, contacts).unwrap();
    }
    for _ in 0..20 * 60 {
        world.step(1.0 / 60.0).unwrap();
    }
    let particles = &world.particles;
    let (mut squares, mut lowest) = (0.0, f32::INFINITY);
    for i in 0..particles.len() {
        squares += particles.velocity(i).length_squared();
        lowest = lowest.min(particles.position(i).y);
    }
    ((squares / particles.len() as f32).sqrt(), lowest)
}

/// Three heaps, because a single one is not representative: in about one of twenty a few boxes, at the limit of friction, still slip by a centimetre from time
/// to time, and such a slip may happen at the moment of the check. (The first of these three is such a heap: it is at rest from 24 s on.)
#[test]
fn a_thousand_boxes_poured_in_any_pose_are_at_rest_after_twenty_seconds() {
    let mut heaps = std::thread::scope(|scope| {
        let heaps = [1, 7_920, 15_839].map(|seed| scope.spawn(move || poured(seed)));
        heaps.map(|heap| heap.join().unwrap())
    });
    heaps.sort_by(|one, other| one.0.total_cmp(&other.0));
    assert!(heaps[1].0 < 1e-3, "{heaps:?}");
    assert!(heaps[2].0 < 5e-2, "{heaps:?}");
    assert!(heaps.iter().all(|heap| heap.1 > -1e-3), "{heaps:?}");
}
