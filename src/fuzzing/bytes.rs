//! Numbers and choices from the bytes of a fuzzer.

/// Decisions from bytes; behind the last one there are zeros.
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Bytes<'a> {
        Bytes { rest: bytes }
    }

    pub(super) fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.rest.split_first() else { return 0 };
        self.rest = rest;
        first
    }

    pub(super) fn bit(&mut self) -> bool {
        self.byte() % 2 == 1
    }

    pub(super) fn word(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    /// Any double at all.
    pub(super) fn double(&mut self) -> f64 {
        f64::from_bits(self.word())
    }

    /// From `first` up to `last`.
    pub(super) fn within(&mut self, first: usize, last: usize) -> usize {
        first + usize::from(self.byte()) % (last + 1 - first)
    }

    pub(super) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[usize::from(self.byte()) % from.len()]
    }
}
