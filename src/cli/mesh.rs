//! Which mesh is made of which raster: the options that `simplify` and `plan` share, and the request that they ask for.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::attributes::AttributeArgs;
use super::breaklines::{BreaklineArgs, BreaklineTypeArgs};
use super::combinations::Asked;
use super::coordinates::CoordinateArgs;
use super::engine::EngineArgs;
use super::format_options::FormatArgs;
use super::goal::GoalArgs;
use super::importance::ImportanceArgs;
use super::input::InputArgs;
use super::machine::{GUARD, MachineArgs};
use super::polish::PolishArgs;
use super::{Failure, output_format, values};
use crate::base::features::{Feature, FeatureSet};
use crate::formats::{self, FORMATS, Format, Precision};
use crate::job::normals::Normals;
use crate::job::rules::{default_engine, default_quality};
use crate::job::{DEFAULT_TILE, EngineChoice, Error, Params, Quality, VertexHeights};
use crate::kernel::triangulate::Feasibility;
use crate::raster::PointSource;
use crate::run::{Input, PointInput, Request, RunError, TextureInput};

/// The mesh that is asked for.
#[derive(Debug, clap::Args)]
pub(crate) struct MeshArgs {
    /// The raster: a file, or any name GDAL opens
    #[arg(value_name = "INPUT", index = 1)]
    pub(super) input: PathBuf,
    #[command(flatten)]
    pub(super) goal: GoalArgs,
    /// Test triangles at the samples under them (weak), or also where their edges cross the grid (strong)
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_enum, default_value_t = FeasibilityArg::Weak)]
    feasibility: FeasibilityArg,
    /// How much work goes into fewer triangles [default: balanced]
    #[arg(long, help_heading = "Mesh", value_enum)]
    quality: Option<QualityArg>,
    /// The heights of vertices that polishing has moved: those of samples, or fitted to the samples around them
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_enum, default_value_t = HeightsArg::Sampled)]
    heights: HeightsArg,
    /// The smallest angle, seen from above, of triangles that polishing makes, unless they replace sharper ones; 0 is no limit
    /// [default: 2 with --quality balanced or best, else 0]
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "DEGREES", value_parser = values::angle, allow_hyphen_values = true)]
    min_angle: Option<f64>,
    /// How far the surface may stray between samples: on the side between two neighbouring samples of a row or column it stays
    /// between their heights, give or take F × the tolerance. F is a number from 1 on, or inf for no limit [default: 1.5 with
    /// --quality balanced or best, else inf]
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "F", value_parser = values::max_stray,
        allow_hyphen_values = true)]
    max_stray: Option<f64>,
    /// The side of the tiles worked on one at a time; 0 makes one of the whole raster
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "CELLS", default_value_t = DEFAULT_TILE)]
    tile: usize,
    /// Simplify the rim of voids: ground within CELLS columns and rows of a missing sample may be removed. Removed samples are
    /// counted, and not covered; `verify` needs the same option
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "CELLS", default_value_t = 0, hide_default_value = true, value_parser = values::trim,
        allow_hyphen_values = true)]
    trim: u32,
    #[command(flatten)]
    pub(super) input_args: InputArgs,
    /// Fill voids of at most this many samples: the mesh covers them, at any height. A void is a group of missing samples,
    /// diagonal neighbours included, with none in the first or last row or column; 0 fills none
    #[arg(long, help_heading = "Mesh", value_name = "SAMPLES", value_parser = values::count, default_value_t = 0)]
    fill_holes: u64,
    #[command(flatten)]
    attributes: AttributeArgs,
    #[command(flatten)]
    pub(super) importance: ImportanceArgs,
    /// Normals of vertices: of the raster (gradient), or of the triangles around them (area). For PLY, GLB, OBJ and VTP
    #[arg(long, help_heading = "Format", hide_short_help = true, value_enum)]
    normals: Option<NormalsArg>,
    /// Lay an image over the mesh, in any CRS that GDAL transforms: embedded (GLB), or beside it (OBJ, with a .mtl)
    #[arg(long, help_heading = "Format", hide_short_help = true, value_name = "IMAGE")]
    texture: Option<PathBuf>,
    /// The most pixels along the longer side of --texture
    #[arg(long, help_heading = "Format", hide_short_help = true, value_name = "PIXELS", default_value_t = 4096, requires = "texture",
        value_parser = values::texture_size)]
    texture_size: usize,
    /// A layer of points, in any format OGR reads: the samples nearest to them become vertices of the mesh.
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "FILE")]
    pub(super) points: Option<PathBuf>,
    /// The layer of --points [default: the first]
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "NAME", requires = "points")]
    points_layer: Option<String>,
    #[command(flatten)]
    pub(super) breaklines: BreaklineArgs,
    #[command(flatten)]
    breakline_types: BreaklineTypeArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// Print nothing but errors
    #[arg(long, help_heading = "Run", hide_short_help = true, short, conflicts_with = "json")]
    pub(super) quiet: bool,
    /// Print the report as JSON
    #[arg(long, help_heading = "Run", hide_short_help = true)]
    pub(super) json: bool,
    // The last: their headings would be those of what follows.
    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    coordinates: CoordinateArgs,
    #[command(flatten)]
    format: FormatArgs,
    #[command(flatten)]
    polish: PolishArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QualityArg {
    /// The engine alone, the fastest there is
    None,
    /// Removes vertices whose hole can be filled directly
    Fast,
    /// Removes more vertices, and repairs the triangles around them
    Balanced,
    /// The same, until it removes no more
    Best,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum HeightsArg {
    /// Vertices stand on samples and have their heights
    Sampled,
    /// Vertices stand where triangles fit best: the fewest triangles, larger errors on the whole, in hardly more time
    Fitted,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum NormalsArg {
    /// Of the samples around each vertex: the same whatever the mesh
    Gradient,
    /// Of the triangles around each vertex, by their areas
    Area,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FeasibilityArg {
    Weak,
    Strong,
}

impl From<FeasibilityArg> for Feasibility {
    fn from(argument: FeasibilityArg) -> Feasibility {
        match argument {
            FeasibilityArg::Weak => Feasibility::Weak,
            FeasibilityArg::Strong => Feasibility::Strong,
        }
    }
}

impl MeshArgs {
    /// What the options ask for, and by which of them. What is not said is as the rule book has it.
    pub(super) fn asked(&self, format: &Format) -> Asked {
        let mut asked = self.input_args.asked();
        self.goal.ask(&mut asked);
        self.attributes.ask(&mut asked);
        self.importance.ask(&mut asked);
        asked.add(Feature::Points, self.points.is_some());
        self.breaklines.ask(&mut asked);
        asked.add(Feature::Trim, self.trim > 0);
        asked.add(Feature::FilledVoids, self.fill_holes > 0);
        asked.add(Feature::FittedHeights, self.heights == HeightsArg::Fitted);
        asked.add(Feature::MinAngle, self.min_angle.is_some_and(|floor| floor > 0.0));
        asked.add(Feature::MaxStray, self.max_stray.is_some_and(f64::is_finite));
        asked.add(Feature::StrongFeasibility, self.feasibility == FeasibilityArg::Strong);
        self.polish.ask(&mut asked);
        self.engine.ask(&mut asked);
        let has_fitted_heights = self.heights == HeightsArg::Fitted || self.breaklines.are_given();
        self.coordinates.ask(has_fitted_heights, single(format), &mut asked);
        let quality = self.quality(asked.features());
        if quality != Quality::None {
            asked.add_by(Feature::Polishing, format!("--quality {}", quality.name()));
        }
        let engine = self.engine.choice(|| default_engine(asked.features()));
        asked.add(Feature::GreedyCuts, matches!(engine, EngineChoice::GreedyCuts(_)));
        asked.add(Feature::HittingSet, matches!(engine, EngineChoice::HittingSet(_)));
        asked
    }

    /// The same once it is known that heights need all digits of doubles.
    #[cfg(test)]
    pub(super) fn asked_of_doubles(&self, format: &Format) -> Asked {
        let mut asked = self.asked(format);
        self.coordinates.ask(true, single(format), &mut asked);
        asked
    }

    /// The quality that is asked for, or the usual one for these features.
    fn quality(&self, features: FeatureSet) -> Quality {
        match self.quality {
            Some(QualityArg::None) => Quality::None,
            Some(QualityArg::Fast) => Quality::Fast,
            Some(QualityArg::Balanced) => Quality::Balanced,
            Some(QualityArg::Best) => Quality::Best,
            None => default_quality(features),
        }
    }

    /// The parameters, where these features are asked for. They go together.
    fn params(&self, features: FeatureSet) -> Params {
        let quality = self.quality(features);
        let heights = match self.heights {
            HeightsArg::Sampled => VertexHeights::Sampled,
            HeightsArg::Fitted => VertexHeights::Fitted,
        };
        Params {
            feasibility: self.feasibility.into(),
            tile: self.tile,
            trim: self.trim,
            engine: self.engine.choice(|| default_engine(features)),
            max_stray: self.max_stray,
            quality,
            heights,
            tuning: self.polish.tuning(quality, heights, self.min_angle),
            goal: self.goal.goal(),
            ..Params::new(self.goal.tolerance())
        }
    }

    /// The format of an output of this name, or of one without a name.
    pub(super) fn format(&self, output: Option<&Path>) -> Result<&'static Format, Failure> {
        let named = match output {
            Some(output) => output_format::of(output, self.format.name(), output_format::MESHES)?.name,
            None => self.format.name().unwrap_or(FORMATS[0].name),
        };
        let format = formats::by_name(named).unwrap_or(FORMATS[0]);
        self.coordinates.check(format)?;
        Ok(format)
    }

    /// The run that is asked for, to an output. Its features go together.
    pub(super) fn request(&self, features: FeatureSet, format: &'static Format, output: &Path) -> Request<'static> {
        let mut view = self.input_args.view();
        let lines = self.breakline_types.of(self.breaklines.inputs(&mut view));
        let input = Input::Raster { path: self.input.clone(), view };
        let layer = self.points_layer.clone();
        let mut request = Request {
            format: Some(format),
            guard: Some(GUARD),
            params: self.params(features),
            attributes: self.attributes.attributes(),
            importance: self.importance.input(),
            points: self.points.clone().map(|path| PointInput::Layer(PointSource { path, layer })),
            lines,
            normals: self.normals.map(|normals| match normals {
                NormalsArg::Gradient => Normals::Gradient,
                NormalsArg::Area => Normals::Area,
            }),
            texture: self.texture.clone().map(|path| TextureInput { path, size: self.texture_size }),
            fill_voids: self.fill_holes,
            coordinates: self.coordinates.coordinates(),
            sink: self.format.sink(),
            ..Request::new(input, output, self.goal.tolerance())
        };
        self.machine.apply(&mut request);
        request
    }

    /// Why a run did not get through, in the words of options.
    pub(super) fn explain(&self, error: RunError, asked: &Asked, format: &Format) -> Failure {
        let no_ground = matches!(error.of_job(), Some(Error::NoGround { .. }));
        let failure = match error {
            RunError::Incompatible(conflicts) => {
                // The raster's heights need all their digits.
                let mut asked = asked.clone();
                self.coordinates.ask(true, single(format), &mut asked);
                asked.refuse(&conflicts)
            }
            error => error.into(),
        };
        match &self.input_args.cutline.cutline {
            // Where there is no ground, it may be the cutline's doing.
            Some(file) if no_ground => failure.hint(&format!(
                "samples outside the polygons of --cutline {} have no heights: choose other polygons, if the raster has no void there; ogrinfo shows where they lie",
                file.display()
            )),
            None if no_ground && (self.input_args.marks_samples()) => {
                failure.hint("--nodata and --valid-range decide which samples have heights: choose other values")
            }
            _ => failure,
        }
    }

    /// Takes names to be those of files in a folder, where there are such files.
    pub(super) fn resolve(&mut self, folder: &Path) {
        let options = [&mut self.points, &mut self.texture, &mut self.machine.temp_dir];
        let others = [&mut self.importance.importance, &mut self.input_args.cutline.cutline];
        let files = options.into_iter().chain(others).chain(self.breaklines.files()).flatten().chain([&mut self.input]);
        for file in files {
            let there = folder.join(&*file);
            if there.exists() {
                *file = there;
            }
        }
    }
}

/// What a format is called, if it has single precision alone.
fn single(format: &Format) -> Option<&'static str> {
    (!format.precisions.contains(&Precision::Double)).then_some(format.title)
}
