//! Change tracking of what may be long and hardly ever changes: whether two are equal is one look, where one is a copy of the other.

use core::fmt::{self, Debug, Formatter};
use core::ops::{Deref, DerefMut};
use core::sync::atomic::{AtomicU64, Ordering};

/// A value, and a number that it has for as long as nobody borrows it mutably. Two that have the same number are copies of each other; it is no part of the
/// value. Each mutable borrow takes a new number, so a loop that writes borrows once.
///
/// ```
/// use sinew::Tracked;
///
/// let mut list = Tracked::from(vec![1, 2]);
/// let copy = list.clone();
/// assert!(list == copy, "without a look at what is in them");
/// list.push(3);
/// assert!(list != copy);
/// ```
#[derive(Clone)]
pub struct Tracked<T> {
    value: T,
    revision: u64,
}

/// The next number: of all values, so that those that come of different places have different ones.
static NEXT: AtomicU64 = AtomicU64::new(0);

fn next() -> u64 {
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// A number for what is changed in many places, each of which [says so](Self::advance). A copy has another one: it may come to stand where something else was that
/// was known by the number that both would have had.
#[derive(Debug)]
pub(crate) struct Revision(u64);

impl Revision {
    pub(crate) fn number(&self) -> u64 {
        self.0
    }

    pub(crate) fn advance(&mut self) {
        self.0 = next();
    }
}

impl Default for Revision {
    fn default() -> Self {
        Self(next())
    }
}

impl Clone for Revision {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> Tracked<T> {
    /// The number.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }
}

impl<T> From<T> for Tracked<T> {
    fn from(value: T) -> Self {
        Self { value, revision: next() }
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
        self.revision = next();
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

/// As the value: the number is another one in each run.
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

    /// Tells whether anybody looked at it.
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
        assert_eq!(one, other, "nobody looked");
        let _ = &mut *other;
        assert_ne!(one, other);
        assert_ne!(Tracked::from(Unlike), Tracked::from(Unlike));
        assert_eq!(Tracked::from(7), Tracked::from(7));
        assert_eq!(format!("{:?}", Tracked::from(7)), "7", "the same in each run");
    }
}
