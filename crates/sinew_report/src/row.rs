//! One line of the report: what was expected, what came out, and how far apart the two may be.

/// How far a measured number may be from the expected one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// `|measured/expected - 1|` at most this.
    Relative(f64),
    /// `|measured - expected|` at most this, in the row's unit.
    Absolute(f64),
    /// The expected number is the most that it may be.
    AtMost,
    /// The expected number is the least that it may be.
    AtLeast,
}

/// One line of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The row of `physics.md` that it belongs to, such as `"I1"`, or the heading where the page has no number.
    pub id: &'static str,
    /// What is measured, with the settings that it is measured at.
    pub what: String,
    /// Unit of both numbers; empty where they have none.
    pub unit: &'static str,
    /// What the formula gives.
    pub expected: f64,
    /// What the solver gave.
    pub measured: f64,
    /// How far apart the two may be. The case says why.
    pub allowed: Allowed,
}

impl Row {
    /// A number that is right to a share of itself: `|measured/expected - 1| ≤ share`.
    pub fn relative(
        what: impl Into<String>,
        unit: &'static str,
        expected: f64,
        measured: f64,
        share: f64,
    ) -> Self {
        let allowed = Allowed::Relative(share);
        Self { id: "", what: what.into(), unit, expected, measured, allowed }
    }

    /// A number that is right to an amount in its own unit: `|measured - expected| ≤ amount`.
    pub fn absolute(
        what: impl Into<String>,
        unit: &'static str,
        expected: f64,
        measured: f64,
        amount: f64,
    ) -> Self {
        let allowed = Allowed::Absolute(amount);
        Self { id: "", what: what.into(), unit, expected, measured, allowed }
    }

    /// A number that is at most `limit`.
    pub fn at_most(what: impl Into<String>, unit: &'static str, limit: f64, measured: f64) -> Self {
        let allowed = Allowed::AtMost;
        Self { id: "", what: what.into(), unit, expected: limit, measured, allowed }
    }

    /// A number that is at least `limit`.
    pub fn at_least(
        what: impl Into<String>,
        unit: &'static str,
        limit: f64,
        measured: f64,
    ) -> Self {
        let allowed = Allowed::AtLeast;
        Self { id: "", what: what.into(), unit, expected: limit, measured, allowed }
    }

    /// How far the measured number is from the expected one: a share of it where a share is [`Allowed`], otherwise in its unit. For a limit,
    /// how far it is overstepped, 0 if it is not.
    pub fn error(&self) -> f64 {
        let difference = self.measured - self.expected;
        match self.allowed {
            Allowed::Relative(_) => difference / self.expected.abs(),
            Allowed::Absolute(_) => difference,
            // Not `max`, which takes a NaN for nothing.
            Allowed::AtMost if difference <= 0.0 => 0.0,
            Allowed::AtLeast if difference >= 0.0 => 0.0,
            Allowed::AtMost | Allowed::AtLeast => difference,
        }
    }

    /// Whether the error is within what is allowed. A number that is none (NaN) never is.
    pub fn verdict(&self) -> bool {
        let most = match self.allowed {
            Allowed::Relative(most) | Allowed::Absolute(most) => most,
            Allowed::AtMost | Allowed::AtLeast => 0.0,
        };
        self.error().abs() <= most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_right_within_what_is_allowed_and_wrong_beyond() {
        assert!(Row::relative("", "", -2.0, -2.002, 0.0011).verdict());
        assert!(!Row::relative("", "", -2.0, -2.002, 0.0009).verdict());
        assert!(Row::absolute("", "", 0.0, -0.5, 0.5).verdict());
        assert!(!Row::absolute("", "", 0.0, -0.6, 0.5).verdict());
        assert!(Row::at_most("", "", 1.0, 0.2).verdict());
        assert!(!Row::at_most("", "", 1.0, 1.2).verdict());
        assert!(Row::at_least("", "", 1.0, 1.2).verdict());
        assert!(!Row::at_least("", "", 1.0, 0.2).verdict());
    }

    #[test]
    fn what_is_no_number_is_never_right() {
        for row in [
            Row::relative("", "", 1.0, f64::NAN, 9.0),
            Row::relative("", "", 0.0, 0.0, 9.0),
            Row::absolute("", "", 1.0, f64::NAN, 9.0),
            Row::at_most("", "", 1.0, f64::NAN),
            Row::at_least("", "", 1.0, f64::NAN),
            Row::absolute("", "", 1.0, f64::INFINITY, 9.0),
        ] {
            assert!(!row.verdict(), "{row:?}");
        }
    }

    #[test]
    fn the_sign_of_an_error_says_which_way_it_went() {
        assert!(Row::relative("", "", -2.0, -3.0, 0.0).error() < 0.0);
        assert_eq!(Row::at_most("", "", 1.0, 1.5).error(), 0.5);
        assert_eq!(Row::at_least("", "", 1.0, 0.5).error(), -0.5);
    }
}
