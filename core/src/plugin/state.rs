//! Writing, reading and hashing a solver's state.

use xxhash_rust::xxh3::Xxh3;

use crate::boundary::Vec3;

/// Takes the bytes of a state in order. A hasher or a buffer; a solver cannot tell which.
pub trait StateSink {
    /// Appends bytes.
    fn bytes(&mut self, bytes: &[u8]);

    /// Appends a number.
    fn f64(&mut self, value: f64) {
        self.bytes(&value.to_le_bytes());
    }

    /// Appends a number.
    fn u64(&mut self, value: u64) {
        self.bytes(&value.to_le_bytes());
    }

    /// Appends three numbers.
    fn vec3(&mut self, value: Vec3) {
        self.bytes(bytemuck::bytes_of(&value));
    }

    /// Appends the length of a list and its vectors.
    fn vec3s(&mut self, values: &[Vec3]) {
        self.u64(values.len() as u64);
        self.bytes(bytemuck::cast_slice(values));
    }
}

impl StateSink for Vec<u8> {
    fn bytes(&mut self, bytes: &[u8]) {
        self.extend_from_slice(bytes);
    }
}

/// xxh3-128 of a state, without a copy of it.
#[derive(Default)]
pub struct StateHasher(Xxh3);

impl StateHasher {
    /// Hash of everything so far.
    pub fn finish(&self) -> u128 {
        self.0.digest128()
    }
}

impl StateSink for StateHasher {
    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }
}

/// A saved state that ends too early, goes on too long, or holds something else.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StateError {
    /// Fewer bytes than needed.
    #[error("it ends {missing} bytes early")]
    Short {
        /// Bytes missing.
        missing: usize,
    },
    /// More bytes than needed.
    #[error("{left} bytes are left over")]
    Long {
        /// Bytes left over.
        left: usize,
    },
    /// A count differs from what the scene has.
    #[error("{what}: {found} instead of {expected}")]
    Count {
        /// Counted thing.
        what: &'static str,
        /// In the state.
        found: u64,
        /// In the scene.
        expected: u64,
    },
}

/// Reads what a [`StateSink`] wrote.
pub struct StateReader<'a>(&'a [u8]);

impl<'a> StateReader<'a> {
    /// Starts at the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Takes the next `n` bytes.
    ///
    /// # Errors
    /// [`StateError::Short`].
    pub fn bytes(&mut self, n: usize) -> Result<&'a [u8], StateError> {
        if self.0.len() < n {
            return Err(StateError::Short { missing: n - self.0.len() });
        }
        let (head, tail) = self.0.split_at(n);
        self.0 = tail;
        Ok(head)
    }

    fn eight(&mut self) -> Result<[u8; 8], StateError> {
        let mut buffer = [0; 8];
        buffer.copy_from_slice(self.bytes(8)?);
        Ok(buffer)
    }

    /// Takes a number.
    ///
    /// # Errors
    /// [`StateError::Short`].
    pub fn f64(&mut self) -> Result<f64, StateError> {
        self.eight().map(f64::from_le_bytes)
    }

    /// Takes a number.
    ///
    /// # Errors
    /// [`StateError::Short`].
    pub fn u64(&mut self) -> Result<u64, StateError> {
        self.eight().map(u64::from_le_bytes)
    }

    /// Takes three numbers.
    ///
    /// # Errors
    /// [`StateError::Short`].
    pub fn vec3(&mut self) -> Result<Vec3, StateError> {
        Ok([self.f64()?, self.f64()?, self.f64()?])
    }

    /// Takes a list whose length the scene fixes.
    ///
    /// # Errors
    /// [`StateError::Count`], [`StateError::Short`].
    pub fn vec3s(&mut self, what: &'static str, expected: usize) -> Result<Vec<Vec3>, StateError> {
        let found = self.u64()?;
        if found != expected as u64 {
            return Err(StateError::Count { what, found, expected: expected as u64 });
        }
        (0..expected).map(|_| self.vec3()).collect()
    }

    /// Checks that nothing is left.
    ///
    /// # Errors
    /// [`StateError::Long`].
    pub fn end(self) -> Result<(), StateError> {
        if self.0.is_empty() { Ok(()) } else { Err(StateError::Long { left: self.0.len() }) }
    }
}
