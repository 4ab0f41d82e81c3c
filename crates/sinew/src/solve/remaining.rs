//! What remains of a task for the solvers that take islands one by one, after instance batches and wavefronts have taken theirs.

use core::ops::Range;

use super::plan::Task;
use crate::islands::Singles;

/// Islands of a task, and its rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Remaining {
    pub(crate) islands: Vec<Range<usize>>,
    pub(crate) rows: Vec<Range<u32>>,
}

impl Remaining {
    /// Sets it to the whole task.
    pub(super) fn reset(&mut self, task: &Task) {
        self.islands.clear();
        self.rows.clear();
        self.islands.push(task.islands.clone());
        self.rows.push(task.rows.clone());
    }

    /// Whether nothing remains.
    pub(super) fn is_empty(&self) -> bool {
        self.islands.iter().all(Range::is_empty) && self.rows.iter().all(Range::is_empty)
    }

    /// Whether an island remains.
    pub(super) fn contains(&self, island: usize) -> bool {
        self.islands.iter().any(|islands| islands.contains(&island))
    }

    /// Removes some islands and their rows.
    pub(super) fn remove(&mut self, islands: Range<usize>, rows: Range<u32>) {
        self.remove_islands(islands);
        cut(&mut self.rows, rows);
    }

    /// Removes some islands but not their rows, which are still predicted and derived.
    pub(super) fn remove_islands(&mut self, islands: Range<usize>) {
        cut(&mut self.islands, islands);
    }

    /// Removes the [single particles](Singles) of a task, which are not swept.
    pub(super) fn remove_singles(&mut self, singles: &[Singles], task: &Task) {
        for islands in singles.iter().map(|all| all.among(&task.islands).islands) {
            if !islands.is_empty() {
                self.remove_islands(islands);
            }
        }
    }
}

/// Cuts a range out of the range that contains it, mostly the last one. Leaves no empty ranges: there may be many instance batches, and the list is searched
/// for each island.
fn cut<T: Copy + PartialOrd>(ranges: &mut Vec<Range<T>>, out: Range<T>) {
    let all_in = |range: &Range<T>| range.start <= out.start && out.end <= range.end;
    let Some(i) = ranges.iter().rposition(all_in) else { return };
    let after = out.end..core::mem::replace(&mut ranges[i].end, out.start);
    if ranges[i].is_empty() {
        ranges[i] = after;
    } else if !after.is_empty() {
        ranges.insert(i + 1, after);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_removed_is_gone_and_all_else_remains() {
        let task = Task { islands: 2..9, rows: 20..90, ..Task::default() };
        let mut rest = Remaining::default();
        rest.reset(&task);
        for island in [2, 5, 8, 4, 3] {
            let first = 10 * island as u32;
            rest.remove(island..island + 1, first..first + 10);
        }
        let left: Vec<usize> = (0..12).filter(|&island| rest.contains(island)).collect();
        assert_eq!(left, [6, 7]);
        let rows: Vec<u32> = rest.rows.iter().cloned().flatten().collect();
        assert_eq!(rows, (60..80).collect::<Vec<u32>>());
        assert!(!rest.is_empty());
        rest.remove(6..8, 60..80);
        assert!(rest.is_empty());
    }
}
