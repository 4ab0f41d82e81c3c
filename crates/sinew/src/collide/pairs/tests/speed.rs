//! What it costs.

use std::time::Instant;

use super::super::grid::Search;
use super::heap::heap;
use super::{Pairs, SUBSTEPS, World};
use crate::lanes::{InstructionSet, with};

const DT: f32 = 1.0 / 60.0;

#[test]
#[ignore = "a measurement: run it alone, in release"]
fn a_dense_heap_is_timed() {
    for set in [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::Avx2] {
        let mut world: World = heap(16_384, 24, 0.5);
        world.pairs.instructions = set;
        for _ in 0..90 {
            world.step(DT);
        }
        let count = world.particles.len() as f64;
        let (mut finding, mut solving) = (f64::MAX, f64::MAX);
        world.looks = 0;
        for _ in 0..30 {
            let begin = Instant::now();
            world.find(DT);
            finding = finding.min(begin.elapsed().as_secs_f64());
            world.spent = 0.0;
            world.step(DT);
            solving = solving.min(world.spent);
        }
        let pairs = world.pairs.near.pairs.len() as f64 / count;
        let blocks = world.pairs.near.blocks.len() as f64 * 8.0 / count;
        println!(
            "{set:?}: find {:.1} ns a particle, {SUBSTEPS} substeps {:.1} ns; {pairs:.2} pairs a particle in {blocks:.2} lanes, {} looks",
            finding / count * 1e9,
            solving / count * 1e9,
            world.looks,
        );
    }
}

#[test]
#[ignore = "a measurement: run it alone, in release"]
fn the_parts_of_finding_are_timed() {
    let mut world: World = heap(16_384, 24, 0.5);
    for _ in 0..60 {
        world.step(DT);
    }
    let count = world.particles.len() as f64;
    let mut best = [f64::MAX; 8];
    for _ in 0..30 {
        let mut at = Instant::now();
        let mut lap = |k: usize, best: &mut [f64; 8]| {
            best[k] = best[k].min(at.elapsed().as_secs_f64());
            at = Instant::now();
        };
        let World { particles, contacts, pairs, .. } = &mut world;
        let Pairs { members, outrun, grid, near, .. } = pairs;
        members.take(particles, contacts, &[], &[], DT);
        lap(0, &mut best);
        members.place(particles, false);
        lap(1, &mut best);
        outrun.begin(members);
        lap(2, &mut best);
        grid.fill(members);
        lap(3, &mut best);
        near.clear();
        with(pairs.instructions, Search { grid, members, near });
        lap(4, &mut best);
        near.colour(members);
        lap(5, &mut best);
        let outran = outrun.is_outrun(members, particles);
        lap(6, &mut best);
        let swift = outrun.is_swift(members, particles);
        lap(7, &mut best);
        assert!(!(outran && swift));
    }
    let names = ["take", "place", "boxes", "sort", "search", "colour", "outrun", "swift"];
    for (name, best) in names.iter().zip(best) {
        println!("{name}: {:.1} ns a particle", best / count * 1e9);
    }
}
