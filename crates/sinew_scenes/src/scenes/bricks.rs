//! The same throw computed in three ways: bricks that spin about their middle axis, which is unstable (Dzhanibekov effect).

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParticles, BoxParticles, Representation};
use bevy_sinew::{BodySolver, GradientAt, RigidIntegrator};

use crate::look::Look;
use crate::props::mesh;
use crate::readings::entities_named;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "bricks",
    heading: Heading::Constraints,
    title: "Bricks in space (Dzhanibekov)",
    about: "orange, plain position-based dynamics, loses its spin; blue, corrected along the gradients at the start of the step, flips every 3.9 s, and so does green, a rigid body",
    eye: Vec3::new(0.0, 4.7, 13.8),
    target: Vec3::new(0.0, 2.7, 0.0),
    seconds: 8.0,
    moment: 3.9,
    lesson: Some(Lesson {
        try_this: "throw them faster, or tilted further: the further off its axis, the sooner a brick flips",
        watch: "no torque acts on a brick in space, so its angular momentum is constant, though its axis flips over and back; the blue one's 28 distances conserve it by themselves",
        formula: "L = Σ m r × v = I ω is constant",
        sliders: &[
            SceneSlider { label: "Spin", unit: "rad/s", range: [2.0, 7.0], default: 6.0 },
            SceneSlider { label: "Tilt", unit: "rad", range: [0.0, 0.1], default: 0.01 },
            SceneSlider { label: "Mass", unit: "kg", range: [1.0, 10.0], default: 1.0 },
        ],
        number: "Angular momentum of the blue brick",
        unit: "kg m²/s",
        after: 2.0,
        measure: |world| {
            let brick = *entities_named(world, "brick").get(1)?;
            angular_momentum(world, brick)
        },
        expect: |values, _| {
            let [spin, tilt, mass] = [values[0], values[1], values[2]].map(f64::from);
            let [x, y, z] = SIZE.to_array().map(f64::from);
            let momenta = [tilt * (y * y + z * z), x * x + z * z];
            mass * spin / 12.0 * libm::hypot(momenta[0], momenta[1])
        },
        tolerance: [0.0, 0.005],
    }),
    spawn,
};

/// Edges of a brick, metres. The middle axis is y, which points up.
const SIZE: Vec3 = Vec3::new(1.0, 2.0, 3.0);

/// Σ m r × v of a body about its barycentre, kg m²/s.
fn angular_momentum(world: &World, body: Entity) -> Option<f64> {
    let state = |p: Entity| {
        let (particle, mass) = (world.get::<Particle>(p)?, world.get::<Mass>(p)?);
        Some((particle.position.as_dvec3(), particle.velocity.as_dvec3(), f64::from(mass.0)))
    };
    let states: Vec<_> =
        world.get::<BodyParticles>(body)?.iter().map(state).collect::<Option<_>>()?;
    let mass: f64 = states.iter().map(|(_, _, m)| m).sum();
    let centre = states.iter().map(|(at, _, m)| at * *m).sum::<bevy::math::DVec3>() / mass;
    let about =
        |(at, v, m): &(bevy::math::DVec3, bevy::math::DVec3, f64)| (at - centre).cross(*v) * *m;
    Some(states.iter().map(about).sum::<bevy::math::DVec3>().length())
}

fn spawn(world: &mut World) {
    let [spin, tilt, mass] = values(world);
    // About the middle axis, except for the tilt.
    let thrown = spin * Vec3::new(tilt, 1.0, 0.0);
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    let ways = [
        (-4.0, 0xd9622b, GradientAt::Current, Representation::Particles),
        (0.0, 0x3d7ea6, GradientAt::StepStart, Representation::Particles),
        (4.0, 0x66a182, GradientAt::StepStart, Representation::Rigid(RigidIntegrator::default())),
    ];
    for (x, color, gradient_at, representation) in ways {
        let skin = mesh(world, rounded_box(SIZE, 0.06, 4));
        let brick = world
            .spawn((
                InScene,
                Name::new("brick"),
                // With the inertia of a solid brick, which determines when it flips.
                RigidBox {
                    particles: BoxParticles::Equimomental,
                    ..RigidBox::new(SIZE).with_mass(mass)
                },
                // So that the effect of the corrections alone is visible.
                BodySolver { gradient_at: Some(gradient_at), keep_spin: Some(false), ..default() },
                representation,
                skin,
                Look::color(color).roughness(0.5),
                Interpolate,
                Transform::from_xyz(x, 2.8, 0.0),
            ))
            .set_angular_velocity(thrown)
            .id();
        // A knob marks the end that was up at first.
        let (stick, knob) = (mesh(world, cylinder(0.05, 0.5)), mesh(world, ball(0.16)));
        let (steel, red) = (Look::color(0xb9bec6).metal(), Look::color(0xd1495b).roughness(0.3));
        let above = |y: f32| Transform::from_xyz(0.0, SIZE.y * 0.5 + y, 0.0);
        world.spawn((ChildOf(brick), stick, steel, above(0.25)));
        world.spawn((ChildOf(brick), knob, red, above(0.55)));
    }
}
