//! Loads: with what force single distances and constraints hold, for whoever asks.

use super::{Scratch, Simulation, Substep};

impl Simulation {
    /// Has the loads of these distances and constraints measured from the next step on, by their numbers in [`distances`](Self::distances) and
    /// [`constraints`](Self::constraints), and those of no others. Where one is added or removed, numbers change: then say them again.
    ///
    /// Islands with such are solved one constraint after the other, whatever order they ask for, and held by tethers however small they are
    /// ([`SolverSettings::long_range`](crate::SolverSettings::long_range)): three times the work, and a few particles move by round-off elsewhere.
    ///
    /// ```
    /// use sinew::glam::Vec3;
    /// use sinew::{Distance, ParticleSeed, Simulation};
    ///
    /// let mut world = Simulation::default();
    /// world.forces.gravity = Vec3::NEG_Y * 9.81;
    /// let hook = world.particles.push(ParticleSeed::at(Vec3::ZERO).pinned())?;
    /// let bob = world.particles.push(ParticleSeed { mass: 2.0, ..ParticleSeed::at(Vec3::NEG_Y) })?;
    /// world.distances_mut().push(Distance::new(hook, bob, 1.0));
    /// world.measure_loads([0], []);
    /// for _ in 0..2 {
    ///     world.step(1.0 / 60.0)?;
    /// }
    /// let weight = world.distance_load(0).unwrap();
    /// assert!((weight - 2.0 * 9.81).abs() < 0.2, "{weight} N");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn measure_loads(
        &mut self,
        distances: impl IntoIterator<Item = usize, IntoIter: Clone>,
        constraints: impl IntoIterator<Item = usize, IntoIter: Clone>,
    ) {
        self.scratch.loads.want(distances.into_iter(), constraints.into_iter());
    }

    /// Has these distances, by their numbers in [`distances`](Self::distances), be as far from their lengths when a step ends as the solver left them, from
    /// the next step on, and no others: for whoever breaks them by that. Otherwise large cloth that something holds has its errors shared out and its strain
    /// limited to 3 % then ([`SolverSettings::microsteps`](crate::SolverSettings::microsteps)). Where one is added or removed, numbers change: then say them
    /// again.
    pub fn measure_strains(&mut self, distances: impl IntoIterator<Item = usize>) {
        self.scratch.measured_strains.clear();
        self.scratch.measured_strains.extend(distances);
        self.scratch.settled = None;
    }

    /// The tension of a distance, N, in the mean over the last step; negative where it holds its ends apart. `None` if it was not
    /// [measured](Self::measure_loads), or could not act.
    ///
    /// It is what the solver did, so it balances what pulls whether the solver was done or not: what hangs at rest pulls with its weight.
    pub fn distance_load(&self, number: usize) -> Option<f32> {
        let Scratch { loads, plan, .. } = &self.scratch;
        loads.distance(number, (&self.particles, plan), self.last_substeps())
    }

    /// The same of a constraint: the force between the two anchors of an [`AnchorDistance`](crate::constraints::AnchorDistance), of any other kind that on
    /// the first of its particles that is free. Not negative.
    pub fn constraint_load(&self, number: usize) -> Option<f32> {
        self.scratch.loads.constraint(number, self.last_substeps())
    }

    fn last_substeps(&self) -> (f32, u32) {
        let Substep { length, remaining } = self.scratch.substep;
        (length, self.report.substeps.saturating_sub(remaining))
    }

    /// Looks up where in the plan those are that are measured, when the step begins.
    pub(super) fn find_loads(&mut self) {
        if self.scratch.loads.is_stale() {
            let none = self.scratch.loads.is_empty();
            let numbers = if none { Default::default() } else { self.scratch.plan.numbers() };
            let [mut distances, mut constraints] = numbers;
            if !none && !self.compounds.is_empty() {
                let [outer, others] = self.numbers_beside_compounds();
                let given = |all: &[u32], i: u32| all.get(i as usize).copied().unwrap_or(u32::MAX);
                distances.iter_mut().for_each(|i| *i = given(&outer, *i));
                // Behind the others are the shapes, which are nobody's.
                constraints.iter_mut().for_each(|i| *i = given(&others, *i));
            }
            let Scratch { loads, plan, .. } = &mut self.scratch;
            loads.find(plan, &distances, &constraints);
        }
        let Scratch { loads, plan, .. } = &mut self.scratch;
        loads.begin(plan);
    }
}
