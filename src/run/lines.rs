//! Lines that become edges of the mesh: what a run is asked for, read and brought to the raster's samples.

use std::path::{Path, PathBuf};

use super::inputs::Opened;
use super::lakes::{LakeHeight, with_levels};
use super::{RunError, Warned};
use crate::base::control::CancelToken;
use crate::base::external::Scratch;
use crate::base::features::FeatureSet;
use crate::base::warning::Warning;
use crate::base::{Band, LineKind, LineSet, LineType, Polylines};
use crate::job::lines::{Lines as Held, LinesFailure};
use crate::kernel::breaklines::{LinesError, TwoHeights};
#[cfg(feature = "gdal")]
use crate::raster::{LineAsk, LineMemory, LineSource, Said, ShapesError, read_lines, read_outlines};
use crate::verify::{RequiredLines, VerifyError};

/// The most vertices of a layer that are held in memory, but for what has an inside.
#[cfg(feature = "gdal")]
const VERTICES_IN_MEMORY: usize = 1 << 20;

/// Lines of one kind that become edges of the mesh.
#[derive(Debug, Clone)]
pub struct LineInput {
    /// What they are. A run has one input of each kind at the most.
    pub kind: LineKind,
    /// Where they come from.
    pub from: Lines,
    /// How far edges may be from a line's places, at the most, in cells; 0 for lakes and cutlines.
    pub shift: f64,
    /// Which heights edges have; footprints and cutlines have the raster's.
    pub heights: HeightSource,
    /// Of what type they are; outlines are hard. Who judges a mesh does not look at types.
    pub types: LineTypes,
}

/// The lines of a [`LineInput`].
#[derive(Debug, Clone)]
pub enum Lines {
    /// A layer of lines, or of polygons where they are outlines of lakes, footprints or a cutline.
    #[cfg(feature = "gdal")]
    Layer(LineSource),
    /// These lines, through places on the map of the input; outlines end where they begin, or are closed.
    Places(Polylines),
}

/// Where heights along lines come from.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum HeightSource {
    /// The raster's surface.
    #[default]
    Raster,
    /// The lines themselves, which have z.
    Own,
    /// What the feature says in this text field: `raster` or `line`; for breaklines of a layer.
    Field(String),
    /// Each lake has one; for lakes alone.
    Lake(LakeHeight),
}

/// Of what type breaklines are.
#[derive(Debug, Clone, PartialEq)]
pub enum LineTypes {
    /// All of one.
    All(LineType),
    /// What the feature says in this text field, hard or soft; for those of a layer.
    Field(String),
    /// Each of its own; for those that are given as places.
    Each(Vec<LineType>),
}

impl Default for LineTypes {
    fn default() -> LineTypes {
        LineTypes::All(LineType::Hard)
    }
}

impl LineTypes {
    /// What they are called.
    pub fn name(&self) -> String {
        match self {
            LineTypes::All(line_type) => line_type.name().to_string(),
            LineTypes::Field(name) => format!("field:{name}"),
            LineTypes::Each(_) => "each".to_string(),
        }
    }
}

impl HeightSource {
    /// What it is called.
    pub fn name(&self) -> String {
        match self {
            HeightSource::Raster => "raster".to_string(),
            HeightSource::Own => "line".to_string(),
            HeightSource::Field(name) => format!("field:{name}"),
            HeightSource::Lake(height) => height.name(),
        }
    }
}

impl LineInput {
    /// The same lines, of these types if they are breaklines.
    #[must_use]
    pub fn of_types(self, types: &LineTypes) -> LineInput {
        match self.kind {
            LineKind::Breaklines => LineInput { types: types.clone(), ..self },
            LineKind::Lakes | LineKind::Footprints | LineKind::Cutline => self,
        }
    }

    /// The file of the layer, if they come from one.
    pub(super) fn file(&self) -> Option<&Path> {
        match &self.from {
            #[cfg(feature = "gdal")]
            Lines::Layer(source) => Some(&source.path),
            Lines::Places(_) => None,
        }
    }

    /// The layer, where one is named.
    pub(super) fn layer(&self) -> Option<&str> {
        match &self.from {
            #[cfg(feature = "gdal")]
            Lines::Layer(source) => source.layer.as_deref(),
            Lines::Places(_) => None,
        }
    }

    /// What all lines of a run ask of it.
    pub(super) fn features(all: &[LineInput]) -> FeatureSet {
        let may_have_own = |heights: &HeightSource| matches!(heights, HeightSource::Own | HeightSource::Field(_));
        LineSet::features(all.iter().map(|input| (input.kind, may_have_own(&input.heights))))
    }
}

/// Why lines cannot be used that have been read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnusableLines {
    /// They cannot be put on the lattice.
    #[error("{}: {error}", path.display())]
    Lattice {
        /// The layer's file, or the raster where there is none.
        path: PathBuf,
        /// What they are.
        kind: LineKind,
        /// Why not.
        error: LinesError,
    },
    /// Nothing of them lies on the raster, or nothing has a length there.
    #[error("{}: expected {} on the raster, found none of {lines} that has a length there on the lattice of quarter cells", path.display(), kind.name())]
    Outside {
        /// The layer's file, or the raster where there is none.
        path: PathBuf,
        /// What they are.
        kind: LineKind,
        /// How many lines there are, each ring of a polygon being one.
        lines: u64,
    },
    /// Nothing of the raster is inside of a cutline.
    #[error("{}: expected a cutline around some of the raster, found nothing inside of {lines} outlines", path.display())]
    NothingInside {
        /// The layer's file, or the raster where there is none.
        path: PathBuf,
        /// How many outlines there are.
        lines: u64,
    },
    /// Lines have no heights of their own.
    #[error("{}: expected {} with heights, found lines of two coordinates", path.display(), kind.name())]
    Level {
        /// The raster: no file has the lines.
        path: PathBuf,
        /// What they are.
        kind: LineKind,
    },
    /// Nothing can be judged by them.
    #[error("{}: {error}", path.display())]
    Judged {
        /// The layer's file, or the raster where there is none.
        path: PathBuf,
        /// What they are.
        kind: LineKind,
        /// Why not.
        error: Box<VerifyError>,
    },
    /// A lake has no height.
    #[error("{}: expected samples with heights on the rim of every lake, found the rim of feature {feature} in a void of the raster", path.display())]
    NoLevel {
        /// The layer's file, or the raster where there is none.
        path: PathBuf,
        /// The lake.
        feature: u64,
    },
    /// Several heights at one place.
    #[error("{}: {error}", path.display())]
    TwoHeights {
        /// The layer's file, or the raster where there is none.
        path: PathBuf,
        /// Where, and which.
        error: TwoHeights,
    },
}

/// What messages call lines of a kind: their layer's file, or the raster.
pub(super) fn path(inputs: &[LineInput], kind: LineKind, band: &Band) -> PathBuf {
    let input = inputs.iter().find(|input| input.kind == kind);
    input.and_then(LineInput::file).unwrap_or(band.path()).to_path_buf()
}

impl Opened {
    /// All lines that become edges.
    pub(super) fn lines(
        &self,
        inputs: &[LineInput],
        temp_dir: Option<&Path>,
        warned: &Warned<'_>,
        cancel: &CancelToken,
    ) -> Result<Vec<LineSet>, RunError> {
        let read = |input: &LineInput| {
            let sets = self.line_sets(input, temp_dir, cancel)?;
            let without_geometry = sets.iter().map(|set| set.lines.without_geometry()).sum();
            let told = input.file().and_then(|file| Warning::of_no_geometry(file, without_geometry));
            told.into_iter().for_each(|found| warned.tell(found));
            Ok(sets)
        };
        Ok(inputs.iter().map(read).collect::<Result<Vec<_>, RunError>>()?.concat())
    }

    /// The lines of an input: more than one set where some have heights of their own and others do not, or are of another type.
    fn line_sets(
        &self,
        input: &LineInput,
        temp_dir: Option<&Path>,
        cancel: &CancelToken,
    ) -> Result<Vec<LineSet>, RunError> {
        let &LineInput { kind, ref from, shift, ref heights, ref types } = input;
        let wants_heights = *heights == HeightSource::Own;
        let lines = match from {
            #[cfg(feature = "gdal")]
            Lines::Layer(source) => {
                let shapes = |error| RunError::Shapes { kind, error };
                let nowhere = || shapes(ShapesError::NoRaster { path: source.path.clone() });
                let raster = self.raster.as_ref().ok_or_else(nowhere)?;
                // What has an inside is held in memory.
                let vertices = if kind.has_inside() { usize::MAX } else { VERTICES_IN_MEMORY };
                let memory = LineMemory { temp_dir: temp_dir.map(Path::to_path_buf), vertices };
                match kind {
                    LineKind::Breaklines => {
                        let sets = read_lines(raster, source, &ask(heights, types), &memory, cancel);
                        sets.map_err(shapes)?
                    }
                    LineKind::Lakes | LineKind::Footprints | LineKind::Cutline => {
                        let field = match heights {
                            HeightSource::Lake(LakeHeight::Field(name)) => Some(name.as_str()),
                            _ => None,
                        };
                        vec![read_outlines(raster, source, field, &memory, cancel).map_err(shapes)?]
                    }
                }
            }
            Lines::Places(lines) => {
                let _ = (temp_dir, cancel);
                let path = self.band.path().to_path_buf();
                // No field says anything of them.
                if (wants_heights || matches!(heights, HeightSource::Field(_))) && lines.heights().is_none() {
                    return Err(UnusableLines::Level { path, kind }.into());
                }
                let lines = match kind {
                    LineKind::Breaklines if wants_heights => lines.clone(),
                    LineKind::Breaklines => lines.clone().without_heights(),
                    LineKind::Lakes | LineKind::Footprints | LineKind::Cutline => lines.closed(),
                };
                let transform = self.band.geo_transform();
                let placed = lines.placed(|&(x, y)| transform.sample_coordinates(x, y));
                let is_finite = |(column, row): &&(f64, f64)| column.is_finite() && row.is_finite();
                if let Some(&(column, row)) = placed.lines().iter().flatten().find(|place| !is_finite(place)) {
                    let error = LinesError::TooFar { column, row };
                    return Err(UnusableLines::Lattice { path, kind, error }.into());
                }
                by_type(placed, types)
            }
        };
        let with_level = |lines| match heights {
            HeightSource::Lake(height) => {
                let path = input.file().unwrap_or(self.band.path());
                with_levels(lines, height, (&self.band, path), cancel)
            }
            HeightSource::Raster | HeightSource::Own | HeightSource::Field(_) => Ok(lines),
        };
        lines.into_iter().map(|lines| Ok(LineSet { kind, lines: with_level(lines)?, shift })).collect()
    }
}

/// What is asked of a layer of breaklines.
#[cfg(feature = "gdal")]
fn ask(heights: &HeightSource, types: &LineTypes) -> LineAsk {
    let with_heights = match heights {
        HeightSource::Field(name) => Said::Field(name.clone()),
        heights => Said::Of(*heights == HeightSource::Own),
    };
    let types = match types {
        LineTypes::Field(name) => Said::Field(name.clone()),
        LineTypes::All(line_type) => Said::Of(*line_type),
        // These are of lines that are no layer's.
        LineTypes::Each(_) => Said::Of(LineType::Hard),
    };
    LineAsk { with_heights, types }
}

/// Lines in memory, those of each type for themselves.
fn by_type(lines: Polylines, types: &LineTypes) -> Vec<Polylines> {
    let each = match types {
        LineTypes::All(line_type) => return vec![lines.of_type(*line_type)],
        // No field says anything of them.
        LineTypes::Field(_) => return vec![lines],
        LineTypes::Each(each) => each,
    };
    let of = |line_type| lines.only(|line| each.get(line) == Some(&line_type)).of_type(line_type);
    let sets: Vec<Polylines> =
        [LineType::Hard, LineType::Soft].map(of).into_iter().filter(|set| set.count() > 0).collect();
    if sets.is_empty() { vec![lines] } else { sets }
}

/// All lines on the lattice of the heights; `None` where there are none.
pub(super) fn on_lattice(
    inputs: &[LineInput],
    sets: &[LineSet],
    band: &Band,
    scratch: Scratch,
) -> Result<Option<Held>, RunError> {
    if sets.is_empty() {
        return Ok(None);
    }
    let of = |kind| path(inputs, kind, band);
    let failed = |failure| match failure {
        LinesFailure::Lattice(kind, error) => RunError::from(UnusableLines::Lattice { path: of(kind), kind, error }),
        LinesFailure::Scratch(error) => crate::job::Error::from(error).into(),
    };
    let lines = Held::new(sets, (band.width(), band.height()), scratch, Held::IN_MEMORY).map_err(failed)?;
    for (kind, counts) in lines.counts() {
        let (path, lines_read) = (of(kind), counts.lines);
        match kind {
            // One around all of the raster has no line on it.
            LineKind::Cutline if lines.leave_nothing() => {
                return Err(UnusableLines::NothingInside { path, lines: lines_read }.into());
            }
            LineKind::Breaklines | LineKind::Lakes | LineKind::Footprints
                if lines.counts().all(|(other, counts)| other != kind || counts.segments == 0) =>
            {
                let of_kind = lines.counts().filter(|(other, _)| *other == kind);
                let lines_read = of_kind.map(|(_, counts)| counts.lines).sum();
                return Err(UnusableLines::Outside { path, kind, lines: lines_read }.into());
            }
            _ => {}
        }
    }
    Ok(Some(lines))
}

/// Makes sure that a mesh is judged by some of the lines of each kind.
pub(super) fn check_judged(
    inputs: &[LineInput],
    sets: &[LineSet],
    band: &Band,
    required: &RequiredLines,
) -> Result<(), RunError> {
    // A cutline around all of the raster has no line on it.
    for kind in [LineKind::Breaklines, LineKind::Lakes, LineKind::Footprints] {
        let of_kind = || sets.iter().enumerate().filter(|(_, set)| set.kind == kind);
        if of_kind().next().is_some() && !of_kind().any(|(number, _)| required.has_segments(number)) {
            let lines = of_kind().map(|(_, set)| set.lines.count() as u64).sum();
            return Err(UnusableLines::Outside { path: path(inputs, kind, band), kind, lines }.into());
        }
    }
    Ok(())
}
