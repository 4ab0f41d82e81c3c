//! Any number of threads gives the same bits.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use bevy::prelude::*;
use bevy::tasks::{TaskPool, TaskPoolBuilder};
use bevy_sinew::SinewWorkers;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::Workers;

use crate::support::{app, hash, tick};

/// Ticks that are compared: 5 s.
const TICKS: u64 = 300;

/// Ticks between one hash and the next.
const STRIDE: u64 = 20;

/// A game's own task pool, and how often it was used.
#[derive(Debug)]
struct Own {
    pool: TaskPool,
    runs: AtomicUsize,
}

impl Own {
    fn of(threads: usize) -> Arc<Self> {
        let pool = TaskPoolBuilder::new().num_threads(threads).build();
        Arc::new(Self { pool, runs: AtomicUsize::new(0) })
    }
}

impl Workers for Own {
    fn run(&self, work: &(dyn Fn() + Sync)) {
        self.runs.fetch_add(1, Ordering::Relaxed);
        self.pool.scope(|scope| {
            (0..self.pool.thread_num()).for_each(|_| scope.spawn(async move { work() }));
        });
    }
}

/// Many bodies of all kinds, large enough that the solver splits its work.
fn crowd(app: &mut App) {
    let world = app.world_mut();
    world.spawn(Ground);
    world.spawn(Wind { pressure: Vec3::new(2.0, 0.0, 1.0), gusts: 0.5, ..default() });
    world.insert_resource(SolverConfig { substeps: 4, max_sweeps: 2, ..default() });
    for n in 0..8 {
        let at = |x: f32| Transform::from_xyz(x, 2.5, 1.5 * n as f32);
        let cloth = Cloth::grid(1.0, 1.0, 20 + n, 24).pinned(ClothPins::TopCorners);
        world.spawn((cloth, at(0.0)));
        world.spawn((Rope { slack: 0.2, pin_end: true, to: Vec3::X, ..default() }, at(2.0)));
        world.spawn((Ragdoll::default(), at(4.0)));
    }
}

/// The hashes of the crowd at every [`STRIDE`] ticks.
fn hashes(config: impl FnOnce(&mut App)) -> Vec<u64> {
    let mut app = app();
    crowd(&mut app);
    config(&mut app);
    let mut stride = |_| {
        tick(&mut app, STRIDE);
        hash(&mut app)
    };
    (0..TICKS / STRIDE).map(&mut stride).collect()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let alone = hashes(|app| app.world_mut().resource_mut::<SolverConfig>().threads = false);
    assert_eq!(hashes(|_| ()), alone, "as it comes");
    for threads in [1, 2, 3, 8] {
        let own = Own::of(threads);
        let lent: Arc<dyn Workers> = own.clone();
        let found = hashes(|app| {
            app.insert_resource(SinewWorkers(Some(lent)));
        });
        assert_eq!(found, alone, "{threads} threads");
        assert!(own.runs.load(Ordering::Relaxed) > 0, "{threads} threads were used");
    }
}

#[test]
fn threads_are_switched_off_and_on_while_time_runs() {
    let mut app = app();
    crowd(&mut app);
    let own = Own::of(2);
    let lent: Arc<dyn Workers> = own.clone();
    app.insert_resource(SinewWorkers(Some(lent)));
    tick(&mut app, 1);
    let runs = own.runs.load(Ordering::Relaxed);
    app.world_mut().resource_mut::<SolverConfig>().threads = false;
    tick(&mut app, 2);
    assert_eq!(own.runs.load(Ordering::Relaxed), runs, "the pool is not used");
    app.world_mut().resource_mut::<SolverConfig>().threads = true;
    tick(&mut app, 2);
    assert!(own.runs.load(Ordering::Relaxed) > runs, "and used again");
}
