//! What a run is asked for, as data.

use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::LineInput;
use crate::base::features::{Feature, FeatureSet};
use crate::base::{Band, PointSet};
use crate::field::Choice;
use crate::formats::{Format, SinkOption, SinkOptions};
use crate::job::normals::Normals;
use crate::job::{Params, VertexHeights};
#[cfg(feature = "gdal")]
use crate::raster::{PointSource, View};
use crate::run::scene::Most;

/// Where samples come from.
// There are two of them in a run.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
pub enum Input {
    /// A raster that GDAL opens, and how it is looked at.
    #[cfg(feature = "gdal")]
    Raster {
        /// A file, or any other name that GDAL opens.
        path: PathBuf,
        /// Band, window, marks of missing samples and so on.
        view: View,
    },
    /// Samples that a program reads window by window, or has in memory.
    Band(Band),
}

impl Input {
    /// What messages call it.
    pub fn path(&self) -> &Path {
        match self {
            #[cfg(feature = "gdal")]
            Input::Raster { path, .. } => path,
            Input::Band(band) => band.path(),
        }
    }
}

impl From<Band> for Input {
    fn from(band: Band) -> Input {
        Input::Band(band)
    }
}

/// The first band of a raster, all of it.
#[cfg(feature = "gdal")]
impl From<&str> for Input {
    fn from(path: &str) -> Input {
        Input::Raster { path: path.into(), view: View::default() }
    }
}

/// The first band of a raster, all of it.
#[cfg(feature = "gdal")]
impl From<&Path> for Input {
    fn from(path: &Path) -> Input {
        path.to_path_buf().into()
    }
}

/// The first band of a raster, all of it.
#[cfg(feature = "gdal")]
impl From<String> for Input {
    fn from(path: String) -> Input {
        PathBuf::from(path).into()
    }
}

/// The first band of a raster, all of it.
#[cfg(feature = "gdal")]
impl From<PathBuf> for Input {
    fn from(path: PathBuf) -> Input {
        Input::Raster { path, view: View::default() }
    }
}

/// Further bands that become attributes of the vertices.
#[derive(Debug, Clone)]
pub struct Attributes {
    /// Which.
    pub bands: AttributeBands,
    /// What they count in the error, from 0 (only heights do) to 1 (only attributes). In an image it is 1.
    pub weight: f64,
    /// The input is an image without heights: they are 0 everywhere.
    pub image: bool,
}

/// The bands of [`Attributes`].
#[derive(Debug, Clone)]
pub enum AttributeBands {
    /// All bands of the input's raster: for an image.
    #[cfg(feature = "gdal")]
    All,
    /// These bands of the input's raster, from 1.
    #[cfg(feature = "gdal")]
    Numbers(Vec<usize>),
    /// These bands, each as large as the input.
    Bands(Vec<Band>),
}

/// Where the points come from that become vertices.
#[derive(Debug, Clone)]
pub enum PointInput {
    /// A layer of points: the samples nearest to them.
    #[cfg(feature = "gdal")]
    Layer(PointSource),
    /// These samples.
    Samples(Arc<PointSet>),
    /// The samples nearest to these places on the map of the input; those beyond its rim are left out and counted.
    Places(Arc<[(f64, f64)]>),
}

/// An image that is laid over the mesh.
#[cfg(feature = "gdal")]
#[derive(Debug, Clone, PartialEq)]
pub struct TextureInput {
    /// An image that GDAL opens, in any CRS.
    pub path: PathBuf,
    /// The most pixels along its longer side.
    pub size: usize,
}

/// How coordinates are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinates {
    /// x and y less an origin near the middle of the raster, which the header names.
    pub local: bool,
    /// Heights are multiplied by this; finite, above 0.
    pub z_scale: f64,
    /// Coordinates in single precision, which implies `local`.
    pub single: bool,
}

impl Default for Coordinates {
    fn default() -> Self {
        Coordinates { local: false, z_scale: 1.0, single: false }
    }
}

impl Coordinates {
    /// Whether heights keep their digits where they are multiplied by [`Coordinates::z_scale`].
    pub fn scales_exactly(&self) -> bool {
        self.z_scale.log2().fract() == 0.0
    }
}

/// Is told which files are mapped from now on, and what the unfinished output is called, before any sample of them is
/// looked at. Where another process truncates a mapped file, the next look at it raises SIGBUS, which ends this process: a
/// program that catches the signal can say why and remove the output. An error ends the run.
pub type Guard<'a> = dyn Fn(&[PathBuf], &Path) -> io::Result<()> + Sync + 'a;

/// A run from samples to a mesh in a file: everything that the command `simplify` can be asked for.
///
/// [`Request::new`] has everything as usual; fields may then be changed. What does not go together is refused before
/// anything is read ([`crate::job::rules`]).
#[derive(Clone)]
pub struct Request<'a> {
    /// The heights.
    pub input: Input,
    /// The mesh.
    pub output: PathBuf,
    /// The format of the mesh; `None` goes by the extension of the output.
    pub format: Option<&'static Format>,
    /// Options of the format.
    pub sink: SinkOptions,
    /// Whether an existing output is replaced.
    pub overwrite: bool,
    /// What decides the mesh. [`Params::points`] is not looked at: see [`Request::points`].
    pub params: Params,
    /// Further bands, as attributes of the vertices.
    pub attributes: Option<Attributes>,
    /// Weights of errors, on the samples of the input: error × weight is within the tolerance.
    pub importance: Option<Input>,
    /// Samples that become vertices.
    pub points: Option<PointInput>,
    /// Lines that become edges of the mesh, one set of each kind at the most. [`Params::breaklines`] is not looked at.
    pub lines: Vec<LineInput>,
    /// Normals of vertices, as the format has them.
    pub normals: Option<Normals>,
    /// An image over the mesh, as the format has it.
    #[cfg(feature = "gdal")]
    pub texture: Option<TextureInput>,
    /// Voids up to this number of samples are filled: the mesh goes on over them, bound by no tolerance there. 0 fills none.
    pub fill_voids: u64,
    /// How coordinates are written.
    pub coordinates: Coordinates,
    /// How samples are read.
    pub access: Choice,
    /// Where it is given, the raster's own file may be mapped, which is faster; else it is read by windows.
    pub guard: Option<&'a Guard<'a>>,
    /// The most memory to use; `None` is [`crate::job::default_budget`].
    pub memory: Option<u64>,
    /// Threads to work with; fewer if the memory is for fewer, and `None` as many as the machine has cores.
    pub threads: Option<NonZeroUsize>,
    /// A folder that keeps finished tiles: after an interruption the same request goes on there.
    pub work_dir: Option<PathBuf>,
    /// Whether the work dir stays, with all its tiles, once the output is there.
    pub keep_work_dir: bool,
    /// How much of the mesh is in [`super::Report::scene`], for looking at it; `None` for nothing. It costs no pass over the raster.
    pub scene: Option<Most>,
}

impl Request<'_> {
    /// A run with everything as usual: within this vertical distance of every sample, in the unit of the heights.
    pub fn new(input: impl Into<Input>, output: impl Into<PathBuf>, max_error: f64) -> Request<'static> {
        Request {
            input: input.into(),
            output: output.into(),
            format: None,
            sink: SinkOptions::default(),
            overwrite: false,
            params: Params::new(max_error),
            attributes: None,
            importance: None,
            points: None,
            lines: Vec::new(),
            normals: None,
            #[cfg(feature = "gdal")]
            texture: None,
            fill_voids: 0,
            coordinates: Coordinates::default(),
            access: Choice::Auto,
            guard: None,
            memory: None,
            threads: None,
            work_dir: None,
            keep_work_dir: false,
            scene: None,
        }
    }

    /// What of the features of a run it asks for.
    pub fn features(&self) -> FeatureSet {
        let image = self.attributes.as_ref().is_some_and(|a| a.image);
        let wanted = [
            (Feature::Image, image),
            (Feature::Attributes, self.attributes.is_some() && !image),
            (Feature::Importance, self.importance.is_some()),
            (Feature::Points, self.points.is_some()),
            (Feature::FilledVoids, self.fill_voids > 0),
            (Feature::InexactScale, !self.coordinates.scales_exactly()),
            // Fitted heights need all digits of doubles.
            (Feature::RoundedToSingle, self.coordinates.single && self.has_fitted_heights()),
        ];
        let wanted: FeatureSet = wanted.into_iter().filter(|(_, is_wanted)| *is_wanted).map(|(f, _)| f).collect();
        wanted.and(self.params.features()).and(self.of_view()).and(LineInput::features(&self.lines))
    }

    /// Whether vertices may have heights that no sample has.
    pub(super) fn has_fitted_heights(&self) -> bool {
        self.params.heights == VertexHeights::Fitted || !self.lines.is_empty()
    }

    #[cfg(feature = "gdal")]
    fn of_view(&self) -> FeatureSet {
        let Input::Raster { view, .. } = &self.input else { return FeatureSet::default() };
        let wanted = [
            (Feature::Band, view.band.is_some()),
            (Feature::Encoding, view.encoding.is_some()),
            (Feature::NodataMarks, !view.nodata.is_empty()),
            (Feature::ValidRange, view.valid_range.is_some()),
            (Feature::Cutline, view.cutline.is_some()),
        ];
        wanted.into_iter().filter(|(_, is_wanted)| *is_wanted).map(|(f, _)| f).collect()
    }

    #[cfg(not(feature = "gdal"))]
    fn of_view(&self) -> FeatureSet {
        FeatureSet::default()
    }

    /// What it asks of the format beside [`Request::sink`].
    pub(super) fn further_options(&self) -> impl Iterator<Item = SinkOption> + use<> {
        #[cfg(feature = "gdal")]
        let texture = self.texture.is_some();
        #[cfg(not(feature = "gdal"))]
        let texture = false;
        let all = [(SinkOption::Normals, self.normals.is_some()), (SinkOption::Texture, texture)];
        all.into_iter().filter(|(_, is_asked)| *is_asked).map(|(option, _)| option)
    }

    /// Files that are read: the output is none of them.
    pub(crate) fn inputs(&self) -> Vec<&Path> {
        let mut all = vec![self.input.path()];
        all.extend(self.importance.as_ref().map(Input::path));
        all.extend(self.lines.iter().filter_map(LineInput::file));
        #[cfg(feature = "gdal")]
        {
            if let Input::Raster { view, .. } = &self.input {
                all.extend(view.cutline.as_ref().map(|cutline| cutline.path.as_path()));
            }
            if let Some(PointInput::Layer(source)) = &self.points {
                all.push(&source.path);
            }
            all.extend(self.texture.as_ref().map(|texture| texture.path.as_path()));
        }
        all
    }
}
