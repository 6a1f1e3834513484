//! What became of layers: of polygons, lines and points.

use std::path::Path;

use serde::Serialize;

use crate::base::{Cutline, LineKind, PointCounts};
use crate::job::{Mesh, Params};
use crate::kernel::breaklines::{ChainCounts, LineCounts};
#[cfg(feature = "gdal")]
use crate::run::PointInput;
use crate::run::{Input, Request};

/// Polygons outside of which samples count as missing.
#[derive(Debug, Clone, Serialize)]
pub struct CutlineReport {
    /// The layer's file; empty where a program gave the polygons.
    pub file: String,
    /// How many.
    pub polygons: u64,
    /// The vertices of all of them.
    pub vertices: u64,
}

/// Lines that were asked to be edges.
#[derive(Debug, Clone, Serialize)]
pub struct LinesReport {
    /// The layer's file; empty where a program gave the lines.
    pub file: String,
    /// Where their heights come from: raster, line or a field, for lakes min, median or a field.
    pub z: String,
    /// Of what type they are: hard, soft or a field; each where a program gave lines with types of their own.
    pub types: String,
    /// How far edges may be from lines, in cells.
    pub shift: f64,
    /// How many edges of the mesh follow soft lines alone; 0 for outlines.
    pub soft_edges: u64,
    /// What became of the lines. Where fields say where heights come from, or what type lines are, those of either kind are counted for
    /// themselves.
    #[serde(flatten)]
    pub counts: LineCounts,
    /// What became of them on the ground.
    pub chains: ChainCounts,
}

/// Points that were asked to be vertices.
#[derive(Debug, Clone, Serialize)]
pub struct PointsReport {
    /// The layer's file; empty where a program gave the samples.
    pub file: String,
    /// The layer.
    pub layer: String,
    /// What became of them.
    #[serde(flatten)]
    pub counts: PointCounts,
}

impl LinesReport {
    pub(super) fn new(kind: LineKind, request: &Request<'_>, params: &Params, mesh: &Mesh) -> Option<LinesReport> {
        let input = request.lines.iter().find(|input| input.kind == kind)?;
        // Several sets of a kind where some lines have heights of their own, or are soft.
        let of_kind = params.breaklines.as_ref()?.counts().zip(mesh.chains()).filter(|((of, _), _)| *of == kind);
        let (counts, chains) = of_kind.map(|((_, counts), chains)| (counts, *chains)).reduce(|(a, b), (c, d)| {
            let counts = LineCounts {
                lines: a.lines + c.lines,
                left_out: a.left_out + c.left_out,
                segments: a.segments + c.segments,
                largest_rounding: a.largest_rounding.max(c.largest_rounding),
            };
            (counts, ChainCounts { edges: b.edges + d.edges, off_ground: b.off_ground + d.off_ground })
        })?;
        Some(LinesReport {
            file: shown(input.file()),
            z: input.heights.name(),
            types: input.types.name(),
            shift: input.shift,
            soft_edges: if kind == LineKind::Breaklines { mesh.soft_edges() } else { 0 },
            counts,
            chains,
        })
    }
}

impl CutlineReport {
    pub(super) fn new(cutline: &Cutline, request: &Request<'_>) -> CutlineReport {
        let file = match &request.input {
            #[cfg(feature = "gdal")]
            Input::Raster { view, .. } => view.cutline.as_ref().map(|source| source.path.as_path()),
            Input::Band(_) => None,
        };
        let (polygons, vertices) = cutline.counts();
        CutlineReport { file: shown(file), polygons, vertices }
    }
}

impl PointsReport {
    pub(super) fn new(layer: &str, counts: PointCounts, request: &Request<'_>) -> PointsReport {
        let file = match &request.points {
            #[cfg(feature = "gdal")]
            Some(PointInput::Layer(source)) => Some(source.path.as_path()),
            _ => None,
        };
        PointsReport { file: shown(file), layer: layer.to_string(), counts }
    }
}

/// A path as text; empty where there is none.
fn shown(path: Option<&Path>) -> String {
    path.map_or(String::new(), |path| path.display().to_string())
}
