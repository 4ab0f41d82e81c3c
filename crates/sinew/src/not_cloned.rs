//! Scratch memory that is not copied with its owner: its content does not matter between steps, or is computed again.

/// Memory kept from call to call to save allocations. Its content carries no state: a clone starts with the default.
#[derive(Default)]
pub(crate) struct NotCloned<T>(pub(crate) T);

impl<T: Default> Clone for NotCloned<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> core::fmt::Debug for NotCloned<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("NotCloned")
    }
}
