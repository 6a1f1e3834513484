//! Why samples cannot be had.

use std::path::PathBuf;

use crate::base::Window;
use crate::base::decimal::Decimal;

/// What is said where a source of samples fails and says nothing.
pub(crate) const SILENT: &str = "GDAL gave no reason";

/// Why a raster cannot be used, or could not be read. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RasterError {
    /// The file does not exist, is not readable, or no GDAL driver takes it.
    #[error("{}: cannot be opened as a raster: {reason}", path.display())]
    Open {
        /// The raster.
        path: PathBuf,
        /// What GDAL said.
        reason: String,
    },
    /// The file holds no raster band: a vector file, or a container of subdatasets.
    #[error("{}: expected a raster band, found none{hint}", path.display())]
    NoBands {
        /// The raster.
        path: PathBuf,
        /// The subdatasets, where there are some.
        hint: String,
    },
    /// The band asked for is not there.
    #[error("{}: expected band {band}, found bands 1 to {count}", path.display())]
    NoSuchBand {
        /// The raster.
        path: PathBuf,
        /// The band asked for, from 1.
        band: usize,
        /// How many there are.
        count: usize,
    },
    /// The samples are not real numbers.
    #[error("{}: band {band}: expected integer or real samples, found {found}", path.display())]
    SampleType {
        /// The raster.
        path: PathBuf,
        /// The band, from 1.
        band: usize,
        /// GDAL's name of the type.
        found: String,
    },
    /// No sample can be equal to the nodata value that was given.
    #[error("{}: expected a nodata value that a sample of type {sample_type} can hold, found {found}", path.display())]
    NodataValue {
        /// The raster.
        path: PathBuf,
        /// The value.
        found: String,
        /// The type of the samples.
        sample_type: &'static str,
    },
    /// The band holds colours, or indices into a table of them.
    #[error("{}: band {band}: expected heights, found {found}", path.display())]
    Picture {
        /// The raster.
        path: PathBuf,
        /// The band, from 1.
        band: usize,
        /// What it holds.
        found: String,
        /// The first band that is no colour.
        other: Option<usize>,
        /// Whether bands 1 to 3 are bytes, so that heights may be encoded in them.
        encoded: bool,
    },
    /// There are no three bands of bytes for encoded heights.
    #[error("{}: expected three bands of bytes with {encoding} heights, found {found}", path.display())]
    NotEncoded {
        /// The raster.
        path: PathBuf,
        /// The encoding.
        encoding: &'static str,
        /// What there is instead.
        found: String,
    },
    /// Rows are too long to be held in memory.
    #[error("{}: expected at most {limit} samples across, found {found}", path.display())]
    Wide {
        /// The raster.
        path: PathBuf,
        /// The most that can be held.
        limit: usize,
        /// How many there are.
        found: usize,
    },
    /// A surface needs two samples each way.
    #[error("{}: expected at least 2 × 2 samples, found {width} × {height}: there is no surface to triangulate", path.display())]
    TooSmall {
        /// The raster.
        path: PathBuf,
        /// Samples across.
        width: usize,
        /// Samples down.
        height: usize,
    },
    /// There are not as many values in memory as there are samples.
    #[error("{}: expected the bytes of {width} × {height} samples of type {sample_type}, found {found}", path.display())]
    Length {
        /// What messages call it.
        path: PathBuf,
        /// Samples across.
        width: usize,
        /// Samples down.
        height: usize,
        /// The type of the samples.
        sample_type: &'static str,
        /// How many bytes there are.
        found: usize,
    },
    /// A window reaches out of the raster, or has no surface.
    #[error(
        "{}: expected a window of at least 2 × 2 of the raster's {width} × {height} samples, found {} × {} from column {}, \
         row {} on",
        path.display(), window.width, window.height, window.column, window.row
    )]
    Window {
        /// The raster.
        path: PathBuf,
        /// The window.
        window: Window,
        /// Samples across the raster.
        width: usize,
        /// Samples down.
        height: usize,
    },
    /// The raster is georeferenced, but not by a geotransform.
    #[error("{}: expected a geotransform, or no georeferencing at all, found {found}", path.display())]
    NotAffine {
        /// The raster.
        path: PathBuf,
        /// What there is instead.
        found: String,
    },
    /// The geotransform puts a column or row elsewhere than the file says: its axis is uneven, most often.
    #[error(
        "{}: expected columns and rows within a tenth of a cell of where the file's axes list them, found {what} {index}, which \
         '{axis}' lists at {listed}, put at {placed} by GDAL's geotransform: {cells:.1} cells away",
        path.display()
    )]
    AxisElsewhere {
        /// The raster.
        path: PathBuf,
        /// "column" or "row".
        what: &'static str,
        /// The name of the axis in the file.
        axis: String,
        /// The column or row that is farthest away, as the file counts them, from 0.
        index: usize,
        /// Where the file lists it.
        listed: f64,
        /// Where the geotransform puts it.
        placed: f64,
        /// The distance, in cells.
        cells: f64,
    },
    /// The file says where columns and rows are, and GDAL makes no geotransform of it.
    #[error(
        "{}: expected a geotransform, as the file lists coordinates of columns ('{columns}') and rows ('{rows}'), found none: GDAL \
         makes none of them, and may show the rows upside down",
        path.display()
    )]
    UnusedAxes {
        /// The raster.
        path: PathBuf,
        /// The name of the axis that lists columns; empty where none does.
        columns: String,
        /// The name of the axis that lists rows; empty where none does.
        rows: String,
        /// Whether columns run from south to north and rows from west to east.
        swapped: bool,
        /// The left, top, right and bottom edge of the raster as GDAL shows it, if columns and rows are even.
        corners: Option<Box<[f64; 4]>>,
    },
    /// There is no way from the CRS of a bounding box to the raster's.
    #[error("{}: the box cannot be transformed from {from} to the raster's CRS {to}: {reason}", path.display())]
    BoxCrs {
        /// The raster.
        path: PathBuf,
        /// The CRS of the box.
        from: String,
        /// The raster's.
        to: String,
        /// What GDAL said.
        reason: String,
    },
    /// A bounding box holds no surface.
    #[error(
        "{}: expected a box with at least 2 × 2 samples inside, found {columns} × {rows}; samples lie from x {}, y {} to \
         x {}, y {}, CRS {crs}",
        path.display(), extent[0], extent[1], extent[2], extent[3]
    )]
    EmptyBox {
        /// The raster.
        path: PathBuf,
        /// Columns in the box.
        columns: usize,
        /// Rows in the box.
        rows: usize,
        /// The least x and y of the raster's samples, and the largest.
        extent: [f64; 4],
        /// The raster's CRS.
        crs: String,
    },
    /// A vertex of a cutline is nowhere on the raster's map.
    #[error("{}: expected finite coordinates of a cutline, found {x}, {y}", path.display())]
    CutlinePlace {
        /// The raster.
        path: PathBuf,
        /// Its x.
        x: f64,
        /// Its y.
        y: f64,
    },
    /// The geotransform cannot place vertices, or not finely enough to find them again.
    #[error("{}: the geotransform {coefficients:?} cannot place vertices: {reason}", path.display())]
    GeoTransform {
        /// The raster.
        path: PathBuf,
        /// The six coefficients, in GDAL's order.
        coefficients: [f64; 6],
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A scale or offset tag is not a number, or is zero.
    #[error("{}: expected a finite scale other than 0 and a finite offset, found scale {}, offset {}", path.display(), Decimal(*scale), Decimal(*offset))]
    Scaling {
        /// The raster.
        path: PathBuf,
        /// The scale tag.
        scale: f64,
        /// The offset tag.
        offset: f64,
    },
    /// A window of samples could not be read: a truncated or damaged file, most often.
    #[error("{}: reading {width} × {height} samples at column {column}, row {row} failed: {reason}", path.display())]
    Read {
        /// The raster.
        path: PathBuf,
        /// The window's first column.
        column: usize,
        /// The window's first row.
        row: usize,
        /// Samples across.
        width: usize,
        /// Samples down.
        height: usize,
        /// What GDAL said.
        reason: String,
    },
    /// The raster is not what it was when the run, or the run that is continued, began.
    #[error("{}: the raster has changed: expected {what} {expected}, found {found}", path.display())]
    Changed {
        /// The raster.
        path: PathBuf,
        /// What differs.
        what: String,
        /// What it was.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A layer of points or polygons is not what it was when the run began.
    #[error("{}: the layer has changed: expected {what} {expected}, found {found}", path.display())]
    LayerChanged {
        /// The layer's file.
        path: PathBuf,
        /// What differs.
        what: String,
        /// What it was.
        expected: String,
        /// What it is.
        found: String,
    },
    /// Two rasters that are to have the same samples do not.
    #[error("{}: expected the grid of {}, {what} {expected}, found {what} {found}", path.display(), of.display())]
    OtherGrid {
        /// The raster.
        path: PathBuf,
        /// The raster whose grid it is to have.
        of: PathBuf,
        /// What differs.
        what: &'static str,
        /// What it is to be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// Anything else GDAL refuses to tell about the file.
    #[error("{}: {what}: {reason}", path.display())]
    Gdal {
        /// The raster.
        path: PathBuf,
        /// What was asked.
        what: &'static str,
        /// What GDAL said.
        reason: String,
    },
}

impl RasterError {
    /// Whether an input is not what it was.
    pub fn is_change(&self) -> bool {
        matches!(self, RasterError::Changed { .. } | RasterError::LayerChanged { .. })
    }

    /// Whether samples could not be read, and nobody said why.
    pub fn is_silent(&self) -> bool {
        matches!(self, RasterError::Read { reason, .. } | RasterError::Gdal { reason, .. } if reason.starts_with(SILENT))
    }
}
