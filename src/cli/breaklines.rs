//! `--breaklines` and what belongs to it: the options that `simplify`, `plan` and `verify` share.

use std::path::PathBuf;

use clap::ArgGroup;

use super::combinations::{Asked, option};
use super::failure::{Failure, of_shapes};
use super::values;
use crate::base::features::Feature;
use crate::base::{LineKind, LineType, Polylines};
use crate::kernel::breaklines::LinesError;
use crate::raster::{CutlineSource, LineSource, ShapesError, View};
use crate::run::{HeightSource, LakeHeight, LineInput, LineTypes, Lines, UnusableLines};
use crate::verify::VerifyError;

/// Lines that edges of the mesh follow.
#[derive(Debug, clap::Args)]
#[command(group = ArgGroup::new("edge_lines").multiple(true).args(["breaklines", "footprints"]))]
pub(crate) struct BreaklineArgs {
    /// A layer of lines, in any format OGR reads: edges of the mesh follow them, within the tolerance of the raster's surface.
    /// `verify` needs the same option
    #[arg(long, help_heading = "Mesh", value_name = "FILE")]
    breaklines: Option<PathBuf>,
    /// The layer of --breaklines [default: the first]
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "NAME", requires = "breaklines")]
    breaklines_layer: Option<String>,
    /// A layer of polygons that are lakes, in any format OGR reads: the mesh is level inside of them, edges follow their outlines, and
    /// holes are islands. `verify` needs the same option
    #[arg(long, help_heading = "Mesh", value_name = "FILE")]
    lake_polygons: Option<PathBuf>,
    /// The layer of --lake-polygons [default: the first]
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "NAME", requires = "lake_polygons")]
    lake_polygons_layer: Option<String>,
    /// The height of each of --lake-polygons: `min` or `median` of the samples nearest to its outline, or `field:NAME` for a number of the
    /// layer
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "Z", requires = "lake_polygons", value_parser = lake_height,
        default_value = "min")]
    lake_z: LakeHeight,
    /// A layer of polygons, in any format OGR reads: edges of the mesh follow their outlines as they follow --breaklines, so that roofs
    /// and dams keep sharp edges. Inside all samples keep --max-error. `verify` needs the same option
    #[arg(long, help_heading = "Mesh", value_name = "FILE")]
    footprints: Option<PathBuf>,
    /// The layer of --footprints [default: the first]
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "NAME", requires = "footprints")]
    footprints_layer: Option<String>,
    /// End the mesh at the outlines of --cutline's polygons themselves, rounded to quarter cells, and not at sides and diagonals of cells:
    /// edges of the mesh follow them, within the tolerance of the raster's surface. `verify` needs the same option
    #[arg(long, help_heading = "Mesh", hide_short_help = true)]
    cutline_exact: bool,
    /// How far edges may be from the lines of --breaklines and --footprints, seen from above, so that fewer are needed; from 0 to 16
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "CELLS", requires = "edge_lines", value_parser = values::shift,
        default_value_t = Polylines::USUAL_SHIFT, allow_hyphen_values = true)]
    breakline_shift: f64,
    /// Which heights edges along --breaklines have: `raster` for those of its surface, `line` for the lines' own z, in the raster's unit, or
    /// `field:NAME` for what each feature says in a text field, raster or line. At a sample beside a line with its own z the surface may
    /// be anywhere between the sample and the line, give or take --max-error
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "Z", value_parser = line_heights, default_value = "raster")]
    breakline_z: HeightSource,
}

/// What lines are for those who read the mesh: `verify` does not look at it.
#[derive(Debug, clap::Args)]
pub(crate) struct BreaklineTypeArgs {
    /// Of what type the edges along --breaklines are marked, in formats that mark them: `hard` where the slope breaks, `soft` where it
    /// need not, or `field:NAME` for what each feature says in a text field, hard or soft. Both are followed in the same way. Where lines
    /// of both types share a stretch it is hard
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "TYPE", requires = "breaklines", value_parser = line_types,
        default_value = "hard")]
    breakline_type: LineTypes,
}

impl BreaklineTypeArgs {
    /// Lines of these types.
    pub(super) fn of(&self, lines: Vec<LineInput>) -> Vec<LineInput> {
        lines.into_iter().map(|input| input.of_types(&self.breakline_type)).collect()
    }
}

impl BreaklineArgs {
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::Breaklines, self.breaklines.is_some());
        asked.add(Feature::Lakes, self.lake_polygons.is_some());
        asked.add(Feature::Footprints, self.footprints.is_some());
        asked.add(Feature::ExactCutline, self.cutline_exact);
        asked.add(Feature::LineHeights, self.breakline_z != HeightSource::Raster);
    }

    /// The lines, if there are any: one set of each kind. A cutline that is exact is one, and no longer of the view.
    pub(super) fn inputs(&self, view: &mut View) -> Vec<LineInput> {
        let layers = [
            (LineKind::Breaklines, &self.breaklines, &self.breaklines_layer, self.breakline_z.clone()),
            (LineKind::Lakes, &self.lake_polygons, &self.lake_polygons_layer, HeightSource::Lake(self.lake_z.clone())),
            (LineKind::Footprints, &self.footprints, &self.footprints_layer, HeightSource::Raster),
        ];
        let input = |(kind, path, layer, heights): (LineKind, &Option<PathBuf>, &Option<String>, HeightSource)| {
            let from = Lines::Layer(LineSource { path: path.clone()?, layer: layer.clone() });
            // Lakes keep their outlines as they are on the lattice: so it is known what is inside.
            let shift = if kind == LineKind::Lakes { 0.0 } else { self.breakline_shift };
            Some(LineInput { kind, from, shift, heights, types: LineTypes::default() })
        };
        let cutline = view.cutline.take_if(|_| self.cutline_exact).map(|CutlineSource { path, layer }| LineInput {
            kind: LineKind::Cutline,
            from: Lines::Layer(LineSource { path, layer }),
            shift: 0.0,
            heights: HeightSource::Raster,
            types: LineTypes::default(),
        });
        layers.into_iter().filter_map(input).chain(cutline).collect()
    }

    /// The files of all layers.
    pub(super) fn files(&mut self) -> [&mut Option<PathBuf>; 3] {
        [&mut self.breaklines, &mut self.lake_polygons, &mut self.footprints]
    }

    /// Whether there are lines.
    pub(super) fn are_given(&self) -> bool {
        self.breaklines.is_some() || self.lake_polygons.is_some() || self.footprints.is_some() || self.cutline_exact
    }
}

fn line_heights(word: &str) -> Result<HeightSource, String> {
    match (word, word.strip_prefix("field:")) {
        ("raster", _) => Ok(HeightSource::Raster),
        ("line", _) => Ok(HeightSource::Own),
        (_, Some(name)) if !name.is_empty() => Ok(HeightSource::Field(name.to_string())),
        _ => Err("expected raster, line or field:NAME".to_string()),
    }
}

fn line_types(word: &str) -> Result<LineTypes, String> {
    match (LineType::from_name(word), word.strip_prefix("field:")) {
        (Some(line_type), _) => Ok(LineTypes::All(line_type)),
        (None, Some(name)) if !name.is_empty() => Ok(LineTypes::Field(name.to_string())),
        _ => Err("expected hard, soft or field:NAME".to_string()),
    }
}

fn lake_height(word: &str) -> Result<LakeHeight, String> {
    match (word, word.strip_prefix("field:")) {
        ("min", _) => Ok(LakeHeight::Min),
        ("median", _) => Ok(LakeHeight::Median),
        (_, Some(name)) if !name.is_empty() => Ok(LakeHeight::Field(name.to_string())),
        _ => Err("expected min, median or field:NAME".to_string()),
    }
}

/// What mends heights that lines do not have.
const RASTER_HEIGHTS: &str =
    "--breakline-z raster takes heights from the raster, and so does the text raster in a field for one feature";

/// Why a layer of lines cannot be used.
pub(super) fn of_layer(kind: LineKind, error: ShapesError) -> Failure {
    let expected = match &error {
        ShapesError::Layer { expected, .. } => expected.as_str(),
        _ => "",
    };
    let mended = [
        ("with heights", RASTER_HEIGHTS),
        (
            "raster or line in field",
            "--breakline-z names a text field of the layer; raster and line hold for all features",
        ),
        (
            "hard or soft in field",
            "--breakline-type names a text field of the layer; hard and soft hold for all features",
        ),
        ("a number in field", "--lake-z names a field of the layer; min and median take heights from the raster"),
    ];
    match mended.into_iter().find(|(words, _)| expected.contains(words)) {
        Some((_, hint)) => Failure::new(error).hint(hint),
        None => of_shapes(error, layer_option(kind)),
    }
}

/// The option that names the layer of lines of a kind.
fn layer_option(kind: LineKind) -> &'static str {
    match kind {
        LineKind::Cutline => option(Feature::Cutline),
        LineKind::Breaklines | LineKind::Lakes | LineKind::Footprints => option(kind.feature()),
    }
}

/// What mends lakes that overlap.
const APART: &str = "make one feature of them, or take one out of the layer of --lake-polygons";

/// What mends two heights at one place, by what has them.
fn one_height(kinds: [LineKind; 2]) -> &'static str {
    match kinds.map(|kind| kind == LineKind::Lakes) {
        [true, true] => "make one feature of them, or give both one height with --lake-z field:NAME",
        [false, false] => {
            "change the z of one of them there, choose a larger --max-error (under a budget they must be the same), or take heights from the raster with --breakline-z raster"
        }
        _ => {
            "change the z of the line or the height of the lake, choose a larger --max-error (under a budget they must be the same), or take heights of lines from the raster with --breakline-z raster"
        }
    }
}

/// Why lines cannot be used that have been read.
pub(super) fn of_lines(error: &UnusableLines, failure: Failure) -> Failure {
    let fewer =
        |kind: &LineKind| format!("divide the raster with --window, or give {} fewer lines", layer_option(*kind));
    let other_crs = |kind: &LineKind| {
        format!(
            "if the coordinates are in another CRS than the layer of {} says, ogr2ogr -a_srs sets the right one",
            layer_option(*kind)
        )
    };
    match error {
        UnusableLines::Lattice { error: LinesError::TooMany, kind, .. } => failure.hint(&fewer(kind)),
        UnusableLines::Lattice { error: LinesError::TooFar { .. }, kind, .. } | UnusableLines::Outside { kind, .. } => {
            failure.hint(&other_crs(kind))
        }
        UnusableLines::NothingInside { .. } => failure.hint(&other_crs(&LineKind::Cutline)),
        UnusableLines::TwoHeights { error, .. } => failure.hint(one_height(error.of.map(|of| of.0))),
        UnusableLines::Judged { error, kind, .. } => match **error {
            VerifyError::ManyLines => failure.hint(&fewer(kind)),
            VerifyError::FarLine { .. } => failure.hint(&other_crs(kind)),
            VerifyError::TwoHeights { kinds, .. } => failure.hint(one_height(kinds)),
            VerifyError::LakesOverlap { .. } => failure.hint(APART),
            VerifyError::LineHeight { .. } => failure.hint(RASTER_HEIGHTS),
            _ => failure,
        },
        UnusableLines::Lattice { error: LinesError::Height { .. }, .. } => failure.hint(RASTER_HEIGHTS),
        UnusableLines::Lattice { error: LinesError::Overlap { .. }, .. } => failure.hint(APART),
        UnusableLines::NoLevel { .. } => {
            failure.hint("--lake-z field:NAME takes heights from the layer; or take the lake out of it")
        }
        UnusableLines::Lattice { .. } | UnusableLines::Level { .. } => failure,
    }
}
