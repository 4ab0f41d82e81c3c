//! Many kinds of bodies at once, as in a level of a game, around a river.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BoxParticles, Region};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::deepest_below;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, capsule, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "stage",
    heading: Heading::Together,
    title: "A level with everything",
    about: "a flag, five capes, lanterns, a rope bridge, sixty crates, ten ragdolls and ten floaters in a river, in one wind; it may take more than 16 ms a frame",
    eye: Vec3::new(5.0, 4.7, 12.2),
    target: Vec3::new(0.5, 1.15, -0.3),
    seconds: 6.0,
    moment: 2.6,
    lesson: Some(Lesson {
        try_this: "make the wind stronger or steadier, or the river faster",
        watch: "crates and figures lie on the land, floats drift with the river, capes and the flag blow in the wind; nothing passes through the ground",
        formula: "y ≥ 0",
        sliders: &[
            SceneSlider { label: "Wind", unit: "Pa", range: [0.0, 12.0], default: 6.5 },
            SceneSlider { label: "Gusts", unit: "", range: [0.0, 1.0], default: 0.5 },
            SceneSlider { label: "Current", unit: "m/s", range: [0.0, 1.0], default: 0.5 },
        ],
        number: "Deepest below the ground",
        unit: "mm",
        after: 0.5,
        measure: |world| Some(deepest_below(world, 0.0)),
        expect: |_, _| 0.0,
        tolerance: [1.0, 0.0],
    }),
    spawn,
};

/// Heights of the land and of the water, metres.
const LAND: f32 = 0.7;
const WATER: f32 = 0.52;
/// The banks of the river along z, and half its length, metres.
const BANKS: [f32; 2] = [1.9, 4.3];
const HALF: f32 = 9.0;
/// Direction of the wind.
const DOWNWIND: Vec3 = Vec3::new(12.0 / 13.0, 0.0, 5.0 / 13.0);

fn spawn(world: &mut World) {
    world.insert_resource(AirDrag(0.3));
    let [strength, gusts, current] = values(world);
    let pressure = DOWNWIND * strength;
    world.spawn((
        InScene,
        Name::new("breeze"),
        Wind { pressure, gusts, gust_length: 1.4, gust_period: 1.1 },
    ));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    land(world);
    river(world, current);
    bridge(world);
    flag(world);
    for (n, color) in [0xb8434e, 0xe0b040, 0x3f6f9f, 0x66a182, 0x8e6bb0].into_iter().enumerate() {
        cape(world, Vec3::new(-4.7 + 1.35 * n as f32, LAND, -2.0 - 0.25 * (n % 2) as f32), color);
    }
    lanterns(world);
    crates(world);
    figures(world);
}

/// A static box.
fn block(world: &mut World, size: Vec3, at: Vec3, look: Look) -> Entity {
    let skin = mesh(world, rounded_box(size, 0.03, 2));
    let solid = (Collider::cuboid(size), SurfaceMaterial::new(0.6));
    world.spawn((InScene, solid, skin, look, Transform::from_translation(at))).id()
}

fn land(world: &mut World) {
    let grass = Look::color(0x7d9464).roughness(0.95);
    let back = -5.2;
    let deep = BANKS[0] - back;
    let size = Vec3::new(2.0 * HALF, LAND, deep);
    block(world, size, Vec3::new(0.0, 0.5 * LAND, back + 0.5 * deep), grass.clone());
    let size = Vec3::new(2.0 * HALF, LAND, 1.5);
    block(world, size, Vec3::new(0.0, 0.5 * LAND, BANKS[1] + 0.75), grass);
}

/// Water that flows at `current` m/s.
fn river(world: &mut World, current: f32) {
    let [near, far] = [BANKS[1], BANKS[0]];
    let (wide, middle) = (near - far, 0.5 * (near + far));
    world.spawn((
        InScene,
        Name::new("river"),
        Fluid::flowing(Vec3::X * current),
        Region::boxed(Vec3::new(2.0 * HALF, 2.0 * WATER, wide)),
        Transform::from_xyz(0.0, WATER, middle),
    ));
    let slab = mesh(world, Cuboid::new(2.0 * HALF, WATER, wide));
    let blue = Look::color(0x2f86b5).roughness(0.08).opacity(0.62);
    world.spawn((InScene, slab, blue, Transform::from_xyz(0.0, 0.5 * WATER, middle)));
    // Walls at both ends of the river keep the floats in it.
    let stone = Look::color(0x8c8780).roughness(0.85);
    for x in [-HALF + 0.1, HALF - 0.1] {
        let at = Vec3::new(x, 0.5 * LAND, middle);
        block(world, Vec3::new(0.2, LAND, wide), at, stone.clone());
    }
    let size = Vec3::new(0.5, 0.36, 0.5);
    let skin = mesh(world, rounded_box(size, 0.04, 3));
    for n in 0..10_u32 {
        let share = 0.35 + 0.06 * (n % 4) as f32;
        let z = middle + 0.55 * ((n % 3) as f32 - 1.0);
        let at = Transform::from_xyz(-7.6 + 1.3 * n as f32, WATER + 0.1, z)
            .with_rotation(Quat::from_rotation_y(0.4 * n as f32));
        let hull = RigidBox { particles: BoxParticles::Equimomental, ..RigidBox::new(size) };
        let look = Look::color([0xd9622b, 0xe9b44c, 0xf3f1ea][n as usize % 3]).roughness(0.5);
        world.spawn((
            InScene,
            Name::new("floater"),
            hull.with_mass(1000.0 * share * size.element_product()),
            Floats::OWN,
            (skin.clone(), look, Interpolate),
            at,
        ));
    }
}

/// Planks from bank to bank, each tied to the next at two corners.
fn bridge(world: &mut World) {
    const PLANKS: usize = 9;
    let (x, high) = (1.9, LAND + 0.06);
    let wood = Look::color(0x9a7650).roughness(0.8);
    let middle = 0.5 * (BANKS[0] + BANKS[1]);
    let (size, gap) = (Vec3::new(1.1, 0.06, 0.2), 0.27);
    let skin = mesh(world, rounded_box(size, 0.015, 2));
    let planks: [Entity; PLANKS] = core::array::from_fn(|n| {
        let z = middle + gap * (n as f32 - 0.5 * (PLANKS - 1) as f32);
        world
            .spawn((
                InScene,
                Name::new("plank"),
                RigidBox::new(size).with_mass(3.0),
                (skin.clone(), wood.clone(), Interpolate),
                Transform::from_xyz(x, high, z),
            ))
            .id()
    });
    let hemp = Look::color(0xc9a66b).roughness(0.9);
    let stake = (0.05, 0.75);
    for side in [-1.0, 1.0] {
        let ends = [-1.0, 1.0].map(|end| {
            let z = middle + end * (0.5 * (BANKS[1] - BANKS[0]) + 0.12);
            let post = post(world, stake.0, stake.1);
            let at = Transform::from_xyz(x + 0.62 * side, LAND + 0.5 * stake.1 - 0.1, z);
            world.spawn((InScene, post, wood.clone(), at)).id()
        });
        let hook = |end: usize| {
            let out = if end == 0 { 1.0 } else { -1.0 };
            (
                ends[end],
                Anchor::Point(Vec3::new(0.0, high - LAND - 0.5 * stake.1 + 0.1, 0.05 * out)),
            )
        };
        let corner = |plank: Entity, z: f32| (plank, Anchor::Corner(Vec3::new(side, 0.0, z)));
        let mut piece = |from: (Entity, Anchor), to: (Entity, Anchor)| {
            let rope = Rope { segments: 1, mass: 0.1, radius: 0.015, ..Rope::between(from, to) };
            world.spawn((InScene, Name::new("bridge rope"), rope, hemp.clone(), Interpolate));
        };
        piece(hook(0), corner(planks[0], -1.0));
        for pair in planks.windows(2) {
            piece(corner(pair[0], 1.0), corner(pair[1], -1.0));
        }
        piece(corner(planks[PLANKS - 1], 1.0), hook(1));
    }
}

fn flag(world: &mut World) {
    let (at, high, size) = (Vec3::new(-6.0, LAND, -1.2), 3.4, Vec2::new(1.92, 1.2));
    let pole = post(world, 0.035, high);
    let up = Transform::from_translation(at + Vec3::Y * (0.5 * high));
    world.spawn((InScene, pole, Look::color(0xb9bec6).metal(), up));
    let knob = mesh(world, ball(0.07));
    let top = Transform::from_translation(at + Vec3::Y * high);
    world.spawn((InScene, knob, Look::color(0xd9a441).metal(), top));
    let cloth = Cloth { density: 0.18, ..Cloth::grid(size.x, size.y, 32, 20) };
    world.spawn((
        InScene,
        Name::new("flag"),
        cloth.pinned(ClothPins::LeftEdge),
        Look::texture("textures/flag.png").double_sided().roughness(0.85),
        Interpolate,
        Transform::from_translation(at + Vec3::new(0.5 * size.x + 0.04, high - 0.7, 0.0)),
    ));
}

/// A stone figure with a cape over its shoulders.
fn cape(world: &mut World, at: Vec3, color: u32) {
    let stone = Look::color(0xa7a197).roughness(0.8);
    let (radius, high) = (0.21, 1.4);
    let skin = mesh(world, capsule(radius, high));
    let trunk = Collider::capsule(radius, high - 2.0 * radius);
    let place = Transform::from_translation(at + Vec3::Y * (0.5 * high));
    world.spawn((InScene, Name::new("statue"), trunk, skin, stone.clone(), place));
    let (head, up) = (mesh(world, ball(0.15)), Vec3::Y * (high + 0.12));
    let solid = Collider::sphere(0.15);
    world.spawn((InScene, solid, head, stone, Transform::from_translation(at + up)));
    // The particles are wide enough to leave no gaps for the colliders here, so that the cape need not collide by its triangles.
    let cloth = Cloth { radius: 0.018, ..Cloth::grid(0.95, 1.15, 23, 23) };
    // On the leeward side of the figure, so that the wind lifts its free parts.
    let hangs = at + Vec3::new(0.12, high - 0.1 - 0.575, radius + 0.05);
    world.spawn((
        InScene,
        Name::new("cape"),
        cloth.pinned(ClothPins::TopEdge),
        Look::color(color).double_sided().roughness(0.85),
        Interpolate,
        Transform::from_translation(hangs).with_rotation(Quat::from_rotation_y(0.25)),
    ));
}

/// Lanterns on ropes from a beam, and slack lines between the posts.
fn lanterns(world: &mut World) {
    let (left, right, z, high) = (2.6, 6.6, -2.6, 3.0);
    let wood = Look::color(0x8a6a4b).roughness(0.8);
    let hemp = Look::color(0xc9a66b).roughness(0.9);
    for x in [left, right] {
        let post = post(world, 0.07, high);
        let at = Transform::from_xyz(x, LAND + 0.5 * high, z);
        world.spawn((InScene, post, wood.clone(), at));
    }
    let middle = Vec3::new(0.5 * (left + right), LAND + high + 0.06, z);
    let size = Vec3::new(right - left + 0.6, 0.12, 0.12);
    let beam = block(world, size, middle, wood);
    let size = Vec3::new(0.2, 0.28, 0.2);
    let skin = mesh(world, rounded_box(size, 0.06, 4));
    let cap = mesh(world, cylinder(0.09, 0.04));
    let iron = Look::color(0x2d3036).metal();
    for n in 0..6_u32 {
        let x = left + 0.45 + 0.62 * n as f32;
        let down = 0.7 + 0.35 * (n % 3) as f32;
        // Displaced, so that they swing.
        let at = Vec3::new(x - 0.35, middle.y - 0.1 - down - 0.14, z + 0.25);
        let lamp = world
            .spawn((
                InScene,
                Name::new("lantern"),
                RigidBox::new(size).with_mass(1.2),
                (skin.clone(), Look::color(0xffd67a).roughness(0.3), Interpolate),
                Transform::from_translation(at),
            ))
            .id();
        let lid = Transform::from_xyz(0.0, 0.5 * size.y + 0.01, 0.0);
        world.spawn((ChildOf(lamp), cap.clone(), iron.clone(), lid));
        let hook = (beam, Anchor::Point(Vec3::new(x - middle.x, -0.06, 0.0)));
        let rope = Rope::between(hook, (lamp, Anchor::Corner(Vec3::Y)));
        let rope = Rope { segments: 16, mass: 0.25, radius: 0.014, ..rope };
        world.spawn((InScene, Name::new("lantern rope"), rope, hemp.clone(), Interpolate));
    }
    // From the flag pole to the beam, and from the posts to the ground. None ends inside a collider.
    let top = Vec3::new(-5.9, LAND + 2.2, -1.16);
    for (from, to, slack) in [
        (top, Vec3::new(left - 0.12, LAND + 2.8, z), 0.06),
        (top + Vec3::Y * 0.2, Vec3::new(-4.9, LAND + 0.2, -4.6), 0.08),
        (Vec3::new(right, LAND + 2.9, z - 0.13), Vec3::new(right + 1.6, LAND + 0.1, -4.6), 0.1),
        (Vec3::new(left, LAND + 2.9, z - 0.13), Vec3::new(left - 1.6, LAND + 0.1, -4.6), 0.1),
    ] {
        let rope =
            Rope { segments: 30, mass: 0.6, radius: 0.016, slack, ..Rope::between(from, to) };
        let rope = Rope { pin_end: true, ..rope };
        world.spawn((InScene, Name::new("line"), rope, hemp.clone(), Interpolate));
    }
}

/// Sixty crates poured into a heap.
fn crates(world: &mut World) {
    const EDGE: f32 = 0.4;
    let skin = mesh(world, rounded_box(Vec3::splat(EDGE), 0.015, 2));
    for n in 0..60_u32 {
        let (layer, place) = (n / 9, n % 9);
        let [x, z] = [place % 3, place / 3].map(|i| (i as f32 - 1.0) * 0.52);
        let drift = 0.1 * (layer % 3) as f32 - 0.1;
        let at = Vec3::new(4.9 + x + drift, LAND + 0.3 + 0.56 * layer as f32, -0.4 + z - drift);
        let turn = 0.35 * layer as f32 + 0.2 * place as f32;
        let turn = Quat::from_euler(EulerRot::XYZ, 0.4 * turn, turn, 0.3 * turn);
        world.spawn((
            InScene,
            Name::new("crate"),
            RigidBox::new(Vec3::splat(EDGE)).with_mass(4.0),
            SurfaceMaterial::new(0.6),
            (skin.clone(), Look::texture("textures/crate.png").roughness(0.8), Interpolate),
            Transform::from_translation(at).with_rotation(turn),
        ));
    }
}

/// Ten ragdolls: most fall onto the land, one onto the bridge, one into the river.
fn figures(world: &mut World) {
    let colors = [0xd9622b, 0x2f8f83, 0xe0b040, 0x8e6bb0, 0x3d7ea6];
    for n in 0..10_u32 {
        let (x, z) = match n {
            8 => (1.9, 3.1),
            9 => (-2.4, 3.0),
            n => (-4.6 + 1.55 * (n % 4) as f32, if n < 4 { 0.9 } else { -0.5 }),
        };
        let high = LAND + 0.4 + 0.25 * (n % 3) as f32 + if n > 7 { 0.6 } else { 0.0 };
        let turn = Quat::from_rotation_y(0.9 * n as f32)
            * Quat::from_rotation_z(0.25 * (n % 4) as f32 - 0.35);
        world.spawn((
            InScene,
            Name::new("ragdoll"),
            Ragdoll::default(),
            Look::color(colors[n as usize % colors.len()]).roughness(0.55),
            Interpolate,
            Transform::from_xyz(x, high, z).with_rotation(turn),
        ));
    }
}
