//! A polygon over a raster, and the samples of rows inside it.

use crate::base::Window;

/// A polygon with holes, in columns and rows with fractions, as its sides in no order: the even-odd rule needs none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Polygon {
    sides: Vec<[f64; 4]>,
    /// The lowest and the highest row of every [`GROUP`] sides.
    groups: Vec<(f64, f64)>,
}

/// Sides whose rows are looked at together: sides that follow each other are near each other.
const GROUP: usize = 256;

/// A side that crosses rows of a window.
struct Crossing {
    /// The first row it does not begin below of, and the first it ends above of.
    rows: std::ops::Range<i64>,
    side: [f64; 4],
}

impl Polygon {
    /// Adds a ring; whether the last place is the first once more does not matter.
    pub fn add_ring(&mut self, places: &[(f64, f64)]) {
        let next = places.iter().cycle().skip(1);
        // A level side crosses no row.
        let sides = places.iter().zip(next).filter(|(a, b)| a.1 != b.1).map(|(a, b)| [a.0, a.1, b.0, b.1]);
        self.sides.extend(sides);
        let rows = |sides: &[[f64; 4]]| {
            let all = sides.iter().flat_map(|s| [s[1], s[3]]);
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)))
        };
        self.groups = self.sides.chunks(GROUP).map(rows).collect();
    }

    pub(crate) fn sides(&self) -> u64 {
        self.sides.len() as u64
    }

    pub(crate) fn hash(&self, hasher: &mut crc32fast::Hasher) {
        hasher.update(&self.sides().to_le_bytes());
        self.sides.iter().flatten().for_each(|number| hasher.update(&number.to_le_bytes()));
    }

    /// Marks the samples of a window that are inside.
    pub(crate) fn mark(&self, window: Window, mask: &mut [bool]) {
        let (top, bottom) = (window.row as i64, (window.row + window.height) as i64);
        let mut crossings = Vec::new();
        for (sides, &(low, high)) in self.sides.chunks(GROUP).zip(&self.groups) {
            if high < top as f64 || low >= bottom as f64 {
                continue;
            }
            let reaching = sides.iter().map(|&side| Crossing { rows: rows(side), side });
            crossings.extend(reaching.filter(|c| c.rows.start < bottom && c.rows.end > top && !c.rows.is_empty()));
        }
        crossings.sort_unstable_by_key(|c| c.rows.start);
        let mut coming = crossings.iter().peekable();
        let mut active: Vec<&Crossing> = Vec::new();
        let mut columns = Vec::new();
        for row in top..bottom {
            active.retain(|c| c.rows.end > row);
            while let Some(crossing) = coming.next_if(|c| c.rows.start <= row) {
                active.extend((crossing.rows.end > row).then_some(crossing));
            }
            columns.clear();
            columns.extend(active.iter().map(|c| crossed_at(c.side, row as f64)));
            columns.sort_unstable_by(f64::total_cmp);
            let line = &mut mask[(row - top) as usize * window.width..][..window.width];
            for pair in columns.chunks_exact(2) {
                // Beyond a window on either side casts saturate, and ranges are empty.
                let from = (pair[0].ceil() as i64).max(window.column as i64) as usize - window.column;
                let to = (pair[1].ceil() as i64).min((window.column + window.width) as i64);
                let to = usize::try_from(to - window.column as i64).unwrap_or(0);
                if from < to {
                    line[from..to].fill(true);
                }
            }
        }
    }
}

/// The rows of samples that a side crosses: one at its upper end, none at its lower.
fn rows([_, y0, _, y1]: [f64; 4]) -> std::ops::Range<i64> {
    y0.min(y1).ceil() as i64..y0.max(y1).ceil() as i64
}

/// The column at which a side crosses a row; the same for both polygons beside it, whatever way around each has it.
fn crossed_at([x0, y0, x1, y1]: [f64; 4], row: f64) -> f64 {
    let ((x0, y0), (x1, y1)) = if y0 < y1 { ((x0, y0), (x1, y1)) } else { ((x1, y1), (x0, y0)) };
    x0 + (x1 - x0) * ((row - y0) / (y1 - y0))
}
