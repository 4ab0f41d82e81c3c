//! Scratch that a copy of its owner does without: what is in it has nothing to say between steps, or is found again.

/// Memory that is kept from call to call and has nothing to say in between: a copy has none.
#[derive(Default)]
pub(crate) struct Kept<T>(pub(crate) T);

impl<T: Default> Clone for Kept<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> core::fmt::Debug for Kept<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Kept")
    }
}
