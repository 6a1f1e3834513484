//! An image of any CRS, cut to a raster and brought into its CRS.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gdal::raster::{Buffer, ColorInterpretation, RasterCreationOptions, reproject};
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DriverManager, errors::GdalError};

use super::{About, reason};
use crate::base::Texture;

/// How well JPEG keeps an image, of 100.
const QUALITY: &str = "QUALITY=90";

/// Why an image cannot be laid over a mesh. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DrapeError {
    /// It cannot be opened, read or brought into the other CRS.
    #[error("{}: {what}: {reason}", path.display())]
    Gdal {
        /// The image.
        path: PathBuf,
        /// What failed.
        what: &'static str,
        /// What GDAL said.
        reason: String,
    },
    /// It is no image of 8 bits in colours or greys.
    #[error("{}: expected an image of {expected}, found {found}", path.display())]
    Kind {
        /// The image.
        path: PathBuf,
        /// What would have been right.
        expected: &'static str,
        /// What there is.
        found: String,
    },
    /// It does not say where it lies.
    #[error("{}: expected an image with a place on the map, found none", path.display())]
    Place {
        /// The image.
        path: PathBuf,
    },
    /// It lies elsewhere.
    #[error("{}: expected an image that lies over the raster, found none of it there", path.display())]
    Elsewhere {
        /// The image.
        path: PathBuf,
    },
}

/// Cuts an image to a rectangle of the map, in a CRS (its authority's code or WKT; `None` takes the image's own), and scales it so
/// that its longer side has at most `size` pixels, but no more than the image has there. What the image leaves free is white, as is what shines
/// through it where it has an opacity. Of further bands than red, green and blue nothing is used.
///
/// Memory: three bytes a pixel, twice.
///
/// # Errors
/// [`DrapeError`].
pub fn drape(path: &Path, extent: [f64; 4], crs: Option<&str>, size: usize) -> Result<Texture, DrapeError> {
    let _about = About::reading(path);
    let failed =
        |what| move |error: GdalError| DrapeError::Gdal { path: path.to_path_buf(), what, reason: reason(&error) };
    if path.is_absolute() && !path.starts_with("/vsi") || path.parent().is_some_and(|p| p == Path::new("")) {
        // GDAL has no words for it.
        if let Err(error) = path.metadata() {
            let (path, what) = (path.to_path_buf(), "cannot be opened as an image");
            return Err(DrapeError::Gdal { path, what, reason: error.to_string() });
        }
    }
    let source = Dataset::open(path).map_err(failed("cannot be opened as an image"))?;
    let bands = usable_bands(&source, path)?;
    if source.geo_transform().is_err() {
        return Err(DrapeError::Place { path: path.to_path_buf() });
    }
    let crs = match crs {
        Some(definition) => SpatialRef::from_definition(definition).ok(),
        None => source.spatial_ref().ok(),
    };
    let (width, height) = pixels(&source, extent, crs.as_ref(), size);
    let memory = DriverManager::get_driver_by_name("MEM").map_err(failed("no memory for it"))?;
    let mut target =
        memory.create_with_band_type::<u8, _>("", width, height, bands).map_err(failed("no memory for it"))?;
    let [left, bottom, right, top] = extent;
    let transform = [left, (right - left) / width as f64, 0.0, top, 0.0, (bottom - top) / height as f64];
    target.set_geo_transform(&transform).map_err(failed("cannot be placed"))?;
    if let Some(crs) = &crs {
        target.set_spatial_ref(crs).map_err(failed("cannot be placed"))?;
    }
    let marker = mark_all(&mut target, (width, height), bands).map_err(failed("no memory for it"))?;
    reproject(&source, &target).map_err(failed("cannot be brought into the CRS of the raster"))?;
    if is_untouched(&target, (width, height), marker).map_err(failed("cannot be read back"))? {
        return Err(DrapeError::Elsewhere { path: path.to_path_buf() });
    }
    let jpeg = encoded(&target).map_err(failed("cannot be compressed"))?;
    Ok(Texture { jpeg: Arc::new(jpeg), extent })
}

/// How many bands are used: one of greys, or three of colours.
fn usable_bands(source: &Dataset, path: &Path) -> Result<usize, DrapeError> {
    let wrong = |expected, found: String| Err(DrapeError::Kind { path: path.to_path_buf(), expected, found });
    let count = source.raster_count();
    if count == 0 {
        return wrong("one to four bands", "no bands".to_string());
    }
    let first = source.rasterband(1);
    if let Ok(band) = first {
        if band.color_interpretation() == ColorInterpretation::PaletteIndex {
            return wrong(
                "colours",
                "numbers of colours in a table (gdal_translate -expand rgb makes colours of them)".to_string(),
            );
        }
        if band.band_type() != gdal::raster::GdalDataType::UInt8 {
            let found =
                format!("samples of type {} (gdal_translate -ot Byte -scale makes bytes of them)", band.band_type());
            return wrong("8 bits", found);
        }
    }
    Ok(if count < 3 { 1 } else { 3 })
}

/// Pixels across and down: as many as the image has over the rectangle, if that is known, and no more than `size`.
fn pixels(
    source: &Dataset,
    [left, bottom, right, top]: [f64; 4],
    crs: Option<&SpatialRef>,
    size: usize,
) -> (usize, usize) {
    let (across, down) = (right - left, top - bottom);
    let own = source.spatial_ref().ok();
    let is_same = match (&own, crs) {
        (Some(own), Some(crs)) => own == crs,
        _ => true,
    };
    let fine = source.geo_transform().ok().filter(|_| is_same).map(|t| {
        let cell = t[1].hypot(t[4]).min(t[2].hypot(t[5]));
        across.max(down) / cell
    });
    let longer = fine.map_or(size as f64, |pixels| pixels.ceil().min(size as f64)).max(1.0);
    let side = |length: f64| ((longer * length / across.max(down)).round() as usize).clamp(1, size.max(1));
    (side(across), side(down))
}

/// Paints all white. The first band is what tells whether anything has been painted over: 254 nearly is white, too.
fn mark_all(target: &mut Dataset, size: (usize, usize), bands: usize) -> Result<u8, GdalError> {
    for number in 1..=bands {
        let mut white = Buffer::new(size, vec![if number == 1 { 254u8 } else { 255 }; size.0 * size.1]);
        target.rasterband(number)?.write((0, 0), size, &mut white)?;
    }
    Ok(254)
}

fn is_untouched(target: &Dataset, size: (usize, usize), marker: u8) -> Result<bool, GdalError> {
    let first = target.rasterband(1)?.read_as::<u8>((0, 0), size, size, None)?;
    Ok(first.data().iter().all(|value| *value == marker))
}

fn encoded(image: &Dataset) -> Result<Vec<u8>, GdalError> {
    let failed = |e: std::io::Error| GdalError::BadArgument(e.to_string());
    let folder = tempfile::tempdir().map_err(failed)?;
    let path = folder.path().join("texture.jpg");
    let options: RasterCreationOptions = [QUALITY].into_iter().collect();
    image.create_copy(&DriverManager::get_driver_by_name("JPEG")?, &path, &options)?.close()?;
    std::fs::read(&path).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red grows to the right, green downwards, over 100 × 50 units of UTM from (500000, 5200000).
    fn image(folder: &Path, bands: usize) -> PathBuf {
        let path = folder.join("image.tif");
        let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
        let mut dataset = driver.create_with_band_type::<u8, _>(&path, 100, 50, bands).expect("an image");
        dataset.set_geo_transform(&[500_000.0, 1.0, 0.0, 5_200_000.0, 0.0, -1.0]).expect("placed");
        dataset.set_spatial_ref(&SpatialRef::from_epsg(32633).expect("a CRS")).expect("placed");
        for number in 1..=bands {
            let value = |i: usize| [2 * (i % 100), 4 * (i / 100), 7, 200][number - 1] as u8;
            let mut buffer = Buffer::new((100, 50), (0..5000).map(value).collect());
            dataset.rasterband(number).expect("a band").write((0, 0), (100, 50), &mut buffer).expect("written");
        }
        dataset.close().expect("closed");
        path
    }

    fn pixels_of(texture: &Texture) -> (Vec<u8>, Vec<u8>, (usize, usize)) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("texture.jpg");
        std::fs::write(&path, texture.jpeg.as_slice()).expect("written");
        let dataset = Dataset::open(&path).expect("an image");
        let size = dataset.raster_size();
        let band = |number| {
            let band = dataset.rasterband(number).expect("a band");
            band.read_as::<u8>((0, 0), size, size, None).expect("read").data().to_vec()
        };
        (band(1), band(2), size)
    }

    #[test]
    fn cut_and_scaled() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = image(folder.path(), 3);
        let extent = [500_020.0, 5_199_960.0, 500_060.0, 5_199_980.0];
        let texture = drape(&path, extent, Some("EPSG:32633"), 4096).expect("a texture");
        assert_eq!(texture.extent, extent);
        let (red, green, size) = pixels_of(&texture);
        assert_eq!(size, (40, 20));
        // JPEG loses a little.
        assert!(red[0].abs_diff(40) < 8 && red[39].abs_diff(118) < 8, "{} {}", red[0], red[39]);
        assert!(green[0].abs_diff(80) < 8 && green[19 * 40].abs_diff(156) < 8, "{} {}", green[0], green[19 * 40]);
        assert_eq!(pixels_of(&drape(&path, extent, Some("EPSG:32633"), 10).expect("a texture")).2, (10, 5));
        assert_eq!(texture.at(500_030.0, 5_199_965.0), [0.25, 0.75]);
    }

    #[test]
    fn another_crs_is_transformed_and_white_shines_through() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = image(folder.path(), 4);
        Dataset::open_ex(
            &path,
            gdal::DatasetOptions { open_flags: gdal::GdalOpenFlags::GDAL_OF_UPDATE, ..Default::default() },
        )
        .and_then(|d| d.rasterband(4)?.set_color_interpretation(ColorInterpretation::AlphaBand))
        .expect("an opacity");
        // The middle of the image, in degrees.
        let texture = drape(&path, [15.0003, 46.9532, 15.0008, 46.9534], Some("EPSG:4326"), 64).expect("a texture");
        let (red, _, (width, height)) = pixels_of(&texture);
        assert_eq!((width, height), (64, 26));
        assert!(red[0] < red[width - 1] && red[0].abs_diff(91) < 8, "{} {}", red[0], red[width - 1]);
    }

    #[test]
    fn what_cannot_be_draped_is_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = image(folder.path(), 3);
        let far = drape(&path, [0.0, 0.0, 10.0, 10.0], Some("EPSG:32633"), 64).expect_err("elsewhere");
        assert!(matches!(far, DrapeError::Elsewhere { .. }), "{far}");
        let missing = drape(&folder.path().join("none.tif"), [0.0, 0.0, 1.0, 1.0], None, 64).expect_err("missing");
        assert!(missing.to_string().contains("none.tif: cannot be opened as an image"), "{missing}");
    }
}
