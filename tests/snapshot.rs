//! Saving and restoring the simulation by cloning its components, as a rollback plugin or a save game does.

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AirFlow, AnyConstraint, AreaConstraint, Attractor, BendConstraint, BodyPart, BodySolver,
    Charge, ColliderMotion, CollinearConstraint, ConeConstraint, ConstraintOf, ContactCache,
    CoplanarConstraint, CreationOrder, Drag, Electric, ElectricField, ExtractedTransform,
    ExtractedVelocity, Flatland, GroundDrag, Inertia, MeshFollow, PartOf, ParticleBody, ParticleOf,
    PatchConstraint, PendingEdits, RestPlace, RigidConstraint, RigidPose, SinewClock,
    TetrahedronConstraint, TickForces, TubeMesh, WindSurface,
};

use crate::support::{hash, tick};

/// What the documentation calls the state: which components it is in.
macro_rules! for_each_state_component {
    ($apply:ident) => {
        $apply!(
            // The order of creation first: the rest then finds it.
            CreationOrder,
            Particle,
            Mass,
            Pinned,
            PinnedTo,
            Radius,
            Charge,
            Drag,
            ExternalForce,
            DistanceConstraint,
            Spring,
            AngleConstraint,
            HingeConstraint,
            ConeConstraint,
            AreaConstraint,
            PatchConstraint,
            TetrahedronConstraint,
            VolumeConstraint,
            BendConstraint,
            CoplanarConstraint,
            CollinearConstraint,
            RigidConstraint,
            AnyConstraint,
            ParticleBody,
            RigidPose,
            WindSurface,
            MeshFollow,
            TubeMesh,
            BodyPart,
            Transform,
            ExtractedTransform,
            LinearVelocity,
            AngularVelocity,
            ExtractedVelocity,
            WorldCenterOfMass,
            Inertia,
            ControlForce,
            ExternalTorque,
            ExternalImpulse,
            TickForces,
            PendingEdits,
            GravityScale,
            GroundDrag,
            BodySolver,
            Representation,
            Wind,
            AirFlow,
            Fluid,
            Floats,
            Region,
            Attractor,
            ElectricField,
            Flatland,
            Ground,
            BoundingBox,
            Collider,
            ColliderMotion,
            ContactCache,
            SurfaceMaterial,
            CollisionLayers,
            Sensor,
            BodyContacts,
            ContactsDisabled,
            RestPlace,
            Sleep,
            Interpolate,
            ParticleOf,
            ConstraintOf,
            PartOf
        );
    };
}

/// The recipes: descriptions, from which bodies were built.
macro_rules! for_each_recipe {
    ($apply:ident) => {
        $apply!(RigidBox, Rope, Cloth, Ragdoll);
    };
}

type Put = Box<dyn Fn(&mut World, &EntityHashMap<Entity>)>;
type PutBack = Box<dyn Fn(&mut World)>;

/// Everything that makes up the simulation at one instant.
pub(crate) struct Snapshot {
    entities: Vec<Entity>,
    anew: Vec<Put>,
    in_place: Vec<PutBack>,
}

impl Snapshot {
    /// Clones the state, without the recipes that bodies were built from.
    pub(crate) fn take(world: &mut World) -> Self {
        Self::clone_out_of(world, false)
    }

    /// Clones the recipes too.
    pub(crate) fn with_recipes(world: &mut World) -> Self {
        Self::clone_out_of(world, true)
    }

    fn clone_out_of(world: &mut World, recipes: bool) -> Self {
        let mut entities: Vec<(CreationOrder, Entity)> = Vec::new();
        for (entity, order) in world.query::<(Entity, &CreationOrder)>().iter(world) {
            entities.push((*order, entity));
        }
        entities.sort();
        let entities: Vec<Entity> = entities.into_iter().map(|(_, entity)| entity).collect();
        let (mut anew, mut in_place): (Vec<Put>, Vec<PutBack>) = (Vec::new(), Vec::new());
        macro_rules! clone_all {
            ($($component:ty),*) => { $(
                let saved = cloned::<$component>(world, &entities);
                let again = saved.clone();
                anew.push(Box::new(move |world, map| {
                    for (entity, component) in &saved {
                        let mut component = component.clone();
                        <$component as Component>::map_entities(&mut component, &mut map.clone());
                        world.entity_mut(map[entity]).insert(component);
                    }
                }));
                in_place.push(Box::new(move |world| put_back(world, &again)));
            )* };
        }
        for_each_state_component!(clone_all);
        if recipes {
            for_each_recipe!(clone_all);
        }
        macro_rules! clone_resources {
            ($($resource:ty),*) => { $(
                let saved = *world.resource::<$resource>();
                anew.push(Box::new(move |world, _| world.insert_resource(saved)));
                in_place.push(Box::new(move |world| world.insert_resource(saved)));
            )* };
        }
        clone_resources!(SinewClock, SinewControl, SolverConfig, Gravity, AirDrag, Electric);
        Self { entities, anew, in_place }
    }

    /// Puts every component back onto the entity that it came from. Entities that were despawned since are not made again.
    pub(crate) fn put_back(&self, world: &mut World) {
        self.in_place.iter().for_each(|put| put(world));
    }

    /// Spawns everything as new entities, with other ids, and returns which became which.
    pub(crate) fn spawn(&self, world: &mut World) -> EntityHashMap<Entity> {
        // Some spare ones, so that no id is what it was.
        (0..7).for_each(|_| _ = world.spawn_empty());
        let map = self.entities.iter().map(|&old| (old, world.spawn_empty().id())).collect();
        self.anew.iter().for_each(|put| put(world, &map));
        map
    }

    /// Despawns everything that is part of the simulation now.
    pub(crate) fn clear(world: &mut World) {
        let all: Vec<Entity> =
            world.query_filtered::<Entity, With<CreationOrder>>().iter(world).collect();
        for entity in all {
            world.try_despawn(entity).ok();
        }
    }
}

fn cloned<C: Component + Clone>(world: &mut World, entities: &[Entity]) -> Vec<(Entity, C)> {
    let found =
        entities.iter().filter_map(|&entity| Some((entity, world.get::<C>(entity)?.clone())));
    found.collect()
}

/// Components that are there are overwritten, as rollback plugins do it, and those that are not are inserted.
fn put_back<C: Component + Clone>(world: &mut World, saved: &[(Entity, C)]) {
    for (entity, component) in saved {
        if let Ok(mut entity) = world.get_entity_mut(*entity) {
            entity.insert(component.clone());
        }
    }
}

/// Hash after each of the next `count` ticks.
pub(crate) fn hashes(app: &mut App, count: u64) -> Vec<u64> {
    (0..count)
        .map(|_| {
            tick(app, 1);
            hash(app)
        })
        .collect()
}

/// What a sync test of a rollback plugin does: in each of so many ticks back by seven, forward again, compare.
pub(crate) fn roll_back_in_every_tick(app: &mut App, ticks: usize) {
    let mut ring: Vec<(Snapshot, u64)> = Vec::new();
    // In the first tick there may be nothing to hash yet.
    tick(app, 1);
    for _ in 0..ticks {
        let now = hash(app);
        ring.push((Snapshot::take(app.world_mut()), now));
        tick(app, 1);
        if ring.len() > 8 {
            let back = ring.len() - 7;
            ring[back].0.put_back(app.world_mut());
            for (_, expected) in &ring[back..] {
                assert_eq!(hash(app), *expected);
                tick(app, 1);
            }
        }
    }
}
