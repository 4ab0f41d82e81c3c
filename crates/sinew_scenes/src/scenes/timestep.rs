//! A time step that changes in flight, and three ways to treat Verlet's previous position: corrected by the solver, rescaled, and left as it was.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{FLOOR, curve, floor, mesh, post};
use crate::rounds::{Rounds, into_round};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "timestep",
    heading: Heading::Integration,
    title: "A step that changes",
    about: "the step changes every quarter of a second: blue is corrected for it, yellow rescaled, red left as it was",
    eye: Vec3::new(0.9, 1.9, 5.2),
    target: Vec3::new(0.25, 1.25, 0.0),
    seconds: 4.0,
    moment: 0.45,
    lesson: Some(Lesson {
        try_this: "set both steps to 4 a tick: all three balls fly alike; then make them differ",
        watch: "with an unchanged previous position, a step four times shorter makes a ball four times faster; rescaled, the age of its velocity is ignored, and it is some millimetres off",
        formula: "q = p + (p − p_old) h'/h + a h' (h + h')/2: exact for constant a",
        sliders: &[
            SceneSlider { label: "First steps", unit: "a tick", range: [1.0, 4.0], default: 2.0 },
            SceneSlider { label: "Then", unit: "a tick", range: [4.0, 12.0], default: 4.0 },
            SceneSlider { label: "Speed", unit: "m/s", range: [3.5, 5.5], default: 4.5 },
        ],
        number: "Height of the blue ball over its start",
        unit: "m",
        after: 0.75,
        measure: |world| {
            let ball: Particle = component_of(world, "corrected")?;
            Some(f64::from(ball.position.y - START.y))
        },
        expect: |values, seconds| {
            let time = into_round(seconds, FLIGHT);
            f64::from(values[2]) * time - 0.5 * 9.81 * time * time
        },
        tolerance: [1e-3, 0.0],
    }),
    spawn,
};

/// Interval at which the step changes, and time after which the balls are thrown again, seconds.
const CHANGE: f64 = 0.25;
const FLIGHT: f64 = 0.75;
/// Start of the middle ball, metres.
const START: Vec3 = Vec3::new(-1.1, FLOOR + 0.75, 0.0);
/// Horizontal velocity, m/s.
const ALONG: f32 = 2.6;

/// How the previous position of a ball is treated when the step changes.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(crate) enum Memory {
    /// It is left to the solver, which stores the length of the last step.
    Corrected,
    /// It is moved so that the velocity stays the same, as if that were the mean over a step of the new length.
    Rescaled,
    /// It stays, so that the last displacement counts as that of a step of the new length.
    Kept,
}

/// Changes the step, and throws the balls again.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct ChangesStep {
    substeps: [u32; 2],
    throw: Vec3,
}

/// Changes the step where a round ends, and treats the balls accordingly.
pub(crate) fn change_step(
    clock: Res<SinewClock>,
    mut config: ResMut<SolverConfig>,
    mut changes: Query<(&mut Rounds, &ChangesStep)>,
    mut balls: Query<(&Memory, &mut Particle)>,
) {
    for (mut rounds, change) in &mut changes {
        let Some(ended) = rounds.ended(&clock) else { continue };
        let turn = ended % (FLIGHT / CHANGE) as u32;
        let before = config.substeps;
        config.substeps = change.substeps[turn as usize % 2];
        let longer = before as f32 / config.substeps as f32;
        for (memory, mut ball) in &mut balls {
            if turn == 0 {
                let at = START.with_z(lane(*memory));
                *ball = Particle::at(at).with_velocity(change.throw);
                continue;
            }
            match memory {
                Memory::Corrected => continue,
                Memory::Rescaled => {}
                Memory::Kept => ball.velocity /= longer,
            }
            ball.lag *= longer;
        }
    }
}

/// The lane of a ball, metres along z.
fn lane(memory: Memory) -> f32 {
    match memory {
        Memory::Corrected => 0.0,
        Memory::Rescaled => 0.4,
        Memory::Kept => -0.4,
    }
}

fn spawn(world: &mut World) {
    let [first, then, speed] = values(world);
    let substeps = [first, then].map(|steps| steps.round() as u32);
    world.insert_resource(SolverConfig { substeps: substeps[0], ..default() });
    world.insert_resource(AirDrag(0.0));
    let throw = Vec3::new(ALONG, speed, 0.0);
    world.spawn((InScene, Rounds::of(CHANGE), ChangesStep { substeps, throw }));
    floor(world, Vec2::new(5.0, 2.2), Look::color(0x6f7f6a).roughness(0.9));
    let skin = mesh(world, ball(0.1));
    let stand = post(world, 0.06, 0.6);
    for (name, memory, color) in [
        ("kept", Memory::Kept, 0xd1495b),
        ("corrected", Memory::Corrected, 0x3d7ea6),
        ("rescaled", Memory::Rescaled, 0xe9b44c),
    ] {
        let from = START.with_z(lane(memory));
        let path = |k: i32| {
            let time = FLIGHT as f32 * k as f32 / 24.0;
            from + throw * time + Vec3::NEG_Y * (0.5 * 9.81 * time * time)
        };
        let path: Vec<Vec3> = (0..=24).map(path).collect();
        curve(world, &path, 0.012, Look::color(0xf3f1ea));
        let under = Transform::from_translation(from.with_y(FLOOR + 0.3));
        world.spawn((InScene, stand.clone(), Look::color(0x4a4f55).roughness(0.5), under));
        world.spawn((
            InScene,
            Name::new(name),
            memory,
            Particle::at(from).with_velocity(throw),
            Radius(0.1),
            Interpolate,
            Transform::from_translation(from),
            skin.clone(),
            Look::color(color).roughness(0.3),
        ));
    }
}
