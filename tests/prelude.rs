//! The prelude is short and shares no name with Bevy's, so a game may import both whole.

use core::any::type_name;

use bevy::prelude::*;
use bevy_sinew::CollisionLayer;
use bevy_sinew::prelude::*;

/// Names of types and the paths that they resolve to. A name that is in both preludes would be ambiguous here, and not compile.
macro_rules! types {
    ($($name:ident),* $(,)?) => {
        [$((stringify!($name), type_name::<$name>())),*]
    };
}

/// The traits of the prelude, which have no type name: [`traits`] uses them, so that they would be ambiguous there.
const TRAITS: [&str; 2] = ["BodyCommandsExt", "SinewCommandsExt"];
fn traits<'a>(entity: EntityCommands<'a>, world: Commands<'a, 'a>)
where
    EntityCommands<'a>: BodyCommandsExt,
    Commands<'a, 'a>: SinewCommandsExt,
{
    let _ = (entity, world);
}

/// The names that the source exports in the prelude, sorted.
fn exported() -> Vec<&'static str> {
    let source = include_str!("../crates/bevy_sinew/src/lib.rs");
    let (_, prelude) = source.split_once("pub mod prelude {").expect("there is a prelude");
    let code = prelude.lines().filter(|line| !line.trim_start().starts_with("//"));
    let words = code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'));
    let mut names: Vec<_> =
        words.filter(|word| word.starts_with(|c: char| c.is_uppercase())).collect();
    names.sort_unstable();
    names
}

#[test]
fn the_prelude_has_about_fifty_names_and_shares_none_with_bevys() {
    let types = types![
        AirDrag,
        AngularVelocity,
        Anchor,
        AttachTo,
        BodyBuilt,
        BoundingBox,
        BreakAt,
        Broke,
        Cloth,
        ClothPins,
        Collider,
        CollisionLayers,
        ContactEnded,
        ContactEvents,
        ContactStarted,
        DistanceConstraint,
        ExternalForce,
        ExternalImpulse,
        ExternalTorque,
        Floats,
        Fluid,
        Gravity,
        GravityScale,
        Ground,
        Interpolate,
        LinearVelocity,
        Mass,
        Particle,
        Pinned,
        PinnedTo,
        Radius,
        Ragdoll,
        RigidBox,
        RigidMesh,
        RigidShape,
        Rope,
        Sensor,
        SinewControl,
        SinewPlugins,
        SinewQuery,
        SinewWorld,
        Sleep,
        SoftBody,
        Softness,
        SolverConfig,
        Spring,
        SurfaceMaterial,
        Wind,
    ];
    for (name, from) in types {
        assert!(from.contains("sinew"), "{name} is {from}");
    }
    let _ = traits;
    let mut listed: Vec<_> = types.iter().map(|(name, _)| *name).chain(TRAITS).collect();
    listed.sort_unstable();
    assert_eq!(listed, exported(), "the list above is the prelude");
    assert!((45..=52).contains(&listed.len()), "{} names", listed.len());
    // Bevy's own names still resolve to Bevy.
    assert!(type_name::<(Transform, Commands, Query<Entity>)>().contains("bevy_ecs"));
}

#[derive(CollisionLayer, Clone, Copy, Default)]
enum Layer {
    #[default]
    Wall,
    /// With a doc of its own.
    Player,
    Ghost,
}

#[test]
fn layers_are_the_variants_of_an_enum_in_their_order() {
    let ghost = CollisionLayers::of_layers([Layer::Ghost], [Layer::Player]);
    assert_eq!(ghost, CollisionLayers::of(&[2], &[1]));
    let player = CollisionLayers::of_layers([Layer::Player], [Layer::Wall, Layer::Ghost]);
    assert!(ghost.interacts_with(player) && player.interacts_with(ghost));
    let wall = CollisionLayers::of_layers([Layer::default()], [Layer::Player]);
    assert_eq!(wall.memberships, 1);
    assert!(wall.interacts_with(player) && !wall.interacts_with(ghost));
}
