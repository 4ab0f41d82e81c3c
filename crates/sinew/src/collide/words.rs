//! Serialisation of types with private fields as a sequence of `u32` words. Floats are stored by their bits, so that reading restores them exactly.

use glam::{Mat3, Vec3};

/// Appends values as words.
pub(crate) trait Write {
    fn float(&mut self, x: f32);

    fn long(&mut self, x: u64);

    fn vec3(&mut self, v: Vec3) {
        v.to_array().into_iter().for_each(|x| self.float(x));
    }

    fn mat3(&mut self, m: Mat3) {
        m.to_cols_array().into_iter().for_each(|x| self.float(x));
    }
}

impl Write for Vec<u32> {
    fn float(&mut self, x: f32) {
        self.push(x.to_bits());
    }

    fn long(&mut self, x: u64) {
        self.extend([x as u32, (x >> 32) as u32]);
    }
}

/// Reads words in sequence; `None` where they end too early.
pub(crate) struct Reader<'a>(pub(crate) &'a [u32]);

impl Reader<'_> {
    pub(crate) fn word(&mut self) -> Option<u32> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    pub(crate) fn float(&mut self) -> Option<f32> {
        self.word().map(f32::from_bits)
    }

    pub(crate) fn long(&mut self) -> Option<u64> {
        let (low, high) = (self.word()?, self.word()?);
        Some(u64::from(low) | u64::from(high) << 32)
    }

    pub(crate) fn vec3(&mut self) -> Option<Vec3> {
        Some(Vec3::new(self.float()?, self.float()?, self.float()?))
    }

    pub(crate) fn mat3(&mut self) -> Option<Mat3> {
        Some(Mat3::from_cols(self.vec3()?, self.vec3()?, self.vec3()?))
    }

    /// A list preceded by its length. Memory is reserved only for as many elements as there are words left, whatever the length says.
    pub(crate) fn list<T>(
        &mut self,
        mut one: impl FnMut(&mut Self) -> Option<T>,
    ) -> Option<Vec<T>> {
        let length = self.word()? as usize;
        let mut list = Vec::with_capacity(length.min(self.0.len()));
        for _ in 0..length {
            list.push(one(self)?);
        }
        Some(list)
    }

    /// Returns `read` if no words are left over.
    pub(crate) fn all<T>(self, read: T) -> Option<T> {
        self.0.is_empty().then_some(read)
    }
}
