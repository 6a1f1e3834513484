//! The heights of a tile's samples, and those near samples that are missing: what tells of voids that nothing marks.

use crate::base::NEAR_VOID;
use crate::base::{Heights, Tile, Validity};

/// The least and the largest of some numbers; infinities where there are none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The least.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Extent {
    /// Of no numbers.
    pub const EMPTY: Extent = Extent { min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// With those of others.
    pub fn and(self, other: Extent) -> Extent {
        Extent { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.min > self.max
    }

    /// Whether another one reaches farther beyond this one than this one is wide.
    pub fn is_exceeded_by(self, other: Extent) -> bool {
        let width = self.max - self.min;
        !self.is_empty() && !other.is_empty() && (other.min < self.min - width || other.max > self.max + width)
    }
}

/// Heights of samples as the raster has them, those of bridged holes left out. They are the same whichever tiles share a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightStats {
    /// Those that are farther than three columns and rows from every missing sample, as far as tiles can tell.
    pub far: Extent,
    /// The others: near missing samples, or at a tile's rim, beyond which samples may be missing.
    pub near: Extent,
    /// Whether a sample counts as missing for its nearness to a mark that it does not equal.
    pub by_nearness: bool,
}

impl Default for HeightStats {
    fn default() -> Self {
        HeightStats { far: Extent::EMPTY, near: Extent::EMPTY, by_nearness: false }
    }
}

impl HeightStats {
    /// Of a tile.
    ///
    /// Cost: two passes over the samples, one more where some are missing; two bytes a sample then.
    pub fn of(tile: &Tile) -> HeightStats {
        let (far, near) = match &tile.heights {
            Heights::F32(heights) => extents(heights, tile),
            Heights::F64(heights) if !tile.eased.is_empty() => {
                let mut stored = heights.clone();
                tile.eased.iter().for_each(|eased| stored[eased.sample as usize] = eased.height);
                extents(&stored, tile)
            }
            Heights::F64(heights) => extents(heights, tile),
        };
        HeightStats { far, near, by_nearness: tile.validity.by_nearness() }
    }

    /// Of all samples.
    pub fn all(&self) -> Extent {
        self.far.and(self.near)
    }

    /// Whether a closer look may find something worth a warning, of a raster with voids: heights beside them that are far
    /// beyond all others, or samples that are missing by nearness alone. Never wrong where it says no.
    pub fn is_suspicious(&self) -> bool {
        self.by_nearness || self.far.is_exceeded_by(self.near)
    }

    /// Adds those of other samples.
    pub fn add(&mut self, other: &HeightStats) {
        self.far = self.far.and(other.far);
        self.near = self.near.and(other.near);
        self.by_nearness |= other.by_nearness;
    }
}

fn extents<H: Copy + Into<f64>>(heights: &[H], tile: &Tile) -> (Extent, Extent) {
    let (width, height) = (tile.width, tile.height);
    let rows = heights[..width * height].chunks_exact(width).enumerate();
    let inner = |row: usize| row >= NEAR_VOID && row + NEAR_VOID < height;
    let (mut far, mut near) = (Extent::EMPTY, Extent::EMPTY);
    if tile.validity.is_whole() {
        for (row, heights) in rows {
            let middle = if inner(row) {
                NEAR_VOID.min(width)..width.saturating_sub(NEAR_VOID).max(NEAR_VOID.min(width))
            } else {
                0..0
            };
            near = near.and(extent(&heights[..middle.start])).and(extent(&heights[middle.end..]));
            far = far.and(extent(&heights[middle]));
        }
        return (far, near);
    }
    let is_near = near_missing(&tile.validity, width, height);
    for (row, heights) in rows {
        for (column, height) in heights.iter().enumerate() {
            let (x, y) = (column as i32, row as i32);
            if !tile.validity.has_height(x, y) || tile.validity.is_outside(x, y) {
                continue;
            }
            let height = (*height).into();
            let one = Extent { min: height, max: height };
            let inside = inner(row) && column >= NEAR_VOID && column + NEAR_VOID < width;
            match inside && !is_near[row * width + column] {
                true => far = far.and(one),
                false => near = near.and(one),
            }
        }
    }
    (far, near)
}

fn extent<H: Copy + Into<f64>>(heights: &[H]) -> Extent {
    heights.iter().fold(Extent::EMPTY, |e, &h| {
        let h = h.into();
        Extent { min: if h < e.min { h } else { e.min }, max: if h > e.max { h } else { e.max } }
    })
}

/// Which samples have a missing one within [`NEAR_VOID`] columns and rows in the tile.
fn near_missing(validity: &Validity, width: usize, height: usize) -> Vec<bool> {
    let mut along = vec![false; width * height];
    for (row, flags) in along.chunks_exact_mut(width).enumerate() {
        let mut until = 0;
        for column in 0..width {
            if !validity.has_height(column as i32, row as i32) {
                let first = column.saturating_sub(NEAR_VOID).max(until);
                until = (column + NEAR_VOID + 1).min(width);
                flags[first.min(until)..until].fill(true);
            }
        }
    }
    let mut near = vec![false; width * height];
    for (row, flags) in along.chunks_exact(width).enumerate() {
        if flags.contains(&true) {
            for other in row.saturating_sub(NEAR_VOID)..(row + NEAR_VOID + 1).min(height) {
                let into = &mut near[other * width..(other + 1) * width];
                into.iter_mut().zip(flags).for_each(|(near, flag)| *near |= flag);
            }
        }
    }
    near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_and_near() {
        let heights: Vec<f32> = (0..400).map(|i| (i % 20) as f32).collect();
        let tile = Tile::from_heights(20, 20, Heights::F32(heights.clone()));
        let whole = HeightStats::of(&tile);
        assert_eq!((whole.far, whole.all()), (Extent { min: 3.0, max: 16.0 }, Extent { min: 0.0, max: 19.0 }));
        let small = HeightStats::of(&Tile::from_heights(4, 4, Heights::F32(heights[..16].to_vec())));
        assert!(small.far.is_empty());
        assert_eq!(small.near, Extent { min: 0.0, max: 15.0 });
        let (far, wild) = (whole.far, Extent { min: -11.0, max: 0.0 });
        assert!(far.is_exceeded_by(wild) && !far.is_exceeded_by(Extent { min: -10.0, max: 29.0 }));
        assert!(!Extent::EMPTY.is_exceeded_by(wild));
    }
}
