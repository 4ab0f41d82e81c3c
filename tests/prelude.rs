//! The prelude: it names nothing that Bevy's does, so both may be imported whole.

use core::any::type_name;

use bevy::prelude::*;
use bevy_sinew::CollisionLayer;
use bevy_sinew::prelude::*;

/// A name that stands in both would be ambiguous here, and not compile.
#[test]
fn the_prelude_stands_beside_that_of_bevy() {
    let names = [
        type_name::<(SinewPlugins, SolverConfig, Gravity, AirDrag, Ground, BoundingBox)>(),
        type_name::<(SinewControl, SinewWorld, Interpolate, Particle, Mass, Radius, Pinned)>(),
        type_name::<(PinnedTo, GravityScale, ParticleRow, DistanceConstraint, Spring)>(),
        type_name::<(AngleConstraint, HingeConstraint, VolumeConstraint, Softness)>(),
        type_name::<(RigidBox, RigidMesh, RigidShape, Rope, Cloth, ClothPins, SoftBody)>(),
        type_name::<(SoftShape, Articulated, Ragdoll, Representation, Wind, Fluid, Floats)>(),
        type_name::<(Region, ControlForce, ExternalForce, ExternalImpulse, ExternalTorque)>(),
        type_name::<(LinearVelocity, AngularVelocity, WorldCenterOfMass, PhaseSystems)>(),
        type_name::<(SubstepSchedule, Collider, SurfaceMaterial, CollisionLayers, Sensor)>(),
        type_name::<(BodyContacts, ContactsDisabled, ContactEvents, ContactStarted)>(),
        type_name::<(Anchor, AttachTo, AttachmentOf, BodyAttachments, BodyBuilt, BreakAt)>(),
        type_name::<(Broke, RopeEnd)>(),
        type_name::<(ContactEnded, Sleep, Transform, Commands, Query<Entity>)>(),
    ];
    for name in names {
        assert!(name.contains("bevy"), "{name}");
    }
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
    assert!(ghost.meets(player) && player.meets(ghost));
    let wall = CollisionLayers::of_layers([Layer::default()], [Layer::Player]);
    assert_eq!(wall.memberships, 1);
    assert!(wall.meets(player) && !wall.meets(ghost));
}
