use super::tiles::{Job, Workspace};
use super::{Error, Params};
use crate::control::Control;
use crate::field::{Choice, Field, FieldOptions};
use crate::raster::Raster;
use crate::tiling::{TileGrid, TileId};

/// How many tiles each way are tried.
const TRIED: usize = 3;

/// How many samples a triangle will take, from up to nine tiles spread evenly over the raster: for estimates only.
///
/// The windows are read through GDAL, those of the importance raster too, so nothing has to be decoded beforehand. Cost:
/// nine tiles.
///
/// # Errors
/// [`Error`], as for the whole run: a raster that cannot be read is told of early.
pub fn probe_density(
    raster: &Raster,
    importance: Option<&Raster>,
    params: &Params,
    control: &Control<'_>,
) -> Result<f64, Error> {
    let options = FieldOptions { temp_dir: params.temp_dir.clone(), choice: Choice::Windows };
    probe_field(&Field::open_with_importance(raster, importance, &options, control)?, params, control)
}

/// Does what [`probe_density`] does, with a field that is open.
///
/// # Errors
/// As [`probe_density`].
pub fn probe_field(field: &Field, params: &Params, control: &Control<'_>) -> Result<f64, Error> {
    let grid = TileGrid::new(field.width(), field.height(), params.tile);
    let job = Job { field, params, grid, shifted: None, control, end: None };
    let mut workspace = Workspace::default();
    let (mut samples, mut triangles) = (0, 0);
    for row in spread(grid.rows()) {
        for column in spread(grid.columns()) {
            let counted = workspace.probe(&job, grid.index(TileId { column, row }))?;
            samples += counted.0;
            triangles += counted.1;
        }
    }
    // Where the tiles that were tried have no ground, it is as if they had one triangle.
    Ok(samples as f64 / triangles.max(1) as f64)
}

/// Up to [`TRIED`] places in the middle of even parts.
fn spread(count: usize) -> impl Iterator<Item = usize> {
    let tried = count.min(TRIED);
    (0..tried).map(move |i| (2 * i + 1) * count / (2 * tried))
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn places_are_different_and_inside() {
        assert_eq!(spread(1).collect::<Vec<_>>(), [0]);
        assert_eq!(spread(2).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(spread(3).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(spread(100).collect::<Vec<_>>(), [16, 50, 83]);
    }
}
