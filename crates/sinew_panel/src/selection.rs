//! The selected body, and the values that the panel shows of it.

#[cfg(test)]
mod tests;

use bevy::ecs::message::MessageCursor;
use bevy::ecs::system::SystemParam;
use bevy::picking::pointer::{PointerAction, PointerButton, PointerInput};
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use bevy_sinew::sinew::Impact;
use bevy_sinew::{
    AngularVelocity, BodyConstraints, BodyParticles, Cloth, DistanceConstraint, Inertia,
    LinearVelocity, Mass, MouseDrag, Particle, ParticleOf, ParticleRow, Ragdoll, Representation,
    RigidBox, RigidMesh, RigidPose, Rope, SinewWorld, Sleep, SoftBody, Spring, WatchedContacts,
    WorldCenterOfMass,
};

use crate::keys::PanelKeys;
use crate::recording::WentBack;
use crate::state::PanelState;

/// The selected body. A resource that a game may set as well.
///
/// While the panel is shown, a press on a body or a loose particle selects it, if [`MouseDragPlugin`](bevy_sinew::MouseDragPlugin) is added and grabs it. A
/// click that grabs nothing clears the selection, and so does [`PanelKeys::deselect`].
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct Selection {
    /// The body or the loose particle. It stays selected when it is despawned, because going back in time may spawn it again. Default none.
    pub body: Option<Entity>,
    /// The clicked point: the particles that it lies between and the weight of each; the weights sum to 1. Empty: the centre of mass.
    pub anchor: Vec<(Entity, f32)>,
}

impl Selection {
    /// Selects a body or a loose particle.
    pub fn select(&mut self, body: Entity) {
        *self = Self { body: Some(body), anchor: Vec::new() };
    }

    /// Clears the selection.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// How far a pointer may move between press and release of a click, logical pixels.
const STILL: f32 = 6.0;

/// Selects the body that the pointer grabs, and clears the selection on a click on empty space.
pub(crate) fn select(
    state: Res<PanelState>,
    bound: Res<PanelKeys>,
    keys: Option<Res<ButtonInput<KeyCode>>>,
    egui: Option<Res<EguiWantsInput>>,
    drag: Option<Res<MouseDrag>>,
    inputs: Option<Res<Messages<PointerInput>>>,
    owners: Query<&ParticleOf>,
    mut selection: ResMut<Selection>,
    mut cursor: Local<MessageCursor<PointerInput>>,
    mut into_void: Local<Option<Vec2>>,
) {
    let (wants_keys, wants_pointer) = egui.map_or((false, false), |egui| {
        (egui.wants_keyboard_input(), egui.wants_any_pointer_input())
    });
    let escaped = bound.deselect.zip(keys).is_some_and(|(key, keys)| keys.just_pressed(key));
    if escaped && state.shown && !wants_keys && selection.body.is_some() {
        selection.clear();
    }
    let Some(inputs) = inputs else { return };
    for input in cursor.read(&inputs).filter(|_| state.shown) {
        let button = drag.as_ref().map_or(Some(PointerButton::Primary), |drag| drag.button);
        match input.action {
            PointerAction::Press(pressed) if button == Some(pressed) => {
                let grab = drag.as_ref().and_then(|drag| drag.grabbed.as_ref());
                let first = grab.and_then(|grab| Some((grab, grab.anchor.first()?.0)));
                *into_void = None;
                if let Some((grab, particle)) = first {
                    let body = owners.get(particle).map_or(particle, |of| of.0);
                    *selection = Selection { body: Some(body), anchor: grab.anchor.clone() };
                } else if !wants_pointer {
                    *into_void = Some(input.location.position);
                }
            }
            PointerAction::Release(released) if button == Some(released) => {
                let from = into_void.take();
                if from.is_some_and(|from| from.distance(input.location.position) <= STILL) {
                    selection.clear();
                }
            }
            _ => {}
        }
    }
}

/// Watches the contacts of the selected body while the panel is shown, so that the solver reports them.
pub(crate) fn watch(
    state: Res<PanelState>,
    selection: Res<Selection>,
    mut watched: ResMut<WatchedContacts>,
) {
    let body = selection.body.filter(|_| state.shown);
    if watched.body != body {
        watched.body = body;
    }
}

/// Keeps the selection on a body that was spawned again under another id by going back.
pub(crate) fn follow_back(went: On<WentBack>, mut selection: ResMut<Selection>) {
    let now = |entity: Entity| went.entities.get(&entity).copied().unwrap_or(entity);
    if went.entities.is_empty() || selection.body.is_none() {
        return;
    }
    selection.body = selection.body.map(now);
    selection.anchor.iter_mut().for_each(|one| one.0 = now(one.0));
}

/// System parameter that reads the values of the selected body.
#[derive(SystemParam)]
pub(crate) struct Selected<'w, 's> {
    bodies: Query<
        'w,
        's,
        (
            &'static BodyParticles,
            &'static WorldCenterOfMass,
            &'static LinearVelocity,
            &'static AngularVelocity,
            &'static Inertia,
            Option<&'static BodyConstraints>,
            Option<&'static Representation>,
            Has<RigidPose>,
        ),
    >,
    names: Query<'w, 's, (Option<&'static Name>, Recipes)>,
    sleep: Query<'w, 's, &'static Sleep>,
    particles: Query<'w, 's, (&'static Particle, &'static ParticleRow, Option<&'static Mass>)>,
    rods: Query<'w, 's, &'static DistanceConstraint>,
    springs: Query<'w, 's, &'static Spring>,
}

/// Which recipe a body is from; one flag for each.
type Recipes = (
    Has<RigidBox>,
    Has<RigidMesh>,
    Has<Rope>,
    Has<Cloth>,
    Has<SoftBody>,
    Has<Ragdoll>,
    Has<BodyParticles>,
);

/// The values of one body, as of the end of the last tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Readout {
    /// Number of its particles, and of its constraints.
    pub(crate) particles: usize,
    pub(crate) constraints: usize,
    /// Mass, kg, and centre of mass, m.
    pub(crate) mass: f32,
    pub(crate) centre: Vec3,
    /// Velocity, m/s, and angular velocity, rad/s.
    pub(crate) velocity: Vec3,
    pub(crate) spin: Vec3,
    /// Inertia tensor about its centre of mass in world axes, kg·m².
    pub(crate) inertia: Mat3,
    /// Angular momentum about its centre of mass, kg·m²/s.
    pub(crate) angular_momentum: Vec3,
    /// Kinetic energy of all its particles, J; that of the centre of mass; that of the spin.
    pub(crate) kinetic: f64,
    pub(crate) of_centre: f64,
    pub(crate) of_spin: f64,
    /// Its representation, if it is rigid.
    pub(crate) representation: Option<Representation>,
}

/// A rod or spring that can be cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cuttable {
    pub(crate) constraint: Entity,
    /// Its ends, m.
    pub(crate) ends: [Vec3; 2],
    /// Elongation relative to the rest length.
    pub(crate) strain: f32,
    pub(crate) is_spring: bool,
}

impl Selected<'_, '_> {
    /// Name of a body for the panel: its `Name`, its kind and its entity.
    pub(crate) fn title(&self, body: Entity) -> String {
        let Ok((name, recipes)) = self.names.get(body) else { return "gone".into() };
        let (rigid_box, mesh, rope, cloth, soft, ragdoll, is_body) = recipes;
        let kinds = [
            (rigid_box, "RigidBox"),
            (mesh, "RigidMesh"),
            (rope, "Rope"),
            (cloth, "Cloth"),
            (soft, "SoftBody"),
            (ragdoll, "Ragdoll"),
            (is_body, "Body"),
        ];
        let kind = kinds.into_iter().find(|(is, _)| *is).map_or("Particle", |(_, kind)| kind);
        match name {
            Some(name) => format!("{name} ({kind} {body})"),
            None => format!("{kind} {body}"),
        }
    }

    /// Its `Sleep` component: none if it never sleeps.
    pub(crate) fn sleep(&self, body: Entity) -> Option<&Sleep> {
        self.sleep.get(body).ok()
    }

    /// The values of a body or a loose particle; `None` if it does not exist.
    pub(crate) fn readout(&self, world: &SinewWorld, body: Entity) -> Option<Readout> {
        let Ok((members, centre, velocity, spin, inertia, constraints, representation, rigid)) =
            self.bodies.get(body)
        else {
            return self.loose(world, body);
        };
        let (kinetic, particles) = (self.kinetic(world, members.iter()), members.len());
        let angular_momentum = inertia.0 * spin.0;
        Some(Readout {
            particles,
            constraints: constraints.map_or(0, RelationshipTarget::len),
            mass: centre.mass,
            centre: centre.position,
            velocity: velocity.0,
            spin: spin.0,
            inertia: inertia.0,
            angular_momentum,
            kinetic,
            of_centre: 0.5 * f64::from(centre.mass * velocity.0.length_squared()),
            of_spin: 0.5 * f64::from(angular_momentum.dot(spin.0)),
            representation: rigid.then(|| representation.copied().unwrap_or_default()),
        })
    }

    fn loose(&self, world: &SinewWorld, particle: Entity) -> Option<Readout> {
        let (state, row, mass) = self.particles.get(particle).ok()?;
        let row = row.get().filter(|&row| row < world.particles().len())?;
        let velocity = world.simulation().velocity_now(row);
        let kinetic = self.kinetic(world, [particle].into_iter());
        let mass = mass.map_or(0.0, |mass| mass.0);
        let centre = state.position;
        Some(Readout {
            particles: 1,
            mass,
            centre,
            velocity,
            kinetic,
            of_centre: kinetic,
            ..default()
        })
    }

    /// Kinetic energy of some particles, J.
    fn kinetic(&self, world: &SinewWorld, particles: impl Iterator<Item = Entity>) -> f64 {
        let energy = |particle: Entity| {
            let (_, row, mass) = self.particles.get(particle).ok()?;
            let row = row.get().filter(|&row| row < world.particles().len())?;
            let speed = world.simulation().velocity_now(row).as_dvec3().length_squared();
            Some(0.5 * f64::from(mass?.0) * speed)
        };
        particles.filter_map(energy).sum()
    }

    /// Row of one of its particles, which identifies its island in the solver's report.
    pub(crate) fn row(&self, body: Entity) -> Option<usize> {
        let members = self.bodies.get(body).ok().and_then(|found| found.0.iter().next());
        self.particles.get(members.unwrap_or(body)).ok()?.1.get()
    }

    /// Present position of the clicked point, m.
    pub(crate) fn point(&self, selection: &Selection) -> Option<Vec3> {
        let body = selection.body?;
        if selection.anchor.is_empty() {
            let centre = self.bodies.get(body).map(|found| found.1.position);
            return centre.ok().or_else(|| Some(self.particles.get(body).ok()?.0.position));
        }
        let places = selection.anchor.iter().map(|&(particle, share)| {
            self.particles.get(particle).map(|found| found.0.position * share)
        });
        places.sum::<Result<Vec3, _>>().ok()
    }

    /// The rod or spring of the body that is nearest to the clicked point; of several at the same distance the oldest.
    pub(crate) fn nearest(&self, selection: &Selection) -> Option<Cuttable> {
        let (body, point) = (selection.body?, self.point(selection)?);
        let list = self.bodies.get(body).ok()?.5?;
        let all = list.iter().filter_map(|constraint| self.cuttable(constraint));
        let distance = |one: &Cuttable| {
            let [a, b] = one.ends;
            let along = (point - a).dot(b - a) / (b - a).length_squared().max(f32::MIN_POSITIVE);
            point.distance_squared(a + (b - a) * along.clamp(0.0, 1.0))
        };
        all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn cuttable(&self, constraint: Entity) -> Option<Cuttable> {
        let (a, b, rest, is_spring) =
            match (self.rods.get(constraint), self.springs.get(constraint)) {
                (Ok(rod), _) => (rod.a, rod.b, rod.rest, false),
                (_, Ok(spring)) => (spring.a, spring.b, spring.rest, true),
                _ => return None,
            };
        let place = |end: Entity| Some(self.particles.get(end).ok()?.0.position);
        let ends = [place(a)?, place(b)?];
        let length = ends[0].distance(ends[1]);
        let strain = if rest > 0.0 { length / rest - 1.0 } else { 0.0 };
        Some(Cuttable { constraint, ends, strain, is_spring })
    }
}

/// The contacts of a body in the last tick, each with the other entity if that still exists.
pub(crate) fn contacts(
    world: &SinewWorld,
    body: Entity,
) -> impl Iterator<Item = (Option<Entity>, Impact)> {
    world.report().impacts.iter().filter_map(move |&impact| {
        let [first, second] = [impact.first, impact.second].map(|one| world.entity_of(one));
        if first == Some(body) {
            Some((second, impact))
        } else {
            (second == Some(body)).then_some((first, impact))
        }
    })
}
