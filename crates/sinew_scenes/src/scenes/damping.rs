//! Velocity damping: exact, and by an approximation that depends on the time step.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Drag, SinewClock};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::{Rounds, into_round};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "damping",
    heading: Heading::Forces,
    title: "Velocity damping, exact and approximated",
    about: "blue is damped by the exact factor, the others by 1 − d h, applied every half second, every quarter, every tick",
    eye: Vec3::new(0.5, 2.0, 4.6),
    target: Vec3::new(0.0, 0.75, 0.0),
    seconds: 4.0,
    moment: 1.7,
    lesson: Some(Lesson {
        try_this: "turn the drag up: the approximation gets worse; a heavier bead is damped like a light one, because drag takes a fraction of the velocity",
        watch: "after a second blue has the fraction 1 − d of its speed left; the others have more, and more with shorter steps: it tends to exp(−d)",
        formula: "v = v₀ (1 − d)^t for every step, by c = (1 − d)^h and not by 1 − d h",
        sliders: &[
            SceneSlider { label: "Speed", unit: "m/s", range: [1.0, 2.4], default: 2.0 },
            SceneSlider { label: "Loss per second", unit: "", range: [0.4, 0.95], default: 0.8 },
            SceneSlider { label: "Mass", unit: "kg", range: [0.1, 10.0], default: 1.0 },
        ],
        number: "Distance of the blue bead",
        unit: "m",
        after: 1.75,
        measure: |world| {
            let bead: Particle = component_of(world, "exact")?;
            Some(f64::from(bead.position.x - START))
        },
        expect: |values, seconds| {
            let [speed, lost] = [values[0], values[1]].map(f64::from);
            let rate = -libm::log1p(-lost);
            speed / rate * (1.0 - libm::exp(-rate * into_round(seconds, ROUND)))
        },
        tolerance: [2e-3, 2e-3],
    }),
    spawn,
};

/// All beads start again after this time, seconds.
const ROUND: f64 = 2.0;
/// Where the beads start along x, metres.
const START: f32 = -1.9;

/// Damping by the approximation, in every tick or once in a step of its own.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Approximated {
    /// Fraction of the velocity lost in a second.
    lost: f32,
    /// Length of its step, seconds; `None`: one tick.
    step: Option<f32>,
}

/// A bead that starts again with this velocity, m/s, when its round ends.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Bead {
    round: Rounds,
    speed: f32,
}

/// Applies the approximate damping, and restarts the beads.
pub(crate) fn damp(
    clock: Res<SinewClock>,
    time: Res<Time>,
    mut beads: Query<(&mut Bead, &mut Particle, Option<&Approximated>, Option<&mut Rounds>)>,
) {
    for (mut bead, mut particle, approximated, step) in &mut beads {
        let due = step.map(|mut step| step.ended(&clock).is_some());
        if bead.round.ended(&clock).is_some() {
            let at = particle.position.with_x(START);
            *particle = Particle::at(at).with_velocity(Vec3::X * bead.speed);
            continue;
        }
        if let Some(Approximated { lost, step }) = approximated
            && due.unwrap_or(clock.tick > 0)
        {
            particle.velocity *= 1.0 - lost * step.unwrap_or(time.delta_secs());
        }
    }
}

fn spawn(world: &mut World) {
    let [speed, lost, mass] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(5.0, 2.2), Look::color(0x8c6e54).roughness(0.8));
    let wood = Look::color(0x3f2f25).roughness(0.6);
    let side = mesh(world, rounded_box(Vec3::new(0.12, 1.55, 0.3), 0.03, 2));
    for x in [-2.2, 2.2] {
        let at = Transform::from_xyz(x, FLOOR + 0.775, 0.0);
        world.spawn((InScene, side.clone(), wood.clone(), at));
    }
    let wire = mesh(world, cylinder(0.012, 4.4));
    let skin = mesh(world, ball(0.13));
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let steel = Look::color(0xc8ccd2).metal();
    let mark = mesh(world, Cuboid::new(0.02, 0.3, 0.3));
    let beads = [
        ("exact", None, 0x3d7ea6),
        ("half a second", Some(Some(0.5)), 0xe9b44c),
        ("a quarter of a second", Some(Some(0.25)), 0xd9622b),
        ("a tick", Some(None), 0xb5384a),
    ];
    for (n, (name, approximated, color)) in beads.into_iter().enumerate() {
        let high = FLOOR + 1.36 - 0.37 * n as f32;
        let at = Vec3::new(START, high, 0.0);
        let look = Look::color(color).roughness(0.3);
        let along = Transform::from_xyz(0.0, high, 0.0).with_rotation(lying);
        world.spawn((InScene, wire.clone(), steel.clone(), along));
        // Where the bead is when the round ends, marked behind it on the wire.
        let way = match approximated {
            None => {
                let rate = -libm::log1pf(-lost);
                speed / rate * (1.0 - libm::expf(-rate * ROUND as f32))
            }
            Some(step) => {
                // The sum of a geometric series; the first step is taken at full speed.
                let step = step.unwrap_or(1.0 / 60.0);
                let kept = 1.0 - lost * step;
                speed / lost * (1.0 - libm::powf(kept, ROUND as f32 / step))
            }
        };
        let there = Transform::from_xyz(START + way, high, -0.02);
        world.spawn((InScene, mark.clone(), look.clone(), there));
        let mut bead = world.spawn((
            InScene,
            Name::new(name),
            Bead { round: Rounds::of(ROUND), speed },
            Particle::at(at).with_velocity(Vec3::X * speed),
            Mass(mass),
            Interpolate,
            Transform::from_translation(at),
            skin.clone(),
            look,
        ));
        match approximated {
            None => _ = bead.insert(Drag(lost)),
            Some(step) => {
                bead.insert(Approximated { lost, step });
                if let Some(step) = step {
                    bead.insert(Rounds::of(f64::from(step)));
                }
            }
        }
    }
}
