//! Boxes that turn from particles into rigid bodies and back while they fly, and a twin of each that does not.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BoxParticles, Representation};
use bevy_sinew::{RigidIntegrator, SinewClock};

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "swap",
    heading: Heading::Bodies,
    title: "Particles or rigid, at any time",
    about: "the front row changes what it is every second: orange as particles, blue as a rigid body; it keeps up with the grey row, which never changes",
    eye: Vec3::new(1.6, 4.2, 8.8),
    target: Vec3::new(0.0, 2.0, 0.0),
    seconds: 6.0,
    moment: 1.6,
    lesson: None,
    spawn,
};

/// A body that changes its representation with every second of simulated time.
#[derive(Component)]
pub(crate) struct Swaps;

/// As which it is seen.
fn look_of(representation: Representation) -> Look {
    let color = if representation == Representation::Particles { 0xd9622b } else { 0x3d7ea6 };
    Look::color(color).roughness(0.45)
}

/// Changes what is to change; a function of the simulation's time alone.
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

fn spawn(world: &mut World) {
    // As on the Moon, so that there is time to look.
    world.insert_resource(Gravity(Vec3::new(0.0, -1.62, 0.0)));
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.4)));
    let sizes = [Vec3::new(0.5, 0.7, 1.0), Vec3::splat(0.7), Vec3::new(1.1, 0.35, 0.7)];
    for (i, size) in sizes.into_iter().enumerate() {
        let skin = mesh(world, rounded_box(size, 0.04, 3));
        let (along, up) = (i as f32 - 1.0, 2.7 + 0.3 * i as f32);
        for (z, swaps) in [(1.0, true), (-1.0, false)] {
            let mut thrown = world.spawn((
                InScene,
                Name::new("box"),
                RigidBox { particles: BoxParticles::Equimomental, ..RigidBox::new(size) },
                skin.clone(),
                Look::color(0x9aa1ab).roughness(0.6),
                Interpolate,
                Transform::from_xyz(2.2 * along, 0.9, z),
            ));
            let now = Representation::Particles;
            thrown.insert(now).set_motion(Vec3::Y * up, Vec3::new(1.6, 0.9, 0.4 - along));
            if swaps {
                thrown.insert((Swaps, look_of(now)));
            }
        }
    }
}
