//! Toys of the playground: one of each kind of body, ready to be dropped.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::scene::InScene;
use crate::skin::{Skin, SkinShape};

/// A body to play with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Toy {
    /// A wooden crate of 6 kg.
    Crate,
    /// A ball of 2 kg that bounces.
    Ball,
    /// A rope of 1.6 m.
    Rope,
    /// A cloth of 1.2 m × 1.2 m.
    Cloth,
    /// A cube of jelly.
    Jelly,
    /// A ragdoll of 1.75 m.
    Ragdoll,
}

/// Colours of the toys, in turn.
const COLORS: [u32; 6] = [0xd1495b, 0x2f8f83, 0xe9b44c, 0x8e6bb0, 0x3d7ea6, 0xd9622b];

/// Edge of the crate and of the jelly, and radius of the ball, metres.
const CRATE: f32 = 0.4;
const JELLY: f32 = 0.42;
const BALL: f32 = 0.18;
/// Height above the place at which the rope and the cloth start, metres: they fall onto what is there.
const ABOVE: f32 = 0.7;
/// Height above the place at which all others start, metres: clear of the ground, however it slopes.
const GAP: f32 = 0.06;

impl Toy {
    /// All toys, in the order in which a gallery offers them.
    pub const ALL: [Self; 6] =
        [Self::Crate, Self::Ball, Self::Rope, Self::Cloth, Self::Jelly, Self::Ragdoll];

    /// Name on a screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crate => "Box",
            Self::Ball => "Ball",
            Self::Rope => "Rope",
            Self::Cloth => "Cloth",
            Self::Jelly => "Jelly",
            Self::Ragdoll => "Ragdoll",
        }
    }

    /// Spawns one above a place, metres. `number` picks its colour.
    pub fn spawn(self, world: &mut World, place: Vec3, number: usize) -> Entity {
        let color = COLORS[number % COLORS.len()];
        let at = |up: f32| Transform::from_translation(place + Vec3::Y * up);
        let common = (InScene, Name::new(self.name()), Interpolate);
        match self {
            Self::Crate => {
                let size = Vec3::splat(CRATE);
                let skin = Skin::cuboid(size, Look::texture("textures/crate.png").roughness(0.8));
                let body = RigidBox::new(size).with_mass(6.0);
                let rough = SurfaceMaterial::new(0.6);
                world.spawn((common, body, rough, skin, at(0.5 * CRATE + GAP))).id()
            }
            Self::Ball => {
                let look = Look::texture("textures/ball.png").roughness(0.35);
                let skin = Skin::new(SkinShape::Ball { radius: BALL }, look);
                let body = RigidMesh::mass(2.0).shaped(RigidShape::Sphere { radius: BALL });
                let rubber = SurfaceMaterial::new(0.6).with_restitution(0.8);
                world.spawn((common, body, rubber, skin, at(BALL + GAP))).id()
            }
            Self::Rope => {
                let half = Vec3::X * 0.8;
                let ends = Rope::between(-half, half);
                let rope =
                    Rope { segments: 20, mass: 0.3, radius: 0.018, pin_start: false, ..ends };
                let skin = Skin::own(Look::color(0xc9a66b).roughness(0.9));
                world.spawn((common, rope, skin, at(ABOVE))).id()
            }
            Self::Cloth => {
                let cloth = Cloth { radius: 0.011, ..Cloth::grid(1.2, 1.2, 24, 24) };
                let skin = Skin::own(Look::color(color).double_sided().roughness(0.9));
                let lies = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
                world.spawn((common, cloth, skin, at(ABOVE).with_rotation(lies))).id()
            }
            Self::Jelly => {
                let cube = SoftBody {
                    stiffness: 1e4,
                    damping: 0.5,
                    // A quarter of a cell, so that its surface has no holes for larger particles.
                    radius: JELLY / 8.0,
                    ..SoftBody::cuboid(Vec3::splat(JELLY), UVec3::splat(3))
                };
                let skin = Skin::own(Look::color(color).roughness(0.25));
                world.spawn((common, cube, skin, at(0.5 * JELLY + JELLY / 8.0 + GAP))).id()
            }
            Self::Ragdoll => {
                let skin = Skin::own(Look::color(color).roughness(0.55));
                world.spawn((common, Ragdoll::default(), skin, at(GAP))).id()
            }
        }
    }
}
