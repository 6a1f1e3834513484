//! Samples that are to become vertices.

use crate::base::Window;

/// What became of the points of a layer: `read` = `used` + `merged` + `outside`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct PointCounts {
    /// Points in the layer.
    pub read: u64,
    /// Samples they fell to.
    pub used: u64,
    /// Points that fell to a sample which another had taken.
    pub merged: u64,
    /// Points more than half a cell outside the samples' centres.
    pub outside: u64,
}

/// Samples of a raster, each once, in order of rows and of columns within a row.
///
/// Memory: 8 bytes per sample. The set is a function of the samples it was made from, not of their order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PointSet {
    /// Row in the upper half, column in the lower: their order is that of the rows, then that of the columns.
    places: Box<[u64]>,
}

/// A sample as a number.
pub(crate) fn key(column: usize, row: usize) -> u64 {
    (row as u64) << 32 | column as u64
}

fn place(key: u64) -> (usize, usize) {
    ((key & u64::from(u32::MAX)) as usize, (key >> 32) as usize)
}

impl PointSet {
    /// The set of these samples, given as column and row, in any order and any number of times.
    ///
    /// # Panics
    /// If a column or row does not fit 32 bits: GDAL's rasters have fewer.
    pub fn new(samples: impl IntoIterator<Item = (usize, usize)>) -> PointSet {
        let checked = |(column, row): (usize, usize)| {
            let fits = column <= u32::MAX as usize && row <= u32::MAX as usize;
            assert!(fits, "a sample at column {column}, row {row}");
            key(column, row)
        };
        PointSet::of_keys(samples.into_iter().map(checked).collect())
    }

    /// The set of samples given as [`key`]s.
    pub(crate) fn of_keys(mut places: Vec<u64>) -> PointSet {
        places.sort_unstable();
        places.dedup();
        PointSet { places: places.into_boxed_slice() }
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether a sample, given as column and row, is among them.
    pub fn has(&self, (column, row): (usize, usize)) -> bool {
        self.places.binary_search(&key(column, row)).is_ok()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The memory it holds.
    pub fn bytes(&self) -> u64 {
        size_of_val::<[u64]>(&self.places) as u64
    }

    /// All samples as column and row, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (usize, usize)> {
        self.places.iter().map(|&key| place(key))
    }

    /// The samples in a window as column and row **of the window**, in order of rows, then columns; replaces what is in
    /// `found`.
    ///
    /// Cost: O((samples found + rows of the window with samples of the set) · log n).
    pub fn within(&self, window: Window, found: &mut Vec<(usize, usize)>) {
        found.clear();
        let (right, bottom) = (window.column + window.width, window.row + window.height);
        let mut rest = self.from(window.column, window.row);
        while let Some((&first, after)) = rest.split_first() {
            let (column, row) = place(first);
            if row >= bottom {
                return;
            }
            rest = if column < window.column {
                self.from(window.column, row)
            } else if column >= right {
                self.from(window.column, row + 1)
            } else {
                found.push((column - window.column, row - window.row));
                after
            };
        }
    }

    /// The samples that do not come before this one.
    fn from(&self, column: usize, row: usize) -> &[u64] {
        let first = key(column, row);
        &self.places[self.places.partition_point(|&place| place < first)..]
    }

    /// A checksum of the samples, the same on every machine.
    pub fn checksum(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        self.places.iter().for_each(|place| hasher.update(&place.to_le_bytes()));
        hasher.finalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_window_has_what_a_look_at_every_sample_finds(
            mut samples in prop::collection::vec((0usize..40, 0usize..40), 0..200),
            (column, row) in (0usize..40, 0usize..40), (width, height) in (1usize..20, 1usize..20),
        ) {
            let set = PointSet::new(samples.iter().copied());
            samples.reverse();
            prop_assert_eq!(&set, &PointSet::new(samples.iter().copied()));
            let mut expected: Vec<(usize, usize)> = (0..height)
                .flat_map(|r| (0..width).map(move |c| (c, r)))
                .filter(|(c, r)| samples.contains(&(column + c, row + r)))
                .collect();
            expected.dedup();
            let mut found = vec![(99, 99)];
            set.within(Window { column, row, width, height }, &mut found);
            prop_assert_eq!(found, expected);
            prop_assert!(set.iter().is_sorted_by_key(|(c, r)| (r, c)));
        }
    }

    #[test]
    fn what_is_known_of_a_set() {
        let set = PointSet::new([(3, 1), (2, 1), (3, 1), (7, 0)]);
        assert_eq!(set.iter().collect::<Vec<_>>(), [(7, 0), (2, 1), (3, 1)]);
        assert_eq!((set.len(), set.bytes(), set.is_empty()), (3, 24, false));
        assert_ne!(set.checksum(), PointSet::new([(3, 1), (2, 1), (0, 7)]).checksum());
        assert!(PointSet::default().is_empty());
    }
}
