//! FNV-1a hash (Fowler, Noll, Vo), 64 bits, fed 32 bits at a time: the same on every machine.

/// Hashes a sequence of words.
pub(crate) fn fnv(words: impl IntoIterator<Item = u32>) -> u64 {
    let mix = |hash: u64, word: u32| (hash ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3);
    words.into_iter().fold(0xcbf2_9ce4_8422_2325, mix)
}
