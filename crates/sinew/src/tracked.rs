//! Change tracking for values that may be long and seldom change: comparing a value with its copy compares two revision numbers.

use core::fmt::{self, Debug, Formatter};
use core::ops::{Deref, DerefMut};
use core::sync::atomic::{AtomicU64, Ordering};

/// A value with a revision number that stays the same until the value is borrowed mutably. Two values with the same revision are copies of each other; the
/// revision is not part of the value. Each mutable borrow takes a new revision, so a loop that writes should borrow once.
///
/// ```
/// use sinew::Tracked;
///
/// let mut list = Tracked::from(vec![1, 2]);
/// let copy = list.clone();
/// assert!(list == copy, "without a comparison of the elements");
/// list.push(3);
/// assert!(list != copy);
/// ```
#[derive(Clone)]
pub struct Tracked<T> {
    value: T,
    revision: u64,
}

/// The next revision, shared by all values of the process, so that values of different origin never have the same one.
static NEXT_REVISION: AtomicU64 = AtomicU64::new(0);

fn next_revision() -> u64 {
    NEXT_REVISION.fetch_add(1, Ordering::Relaxed)
}

/// A revision number for state that is changed in many places, each of which must call [`advance`](Self::advance). A clone gets a number of its own: it may
/// replace the original, and a cache keyed by the original's number must then miss.
#[derive(Debug)]
pub(crate) struct Revision(u64);

impl Revision {
    pub(crate) fn number(&self) -> u64 {
        self.0
    }

    pub(crate) fn advance(&mut self) {
        self.0 = next_revision();
    }
}

impl Default for Revision {
    fn default() -> Self {
        Self(next_revision())
    }
}

impl Clone for Revision {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> Tracked<T> {
    /// The revision number.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }
}

impl<T> From<T> for Tracked<T> {
    fn from(value: T) -> Self {
        Self { value, revision: next_revision() }
    }
}

impl<T: Default> Default for Tracked<T> {
    fn default() -> Self {
        Self::from(T::default())
    }
}

impl<T> Deref for Tracked<T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for Tracked<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut T {
        self.revision = next_revision();
        &mut self.value
    }
}

impl<'a, T> IntoIterator for &'a Tracked<T>
where
    &'a T: IntoIterator,
{
    type Item = <&'a T as IntoIterator>::Item;
    type IntoIter = <&'a T as IntoIterator>::IntoIter;

    fn into_iter(self) -> Self::IntoIter {
        self.value.into_iter()
    }
}

/// As the value: the revision differs from run to run.
impl<T: Debug> Debug for Tracked<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.value.fmt(f)
    }
}

impl<T: PartialEq> PartialEq for Tracked<T> {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.revision == other.revision || self.value == other.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Never equal to anything, so that an equality shows that the values were not compared.
    #[derive(Clone, Debug)]
    struct Unlike;

    impl PartialEq for Unlike {
        fn eq(&self, _: &Self) -> bool {
            false
        }
    }

    #[test]
    fn a_copy_is_equal_until_one_of_them_is_written_and_then_the_value_says() {
        let one = Tracked::from(Unlike);
        let mut other = one.clone();
        assert_eq!(one, other, "by their revision, without a comparison");
        let _ = &mut *other;
        assert_ne!(one, other);
        assert_ne!(Tracked::from(Unlike), Tracked::from(Unlike));
        assert_eq!(Tracked::from(7), Tracked::from(7));
        assert_eq!(format!("{:?}", Tracked::from(7)), "7", "the same in each run");
    }
}
