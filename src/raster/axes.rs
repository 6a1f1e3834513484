//! Whether a raster's geotransform puts columns and rows where the file lists them.
//!
//! netCDF and its kin list the coordinate of every column and row. GDAL makes a geotransform of them: also where they are
//! not even, if the first, middle and last steps look alike; and none where they are even but rounded, in which case it
//! shows rows in an order of its own. Samples would lie in wrong places either way.

use std::path::Path;

use gdal::Dataset;
use gdal::Metadata;
use gdal::raster::{Group, MDArray};

use super::RasterError;
use super::axis::{Axis, Deviation, Meaning};
use super::cube::Source;

/// How far, in cells, a column or row may be from where the file lists it.
const TOLERANCE: f64 = 0.1;

/// Compares the axes that the file lists with the geotransform. `name` is the one that GDAL has opened.
///
/// Cost: for netCDF, HDF5 and Zarr the file is opened once more, and the axes are read; memory does not depend on their length.
///
/// # Errors
/// [`RasterError::AxisElsewhere`], [`RasterError::UnusedAxes`].
pub(super) fn check(path: &Path, name: &Path, dataset: &Dataset) -> Result<(), RasterError> {
    let variable = dataset.rasterband(1).ok().and_then(|band| band.metadata_item("NETCDF_VARNAME", ""));
    let Some(source) = name.to_str().and_then(|name| Source::of(&dataset.driver().short_name(), name, variable)) else {
        return Ok(());
    };
    let (size, transform) = (dataset.raster_size(), dataset.geo_transform().ok());
    source.look(size, |groups, array| judge(path, &source, size, transform, groups, array)).unwrap_or(Ok(()))
}

fn judge(
    path: &Path,
    source: &Source,
    size: (usize, usize),
    transform: Option<[f64; 6]>,
    groups: &[&Group<'_>],
    array: &MDArray<'_>,
) -> Result<(), RasterError> {
    let Ok(dimensions) = array.dimensions() else { return Ok(()) };
    let [.., y, x] = &dimensions[..] else { return Ok(()) };
    let (columns, rows) = (Axis::find(groups, x), Axis::find(groups, y));
    let Some(transform) = transform else {
        return unused(path, source, size, columns.as_ref(), rows.as_ref());
    };
    let [x0, xp, xl, y0, yp, yl] = transform;
    if xl != 0.0 || yp != 0.0 {
        return Ok(());
    }
    for (what, axis, first, cell) in [("column", columns, x0, xp), ("row", rows, y0, yl)] {
        let Some(axis) = axis else { continue };
        let may_turn = what == "row" && source.turns_rows();
        if let Some(found) = axis.deviation(first + 0.5 * cell, cell, may_turn)
            && found.cells > TOLERANCE
        {
            let Deviation { index, listed, placed, cells } = found;
            let (path, axis) = (path.to_path_buf(), axis.name);
            return Err(RasterError::AxisElsewhere { path, what, axis, index, listed, placed, cells });
        }
    }
    Ok(())
}

/// No geotransform: refused where the file tells where its samples are.
fn unused(
    path: &Path,
    source: &Source,
    size: (usize, usize),
    columns: Option<&Axis<'_>>,
    rows: Option<&Axis<'_>>,
) -> Result<(), RasterError> {
    let known = |axis: Option<&Axis<'_>>| axis.is_some_and(|a| a.meaning != Meaning::Unknown);
    if !(known(columns) || known(rows) || columns.is_some() && rows.is_some()) {
        return Ok(());
    }
    let corners = columns.and_then(Axis::even).zip(rows.and_then(Axis::even)).map(|((west, dx), (first, dy))| {
        let (width, height) = (size.0 as f64, size.1 as f64);
        let (top, dy) = if source.turns_rows() { (first + (height - 1.0) * dy, -dy) } else { (first, dy) };
        let (left, top) = (west - 0.5 * dx, top - 0.5 * dy);
        [left, top, left + width * dx, top + height * dy]
    });
    let swapped = match (columns, rows) {
        (Some(c), Some(r)) if c.meaning.is_across() && r.meaning.is_along() => Some((c.name.clone(), r.name.clone())),
        _ => None,
    };
    let axes: Vec<String> = [columns, rows].into_iter().flatten().map(|axis| format!("'{}'", axis.name)).collect();
    Err(RasterError::UnusedAxes { path: path.to_path_buf(), axes: axes.join(" and "), corners, swapped })
}
