//! All pairs of options that ask for features, through the commands themselves: each runs and passes `verify`, or is
//! refused; and what is done as the refusal says runs.

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;

use clap::Parser;
use gdal::DriverManager;
use gdal::raster::{Buffer, GdalType};
use gdal::spatial_ref::SpatialRef;

use super::*;
use crate::cli::{Cli, Command};
use crate::job::pair_tests::OF_A_RUN;
use crate::job::rules::WayOut;
use crate::testing;

const SIZE: (usize, usize) = (14, 12);

/// The options of a command line: what follows each of them, if anything does.
type Line = BTreeMap<&'static str, &'static str>;

/// Files for all features.
struct Scene {
    folder: tempfile::TempDir,
}

impl Scene {
    fn new() -> Scene {
        let scene = Scene { folder: testing::folder() };
        let place = |i: usize| (i % SIZE.0, i / SIZE.0);
        let heights = |i: usize| {
            let (c, r) = place(i);
            match (c, r) {
                (8..10, 6..8) => f64::NAN,
                (3, 9) => -9999.0,
                // Few digits: exact tests are quick.
                _ => ((c * c + 3 * r * c + 7 * r) % 23) as f64 * 0.375,
            }
        };
        let red = |i: usize| (place(i).0 * 11 % 256) as f64;
        let weights = |i: usize| 0.25 * (i % 5) as f64;
        let high = |_: usize| 128.0;
        let low = |i: usize| ((place(i).0 + 2 * place(i).1) % 17) as f64;
        scene.write::<f64>("dem.tif", &[&heights, &red, &low]);
        scene.write::<f64>("image.tif", &[&low, &red, &low]);
        scene.write::<f64>("weights.tif", &[&weights]);
        scene.write::<u8>("rgb.tif", &[&high, &low, &red]);
        scene.layer("points.geojson", "Point", &scene.at(4.0, 5.0));
        let line = [(0.4, 2.2), (7.3, 3.9), (13.1, 10.4)].map(|(c, r)| scene.at(c, r).replace(']', ", 30]"));
        scene.layer("lines.geojson", "LineString", &format!("[{}]", line.join(", ")));
        let ring = [(1.3, 0.7), (12.6, 1.2), (11.1, 10.2), (2.2, 9.6), (1.3, 0.7)].map(|(c, r)| scene.at(c, r));
        scene.layer("area.geojson", "Polygon", &format!("[[{}]]", ring.join(", ")));
        let lake = [(2.3, 6.7), (4.6, 6.2), (4.1, 9.2), (2.3, 6.7)].map(|(c, r)| scene.at(c, r));
        scene.layer("lake.geojson", "Polygon", &format!("[[{}]]", lake.join(", ")));
        scene
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn write<T: GdalType + Copy + FromF64>(&self, name: &str, bands: &[&dyn Fn(usize) -> f64]) {
        let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
        let dataset = driver.create_with_band_type::<T, _>(self.path(name), SIZE.0, SIZE.1, bands.len());
        let mut dataset = dataset.expect("a raster");
        dataset.set_geo_transform(&[500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0]).expect("a place");
        dataset.set_spatial_ref(&SpatialRef::from_epsg(32633).expect("a CRS")).expect("a CRS");
        for (number, value) in bands.iter().enumerate() {
            let samples: Vec<T> = (0..SIZE.0 * SIZE.1).map(|i| T::from_f64(value(i))).collect();
            let mut band = dataset.rasterband(number + 1).expect("a band");
            band.write((0, 0), SIZE, &mut Buffer::new(SIZE, samples)).expect("written");
        }
        dataset.close().expect("closed");
    }

    fn at(&self, column: f64, row: f64) -> String {
        format!("[{}, {}]", 500_005.0 + column * 10.0, 5_199_995.0 - row * 10.0)
    }

    fn layer(&self, name: &str, kind: &str, coordinates: &str) {
        let crs = r#"{"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}"#;
        let geometry = format!(r#"{{"type": "{kind}", "coordinates": {coordinates}}}"#);
        let feature = format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {geometry}}}"#);
        let text =
            format!(r#"{{"type": "FeatureCollection", "name": "layer", "crs": {crs}, "features": [{feature}]}}"#);
        std::fs::write(self.path(name), text).expect("written");
    }

    /// Runs a subcommand on the files that the options are for.
    fn command(&self, name: &str, line: &Line) -> Command {
        let raster = match (line.contains_key("--encoding"), line.contains_key("--image")) {
            (true, _) => "rgb.tif",
            (false, true) => "image.tif",
            (false, false) => "dem.tif",
        };
        let mut words = vec!["terrabite".to_string(), name.to_string(), self.path(raster), self.path("tin.ply")];
        for (option, value) in line {
            words.push(option.to_string());
            match *value {
                "" => {}
                file if file.contains('.') && file.ends_with(|c: char| c.is_alphabetic()) => {
                    words.push(self.path(file))
                }
                value => words.push(value.to_string()),
            }
        }
        Cli::try_parse_from(&words).unwrap_or_else(|e| panic!("{words:?}: {e}")).command
    }

    /// Makes a mesh, which must pass.
    fn run(&self, line: &Line) -> Result<(), Failure> {
        let mut making = line.clone();
        making.extend([("--temp-dir", "."), ("--tile", "8"), ("--threads", "1"), ("--access", "windows")]);
        making.extend([("--overwrite", ""), ("--quiet", "")]);
        let Command::Simplify(args) = self.command("simplify", &making) else { panic!("simplify") };
        crate::cli::simplify::run(&args)?;
        let mut judging: Line =
            line.iter().filter(|(option, _)| JUDGED.contains(option)).map(|(o, v)| (*o, *v)).collect();
        judging.extend([("--quiet", "")]);
        let Command::Verify(args) = self.command("verify", &judging) else { panic!("verify") };
        let judged = crate::cli::verify::run(&args).unwrap_or_else(|e| panic!("{e:?} for {line:?}"));
        assert_eq!(format!("{judged:?}"), format!("{:?}", ExitCode::SUCCESS), "{line:?} fails");
        Ok(())
    }

    fn asked(&self, line: &Line) -> Asked {
        let Command::Simplify(args) = self.command("simplify", line) else { panic!("simplify") };
        args.mesh.asked_of_doubles(crate::formats::FORMATS[0])
    }
}

/// What `verify` has to be given, too.
const JUDGED: [&str; 17] = [
    "--max-error",
    "--attributes",
    "--image",
    "--attribute-weight",
    "--importance",
    "--breaklines",
    "--lake-polygons",
    "--footprints",
    "--breakline-z",
    "--trim",
    "--fill-holes",
    "--band",
    "--encoding",
    "--nodata",
    "--valid-range",
    "--cutline",
    "--cutline-exact",
];

trait FromF64 {
    fn from_f64(value: f64) -> Self;
}

impl FromF64 for f64 {
    fn from_f64(value: f64) -> f64 {
        value
    }
}

impl FromF64 for u8 {
    fn from_f64(value: f64) -> u8 {
        value as u8
    }
}

/// The option that asks for a feature, and what follows it. Budgets are large enough for the tolerance to be kept.
fn example(feature: Feature) -> (&'static str, &'static str) {
    match feature {
        Feature::VertexBudget => ("--max-points", "1000"),
        Feature::TriangleBudget => ("--max-triangles", "2000"),
        Feature::RmsGoal => ("--max-rms", "1"),
        Feature::Attributes => ("--attributes", "2,3"),
        Feature::Image => ("--image", ""),
        Feature::AttributeWeight => ("--attribute-weight", "0.3"),
        Feature::Importance => ("--importance", "weights.tif"),
        Feature::Points => ("--points", "points.geojson"),
        Feature::Breaklines => ("--breaklines", "lines.geojson"),
        Feature::Lakes => ("--lake-polygons", "lake.geojson"),
        Feature::Footprints => ("--footprints", "area.geojson"),
        Feature::LineHeights => ("--breakline-z", "line"),
        Feature::Trim => ("--trim", "2"),
        Feature::FilledVoids => ("--fill-holes", "9"),
        Feature::Band => ("--band", "1"),
        Feature::Encoding => ("--encoding", "terrarium"),
        Feature::NodataMarks => ("--nodata", "-9999"),
        Feature::ValidRange => ("--valid-range", "-9999,100"),
        Feature::Cutline => ("--cutline", "area.geojson"),
        Feature::ExactCutline => ("--cutline-exact", ""),
        Feature::Polishing => ("--quality", "fast"),
        Feature::FittedHeights => ("--heights", "fitted"),
        Feature::MinAngle => ("--min-angle", "10"),
        Feature::MaxStray => ("--max-stray", "2"),
        Feature::PolishingNumbers => ("--polish-sweeps", "1"),
        Feature::StrongPolishEdges => ("--polish-edges", "strong"),
        Feature::WeakPolishEdges => ("--polish-edges", "weak"),
        Feature::StrongFeasibility => ("--feasibility", "strong"),
        Feature::GreedyCuts => ("--engine", "greedy-cuts"),
        Feature::CutOrder => ("--cuts", "improved"),
        Feature::HittingSet => ("--engine", "hitting-set"),
        Feature::Squares => ("--squares", "sliding"),
        Feature::SampledCorners => ("--corners", "samples"),
        Feature::FreeCorners => ("--corners", "free"),
        Feature::Stitching => ("--stitching", "shared"),
        Feature::DelaunaySwap => ("--swap", "delaunay"),
        Feature::DataDependentSwap => ("--swap", "data-dependent"),
        Feature::QualityThreshold => ("--quality-threshold", "0.4"),
        Feature::Shape => ("--shape", "smallest-angle"),
        Feature::Fit => ("--fit", "l2"),
        Feature::SequentialSelection => ("--selection", "sequential"),
        Feature::FractionalSelection => ("--selection", "fractional"),
        Feature::ConstantSelection => ("--selection", "constant"),
        Feature::Fraction => ("--fraction", "0.7"),
        Feature::LocalErrorMeasure => ("--measure", "local-error"),
        Feature::GlobalErrorMeasure => ("--measure", "global-error"),
        Feature::SmoothedMeasure => ("--measure", "curvature"),
        Feature::Smoothing => ("--smoothing", "2"),
        Feature::InexactScale => ("--z-scale", "0.3"),
        Feature::RoundedToSingle => ("--precision", "float"),
    }
}

/// Does with the options what the way out says.
fn follow(line: &mut Line, incompatible: &Incompatible) {
    for conflict in &incompatible.conflicts {
        let given_up = match conflict.way_out {
            WayOut::GiveUpThese => conflict.these.as_slice(),
            WayOut::GiveUpThose => conflict.those.as_slice(),
            WayOut::Add(feature) => {
                let (option, value) = example(feature);
                line.insert(option, value);
                &[]
            }
        };
        for &feature in given_up {
            match options(feature).without {
                // The tolerance is there.
                Without::Remove | Without::Replace("--max-error") => line.remove(example(feature).0),
                Without::Replace(other) => panic!("{other} in place of {feature}"),
                Without::Use(words) => {
                    let mut words = words.split(' ');
                    line.insert(words.next().expect("an option"), words.next().expect("a value"))
                }
            };
        }
    }
}

#[test]
fn pairs_of_options_run_or_are_refused_with_a_way_out() {
    let scene = Scene::new();
    let (mut run, mut refused) = (0, 0);
    let mut passed: BTreeSet<Line> = BTreeSet::new();
    // Many a way out leads to the same line.
    let mut must_run = |line: &Line, why: &str| {
        if passed.insert(line.clone()) {
            scene.run(line).unwrap_or_else(|e| panic!("{e:?} for {line:?}{why}"));
        }
    };
    let tried_by_the_library = |feature| OF_A_RUN.contains(&feature);
    for (i, &a) in Feature::ALL.iter().enumerate() {
        for &b in &Feature::ALL[i..] {
            let ((first, x), (second, y)) = (example(a), example(b));
            if first == second && a != b {
                continue;
            }
            let mut line = Line::from([("--max-error", "1.5"), (first, x), (second, y)]);
            let asked = scene.asked(&line);
            // Else the option would be there, and nobody would read it.
            assert!(asked.features().has(b), "{line:?} asks for {b}");
            let Err(incompatible) = rules::check(asked.features()) else {
                if a == b || !tried_by_the_library(a) || !tried_by_the_library(b) {
                    must_run(&line, "");
                }
                run += 1;
                continue;
            };
            refused += 1;
            let message = scene.run(&line).expect_err("refused").message().to_string();
            assert_eq!(message, asked.refuse(&incompatible).message(), "{line:?}");
            assert_eq!(message.lines().count(), incompatible.conflicts.len());
            assert!(message.contains(first) || message.contains(second), "{message}");
            follow(&mut line, &incompatible);
            must_run(&line, &format!(" after {message}"));
        }
    }
    assert!(run > 300 && refused > 150, "{run} pairs run, {refused} are refused");
}

#[test]
fn each_feature_has_its_option() {
    for &feature in Feature::ALL {
        let (option, value) = example(feature);
        let Options { any, one, .. } = options(feature);
        if feature == Feature::PolishingNumbers {
            assert_eq!((any, one), ("--polish-…", "--polish-…"));
            continue;
        }
        assert!(any.starts_with(option) && one.starts_with(option), "{feature}: {option}");
        // Where values ask for different features, the one that is named asks for this.
        let said = any.strip_prefix(option).expect("the option").trim_start();
        assert!(said.is_empty() || said.contains(value) || value.parse::<f64>().is_ok(), "{any}: {value}");
    }
}

#[test]
fn messages_name_options_as_they_are_given() {
    let asked = |line: &[(Feature, &str)]| Asked {
        given: line.iter().map(|(f, o)| (*f, o.to_string())).collect(),
        ..Asked::default()
    };
    let message = |line: &[(Feature, &str)]| asked(line).check().expect_err("refused").message().to_string();
    assert_eq!(
        message(&[
            (Feature::StrongFeasibility, "--feasibility strong"),
            (Feature::WeakPolishEdges, "--polish-edges weak")
        ]),
        "--feasibility strong cannot be combined with --polish-edges weak: polishing would undo what strong feasibility asks \
         for; remove --polish-edges weak"
    );
    let said = message(&[
        (Feature::MinAngle, "--min-angle"),
        (Feature::PolishingNumbers, "--polish-yield"),
        (Feature::PolishingNumbers, "--polish-steps"),
    ]);
    assert!(said.starts_with("--min-angle, --polish-yield and --polish-steps each require --quality "), "{said}");
    assert!(said.ends_with("; use --quality balanced"), "{said}");
}
