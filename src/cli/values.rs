//! What the options' values may be. Each parser's error is the end of clap's sentence "invalid value '…' for …: ".
//!
//! Options that take [`max_error`] set `allow_hyphen_values`: clap would take `-1` for an unknown option and never ask.

use std::num::NonZeroUsize;
use std::path::Path;

use super::format_options::MeshFormat;
use crate::base::Polylines;
use crate::base::ValidRange;
use crate::base::Window;
use crate::base::decimal::{Decimal, is_too_large};
use crate::formats::{self, FORMATS};
use crate::job::shards::Shard;
use crate::kernel::boundary::MAX_CELLS;
use crate::kernel::polish::{Caps, Schedule};
use crate::raster::BoundingBox;

/// A width and a height, in samples or pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Refuses a decimal beyond the largest double: infinity is what a word stands for, if an option takes it.
fn must_not_be_too_large(text: &str, infinite: &str) -> Result<(), String> {
    match is_too_large(text) {
        true => Err(format!("{text} is beyond {}, the largest number{infinite}", Decimal(f64::MAX))),
        false => Ok(()),
    }
}

/// A tolerance: the double the text stands for, finite and not below 0.
pub(crate) fn max_error(text: &str) -> Result<f64, String> {
    must_not_be_too_large(text, "")?;
    let tolerance: f64 = text.parse().map_err(|_| "expected a number such as 0.5".to_string())?;
    if tolerance.is_finite() && tolerance >= 0.0 {
        // A negative zero is zero.
        return Ok(tolerance.abs());
    }
    Err("expected a finite number, 0 or above, in the units of the heights".to_string())
}

/// A limit on straying as a multiple of the tolerance, from 1 on; infinite for none.
pub(crate) fn max_stray(text: &str) -> Result<f64, String> {
    must_not_be_too_large(text, "; inf sets no limit")?;
    let factor = text.parse().ok().filter(|factor: &f64| *factor >= 1.0);
    factor.ok_or_else(|| {
        "expected 1 or more, such as 1.5, or inf: the surface may be 1 × the tolerance off at samples, so it may be as far beyond \
         their heights"
            .to_string()
    })
}

/// Different bands, counted from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Bands(pub(crate) Vec<usize>);

/// `BAND,BAND,…`, at least one, none twice.
pub(crate) fn bands(text: &str) -> Result<Bands, String> {
    let parse = || {
        let bands: Vec<usize> = text.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
        let different = bands.iter().enumerate().all(|(i, band)| *band > 0 && !bands[..i].contains(band));
        different.then_some(Bands(bands))
    };
    parse().ok_or_else(|| "expected bands counted from 1, none of them twice, such as 2,3,4".to_string())
}

/// A factor, finite and above 0.
pub(crate) fn factor(text: &str) -> Result<f64, String> {
    let factor = text.parse().ok().filter(|f: &f64| f.is_finite() && *f > 0.0);
    factor.ok_or_else(|| "expected a finite number above 0, such as 2.5".to_string())
}

/// A finite number.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|n: &f64| n.is_finite()).ok_or_else(|| "expected a number such as 12.5".to_string())
}

/// The name of a format of meshes.
pub(crate) fn mesh_format(text: &str) -> Result<MeshFormat, String> {
    let known = || FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ");
    let name = text.to_ascii_lowercase();
    if let Some(driver) = name.strip_prefix("ogr:") {
        let known = formats::ogr::named(driver).map(|driver| MeshFormat { name: "ogr", driver: Some(driver) });
        return known.ok_or_else(|| format!("expected OGR:GPKG or OGR:FlatGeobuf, found OGR:{}", &text[4..]));
    }
    let by_extension = || formats::by_extension(Path::new(&format!("mesh.{name}")));
    match formats::by_name(&name).or_else(by_extension) {
        Some(format) if name == "gpkg" => Ok(MeshFormat { name: format.name, driver: Some("GPKG") }),
        Some(format) if name == "fgb" => Ok(MeshFormat { name: format.name, driver: Some("FlatGeobuf") }),
        Some(format) => Ok(MeshFormat { name: format.name, driver: None }),
        None => Err(format!("expected one of {}", known())),
    }
}

/// `N/OF`: which part of how many.
pub(crate) fn shard(text: &str) -> Result<Shard, String> {
    let parse = || {
        let (number, of) = text.split_once('/')?;
        Shard::new(number.parse().ok()?, of.parse().ok()?)
    };
    parse().ok_or_else(|| format!("expected a part such as 3/64, from 1/64 to 64/64, of at most {} parts", Shard::MOST))
}

/// The number of a pass.
pub(crate) fn pass(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|pass| *pass > 0).ok_or_else(|| "expected the number of a pass, from 1".to_string())
}

/// Pixels along a side of a texture.
pub(crate) fn texture_size(text: &str) -> Result<usize, String> {
    let size = text.parse().ok().filter(|size| (1..=16_384).contains(size));
    size.ok_or_else(|| "expected a number of pixels from 1 to 16384".to_string())
}

/// A number of vertices or triangles.
pub(crate) fn count(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| "expected a whole number".to_string())
}

/// A share, from 0 to 1.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|s| (0.0..=1.0).contains(s));
    // A negative zero is zero.
    share.map(f64::abs).ok_or_else(|| "expected a number from 0 to 1, such as 0.5".to_string())
}

/// Cells to trim.
pub(crate) fn trim(text: &str) -> Result<u32, String> {
    let cells = text.parse().ok().filter(|cells| *cells <= MAX_CELLS);
    cells.ok_or_else(|| format!("expected a whole number of cells, from 0 to {MAX_CELLS}"))
}

/// How far edges may be shifted, in cells.
pub(crate) fn shift(text: &str) -> Result<f64, String> {
    let cells = text.parse::<f64>().ok().filter(|cells| (0.0..=Polylines::MAX_SHIFT).contains(cells));
    cells.map(f64::abs).ok_or_else(|| format!("expected cells from 0 to {}, such as 0.5", Polylines::MAX_SHIFT))
}

/// An angle in degrees, from 0 to 60: no triangle has all its angles above that.
pub(crate) fn angle(text: &str) -> Result<f64, String> {
    let degrees = text.parse::<f64>().ok().filter(|a| (0.0..=60.0).contains(a));
    // A negative zero is zero.
    degrees.map(f64::abs).ok_or_else(|| "expected degrees from 0 to 60, such as 20".to_string())
}

/// A number of sweeps, or `all`.
pub(crate) fn sweeps(text: &str) -> Result<u32, String> {
    if text == "all" {
        return Ok(Schedule::ALL);
    }
    text.parse().map_err(|_| "expected a whole number, or all".to_string())
}

/// A number of rows, or `all`.
pub(crate) fn rows(text: &str) -> Result<u32, String> {
    let rows = if text == "all" { Some(Schedule::ALL) } else { text.parse().ok().filter(|&rows| rows >= 8) };
    rows.ok_or_else(|| "expected a whole number from 8 on, or all".to_string())
}

/// An energy above 0, or `any`.
pub(crate) fn reach(text: &str) -> Result<f32, String> {
    let finite = || text.parse().ok().filter(|&e: &f32| e > 0.0 && e < f32::INFINITY);
    let reach = if text == "any" { Some(f32::INFINITY) } else { finite() };
    reach.ok_or_else(|| "expected a number above 0, such as 0.05, or any".to_string())
}

/// `CAP,CAP,…`.
pub(crate) fn caps(text: &str) -> Result<Caps, String> {
    let values: Option<Vec<f32>> = text.split(',').map(|cap| cap.trim().parse().ok()).collect();
    let caps = values.and_then(|values| Caps::new(&values));
    caps.ok_or_else(|| format!("expected one to {} numbers, none below 0, such as 1,2,5", Caps::MOST))
}

/// A share above 0, at most 1.
pub(crate) fn shrink(text: &str) -> Result<f32, String> {
    let share = text.parse().ok().filter(|&s: &f32| s > 0.0 && s <= 1.0);
    share.ok_or_else(|| "expected a number above 0, at most 1, such as 0.8".to_string())
}

/// A standard deviation in cells, above 0 and at most 64: so far the smoothing looks.
pub(crate) fn smoothing(text: &str) -> Result<f64, String> {
    let cells = text.parse().ok().filter(|&s: &f64| s > 0.0 && s <= 64.0);
    cells.ok_or_else(|| "expected a number of cells above 0, at most 64".to_string())
}

/// `WIDTHxHEIGHT`, both at least 1.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'X'])?;
        let (width, height) = (width.parse().ok()?, height.parse().ok()?);
        (width > 0 && height > 0).then_some(Size { width, height })
    };
    parse().ok_or_else(|| "expected WIDTHxHEIGHT, such as 4096x4096, both at least 1".to_string())
}

/// `COLUMN,ROW,WIDTH,HEIGHT`, in samples from the upper left: the four numbers of GDAL's `-srcwin`.
pub(crate) fn window(text: &str) -> Result<Window, String> {
    let parse = || {
        let numbers: Vec<usize> = text.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
        let &[column, row, width, height] = numbers.as_slice() else { return None };
        column.checked_add(width)?;
        row.checked_add(height)?;
        (width > 0 && height > 0).then_some(Window { column, row, width, height })
    };
    parse().ok_or_else(|| "expected COLUMN,ROW,WIDTH,HEIGHT in samples, such as 0,0,512,512".to_string())
}

/// `MIN,MAX`, in heights.
pub(crate) fn valid_range(text: &str) -> Result<ValidRange, String> {
    text.split(',').try_for_each(|end| must_not_be_too_large(end.trim(), "; -inf and inf set no limit"))?;
    let parse = || {
        let (min, max) = text.split_once(',')?;
        let (min, max): (f64, f64) = (min.trim().parse().ok()?, max.trim().parse().ok()?);
        // Not if one is no number.
        (min <= max).then_some(ValidRange { min, max })
    };
    parse().ok_or_else(|| "expected MIN,MAX in heights, MIN not above MAX, such as -500,9000".to_string())
}

/// `NAME=VALUE`.
pub(crate) fn open_option(text: &str) -> Result<String, String> {
    match text.split_once('=') {
        Some((name, _)) if !name.is_empty() => Ok(text.to_string()),
        _ => Err("expected NAME=VALUE, such as NUM_THREADS=2".to_string()),
    }
}

/// `XMIN,YMIN,XMAX,YMAX`, on the map.
pub(crate) fn bounding_box(text: &str) -> Result<BoundingBox, String> {
    let parse = || {
        let numbers: Vec<f64> = text.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
        let &[left, bottom, right, top] = numbers.as_slice() else { return None };
        let finite = numbers.iter().all(|n| n.is_finite());
        (finite && left <= right && bottom <= top).then_some(BoundingBox {
            min: (left, bottom),
            max: (right, top),
            crs: None,
        })
    };
    parse()
        .ok_or_else(|| "expected XMIN,YMIN,XMAX,YMAX in map units, such as 500000,5200000,510000,5210000".to_string())
}

/// A number of threads.
pub(crate) fn threads(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "expected a whole number of threads, at least 1".to_string())
}

/// A number of bytes: `1000`, `64KiB`, `256MiB`, `2GB`; a bare `K`, `M`, `G` or `T` is binary, as GDAL takes it.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || "expected a number of bytes, such as 256MiB or 2GB".to_string();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic() || c == ' ');
    let unit: u64 = match text[digits.len()..].trim_start().to_ascii_lowercase().as_str() {
        "" | "b" => 1,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        "t" | "tib" => 1 << 40,
        "kb" => 1_000,
        "mb" => 1_000_000,
        "gb" => 1_000_000_000,
        "tb" => 1_000_000_000_000,
        _ => return Err(wrong()),
    };
    if let Ok(whole) = digits.parse::<u64>() {
        return whole.checked_mul(unit).ok_or_else(wrong);
    }
    let bytes = digits.parse::<f64>().map_err(|_| wrong())? * unit as f64;
    // Below 2⁶³ every double becomes a whole number without saturating.
    if (0.0..9.2e18).contains(&bytes) { Ok(bytes as u64) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances() {
        assert_eq!(max_error("0"), Ok(0.0));
        assert!(max_error("-0").unwrap().is_sign_positive());
        assert_eq!(max_error("0.1"), Ok(0.1));
        for wrong in ["-1", "nan", "-NaN", "inf", "1e999", "", "1,5", "five"] {
            assert!(max_error(wrong).is_err(), "{wrong}");
        }
    }

    /// Only words stand for infinity.
    #[test]
    fn numbers_that_are_too_large() {
        assert_eq!((max_stray("inf"), max_stray("1e308")), (Ok(f64::INFINITY), Ok(1e308)));
        let refused = max_stray("1e400").unwrap_err();
        assert_eq!(refused, "1e400 is beyond 1.7976931348623157e308, the largest number; inf sets no limit");
        assert!(max_error("1e400").unwrap_err().contains("the largest number"));
        assert_eq!(valid_range("-inf, inf"), Ok(ValidRange { min: f64::NEG_INFINITY, max: f64::INFINITY }));
        for wrong in ["-500, 1e400", "-1e400,9000"] {
            assert!(valid_range(wrong).unwrap_err().contains("inf set no limit"), "{wrong}");
        }
        assert_eq!((reach("any"), reach("1e38")), (Ok(f32::INFINITY), Ok(1e38)));
        for wrong in ["1e39", "1e400", "inf"] {
            assert!(reach(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_and_windows() {
        assert_eq!(size("4096x2048"), Ok(Size { width: 4096, height: 2048 }));
        for wrong in ["4096", "0x5", "5x0", "-1x5", "axb", "1x2x3"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(window("1, 2,3,4"), Ok(Window { column: 1, row: 2, width: 3, height: 4 }));
        for wrong in ["1,2,3", "1,2,3,0", "1,2,3,4,5", "-1,2,3,4", "18446744073709551615,0,1,1"] {
            assert!(window(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn valid_ranges_and_open_options() {
        assert_eq!(valid_range("-500, 9000"), Ok(ValidRange { min: -500.0, max: 9000.0 }));
        assert_eq!(valid_range("-inf,1e4"), Ok(ValidRange { min: f64::NEG_INFINITY, max: 1e4 }));
        for wrong in ["", "1", "2,1", "nan,1", "1,nan", "1,2,3", "a,b"] {
            assert!(valid_range(wrong).is_err(), "{wrong}");
        }
        assert_eq!(open_option("HEIGHT=a=b"), Ok("HEIGHT=a=b".to_string()));
        assert!(open_option("HEIGHT").is_err() && open_option("=1").is_err());
    }

    #[test]
    fn boxes() {
        let bounds = bounding_box("-1.5, 2,3e2,4").unwrap();
        assert_eq!((bounds.min, bounds.max, bounds.crs), ((-1.5, 2.0), (300.0, 4.0), None));
        for wrong in ["1,2,3", "3,2,1,4", "1,4,3,2", "1,2,3,nan", "1,2,inf,4", "1,2,3,4,5", ""] {
            assert!(bounding_box(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn bands_and_shares() {
        assert_eq!(bands("2, 3,1"), Ok(Bands(vec![2, 3, 1])));
        for wrong in ["", "0", "1,0", "1,1", "2-4", "1;2", "-1", "1,"] {
            assert!(bands(wrong).is_err(), "{wrong}");
        }
        assert_eq!((share("0.25"), share("1")), (Ok(0.25), Ok(1.0)));
        for wrong in ["-0.1", "1.001", "nan", "half", ""] {
            assert!(share(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn counts_of_threads_and_bytes() {
        assert_eq!(threads("3").unwrap().get(), 3);
        assert!(threads("0").is_err() && threads("-1").is_err() && threads("two").is_err());
        assert_eq!(bytes("1000"), Ok(1000));
        assert_eq!(bytes("256MiB"), Ok(256 << 20));
        assert_eq!(bytes("1.5 GB"), Ok(1_500_000_000));
        assert_eq!(bytes("64k"), Ok(65536));
        assert_eq!(bytes("18446744073709551615"), Ok(u64::MAX));
        for wrong in ["", "MiB", "-1", "-0.5k", "1e30", "20000000T", "5 apples", "nan"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }
}
