//! Loads: the forces with which single distances and constraints hold, measured on request.

use super::{Scratch, Simulation, Substep};

impl Simulation {
    /// Measures the loads of these distances and constraints from the next step on, and of no others, given by their indices in [`distances`](Self::distances)
    /// and [`constraints`](Self::constraints). Adding or removing one shifts the indices: then call this again.
    ///
    /// Islands with measured constraints are solved one constraint after the other, whatever order is set, and by tethers however small they are
    /// ([`SolverSettings::long_range`](crate::SolverSettings::long_range)): three times the work, and a few particles elsewhere move by round-off.
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
        self.scratch.loads.select(distances.into_iter(), constraints.into_iter());
    }

    /// Keeps the strains of these distances, given by their indices in [`distances`](Self::distances), as the solver leaves them, from the next step on, and of
    /// no others: for a game that breaks distances by strain. Without this, large cloth that something holds ends each step with its errors distributed and its
    /// strain limited to 3 % ([`SolverSettings::microsteps`](crate::SolverSettings::microsteps)). Adding or removing a distance shifts the indices: then call
    /// this again.
    pub fn measure_strains(&mut self, distances: impl IntoIterator<Item = usize>) {
        self.scratch.measured_strains.clear();
        self.scratch.measured_strains.extend(distances);
        self.scratch.settings_inputs = None;
    }

    /// Tension of a distance, N, averaged over the last step; negative where it pushes its ends apart. `None` if it was not [measured](Self::measure_loads), or
    /// is faulty and so not in the plan.
    ///
    /// It is the sum of the solver's corrections, so it balances the load even where the solver did not converge: what hangs at rest pulls with its weight.
    pub fn distance_load(&self, number: usize) -> Option<f32> {
        let Scratch { loads, plan, .. } = &self.scratch;
        loads.distance(number, (&self.particles, plan), self.last_substeps())
    }

    /// Load of a constraint, N, averaged over the last step: for an [`AnchorDistance`](crate::constraints::AnchorDistance) the force between its two anchors,
    /// for any other kind the force on the first of its particles that is not pinned. Not negative.
    pub fn constraint_load(&self, number: usize) -> Option<f32> {
        self.scratch.loads.constraint(number, self.last_substeps())
    }

    fn last_substeps(&self) -> (f32, u32) {
        let Substep { length, remaining } = self.scratch.substep;
        (length, self.report.substeps.saturating_sub(remaining))
    }

    /// Finds the measured distances and constraints in the plan, when the step begins.
    pub(super) fn find_loads(&mut self) {
        if self.scratch.loads.is_stale() {
            let none = self.scratch.loads.is_empty();
            let numbers = if none { Default::default() } else { self.scratch.plan.numbers() };
            let [mut distances, mut constraints] = numbers;
            if !none && !self.compounds.is_empty() {
                let [outer, others] = self.numbers_outside_compounds();
                let given = |all: &[u32], i: u32| all.get(i as usize).copied().unwrap_or(u32::MAX);
                distances.iter_mut().for_each(|i| *i = given(&outer, *i));
                // Behind these are the shapes of compounds, which have no index in the list.
                constraints.iter_mut().for_each(|i| *i = given(&others, *i));
            }
            let Scratch { loads, plan, .. } = &mut self.scratch;
            loads.find(plan, &distances, &constraints);
        }
        let Scratch { loads, plan, .. } = &mut self.scratch;
        loads.begin(plan);
    }
}
