//! Arrows made of meshes, which every renderer draws: displacements, velocities, forces.

use bevy::prelude::*;

use crate::look::Look;
use crate::scene::InScene;
use crate::shapes::cylinder;

/// An arrow from point to point: a shaft and a head, two entities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrow {
    shaft: Entity,
    head: Entity,
    /// Length of the head, metres. A shorter arrow is only a head, scaled down.
    tip: f32,
}

/// Scale of a hidden part. Not zero, so that every transform can be inverted.
const HIDDEN: Vec3 = Vec3::splat(1e-4);

impl Arrow {
    /// An arrow with a shaft of this radius, metres, hidden at first.
    pub(crate) fn spawn(world: &mut World, radius: f32, look: Look) -> Self {
        let tip = 9.0 * radius;
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        let shaft = Mesh3d(meshes.add(cylinder(radius, 1.0)));
        let head = Cone { radius: 3.2 * radius, height: tip }.mesh().resolution(20).build();
        let head = Mesh3d(meshes.add(head));
        let hidden = Transform::from_scale(HIDDEN);
        let [shaft, head] =
            [shaft, head].map(|mesh| world.spawn((InScene, mesh, look.clone(), hidden)).id());
        Self { shaft, head, tip }
    }

    /// Draws it from one point to another, metres; hides it if `ends` is `None` or the two points coincide.
    pub(crate) fn point(self, drawn: &mut Query<&mut Transform>, ends: Option<[Vec3; 2]>) {
        let [shaft, head] = self.transforms(ends);
        for (entity, placed) in [(self.shaft, shaft), (self.head, head)] {
            if let Ok(mut transform) = drawn.get_mut(entity) {
                *transform = placed;
            }
        }
    }

    fn transforms(self, ends: Option<[Vec3; 2]>) -> [Transform; 2] {
        let way = ends.map_or(Vec3::ZERO, |[from, to]| to - from);
        let (Some([from, to]), Some(along)) = (ends, way.try_normalize()) else {
            return [Transform::from_scale(HIDDEN); 2];
        };
        let length = way.length();
        let tip = self.tip.min(length);
        let turn = Quat::from_rotation_arc(Vec3::Y, along);
        let rod = (length - tip).max(1e-4);
        let shaft = Transform::from_translation(from + along * (0.5 * rod))
            .with_rotation(turn)
            .with_scale(Vec3::new(1.0, rod, 1.0));
        let head = Transform::from_translation(to - along * (0.5 * tip))
            .with_rotation(turn)
            .with_scale(Vec3::splat(tip / self.tip));
        [shaft, head]
    }
}
