//! Joining vertices that stand at one place, for formats whose triangles do not share them.

use std::fs::File;

use crate::base::external::{Queue, Scratch, ScratchError, Sorted, Sorter};

/// Bytes of each of the three sorts.
const SORT_BYTES: usize = 16 << 20;

/// Numbers read at a time, one after the other.
const PIECE: usize = 8 << 10;

/// Places that are found again without sorting; a power of two. Each takes 32 bytes.
const RECENT: usize = 1 << 16;

/// How many places back a place is found again.
const WINDOW: u64 = 1 << 17;

/// Takes the places of elements (the corners of triangles, or vertices of parts of a mesh), one after the other, and numbers
/// the vertices that they are: elements at the same place, bit for bit, are one vertex. Vertices are numbered in the order in
/// which they appear first.
///
/// Most elements are where one shortly before them was: no more than one of them is sorted.
///
/// Memory: two sorts of 16 MiB at a time, and 3 MiB. Temporary files: 16 bytes for each element, and some 60 for each that
/// is sorted.
pub(super) struct Welder<'s> {
    scratch: &'s Scratch,
    /// Places, each with its number: the same place may be there more than once.
    places: Sorter<'s, 4>,
    /// How many there are.
    sorted: u64,
    /// Of each element the number of its place.
    of_elements: Queue<'s, 1>,
    elements: u64,
    /// Places, each with its number and 1; 0 where there is none.
    recent: Vec<([u64; 3], u64)>,
}

impl<'s> Welder<'s> {
    pub(super) fn new(scratch: &'s Scratch) -> Welder<'s> {
        Welder {
            scratch,
            places: Sorter::new(scratch, SORT_BYTES),
            sorted: 0,
            of_elements: Queue::new(scratch),
            elements: 0,
            recent: vec![([0; 3], 0); RECENT],
        }
    }

    /// The place of the next element.
    pub(super) fn push(&mut self, place: [f64; 3]) -> Result<(), ScratchError> {
        let place = place.map(f64::to_bits);
        let (found, number) = &mut self.recent[slot(place)];
        let is_near = *number > 0 && *number + WINDOW > self.sorted;
        if *found != place || !is_near {
            let [x, y, z] = place;
            self.places.push([x, y, z, self.sorted])?;
            self.sorted += 1;
            (*found, *number) = (place, self.sorted);
        }
        self.elements += 1;
        self.of_elements.push([*number - 1])
    }

    /// The numbers, once all elements have come.
    pub(super) fn finish(self) -> Result<Welded, ScratchError> {
        let Welder { scratch, places, of_elements, elements, .. } = self;
        // Each place with the first one that is the same.
        let mut firsts = Sorter::<2>::new(scratch, SORT_BYTES);
        let mut group: Option<([u64; 3], u64)> = None;
        for record in places.finish()? {
            let [x, y, z, number] = record?;
            let first = match group {
                Some((place, first)) if place == [x, y, z] => first,
                _ => number,
            };
            group = Some(([x, y, z], first));
            firsts.push([first, number])?;
        }
        let mut numbers = Sorter::<2>::new(scratch, SORT_BYTES);
        let (mut vertices, mut last) = (0, None);
        for record in firsts.finish()? {
            let [first, number] = record?;
            if last.replace(first) != Some(first) {
                vertices += 1;
            }
            numbers.push([number, vertices - 1])?;
        }
        let file = scratch.file()?;
        write_numbers(of_elements, numbers.finish()?, scratch, &file)?;
        Ok(Welded { file, elements, vertices })
    }
}

/// Where a place is looked for.
fn slot(place: [u64; 3]) -> usize {
    let mix = |mixed: u64, word: u64| (mixed.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (place.into_iter().fold(0, mix) >> (64 - RECENT.trailing_zeros())) as usize
}

/// Of each element the vertex that its place is.
fn write_numbers(
    of_elements: Queue<'_, 1>,
    mut vertices: Sorted<'_, 2>,
    scratch: &Scratch,
    file: &File,
) -> Result<(), ScratchError> {
    let mut recent = vec![0; WINDOW as usize];
    let mut next = 0;
    for piece in of_elements.into_pieces() {
        let mut piece = piece?;
        for [number] in &mut piece {
            let slot = &mut recent[(*number % WINDOW) as usize];
            if *number == next {
                [_, *slot] = vertices.next().expect("a vertex for each place")?;
                next += 1;
            }
            *number = *slot;
        }
        scratch.write(file, &piece)?;
    }
    Ok(())
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
        Numbers { welded: self, scratch, next: element, piece: Vec::new(), at: 0 }
    }

    /// The vertices of these elements, the first one's first.
    ///
    /// # Panics
    /// If there are fewer.
    pub(super) fn some(&self, scratch: &Scratch, first: u64, count: usize) -> Result<Vec<u64>, ScratchError> {
        assert!(first + count as u64 <= self.elements, "elements {first} and {count} more of {}", self.elements);
        let mut numbers = vec![[0]; count];
        scratch.read(&self.file, first, &mut numbers)?;
        Ok(numbers.into_iter().map(|[number]| number).collect())
    }
}

/// Numbers that are read one after the other.
struct Numbers<'a> {
    welded: &'a Welded,
    scratch: &'a Scratch,
    /// The element after those of the piece.
    next: u64,
    piece: Vec<[u64; 1]>,
    at: usize,
}

impl Iterator for Numbers<'_> {
    type Item = Result<u64, ScratchError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.at == self.piece.len() {
            let count = (PIECE as u64).min(self.welded.elements - self.next);
            if count == 0 {
                return None;
            }
            self.piece.resize(count as usize, [0]);
            if let Err(error) = self.scratch.read(&self.welded.file, self.next, &mut self.piece) {
                // There is nothing after that.
                (self.next, self.at) = (self.welded.elements, self.piece.len());
                return Some(Err(error));
            }
            (self.next, self.at) = (self.next + count, 0);
        }
        let [number] = self.piece[self.at];
        self.at += 1;
        Some(Ok(number))
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

    /// So many places that many are forgotten before they come again, and others come again at once.
    #[test]
    fn places_come_again_after_a_long_while() {
        let scratch = Scratch::new(None, Default::default());
        let mut welder = Welder::new(&scratch);
        let (mut seen, mut expected) = (HashMap::new(), Vec::new());
        let around = 3 * WINDOW / 2;
        for i in 0..4 * WINDOW {
            let place = match i % 4 {
                0 => i / 4 % around,
                1 => i / 4,
                2 => 7 * i % around,
                _ => 0,
            };
            welder.push([0.0, place as f64, 1.0]).expect("taken");
            let next = seen.len() as u64;
            expected.push(*seen.entry(place).or_insert(next));
        }
        let welded = welder.finish().expect("welded");
        assert_eq!(welded.vertices(), seen.len() as u64);
        let found: Vec<u64> = welded.numbers(&scratch).collect::<Result<_, _>>().expect("numbers");
        assert!(found == expected);
    }
}
