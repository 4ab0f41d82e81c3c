//! Parts of one body that overlap in its rest shape, and so never touch: a thigh and the pelvis that it goes into, two bones away. They are found when body
//! colliders, bodies or rest places have changed, for the bodies that touch themselves. Those that are very many are segments of a rope, which are
//! compared when they come near each other ([`overlaps_at_rest`](BodyCollider::overlaps_at_rest)).

use glam::{Quat, Vec3};

use super::super::body_collider::BodyCollider;
use super::super::filter::ContactFilter;
use super::super::frame::Frame;
use super::super::manifold::{ManifoldScratch, collide};
use super::groups::BodyGroups;
use crate::kept::Kept;
use crate::particles::{NO_BODY, Particles};
use crate::pose::pose;

/// Parts of a body up to which all pairs are compared beforehand.
const MOST: usize = 64;

/// By how much two must be clear of each other in the rest shape to touch at all, as a share of how far the smaller one reaches.
const CLEAR: f32 = 0.01;

/// The pairs that overlap at rest. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct RestOverlaps {
    /// Numbers of body colliders, the lower first; sorted.
    pairs: Vec<[u32; 2]>,
    /// [Edits](Particles::edits) of the particles and the [revision](ContactFilter::revision) of how bodies touch when they were found; `None` when body
    /// colliders have changed since.
    seen: Option<[u64; 2]>,
    /// Body and number of each body collider; where those of the body at hand are at rest, and the boxes about them.
    body_colliders: Vec<(u32, u32)>,
    frames: Vec<(u32, Frame, (Vec3, Vec3))>,
    scratch: Kept<ManifoldScratch>,
}

impl RestOverlaps {
    /// Has them looked for anew.
    pub(super) fn reset(&mut self) {
        self.seen = None;
    }

    /// Whether two body colliders of one body overlap at rest, as far as that was found beforehand.
    #[inline]
    pub(super) fn has(&self, a: usize, b: usize) -> bool {
        !self.pairs.is_empty() && self.pairs.binary_search(&[a as u32, b as u32]).is_ok()
    }

    /// Finds them, if anything has changed.
    pub(super) fn update(
        &mut self,
        body_colliders: &[BodyCollider],
        groups: &BodyGroups,
        particles: &Particles,
        filter: &ContactFilter,
    ) {
        let now = [particles.edits(), filter.revision()];
        if self.seen.replace(now) == Some(now) {
            return;
        }
        self.pairs.clear();
        self.body_colliders.clear();
        if particles.rest.is_empty() {
            return;
        }
        for (number, (solid, part)) in body_colliders.iter().zip(&groups.parts).enumerate() {
            // A row may be gone.
            let first = solid.rows.first().and_then(|&row| particles.body.get(row as usize));
            let body = first.copied().unwrap_or(NO_BODY);
            if part.sound && filter.body(body).with_itself {
                self.body_colliders.push((body, number as u32));
            }
        }
        self.body_colliders.sort_unstable();
        let all = core::mem::take(&mut self.body_colliders);
        for own in all.chunk_by(|one, other| one.0 == other.0) {
            if (2..=MOST).contains(&own.len()) {
                self.compare(own, body_colliders, groups, particles);
            }
        }
        self.body_colliders = all;
        self.pairs.sort_unstable();
    }

    /// Compares the body colliders of one body with each other.
    fn compare(
        &mut self,
        own: &[(u32, u32)],
        body_colliders: &[BodyCollider],
        groups: &BodyGroups,
        particles: &Particles,
    ) {
        let Self { frames, pairs, scratch, .. } = self;
        frames.clear();
        for &(_, number) in own {
            let solid = &body_colliders[number as usize];
            let points = solid.rows.iter().zip(&*solid.rest);
            let points = points.map(|(&row, &rest)| (particles.rest[row as usize], rest, 1.0));
            // Without a place at rest there is no frame either.
            if let Some(contacts) = pose(points, Quat::IDENTITY) {
                let frame = Frame::new(contacts.translation, contacts.rotation);
                frames.push((number, frame, solid.shape.bounds_in(&frame)));
            }
        }
        for (i, &(a, frame_a, bounds_a)) in frames.iter().enumerate() {
            for &(b, frame_b, bounds_b) in &frames[i + 1..] {
                let [one, other] = [a, b].map(|number| number as usize);
                let apart =
                    bounds_a.0.cmpgt(bounds_b.1).any() || bounds_b.0.cmpgt(bounds_a.1).any();
                if apart || groups.share_a_row(one, other) {
                    continue;
                }
                let (shape, with) = (&body_colliders[one].shape, &body_colliders[other].shape);
                let clear = CLEAR * groups.parts[one].reach.min(groups.parts[other].reach);
                let (here, mut overlap) = (frame_a.from_within(&frame_b), false);
                collide(shape, with, &here, clear, &mut scratch.0, &mut |manifold| {
                    overlap |= manifold.points().iter().any(|point| point.distance < clear);
                });
                if overlap {
                    pairs.push([a.min(b), a.max(b)]);
                }
            }
        }
    }
}
