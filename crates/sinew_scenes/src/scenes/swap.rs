//! Boxes that change from particles to rigid bodies and back in flight, each beside a copy that does not change.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BoxParticles, Representation};
use bevy_sinew::{RigidIntegrator, SinewClock};

use crate::look::Look;
use crate::props::mesh;
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "swap",
    heading: Heading::Bodies,
    title: "Particles or rigid, at any time",
    about: "the front row changes its representation every second: orange as particles, blue as a rigid body; it keeps up with the grey row, which never changes",
    eye: Vec3::new(1.6, 3.6, 8.6),
    target: Vec3::new(0.0, 2.0, 0.0),
    seconds: 6.0,
    moment: 1.6,
    lesson: Some(Lesson {
        try_this: "throw the boxes with more spin, make them heavier, or use stronger gravity",
        watch: "at each whole second the front row becomes rigid bodies or particles again: position, momentum and angular momentum are kept, so nothing jumps",
        formula: "L = Σ m r × v of the particles = I ω of the rigid body",
        sliders: &[
            SceneSlider { label: "Spin", unit: "rad/s", range: [0.5, 4.0], default: 2.3 },
            SceneSlider { label: "Mass", unit: "kg", range: [0.5, 10.0], default: 1.0 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [0.5, 2.5], default: 1.62 },
        ],
        number: "Angular momentum of the first box",
        unit: "kg m²/s",
        after: 1.5,
        measure: |world| {
            let frame: Transform = nth_component_of(world, "box", 0)?;
            let spin: AngularVelocity = nth_component_of(world, "box", 0)?;
            let [_, mass, _] = values(world);
            Some(momentum(SIZES[0], mass, frame.rotation.inverse() * spin.0))
        },
        expect: |values, _| momentum(SIZES[0], values[1], thrown(0, values[0])),
        tolerance: [0.0, 0.01],
    }),
    spawn,
};

/// A body that changes its representation with every second of simulated time.
#[derive(Component)]
pub(crate) struct Swaps;

/// The colour of a representation.
fn look_of(representation: Representation) -> Look {
    let color = if representation == Representation::Particles { 0xd9622b } else { 0x3d7ea6 };
    Look::color(color).roughness(0.45)
}

/// Changes the representations. They are a function of simulated time alone.
pub(crate) fn swap_bodies(
    clock: Res<SinewClock>,
    mut bodies: Query<(&mut Representation, &mut Look), With<Swaps>>,
) {
    let odd = clock.seconds.rem_euclid(2.0) >= 1.0;
    let rigid = Representation::Rigid(RigidIntegrator::default());
    let wanted = if odd { rigid } else { Representation::Particles };
    for (mut representation, mut look) in &mut bodies {
        if representation.set_if_neq(wanted) {
            *look = look_of(wanted);
        }
    }
}

/// Edges of the boxes, metres.
const SIZES: [Vec3; 3] = [Vec3::new(0.5, 0.7, 1.0), Vec3::splat(0.7), Vec3::new(1.1, 0.35, 0.7)];

/// Initial angular velocity of a box, rad/s: about a different axis for each.
fn thrown(place: usize, spin: f32) -> Vec3 {
    let axis = Vec3::new(1.6, 0.9, 1.4 - place as f32);
    axis * (spin / Vec3::new(1.6, 0.9, 1.4).length())
}

/// The angular momentum of a solid box, kg m²/s, from its angular velocity in its own axes, rad/s.
fn momentum(size: Vec3, mass: f32, spin: Vec3) -> f64 {
    let square = size.as_dvec3() * size.as_dvec3();
    let inertia = (bevy::math::DVec3::splat(square.element_sum()) - square) / 12.0;
    f64::from(mass) * (inertia * spin.as_dvec3()).length()
}

fn spawn(world: &mut World) {
    let [spin, mass, gravity] = values(world);
    // By default as on the Moon, so that there is time to watch.
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.4)));
    for (i, size) in SIZES.into_iter().enumerate() {
        let skin = mesh(world, rounded_box(size, 0.04, 3));
        let (along, up) = (i as f32 - 1.0, 2.7 + 0.3 * i as f32);
        for (z, swaps) in [(1.0, true), (-1.0, false)] {
            let mut flies = world.spawn((
                InScene,
                Name::new("box"),
                RigidBox { particles: BoxParticles::Equimomental, ..RigidBox::new(size) }
                    .with_mass(mass),
                skin.clone(),
                Look::color(0x9aa1ab).roughness(0.6),
                Interpolate,
                Transform::from_xyz(2.2 * along, 0.9, z),
            ));
            let now = Representation::Particles;
            flies.insert(now).set_motion(Vec3::Y * up, thrown(i, spin));
            if swaps {
                flies.insert((Swaps, look_of(now)));
            }
        }
    }
}
