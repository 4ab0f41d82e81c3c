//! Named scenes shared by the gallery, the tests and the benchmarks, so that each is defined once.
//!
//! A scene only spawns entities and sets a few resources. Surfaces are described by [`Look`], which every renderer, with or without a GPU, translates into its
//! own materials. [`load`] swaps scenes in a running app.
//!
//! | scene | what it shows |
//! |---|---|
//! | `flag` | cloth on a grid, wind pressure, gusts, a texture |
//! | `crate` | boxes of 8 particles and 28 distances landing and tumbling |
//! | `square` | a 2D box of 4 particles and 6 distances |
//! | `ragdoll` | ragdolls that collapse |
//! | `ropes` | ropes: slack, swinging with a lantern, and attached to a moving hand |
//! | `banner` | cloth made from a mesh with a seam in its texture |
//! | `jelly` | a block of springs that lands and wobbles |
//! | `pendulums` | rods of different lengths that drift in and out of step |
//! | `charges` | electric forces in a box |
//! | `buoys` | loose particles that float as deep as their density requires |
//! | `boats` | boxes with buoyancy by their shape, in a current |
//! | `bricks` | three ways to compute a spin, and their effect on it |
//! | `soft` | balls that keep their volume, cubes of tetrahedra |
//! | `swap` | boxes that become rigid bodies and particles again in flight |
//! | `hinges` | angle limits: flaps, elbows, a tail of cone joints |
//! | `feathers` | drag by area and speed: sheets at their terminal speed, and a fan |
//! | `orbits` | an attractor and Kepler's ellipses |
//! | `flatland` | a world in 2D |
//! | `pile` | crates that collide by their shape: a heap and a tower |
//! | `drape` | cloth over a ball and a table, folds on folds |
//! | `stairs` | ragdolls that fall down a flight of stairs |
//! | `catch` | a crate caught by a sheet |
//! | `curtain` | a soft ball thrown against a curtain |
//! | `net` | marbles in two coarse sheets, of which one collides by its triangles |
//! | `hills` | a blanket, ragdolls and crates on a terrain |
//! | `tiles` | crates, a barrel and a ball over a floor of many colliders |
//! | `fence` | two blankets over fences that are meshes, of which one collides by its triangles |
//! | `slopes` | stacks on slopes that stick or slide by friction |
//! | `race` | rolling and sliding bodies on one slope |
//! | `billiards` | balls that bounce without loss |
//! | `bin` | 200 cubes of jelly in a bin |
//! | `chain` | loops of rope that hang in each other by contact |
//! | `rails` | coarse ropes across rails and each other, by particles and by segments |
//! | `belt` | friction on a moving kinematic collider; restitution |
//! | `loads` | rod, spring and compliant rod under one load |
//! | `catenary` | a hanging rope at rest on its catenary |
//! | `repose` | blocks on a slope: the angle of repose |
//! | `capacitor` | a charged pendulum between two plates |
//! | `integrators` | one spring by four integrators, and their energies |
//! | `reversal` | balls whose motion is reversed in time |
//! | `timestep` | a time step that changes in flight, and Verlet's previous position |
//! | `orders` | contradictory constraints in three solving orders |
//! | `inertia` | corners against equimomental particles |
//! | `planar` | planar friction beside Coulomb's |
//! | `car` | a torque on the wheels against a force on the body |
//! | `impulses` | an impulse, a force over time, and a teleport |
//! | `masses` | a distance between equal and unequal masses |
//! | `volumes` | a volume corrected by scaling and along its gradient |
//! | `damping` | velocity damping, exact and approximated |
//! | `straight` | collinear beads and coplanar corners |
//! | `step` | one step of position based dynamics in slow motion |
//! | `verlet` | Verlet integration frame by frame: the next position from the last two |
//! | `plane` | a plane as an equation and as an inequality |
//! | `throws` | one throw in vacuum, air, water and honey |
//! | `least` | the smallest mass-weighted displacement, compared with others |
//! | `areas` | an area corrected by scaling and along its gradient |
//! | `spins` | rotations by three integrators, and their energies |
//! | `playground` | a scene to spawn, pin, tie, cut and shoot in, saved to a file |
//! | `events` | sensors that count, layers that let red balls through, boxes that flash by the contact impulse |
//! | `sleep` | a field of sleeping stacks, and those that a ball wakes |
//! | `stage` | flag, capes, lanterns, bridge, heap, ragdolls and a river at once |
//! | `hammock` | a sheet on four ropes, with a crate in it |
//! | `sweeps` | two rods solved by Gauss–Seidel, and the error after each sweep |
//! | `million` | up to a million particles and two million springs: waves on a lake |

mod arrow;
mod bevy_version;
mod look;
mod props;
mod readings;
mod rounds;
mod scene;
mod scenes;
mod shapes;
mod skin;
mod toys;

pub use look::Look;
pub use scene::{Heading, InScene, Lesson, OnStage, Scene, SceneSlider};
pub use scenes::{ALL, find};
pub use shapes::{ball, capsule, coil, cylinder, rounded_box};
pub use skin::{Skin, SkinShape};
pub use toys::Toy;

use bevy::prelude::*;
use bevy_sinew::{
    AirDrag, BodyPart, Electric, Gravity, PartOf, ParticleBody, RegisterState, SinewClock,
    SinewControl, SolverConfig,
};

use crate::bevy_version::OnAdd;

/// What scenes need in addition to [`SinewPlugins`](bevy_sinew::SinewPlugins): meshes and looks for ragdolls and saved bodies, and the systems of scenes that
/// animate or measure.
///
/// Meshes and textures come through the asset server, so the app needs Bevy's plugins for assets, images, meshes and glTF.
pub struct ScenesPlugin;

impl Plugin for ScenesPlugin {
    fn build(&self, app: &mut App) {
        // Looks are restored by a rollback, and restored entities go with their scene; neither is compared or saved.
        app.register_unsaved_state::<Look>().register_unsaved_state::<InScene>();
        // A loaded file restores meshes and looks from this.
        app.register_state::<Skin>()
            .add_observer(skin::dress)
            .add_systems(Update, skin::dress_again);
        app.register_type::<Look>().add_observer(dress_part).add_observer(scenes::ropes::tie_ends);
        app.add_systems(Last, scene::measure);
        // Not while the simulation is paused: a system that pushes a body in every tick would go on pushing it.
        app.add_systems(
            FixedUpdate,
            (
                scenes::ropes::move_hand,
                scenes::swap::swap_bodies,
                scenes::belt::move_trays,
                scenes::reversal::turn_back,
                scenes::timestep::change_step,
                scenes::car::drive,
                scenes::impulses::push,
                scenes::damping::damp,
                rounds::restart,
                scenes::events::dispense,
                scenes::sleep::throw,
            )
                .run_if(time_passes),
        );
        // Drawings of a tick, made after it.
        let drawn = (
            scenes::integrators::step_oscillators,
            scenes::orders::draw_errors,
            scenes::step::show_step,
            scenes::sweeps::show_sweep,
            scenes::verlet::show_frame,
            scenes::least::draw_costs,
            scenes::spins::step_bricks,
            scenes::capacitor::draw_forces,
            scenes::masses::draw_remaining,
            scenes::events::count_and_flash,
            scenes::sleep::record_sleep,
        );
        app.add_systems(FixedLast, drawn);
    }
}

fn time_passes(control: Res<SinewControl>) -> bool {
    control.running()
}

/// Despawns the last scene and spawns another at time zero, with the scene's own settings and its sliders at their defaults.
pub fn load(world: &mut World, scene: &'static Scene) {
    let sliders = scene.lesson.map_or(&[][..], |lesson| lesson.sliders);
    let values: Vec<f32> = sliders.iter().map(|slider| slider.default).collect();
    load_with(world, scene, &values);
}

/// Loads a scene like [`load`], with values for its sliders, in their order. A value out of its slider's range is clamped to it; a missing or non-finite one is
/// replaced by the default.
pub fn load_with(world: &mut World, scene: &'static Scene, values: &[f32]) {
    let sliders = scene.lesson.map_or(&[][..], |lesson| lesson.sliders);
    let within = |(i, slider): (usize, &SceneSlider)| {
        let value = values.get(i).copied().filter(|value| value.is_finite());
        value.unwrap_or(slider.default).clamp(slider.range[0], slider.range[1])
    };
    let values = sliders.iter().enumerate().map(within).collect();
    let mut old = world.query_filtered::<Entity, With<InScene>>();
    let old: Vec<Entity> = old.iter(world).collect();
    for entity in old {
        // Despawning a body also despawns its particles, so some of these may be gone already.
        if let Ok(entity) = world.get_entity_mut(entity) {
            entity.despawn();
        }
    }
    world.insert_resource(OnStage { scene, values, reading: None, ended: None });
    world.insert_resource(SinewClock::default());
    world.insert_resource(SolverConfig::default());
    world.insert_resource(Gravity::default());
    world.insert_resource(AirDrag::default());
    world.insert_resource(Electric::default());
    (scene.spawn)(world);
    world.flush();
}

/// Gives each part of a ragdoll a mesh, in the colour of its figure.
fn dress_part(
    added: OnAdd<BodyPart>,
    mut commands: Commands,
    parts: Query<(&BodyPart, &Name, &PartOf)>,
    bodies: Query<&Look, With<ParticleBody>>,
    meshes: Option<ResMut<Assets<Mesh>>>,
) {
    let (Some(mut meshes), Ok((part, name, body))) = (meshes, parts.get(added.entity)) else {
        return;
    };
    let look = bodies.get(body.0).cloned().unwrap_or_default();
    let mesh = shapes::part_mesh(part, name);
    commands.entity(added.entity).insert((Mesh3d(meshes.add(mesh)), look));
}
