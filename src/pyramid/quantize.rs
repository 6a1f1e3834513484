//! Places and heights on the lattice that quantized-mesh has.
//!
//! **Places.** A tile's column i of n becomes u = ⌊i·32767/n + ½⌋: a function of the line alone, so that tiles of a level agree.
//!
//! **Heights.** A tile's heights are multiples of a step, a power of two from its own relief, so that sums and products are
//! exact: the least and the greatest height that its header names are 32767 steps apart, both on the lattice and exact in single
//! precision. A vertex on the border lies on the coarser step of the tiles that share it, which is on the lattice of the other.
//! So all of them name the same number.

use std::collections::BTreeMap;

use super::grid::TileKey;

/// The largest coordinate.
pub(super) const SPAN: i64 = 32767;

/// The coordinate of a sample on a side of `cells` cells.
pub(super) fn coordinate(at: i64, cells: i64) -> i64 {
    (at * SPAN * 2 + cells) / (2 * cells)
}

/// The places of samples that become vertices are multiples of this, so that no two have one coordinate.
pub(super) fn snap(cells: i64) -> i64 {
    (cells / 16384).max(1)
}

/// The least and the greatest height of a tile's samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Relief {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Whether the tile may have marked voids, whose height is not among these.
    pub(super) has_void: bool,
}

impl Relief {
    pub(super) fn of(height: f64) -> Relief {
        Relief { low: height, high: height, has_void: false }
    }

    pub(super) fn with(self, other: Relief) -> Relief {
        let has_void = self.has_void || other.has_void;
        Relief { low: self.low.min(other.low), high: self.high.max(other.high), has_void }
    }
}

/// The least step, an eighth of a metre as an exponent, with which no tile's least and greatest height are less than 4,095.875 m
/// apart: from 4,095 m on CesiumJS keeps a tile's vertices as floats and does not round them to 12 bits.
pub(super) const UNROUNDED: i32 = -3;

/// The steps of all tiles of a level, as exponents of two.
pub(super) struct Steps {
    coarsest: i32,
    /// Whether a least step was asked for, and decides the coarsest.
    are_fine: bool,
    of: BTreeMap<TileKey, (i32, Relief)>,
}

/// The heights of one tile: multiples of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HeightLattice {
    /// In metres.
    pub(super) step: f64,
    /// The least height, in steps.
    pub(super) least: i64,
}

impl HeightLattice {
    pub(super) fn minimum(&self) -> f64 {
        self.least as f64 * self.step
    }

    pub(super) fn maximum(&self) -> f64 {
        (self.least + SPAN) as f64 * self.step
    }

    /// The nearest multiple of a step that is not finer, in steps above the least.
    pub(super) fn quantize(&self, height: f64, step: f64) -> i64 {
        let multiple = (height / step).round() as i64;
        multiple * (step / self.step) as i64 - self.least
    }

    /// The height that a reader finds.
    pub(super) fn height(&self, quantum: i64) -> f64 {
        (self.least + quantum) as f64 * self.step
    }
}

/// 2ᵉ, for exponents of normal numbers.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// The least exponent e for which 2ᵉ is not below a number above 0.
fn exponent_above(number: f64) -> i32 {
    let mut exponent = -60;
    while power_of_two(exponent) < number {
        exponent += 1;
    }
    exponent
}

impl Steps {
    /// From the relief of all tiles of a level; steps are not below the `least`.
    pub(super) fn of(reliefs: &BTreeMap<TileKey, Relief>, least: Option<i32>) -> Steps {
        let widest = reliefs.values().map(|r| r.high - r.low).fold(0.0, f64::max);
        let highest = reliefs.values().map(|r| r.high.abs().max(r.low.abs())).fold(1.0, f64::max);
        // Single precision has 24 bits: heights have 23 of them, so that the padding below has room.
        let floor = exponent_above(highest / f64::from(1 << 23)).max(least.unwrap_or(i32::MIN));
        // Vertices on a border may be moved by half of the coarsest step: four of them are kept free.
        let coarsest = exponent_above(widest / (SPAN - 4) as f64).max(floor);
        let padding = 4.0 * power_of_two(coarsest);
        let exponent = |r: &Relief| exponent_above((r.high - r.low + padding) / SPAN as f64).max(floor);
        let are_fine = least.is_some_and(|least| coarsest <= least);
        Steps {
            coarsest,
            are_fine,
            of: reliefs.iter().map(|(key, relief)| (*key, (exponent(relief), *relief))).collect(),
        }
    }

    /// The coarsest step of the level.
    pub(super) fn coarsest(&self) -> f64 {
        power_of_two(self.coarsest)
    }

    /// Whether the coarsest step is no coarser than the least that was asked for: without that all might be finer.
    pub(super) fn are_fine(&self) -> bool {
        self.are_fine
    }

    /// The lattice of a tile's heights.
    pub(super) fn lattice(&self, tile: TileKey) -> HeightLattice {
        let (exponent, relief) = self.of[&tile];
        let step = power_of_two(exponent);
        let top = ((relief.high + 0.5 * self.coarsest()) / step).ceil() as i64;
        HeightLattice { step, least: top - SPAN }
    }

    /// The step of heights on the border of a tile: for −1, 0, 1 east and north, the coarsest of all that share the side
    /// or corner.
    pub(super) fn on_border(&self, tile: TileKey, east: i32, north: i32) -> f64 {
        let shared = [(0, 0), (east, 0), (0, north), (east, north)];
        let tiles = shared.into_iter().filter_map(|(e, n)| tile.neighbour(e, n));
        let exponents = tiles.filter_map(|key| self.of.get(&key)).map(|(exponent, _)| *exponent);
        power_of_two(exponents.max().expect("the tile itself"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn coordinates_are_rounded_to_the_nearest() {
        assert_eq!((coordinate(0, 128), coordinate(128, 128), coordinate(64, 128)), (0, 32767, 16384));
        for cells in [2, 8, 128, 4096, 16384] {
            let all: Vec<i64> = (0..=cells).map(|i| coordinate(i, cells)).collect();
            assert!(all.windows(2).all(|c| c[0] < c[1]), "{cells}");
            assert!((0..=cells).all(|i| (all[i as usize] * cells - i * SPAN).abs() * 2 <= cells));
        }
        // Beyond that, those of multiples of the snap differ.
        let cells = 1 << 20;
        let all: Vec<i64> = (0..=cells).step_by(snap(cells) as usize).map(|i| coordinate(i, cells)).collect();
        assert!(all.windows(2).all(|c| c[0] < c[1]));
    }

    proptest! {
        #[test]
        fn shared_vertices_have_one_height_and_all_are_exact_in_single_precision(
            reliefs in prop::collection::vec((-9000.0f64..9000.0, prop_oneof![Just(0.0), 0.0f64..1e-3, 0.0f64..9000.0]), 9),
            share in 0.0f64..1.0,
            unrounded: bool,
        ) {
            let key = |i: usize| TileKey { level: 4, x: 3 + i as u32 % 3, y: 5 + i as u32 / 3 };
            let all = reliefs.iter().enumerate().map(|(i, &(low, range))| (key(i), Relief { low, high: low + range, has_void: false }));
            let all: BTreeMap<TileKey, Relief> = all.collect();
            let steps = Steps::of(&all, unrounded.then_some(UNROUNDED));
            for (&tile, relief) in &all {
                let lattice = steps.lattice(tile);
                prop_assert!(!unrounded || lattice.maximum() - lattice.minimum() >= 4095.875);
                for exact in [lattice.minimum(), lattice.maximum()] {
                    prop_assert_eq!(f64::from(exact as f32), exact);
                }
                let height = relief.low + share * (relief.high - relief.low);
                for (east, north) in [(0, 0), (-1, 0), (1, 1), (0, -1), (-1, 1)] {
                    let step = steps.on_border(tile, east, north);
                    let quantum = lattice.quantize(height, step);
                    prop_assert!((0..=SPAN).contains(&quantum), "{} of {:?}", quantum, lattice);
                    prop_assert!((lattice.height(quantum) - height).abs() <= 0.5 * step);
                    let Some(other) = tile.neighbour(east, north).filter(|other| all.contains_key(other)) else { continue };
                    prop_assert_eq!(steps.on_border(other, -east, -north), step);
                    let theirs = steps.lattice(other);
                    if relief.low >= all[&other].low && relief.high <= all[&other].high {
                        let quantum = theirs.quantize(height, step);
                        prop_assert_eq!(theirs.height(quantum), lattice.height(lattice.quantize(height, step)));
                    }
                }
            }
        }
    }
}
