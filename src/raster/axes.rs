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
use crate::base::warning::{Warning, WarningCode};

/// How far, in cells, a column or row may be from where the file lists it.
const TOLERANCE: f64 = 0.1;

/// Compares the axes that the file lists with the geotransform. `name` is the one that GDAL has opened.
///
/// Cost: for netCDF, HDF5 and Zarr the file is opened once more, and the axes are read; memory does not depend on their length.
///
/// # Errors
/// [`RasterError::AxisElsewhere`], [`RasterError::UnusedAxes`].
pub(super) fn check(path: &Path, name: &Path, dataset: &Dataset) -> Result<Vec<Warning>, RasterError> {
    let variable = dataset.rasterband(1).ok().and_then(|band| band.metadata_item("NETCDF_VARNAME", ""));
    let Some(source) = name.to_str().and_then(|name| Source::of(&dataset.driver().short_name(), name, variable)) else {
        return Ok(Vec::new());
    };
    let size = dataset.raster_size();
    source.look(size, |groups, array| judge(path, &source, dataset, groups, array)).unwrap_or(Ok(Vec::new()))
}

fn judge(
    path: &Path,
    source: &Source,
    dataset: &Dataset,
    groups: &[&Group<'_>],
    array: &MDArray<'_>,
) -> Result<Vec<Warning>, RasterError> {
    let Ok(dimensions) = array.dimensions() else { return Ok(Vec::new()) };
    let [.., y, x] = &dimensions[..] else { return Ok(Vec::new()) };
    let (columns, rows) = (Axis::find(groups, x), Axis::find(groups, y));
    let Ok(transform) = dataset.geo_transform() else {
        unused(path, source, dataset.raster_size(), columns.as_ref(), rows.as_ref())?;
        return Ok(fill_value(path, dataset, array).into_iter().collect());
    };
    expect_in_place(path, source, transform, columns.as_ref(), rows.as_ref())?;
    let warning = |code, message| Warning { code, file: path.to_path_buf(), count: 1, message };
    let swapped = swapped(columns.as_ref(), rows.as_ref()).map(|(columns, rows)| {
        let message =
            format!("its columns are along '{columns}' and its rows along '{rows}', and x and y of the mesh likewise");
        warning(WarningCode::SwappedAxes, message)
    });
    let placed = [&columns, &rows].into_iter().flatten().any(|axis| axis.meaning != Meaning::Unknown);
    let unmapped = (placed && dataset.projection().is_empty()).then(|| {
        let message = "it lists coordinates and has no grid mapping: their CRS is unknown".to_string();
        warning(WarningCode::NoGridMapping, message)
    });
    Ok([swapped, unmapped, fill_value(path, dataset, array)].into_iter().flatten().collect())
}

/// Of Zarr, GDAL takes the value of chunks that were never written for the mark, and not what the file names as such.
fn fill_value(path: &Path, dataset: &Dataset, array: &MDArray<'_>) -> Option<Warning> {
    let tag = dataset.rasterband(1).ok()?.no_data_value();
    let named = (dataset.driver().short_name() == "Zarr").then(|| array.attribute("_FillValue").ok()).flatten()?;
    let named = named.datatype().class().is_numeric().then(|| named.read_as_f64())?;
    if tag.is_some_and(|tag| tag == named || tag.is_nan() && named.is_nan()) {
        return None;
    }
    let taken = tag.map_or("none".to_string(), |tag| tag.to_string());
    let message =
        format!("it names {named} as the value of missing samples (_FillValue), and GDAL takes {taken} for it");
    Some(Warning { code: WarningCode::FillValue, file: path.to_path_buf(), count: 1, message })
}

/// The axes' names, if columns run from south to north and rows from west to east.
fn swapped(columns: Option<&Axis<'_>>, rows: Option<&Axis<'_>>) -> Option<(String, String)> {
    let (columns, rows) = columns.zip(rows)?;
    let swapped = columns.meaning.is_across() && rows.meaning.is_along();
    swapped.then(|| (columns.name.clone(), rows.name.clone()))
}

fn expect_in_place(
    path: &Path,
    source: &Source,
    transform: [f64; 6],
    columns: Option<&Axis<'_>>,
    rows: Option<&Axis<'_>>,
) -> Result<(), RasterError> {
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
            let (path, axis) = (path.to_path_buf(), axis.name.clone());
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
    let name = |axis: Option<&Axis<'_>>| axis.map_or(String::new(), |axis| axis.name.clone());
    Err(RasterError::UnusedAxes {
        path: path.to_path_buf(),
        columns: name(columns),
        rows: name(rows),
        swapped: swapped(columns, rows).is_some(),
        corners: corners.map(Box::new),
    })
}
