//! Heights of lakes: of a field, or of the samples on their rims.

use std::path::Path;

use super::RunError;
use super::lines::UnusableLines;
use crate::base::control::CancelToken;
use crate::base::{Band, LineKind, Polylines, Window};
use crate::kernel::breaklines::LinesError;
use crate::verify::HeightReader;

/// Which height a lake has.
#[derive(Debug, Clone, PartialEq)]
pub enum LakeHeight {
    /// The least of the samples on its rim: those nearest to its outline, at steps of half a cell or less.
    Min,
    /// The median of these; of two the lower.
    Median,
    /// That of a field of the layer.
    Field(String),
    /// One for each feature.
    Each(Vec<f64>),
}

impl LakeHeight {
    /// What it is called.
    pub fn name(&self) -> String {
        match self {
            LakeHeight::Min => "min".to_string(),
            LakeHeight::Median => "median".to_string(),
            LakeHeight::Field(name) => format!("field:{name}"),
            LakeHeight::Each(_) => "given".to_string(),
        }
    }
}

/// Outlines of lakes, with the height of each lake along its outlines; `path` is what messages call them.
///
/// # Errors
/// [`RunError`]: samples cannot be read, a lake has none with a height on its rim, outlines are too long.
pub(super) fn with_levels(
    outlines: Polylines,
    height: &LakeHeight,
    (band, path): (&Band, &Path),
    cancel: &CancelToken,
) -> Result<Polylines, RunError> {
    let mut heights: Vec<Vec<f64>> = Vec::new();
    let lines = outlines.lines();
    let mut from = 0;
    let mut number = 0;
    while from < lines.len() {
        cancel.check().map_err(crate::job::Error::from)?;
        let feature = outlines.feature(from);
        let count = (from..lines.len()).take_while(|&line| outlines.feature(line) == feature).count();
        let rings = &lines[from..from + count];
        let level = match height {
            LakeHeight::Each(each) => each.get(number).copied(),
            LakeHeight::Field(_) => outlines.heights().and_then(|heights| heights[from].first().copied()),
            LakeHeight::Min | LakeHeight::Median => {
                let mut found = on_rim(rings, (band, path))?;
                found.sort_unstable_by(f64::total_cmp);
                let at = if *height == LakeHeight::Min { 0 } else { found.len().saturating_sub(1) / 2 };
                found.get(at).copied()
            }
        };
        let is_outside = rings.iter().all(|ring| samples_beside(ring, band).map_or(true, |samples| samples.is_empty()));
        // Nothing is made of what lies elsewhere.
        let level = level.or(is_outside.then_some(0.0));
        let level = level.ok_or_else(|| UnusableLines::NoLevel { path: path.to_path_buf(), feature })?;
        heights.extend(rings.iter().map(|ring| vec![level; ring.len()]));
        (from, number) = (from + count, number + 1);
    }
    Ok(outlines.clone().with_heights(heights))
}

/// The heights of the samples on a rim, those without left out.
fn on_rim(rings: &[Vec<(f64, f64)>], (band, path): (&Band, &Path)) -> Result<Vec<f64>, RunError> {
    let mut samples = Vec::new();
    for ring in rings {
        let found = samples_beside(ring, band).map_err(|error| UnusableLines::Lattice {
            path: path.to_path_buf(),
            kind: LineKind::Lakes,
            error,
        })?;
        samples.extend(found);
    }
    samples.sort_unstable();
    samples.dedup();
    let mut reader = HeightReader::new(band);
    let (mut heights, mut line) = (Vec::with_capacity(samples.len()), Vec::new());
    for of_row in samples.chunk_by(|a, b| a.0 == b.0) {
        let (row, first, last) = (of_row[0].0, of_row[0].1, of_row[of_row.len() - 1].1);
        let window = Window { column: first, row, width: last - first + 1, height: 1 };
        line.resize(window.len(), 0.0);
        reader.read(window, &mut line).map_err(crate::job::Error::from)?;
        heights.extend(of_row.iter().map(|(_, column)| line[column - first]).filter(|height| height.is_finite()));
    }
    Ok(heights)
}

/// The samples nearest to points of a ring that are half a cell apart at the most, by row and column; there may be some twice.
fn samples_beside(ring: &[(f64, f64)], band: &Band) -> Result<Vec<(usize, usize)>, LinesError> {
    let mut samples = Vec::new();
    let mut steps = 0.0;
    for side in ring.windows(2) {
        let [(ax, ay), (bx, by)] = [side[0], side[1]];
        let count = ((bx - ax).abs().max((by - ay).abs()) * 2.0).ceil().max(1.0);
        steps += count;
        if steps > Polylines::MAX_SEGMENTS as f64 {
            return Err(LinesError::TooMany);
        }
        for step in 0..=count as u64 {
            let share = step as f64 / count;
            let (x, y) = ((ax + (bx - ax) * share + 0.5).floor(), (ay + (by - ay) * share + 0.5).floor());
            if (0.0..band.width() as f64).contains(&x) && (0.0..band.height() as f64).contains(&y) {
                samples.push((y as usize, x as usize));
            }
        }
    }
    Ok(samples)
}
