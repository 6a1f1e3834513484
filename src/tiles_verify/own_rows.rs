//! A window of the raster whose samples lie in rows of one latitude and columns of one longitude: most rasters in longitude and latitude.

use super::ellipsoid::{Ellipsoid, Meridian, Parallel};
use crate::base::Window;
use crate::pyramid::{Patch, PyramidError, SampleBlock, Samples};

/// Samples of a window on the ellipsoid, row by row; NaN where there is none.
pub(super) struct OnEllipsoid {
    /// In degrees.
    pub(super) lon: Vec<f64>,
    pub(super) lat: Vec<f64>,
    pub(super) heights: Vec<f64>,
}

/// Samples in rows and columns, without those that have none.
pub(super) struct InRows {
    /// Where its columns are on the grid, from 180° W, and from the first column of the raster's area.
    pub(super) columns: Vec<f64>,
    from_area: Vec<f64>,
    /// From 90° N.
    pub(super) rows: Vec<f64>,
    pub(super) meridians: Vec<Meridian>,
    pub(super) parallels: Vec<Parallel>,
    pub(super) heights: Vec<f64>,
    /// Which of them count.
    pub(super) counts: Vec<bool>,
}

/// What a place may be off its line of the grid by and count as on it, in cells.
pub(super) const ROUNDING: f64 = 1e-6;

impl InRows {
    /// `None` where they do not lie so.
    pub(super) fn of(found: &OnEllipsoid, window: Window, samples: &Samples, ellipsoid: &Ellipsoid) -> Option<InRows> {
        let Window { width, height, .. } = window;
        let (mut lons, mut lats) = (vec![f64::NAN; width], vec![f64::NAN; height]);
        for (i, (&lon, &lat)) in
            found.lon.iter().zip(&found.lat).enumerate().filter(|(i, _)| !found.heights[*i].is_nan())
        {
            let (column, row) = (&mut lons[i % width], &mut lats[i / width]);
            (*column, *row) = (if column.is_nan() { lon } else { *column }, if row.is_nan() { lat } else { *row });
            if (*column, *row) != (lon, lat) {
                return None;
            }
        }
        let (cell, area) = (samples.grid.cell(), samples.area);
        let from_area = |column: f64| (column - area.column as f64).rem_euclid(samples.grid.columns() as f64);
        let column = |lon: f64| (lon + 180.0).rem_euclid(360.0) / cell;
        let is_known = |i: &usize| from_area(column(lons[*i])) < area.width as f64;
        let across: Vec<usize> = (0..width).filter(is_known).collect();
        let mut down: Vec<usize> = (0..height).filter(|&i| !lats[i].is_nan()).collect();
        if down.first().zip(down.last()).is_some_and(|(&first, &last)| lats[first] < lats[last]) {
            down.reverse();
        }
        let mut of = InRows {
            columns: across.iter().map(|&i| column(lons[i])).collect(),
            from_area: across.iter().map(|&i| from_area(column(lons[i]))).collect(),
            rows: down.iter().map(|&i| (90.0 - lats[i]) / cell).collect(),
            meridians: across.iter().map(|&i| Meridian::of(lons[i])).collect(),
            parallels: down.iter().map(|&i| ellipsoid.parallel(lats[i])).collect(),
            heights: Vec::with_capacity(across.len() * down.len()),
            counts: Vec::new(),
        };
        let ascends = |places: &[f64]| places.windows(2).all(|pair| pair[0] < pair[1]);
        if !ascends(&of.from_area) || !ascends(&of.rows) {
            return None;
        }
        for row in down {
            let heights = &found.heights[row * width..];
            of.heights.extend(across.iter().map(|&column| heights[column]));
        }
        of.counts = of.heights.iter().map(|height| !height.is_nan()).collect();
        Some(of)
    }

    /// Where it begins and ends on the grid, in columns of the area and rows; `None` if it has no samples.
    fn ends(&self) -> Option<[(f64, f64); 2]> {
        let ends = |places: &[f64]| Some((*places.first()?, *places.last()?));
        Some([ends(&self.from_area)?, ends(&self.rows)?])
    }

    /// Only samples count that have samples of the grid all around; `false` if those of all are more than `most`.
    pub(super) fn keep_inside(
        &mut self,
        samples: &Samples,
        around: &mut SampleBlock,
        most: usize,
    ) -> Result<bool, PyramidError> {
        let Some(ends) = self.ends() else { return Ok(true) };
        let first = ends.map(|(first, _)| first.floor());
        let size = [0, 1].map(|k| (ends[k].1.floor() - first[k]) as usize + 2);
        if size[0] * size[1] > most && self.heights.len() > 1 {
            return Ok(false);
        }
        let (column, row) = (samples.area.column + first[0] as i64, first[1] as i64);
        samples.read(Patch { column, row, width: size[0], height: size[1], step: 1 }, around)?;
        if !around.inside.contains(&false) {
            return Ok(true);
        }
        // One on a line of the grid needs no other.
        let lines = |places: &[f64], first: f64| -> Vec<(usize, usize)> {
            let on = |at: &f64| ((at - first + ROUNDING).floor() as usize, (at - first - ROUNDING).ceil() as usize);
            places.iter().map(on).collect()
        };
        let (columns, rows) = (lines(&self.from_area, first[0]), lines(&self.rows, first[1]));
        for (counts, &(top, bottom)) in self.counts.chunks_exact_mut(columns.len()).zip(&rows) {
            for (counts, &(left, right)) in counts.iter_mut().zip(&columns) {
                let mut around = (top..=bottom).map(|row| &around.inside[row * size[0] + left..=row * size[0] + right]);
                *counts &= around.all(|inside| !inside.contains(&false));
            }
        }
        Ok(true)
    }
}
