//! The pairs are those of comparing all with all; and a timing.

use std::time::Instant;

use super::*;
use crate::collide::manifold::tests::Random;
use crate::lanes::InstructionSet;

fn naive(bounds: &[(Vec3, Vec3)]) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    for a in 0..bounds.len() {
        for b in a + 1..bounds.len() {
            let good = |i: usize| bounds[i].0.cmple(bounds[i].1).all();
            if good(a) && good(b) && overlap(&bounds[a], &bounds[b]) {
                pairs.push([a as u32, b as u32]);
            }
        }
    }
    pairs
}

fn around(centre: Vec3, half: Vec3) -> (Vec3, Vec3) {
    (centre - half, centre + half)
}

/// Unit boxes that touch, with a margin and a little noise.
fn pile(n: usize, random: &mut Random) -> Vec<(Vec3, Vec3)> {
    let at = |i: usize| Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32);
    (0..n * n * n).map(|i| around(at(i) + random.vector() * 1e-3, Vec3::splat(0.51))).collect()
}

#[test]
fn pairs_are_those_of_comparing_all_with_all() {
    let mut random = Random::new(11);
    let mut broad = Broad::default();
    let mut out = Vec::new();
    for round in 0..60 {
        let spread = [1.0, 10.0, 1e3, 1e6][round % 4];
        let sizes = [0.0, 1.0, 3.0][round % 3];
        let count = [5, 40, 400][round / 20];
        let mut bounds: Vec<_> = (0..count)
            .map(|_| {
                let scale = libm::exp2f(sizes * random.number());
                around(random.vector() * spread, random.vector().abs() * scale)
            })
            .collect();
        bounds.push((Vec3::NAN, Vec3::NAN));
        bounds.push((Vec3::new(-1.0, f32::NAN, 0.0), Vec3::ONE));
        bounds.push((Vec3::ONE, -Vec3::ONE));
        bounds.push((Vec3::splat(f32::NEG_INFINITY), Vec3::new(f32::INFINITY, 0.0, f32::INFINITY)));
        bounds.push(around(Vec3::ZERO, Vec3::new(1e4, 0.1, 1e4)));
        bounds.push((Vec3::splat(f32::INFINITY), Vec3::splat(f32::INFINITY)));
        broad.pairs(&bounds, &mut out);
        assert_eq!(out, naive(&bounds), "{round}");
        // Three groups and none; the list ends before the last boxes.
        let groups: Vec<u32> = (0..bounds.len() as u32 - 4)
            .map(|i| if i % 5 == 4 { NO_GROUP } else { i % 5 % 3 })
            .collect();
        let of = |i: u32| groups.get(i as usize).copied().unwrap_or(NO_GROUP);
        broad.pairs_of_groups(&bounds, &groups, &mut out);
        let mut wanted = naive(&bounds);
        wanted.retain(|&[a, b]| of(a) == NO_GROUP || of(a) != of(b));
        assert_eq!(out, wanted, "{round}");
    }
    broad.pairs(&[], &mut out);
    assert!(out.is_empty());
}

/// Clusters of `size` boxes, each box within `near` of the cluster's middle, with some invalid boxes, one unbounded and one large.
fn clusters(
    count: usize,
    size: usize,
    (spread, near): (f32, f32),
    random: &mut Random,
) -> Vec<(Vec3, Vec3)> {
    let mut bounds: Vec<_> = Vec::new();
    for _ in 0..count {
        let middle = random.vector() * spread;
        bounds.extend((0..size).map(|_| {
            let half = random.vector().abs() * libm::exp2f(random.number());
            around(middle + random.vector() * near, half)
        }));
    }
    bounds[3] = (Vec3::NAN, Vec3::NAN);
    bounds[20] = (Vec3::ONE, -Vec3::ONE);
    bounds[33] = around(Vec3::ZERO, Vec3::new(1e4, 0.1, 1e4));
    bounds.push((Vec3::splat(f32::NEG_INFINITY), Vec3::new(f32::INFINITY, 0.0, f32::INFINITY)));
    bounds
}

#[test]
fn a_search_in_clusters_has_the_same_pairs() {
    let mut random = Random::new(15);
    let (mut search, mut out) = (ClusterSearch::default(), Vec::new());
    for round in 0..60 {
        // Single boxes, pairs, bones of a ragdoll, and more than fit into one cluster.
        let size = [1, 2, 12, 50][round % 4];
        let spread = [1.0, 10.0, 1e3][round % 3];
        let bounds = clusters(200 / size, size, (spread, 1.0), &mut random);
        search.pairs(
            &bounds,
            |i| i < 200 && i % size != 0,
            |_| Vec3::ZERO,
            InstructionSet::best(),
            &mut out,
        );
        assert_eq!(out, naive(&bounds), "{round}");
    }
    search.pairs(&[], |_| true, |_| Vec3::ZERO, InstructionSet::best(), &mut out);
    assert!(out.is_empty());
}

/// Boxes move step by step with some noise; now and then one jumps, one becomes invalid, or all jump.
#[test]
fn candidates_that_last_have_the_same_pairs() {
    let mut random = Random::new(16);
    let (mut search, mut out) = (ClusterSearch::default(), Vec::new());
    for round in 0..12 {
        let size = [1, 12][round % 2];
        let mut bounds = clusters(200 / size, size, (4.0, 1.0), &mut random);
        let count = bounds.len();
        let ways: Vec<_> = (0..count).map(|_| 0.05 * random.vector()).collect();
        let joined = |i: usize| i + 1 < count && !i.is_multiple_of(size);
        for step in 0..40_usize {
            search.pairs(&bounds, joined, |i| ways[i], InstructionSet::best(), &mut out);
            assert_eq!(out, naive(&bounds), "{round} {step}");
            for (own, way) in bounds.iter_mut().zip(&ways) {
                let by = way + 0.002 * random.vector();
                *own = (own.0 + by, own.1 + by);
            }
            let number = 7 * step % (count - 1);
            match step % 8 {
                2 => bounds[number] = around(4.0 * random.vector(), Vec3::ONE),
                5 => bounds[number] = (Vec3::NAN, Vec3::NAN),
                7 if step > 30 => bounds.iter_mut().for_each(|own| {
                    let by = Vec3::splat(3.0);
                    *own = (own.0 + by, own.1 + by);
                }),
                _ => {}
            }
        }
    }
}

#[test]
fn a_moved_box_finds_all_that_it_overlaps_now() {
    let mut random = Random::new(12);
    let mut search = ClusterSearch::default();
    let (mut out, mut pairs) = (Vec::new(), Vec::new());
    for round in 0..60 {
        let size = [1, 12][round % 2];
        let spread = [1.0, 5.0, 100.0][round % 3];
        let mut bounds = clusters(200 / size, size, (spread, 1.0), &mut random);
        let count = bounds.len() as u32 - 1;
        let joined = |i: usize| i < count as usize && !i.is_multiple_of(size);
        search.pairs(&bounds, joined, |_| Vec3::ZERO, InstructionSet::best(), &mut out);
        let moved: Vec<u32> = (0..count).step_by(7).collect();
        for &number in &moved {
            let to = around(random.vector() * spread, random.vector().abs() * 2.0);
            bounds[number as usize] = if number == 14 { (Vec3::NAN, Vec3::NAN) } else { to };
        }
        // Now and then all are filled in again.
        let others = if round % 5 == 0 { &[][..] } else { &moved };
        if others.is_empty() {
            search.fill(&bounds);
        }
        let now = naive(&bounds);
        for &number in &moved {
            pairs.clear();
            search.query(number, &bounds, others, &mut pairs);
            pairs.sort_unstable();
            pairs.dedup();
            let own = now.iter().copied().filter(|pair| pair.contains(&number));
            assert_eq!(pairs, own.collect::<Vec<_>>(), "{round} {number}");
        }
    }
}

#[test]
fn far_from_zero_and_all_in_one_place_none_is_missed() {
    let mut random = Random::new(12);
    let mut broad = Broad::default();
    let (mut out, mut some) = (Vec::new(), 0);
    // 0.01 m at 1e6 m, where neighbouring numbers are 0.06 m apart; the same place for all; and no extent.
    for (at, spread, half) in
        [(1e6, 0.1, 0.01), (0.0, 0.0, 1.0), (5.0, 0.0, 0.0), (1e12, 1e5, 1e-3)]
    {
        let bounds: Vec<_> = (0..100)
            .map(|_| around(Vec3::splat(at) + random.vector() * spread, Vec3::splat(half)))
            .collect();
        broad.pairs(&bounds, &mut out);
        assert_eq!(out, naive(&bounds), "{at} {spread} {half}");
        some += usize::from(!out.is_empty());
    }
    assert_eq!(some, 4);
}

#[test]
fn a_pile_has_the_pairs_of_its_faces_edges_and_corners() {
    let mut random = Random::new(13);
    let bounds = pile(10, &mut random);
    let (mut broad, mut out) = (Broad::default(), Vec::new());
    broad.pairs(&bounds, &mut out);
    // 2700 by faces, 4860 by edges, 2916 by corners.
    assert_eq!(out.len(), 10476);
    assert_eq!(out, naive(&bounds));
}

#[test]
fn how_long_it_takes() {
    let mut random = Random::new(14);
    let floor = around(-Vec3::Y, Vec3::new(1e3, 0.5, 1e3));
    let endless = (Vec3::splat(f32::NEG_INFINITY), Vec3::new(f32::INFINITY, 0.0, f32::INFINITY));
    let mut shuffled = pile(10, &mut random);
    for i in 0..shuffled.len() {
        let j = (random.number().abs() * i as f32) as usize;
        shuffled.swap(i, j);
    }
    let scattered = |n: usize, random: &mut Random, spread: f32, sizes: f32| -> Vec<_> {
        (0..n)
            .map(|_| {
                let half = Vec3::splat(0.5 * libm::exp2f(sizes * random.number()));
                around(random.vector() * spread, half)
            })
            .collect()
    };
    let cases = [
        ("pile of 1000", pile(10, &mut random)),
        ("the same shuffled", shuffled),
        ("and a floor, and a half-space", [pile(10, &mut random), vec![floor, endless]].concat()),
        ("pile of 10648", pile(22, &mut random)),
        ("10000 far apart", scattered(10_000, &mut random, 1e3, 0.0)),
        ("10000 of sizes 1 to 64", scattered(10_000, &mut random, 60.0, 3.0)),
    ];
    let (mut broad, mut out) = (Broad::default(), Vec::new());
    for (name, bounds) in cases {
        let mut best = f64::INFINITY;
        for _ in 0..20 {
            let start = Instant::now();
            broad.pairs(&bounds, &mut out);
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{name}: {:.1} µs, {} pairs", best * 1e6, out.len());
    }
}
