//! Rasters for tests.

use std::path::Path;

use gdal::raster::{Buffer, GdalDataType, GdalType, RasterCreationOptions};
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DriverManager};

use super::Folder;

/// The type a raster's samples are stored in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Byte,
    SignedByte,
    UInt16,
    Int16,
    UInt32,
    Int32,
    UInt64,
    Int64,
    Float32,
    Float64,
}

/// A small raster to be made: hills by default, whole numbers between 30 and 120 that every type holds.
#[derive(Clone)]
pub(crate) struct Dem {
    width: usize,
    height: usize,
    kind: Kind,
    bands: usize,
    driver: &'static str,
    options: Vec<String>,
    nodata: Option<f64>,
    scaling: Option<(f64, f64)>,
    geo_transform: Option<[f64; 6]>,
    epsg: Option<u32>,
    heights: fn(usize, usize) -> f64,
    /// The values of the bands from the second on, by band, column and row; else they are as the first.
    others: Option<fn(usize, usize, usize) -> f64>,
}

/// Hills of some 40 samples' width.
pub(crate) fn hills(column: usize, row: usize) -> f64 {
    let (x, y) = (column as f64, row as f64);
    (75.0 + 30.0 * (x / 7.0).sin() * (y / 9.0).cos() + 15.0 * ((x + y) / 3.0).sin()).round()
}

impl Dem {
    pub(crate) fn new(width: usize, height: usize) -> Dem {
        Dem {
            width,
            height,
            kind: Kind::Int16,
            bands: 1,
            driver: "GTiff",
            options: Vec::new(),
            nodata: None,
            scaling: None,
            geo_transform: None,
            epsg: None,
            heights: hills,
            others: None,
        }
    }

    pub(crate) fn kind(self, kind: Kind) -> Dem {
        Dem { kind, ..self }
    }

    pub(crate) fn bands(self, bands: usize) -> Dem {
        Dem { bands, ..self }
    }

    pub(crate) fn driver(self, driver: &'static str) -> Dem {
        Dem { driver, ..self }
    }

    pub(crate) fn heights(self, heights: fn(usize, usize) -> f64) -> Dem {
        Dem { heights, ..self }
    }

    /// The bands from the second on, by band, column and row.
    pub(crate) fn others(self, values: fn(usize, usize, usize) -> f64) -> Dem {
        Dem { others: Some(values), ..self }
    }

    /// The tag; whether samples carry the value is up to `heights`.
    pub(crate) fn nodata(self, value: f64) -> Dem {
        Dem { nodata: Some(value), ..self }
    }

    pub(crate) fn scaling(self, scale: f64, offset: f64) -> Dem {
        Dem { scaling: Some((scale, offset)), ..self }
    }

    /// Ten metres a cell, north up, in UTM zone 33 north.
    pub(crate) fn on_the_map(self) -> Dem {
        Dem { epsg: Some(32633), ..self.geo_transform([500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0]) }
    }

    pub(crate) fn geo_transform(self, coefficients: [f64; 6]) -> Dem {
        Dem { geo_transform: Some(coefficients), ..self }
    }

    pub(crate) fn epsg(self, code: u32) -> Dem {
        Dem { epsg: Some(code), ..self }
    }

    /// A creation option of the driver, `NAME=VALUE`.
    pub(crate) fn option(mut self, option: &str) -> Dem {
        self.options.push(option.to_string());
        self
    }

    pub(crate) fn tiled(self, side: usize) -> Dem {
        self.option("TILED=YES").option(&format!("BLOCKXSIZE={side}")).option(&format!("BLOCKYSIZE={side}"))
    }

    pub(crate) fn stripped(self, rows: usize) -> Dem {
        self.option(&format!("BLOCKYSIZE={rows}"))
    }

    pub(crate) fn compressed(self) -> Dem {
        self.option("COMPRESS=DEFLATE")
    }

    pub(crate) fn big_endian(self) -> Dem {
        self.option("ENDIANNESS=BIG")
    }

    /// Writes it to a folder, and gives its path.
    pub(crate) fn write(&self, folder: &Folder, name: &str) -> String {
        let path = folder.join(name);
        let mut dataset = match self.kind {
            Kind::Byte | Kind::SignedByte => self.create::<u8>(&path),
            Kind::UInt16 => self.create::<u16>(&path),
            Kind::Int16 => self.create::<i16>(&path),
            Kind::UInt32 => self.create::<u32>(&path),
            Kind::Int32 => self.create::<i32>(&path),
            Kind::UInt64 => self.create::<u64>(&path),
            Kind::Int64 => self.create::<i64>(&path),
            Kind::Float32 => self.create::<f32>(&path),
            Kind::Float64 => self.create::<f64>(&path),
        };
        self.georeference(&mut dataset);
        self.fill(&dataset);
        dataset.close().unwrap();
        folder.at(name)
    }

    fn create<T: GdalType>(&self, path: &Path) -> Dataset {
        let mut options: RasterCreationOptions = self.options.iter().map(String::as_str).collect();
        if self.kind == Kind::SignedByte {
            options.add_string("PIXELTYPE=SIGNEDBYTE").unwrap();
        }
        let driver = DriverManager::get_driver_by_name(self.driver).unwrap();
        let (width, height) = (self.width, self.height);
        driver.create_with_band_type_with_options::<T, _>(path, width, height, self.bands, &options).unwrap()
    }

    fn georeference(&self, dataset: &mut Dataset) {
        if let Some(coefficients) = &self.geo_transform {
            dataset.set_geo_transform(coefficients).unwrap();
        }
        if let Some(epsg) = self.epsg {
            dataset.set_spatial_ref(&SpatialRef::from_epsg(epsg).unwrap()).unwrap();
        }
    }

    /// Every band gets the same heights, unless `others` says otherwise. GDAL converts them to the type of the samples.
    fn fill(&self, dataset: &Dataset) {
        let value = |band: usize, column: usize, row: usize| match self.others {
            Some(others) if band > 1 => others(band, column, row),
            _ => (self.heights)(column, row),
        };
        for number in 1..=self.bands {
            let samples = (0..self.width * self.height).map(|i| value(number, i % self.width, i / self.width));
            let mut buffer = Buffer::new((self.width, self.height), samples.collect::<Vec<f64>>());
            let mut band = dataset.rasterband(number).unwrap();
            match (self.nodata, band.band_type()) {
                (Some(value), GdalDataType::Int64) => band.set_no_data_value_i64(Some(value as i64)).unwrap(),
                (Some(value), GdalDataType::UInt64) => band.set_no_data_value_u64(Some(value as u64)).unwrap(),
                (value, _) => band.set_no_data_value(value).unwrap(),
            }
            if let Some((scale, offset)) = self.scaling {
                band.set_scale(scale).unwrap();
                band.set_offset(offset).unwrap();
            }
            band.write((0, 0), (self.width, self.height), &mut buffer).unwrap();
        }
    }
}
