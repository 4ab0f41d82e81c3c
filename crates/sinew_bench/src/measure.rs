//! Taking turns: contenders run the same ticks in small portions, one after the other, so that what else the machine does meets them alike.
//! The time that counts is that of the processor, user and system, of the whole process; the median of the portions is what is told.

use std::time::Instant;

use cpu_time::ProcessTime;
use sinew::glam::{Quat, Vec3};
use sinew::pose::{Pose, pose};
use sinew::{BodyCollider, Distance, Simulation};

use crate::row::{Row, Stretch, Unit};

/// Length of a tick, s.
pub const TICK: f32 = 1.0 / 60.0;

/// Ticks after which the quality is judged: 4 s, when what was let go has swung to and fro.
pub const TICKS: usize = 240;

/// Ticks before the clock starts: the plan is compiled and caches are warm.
const WARM: usize = 4;

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Portions of which the median is taken, at least 1.
    pub rounds: usize,
    /// Whether a tenth of the ticks is enough: for trying the program out. Figures are rough, and the quality is that after 0.4 s.
    pub quick: bool,
    /// Whether user scenes have the threads of an app, and are timed by the clock at the wall.
    pub threads: bool,
    /// Whether the rival runs, too.
    pub peers: bool,
}

/// Something that can run a scene.
pub trait World {
    /// Runs one tick.
    fn tick(&mut self);

    /// How well it holds together now; `None` where there is nothing to stretch.
    fn stretch(&self) -> Option<Stretch>;

    /// The cubes in it that collide; none where nobody asks how calm they are.
    fn cubes(&self) -> Vec<Cube> {
        Vec::new()
    }

    /// How fast those are, m/s, or whatever else there is.
    fn speeds(&self) -> Vec<Vec3> {
        self.cubes().iter().map(|cube| cube.velocity).collect()
    }
}

/// A cube of 1 m that collides.
#[derive(Clone, Copy, Debug)]
pub struct Cube {
    /// From its own frame, which has its centre, to the world.
    pub pose: Pose,
    /// Of its centre, m/s.
    pub velocity: Vec3,
}

/// The contenders.
pub struct Race {
    /// Sinew.
    pub ours: Option<Box<dyn World>>,
    /// The naive reference.
    pub naive: Option<Box<dyn World>>,
    /// The rival.
    pub peer: Option<Box<dyn World>>,
    /// The most ticks that are timed and run, for scenes of which one tick takes long; Sinew runs all the same to the end.
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

/// That of the hard ones among some distances: a soft one is there to yield.
pub fn stretch_of(
    distances: &[Distance],
    position: impl Fn(usize) -> sinew::glam::Vec3,
) -> Option<Stretch> {
    let mut hard = distances.iter().filter(|d| d.softness.is_hard() && d.rest > 0.0).peekable();
    hard.peek()?;
    Some(Stretch::of(hard, position))
}

/// What a portion took, s per tick.
#[derive(Clone, Copy, Debug)]
pub struct Took {
    /// Of the processor.
    pub cpu: f64,
    /// Of the clock at the wall.
    pub wall: f64,
}

/// Times `work`, which is `count` things, seconds each.
pub fn time(count: usize, mut work: impl FnMut()) -> Took {
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    work();
    let count = count.max(1) as f64;
    Took { cpu: cpu.elapsed().as_secs_f64() / count, wall: wall.elapsed().as_secs_f64() / count }
}

/// The mean of the squares of speeds, m²/s².
pub fn mean_square(speeds: &[Vec3]) -> f64 {
    let squares = speeds.iter().map(|speed| f64::from(speed.length_squared()));
    squares.sum::<f64>() / speeds.len().max(1) as f64
}

/// The middle one; NaN of nothing.
pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Race {
    /// Between Sinew and the naive reference.
    pub fn between(ours: impl World + 'static, naive: impl World + 'static) -> Self {
        Self { naive: Some(Box::new(naive)), ..Self::alone(ours) }
    }

    /// Sinew alone.
    pub fn alone(ours: impl World + 'static) -> Self {
        Self { ours: Some(Box::new(ours)), naive: None, peer: None, most: TICKS }
    }

    /// The same with a rival, if there is one.
    pub fn against(self, peer: Option<Box<dyn World>>) -> Self {
        Self { peer, ..self }
    }

    /// The same with no more ticks than that.
    pub fn short(self, most: usize) -> Self {
        Self { most, ..self }
    }

    /// Runs it and fills in the row. `count` is how many of the row's units there are in a tick.
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
        // Nobody waits minutes to hear how well a slow reference did, or for what nothing is judged by.
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
