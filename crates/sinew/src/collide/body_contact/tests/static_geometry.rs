//! Kernels for fixed geometry, which load no row of the second one, give the same results as the general ones.

use glam::Vec4;

use super::super::bodies::{Bodies, CENTRE, ROTATION, SHIFT, SPIN, STEP};
use super::super::friction::{predict_impulses, solve_all_friction};
use super::super::normal_solve::solve_normals;
use super::super::turn::set;
use super::super::wide_contact::WideContact;
use super::*;
use crate::constraints::checks::Random;
use crate::lanes::{InstructionSet, LANES};

/// Eight body colliders that press on a static one in row 8, in `points` points each; row 9 is the null row.
fn eight_on_one(points: usize, random: &mut Random) -> (WideContact, Bodies) {
    let mut bodies = Bodies::default();
    bodies.resize(LANES + 2, &[]);
    let mut wide = WideContact::empty(9, false, 1);
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
        (wide.a[lane], wide.b[lane], wide.number[lane]) = (lane as u32, 8, lane as u32);
        let (normal, offset) = (some(random, 1.0).normalize(), some(random, 1.0));
        set(&mut wide.normal, lane, normal);
        set(&mut wide.offset, lane, offset);
        for i in 0..points {
            let on_a = some(random, 0.5);
            // From below the surface to above it.
            let on_b = frame.point(on_a) - offset + normal * (2e-3 * random.number() + 1e-3);
            set(&mut wide.on_a[i], lane, on_a);
            set(&mut wide.on_b[i], lane, on_b);
            wide.missing[i][lane] = 0.0;
        }
        set(&mut wide.up, lane, normal);
        set(&mut wide.arm, lane, some(random, 0.3));
        wide.radius[lane] = random.number().max(0.0) * 0.2;
        wide.friction_limit[lane] = random.number().max(0.0) * 1e-3;
        (wide.friction[lane], wide.own[lane], wide.torsional_radius[lane]) = (0.5, 1.0, 1e-2);
        (wide.inverse_slip[lane], wide.inverse_turn[lane], wide.steepness[lane]) =
            (10.0, 10.0, 0.0);
        for accumulated_slip in &mut wide.accumulated_slip {
            accumulated_slip[lane] = 1e-4 * random.number();
        }
    }
    wide.kept = true;
    (wide, bodies)
}

/// Solves friction, normals and friction, and returns the rows and the state of the wide contact. As numbers: the sign of a zero does not matter.
fn pressed(
    wide: &WideContact,
    bodies: &Bodies,
    fixed: bool,
) -> (Vec<[Vec4; 8]>, Vec<[f32; LANES]>) {
    let (mut wide_contacts, mut bodies) = ([WideContact { fixed, ..wide.clone() }], bodies.clone());
    let set = InstructionSet::Scalar;
    predict_impulses(&wide_contacts, &mut bodies, set);
    solve_all_friction(&mut wide_contacts, false, 1e-3, &mut bodies, set);
    let (h, recover, max_depenetration) = (1.0 / 600.0, 1e-2, 1e-4);
    let limits = ([recover; 2], [max_depenetration; 2]);
    solve_normals(&mut wide_contacts, &mut bodies, h, limits.0, limits.1, 0, set);
    solve_all_friction(&mut wide_contacts, true, 1e-3, &mut bodies, set);
    let [wide] = wide_contacts;
    let rows = bodies.rows[..LANES].iter().map(|row| row.0).collect();
    let mut columns = [wide.force, wide.approach, wide.accumulated_slip].concat();
    columns.extend([wide.up, wide.arm].concat());
    columns.extend([
        wide.staleness,
        wide.radius,
        wide.sum,
        wide.friction_limit_used,
        wide.friction_limit,
    ]);
    let bits = [wide.sticking, wide.sliding, wide.depenetrated, wide.stale];
    let [sticking, sliding, depenetrated, stale] = bits.map(|bits| bits as f32);
    columns.push([sticking, sliding, depenetrated, stale, 0.0, 0.0, 0.0, 0.0]);
    (rows, columns)
}

#[test]
fn kernels_for_fixed_geometry_match_the_general_ones() {
    let mut random = Random::new(21);
    for round in 0..100 {
        let (wide, bodies) = eight_on_one(1 + round % 4, &mut random);
        let (general, left_out) = (pressed(&wide, &bodies, false), pressed(&wide, &bodies, true));
        assert_eq!(general.0, left_out.0, "{round}");
        assert_eq!(general.1, left_out.1, "{round}");
        // Some impulse is not zero.
        let sums = general.1[general.1.len() - 4];
        assert!(sums.iter().any(|&sum| sum > 0.0), "{sums:?}");
    }
}
