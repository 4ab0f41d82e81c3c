//! Which spring or constraint stands where in the solver's lists.

use bevy::prelude::*;

use crate::components::CreationOrder;

/// Whose links stand in the solver's lists, place by place.
#[derive(Default)]
pub(crate) struct Links {
    pub(crate) distances: Vec<Place>,
    pub(crate) constraints: Vec<Place>,
    pub(crate) springs: Vec<Place>,
    /// Whether all links there are do.
    pub(crate) sound: bool,
    /// The layout whose rows they name.
    pub(crate) layout: u64,
    /// Counts the changes of the lists.
    pub(crate) version: u64,
    pub(crate) surfaces: CompiledSurfaces,
}

/// Of what the solver's list of triangles was made.
#[derive(Clone, Copy, Default)]
pub(crate) struct CompiledSurfaces {
    /// How many surfaces there were.
    pub(crate) count: usize,
    /// Whether no particle was set aside.
    pub(crate) all_sound: bool,
    /// The layout of rows that they named, and the end of those rows.
    pub(crate) layout: u64,
    pub(crate) end: usize,
}

/// Where a link stands in the solver's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LinkAt {
    /// The number of a distance.
    Distance(usize),
    /// Of a spring.
    Spring(usize),
    /// Of any other constraint.
    Constraint(usize),
}

impl LinkAt {
    pub(crate) fn distance(self) -> Option<usize> {
        if let Self::Distance(number) = self { Some(number) } else { None }
    }

    pub(crate) fn constraint(self) -> Option<usize> {
        if let Self::Constraint(number) = self { Some(number) } else { None }
    }
}

impl Links {
    /// Finds all links of an entity.
    pub(crate) fn find(&self, order: CreationOrder, entity: Entity, mut each: impl FnMut(LinkAt)) {
        let lists: [(&[Place], fn(usize) -> LinkAt); 3] = [
            (&self.distances, LinkAt::Distance),
            (&self.springs, LinkAt::Spring),
            (&self.constraints, LinkAt::Constraint),
        ];
        for (places, at) in lists {
            let first =
                places.partition_point(|place| (place.order, place.entity) < (order, entity));
            let own = places[first..].iter().take_while(|place| place.entity == entity);
            (first..).zip(own).for_each(|(number, _)| each(at(number)));
        }
    }
}

/// Whose link it is, and where it stands in its list: by creation, and for several on one entity by their kind.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Place {
    pub(crate) order: CreationOrder,
    pub(crate) entity: Entity,
    pub(crate) kind: usize,
}
