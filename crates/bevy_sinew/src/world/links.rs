//! Which links (springs and constraints) are in the solver's lists, and where.

use bevy::prelude::*;

use crate::components::CreationOrder;

/// The key of each link in the solver's lists, by index.
#[derive(Default)]
pub(crate) struct Links {
    pub(crate) distances: Vec<LinkKey>,
    pub(crate) constraints: Vec<LinkKey>,
    pub(crate) springs: Vec<LinkKey>,
    /// Whether all links are in the lists: none is invalid or waits.
    pub(crate) complete: bool,
    /// The layout of the rows that they refer to.
    pub(crate) layout: u64,
    /// A counter of changes of the lists.
    pub(crate) version: u64,
    pub(crate) surfaces: CompiledSurfaces,
}

/// What the solver's list of triangles was compiled from.
#[derive(Clone, Copy, Default)]
pub(crate) struct CompiledSurfaces {
    /// The number of surfaces.
    pub(crate) count: usize,
    /// Whether no particle was set aside.
    pub(crate) all_valid: bool,
    /// The layout of rows, and the end of the rows that the triangles refer to.
    pub(crate) layout: u64,
    pub(crate) end: usize,
}

/// The index of a link in one of the solver's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LinkIndex {
    /// In the list of distances.
    Distance(usize),
    /// In the list of springs.
    Spring(usize),
    /// In the list of all other constraints.
    Constraint(usize),
}

impl LinkIndex {
    pub(crate) fn distance(self) -> Option<usize> {
        if let Self::Distance(number) = self { Some(number) } else { None }
    }

    pub(crate) fn constraint(self) -> Option<usize> {
        if let Self::Constraint(number) = self { Some(number) } else { None }
    }
}

impl Links {
    /// Calls `each` for all links of an entity.
    pub(crate) fn find(
        &self,
        order: CreationOrder,
        entity: Entity,
        mut each: impl FnMut(LinkIndex),
    ) {
        let lists: [(&[LinkKey], fn(usize) -> LinkIndex); 3] = [
            (&self.distances, LinkIndex::Distance),
            (&self.springs, LinkIndex::Spring),
            (&self.constraints, LinkIndex::Constraint),
        ];
        for (keys, at) in lists {
            let first = keys.partition_point(|key| (key.order, key.entity) < (order, entity));
            let own = keys[first..].iter().take_while(|key| key.entity == entity);
            (first..).zip(own).for_each(|(number, _)| each(at(number)));
        }
    }
}

/// The entity of a link, and its sort key: by creation, and for several on one entity by their kind.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct LinkKey {
    pub(crate) order: CreationOrder,
    pub(crate) entity: Entity,
    pub(crate) kind: usize,
}
