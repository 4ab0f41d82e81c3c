//! Tubes around chains of particles, for ropes.

use core::f32::consts::TAU;
use core::mem::{swap, take};

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use super::{Easing, Frame};
use crate::components::{Interpolate, TubeMesh};
use crate::frames::Frames;
use crate::recipes::MadeFrom;
use crate::rows::{GONE, ResolvedRows};
use crate::schedule::SinewClock;
use crate::world::SinewWorld;

/// Gives each [`TubeMesh`] a mesh of its own, and updates it.
pub(crate) fn draw_tubes(
    mut commands: Commands,
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    easing: Easing,
    meshes: Option<ResMut<Assets<Mesh>>>,
    mut tubes: Query<(
        Entity,
        Ref<TubeMesh>,
        &mut ResolvedRows<TubeMesh>,
        Option<&Mesh3d>,
        Has<Interpolate>,
    )>,
    frames: Frames,
    mut middle: Local<Vec<Vec3>>,
    mut skin: Local<Skin>,
    mut drawn_meshes: Local<Vec<AssetId<Mesh>>>,
) {
    let Some(mut meshes) = meshes else { return };
    drawn_meshes.clear();
    for (entity, tube, mut rows, handle, eased) in &mut tubes {
        let drawn = handle.is_some() && !tube.is_changed() && rows.drawn == clock.tick;
        if drawn && !eased && easing.running() {
            continue;
        }
        rows.drawn = clock.tick;
        let ease = easing.now(eased);
        let rows =
            rows.resolve(&world.tables.layout, tube.is_changed(), tube.particles.iter().copied());
        let Some(frame) = Frame::of(&frames, entity) else { continue };
        middle.clear();
        let there = rows.iter().filter(|&&row| row != GONE);
        middle.extend(there.map(|&row| Vec3::from(frame.place(&world, row, ease))));
        let sides = tube.sides.clamp(3, 64) as usize;
        let mut draw = |mesh: &mut Mesh| {
            // Works in the mesh's own memory.
            skin.trade_lists(mesh);
            skin.wrap(&middle, tube.radius, sides);
            skin.trade_lists(mesh);
            skin.put_triangles(mesh, tube.is_changed());
        };
        // A clone of a rope has the mesh of its original, and is given one of its own.
        let is_own = |handle: &&Mesh3d| match drawn_meshes.binary_search(&handle.id()) {
            Ok(_) => false,
            Err(at) => {
                drawn_meshes.insert(at, handle.id());
                true
            }
        };
        if let Some(handle) = handle.filter(is_own) {
            if let Some(mut mesh) = meshes.get_mut(&handle.0) {
                draw(&mut mesh);
            }
            continue;
        }
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        draw(&mut mesh);
        let own = meshes.add(mesh);
        commands.entity(entity).try_insert((Mesh3d(own.clone()), MadeFrom { source: None, own }));
    }
}

/// The surface of a tube, in rings of `sides + 1` vertices (the first is repeated at the end, for the texture seam). Kept from frame to frame to reuse its
/// memory, and for the data that tubes share.
#[derive(Default)]
pub(crate) struct Skin {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
    /// The number of rings and sides of the indices.
    indexed: (usize, usize),
    /// The vertices of a ring.
    turns: Vec<Turn>,
}

/// A vertex on a ring.
struct Turn {
    /// Fraction of the way around.
    share: f32,
    sin: f32,
    cos: f32,
}

impl Skin {
    /// Computes a tube of `radius` metres around a chain of points, closed by flat caps from its end rings. For fewer than two points, as in the frame in which
    /// a rope is spawned, it is a degenerate triangle: for a mesh without vertices Bevy 0.19's renderer allocates nothing, and then reports an error where it
    /// copies the vertices all the same ("use after free").
    ///
    /// The rings do not twist: the direction of each ring is that of the previous one, rotated by the shortest arc between the two segments that it separates
    /// (parallel transport).
    fn wrap(&mut self, middle: &[Vec3], radius: f32, sides: usize) {
        if middle.len() < 2 {
            let at = middle.first().copied().unwrap_or_default();
            self.positions = vec![at.to_array(); 3];
            self.normals = vec![[0.0, 1.0, 0.0]; 3];
            self.uvs = vec![[0.0; 2]; 3];
            (self.indices, self.indexed) = (vec![0, 1, 2], (0, 0));
            return;
        }
        self.lay_out(middle.len(), sides);
        let Self { positions, normals, uvs, turns, .. } = self;
        let last = middle.len() - 1;
        let direction = |i: usize| {
            let (before, after) = (middle[i.saturating_sub(1)], middle[(i + 1).min(last)]);
            (after - before).try_normalize()
        };
        let mut along = direction(0).unwrap_or(Vec3::Y);
        let mut across = along.any_orthonormal_vector();
        let (mut run, around) = (0.0, TAU * radius.max(1e-6));
        let rings =
            positions.chunks_exact_mut(turns.len()).zip(normals.chunks_exact_mut(turns.len()));
        let rings = rings.zip(uvs.chunks_exact_mut(turns.len()));
        for (i, (point, ((positions, normals), uvs))) in middle.iter().zip(rings).enumerate() {
            let next = direction(i).unwrap_or(along);
            across = carried(across, along, next);
            along = next;
            if i > 0 {
                run += middle[i - 1].distance(*point);
            }
            let side = along.cross(across);
            // One repetition of the texture is as long as the circumference, so that the strands of a rope keep their slant.
            let high = run / around;
            let vertices = positions.iter_mut().zip(normals).zip(uvs);
            for (((position, normal), uv), turn) in vertices.zip(&*turns) {
                let out = across * turn.cos + side * turn.sin;
                *position = (*point + out * radius).to_array();
                *normal = out.to_array();
                *uv = [turn.share, high];
            }
        }
    }

    /// Allocates this number of rings, and the triangles between them.
    fn lay_out(&mut self, rings: usize, sides: usize) {
        let Self { positions, normals, uvs, indices, indexed, turns } = self;
        let vertices = rings * (sides + 1);
        positions.resize(vertices, [0.0; 3]);
        normals.resize(vertices, [0.0; 3]);
        uvs.resize(vertices, [0.0; 2]);
        if turns.len() != sides + 1 {
            turns.clear();
            turns.extend((0..=sides).map(|k| {
                let share = k as f32 / sides as f32;
                let (sin, cos) = libm::sincosf(share * TAU);
                Turn { share, sin, cos }
            }));
        }
        if *indexed == (rings, sides) {
            return;
        }
        *indexed = (rings, sides);
        indices.clear();
        let (ring, last) = (sides as u32 + 1, rings as u32 - 1);
        for i in 0..last {
            for k in 0..sides as u32 {
                let (a, b) = (i * ring + k, i * ring + k + 1);
                indices.extend([a, b, a + ring, b, b + ring, a + ring]);
            }
        }
        for (first, flip) in [(0, true), (last * ring, false)] {
            for k in 1..sides as u32 - 1 {
                let (b, c) = if flip { (k + 1, k) } else { (k, k + 1) };
                indices.extend([first, first + b, first + c]);
            }
        }
    }

    /// Swaps its vertex lists with those of a mesh.
    fn trade_lists(&mut self, mesh: &mut Mesh) {
        let Self { positions, normals, uvs, .. } = self;
        for (attribute, own) in
            [(Mesh::ATTRIBUTE_POSITION, positions), (Mesh::ATTRIBUTE_NORMAL, normals)]
        {
            match mesh.try_attribute_mut(attribute) {
                Ok(VertexAttributeValues::Float32x3(list)) => swap(list, own),
                _ => mesh.insert_attribute(attribute, take(own)),
            }
        }
        match mesh.try_attribute_mut(Mesh::ATTRIBUTE_UV_0) {
            Ok(VertexAttributeValues::Float32x2(list)) => swap(list, uvs),
            _ => mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, take(uvs)),
        }
    }

    /// Writes the indices into a mesh if they may differ: if the tube `changed`, or their number did.
    fn put_triangles(&self, mesh: &mut Mesh, changed: bool) {
        let Self { indices, .. } = self;
        match mesh.try_indices_mut() {
            Ok(Indices::U32(list)) if !changed && list.len() == indices.len() => {}
            Ok(Indices::U32(list)) => list.clone_from(indices),
            _ => mesh.insert_indices(Indices::U32(indices.clone())),
        }
    }
}

/// Rotates a unit vector that is perpendicular to `along` with the shortest rotation from `along` to `next`. With `w` their cross product and `c` their dot
/// product, that is Rodrigues' `v + w × v + w × (w × v) / (1 + c)`.
fn carried(across: Vec3, along: Vec3, next: Vec3) -> Vec3 {
    let (axis, cos) = (along.cross(next), along.dot(next));
    let turned = if cos > -0.99 {
        let moved = axis.cross(across);
        across + moved + axis.cross(moved) / (1.0 + cos)
    } else {
        // Nearly opposite directions: the shortest rotation is not unique.
        Quat::from_rotation_arc(along, next) * across
    };
    turned.normalize_or(across)
}
