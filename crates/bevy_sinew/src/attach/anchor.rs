//! Anchors: where on a body something is tied, said by what the body is.

use bevy::prelude::*;

/// Where on an entity something is tied: what of a body, and where on the other one ([`AttachTo`](super::AttachTo)).
///
/// Places are in the entity's own frame, metres. That of a body is the one in which its recipe builds it, scaled as the entity is: a region of a cloth is the
/// same however the cloth hangs by now, and a point of a soft body or of a rope is its particle that was built nearest to it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::RopeEnd;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let post = commands.spawn(Transform::from_xyz(0.0, 2.0, 0.0)).id();
/// // The upper left corner of a banner, by where it is, and both ends of a rope.
/// let corner = Anchor::Point(Vec3::new(-0.5, 0.5, 0.0));
/// commands.spawn((Cloth::grid(1.0, 1.0, 8, 8), AttachTo::new(post).part(corner)));
/// let end = Anchor::RopeEnd(RopeEnd::First);
/// commands.spawn((Rope::default(), AttachTo::new(post).part(end)));
/// # }
/// ```
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Anchor {
    /// Of the body: all of its particles, each by itself. On the other entity: wherever that is; to snap to, its origin. The default.
    #[default]
    Whole,
    /// A point. Of a rigid body any point, in it or not; of any other the particle that was built nearest to it.
    Point(Vec3),
    /// A corner of a box or of a limb ([`BodyPart`](crate::BodyPart)): the signs say which. With a zero it is the middle of an edge or of a face.
    Corner(Vec3),
    /// The particle that follows this vertex of the body's mesh, as [`MeshFollow`](crate::MeshFollow) has it; where it has none, the particle of this
    /// number in [`BodyParticles`](crate::BodyParticles).
    Vertex(u32),
    /// The particles that were built within a box along the axes of the frame.
    InBox {
        /// Its middle, metres.
        center: Vec3,
        /// Half its size, metres.
        half_size: Vec3,
    },
    /// The particles that were built within a sphere.
    InSphere {
        /// Its middle, metres.
        center: Vec3,
        /// Metres.
        radius: f32,
    },
    /// An end of a rope.
    RopeEnd(RopeEnd),
    /// A point of a bone, by its name: of a [`Ragdoll`](crate::Ragdoll) or an [`Articulated`](crate::Articulated) body.
    Bone {
        /// The `Name` of its [`BodyPart`](crate::BodyPart).
        name: String,
        /// In the bone's own frame, metres.
        point: Vec3,
    },
}

/// An end of a rope.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum RopeEnd {
    /// Where it starts. The default.
    #[default]
    First,
    /// Where it ends.
    Last,
}

impl Anchor {
    /// The middle of a bone.
    pub fn bone(name: impl Into<String>) -> Self {
        Self::Bone { name: name.into(), point: Vec3::ZERO }
    }

    /// Whether all its numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        match self {
            Self::Whole | Self::Vertex(_) | Self::RopeEnd(_) => true,
            Self::Point(point) | Self::Corner(point) | Self::Bone { point, .. } => {
                point.is_finite()
            }
            Self::InBox { center, half_size } => center.is_finite() && half_size.is_finite(),
            Self::InSphere { center, radius } => center.is_finite() && radius.is_finite(),
        }
    }

    /// Whether a place is in the region that it is; `None` if it is none.
    pub(super) fn holds(&self, place: Vec3) -> Option<bool> {
        match *self {
            Self::InBox { center, half_size } => {
                Some((place - center).abs().cmple(half_size.abs()).all())
            }
            Self::InSphere { center, radius } => Some(place.distance(center) <= radius),
            _ => None,
        }
    }
}
