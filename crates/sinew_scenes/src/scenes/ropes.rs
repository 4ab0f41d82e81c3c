//! Ropes: a slack line between two posts, a rope that swings with a lantern at its end, and one attached to a moving hand.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyParticles, ConstraintOf, ParticleBody, ParticleOf, PinnedTo, RigidPose, SinewClock,
};

use crate::bevy_version::OnAdd;
use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::points_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "ropes",
    heading: Heading::Soft,
    title: "Ropes",
    about: "a slack line, a swinging lantern, and a whip in a moving hand",
    eye: Vec3::new(0.9, 1.9, 6.6),
    target: Vec3::new(0.25, 1.25, 0.0),
    seconds: 6.0,
    moment: 2.6,
    lesson: Some(Lesson {
        try_this: "hang a heavier lantern on the rope, or a longer rope on the beam",
        watch: "the rope weighs far less than its lantern, swings with it, and does not stretch",
        formula: "Σ |p_(i+1) − p_i| = L",
        sliders: &[
            SceneSlider { label: "Lantern", unit: "kg", range: [0.3, 3.0], default: 1.2 },
            SceneSlider { label: "Rope", unit: "m", range: [0.8, 1.3], default: 1.22 },
            SceneSlider { label: "Slack of the line", unit: "", range: [0.1, 0.4], default: 0.25 },
        ],
        number: "Length of the swinging rope",
        unit: "m",
        after: 2.0,
        measure: |world| {
            let points = points_of(world, "swinging rope");
            let pieces = points.windows(2).map(|pair| f64::from(pair[0].distance(pair[1])));
            (!points.is_empty()).then(|| pieces.sum())
        },
        expect: |values, _| f64::from(values[1]),
        tolerance: [0.0, 0.005],
    }),
    spawn,
};

/// A waving hand. Its position is a function of simulated time alone.
#[derive(Component)]
pub(crate) struct Hand {
    at: Vec3,
}

/// Moves the hand along a horizontal figure of eight, 0.5 m wide and 0.3 m high, with a period of 1.6 s.
pub(crate) fn move_hand(clock: Res<SinewClock>, mut hands: Query<(&Hand, &mut Transform)>) {
    for (hand, mut transform) in &mut hands {
        let turn = (clock.seconds / 1.6).fract() as f32 * core::f32::consts::TAU;
        let (sin, cos) = libm::sincosf(turn);
        transform.translation = hand.at + Vec3::new(0.25 * sin, 0.3 * sin * cos, 0.1 * cos);
    }
}

fn spawn(world: &mut World) {
    let [lantern, length, slack] = values(world);
    world.spawn((InScene, Ground));
    let wood = Look::color(0x8a6a4b);
    for x in [-2.0, 0.4] {
        let post = post(world, 0.05, 2.2);
        world.spawn((InScene, post, wood.clone(), Transform::from_xyz(x, 1.1, 0.0)));
    }
    let hemp = Look::color(0xc9a66b).roughness(0.9);
    let rope = |from: Vec3, to: Vec3, radius: f32| Rope {
        mass: 0.4,
        radius,
        segments: 32,
        ..Rope::between(from, to)
    };
    // Between the facing sides of the posts, so that the line does not start inside of them.
    let line = rope(Vec3::new(-1.928, 2.15, 0.0), Vec3::new(0.328, 2.15, 0.0), 0.022);
    world.spawn((
        InScene,
        Name::new("slack line"),
        Rope { slack, pin_end: true, ..line },
        hemp.clone(),
        Interpolate,
    ));

    // The swinging rope hangs from a beam that extends from the post, so that it swings clear of the post. The lantern is tied to its last particle.
    let beam = post(world, 0.03, 0.85);
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let beam_at = Transform::from_xyz(0.8, 2.15, 0.0).with_rotation(lying);
    world.spawn((InScene, beam, wood.clone(), beam_at));
    let (hook, held_out) = (Vec3::new(1.15, 2.1, 0.0), Vec3::new(0.45, -0.7, 0.9));
    let swing = rope(hook, hook + held_out.normalize() * length, 0.016);
    let swing = Rope { segments: 16, ..swing };
    let end = swing.to;
    let along = (swing.to - swing.from).normalize();
    let rope =
        world.spawn((InScene, Name::new("swinging rope"), swing, hemp.clone(), Interpolate)).id();
    let lamp_mesh = world.resource::<AssetServer>().load("props/lantern.glb#Mesh0/Primitive0");
    let lamp = world
        .spawn((
            InScene,
            Name::new("lantern"),
            ParticleBody,
            Mesh3d(lamp_mesh),
            Look::texture("props/lantern.glb#Texture0").roughness(0.4),
            Interpolate,
            Transform::from_translation(end),
        ))
        .id();
    // The two particles of the lantern: its ring, and its foot, which has nearly all of the mass. In the frame of the mesh they are 0.36 m above and 0.19 m
    // below the origin.
    let [ring, foot] = [(0.0, 0.1, 0.02), (0.55, lantern, 0.15)].map(|(down, mass, radius)| {
        let place = end + along * down;
        world.spawn((Particle::at(place), Mass(mass), Radius(radius), ParticleOf(lamp))).id()
    });
    world.spawn((DistanceConstraint::new(ring, foot, 0.55), ConstraintOf(lamp)));
    let rest = vec![Vec3::Y * 0.36, Vec3::Y * -0.19];
    world.entity_mut(lamp).insert(RigidPose { particles: vec![ring, foot], rest });
    world.spawn((InScene, Tie { rope, ring }));

    let at = Vec3::new(2.0, 2.0, 0.3);
    let knob = mesh(world, ball(0.07));
    let hand = world
        .spawn((InScene, Hand { at }, knob, Look::color(0xd9622b), Transform::from_translation(at)))
        .id();
    let whip =
        Rope { segments: 40, radius: 0.014, mass: 0.2, ..Rope::between(at, at - Vec3::Y * 1.6) };
    let whip =
        world.spawn((InScene, Name::new("whip"), whip, Look::color(0x3a3f47), Interpolate)).id();
    // Ropes are built in the next tick; ties to their particles wait for that.
    world.spawn((InScene, Lead { rope: whip, hand }));
}

/// A pending tie from the end of a rope to a particle.
#[derive(Component)]
pub(crate) struct Tie {
    rope: Entity,
    ring: Entity,
}

/// A pending attachment of the start of a rope to a hand.
#[derive(Component)]
pub(crate) struct Lead {
    rope: Entity,
    hand: Entity,
}

/// Makes the pending ties of a rope once the rope is built.
pub(crate) fn tie_ends(
    built: OnAdd<bevy_sinew::TubeMesh>,
    mut commands: Commands,
    ropes: Query<&BodyParticles>,
    ties: Query<(Entity, &Tie)>,
    leads: Query<(Entity, &Lead)>,
) {
    let Ok(particles) = ropes.get(built.entity) else { return };
    let (Some(first), Some(last)) = (particles.iter().next(), particles.iter().last()) else {
        return;
    };
    for (waiting, tie) in ties.iter().filter(|(_, tie)| tie.rope == built.entity) {
        let knot = DistanceConstraint::new(last, tie.ring, 0.0);
        commands.spawn((knot, ConstraintOf(tie.rope)));
        commands.entity(waiting).despawn();
    }
    for (waiting, lead) in leads.iter().filter(|(_, lead)| lead.rope == built.entity) {
        commands.entity(first).insert(PinnedTo { entity: lead.hand, offset: Vec3::ZERO });
        commands.entity(waiting).despawn();
    }
}
