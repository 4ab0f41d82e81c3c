//! How long a constraint takes, by the scalar kernel and by the wide ones.

use std::hint::black_box;
use std::time::Instant;

use super::*;

const SIDE: usize = 128;

/// The bends of a cloth of 128 by 128 particles: four rows for each inner edge, in colours, sorted.
fn cloth_edges() -> Vec<Vec<[u32; 4]>> {
    let at = |c: usize, r: usize| (r * SIDE + c) as u32;
    let mut stencils = Vec::new();
    for r in 0..SIDE - 1 {
        for c in 0..SIDE - 1 {
            let [p, q, s, t] = [at(c, r), at(c + 1, r), at(c, r + 1), at(c + 1, r + 1)];
            stencils.push([q, s, p, t]);
            if c + 2 < SIDE {
                stencils.push([q, t, s, at(c + 2, r)]);
            }
            if r + 2 < SIDE {
                stencils.push([s, t, q, at(c, r + 2)]);
            }
        }
    }
    let mut used = vec![0_u64; SIDE * SIDE];
    let mut colours = vec![Vec::new(); 64];
    for rows in stencils {
        let taken = rows.iter().fold(0, |taken, &row| taken | used[row as usize]);
        let colour = (!taken).trailing_zeros();
        rows.iter().for_each(|&row| used[row as usize] |= 1 << colour);
        colours[colour as usize].push(rows);
    }
    colours.retain(|colour| !colour.is_empty());
    colours
        .iter_mut()
        .for_each(|colour| colour.sort_unstable_by_key(|rows| *rows.iter().min().unwrap()));
    colours
}

/// Nanoseconds for one constraint, the best of some sweeps.
fn best(count: usize, mut sweep: impl FnMut()) -> f64 {
    let mut best = f64::MAX;
    for _ in 0..40 {
        let began = Instant::now();
        sweep();
        best = best.min(began.elapsed().as_secs_f64());
    }
    best * 1e9 / count as f64
}

fn compare(name: &str, groups: &[Group]) {
    let mut random = Random::new(3);
    let mut now = Vec::new();
    for i in 0..SIDE * SIDE {
        let place = Vec3::new((i % SIDE) as f32, (i / SIDE) as f32, 0.0) + random.vector() * 0.1;
        now.push(place.extend(1.0));
    }
    let (start, origin, radius) = (now.clone(), vec![Vec3::ZERO; now.len()], vec![0.0; now.len()]);
    let count_of = |group: &Group| match group {
        Group::Laws(laws) => laws.len(),
        Group::Distances(distances) => distances.len(),
    };
    let count = groups.iter().map(count_of).sum();
    let mut all = Laws::default();
    let which: Vec<_> = groups
        .iter()
        .map(|group| match group {
            Group::Laws(laws) => all.add(laws, false).unwrap(),
            Group::Distances(distances) => all.add_distances(distances, false),
        })
        .collect();
    let mut sums: Vec<_> = groups.iter().map(|group| vec![0.0; count_of(group)]).collect();
    let manner = Manner { pace: PACE, direction: Direction::Nearest };
    let mut local = Local::default();
    let mut position = now.clone();
    let scalar = best(count, || {
        let mut places = Places {
            first: 0,
            position: &mut position,
            start: &start,
            origin: &origin,
            radius: &radius,
            velocity: &mut [],
        };
        for (group, sums) in groups.iter().zip(&mut sums) {
            for (i, sum) in sums.iter_mut().enumerate() {
                black_box(match group {
                    Group::Laws(laws) => {
                        project_constraint(&mut places, &laws[i], manner, sum, &mut local)
                    }
                    Group::Distances(d) => project_distance(&mut places, &d[i], PACE, sum),
                });
            }
        }
    });
    let wide = SETS.map(|set| {
        position.copy_from_slice(&now);
        sums.iter_mut().for_each(|sums| sums.fill(0.0));
        best(count, || {
            for (which, sums) in which.iter().zip(&mut sums) {
                let places = Places {
                    first: 0,
                    position: &mut position,
                    start: &start,
                    origin: &origin,
                    radius: &radius,
                    velocity: &mut [],
                };
                black_box(with(set, Sweep { laws: &all, which, places, sums, pace: PACE }));
            }
        })
    });
    let [arrays, quads, eight] = wide;
    println!(
        "{name:28} {count:6} in {:2} colours: scalar {scalar:6.1} ns; arrays {arrays:6.1}, quads {quads:6.1}, avx2 {eight:6.2} ns",
        groups.len()
    );
}

#[test]
#[ignore = "a measurement: run it alone, in release"]
fn a_sweep_of_each_kernel_is_timed() {
    let colours = cloth_edges();
    for (name, soft) in [
        ("hard", Softness::Hard),
        ("compliant", Softness::compliant(1e-4)),
        ("damped", Softness::spring(1e4, 1.0)),
        ("frequency", Softness::frequency(20.0, 0.1)),
        ("share", Softness::Share(0.3)),
    ] {
        for (law_name, n, law, _) in every() {
            let group = |rows: &Vec<[u32; 4]>| {
                let law = |(k, rows): (usize, &[u32; 4])| {
                    Constraint::new(rows[..n].iter().copied(), law(k, soft))
                };
                Group::Laws(rows.iter().enumerate().map(law).collect())
            };
            if n <= 4 {
                let groups: Vec<_> = colours.iter().map(group).collect();
                compare(&format!("{law_name}, {name}"), &groups);
            }
        }
        for bound in [Bound::Equal, Bound::AtMost] {
            let group = |rows: &Vec<[u32; 4]>| {
                let d = |rows: &[u32; 4]| {
                    Distance::new(rows[0], rows[2], 1.0).with_softness(soft).with_bound(bound)
                };
                Group::Distances(rows.iter().map(d).collect())
            };
            let groups: Vec<_> = colours.iter().map(group).collect();
            compare(&format!("distance, {name}, {bound:?}"), &groups);
        }
    }
}

#[test]
#[ignore = "a measurement: run it alone, in release"]
fn a_sweep_of_a_balloon_is_timed() {
    // A sheet of 2 * 31 * 31 triangles; that it is not closed does not matter to the time.
    const ROW: usize = 32;
    let mut random = Random::new(4);
    let places: Vec<_> = (0..ROW * ROW)
        .map(|i| Vec3::new((i % ROW) as f32, (i / ROW) as f32, 0.0) + random.vector() * 0.3)
        .collect();
    let mut triangles = Vec::new();
    for i in (0..ROW * (ROW - 1)).filter(|i| i % ROW != ROW - 1) {
        let [a, b, c, d] = [i, i + 1, i + ROW, i + ROW + 1].map(|i| i as u32);
        triangles.extend([[a, b, c], [b, d, c]]);
    }
    let laws = [
        ("volume", Law::Volume(crate::constraints::Volume::of(triangles.clone(), &places))),
        ("patch", Law::Patch(crate::constraints::Patch::of(triangles.clone(), &places))),
    ];
    for (name, law) in laws {
        let mut state = State::at(&[], 0, &mut random);
        state.now = places.iter().map(|p| p.extend(1.0)).collect();
        state.start.clone_from(&state.now);
        let origin = vec![Vec3::ZERO; state.now.len()];
        let radius = vec![0.0; state.now.len()];
        let constraint = Constraint::new(0..(ROW * ROW) as u32, law);
        let manner = Manner { pace: PACE, direction: Direction::Nearest };
        let mut local = Local::default();
        let each = best(triangles.len(), || {
            let mut places = Places {
                first: 0,
                position: &mut state.now,
                start: &state.start,
                origin: &origin,
                radius: &radius,
                velocity: &mut [],
            };
            black_box(project_constraint(&mut places, &constraint, manner, &mut 0.0, &mut local));
        });
        println!("{name}: {each:.1} ns a triangle");
    }
}
