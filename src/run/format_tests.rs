//! Every format, in every way that coordinates can be written: a run writes it, `verify` passes it, and it comes through PLY
//! and back as the same mesh.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{
    AttributeBands, Attributes, ConvertRequest, Coordinates, Request, VerifyRequest, convert, simplify, verify,
};
use crate::base::control::Control;
use crate::base::{Band, GeoTransform, Metres, RasterError, Reference, SampleType, Window, Windows};
use crate::formats::{self, FORMATS, Format, Precision, ReadError, ReadOptions, Unit};
use crate::job::normals::Normals;
use crate::job::{Params, Quality};
use crate::testing;

const SIZE: (usize, usize) = (40, 30);

/// Samples made where they are asked for.
struct Made(fn(usize, usize) -> f64, SampleType);

impl Windows for Made {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let bytes = self.1.bytes();
        for (i, sample) in out.chunks_exact_mut(bytes).enumerate() {
            let value = self.0(window.column + i % window.width, window.row + i / window.width);
            match bytes {
                4 => sample.copy_from_slice(&(value as f32).to_ne_bytes()),
                _ => sample.copy_from_slice(&value.to_ne_bytes()),
            }
        }
        Ok(())
    }
}

fn hills(column: usize, row: usize) -> f64 {
    let (c, r) = (column as f64, row as f64);
    300.0 + 20.0 * (c / 6.0).sin() + 15.0 * (r / 5.0).cos() + c * r / 90.0
}

fn hills_with_gaps(column: usize, row: usize) -> f64 {
    let (c, r) = (column as f64, row as f64);
    // A hole, an island in a lake, a corner, and two gaps that touch in a corner.
    let lake = (c - 25.0).hypot(r - 15.0);
    let is_gap = (c - 9.0).hypot(r - 8.0) < 3.0
        || (4.0..7.0).contains(&lake)
        || column + row < 5
        || (column, row) == (35, 25)
        || (column, row) == (36, 26);
    if is_gap { f64::NAN } else { hills(column, row) }
}

fn heat(column: usize, row: usize) -> f64 {
    ((3 * column + 5 * row) % 17) as f64 / 4.0
}

/// On the map of a projected CRS, or in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Utm,
    Degrees,
    SurveyFeet,
}

fn band(height: fn(usize, usize) -> f64, kind: SampleType, place: Place) -> Band {
    let (coefficients, crs, unit, metres) = match place {
        Place::Utm => ([500_000.12, 0.25, 0.0, 5_200_000.77, 0.0, -0.25], "EPSG:32633", "metre", Metres::PerUnit(1.0)),
        Place::Degrees => (
            [-122.3, 1.0 / 3600.0, 0.0, 46.2, 0.0, -1.0 / 3600.0],
            "EPSG:4326",
            "degree",
            Metres::OnEllipsoid {
                semi_major: 6_378_137.0,
                semi_minor: 6_356_752.314_245_179,
                radians: 1f64.to_radians(),
            },
        ),
        Place::SurveyFeet => (
            [1_300_000.3, 3.0, 0.0, 700_000.9, 0.0, -3.0],
            "EPSG:2285",
            "US survey foot",
            Metres::PerUnit(1200.0 / 3937.0),
        ),
    };
    let transform = GeoTransform::new(coefficients, SIZE.0, SIZE.1).expect("a transform");
    let reference = Reference {
        crs: crs.to_string(),
        geographic: place == Place::Degrees,
        unit: unit.to_string(),
        metres: Some(metres),
        height_unit: if place == Place::SurveyFeet { "US survey foot" } else { "metre" }.to_string(),
        ..Reference::none()
    };
    Band::new("dem", SIZE, kind, Arc::new(Made(height, kind)))
        .expect("a band")
        .with_reference(reference, Some(crs.to_string()))
        .with_geo_transform(transform)
}

/// One way of writing.
#[derive(Debug, Clone, Copy)]
struct Way {
    place: Place,
    local: bool,
    single: bool,
    attributes: bool,
    gaps: bool,
    kind: SampleType,
    normals: Option<Normals>,
}

impl Way {
    fn band(&self) -> Band {
        band(if self.gaps { hills_with_gaps } else { hills }, self.kind, self.place)
    }

    fn attributes(&self) -> Option<Attributes> {
        let bands = AttributeBands::Bands(vec![band(heat, SampleType::F32, self.place)]);
        self.attributes.then(|| Attributes { bands, weight: 0.25, image: false })
    }

    fn request(&self, format: &'static Format, output: &Path) -> Request<'static> {
        let quality = if self.attributes { Quality::None } else { Quality::Balanced };
        let params = testing::in_memory(&Params { tile: 16, quality, ..Params::new(0.5) });
        Request {
            format: Some(format),
            overwrite: true,
            params,
            attributes: self.attributes(),
            normals: self.normals,
            coordinates: Coordinates { local: self.local, single: self.single, z_scale: 1.0 },
            ..Request::new(self.band(), output, 0.5)
        }
    }

    /// `format` is the one that the mesh was first in: what it does not keep is gone.
    fn passes(&self, format: &'static Format, mesh: &Path) {
        let is_kept = format.attributes != formats::Attributes::None;
        let request = VerifyRequest {
            attributes: self.attributes().filter(|_| is_kept),
            ..VerifyRequest::new(self.band(), mesh, 0.5)
        };
        let report =
            verify(&request, &Control::default()).unwrap_or_else(|e| panic!("{}: {self:?}: {e}", format.title));
        assert!(report.passed, "{}: {self:?}: {:?}", format.title, report.failures);
    }
}

/// Triangles as what stands at their corners, each turned so that the least comes first, in order.
fn triangles(mesh: &Path) -> Vec<Vec<Vec<u64>>> {
    let mut reader = formats::open(mesh, None, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut names: Vec<String> = reader.attributes().iter().map(|a| a.name.clone()).collect();
    names.sort_unstable();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut vertices = Vec::new();
    let mut all = Vec::new();
    reader
        .for_each_vertex_with(&names, |_, place, attributes| {
            vertices.push(place.iter().chain(attributes).map(|v| v.to_bits()).collect::<Vec<_>>());
            Ok::<(), ReadError>(())
        })
        .expect("vertices");
    reader
        .for_each_face(|_, face| {
            let mut corners: Vec<_> = face.iter().map(|&v| vertices[v as usize].clone()).collect();
            let least = (0..3).min_by_key(|&i| &corners[i]).expect("three");
            corners.rotate_left(least);
            all.push(corners);
            Ok::<(), ReadError>(())
        })
        .expect("faces");
    all.sort_unstable();
    all
}

fn try_format(format: &'static Format, way: Way) {
    let folder = testing::folder();
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    let control = Control::default();
    let first = at("first").with_extension(format.extensions[0]);
    let report =
        simplify(&way.request(format, &first), &control).unwrap_or_else(|e| panic!("{}: {way:?}: {e}", format.title));
    way.passes(format, &first);
    let is_single = way.single || !format.precisions.contains(&Precision::Double);
    assert_eq!(report.map.precision, if is_single { "float" } else { "double" });
    let is_scaled = format.unit == Unit::Metre && way.place != Place::Utm;
    assert_eq!(report.map.xy_scale != (1.0, 1.0), is_scaled, "{}: {way:?}", format.title);
    let given = triangles(&first);
    assert_eq!(given.len() as u64, report.triangles);
    // Through PLY, and back.
    let (ply, again) = (at("second.ply"), at("third").with_extension(format.extensions[0]));
    let through = ConvertRequest { overwrite: true, ..ConvertRequest::new(&first, &ply) };
    convert(&through, &control).unwrap_or_else(|e| panic!("{}: {way:?}: {e}", format.title));
    assert!(triangles(&ply) == given, "{}: {way:?}: another mesh as PLY", format.title);
    way.passes(format, &ply);
    let back = ConvertRequest { format: Some(format), overwrite: true, ..ConvertRequest::new(&ply, &again) };
    convert(&back, &control).unwrap_or_else(|e| panic!("{}: {way:?}: {e}", format.title));
    assert!(triangles(&again) == given, "{}: {way:?}: another mesh from PLY", format.title);
    way.passes(format, &again);
}

#[test]
fn every_format_in_every_way() {
    for format in FORMATS {
        for bits in 0..16 {
            let [local, single, attributes, gaps] = [1, 2, 4, 8].map(|bit| bits & bit != 0);
            let way = Way { place: Place::Utm, local, single, attributes, gaps, kind: SampleType::F32, normals: None };
            try_format(format, way);
        }
    }
}

/// Heights that single precision rounds, degrees, feet, normals.
#[test]
fn what_is_lost_is_kept_from_the_tolerance() {
    for format in FORMATS {
        for place in [Place::Utm, Place::Degrees, Place::SurveyFeet] {
            for single in [false, true] {
                let way = Way {
                    place,
                    local: false,
                    single,
                    attributes: false,
                    gaps: true,
                    kind: SampleType::F64,
                    normals: None,
                };
                try_format(format, way);
                if format.options.contains(&formats::SinkOption::Normals) {
                    try_format(format, Way { normals: Some(Normals::Gradient), ..way });
                }
            }
        }
    }
}

/// A mesh in doubles on the map becomes, in another format, what a run would have written into it.
#[test]
fn a_converted_mesh_is_the_one_that_a_run_writes() {
    let folder = testing::folder();
    let control = Control::default();
    for place in [Place::Utm, Place::Degrees] {
        let way = Way {
            place,
            local: false,
            single: false,
            attributes: false,
            gaps: true,
            kind: SampleType::F32,
            normals: None,
        };
        let ply = folder.path().join("tin.ply");
        simplify(&way.request(FORMATS[0], &ply), &control).expect("a mesh");
        let local = Coordinates { local: true, ..Coordinates::default() };
        let scaled = Coordinates { z_scale: 3.0, ..Coordinates::default() };
        let single = Coordinates { z_scale: 0.25, single: true, ..local };
        for (format, coordinates) in
            FORMATS.iter().flat_map(|format| [Coordinates::default(), local, scaled, single].map(|c| (*format, c)))
        {
            let out = folder.path().join("out").with_extension(format.extensions[0]);
            let (format_of_out, overwrite) = (Some(format), true);
            let request =
                ConvertRequest { format: format_of_out, overwrite, coordinates, ..ConvertRequest::new(&ply, &out) };
            let report = convert(&request, &control).expect("converted");
            let has_origin = coordinates.local || !format.precisions.contains(&Precision::Double);
            assert_eq!(report.offset != (0.0, 0.0), has_origin, "{}: {place:?} {coordinates:?}", format.title);
            assert_eq!(report.z_scale, coordinates.z_scale);
            // Heights may lose a little, which the report says.
            let request = VerifyRequest::new(way.band(), &out, 0.5 + report.loss);
            let found = verify(&request, &control).expect("judged");
            assert!(found.passed, "{}: {place:?} {coordinates:?}: {:?}", format.title, found.failures);
            assert_eq!(report.max_error, Some(0.5 + report.loss));
            let anew = Coordinates { z_scale: 5.0, ..Coordinates::default() };
            let anew = ConvertRequest {
                coordinates: anew,
                overwrite,
                ..ConvertRequest::new(&out, folder.path().join("a.ply"))
            };
            let is_plain = report.z_scale == 1.0 && report.precision == "double";
            assert_eq!(convert(&anew, &control).is_ok(), is_plain, "{}: {coordinates:?}", format.title);
        }
    }
}

/// Normals stand on the axes of the file: where a converted one has longer ones, they turn.
#[test]
fn normals_turn_with_the_axes() {
    let folder = testing::folder();
    let control = Control::default();
    let at = |name: &str| folder.path().join(name);
    let (local, single, attributes, gaps) = (false, false, false, true);
    let (kind, normals) = (SampleType::F32, Some(Normals::Area));
    let read = |path: &Path| {
        let mut found = Vec::new();
        let mut reader = formats::open(path, None, &ReadOptions::default()).expect("a mesh");
        let keep = |_: u64, _: [f64; 3], normal: &[f64]| {
            found.push([normal[0], normal[1], normal[2]]);
            Ok::<(), ReadError>(())
        };
        reader.for_each_vertex_with(&["nx", "ny", "nz"], keep).expect("vertices");
        found
    };
    let coordinates = Coordinates { z_scale: 7.0, ..Coordinates::default() };
    let pairs = [Place::Utm, Place::Degrees].into_iter().flat_map(|p| ["ply", "glb", "vtp"].map(|e| (p, e)));
    for (place, extension) in pairs {
        let way = Way { place, local, single, attributes, gaps, kind, normals };
        simplify(&way.request(FORMATS[0], &at("tin.ply")), &control).expect("a mesh");
        let (format, overwrite) = (formats::by_name(extension), true);
        let (converted, made) = (at("a").with_extension(extension), at("b").with_extension(extension));
        let request = ConvertRequest { coordinates, overwrite, ..ConvertRequest::new(at("tin.ply"), &converted) };
        convert(&request, &control).expect("converted");
        let request = way.request(format.expect("a format"), &made);
        simplify(&Request { coordinates, ..request }, &control).expect("a mesh");
        let (found, expected, before) = (read(&converted), read(&made), read(&at("tin.ply")));
        let off = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
        let farthest = |others: &[[f64; 3]]| found.iter().zip(others).map(off).fold(0.0, f64::max);
        assert_eq!(found.len(), expected.len());
        assert!(farthest(&expected) < 1e-5, "{extension}: {}", farthest(&expected));
        // Heights are so much longer than degrees that normals lie flat, whatever heights are multiplied by.
        let has_turned = place == Place::Utm || extension == "glb";
        assert_eq!(farthest(&before) > 0.1, has_turned, "{extension}: {}", farthest(&before));
    }
}
