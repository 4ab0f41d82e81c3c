//! The actions of the tools.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{AttachmentOf, CreationOrder, MouseDrag};
use sinew_scenes::{InScene, Look, Skin, SkinShape, Toy};

use super::aim::{self, PickedPoint};
use super::{Tool, Tools, cut, file};

/// A static hook that a body is pinned to. It is part of the state, so that it can be removed after loading.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub(super) struct Hook;

/// A ball that was shot.
#[derive(Component)]
struct Shot;

/// Radius of a hook, metres.
const HOOK: f32 = 0.035;
/// Largest distance of a hook from the pointer at which it is picked, metres.
const NEAR_HOOK: f32 = 0.09;
/// Radius, metres, mass, kg, and speed, m/s, of a ball that is shot.
const SHOT: (f32, f32, f32) = (0.11, 4.0, 13.0);
/// Largest number of balls: the oldest is despawned.
const SHOTS: usize = 24;
/// Length of a segment of a rope, metres, and largest number of segments.
const PIECE: f32 = 0.08;
const PIECES: u32 = 60;

/// Carries out the actions of this frame.
pub(super) fn work(world: &mut World) {
    let actions = core::mem::take(&mut world.resource_mut::<Tools>().actions);
    for (tool, ray) in actions {
        let message = match tool {
            Tool::Spawn(toy) => spawn(world, toy, ray),
            Tool::Pin => pin(world, ray),
            Tool::Rod => tie(world, ray, true),
            Tool::Rope => tie(world, ray, false),
            // It repeats while the key is down: the last message stays until something is cut.
            Tool::Cut => match cut::cut(world, ray) {
                0 => continue,
                1 => "Cut 1 thread.".into(),
                threads => format!("Cut {threads} threads."),
            },
            Tool::Shoot => shoot(world, ray),
            Tool::Remove => remove(world, ray),
            Tool::Save => file::save(world),
            Tool::Load => file::load(world),
        };
        world.resource_mut::<Tools>().message = message;
    }
}

fn spawn(world: &mut World, toy: Toy, ray: Ray3d) -> String {
    let place = aim::place(world, ray);
    let mut tools = world.resource_mut::<Tools>();
    let number = tools.spawned;
    tools.spawned += 1;
    toy.spawn(world, place, number);
    format!("Spawned a {}.", toy.name().to_lowercase())
}

/// Spawns a static hook to tie a body to.
fn hook(world: &mut World, point: Vec3, color: u32) -> Entity {
    let skin =
        Skin::new(SkinShape::Ball { radius: HOOK }, Look::color(color).roughness(0.3).metal());
    let at = Transform::from_translation(point);
    // With a `CreationOrder` it is part of the simulation's state, and is saved and restored with it.
    let hook = (Hook, CreationOrder::default(), skin, at);
    world.spawn((InScene, Name::new("pin"), hook)).id()
}

/// The hook under the pointer: the nearest one within reach.
fn hook_under(world: &mut World, ray: Ray3d) -> Option<Entity> {
    // The body that hangs on it may hide it.
    let far = aim::depth(world, ray, true) + NEAR_HOOK;
    let mut hooks = world.query_filtered::<(Entity, &Transform), With<Hook>>();
    let near = hooks.iter(world).filter_map(|(entity, at)| {
        let (depth, off) = aim::off_ray(ray, at.translation);
        (depth > 0.0 && depth < far && off < NEAR_HOOK).then_some((off, entity))
    });
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, entity)| entity)
}

/// Removes a hook and the attachments to it.
fn unhook(world: &mut World, hook: Entity) {
    let mut ties = world.query::<(Entity, &AttachTo)>();
    let ties: Vec<Entity> =
        ties.iter(world).filter(|(_, to)| to.entity == hook).map(|(tie, _)| tie).collect();
    for tie in ties {
        world.despawn(tie);
    }
    world.despawn(hook);
}

fn pin(world: &mut World, ray: Ray3d) -> String {
    if let Some(hook) = hook_under(world, ray) {
        unhook(world, hook);
        return "Unpinned.".into();
    }
    let Some(spot) = aim::spot(world, ray).filter(|spot| spot.body.is_some()) else {
        return "Nothing to pin there.".into();
    };
    let hook = hook(world, spot.point, 0xd1495b);
    let tie = AttachTo::new(hook).part(spot.anchor);
    world.spawn((tie, AttachmentOf(spot.entity)));
    "Pinned. Use the tool on the pin to remove it.".into()
}

/// Stores the first end; with the second one, spawns a rod or a rope between them.
fn tie(world: &mut World, ray: Ray3d, rigid: bool) -> String {
    let Some(spot) = aim::spot(world, ray) else { return "Nothing to tie there.".into() };
    let Some(first) = take_first(world) else {
        let mark = Skin::new(SkinShape::Ball { radius: 1.2 * HOOK }, Look::color(0xf2d544));
        let mark = world.spawn((InScene, mark, Transform::from_translation(spot.point))).id();
        world.resource_mut::<Tools>().first = Some((spot, mark));
        return "First end set; now the second.".into();
    };
    // An end may have been despawned meanwhile.
    let there = |spot: &PickedPoint| world.get_entity(spot.entity).is_ok();
    if !there(&first) || !there(&spot) {
        return "The first end was removed.".into();
    }
    let rigid_body = matches!(spot.anchor, Anchor::Point(_));
    if first.entity == spot.entity && (rigid_body || first.point.distance(spot.point) < 1e-3) {
        return "Both ends are on the same body.".into();
    }
    if first.body.is_none() && spot.body.is_none() {
        return "Neither end is on a body.".into();
    }
    let length = now(world, &first).distance(spot.point);
    let [start, end] = [first, spot].map(|spot| match spot.body {
        Some(_) => (spot.entity, spot.anchor),
        None => (hook(world, spot.point, 0xb9bec6), Anchor::Whole),
    });
    let segments = if rigid { 1 } else { ((length / PIECE) as u32).clamp(3, PIECES) };
    let rope = Rope {
        segments,
        mass: if rigid { 0.3 } else { 0.15 * length.max(0.2) },
        radius: if rigid { 0.022 } else { 0.015 },
        ..Rope::between(start, end)
    };
    let (name, look) = if rigid {
        ("rod", Look::color(0xc8ccd2).metal())
    } else {
        ("rope", Look::color(0xc9a66b).roughness(0.9))
    };
    world.spawn((InScene, Name::new(name), rope, Skin::own(look), Interpolate));
    format!("Added a {name} of {length:.2} m.")
}

/// Takes the first end of a tie, and despawns its marker.
pub(super) fn take_first(world: &mut World) -> Option<PickedPoint> {
    let (spot, mark) = world.resource_mut::<Tools>().first.take()?;
    world.try_despawn(mark).ok();
    Some(spot)
}

/// Current position of a spot: its body may have moved since.
fn now(world: &World, spot: &PickedPoint) -> Vec3 {
    let particle = world.get::<Particle>(spot.entity).map(|particle| particle.position);
    match (&spot.anchor, world.get::<Transform>(spot.entity)) {
        (Anchor::Point(local), Some(frame)) => frame.transform_point(*local),
        _ => particle.unwrap_or(spot.point),
    }
}

fn shoot(world: &mut World, ray: Ray3d) -> String {
    let mut shots = world.query_filtered::<(&CreationOrder, Entity), With<Shot>>();
    let mut old: Vec<(CreationOrder, Entity)> =
        shots.iter(world).map(|(order, shot)| (*order, shot)).collect();
    old.sort_unstable();
    if let Some(&(_, oldest)) = old.first().filter(|_| old.len() >= SHOTS) {
        world.despawn(oldest);
    }
    let (radius, mass, speed) = SHOT;
    let ball = RigidMesh::mass(mass).shaped(RigidShape::Sphere { radius });
    let skin = Skin::new(SkinShape::Ball { radius }, Look::color(0x3a3f47).metal());
    let at = Transform::from_translation(ray.origin + ray.direction * 0.5);
    let motion = LinearVelocity(ray.direction * speed);
    world.spawn((InScene, Name::new("shot"), Shot, ball, motion, skin, Interpolate, at));
    format!("Shot at {speed} m/s.")
}

fn remove(world: &mut World, ray: Ray3d) -> String {
    if let Some(hook) = hook_under(world, ray) {
        unhook(world, hook);
        return "Unpinned.".into();
    }
    let Some(body) = aim::spot(world, ray).and_then(|spot| spot.body) else {
        return "No body there.".into();
    };
    // Releases the body before it is despawned.
    world.resource_mut::<MouseDrag>().grabbed = None;
    world.despawn(body);
    "Removed.".into()
}
