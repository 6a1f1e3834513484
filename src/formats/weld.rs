//! Joining vertices that stand at one place, for formats whose triangles do not share them.

use std::fs::File;

use crate::base::external::{Scratch, ScratchError, Sorted, Sorter};

/// Bytes of each of the three sorts.
const SORT_BYTES: usize = 16 << 20;

/// Numbers read at a time, one after the other.
const PIECE: usize = 8 << 10;

/// Takes the places of elements (the corners of triangles, or vertices of parts of a mesh), one after the other, and numbers
/// the vertices that they are: elements at the same place, bit for bit, are one vertex. Vertices are numbered in the order in
/// which they appear first.
///
/// Memory: two sorts of 16 MiB at a time. Temporary files: some 60 bytes for each element.
pub(super) struct Welder<'s> {
    scratch: &'s Scratch,
    places: Sorter<'s, 4>,
    elements: u64,
}

impl<'s> Welder<'s> {
    pub(super) fn new(scratch: &'s Scratch) -> Welder<'s> {
        Welder { scratch, places: Sorter::new(scratch, SORT_BYTES), elements: 0 }
    }

    /// The place of the next element.
    pub(super) fn push(&mut self, [x, y, z]: [f64; 3]) -> Result<(), ScratchError> {
        self.places.push([x.to_bits(), y.to_bits(), z.to_bits(), self.elements])?;
        self.elements += 1;
        Ok(())
    }

    /// The numbers, once all elements have come.
    pub(super) fn finish(self) -> Result<Welded, ScratchError> {
        let Welder { scratch, places, elements } = self;
        // Each element with the first one at its place.
        let mut firsts = Sorter::<2>::new(scratch, SORT_BYTES);
        let mut group: Option<([u64; 3], u64)> = None;
        for record in places.finish()? {
            let [x, y, z, element] = record?;
            let first = match group {
                Some((place, first)) if place == [x, y, z] => first,
                _ => element,
            };
            group = Some(([x, y, z], first));
            firsts.push([first, element])?;
        }
        let mut numbers = Sorter::<2>::new(scratch, SORT_BYTES);
        let (mut vertices, mut last) = (0, None);
        for record in firsts.finish()? {
            let [first, element] = record?;
            if last.replace(first) != Some(first) {
                vertices += 1;
            }
            numbers.push([element, vertices - 1])?;
        }
        let file = scratch.file()?;
        write_numbers(numbers.finish()?, scratch, &file)?;
        Ok(Welded { file, elements, vertices })
    }
}

fn write_numbers(numbers: Sorted<'_, 2>, scratch: &Scratch, file: &File) -> Result<(), ScratchError> {
    let mut piece = Vec::with_capacity(PIECE);
    for record in numbers {
        let [_, vertex] = record?;
        piece.push([vertex]);
        if piece.len() == PIECE {
            scratch.write(file, &piece)?;
            piece.clear();
        }
    }
    scratch.write(file, &piece)
}

/// Which vertex each element is. Memory: nothing; temporary file: 8 bytes for each element.
#[derive(Debug)]
pub(super) struct Welded {
    file: File,
    elements: u64,
    vertices: u64,
}

impl Welded {
    /// How many vertices there are.
    pub(super) fn vertices(&self) -> u64 {
        self.vertices
    }

    /// The vertices of all elements, one after the other; a vertex appears for the first time where its number is that of
    /// those before it. Memory: 64 KiB. To be read to the end, or dropped, before it is asked for again.
    pub(super) fn numbers<'a>(&'a self, scratch: &'a Scratch) -> impl Iterator<Item = Result<u64, ScratchError>> + 'a {
        self.numbers_from(0, scratch)
    }

    /// The same, from one element on.
    pub(super) fn numbers_from<'a>(
        &'a self,
        element: u64,
        scratch: &'a Scratch,
    ) -> impl Iterator<Item = Result<u64, ScratchError>> + 'a {
        let pieces = (element..self.elements).step_by(PIECE).map(move |first| {
            let mut piece = vec![[0]; PIECE.min((self.elements - first) as usize)];
            scratch.read(&self.file, first, &mut piece).map(|()| piece)
        });
        pieces.flat_map(|piece| {
            let (numbers, error) = match piece {
                Ok(numbers) => (numbers, None),
                Err(error) => (Vec::new(), Some(Err(error))),
            };
            numbers.into_iter().map(|[number]| Ok(number)).chain(error)
        })
    }

    /// The vertices of these elements, the first one's first.
    ///
    /// # Panics
    /// If there are not so many.
    pub(super) fn some(&self, scratch: &Scratch, first: u64, count: usize) -> Result<Vec<u64>, ScratchError> {
        assert!(first + count as u64 <= self.elements, "elements {first} and {count} more of {}", self.elements);
        let mut numbers = vec![[0]; count];
        scratch.read(&self.file, first, &mut numbers)?;
        Ok(numbers.into_iter().map(|[number]| number).collect())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn numbers_are_those_of_a_map(places in proptest::collection::vec((0u8..4, 0u8..4, 0u8..2), 0..300)) {
            let scratch = Scratch::new(None, Default::default());
            let mut welder = Welder::new(&scratch);
            let (mut seen, mut expected) = (HashMap::new(), Vec::new());
            for &(x, y, z) in &places {
                welder.push([f64::from(x), f64::from(y), f64::from(z)]).expect("taken");
                let next = seen.len() as u64;
                expected.push(*seen.entry((x, y, z)).or_insert(next));
            }
            let welded = welder.finish().expect("welded");
            let found: Vec<u64> = welded.numbers(&scratch).collect::<Result<_, _>>().expect("numbers");
            prop_assert_eq!(&found, &expected);
            prop_assert_eq!(welded.vertices(), seen.len() as u64);
            let half = expected.len() / 2;
            let later: Vec<u64> = welded.numbers_from(half as u64, &scratch).collect::<Result<_, _>>().expect("numbers");
            prop_assert_eq!(&later, &expected[half..]);
            prop_assert_eq!(&welded.some(&scratch, half as u64, expected.len() - half).expect("some"), &expected[half..]);
        }
    }
}
