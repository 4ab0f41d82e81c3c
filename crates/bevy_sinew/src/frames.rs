//! World transforms of entities through their parents, computed on demand, as `GlobalTransform` is a frame old in the fixed schedule.
//!
//! The solver works in world coordinates; a placement there is a translation, a rotation and a scale along the entity's own axes. Uniformly scaled parents
//! preserve this form. A non-uniformly scaled parent shears a rotated child, unless it is rotated by right angles: that is no such placement, and the child is
//! refused.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::{Allow, QueryFilter};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::collide::is_uniform;

/// Read access to transforms and parents, disabled ones too: what hangs on a disabled entity stays where it is.
#[derive(SystemParam)]
pub(crate) struct Frames<'w, 's> {
    transforms: Query<'w, 's, &'static Transform, Allow<Disabled>>,
    parents: Query<'w, 's, &'static ChildOf, Allow<Disabled>>,
}

/// Why an entity has no valid placement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Misplaced {
    /// A parent shears it.
    Sheared,
    /// It is round, or a figure, and is scaled non-uniformly.
    NonUniform,
}

impl Frames<'_, '_> {
    /// The world transform of an entity. An entity without a transform is at its parent.
    pub(crate) fn of(&self, entity: Entity) -> Result<Transform, Misplaced> {
        let own = |entity| self.transforms.get(entity).ok().copied();
        world_transform(own(entity).unwrap_or_default(), entity, own, &self.parents)
    }

    /// The world transform of an entity's parent; the identity if it has none.
    #[cfg(feature = "interpolation")]
    pub(crate) fn above(&self, entity: Entity) -> Result<Transform, Misplaced> {
        let own = |entity| self.transforms.get(entity).ok().copied();
        world_transform(Transform::IDENTITY, entity, own, &self.parents)
    }

    /// The world matrix of an entity, sheared by its parents or not; `None` if it has no transform.
    pub(crate) fn matrix(&self, entity: Entity) -> Option<GlobalTransform> {
        let own = GlobalTransform::from(*self.transforms.get(entity).ok()?);
        let above = self.parents.iter_ancestors(entity);
        Some(
            above
                .filter_map(|parent| self.transforms.get(parent).ok())
                .fold(own, |inner, outer| *outer * inner),
        )
    }
}

/// The world transform of `inner` in the frame of an entity's parents.
pub(crate) fn world_transform<F: QueryFilter>(
    inner: Transform,
    entity: Entity,
    transform: impl Fn(Entity) -> Option<Transform>,
    parents: &Query<&ChildOf, F>,
) -> Result<Transform, Misplaced> {
    through_parents(inner, entity, transform, |of| parents.get(of).ok().map(ChildOf::parent))
}

fn through_parents(
    inner: Transform,
    entity: Entity,
    transform: impl Fn(Entity) -> Option<Transform>,
    parent: impl Fn(Entity) -> Option<Entity>,
) -> Result<Transform, Misplaced> {
    let mut above = core::iter::successors(parent(entity), |&of| parent(of));
    above.try_fold(inner, |inner, parent| match transform(parent) {
        Some(outer) => compose(&outer, &inner).ok_or(Misplaced::Sheared),
        None => Ok(inner),
    })
}

/// Converts a world transform to the frame `above`; its scale is kept.
pub(crate) fn to_local(above: &Transform, place: &Transform) -> Transform {
    let back = above.rotation.inverse();
    Transform {
        translation: back * (place.translation - above.translation) / above.scale,
        rotation: back * place.rotation,
        scale: place.scale,
    }
}

/// The world transform of an entity, from a `World`.
pub(crate) fn in_world(world: &World, entity: Entity) -> Result<Transform, Misplaced> {
    let own = |entity| world.get::<Transform>(entity).copied();
    let parent = |of| world.get::<ChildOf>(of).map(ChildOf::parent);
    through_parents(own(entity).unwrap_or_default(), entity, own, parent)
}

/// The factor of a uniform scale, without its sign; an error for any other scale.
pub(crate) fn even_factor(scale: Vec3) -> Result<f32, Misplaced> {
    let factor = scale.abs();
    if is_uniform(factor) { Ok(factor.x) } else { Err(Misplaced::NonUniform) }
}

/// Relative difference up to which two scales are the same: that of a scale that Bevy has taken from a matrix, as when an entity gets another parent in place.
const SCALE_ROUND_OFF: f32 = 2e-6;

/// Whether two scales are the same, within round-off. Otherwise a body would be rebuilt in a size that it has.
pub(crate) fn is_same_scale(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().cmple(b.abs() * SCALE_ROUND_OFF).all()
}

/// The composition of two transforms; `None` if `outer` shears `inner`.
pub fn compose(outer: &Transform, inner: &Transform) -> Option<Transform> {
    let translation = outer.transform_point(inner.translation);
    let (s, r) = (outer.scale, inner.rotation);
    if is_uniform(s) || r == Quat::IDENTITY {
        let (rotation, scale) = (outer.rotation * r, s * inner.scale);
        return Some(Transform { translation, rotation, scale });
    }
    // The stretched axes of the inner frame; they are perpendicular if nothing is sheared.
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| s * (r * axis));
    let lengths = axes.map(Vec3::length);
    let [x, y, z] = [0, 1, 2].map(|i| axes[i] / lengths[i]);
    let skew = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
    // Written so that NaN counts as sheared: a scale of zero leaves no axis.
    #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN is sheared")]
    if !(skew < 1e-4) {
        return None;
    }
    let mirror = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
    let turned = Mat3::from_cols(x * mirror, y, z);
    let scale = Vec3::new(lengths[0] * mirror, lengths[1], lengths[2]) * inner.scale;
    let rotation = outer.rotation * Quat::from_mat3(&turned);
    Some(Transform { translation, rotation, scale })
}
