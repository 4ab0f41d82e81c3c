//! Dragging bodies with the mouse.
//!
//! When a pointer is pressed, a ray is cast into the world. It hits rigid bodies by their shapes, cloth and soft bodies by their triangles, and particles; if
//! it hits nothing, the nearest particle beside it is selected. The hit is reported to Bevy's picking as by any other backend, so that anything in front of it,
//! such as a UI, receives the press instead. The selected point is held by a soft constraint, which exists only during the drag.

use core::f32::consts::TAU;

use bevy::camera::Camera;
use bevy::camera::visibility::RenderLayers;
use bevy::ecs::system::SystemParam;
use bevy::math::{DMat3, DVec3};
use bevy::picking::PickingSystems;
use bevy::picking::backend::ray::RayMap;
use bevy::picking::backend::{HitData, PointerHits};
use bevy::picking::pointer::{PointerAction, PointerButton, PointerId, PointerInput};
use bevy::prelude::*;
use sinew::{ConstraintFault, ConstraintKind, Equation, Points, Softness};

use crate::bevy_version::{OnPress, pointer};
use crate::components::{
    BodyParticles, BodyParts, CreationOrder, Mass, PartOf, Particle, ParticleConstraint,
    ParticleOf, ParticleRow, Pinned, RigidPose, WindSurface,
};
use crate::query::QueryFilter;
use crate::schedule::{SinewSystems, SinewTick, time_passes};
use crate::step::RegisterParticleConstraint;
use crate::world::SinewWorld;

/// Lets a pointer drag bodies and particles. It is not part of [`SinewPlugins`](crate::SinewPlugins): add it beside them. It has no effect in an app without
/// picking (`DefaultPlugins` includes it) or without a pointer, except where a game sets [`MouseDrag::grabbed`] itself.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// use bevy_sinew::MouseDragPlugin;
///
/// App::new().add_plugins((DefaultPlugins, SinewPlugins, MouseDragPlugin)).run();
/// ```
#[derive(Default)]
pub struct MouseDragPlugin;

/// Settings of dragging, and what is being dragged. A game may set [`grabbed`](Self::grabbed) itself: for a hand, or a tractor beam.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::MouseDrag;
/// # use bevy::picking::pointer::PointerButton;
/// /// Drag with the right button, gently.
/// fn set_up(mut drag: ResMut<MouseDrag>) {
///     drag.button = Some(PointerButton::Secondary);
///     drag.frequency = 1.0;
/// }
/// ```
#[derive(Resource, Clone, Debug)]
pub struct MouseDrag {
    /// The button that drags; `None` disables the pointer. Default the primary button.
    pub button: Option<PointerButton>,
    /// How far beside the pointer a particle may be where the pointer is not over a body, as the tangent of the angle seen from the camera. Default 0.04, about
    /// 2°.
    pub reach: f32,
    /// How quickly the body follows: the frequency of a critically damped spring that carries the whole body, Hz, 0 to 15. Default 2.2, which takes a quarter
    /// of a second.
    pub frequency: f32,
    /// Maximum pull, as an acceleration of the whole island that is dragged, m/s². Default 500.
    pub max_acceleration: f32,
    /// What is being dragged; `None` for nothing.
    pub grabbed: Option<Grab>,
}

/// A point of a body, and the target to which it is pulled.
#[derive(Clone, Debug, PartialEq)]
pub struct Grab {
    /// The particles that define the point, each once, with their weights, which add up to 1.
    pub anchor: Vec<(Entity, f32)>,
    /// The target, metres.
    pub target: Vec3,
}

impl Grab {
    /// Grabs a single particle.
    pub fn particle(particle: Entity, target: Vec3) -> Self {
        Self { anchor: vec![(particle, 1.0)], target }
    }
}

impl Default for MouseDrag {
    fn default() -> Self {
        Self {
            button: Some(PointerButton::Primary),
            reach: 0.04,
            frequency: 2.2,
            max_acceleration: 500.0,
            grabbed: None,
        }
    }
}

impl Plugin for MouseDragPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MouseDrag>()
            .init_resource::<PointerState>()
            .register_particle_constraint::<GrabConstraint>()
            .add_observer(start_drag)
            .add_systems(
                PreUpdate,
                (pick.in_set(PickingSystems::Backend), follow_pointer.after(PickingSystems::Hover))
                    .run_if(resource_exists::<Messages<PointerInput>>),
            )
            // While time is paused nothing is pulled, so selecting a body changes nothing.
            .add_systems(SinewTick, update_grab.before(SinewSystems::Build).run_if(time_passes));
    }
}

/// The state of the pointers.
#[derive(Resource, Default)]
struct PointerState {
    /// The hits under the pointers that were pressed in this frame.
    pressed: Vec<PressHit>,
    /// The hit that is being dragged.
    dragged: Option<PressHit>,
}

/// A hit of a pointer's ray through a camera: the point, its body, and the particles that define the point.
#[derive(Clone, Debug)]
struct PressHit {
    pointer: PointerId,
    camera: Entity,
    entity: Entity,
    point: Vec3,
    anchor: Vec<(Entity, f32)>,
}

/// Reports to Bevy's picking what is under a pointer that was pressed: a body that can be dragged, or a collider in front of it.
fn pick(
    drag: Res<MouseDrag>,
    rays: Res<RayMap>,
    mut pointers: ResMut<PointerState>,
    mut inputs: MessageReader<PointerInput>,
    mut hits: MessageWriter<PointerHits>,
    cameras: Query<(&Camera, Option<&RenderLayers>)>,
    world: Res<SinewWorld>,
    anchors: Anchors,
) {
    pointers.pressed.clear();
    for input in inputs.read() {
        if !matches!(input.action, PointerAction::Press(button) if drag.button == Some(button)) {
            continue;
        }
        for (&id, &ray) in rays.iter().filter(|(id, _)| id.pointer == input.pointer_id) {
            let Ok((camera, layers)) = cameras.get(id.camera) else { continue };
            // A camera that renders no layer, such as the one that egui uses, is no viewpoint.
            if layers.is_some_and(|layers| *layers == RenderLayers::none()) {
                continue;
            }
            let Some(hit) = anchors.hit_under(&world, ray, drag.reach) else { continue };
            let data = HitData::new(id.camera, hit.distance, Some(hit.point), hit.normal);
            hits.write(PointerHits::new(id.pointer, vec![(hit.entity, data)], camera.order as f32));
            pointers.pressed.extend(hit.anchor.map(|anchor| PressHit {
                pointer: id.pointer,
                camera: id.camera,
                entity: hit.entity,
                point: hit.point,
                anchor,
            }));
        }
    }
}

/// Starts a drag from a press on a body. Another backend, such as the one for meshes, may have reported the same body first: in any case the press targets the
/// body, a part of it, or a mesh of either, from which it bubbles up.
fn start_drag(
    press: OnPress,
    mut drag: ResMut<MouseDrag>,
    mut pointers: ResMut<PointerState>,
    parts: Query<&PartOf>,
) {
    if drag.button != Some(press.button) {
        return;
    }
    let target = press.entity;
    let body = parts.get(target).map_or(target, |of| of.0);
    let hit = pointers.pressed.iter().find(|hit| {
        hit.pointer == pointer(&press)
            && hit.camera == press.hit.camera
            && [target, body].contains(&hit.entity)
    });
    if let Some(hit) = hit.cloned() {
        drag.grabbed = Some(Grab { anchor: hit.anchor.clone(), target: hit.point });
        pointers.dragged = Some(hit);
    }
}

/// Moves the target with the pointer, at the depth at which the point was grabbed, and ends the drag when the button is released.
fn follow_pointer(
    mut drag: ResMut<MouseDrag>,
    mut pointers: ResMut<PointerState>,
    mut inputs: MessageReader<PointerInput>,
    rays: Res<RayMap>,
    frames: Query<&GlobalTransform, With<Camera>>,
) {
    let Some(PressHit { pointer, camera, point: grabbed_point, .. }) = pointers.dragged else {
        inputs.clear();
        return;
    };
    let button = drag.button;
    let released = inputs.read().filter(|input| input.pointer_id == pointer).any(|input| {
        matches!(input.action, PointerAction::Cancel)
            || matches!(input.action, PointerAction::Release(up) if button == Some(up))
    });
    if released || button.is_none() {
        (drag.grabbed, pointers.dragged) = (None, None);
        return;
    }
    let mut own = rays.iter().filter(|(id, _)| id.pointer == pointer && id.camera == camera);
    let (Some((_, ray)), Ok(frame)) = (own.next(), frames.get(camera)) else { return };
    let Some(grab) = &mut drag.grabbed else { return };
    let forward = frame.forward();
    let depth = (grabbed_point - ray.origin).dot(*forward);
    let steepness = ray.direction.dot(*forward);
    if steepness > 1e-3 {
        grab.target = ray.origin + *ray.direction * (depth / steepness);
    }
}

/// Maintains the constraints of the drag; there are none without a drag.
fn update_grab(
    mut commands: Commands,
    drag: Res<MouseDrag>,
    world: Res<SinewWorld>,
    rows: Query<&ParticleRow>,
    mut grabs: Query<(Entity, &mut GrabConstraint)>,
) {
    let wanted = drag.grabbed.as_ref().and_then(|grab| wanted(grab, &drag, &world, &rows));
    let Some(wanted) = wanted else {
        grabs.iter().for_each(|(entity, _)| commands.entity(entity).despawn());
        return;
    };
    if grabs.is_empty() {
        commands.spawn_batch(wanted.map(|constraint| (CreationOrder::default(), constraint)));
        return;
    }
    for (_, mut constraint) in &mut grabs {
        let axis = constraint.axis;
        if let Some(now) = wanted.iter().find(|now| now.axis == axis) {
            constraint.set_if_neq(now.clone());
        }
    }
}

/// The three constraints that pull a point along the axes; `None` if the particles are gone, or a number is invalid.
fn wanted(
    grab: &Grab,
    drag: &MouseDrag,
    world: &SinewWorld,
    rows: &Query<&ParticleRow>,
) -> Option<[GrabConstraint; 3]> {
    let particles = world.particles();
    let (mut at, mut mass) = (Vec3::ZERO, 0.0_f32);
    for &(particle, share) in &grab.anchor {
        let row = rows.get(particle).ok()?.within(particles)?;
        at += particles.position(row) * share;
        mass = mass.max(world.simulation().island_mass(row));
    }
    let omega = TAU * drag.frequency.clamp(0.0, 15.0);
    let far = drag.max_acceleration.max(0.0) / (omega * omega);
    let target = at + (grab.target - at).clamp_length_max(far);
    if !(target.is_finite() && mass > 0.0 && omega > 0.0) {
        return None;
    }
    // A spring that would carry the whole island.
    let softness = Softness::spring(mass * omega * omega, 2.0 * mass * omega);
    let (particles, shares): (Vec<Entity>, Vec<f32>) = grab.anchor.iter().copied().unzip();
    Some(Vec3::AXES.map(|axis| GrabConstraint {
        particles: particles.clone(),
        shares: shares.clone(),
        axis,
        target,
        softness,
    }))
}

/// Pulls a combination of particles to the plane through a target across an axis.
#[derive(Component, Clone, Debug, PartialEq)]
struct GrabConstraint {
    #[entities]
    particles: Vec<Entity>,
    shares: Vec<f32>,
    axis: Vec3,
    target: Vec3,
    softness: Softness,
}

impl ParticleConstraint for GrabConstraint {
    fn particles(&self) -> &[Entity] {
        &self.particles
    }

    fn kind(&self) -> ConstraintKind {
        let Self { shares, axis, target, softness, .. } = self.clone();
        ConstraintKind::custom(PointOnPlane { shares, axis, target, softness })
    }

    fn fault(&self) -> Option<ConstraintFault> {
        let valid = self.shares.iter().all(|share| share.is_finite()) && self.target.is_finite();
        (!valid).then_some(ConstraintFault::Number)
    }
}

/// `C = n · (Σ bᵢ pᵢ - t)`, metres, with the weights `Σ bᵢ = 1`: linear, with the gradients `bᵢ n`. The target is fixed in the world, so momentum is not
/// conserved.
#[derive(Debug)]
struct PointOnPlane {
    shares: Vec<f32>,
    axis: Vec3,
    target: Vec3,
    softness: Softness,
}

impl Equation for PointOnPlane {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let mut value = 0.0;
        for (i, (gradient, &share)) in gradients.iter_mut().zip(&self.shares).enumerate() {
            *gradient = self.axis * share;
            value += share * self.axis.dot(points.relative_to(i, self.target));
        }
        value
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_length(&self) -> bool {
        true
    }
}

/// A hit under a ray, with the particles that define the point, if it can be dragged.
struct RayHit {
    entity: Entity,
    distance: f32,
    point: Vec3,
    normal: Option<Vec3>,
    anchor: Option<Vec<(Entity, f32)>>,
}

/// The queries that find the particles of a hit.
#[derive(SystemParam)]
struct Anchors<'w, 's> {
    particles: Query<'w, 's, (Entity, &'static Particle, &'static ParticleRow), Without<Pinned>>,
    weighed: Query<'w, 's, (&'static Particle, &'static Mass)>,
    owners: Query<'w, 's, &'static ParticleOf>,
    poses: Query<'w, 's, &'static RigidPose>,
    parts: Query<'w, 's, &'static BodyParts>,
    surfaces: Query<'w, 's, &'static WindSurface>,
    bodies: Query<'w, 's, (), With<BodyParticles>>,
}

impl Anchors<'_, '_> {
    /// The hit under a ray: the first one along the ray, or the nearest particle beside it.
    fn hit_under(&self, world: &SinewWorld, ray: Ray3d, reach: f32) -> Option<RayHit> {
        let hit = world.cast_ray(ray, f32::MAX, &QueryFilter::default());
        let ray_hit = hit.map(|hit| RayHit {
            entity: hit.entity,
            distance: hit.distance,
            point: hit.point,
            normal: Some(hit.normal),
            anchor: hit.particle.map(|particle| self.anchor(hit.entity, particle, hit.point)),
        });
        if ray_hit.as_ref().is_some_and(|ray_hit| ray_hit.anchor.is_some()) {
            return ray_hit;
        }
        // A collider hides the particles behind it.
        let far = ray_hit.as_ref().map_or(f32::INFINITY, |ray_hit| ray_hit.distance);
        let columns = world.particles();
        let candidates = self.particles.iter().map(|(entity, particle, row)| {
            (entity, particle.position, row.within(columns).map_or(0.0, |row| columns.radius(row)))
        });
        let beside = nearest_beside(ray, reach, far, candidates).map(|(particle, point)| RayHit {
            entity: self.owners.get(particle).map_or(particle, |of| of.0),
            distance: ray.origin.distance(point),
            point,
            normal: None,
            anchor: Some(vec![(particle, 1.0)]),
        });
        beside.or(ray_hit)
    }

    /// The particles that define a point of a body, with their weights. `particle` is one of those that were hit.
    fn anchor(&self, body: Entity, particle: Entity, point: Vec3) -> Vec<(Entity, f32)> {
        let alone = || vec![(particle, 1.0)];
        if !self.bodies.contains(body) {
            return alone();
        }
        let parts = self.parts.get(body).into_iter().flat_map(BodyParts::iter).chain([body]);
        let poses = parts.filter_map(|part| self.poses.get(part).ok());
        // Of several rigid parts that share the particle, the one whose particles are nearest to the point.
        let near = |pose: &RigidPose| {
            let places = pose.particles.iter().filter_map(|&own| self.weighed.get(own).ok());
            let (mut sum, mut count) = (Vec3::ZERO, 0.0_f32);
            places.for_each(|(own, _)| (sum, count) = (sum + own.position, count + 1.0));
            (sum / count.max(1.0)).distance_squared(point)
        };
        let own = poses.filter(|pose| pose.particles.contains(&particle));
        if let Some(pose) = own.min_by(|a, b| near(a).total_cmp(&near(b))) {
            return self.between(&pose.particles, point).unwrap_or_else(alone);
        }
        let triangles = self.surfaces.get(body).map_or(&[][..], |surface| &surface.triangles);
        let own = triangles.iter().filter(|corners| corners.contains(&particle));
        let found = own.filter_map(|corners| {
            let shares = self.between(corners, point)?;
            // Inside a triangle no weight is negative.
            let least = shares.iter().map(|&(_, share)| share).fold(f32::INFINITY, f32::min);
            Some((least, shares))
        });
        let best = found.max_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(alone, |(_, shares)| shares)
    }

    /// The weights of particles that define a point: with their masses `m`, their centre of mass `c` and `S = Σ m (p - c)(p - c)ᵀ`,
    ///
    /// ```text
    /// bᵢ = mᵢ (1/M + (pᵢ - c) · S⁻¹ (x - c))        Σ bᵢ = 1,   Σ bᵢ pᵢ = x
    /// ```
    ///
    /// Of all weights that define the point, these move the particles least. For flat or straight bodies the point is projected to their plane or line.
    fn between(&self, particles: &[Entity], point: Vec3) -> Option<Vec<(Entity, f32)>> {
        let own: Vec<(Entity, DVec3, f64)> = particles
            .iter()
            .filter_map(|&entity| {
                let (particle, mass) = self.weighed.get(entity).ok()?;
                Some((entity, particle.exact(), f64::from(mass.0)))
            })
            .collect();
        let mass: f64 = own.iter().map(|one| one.2).sum();
        let centre = own.iter().map(|one| one.1 * one.2).sum::<DVec3>() / mass;
        let mut spread = DMat3::ZERO;
        for (_, place, mass) in &own {
            let arm = *place - centre;
            spread += DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z) * *mass;
        }
        // A flat body has no inverse outside of its plane: a millionth of its size regularises it.
        let size = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        let braced = spread + DMat3::from_diagonal(DVec3::splat(1e-6 * size));
        let towards = braced.inverse() * (point.as_dvec3() - centre);
        let share = |place: DVec3, m: f64| m * (1.0 / mass + (place - centre).dot(towards));
        let shares: Vec<(Entity, f32)> =
            own.iter().map(|&(entity, place, m)| (entity, share(place, m) as f32)).collect();
        shares.iter().all(|(_, share)| share.is_finite()).then_some(shares)
    }
}

/// The particle with the smallest angle to the ray, seen from its origin, and nearer than `far` metres; of those that the ray hits, the nearest to the origin.
fn nearest_beside(
    ray: Ray3d,
    reach: f32,
    far: f32,
    candidates: impl Iterator<Item = (Entity, Vec3, f32)>,
) -> Option<(Entity, Vec3)> {
    let mut best: Option<(f32, Entity, Vec3)> = None;
    for (entity, at, radius) in candidates {
        let away = at - ray.origin;
        let depth = away.dot(*ray.direction);
        if depth.is_nan() || depth <= 0.0 || depth > far {
            continue;
        }
        let beside = ((away - *ray.direction * depth).length() - radius).max(0.0) / depth;
        // One metre of distance counts as much as 30 % of the reach beside the ray.
        let score = beside + depth * reach * 0.3;
        if beside <= reach && best.is_none_or(|(least, ..)| score < least) {
            best = Some((score, entity, at));
        }
    }
    best.map(|(_, entity, at)| (entity, at))
}
