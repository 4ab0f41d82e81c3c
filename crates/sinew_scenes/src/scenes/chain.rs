//! A chain of rope loops that are linked by contact alone, with a weight at its end.

use bevy::prelude::*;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParticles, Bound, ConstraintOf, ParticleBody, ParticleOf, RigidPose};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::entities_named;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "chain",
    heading: Heading::Contacts,
    title: "A chain of loops",
    about: "loops of rope hang in each other by contact alone; the lowest carries a ball of two kilograms, and swings",
    eye: Vec3::new(1.9, 2.3, 4.9),
    target: Vec3::new(-0.25, 1.9, 0.0),
    seconds: 5.0,
    moment: 0.8,
    lesson: Some(Lesson {
        try_this: "hang a heavier ball on the chain, or pull harder at all of it",
        watch: "no joint connects one loop to the next: crossing ropes push each other two radii apart, and that carries the ball",
        formula: "|p_a − p_b| ≥ 2r, and equal where two loops hang in each other",
        sliders: &[
            SceneSlider { label: "Ball mass", unit: "kg", range: [0.2, 4.0], default: 2.0 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 15.0], default: 9.81 },
            SceneSlider { label: "Mass of a loop", unit: "kg", range: [0.4, 1.6], default: 0.8 },
        ],
        number: "Distance of two loops' centre lines",
        unit: "mm",
        after: 1.5,
        measure: |world| {
            let loops = entities_named(world, "loop");
            let beads = |body: &Entity| -> Option<Vec<Vec3>> {
                let at = |p: Entity| world.get::<Particle>(p).map(|p| p.position);
                Some(world.get::<BodyParticles>(*body)?.iter().filter_map(at).collect())
            };
            let beads: Vec<Vec<Vec3>> = loops.iter().filter_map(beads).collect();
            let pairs = beads.windows(2).flat_map(|two| {
                two[0].iter().flat_map(|a| two[1].iter().map(move |b| f64::from(a.distance(*b))))
            });
            Some(pairs.reduce(f64::min)? * 1e3)
        },
        expect: |_, _| 2e3 * f64::from(ROPE),
        tolerance: [2.0, 0.0],
    }),
    spawn,
};

/// Number of loops, and of particles in each.
const LOOPS: usize = 6;
const BEADS: usize = 28;
/// Radius of a rope, metres. Neighbouring particles of a loop overlap, so that nothing slips between them.
const ROPE: f32 = 0.03;
/// Shape of a loop, as of a link of a chain: two half circles and straight sides between them. Radius of the centre line in the bends, where the next loop fits
/// in; length of each straight side; half the height; metres.
const BEND: f32 = 2.0 * ROPE;
const SIDE: f32 = 0.408;
const HALF: f32 = 0.5 * SIDE + BEND;
/// Height of the topmost point of the centre line, metres.
const TOP: f32 = 3.59;
/// Initial angular velocity of the chain, rad/s.
const SWING: f32 = 0.4;

fn spawn(world: &mut World) {
    let [_, gravity, _] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.3));
    world.spawn((InScene, Ground));
    let colors = [0xc9a66b, 0xb8434e, 0x3f6f9f];
    for n in 0..LOOPS {
        // Each hangs in the one above, rotated by a quarter turn: rope on rope, with a millimetre of slack.
        let centre = Vec3::Y * (TOP - HALF - n as f32 * (2.0 * HALF - 2.0 * ROPE - 1e-3));
        let look = Look::color(colors[n % colors.len()]).roughness(0.9);
        link(world, centre, n % 2 == 1, n == 0, n == LOOPS - 1, look);
    }
    gallows(world, TOP);
}

/// The gallows that the chain hangs on, its beam at this height.
fn gallows(world: &mut World, high: f32) {
    let wood = Look::color(0x6d5138).roughness(0.9);
    let (radius, out) = (0.07, 0.95);
    let top = high + radius + ROPE;
    let stands = Transform::from_xyz(-out, 0.5 * (top + radius), 0.0);
    let lies = Transform::from_xyz(0.1 - 0.5 * out, top, 0.0)
        .with_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_2));
    for (length, place) in [(top + radius, stands), (out + 0.2, lies)] {
        let beam = post(world, radius, length);
        world.spawn((InScene, beam, wood.clone(), place));
    }
}

fn link(world: &mut World, centre: Vec3, turned: bool, held: bool, last: bool, look: Look) {
    let [heavy, _, mass] = values(world);
    let body = world.spawn((InScene, Name::new("loop"), ParticleBody, look, Interpolate)).id();
    let across = if turned { Vec3::Z } else { Vec3::X };
    let place = |i: usize| {
        let [out, up] = along_loop((i % BEADS) as f32 / BEADS as f32);
        centre + across * out + Vec3::Y * up
    };
    let beads: Vec<Entity> = (0..BEADS)
        .map(|i| {
            let particle =
                (Particle::at(place(i)), Mass(mass / BEADS as f32), Radius(ROPE), ParticleOf(body));
            world.spawn(particle).id()
        })
        .collect();
    if held {
        world.entity_mut(beads[0]).insert(Pinned::HERE);
    }
    for i in 0..BEADS {
        // The neighbour, and the second neighbour at no less than 0.85 of its distance, so that the rope does not fold sharply.
        let (next, second) = (beads[(i + 1) % BEADS], beads[(i + 2) % BEADS]);
        let (gap, wide) = (place(i).distance(place(i + 1)), place(i).distance(place(i + 2)));
        world.spawn((DistanceConstraint::new(beads[i], next, gap), ConstraintOf(body)));
        let apart =
            DistanceConstraint::new(beads[i], second, 0.85 * wide).with_bound(Bound::AtLeast);
        world.spawn((apart, ConstraintOf(body)));
    }
    let mut particles = beads.clone();
    particles.extend([beads[0], beads[1]]);
    world.entity_mut(body).insert(TubeMesh { particles, radius: ROPE, sides: 10 });
    swing(world, body, centre);
    if last {
        weight(world, beads[BEADS / 2], place(BEADS / 2), heavy);
    }
}

/// A point of a loop's centre line relative to its centre, across and up, metres, at a fraction of the way around it from the top.
fn along_loop(share: f32) -> [f32; 2] {
    let quarter = 0.5 * core::f32::consts::PI * BEND;
    let half = 2.0 * quarter + SIDE;
    // The other side and the lower half are mirror images.
    let (way, side) = if share <= 0.5 { (share, 1.0) } else { (1.0 - share, -1.0) };
    let way = 2.0 * way * half;
    let (way, upper) = if way <= 0.5 * half { (way, 1.0) } else { (half - way, -1.0) };
    let (sin, cos) = libm::sincosf(way.min(quarter) / BEND);
    [side * BEND * sin, upper * (HALF - BEND * (1.0 - cos) - (way - quarter).max(0.0))]
}

/// Starts a body with this barycentre swinging about the top of the chain.
fn swing(world: &mut World, body: Entity, centre: Vec3) {
    let turn = Vec3::Z * SWING;
    let velocity = turn.cross(centre - Vec3::Y * TOP);
    world.commands().entity(body).set_motion(velocity, turn);
}

/// A ball of `heavy` kg on a short string.
fn weight(world: &mut World, bead: Entity, from: Vec3, heavy: f32) {
    let centre = from - Vec3::Y * 0.22;
    let iron = mesh(world, ball(0.13));
    let body = world
        .spawn((
            InScene,
            Name::new("weight"),
            ParticleBody,
            iron,
            Look::color(0x555b61).metal(),
            Interpolate,
            Transform::from_translation(centre),
        ))
        .id();
    let ball =
        world.spawn((Particle::at(centre), Mass(heavy), Radius(0.13), ParticleOf(body))).id();
    world.spawn((DistanceConstraint::new(bead, ball, 0.22), ConstraintOf(body)));
    swing(world, body, centre);
    world.entity_mut(body).insert(RigidPose { particles: vec![ball], rest: vec![Vec3::ZERO] });
    let string = TubeMesh { particles: vec![bead, ball], radius: 0.008, sides: 8 };
    world.spawn((InScene, string, Look::color(0x555b61).metal()));
}
