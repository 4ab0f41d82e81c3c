//! One line of the report: the expected value, the measured value, and the tolerance.

/// How far a measured number may be from the expected one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// `|measured/expected - 1|` at most this.
    Relative(f64),
    /// `|measured - expected|` at most this, in the row's unit.
    Absolute(f64),
    /// The expected number is an upper limit.
    AtMost,
    /// The expected number is a lower limit.
    AtLeast,
}

/// One line of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The row of `physics.md` that it belongs to, such as `"I1"`, or the heading if the row has no number.
    pub id: &'static str,
    /// What is measured, with the settings.
    pub what: String,
    /// Unit of both numbers; empty if they have none.
    pub unit: &'static str,
    /// What the formula gives.
    pub expected: f64,
    /// What the solver gave.
    pub measured: f64,
    /// The tolerance. The case states its reason.
    pub allowed: Allowed,
}

impl Row {
    /// A number with a relative tolerance: `|measured/expected - 1| ≤ share`.
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

    /// A number with an absolute tolerance in its own unit: `|measured - expected| ≤ amount`.
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

    /// A number with an upper limit.
    pub fn at_most(what: impl Into<String>, unit: &'static str, limit: f64, measured: f64) -> Self {
        let allowed = Allowed::AtMost;
        Self { id: "", what: what.into(), unit, expected: limit, measured, allowed }
    }

    /// A number with a lower limit.
    pub fn at_least(
        what: impl Into<String>,
        unit: &'static str,
        limit: f64,
        measured: f64,
    ) -> Self {
        let allowed = Allowed::AtLeast;
        Self { id: "", what: what.into(), unit, expected: limit, measured, allowed }
    }

    /// Difference between the measured and the expected number: relative for [`Allowed::Relative`], otherwise in the row's unit. For a limit, by how much it is
    /// exceeded; 0 if it is not.
    pub fn error(&self) -> f64 {
        let difference = self.measured - self.expected;
        match self.allowed {
            Allowed::Relative(_) => difference / self.expected.abs(),
            Allowed::Absolute(_) => difference,
            // Not `f64::max`, which ignores a NaN.
            Allowed::AtMost if difference <= 0.0 => 0.0,
            Allowed::AtLeast if difference >= 0.0 => 0.0,
            Allowed::AtMost | Allowed::AtLeast => difference,
        }
    }

    /// Whether the error is within the tolerance. False for NaN.
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
