//! Crates that fall, land on an edge, tumble and come to rest.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::readings::is_in_flight;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "crate",
    heading: Heading::Bodies,
    title: "Falling crates",
    about: "8 particles and 28 distances each: no code integrates a rotation, and yet they turn",
    eye: Vec3::new(3.6, 3.4, 7.6),
    target: Vec3::new(0.0, 1.5, -0.4),
    seconds: 5.0,
    moment: 1.0,
    lesson: Some(Lesson {
        try_this: "throw the first crate with more spin, make it larger, or thicken the air",
        watch: "distances alone keep the spin of a crate in flight, as if its rotation were integrated; only air drag takes its share each second",
        formula: "ω = ω₀ (1 − drag)^t until it lands",
        sliders: &[
            SceneSlider { label: "Spin", unit: "rad/s", range: [0.0, 6.0], default: 3.0 },
            SceneSlider { label: "Edge", unit: "m", range: [0.6, 1.2], default: 1.0 },
            SceneSlider { label: "Air drag", unit: "per s", range: [0.0, 0.6], default: 0.1 },
        ],
        number: "Spin of the first crate",
        unit: "rad/s",
        after: 0.5,
        measure: |world| {
            let spin: AngularVelocity = component_of(world, "first crate")?;
            is_in_flight(world, "first crate").then_some(f64::from(spin.0.length()))
        },
        expect: |values, seconds| {
            f64::from(values[0]) * libm::pow(1.0 - f64::from(values[2]), seconds)
        },
        tolerance: [0.01, 0.01],
    }),
    spawn,
};

fn spawn(world: &mut World) {
    let [spin, edge, drag] = values(world);
    world.insert_resource(AirDrag(drag));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.45)));
    let crates = [
        (Vec3::new(0.0, 3.4, 0.0), Vec3::splat(edge), Vec3::new(0.5, 0.3, 0.7)),
        (Vec3::new(-2.2, 2.2, 0.9), Vec3::new(0.8, 0.8, 0.8), Vec3::new(0.9, 1.0, 0.1)),
        (Vec3::new(2.2, 3.6, -0.2), Vec3::new(0.7, 1.1, 0.7), Vec3::new(0.2, 0.4, 1.2)),
        (Vec3::new(-0.6, 4.6, -3.4), Vec3::new(1.1, 0.6, 0.8), Vec3::new(1.1, 0.2, 0.5)),
    ];
    for (n, (place, size, turn)) in crates.into_iter().enumerate() {
        let skin = mesh(world, rounded_box(size, 0.025, 2));
        let mut falls = world.spawn((
            InScene,
            Name::new(if n == 0 { "first crate" } else { "crate" }),
            RigidBox::new(size).with_mass(12.0 * size.element_product()),
            skin,
            Look::texture("textures/crate.png").roughness(0.8),
            Interpolate,
            Transform::from_translation(place).with_rotation(Quat::from_euler(
                EulerRot::XYZ,
                turn.x,
                turn.y,
                turn.z,
            )),
        ));
        if n == 0 {
            falls.set_angular_velocity(Vec3::new(2.0, 1.0, 2.0) * (spin / 3.0));
        }
    }
}
