//! A case: one claim of `physics.md`, run and measured. The tests and the report run the same cases.

use crate::Row;

/// One claim and the function that measures it.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The row of `physics.md` that the case belongs to, such as `"I1"`, or the heading if the row has no number.
    pub id: &'static str,
    /// What the case shows, as the name of a function; [`title`](Self::title) is easier to read.
    pub name: &'static str,
    /// Runs the case. The `id` of the returned rows is empty; [`rows`](Self::rows) fills it in.
    pub run: fn() -> Vec<Row>,
}

impl Case {
    /// What the case shows, in words.
    pub fn title(&self) -> String {
        self.name.replace('_', " ")
    }

    /// Runs the case and returns each measured number, with its verdict.
    pub fn rows(&self) -> Vec<Row> {
        let mut rows = (self.run)();
        for row in &mut rows {
            row.id = self.id;
        }
        rows
    }
}

/// A chapter of `physics.md`.
#[derive(Clone, Copy, Debug)]
pub struct Chapter {
    /// Its heading.
    pub title: &'static str,
    /// Its cases by group, in the order of the page.
    pub groups: &'static [&'static [Case]],
}

impl Chapter {
    /// Its cases, in the order of the page.
    pub fn cases(&self) -> impl Iterator<Item = &'static Case> + use<> {
        self.groups.iter().flat_map(|group| group.iter())
    }
}

/// Lists the cases of a file as `CASES`, and makes a test of each: `"I1" name_of_the_function;`.
macro_rules! cases {
    ($($id:literal $name:ident;)*) => {
        pub(crate) const CASES: &[$crate::Case] =
            &[$($crate::Case { id: $id, name: stringify!($name), run: $name }),*];

        #[cfg(test)]
        mod tests {
            $(#[test]
            fn $name() {
                $crate::case::assert_right(&super::$name());
            })*
        }
    };
}
pub(crate) use cases;

/// Panics with every failed row of a case, not just the first.
#[cfg(test)]
pub(crate) fn assert_right(rows: &[Row]) {
    assert!(!rows.is_empty(), "a case that measures nothing shows nothing");
    let wrong: Vec<String> = rows
        .iter()
        .filter(|row| !row.verdict())
        .map(|row| {
            let Row { what, unit, expected, measured, allowed, .. } = row;
            format!("{what}: {measured} {unit} where {expected} is expected, {allowed:?}")
        })
        .collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
