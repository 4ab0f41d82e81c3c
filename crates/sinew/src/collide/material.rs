//! What surfaces are made of, and which may touch: friction, restitution, the lectures' drags; layers.

use crate::constraints::PlanarDrag;

/// What a surface is made of. Two that touch make a [`CombinedMaterial`] of theirs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Coulomb's coefficient of friction μ, 0 (ice) and up. Default 0.5.
    pub friction: f32,
    /// Which part of the speed of approach it bounces back with, 0 (not at all) to 1 (all of it). Default 0.
    pub restitution: f32,
    /// How the friction of two surfaces is made of each one's. Default [`Combine::Average`].
    pub friction_rule: Combine,
    /// The same of restitution.
    pub restitution_rule: Combine,
    /// The lectures' friction: a drag along the surface and one across it, for what touches it: single particles on what stands, and body colliders.
    /// Of two surfaces the greater counts. Default none.
    pub drag: PlanarDrag,
}

/// How a coefficient of two surfaces is made of each one's. Where the two ask for different rules, the one later in this list counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Combine {
    /// Half of their sum. The default.
    #[default]
    Average,
    /// The smaller of the two: ice is slippery for everyone.
    Min,
    /// Their product.
    Multiply,
    /// The greater of the two.
    Max,
}

/// Two surfaces that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CombinedMaterial {
    /// Coefficient of friction μ.
    pub friction: f32,
    /// Coefficient of restitution e.
    pub restitution: f32,
    /// Drag along and across, shares of the velocity lost per second.
    pub drag: PlanarDrag,
}

impl Default for Material {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Material {
    const DEFAULT: Self = Self {
        friction: 0.5,
        restitution: 0.0,
        friction_rule: Combine::Average,
        restitution_rule: Combine::Average,
        drag: PlanarDrag { along: 0.0, across: 0.0 },
    };

    /// The same with another coefficient of friction.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// The same with another coefficient of restitution.
    pub fn with_restitution(self, restitution: f32) -> Self {
        Self { restitution, ..self }
    }

    /// Whether all numbers are finite and in range.
    pub fn is_valid(&self) -> bool {
        self.friction.is_finite()
            && self.friction >= 0.0
            && (0.0..=1.0).contains(&self.restitution)
            && self.drag.is_valid()
    }

    /// What becomes of this surface and another one.
    pub fn against(&self, other: &Self) -> CombinedMaterial {
        CombinedMaterial {
            friction: self.friction_rule.max(other.friction_rule).of(self.friction, other.friction),
            restitution: self
                .restitution_rule
                .max(other.restitution_rule)
                .of(self.restitution, other.restitution),
            drag: PlanarDrag {
                along: self.drag.along.max(other.drag.along),
                across: self.drag.across.max(other.drag.across),
            },
        }
    }
}

impl Combine {
    /// The coefficient of two surfaces.
    pub fn of(self, a: f32, b: f32) -> f32 {
        match self {
            Self::Average => 0.5 * (a + b),
            Self::Min => a.min(b),
            Self::Multiply => a * b,
            Self::Max => a.max(b),
        }
    }
}

/// Which things may touch: two of them do if each is a member of a layer that the other one collides with. 32 layers, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layers {
    /// Layers that it is in. Default the first.
    pub memberships: u32,
    /// Layers that it collides with. Default all.
    pub filters: u32,
}

impl Default for Layers {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Layers {
    const DEFAULT: Self = Self { memberships: 1, filters: u32::MAX };

    /// Touches nothing.
    pub const NONE: Self = Self { memberships: 0, filters: 0 };

    /// A member of the first of these layers that collides with the second of them.
    pub const fn new(memberships: u32, filters: u32) -> Self {
        Self { memberships, filters }
    }

    /// Whether the two may touch.
    #[inline]
    pub const fn meets(self, other: Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}

/// How a body takes part in contacts with colliders, with other bodies and with itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyContacts {
    /// What it is made of.
    pub material: Material,
    /// What it may touch.
    pub layers: Layers,
    /// Whether it touches other bodies, if they touch it: rigid parts by their shape, other particles as balls of their radius. Default so.
    pub with_bodies: bool,
    /// Whether its particles touch each other where they are further apart in the rest shape. Default not.
    pub with_itself: bool,
    /// Whether it touches those by the triangles of its surface, too ([`Forces::surfaces`](crate::Forces::surfaces)), and not by its particles alone:
    /// nothing passes through its mesh then, however coarse that is. It costs some ten times what its particles do. Default not.
    pub surface: bool,
    /// Whether its contacts are listed in the report. Default not.
    pub events: bool,
    /// Whether it touches nothing at all, not even colliders, planes and boxes. Default not.
    pub disabled: bool,
}

impl Default for BodyContacts {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl BodyContacts {
    /// Touches all there is but itself.
    pub(crate) const DEFAULT: Self = Self {
        material: Material::DEFAULT,
        layers: Layers::DEFAULT,
        with_bodies: true,
        with_itself: false,
        surface: false,
        events: false,
        disabled: false,
    };

    /// Whether it touches anything that moves.
    pub(crate) fn takes_part(&self) -> bool {
        !self.disabled && (self.with_bodies || self.with_itself)
    }

    /// Whether two bodies touch, if no joint keeps them from it.
    #[inline(always)]
    pub(crate) fn meets(&self, other: &Self) -> bool {
        self.with_bodies
            && other.with_bodies
            && !self.disabled
            && !other.disabled
            && self.layers.meets(other.layers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_later_rule_of_two_counts() {
        let rubber = Material { friction: 1.0, ..Default::default() };
        let ice = Material { friction: 0.1, friction_rule: Combine::Min, ..Default::default() };
        assert_eq!(rubber.against(&ice).friction, 0.1);
        assert_eq!(rubber.against(&Material::default()).friction, 0.75);
        let sticky = Material { friction: 2.0, friction_rule: Combine::Max, ..Default::default() };
        assert_eq!(sticky.against(&ice).friction, 2.0);
        assert_eq!(ice.against(&sticky), sticky.against(&ice));
        assert_eq!(Combine::Multiply.of(0.5, 0.5), 0.25);
    }

    #[test]
    fn layers_must_mind_each_other() {
        let (player, wall) = (Layers::new(1, 2), Layers::new(2, 1));
        assert!(player.meets(wall) && wall.meets(player));
        assert!(!player.meets(player));
        assert!(!player.meets(Layers::new(2, 4)), "the other does not mind it");
        assert!(Layers::default().meets(Layers::default()));
        assert!(!Layers::NONE.meets(Layers::default()));
    }

    #[test]
    fn broken_numbers_are_told() {
        assert!(Material::default().is_valid());
        for bad in [f32::NAN, -0.1, f32::INFINITY] {
            assert!(!Material::default().with_friction(bad).is_valid());
            assert!(!Material::default().with_restitution(bad).is_valid());
        }
        assert!(!Material::default().with_restitution(1.1).is_valid());
    }
}
