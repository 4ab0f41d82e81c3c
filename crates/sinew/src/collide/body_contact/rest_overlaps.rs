//! Parts of one body that overlap in its rest shape, and so never collide: a thigh and the pelvis that it goes into, two bones away. The pairs are computed
//! when body colliders, bodies or rest positions have changed, for bodies that collide with themselves. Bodies with very many parts are ropes, whose segments
//! are compared when they come near each other ([`overlaps_at_rest`](BodyCollider::overlaps_at_rest)).

use glam::{Quat, Vec3};

use super::super::body_collider::BodyCollider;
use super::super::filter::ContactFilter;
use super::super::frame::Frame;
use super::super::manifold::{ManifoldScratch, collide};
use super::groups::BodyGroups;
use crate::not_cloned::NotCloned;
use crate::particles::{NO_BODY, Particles};
use crate::pose::pose;

/// Number of parts up to which all pairs of a body are compared in advance.
const MAX_PARTS: usize = 64;

/// Clearance that two parts need in the rest shape to collide at all, as a share of the smaller one's reach.
const CLEARANCE: f32 = 0.01;

/// The pairs that overlap at rest. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct RestOverlaps {
    /// Pairs of body colliders, the lower number first; sorted.
    pairs: Vec<[u32; 2]>,
    /// [Edits](Particles::edits) of the particles and [revision](ContactFilter::revision) of the contact filter for which they were computed; `None` when
    /// body colliders have changed since.
    seen: Option<[u64; 2]>,
    /// Body and number of each body collider; rest frames of the parts of one body, and their bounds.
    body_colliders: Vec<(u32, u32)>,
    frames: Vec<(u32, Frame, (Vec3, Vec3))>,
    scratch: NotCloned<ManifoldScratch>,
}

impl RestOverlaps {
    /// Makes the next update compute them again.
    pub(super) fn reset(&mut self) {
        self.seen = None;
    }

    /// Whether two body colliders of one body overlap at rest, as far as that was computed in advance.
    #[inline]
    pub(super) fn has(&self, a: usize, b: usize) -> bool {
        !self.pairs.is_empty() && self.pairs.binary_search(&[a as u32, b as u32]).is_ok()
    }

    /// Computes the pairs if anything has changed.
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
            // The row may not exist any more.
            let first = solid.rows.first().and_then(|&row| particles.body.get(row as usize));
            let body = first.copied().unwrap_or(NO_BODY);
            if part.sound && filter.body(body).with_itself {
                self.body_colliders.push((body, number as u32));
            }
        }
        self.body_colliders.sort_unstable();
        let all = core::mem::take(&mut self.body_colliders);
        for own in all.chunk_by(|one, other| one.0 == other.0) {
            if (2..=MAX_PARTS).contains(&own.len()) {
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
            // Particles without a rest position give no frame.
            if let Some(rest_pose) = pose(points, Quat::IDENTITY) {
                let frame = Frame::new(rest_pose.translation, rest_pose.rotation);
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
                let clear = CLEARANCE * groups.parts[one].reach.min(groups.parts[other].reach);
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
