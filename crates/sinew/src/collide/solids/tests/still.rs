//! What stands still is left out by kernels of their own: they say what the others say of something that stands still.

use glam::Vec4;

use super::super::bodies::{Bodies, CENTRE, ROTATION, SHIFT, SPIN, STEP};
use super::super::contact::Press;
use super::super::found::set;
use super::super::hold::{Expect, Hold};
use super::super::pack::Pack;
use super::*;
use crate::constraints::checks::Random;
use crate::lanes::{InstructionSet, LANES, with};

/// Eight solids that press on one that stands in row 8, in so many points; row 9 is nothing.
fn eight_on_one(points: usize, random: &mut Random) -> (Pack, Bodies) {
    let mut bodies = Bodies::default();
    bodies.resize(LANES + 2);
    let mut pack = Pack::empty(9, false, 1);
    for lane in 0..LANES {
        let some = |random: &mut Random, much: f32| random.vector() * much;
        let row = &mut bodies[lane];
        row[SHIFT].w = 2.0 + random.number();
        // Inverse inertia: along, and across.
        (row[2], row[3]) = ((Vec3::splat(4.0) + random.vector()).extend(0.0), Vec4::ZERO);
        row[CENTRE] = some(random, 2.0).extend(0.0);
        (row[STEP], row[SPIN]) = (some(random, 1e-3).extend(0.0), some(random, 1e-3).extend(0.0));
        let q = Vec4::new(random.number(), random.number(), random.number(), 1.5);
        row[ROTATION] = q / q.length();
        let frame = bodies.frame(lane, Vec3::ZERO);
        (pack.a[lane], pack.b[lane], pack.number[lane]) = (lane as u32, 8, lane as u32);
        let (normal, offset) = (some(random, 1.0).normalize(), some(random, 1.0));
        set(&mut pack.normal, lane, normal);
        set(&mut pack.offset, lane, offset);
        for i in 0..points {
            let on_a = some(random, 0.5);
            // From below the surface to above it.
            let on_b = frame.point(on_a) - offset + normal * (2e-3 * random.number() + 1e-3);
            set(&mut pack.on_a[i], lane, on_a);
            set(&mut pack.on_b[i], lane, on_b);
            pack.missing[i][lane] = 0.0;
        }
        set(&mut pack.up, lane, normal);
        set(&mut pack.arm, lane, some(random, 0.3));
        pack.radius[lane] = random.number().max(0.0) * 0.2;
        pack.allowed[lane] = random.number().max(0.0) * 1e-3;
        (pack.friction[lane], pack.own[lane], pack.blunt[lane]) = (0.5, 1.0, 1e-2);
        (pack.stiff[lane], pack.bent[lane], pack.wear[lane]) = (10.0, 10.0, 1.0);
        for late in &mut pack.late {
            late[lane] = 1e-4 * random.number();
        }
    }
    pack.kept = true;
    (pack, bodies)
}

/// Holds, presses and holds; and what comes of it. Numbers, for which sign a zero has does not matter.
fn pressed(pack: &Pack, bodies: &Bodies, still: bool) -> (Vec<[Vec4; 8]>, Vec<[f32; LANES]>) {
    let (mut packs, mut bodies) = ([Pack { still, ..pack.clone() }], bodies.clone());
    let set = InstructionSet::Scalar;
    with(set, Expect { packs: &packs, bodies: &mut bodies });
    with(set, Hold { packs: &mut packs, after: false, most: 1e-3, bodies: &mut bodies });
    let (h, recover, pop) = (1.0 / 600.0, 1e-2, 1e-4);
    with(
        set,
        Press { packs: &mut packs, bodies: &mut bodies, h, recover, pops: [pop; 2], sweep: 0 },
    );
    with(set, Hold { packs: &mut packs, after: true, most: 1e-3, bodies: &mut bodies });
    let [pack] = packs;
    let rows = bodies.rows[..LANES].iter().map(|row| row.0).collect();
    let mut columns = [pack.force, pack.approach, pack.late].concat();
    columns.extend([pack.up, pack.arm].concat());
    columns.extend([pack.strain, pack.gap, pack.radius, pack.sum, pack.used, pack.allowed]);
    columns.push([pack.stuck as f32, pack.popped as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    (rows, columns)
}

#[test]
fn what_stands_still_is_to_kernels_that_leave_it_out_what_it_is_to_others() {
    let mut random = Random::new(21);
    for round in 0..100 {
        let (pack, bodies) = eight_on_one(1 + round % 4, &mut random);
        let (asked, left_out) = (pressed(&pack, &bodies, false), pressed(&pack, &bodies, true));
        assert_eq!(asked.0, left_out.0, "{round}");
        assert_eq!(asked.1, left_out.1, "{round}");
        // Something was pressed.
        let sums = asked.1[asked.1.len() - 4];
        assert!(sums.iter().any(|&sum| sum > 0.0), "{sums:?}");
    }
}
