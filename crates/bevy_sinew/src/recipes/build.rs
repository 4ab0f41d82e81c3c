//! From a recipe to entities: the part that all recipes share.

use core::marker::PhantomData;

use bevy::asset::LoadState;
use bevy::ecs::component::Mutable;
use bevy::ecs::relationship::RelationshipTarget;
use bevy::prelude::*;
use bevy::reflect::{FromReflect, GetTypeRegistration, TypePath};
use sinew::collide::is_uniform;
use sinew::recipes::Blueprint;

use crate::components::{
    BodyContacts, BodyPart, BodyParticles, BodyParts, BuiltBody, Collider, ConstraintOf,
    CreationOrder, Drag, ExtractedTransform, ExtractedVelocity, Flatland, Mass, MeshFollow,
    Particle, ParticleBody, ParticleOf, Pinned, Radius, RestPlace, RigidPose, TubeMesh,
    WindSurface,
};
use crate::config::BodySolver;
use crate::frames::{Frames, Misplaced, in_world, is_same_scale};
use crate::mesh::{positions, triangles};
use crate::messages::{Refusal, refuse_in};
use crate::recipes::bind::{ListRelationship, attach, bind, insert_related, spawn_related};
use crate::recipes::bind_mesh::{own_copy, put_mesh, skin_of, source_mesh, take_mesh};
use crate::recipes::built::JustBuilt;
use crate::recipes::flat::{is_flat_world, may_be_flat};
use crate::recipes::{built_defaults, forget_replaced};

/// A component that describes a body, and builds it.
pub(crate) trait Recipe:
    Component<Mutability = Mutable> + Clone + PartialEq + FromReflect + TypePath + GetTypeRegistration
{
    /// The blueprint in the body's own frame, scaled, in metres; from the recipe and, if the recipe uses one, the mesh.
    fn blueprint(&self, mesh: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal>;

    /// The recipe with references to other entities resolved to positions; `None` while one of those entities is not built.
    fn located(&self, world: &World, body: Entity) -> Result<Option<Self>, Refusal> {
        let _ = (world, body);
        Ok(Some(self.clone()))
    }

    /// Whether the body is made from the entity's mesh.
    fn wants_mesh(&self) -> bool {
        false
    }

    /// The shape by which the body collides, if it is one rigid part: in its own frame, metres.
    fn collider(&self, blueprint: &Blueprint) -> Option<Collider> {
        let _ = blueprint;
        None
    }

    /// The default of the body's [`BodyContacts`]; `None` for no component.
    fn contacts(&self) -> Option<BodyContacts> {
        None
    }

    /// Texture coordinates of the mesh that is generated for the body, for each entry of [`Blueprint::vertices`].
    fn uvs(&self) -> Option<Vec<[f32; 2]>> {
        None
    }

    /// Adds the components that are specific to this recipe, once the particles exist.
    fn finish(&self, world: &mut World, body: Entity, blueprint: &Blueprint, particles: &[Entity]) {
        let _ = (world, body, blueprint, particles);
    }
}

/// The triangles of a mesh in the mesh's own coordinates, as recipes use them.
pub(crate) struct MeshShape {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl MeshShape {
    /// The triangles, facing outwards after scaling: a mirroring scale reverses their winding.
    pub(crate) fn faces(&self, scale: Vec3) -> Vec<[u32; 3]> {
        let mirrored = scale.x * scale.y * scale.z < 0.0;
        let face = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        self.triangles.iter().map(face).collect()
    }
}

/// Marks a body that waits: for its mesh to load, or for the entities to which it is tied.
#[derive(Component)]
pub(crate) struct AwaitsMesh<R: Send + Sync + 'static>(PhantomData<fn() -> R>);

impl<R: Send + Sync + 'static> Clone for AwaitsMesh<R> {
    fn clone(&self) -> Self {
        Self(PhantomData)
    }
}

/// What a body was last built from. An unchanged recipe that is restored, for instance by a rollback, is not built again. Part of the state.
#[derive(Component, Reflect, Clone)]
#[component(map_entities = map_built)]
pub(crate) struct Built<R: Recipe> {
    recipe: R,
    #[reflect(ignore)]
    mesh: SourceMesh,
    /// The scale of the body and its parents.
    scale: Vec3,
    /// What the recipe added.
    defaults: Defaults,
}

/// The components that a recipe adds unless the body has them: any other value belongs to the game, and stays when the body is built again.
#[derive(Reflect, Clone, Debug, Default)]
pub(crate) struct Defaults {
    collider: Option<Collider>,
    solver: Option<BodySolver>,
    contacts: Option<BodyContacts>,
}

impl Defaults {
    /// Replaces the defaults of an earlier build (`before`), from this recipe or another one, by these; returns those that are in use.
    fn put(self, before: &Self, body: &mut EntityWorldMut) -> Self {
        Self {
            collider: put_default(body, before.collider.as_ref(), self.collider),
            solver: put_default(body, before.solver.as_ref(), self.solver),
            contacts: put_default(body, before.contacts.as_ref(), self.contacts),
        }
    }
}

/// The mesh that a body was built from.
#[derive(Clone, Copy, Debug, Default)]
enum SourceMesh {
    /// The body came from another app, or from a file, where its mesh had another id: any mesh counts as the same.
    #[default]
    Elsewhere,
    /// A mesh of this app, if any.
    Here(Option<AssetId<Mesh>>),
}

/// The entities to which a rope is tied have other ids in another app; if they were not mapped, the rope would be rebuilt.
fn map_built<R: Recipe, M: EntityMapper>(built: &mut Built<R>, entities: &mut M) {
    <R as Component>::map_entities(&mut built.recipe, entities);
}

impl<R: Recipe> Built<R> {
    /// Marks the mesh as unknown: the body comes from another app.
    pub(crate) fn forget_mesh(&mut self) {
        self.mesh = SourceMesh::Elsewhere;
    }

    fn is_loaded(&self) -> bool {
        matches!(self.mesh, SourceMesh::Elsewhere)
    }
}

/// Marks a body that must be rebuilt because its scale changed, or because its placement has become valid.
#[derive(Component, Clone)]
pub(crate) struct Rescaled;

/// A body that was refused because of its placement: it is tried again when the placement changes.
#[derive(Component, Clone)]
pub(crate) struct AwaitsPlace {
    reason: Refusal,
    at: Result<Transform, Misplaced>,
}

/// The result of building a body without an error.
enum BuildOutcome {
    /// The body is built, at this scale, and has been given these components.
    Built(Vec3, Defaults),
    /// The mesh, or another body, does not exist yet.
    Waiting,
    /// An observer despawned the body during the build.
    Gone,
}

/// Marks bodies whose scale, or that of their parents, has changed, for a rebuild.
pub(crate) fn notice_scale(
    mut commands: Commands,
    built: Query<
        (Entity, &ExtractedTransform, &Transform, Has<ChildOf>),
        (With<ParticleBody>, Without<AwaitsPlace>),
    >,
    refused: Query<(Entity, &AwaitsPlace)>,
    frames: Frames,
) {
    for (body, known, transform, parented) in &built {
        let Some(known) = known.0 else { continue };
        let now = if parented { frames.of(body) } else { Ok(*transform) };
        if !now.is_ok_and(|now| is_same_scale(now.scale, known.scale)) {
            commands.entity(body).insert(Rescaled);
        }
    }
    for (body, awaits) in &refused {
        if frames.of(body) != awaits.at {
            commands.entity(body).insert(Rescaled);
        }
    }
}

/// Tries bodies again that were refused, if the world has become two-dimensional or is no longer.
pub(crate) fn notice_flatland(
    mut commands: Commands,
    flatlands: Query<(), With<Flatland>>,
    refused: Query<Entity, With<AwaitsPlace>>,
    mut was_flat: Local<bool>,
) {
    let is_flat = !flatlands.is_empty();
    if core::mem::replace(&mut *was_flat, is_flat) == is_flat {
        return;
    }
    for body in &refused {
        commands.entity(body).insert(Rescaled);
    }
}

/// Builds bodies whose recipe of type `R` is new or changed, whose mesh has loaded since, or whose scale changed.
pub(crate) fn build<R: Recipe>(
    world: &mut World,
    wanted: &mut QueryState<
        (Entity, &R, &CreationOrder, Has<AwaitsMesh<R>>),
        Or<(Changed<R>, With<AwaitsMesh<R>>, With<Rescaled>)>,
    >,
) {
    let bodies = wanted
        .iter(world)
        .map(|(entity, recipe, order, waits)| (*order, entity, recipe.clone(), waits))
        .collect();
    build_all(world, bodies);
}

/// Builds the bodies that wait, a second time in the same tick: for other bodies that were built in it.
pub(crate) fn build_waiting<R: Recipe>(
    world: &mut World,
    wanted: &mut QueryState<(Entity, &R, &CreationOrder), With<AwaitsMesh<R>>>,
) {
    let bodies = wanted
        .iter(world)
        .map(|(entity, recipe, order)| (*order, entity, recipe.clone(), true))
        .collect();
    build_all(world, bodies);
}

fn build_all<R: Recipe>(world: &mut World, mut bodies: Vec<(CreationOrder, Entity, R, bool)>) {
    if bodies.is_empty() {
        return;
    }
    let is_flat = is_flat_world(world);
    bodies.sort_unstable_by_key(|(order, entity, ..)| (*order, *entity));
    for (_, body, recipe, waits) in bodies {
        // An observer of an earlier body may have despawned this one.
        if world.get_entity(body).is_err() {
            continue;
        }
        let loaded = world.get::<Built<R>>(body).is_some_and(Built::is_loaded);
        if (loaded || !waits) && is_as_built(world, body, &recipe) {
            if loaded {
                draw_loaded(world, body, &recipe);
            }
            continue;
        }
        let mesh = wanted_mesh(world, body, &recipe);
        let outcome = build_one(world, body, &recipe, is_flat);
        let at = in_world(world, body);
        let Ok(mut entity) = world.get_entity_mut(body) else { continue };
        entity.remove::<Rescaled>();
        match outcome {
            Ok(BuildOutcome::Built(scale, defaults)) => {
                let built = Built { recipe, mesh: SourceMesh::Here(mesh), scale, defaults };
                entity.insert(built).remove::<(AwaitsMesh<R>, AwaitsPlace)>();
                forget_replaced(&mut entity);
                world.get_resource_or_init::<JustBuilt>().0.push(body);
            }
            Ok(BuildOutcome::Waiting) => {
                entity.insert_if_new(AwaitsMesh::<R>(PhantomData));
            }
            Ok(BuildOutcome::Gone) => {}
            Err(reason) => {
                Defaults::default().put(&built_defaults(&entity), &mut entity);
                entity.remove::<(AwaitsMesh<R>, Built<R>, BuiltBody)>();
                despawn_built(world, body);
                take_mesh(world, body);
                if awaits_place(world, body, &reason, at) {
                    continue;
                }
                refuse_in(world, body, reason);
            }
        }
    }
}

/// Stores the placement for which a body was refused, if that is the reason. Returns whether the same error is known already.
fn awaits_place(
    world: &mut World,
    body: Entity,
    reason: &Refusal,
    at: Result<Transform, Misplaced>,
) -> bool {
    let Ok(mut entity) = world.get_entity_mut(body) else { return false };
    if !matches!(
        reason,
        Refusal::Transform | Refusal::Sheared | Refusal::UnevenScale | Refusal::NotFlat
    ) {
        entity.remove::<AwaitsPlace>();
        return false;
    }
    let known = entity.get::<AwaitsPlace>().is_some_and(|awaits| awaits.reason == *reason);
    entity.insert(AwaitsPlace { reason: reason.clone(), at });
    known
}

/// Whether the body is built as its current recipe, mesh and scale describe it.
fn is_as_built<R: Recipe>(world: &World, body: Entity, recipe: &R) -> bool {
    // A clone of a body has an empty list: its particles were not cloned.
    let is_there = world.get::<BodyParticles>(body).is_some_and(|list| !list.is_empty());
    let built = world.get::<Built<R>>(body).filter(|_| is_there);
    built.is_some_and(|built| {
        let same_mesh = match built.mesh {
            SourceMesh::Elsewhere => true,
            SourceMesh::Here(mesh) => mesh == wanted_mesh(world, body, recipe),
        };
        built.recipe == *recipe
            && same_mesh
            && in_world(world, body).is_ok_and(|at| is_same_scale(at.scale, built.scale))
    })
}

/// Gives the mesh of its recipe to a body that came from a file or from another app, since what is drawn is not part of the state. A body that is made from a
/// mesh waits until the game inserts that. A mesh that the game inserted instead of a generated one stays.
fn draw_loaded<R: Recipe>(world: &mut World, body: Entity, recipe: &R) {
    let Some(vertices) = world.get::<MeshFollow>(body).map(|follow| follow.vertices.len()) else {
        return;
    };
    let Some(meshes) = world.get_resource::<Assets<Mesh>>() else { return };
    let given = world.get::<Mesh3d>(body);
    if recipe.wants_mesh() {
        if !given.is_some_and(|mesh| meshes.contains(&mesh.0)) {
            attach(world, body, AwaitsMesh::<R>(PhantomData));
            return;
        }
        own_copy(world, body);
    } else if given.is_none()
        && let Ok(at) = in_world(world, body)
        && let Ok(blueprint) = recipe.blueprint(None, at.scale)
        // Unless the game has changed what the mesh follows.
        && blueprint.vertices.len() == vertices
    {
        give_mesh(world, body, recipe, &blueprint);
    }
    let mesh = SourceMesh::Here(wanted_mesh(world, body, recipe));
    if let Ok(mut entity) = world.get_entity_mut(body) {
        if let Some(mut built) = entity.get_mut::<Built<R>>() {
            built.mesh = mesh;
        }
        entity.remove::<AwaitsMesh<R>>();
    }
}

fn wanted_mesh<R: Recipe>(world: &World, body: Entity, recipe: &R) -> Option<AssetId<Mesh>> {
    source_mesh(world, body).filter(|_| recipe.wants_mesh()).map(Handle::id)
}

/// The components that the last build of a body from this recipe added.
pub(super) fn recipe_defaults<'a, R: Recipe>(body: &'a EntityWorldMut) -> Option<&'a Defaults> {
    body.get::<Built<R>>().map(|built| &built.defaults)
}

/// Removes what the plugin keeps of a recipe that the body no longer has.
pub(super) fn forget_recipe<R: Recipe>(body: &mut EntityWorldMut) {
    if body.contains::<Built<R>>() && !body.contains::<R>() {
        body.remove::<(Built<R>, AwaitsMesh<R>)>();
    }
}

/// Adds a component of the recipe (`own`), or removes that of an earlier build (`before`), unless the game has added one; returns the recipe's if it is used.
fn put_default<C: Component + Clone + PartialEq>(
    body: &mut EntityWorldMut,
    before: Option<&C>,
    own: Option<C>,
) -> Option<C> {
    let has = body.get::<C>();
    // A component equal to that of the recipe may have been restored.
    if has.is_some() && has != before && has != own.as_ref() {
        return None;
    }
    match &own {
        Some(component) if has != Some(component) => drop(body.insert(component.clone())),
        None if has.is_some() => drop(body.remove::<C>()),
        _ => {}
    }
    own
}

/// Builds one body. A refused body is left without particles.
fn build_one<R: Recipe>(
    world: &mut World,
    body: Entity,
    recipe: &R,
    is_flat: bool,
) -> Result<BuildOutcome, Refusal> {
    if world.get::<Transform>(body).is_none() {
        return Err(Refusal::Transform);
    }
    let transform = in_world(world, body)?;
    if !transform.is_finite() || transform.scale.abs().min_element() == 0.0 {
        return Err(Refusal::Transform);
    }
    let Some(recipe) = &recipe.located(world, body)? else { return Ok(BuildOutcome::Waiting) };
    let mesh = if recipe.wants_mesh() {
        match read_mesh(world, body)? {
            Some(mesh) => Some(mesh),
            None => return Ok(BuildOutcome::Waiting),
        }
    } else {
        None
    };
    despawn_built(world, body);
    let blueprint = recipe.blueprint(mesh.as_ref(), transform.scale)?;
    // A rigid body may rotate later, whatever its current rotation is.
    let parent = world.get::<ChildOf>(body).map(ChildOf::parent);
    let above = parent.map_or(Ok(Transform::IDENTITY), |parent| in_world(world, parent))?;
    if !blueprint.parts.is_empty() && !is_uniform(above.scale) {
        return Err(Refusal::Sheared);
    }
    if is_flat && !may_be_flat(&blueprint) {
        return Err(Refusal::NotFlat);
    }
    let placed = blueprint.transformed(transform.rotation, transform.translation);
    let particles = spawn_particles(world, body, &blueprint, &placed);
    let bound = bind(world, body, &placed, &particles);

    // A rebuilt body keeps its velocities.
    attach(world, body, (ExtractedTransform(Some(transform)), ExtractedVelocity(None)));
    let all_there = particles.len() == placed.particles.len();
    if all_there && !placed.triangles.is_empty() {
        let corner = |i: u32| particles[i as usize];
        let triangles = placed.triangles.iter().map(|t| t.map(corner)).collect();
        attach(world, body, WindSurface { triangles });
    }
    if all_there && !placed.vertices.is_empty() {
        let vertices = placed.vertices.iter().map(|&i| particles[i as usize]).collect();
        attach(world, body, MeshFollow { vertices });
        give_mesh(world, body, recipe, &placed);
    }
    if world.get_entity(body).is_ok() {
        recipe.finish(world, body, &placed, &particles);
    }
    if !world
        .get_entity(body)
        .is_ok_and(|body| body.contains::<MeshFollow>() || body.contains::<TubeMesh>())
    {
        take_mesh(world, body);
    }
    let has_settings = blueprint.settings != Default::default();
    let defaults = Defaults {
        collider: recipe.collider(&blueprint),
        solver: has_settings.then(|| blueprint.settings.into()),
        contacts: recipe.contacts(),
    };
    if let Ok(mut entity) = world.get_entity_mut(body) {
        let defaults = defaults.put(&built_defaults(&entity), &mut entity);
        return Ok(BuildOutcome::Built(transform.scale, defaults));
    }
    // The body's list was despawned with it; entities that were not in the list any more would remain.
    for entity in particles.into_iter().chain(bound) {
        world.try_despawn(entity).ok();
    }
    Ok(BuildOutcome::Gone)
}

/// Gives a body the mesh that it deforms: a copy of the one that it was made from, or a generated one.
fn give_mesh<R: Recipe>(world: &mut World, body: Entity, recipe: &R, blueprint: &Blueprint) {
    if recipe.wants_mesh() {
        own_copy(world, body);
    } else if world.contains_resource::<Assets<Mesh>>() {
        put_mesh(world, body, skin_of(blueprint, recipe.uvs()), None);
    }
}

/// Despawns the entities of an earlier build of this body, from this recipe or another one, and removes the components that refer to them.
fn despawn_built(world: &mut World, body: Entity) {
    despawn_related::<ParticleOf>(world, body);
    despawn_related::<ConstraintOf>(world, body);
    let Ok(mut entity) = world.get_entity_mut(body) else { return };
    entity
        .despawn_related::<BodyParts>()
        .remove::<(RigidPose, BodyPart, WindSurface, MeshFollow, TubeMesh)>();
}

/// Despawns all entities of one relationship of a body. The list is taken out first: otherwise each entity would search the list for itself, and move all
/// entries behind it.
fn despawn_related<R: ListRelationship>(world: &mut World, body: Entity) {
    let Some(mut list) = world.get_mut::<R::RelationshipTarget>(body) else { return };
    for entity in core::mem::take(list.collection_mut_risky()) {
        // An observer of an earlier entity may have despawned this one.
        world.try_despawn(entity).ok();
    }
}

/// The mesh of a body; `None` while it is loading.
fn read_mesh(world: &World, body: Entity) -> Result<Option<MeshShape>, Refusal> {
    let handle = source_mesh(world, body).ok_or(Refusal::NoMesh)?;
    let meshes = world.get_resource::<Assets<Mesh>>().ok_or(Refusal::NoMesh)?;
    let Some(mesh) = meshes.get(handle) else {
        let state =
            world.get_resource::<AssetServer>().and_then(|server| server.get_load_state(handle));
        return match state {
            Some(LoadState::Failed(_)) => Err(Refusal::MeshLoad),
            Some(_) => Ok(None),
            // A handle that no loader owns never gets a mesh.
            None => Err(Refusal::NoMesh),
        };
    };
    let positions = positions(mesh).ok_or(Refusal::UnreadableMesh)?;
    let triangles = triangles(mesh, positions.len()).ok_or(Refusal::UnreadableMesh)?.collect();
    Ok(Some(MeshShape { positions, triangles }))
}

/// Spawns the particles of a body. Stops early if an observer despawns the body; the functions below do so, too.
fn spawn_particles(
    world: &mut World,
    body: Entity,
    blueprint: &Blueprint,
    placed: &Blueprint,
) -> Vec<Entity> {
    let mut particles = spawn_related::<ParticleOf>(world, body, placed.particles.len());
    for (done, (own, seed)) in blueprint.particles.iter().zip(&placed.particles).enumerate() {
        let Some(&entity) = particles.get(done) else { break };
        let pinned = seed.mass.is_infinite();
        let free = blueprint.free_mass(done as u32).unwrap_or(1.0);
        let particle = (
            Particle {
                position: seed.position,
                remainder: seed.remainder,
                velocity: seed.velocity,
                lag: seed.lag,
            },
            Mass(if pinned { free } else { seed.mass }),
            Radius(seed.radius),
            RestPlace(own.position),
        );
        let (of, drag) = (ParticleOf(body), Drag(seed.drag));
        // All components in one insertion: a further one would move the entity to another table.
        let there = match (pinned, seed.drag > 0.0) {
            (false, false) => insert_related(world, entity, of, particle),
            (false, true) => insert_related(world, entity, of, (particle, drag)),
            (true, false) => insert_related(world, entity, of, (particle, Pinned::HERE)),
            (true, true) => insert_related(world, entity, of, (particle, drag, Pinned::HERE)),
        };
        if !there {
            particles.truncate(done);
            break;
        }
    }
    particles
}
