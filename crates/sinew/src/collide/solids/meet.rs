//! Two that may come to touch: what is remembered of where they do, as long as that holds, and otherwise what is found afresh.

use super::super::manifold::{Scratch, collide, is_of_triangles};
use super::super::{Frame, Shape};
use super::found::Found;
use super::memory::{Grasp, Key, Memory, Remembered, SLACK};

/// A solid, and another one or what stands.
pub(super) struct Meet<'a> {
    pub(super) key: Key,
    pub(super) shapes: [&'a Shape; 2],
    /// How far the first one reaches, and the smaller one of the two, metres.
    pub(super) size: (f32, f32),
    /// How near they may come in the step, metres.
    pub(super) reach: f32,
}

impl Meet<'_> {
    /// Adds their manifolds to what is remembered, and those that may come to press to what was found, each as `meeting` has it.
    pub(super) fn find(
        self,
        [a, b]: [&Frame; 2],
        meeting: Found,
        memory: &mut Memory,
        found: &mut Vec<Found>,
        scratch: &mut Scratch,
    ) {
        let Self { key, shapes, size: (size, smaller), reach } = self;
        let here = a.from_within(b);
        let marks = shapes.map(Shape::mark);
        let known = memory.recall(&key).filter(|known| known.marks == marks).copied();
        let strain = known.and_then(|known| known.strain(&here, size, meeting.stiff, reach));
        if let (Some(mut known), Some(strain)) = (known, strain) {
            if known.is_near(&here, reach) {
                found.push(Found { strain, memory: memory.now.len() as u32, ..meeting });
            } else {
                known.grasp = Grasp::default();
            }
            memory.now.push(known);
            return;
        }
        let (first, far) = (memory.now.len(), reach + SLACK * smaller);
        collide(shapes[0], shapes[1], &here, far, scratch, &mut |manifold| {
            let (place, manifold) = (memory.now.len(), *manifold);
            let key = Key { nth: (place - first) as u32, ..key };
            let grasp = Grasp::default();
            let one = Remembered { key, marks, manifold, seen_from: here, reach: far, grasp };
            if one.is_near(&here, reach) {
                found.push(Found { memory: place as u32, ..meeting });
            }
            memory.learn(one, b.turn(manifold.normal));
        });
        // Also where it is one triangle today.
        if memory.now.len() > first && shapes.into_iter().any(is_of_triangles) {
            memory.now[first..].iter_mut().for_each(|one| one.reach = -1.0);
        }
    }
}
