//! Timing. The contenders run the same ticks in small portions, one after the other, so that other load on the machine affects them equally. The CPU time of
//! the whole process, user and system, is measured, and the median of the portions is reported.

use std::time::Instant;

use cpu_time::ProcessTime;
use sinew::glam::{Quat, Vec3};
use sinew::pose::{Pose, pose};
use sinew::{BodyCollider, Distance, Simulation};

use crate::row::{Row, Stretch, Unit};

/// Duration of a tick, s.
pub const TICK: f32 = 1.0 / 60.0;

/// Ticks after which the quality is measured: 4 s, when a released body has swung to and fro.
pub const TICKS: usize = 240;

/// Ticks before timing starts: the solver's plan is built and caches are warm.
const WARM: usize = 4;

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Number of timed portions, at least 1; the median is reported.
    pub rounds: usize,
    /// Whether only a tenth of the ticks are run, to try the program out. Figures are rough, and the quality is that after 0.4 s.
    pub quick: bool,
    /// Whether user scenes run with the default threads of an app and are timed by the wall clock.
    pub threads: bool,
    /// Whether the other engines run as well.
    pub peers: bool,
}

/// A simulation of some engine that can run a scene.
pub trait World {
    /// Runs one tick.
    fn tick(&mut self);

    /// Present stretch of its constraints; `None` if there is nothing that can stretch.
    fn stretch(&self) -> Option<Stretch>;

    /// The colliding cubes in it; empty for scenes whose motion at rest is not measured.
    fn cubes(&self) -> Vec<Cube> {
        Vec::new()
    }

    /// Velocities of the cubes, m/s, or of other bodies where an implementation overrides it.
    fn speeds(&self) -> Vec<Vec3> {
        self.cubes().iter().map(|cube| cube.velocity).collect()
    }
}

/// A colliding cube of 1 m.
#[derive(Clone, Copy, Debug)]
pub struct Cube {
    /// Pose of the cube in the world; its origin is its centre.
    pub pose: Pose,
    /// Velocity of its centre, m/s.
    pub velocity: Vec3,
}

/// The contenders of a scene.
pub struct Race {
    /// Sinew.
    pub ours: Option<Box<dyn World>>,
    /// The naive reference.
    pub naive: Option<Box<dyn World>>,
    /// Another engine.
    pub peer: Option<Box<dyn World>>,
    /// The most ticks that are timed, for scenes with long ticks. Sinew still runs to the end where its quality is measured.
    pub most: usize,
}

/// Sinew itself.
pub struct Ours(pub Simulation);

impl World for Ours {
    fn tick(&mut self) {
        let done = self.0.step(TICK).is_ok();
        debug_assert!(done, "a sixtieth of a second can be stepped");
    }

    fn stretch(&self) -> Option<Stretch> {
        stretch_of(self.0.distances(), |i| self.0.particles.position(i))
    }

    fn cubes(&self) -> Vec<Cube> {
        let particles = &self.0.particles;
        let cube = |solid: &BodyCollider| {
            let rows = || solid.rows.iter().map(|&row| row as usize);
            let points = rows().zip(&*solid.rest);
            let points = points.map(|(i, &rest)| (particles.position(i), rest, particles.mass(i)));
            let velocity = rows().map(|i| particles.velocity(i)).sum::<Vec3>();
            let velocity = velocity / solid.rows.len() as f32;
            Some(Cube { pose: pose(points, Quat::IDENTITY)?, velocity })
        };
        self.0.body_colliders().iter().filter_map(cube).collect()
    }
}

/// Stretch of the hard ones among some distances; soft ones are meant to yield. `None` if there are none.
pub fn stretch_of(
    distances: &[Distance],
    position: impl Fn(usize) -> sinew::glam::Vec3,
) -> Option<Stretch> {
    let mut hard = distances.iter().filter(|d| d.softness.is_hard() && d.rest > 0.0).peekable();
    hard.peek()?;
    Some(Stretch::of(hard, position))
}

/// Duration of a portion, s per tick.
#[derive(Clone, Copy, Debug)]
pub struct Took {
    /// CPU time.
    pub cpu: f64,
    /// Wall-clock time.
    pub wall: f64,
}

/// Times `work`, which consists of `count` items; returns seconds per item.
pub fn time(count: usize, mut work: impl FnMut()) -> Took {
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    work();
    let count = count.max(1) as f64;
    Took { cpu: cpu.elapsed().as_secs_f64() / count, wall: wall.elapsed().as_secs_f64() / count }
}

/// Mean of the squares of speeds, m²/s².
pub fn mean_square(speeds: &[Vec3]) -> f64 {
    let squares = speeds.iter().map(|speed| f64::from(speed.length_squared()));
    squares.sum::<f64>() / speeds.len().max(1) as f64
}

/// Median; NaN if there are no times.
pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Race {
    /// Sinew and the naive reference.
    pub fn between(ours: impl World + 'static, naive: impl World + 'static) -> Self {
        Self { naive: Some(Box::new(naive)), ..Self::alone(ours) }
    }

    /// Sinew alone.
    pub fn alone(ours: impl World + 'static) -> Self {
        Self { ours: Some(Box::new(ours)), naive: None, peer: None, most: TICKS }
    }

    /// Adds another engine, if there is one.
    pub fn against(self, peer: Option<Box<dyn World>>) -> Self {
        Self { peer, ..self }
    }

    /// Limits the number of timed ticks.
    pub fn short(self, most: usize) -> Self {
        Self { most, ..self }
    }

    /// Runs the race and fills in the row. `count` is the number of the row's units in a tick.
    pub fn run(self, effort: &Effort, count: usize, row: Row) -> Row {
        let Self { ours, naive, peer, most } = self;
        let mut contenders = [ours, naive, peer];
        let all = if effort.quick { TICKS / 10 } else { TICKS };
        let timed = most.min(all).saturating_sub(WARM).max(1);
        let rounds = effort.rounds.clamp(1, timed);
        let portion = timed / rounds;
        let mut times: [Vec<f64>; 3] = Default::default();
        for world in contenders.iter_mut().filter_map(|slot| slot.as_mut()) {
            (0..WARM).for_each(|_| world.tick());
        }
        for _ in 0..rounds {
            for (slot, times) in contenders.iter_mut().zip(&mut times) {
                if let Some(world) = slot {
                    let took = time(portion, || (0..portion).for_each(|_| world.tick()));
                    times.push(if row.unit == Unit::WallTick { took.wall } else { took.cpu });
                }
            }
        }
        let so_far = WARM + rounds * portion;
        let [ours, naive, peer] = times
            .map(|times| (!times.is_empty()).then(|| median(times) * 1e9 / count.max(1) as f64));
        // In scenes with few timed ticks only Sinew runs on to the end for its quality, since the slow references would take minutes; and a world without a
        // stretch does not run on at all.
        let judged = |number, world: &mut Box<dyn World>| {
            world.stretch()?;
            (number == 0 || most >= all).then(|| (so_far..all).for_each(|_| world.tick()))?;
            world.stretch()
        };
        let mut numbered = contenders.into_iter().enumerate();
        let [stretch, naive_stretch, peer_stretch] = [(); 3].map(|()| {
            let (number, mut slot) = numbered.next()?;
            judged(number, slot.as_mut()?)
        });
        Row { ours, naive, peer, stretch, naive_stretch, peer_stretch, ..row }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_one() {
        assert_eq!(median(vec![3.0, 1.0, 9.0]), 3.0);
        assert!(median(Vec::new()).is_nan());
    }

    #[test]
    fn speeds_are_judged_by_the_mean_of_their_squares() {
        assert_eq!(mean_square(&[3.0, 4.0].map(|v| Vec3::X * v)), 12.5);
        assert_eq!(mean_square(&[]), 0.0);
    }
}
