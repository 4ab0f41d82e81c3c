//! Where entities are, in a tick.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

/// Where entities are: computed afresh, as `GlobalTransform` is a frame old in the fixed schedule.
#[derive(SystemParam)]
pub(crate) struct Frames<'w, 's> {
    transforms: Query<'w, 's, &'static Transform>,
    parents: Query<'w, 's, &'static ChildOf>,
}

impl Frames<'_, '_> {
    /// Where an entity is, on top of its parents. What has no transform is where its parents are.
    pub(crate) fn of(&self, entity: Entity) -> Transform {
        let own = |entity| self.transforms.get(entity).copied().unwrap_or_default();
        let parents = self.parents.iter_ancestors(entity);
        parents.fold(own(entity), |inner, parent| own(parent).mul_transform(inner))
    }
}
