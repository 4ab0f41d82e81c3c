//! Hulls: what bodies float by, compiled from entities to rows when a body, its shape or the particles change.

use std::collections::BTreeMap;

use bevy::prelude::*;
use sinew::{Hull, HullFault, Skin};

use crate::components::{
    BodyPart, BodyParticles, CreationOrder, Floats, HullShape, ParticleBody, RigidPose, WindSurface,
};
use crate::messages::{Refusal, Refused, refuse};
use crate::world::{SinewWorld, Tables};

/// The components of which a hull may be made.
type HullInputs = (
    &'static Floats,
    Option<&'static RigidPose>,
    Option<&'static WindSurface>,
    Option<&'static BodyPart>,
    Has<ParticleBody>,
    Has<BodyParticles>,
);

/// Compiles all hulls again if particles were added, removed or set aside, or if a component of which a hull is made was added, removed or changed.
///
/// A hull with an error is left out, and reported once; a hull whose body is not built yet, or whose particles are all set aside, is left out without a
/// message.
pub(crate) fn compile_hulls(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    floating: Query<(Entity, &CreationOrder, HullInputs)>,
    changed: Query<
        (),
        (
            With<Floats>,
            Or<(Changed<Floats>, Changed<RigidPose>, Changed<WindSurface>, Changed<BodyPart>)>,
        ),
    >,
    mut count: Local<[usize; 4]>,
    mut known: Local<BTreeMap<Entity, HullFault>>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    // Change detection finds additions; a removal changes the count.
    let mut now = [0; 4];
    for (_, _, (_, pose, surface, part, ..)) in &floating {
        let there = [true, pose.is_some(), surface.is_some(), part.is_some()];
        now.iter_mut().zip(there).for_each(|(count, there)| *count += usize::from(there));
    }
    let count_changed = core::mem::replace(&mut *count, now) != now;
    if !tables.links_compiled && !count_changed && changed.is_empty() {
        return;
    }
    let mut bodies: Vec<_> = floating.iter().collect();
    bodies.sort_unstable_by_key(|(entity, order, _)| (**order, *entity));
    let before = core::mem::take(&mut *known);
    let hulls = &mut simulation.forces.hulls;
    hulls.clear();
    for (entity, _, inputs) in bodies {
        match hull(tables, inputs) {
            Ok(found) => hulls.extend(found),
            Err(fault) => {
                if before.get(&entity) != Some(&fault) {
                    refuse(&mut messages, entity, Refusal::Hull(fault));
                }
                known.insert(entity, fault);
            }
        }
    }
}

/// The hull of a body; `None` while the body or its particles are missing.
fn hull(
    tables: &Tables,
    (floats, pose, surface, part, is_body, is_built): <HullInputs as bevy::ecs::query::QueryData>::Item<
        '_,
        '_,
    >,
) -> Result<Option<Hull>, HullFault> {
    if is_body && !is_built {
        return Ok(None);
    }
    match (&floats.shape, part) {
        (HullShape::Own, Some(part)) => posed_hull(tables, pose, box_mesh(part.size)),
        (HullShape::Own | HullShape::Surface, _) => surface_hull(tables, surface),
        (HullShape::Box { size }, _) => posed_hull(tables, pose, box_mesh(*size)),
        (HullShape::Mesh { vertices, triangles }, _) => {
            posed_hull(tables, pose, (vertices.clone(), triangles.clone()))
        }
    }
}

/// A hull in the frame of a rigid body, carried by those of its particles that exist and are not set aside.
fn posed_hull(
    tables: &Tables,
    pose: Option<&RigidPose>,
    (vertices, triangles): (Vec<Vec3>, Vec<[u32; 3]>),
) -> Result<Option<Hull>, HullFault> {
    let pose = pose.ok_or(HullFault::Empty)?;
    if pose.particles.len() != pose.rest.len() {
        return Err(HullFault::Count);
    }
    let carriers = pose.particles.iter().zip(&pose.rest);
    let valid = carriers.filter_map(|(&p, &rest)| Some((tables.valid_row(p)?, rest)));
    let (rows, rest): (Vec<u32>, Vec<Vec3>) = valid.unzip();
    let skin = Skin::Posed { vertices, rest };
    hull_from_rows(tables, rows, triangles, skin, pose.particles.iter().copied())
}

/// A hull whose corners are particles; a triangle with a missing corner is left out, as for the wind.
fn surface_hull(tables: &Tables, surface: Option<&WindSurface>) -> Result<Option<Hull>, HullFault> {
    let corners = &surface.ok_or(HullFault::Empty)?.triangles;
    let row = |corner| tables.valid_row(corner);
    let valid: Vec<[u32; 3]> =
        corners.iter().filter_map(|&[a, b, c]| Some([row(a)?, row(b)?, row(c)?])).collect();
    let mut rows: Vec<u32> = valid.iter().flatten().copied().collect();
    rows.sort_unstable();
    rows.dedup();
    // Every row is in the list, which was made from them.
    let place = |row: u32| rows.partition_point(|&other| other < row) as u32;
    let triangles = valid.iter().map(|corners| corners.map(place)).collect();
    hull_from_rows(
        tables,
        rows.clone(),
        triangles,
        Skin::Carriers,
        corners.iter().flatten().copied(),
    )
}

/// The hull, or its error. If all of its particles are set aside, it waits for them.
fn hull_from_rows(
    tables: &Tables,
    rows: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    skin: Skin,
    mut named: impl Iterator<Item = Entity>,
) -> Result<Option<Hull>, HullFault> {
    if rows.is_empty() && named.any(|particle| tables.is_absent(particle)) {
        return Ok(None);
    }
    Hull::new(rows, triangles, skin).map(Some)
}

/// A solid box about the origin: corner `i` is on the positive side of x, y and z if bit 0, 1 and 2 of `i` is set.
fn box_mesh(size: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    // Counter-clockwise from outside, like the faces of `sinew::recipes::box_3d`.
    const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let side = |i: u32, bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
    let corner = |i| Vec3::new(side(i, 0), side(i, 1), side(i, 2)) * size;
    let triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}
