//! A playground: things to hang bodies from, slide down, jump on and knock over.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::FLOOR;
use crate::readings::deepest_below;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::skin::{Skin, SkinShape};
use crate::toys::Toy;

pub(super) const SCENE: Scene = Scene {
    name: "playground",
    heading: Heading::Together,
    title: "A playground",
    about: "spawn, pin, tie, cut, shoot and drag, and save it to a file; in a window the keys are listed below",
    eye: Vec3::new(0.6, 3.2, 9.3),
    target: Vec3::new(0.0, 1.0, -0.3),
    seconds: 5.0,
    moment: 1.3,
    lesson: Some(Lesson {
        try_this: "play with the Moon's gravity, in thick air, or without friction",
        watch: "whatever you do, nothing passes through the floor: what has landed lies on it",
        formula: "y ≥ h",
        sliders: &[
            SceneSlider { label: "Gravity", unit: "m/s²", range: [1.62, 9.81], default: 9.81 },
            SceneSlider { label: "Air drag", unit: "per s", range: [0.0, 0.9], default: 0.1 },
            SceneSlider { label: "Friction", unit: "", range: [0.0, 1.0], default: 0.6 },
        ],
        number: "Deepest below the floor",
        unit: "mm",
        // Once all has landed: a limb that lands is some millimetres deep for a tick, and the sheet of the trampoline for longer.
        after: 4.5,
        measure: |world| Some(deepest_below(world, FLOOR)),
        expect: |_, _| 0.0,
        tolerance: [1.0, 0.0],
    }),
    spawn,
};

// Everything here has a [`Skin`], so that it is drawn again after loading.
fn spawn(world: &mut World) {
    let [gravity, drag, friction] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(drag));
    let (wood, steel) = (Look::color(0x8a6a4b).roughness(0.8), Look::color(0xb9bec6).metal());
    let slab = Look::color(0x54616b).roughness(0.95);
    let level = Vec3::Y * (FLOOR - 0.2);
    let floor = block(world, "floor", Vec3::new(9.0, 0.4, 6.4), level, Quat::IDENTITY, slab);
    world.entity_mut(floor).insert(SurfaceMaterial::new(friction));
    gallows(world, &wood);
    slide(world, &wood);
    trampoline(world, &steel);
    // A pyramid of boxes, and bodies that can knock it over.
    for (n, (x, layer)) in
        [(-0.43, 0), (0.0, 0), (0.43, 0), (-0.215, 1), (0.215, 1), (0.0, 2)].into_iter().enumerate()
    {
        let place = Vec3::new(x, FLOOR - 0.06 + 0.4 * layer as f32, -1.5);
        Toy::Crate.spawn(world, place, n);
    }
    Toy::Ball.spawn(world, Vec3::new(3.0, 2.2, -1.5), 0);
    Toy::Jelly.spawn(world, Vec3::new(2.35, 1.7, 1.1), 0);
    Toy::Ragdoll.spawn(world, Vec3::new(-0.6, FLOOR, 0.9), 4);
}

/// A static box.
fn block(
    world: &mut World,
    name: &'static str,
    size: Vec3,
    at: Vec3,
    turn: Quat,
    look: Look,
) -> Entity {
    let solid = (Collider::cuboid(size), SurfaceMaterial::new(0.6), Skin::cuboid(size, look));
    let at = Transform::from_translation(at).with_rotation(turn);
    world.spawn((InScene, Name::new(name), solid, at)).id()
}

fn pillar(world: &mut World, radius: f32, height: f32, x: f32, z: f32, look: &Look) -> Entity {
    let skin = Skin::new(SkinShape::Cylinder { radius, height }, look.clone());
    let at = Transform::from_xyz(x, FLOOR + 0.5 * height, z);
    world.spawn((InScene, Name::new("post"), Collider::cylinder(radius, height), skin, at)).id()
}

/// A beam on two posts, from which a box and a cloth hang.
fn gallows(world: &mut World, wood: &Look) {
    let (high, left, right, z) = (2.5, -3.6, -1.5, -0.6);
    for x in [left, right] {
        pillar(world, 0.06, high, x, z, wood);
    }
    let size = Vec3::new(right - left + 0.5, 0.12, 0.12);
    let middle = Vec3::new(0.5 * (left + right), FLOOR + high + 0.06, z);
    let beam = block(world, "beam", size, middle, Quat::IDENTITY, wood.clone());
    let crate_ = Toy::Crate.spawn(world, Vec3::new(-3.0, 0.9, z), 0);
    let hook = (beam, Vec3::new(-3.0 - middle.x, -0.06, 0.0));
    let ends = Rope::between(hook, (crate_, Anchor::Corner(Vec3::Y)));
    let rope = Rope { segments: 16, mass: 0.2, radius: 0.018, ..ends };
    let hemp = Skin::own(Look::color(0xc9a66b).roughness(0.9));
    world.spawn((InScene, Name::new("rope"), rope, hemp, Interpolate, Transform::default()));
    let cloth = Cloth { radius: 0.011, ..Cloth::grid(0.75, 1.3, 15, 26) };
    let cloth = cloth.pinned(ClothPins::TopEdge);
    let silk = Skin::own(Look::color(0xb8434e).double_sided().roughness(0.85));
    let at = Transform::from_xyz(-2.1, middle.y - 0.08 - 0.65, z + 0.08);
    world.spawn((InScene, Name::new("cloth"), cloth, silk, Interpolate, at));
}

/// A board to slide and roll down.
fn slide(world: &mut World, wood: &Look) {
    let (length, slope) = (2.6, 0.45_f32);
    let (sin, cos) = libm::sincosf(slope);
    let middle = Vec3::new(2.6, FLOOR + 0.5 * length * sin, -1.5);
    let turn = Quat::from_rotation_z(slope);
    block(world, "slide", Vec3::new(length, 0.08, 1.2), middle, turn, wood.clone());
    let foot = Vec3::new(0.16, length * sin - 0.1, 1.2);
    let at = Vec3::new(2.6 + 0.5 * length * cos - 0.1, FLOOR + 0.5 * foot.y, -1.5);
    block(world, "foot", foot, at, Quat::IDENTITY, wood.clone());
}

/// A sheet on four posts that throws back bodies that fall onto it.
fn trampoline(world: &mut World, steel: &Look) {
    let (half, high, middle) = (0.75, 0.6, Vec2::new(2.35, 1.1));
    for (x, z) in [(-half, -half), (-half, half), (half, -half), (half, half)] {
        pillar(world, 0.035, high - 0.02, middle.x + x, middle.y + z, steel);
    }
    let cloth = Cloth {
        density: 0.4,
        stretch_compliance: 3e-4,
        radius: 0.02,
        ..Cloth::grid(2.0 * half, 2.0 * half, 18, 18)
    };
    let skin = Skin::own(Look::color(0x35506b).double_sided().roughness(0.9));
    let lies = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    let at = Transform::from_xyz(middle.x, FLOOR + high, middle.y).with_rotation(lies);
    let pinned = cloth.pinned(ClothPins::Corners);
    world.spawn((InScene, Name::new("trampoline"), pinned, skin, Interpolate, at));
}
