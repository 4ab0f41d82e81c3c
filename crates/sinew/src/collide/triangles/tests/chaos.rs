//! Triangles that are each thrown somewhere else in one substep: far more contacts than Gauss–Seidel can resolve.

use glam::{DVec3, Vec3};

use super::super::Triangles;
use super::super::crossing::Four;
use super::super::participants::EDGES;
use super::{ALONE, colliding};
use crate::collide::ContactFilter;
use crate::collide::nearby::Nearby;
use crate::particles::{ParticleSeed, Particles};
use crate::test_random::Random;

/// A cubic lattice of 1 m with `side` triangles a side, each a body, displaced by up to `way` metres and distorted by up to a quarter of that.
fn thrown(side: usize, way: f32, random: &mut Random) -> (Particles, Vec<[u32; 3]>) {
    let (mut particles, mut surfaces) = (Particles::default(), Vec::new());
    for k in 0..side * side * side {
        let cell = [k % side, k / side % side, k / side / side].map(|i| i as f32);
        let first = particles.len() as u32;
        for _ in 0..3 {
            // About half a metre across, so that none begins in another.
            let at = Vec3::from(cell) + random.vector() * 0.28;
            let mass = libm::exp2f(3.0 * random.number());
            let seed = ParticleSeed::at(at).with_mass(mass).with_radius(0.02);
            let row = particles.push(seed).unwrap() as usize;
            particles.set_body(row, Some(k as u32));
        }
        surfaces.push([first, first + 1, first + 2]);
    }
    for corners in &surfaces {
        let far = random.vector() * way;
        for &row in corners {
            let own = random.vector() * (0.25 * way);
            particles.displace(row as usize, far + own);
        }
    }
    (particles, surfaces)
}

fn four(particles: &Particles, rows: [u32; 4], edges: bool) -> Four {
    let zero = particles.origin[rows[0] as usize];
    let at = |row: u32, local: glam::Vec4| {
        (particles.origin[row as usize] - zero).as_dvec3() + local.truncate().as_dvec3()
    };
    Four {
        from: rows.map(|row| at(row, particles.start[row as usize])),
        to: rows.map(|row| at(row, particles.position[row as usize])),
        edges,
    }
}

/// Number of crossings, all against all.
fn passing(particles: &Particles, surfaces: &[[u32; 3]]) -> usize {
    let mut count = 0;
    for (i, one) in surfaces.iter().enumerate() {
        for (j, other) in surfaces.iter().enumerate() {
            if i == j {
                continue;
            }
            for &corner in one {
                let [a, b, c] = *other;
                let four = four(particles, [corner, a, b, c], false);
                count += usize::from(four.crossing().is_some());
            }
            for [a, b] in EDGES.iter().filter(|_| i < j) {
                for [c, d] in EDGES {
                    let four = four(particles, [one[*a], one[*b], other[c], other[d]], true);
                    count += usize::from(four.crossing().is_some());
                }
            }
        }
    }
    count
}

#[test]
fn whatever_is_thrown_through_each_other_in_a_substep_has_not_passed_when_it_ends() {
    let mut random = Random::new(3);
    let (mut rounds, mut sorted_out) = (0, 0);
    for round in 0..24 {
        let way = [0.6, 1.0, 3.0, 30.0][round % 4];
        let (mut particles, surfaces) = thrown(4, way, &mut random);
        let contacts = vec![colliding(false); surfaces.len()];
        let moment = |particles: &Particles| -> DVec3 {
            (0..particles.len())
                .map(|i| {
                    let way = (particles.position[i] - particles.start[i]).truncate();
                    way.as_dvec3() * f64::from(particles.mass(i))
                })
                .sum()
        };
        let (before, began) = (passing(&particles, &surfaces), moment(&particles));
        let (filter, nearby) = (ContactFilter::untied(&contacts), Nearby::everywhere(&contacts));
        let mut triangles = Triangles::default();
        // All exceed the margins of a list built at the start positions.
        let (ends, start) = (particles.position.clone(), particles.start.clone());
        particles.position = start;
        triangles.broad_phase(&particles, &surfaces, (&filter, &nearby), &[], 1.0 / 60.0, ALONE);
        particles.position = ends;
        triangles.project(&mut particles, &filter, ALONE);
        let after = passing(&particles, &surfaces);
        println!(
            "{way} m: {before} passing, {after} after {} looks, {} rounds",
            triangles.rebuilds, triangles.rounds
        );
        assert_eq!(after, 0, "{way} m, {before} before");
        // A contact that was corrected again, after the neighbours of a displaced member were tested again, was counted as another one.
        let mut members: Vec<_> = triangles.hits.iter().map(|hit| hit.members).collect();
        let count = members.len();
        members.sort_unstable();
        members.dedup();
        assert_eq!(members.len(), count, "contacts, each once");
        let off = (moment(&particles) - began).length();
        assert!(off < 1e-5 * f64::from(way) * surfaces.len() as f64, "{off} kg·m");
        rounds += triangles.rounds;
        sorted_out += before;
    }
    assert!(sorted_out > 1000);
    println!("{sorted_out} in all, {rounds} rounds of zones");
    assert!(rounds > 0, "there was something for zones to do");
}
