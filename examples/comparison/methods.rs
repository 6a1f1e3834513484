//! The methods: what each makes of a window within a tolerance.

use terrabite::base::control::{CancelToken, Control};
use terrabite::base::mesh::{Domain, TileMesh};
use terrabite::base::tiling::TilePlace;
use terrabite::field::{Field, FieldOptions};
use terrabite::job::{Mesh, Params, Quality, triangulate};
use terrabite::kernel::seam::{MinLink, Rim};
use terrabite::kernel::triangulate::cuts::GreedyCuts;
use terrabite::kernel::triangulate::hitting_set::{
    Corners, HittingSet, Literal, Partition, Reading, Squares, partition, stitch_literally,
};
use terrabite::kernel::triangulate::insertion::{
    DataDependent, Fit, GreedyInsertion, InsertionOptions, Scratch, Shape, Swap,
};
use terrabite::kernel::triangulate::{Engine, EngineChoice, EngineScratch, Feasibility, Task};

use super::Window;
use crate::paper::{Outcome, rectangle};

/// A mesh, of one tile alone or of a whole run.
pub(crate) enum Made {
    /// By an engine.
    Tile(TileMesh),
    /// By all passes of a run.
    Run(Box<Mesh>),
    /// No mesh: squares that hold every sample.
    Squares(Partition),
}

/// A way to triangulate a window.
pub(crate) struct Method {
    /// What the table calls it.
    pub(crate) name: &'static str,
    /// Does it.
    pub(crate) make: fn(&Window, f64) -> Outcome<Made>,
}

/// All of them, in the order of the table.
pub(crate) const METHODS: &[Method] = &[
    Method { name: "franklin-delaunay", make: |w, e| Ok(Made::Tile(franklin(Swap::Delaunay, w, e)?)) },
    Method { name: "franklin-error", make: |w, e| Ok(Made::Tile(franklin(LARGEST_ERROR, w, e)?)) },
    Method { name: "cuts-weak", make: |w, e| by_engine(&GreedyCuts::PLAIN, Feasibility::Weak, w, e) },
    Method { name: "cuts-strong", make: |w, e| by_engine(&GreedyCuts::PLAIN, Feasibility::Strong, w, e) },
    Method { name: "improved-weak", make: |w, e| by_engine(&GreedyCuts::IMPROVED, Feasibility::Weak, w, e) },
    Method { name: "improved-strong", make: |w, e| by_engine(&GreedyCuts::IMPROVED, Feasibility::Strong, w, e) },
    Method { name: "insertion", make: |w, e| by_engine(&GreedyInsertion::default(), Feasibility::Weak, w, e) },
    Method { name: "sp-a", make: |w, e| divided(Squares::Nested, Corners::Free, w, e) },
    Method { name: "sp-a-sliding", make: |w, e| divided(Squares::Sliding, Corners::Free, w, e) },
    Method { name: "sp-b", make: |w, e| divided(Squares::Nested, Corners::Samples, w, e) },
    Method { name: "sp-b-sliding", make: |w, e| divided(Squares::Sliding, Corners::Samples, w, e) },
    Method { name: "stitched-disjoint", make: |w, e| Ok(Made::Tile(stitched(Reading::Disjoint, w, e)?.mesh)) },
    Method { name: "stitched-shared", make: |w, e| Ok(Made::Tile(stitched(Reading::Shared, w, e)?.mesh)) },
    Method { name: "hitting-set", make: |w, e| by_engine(&HittingSet::default(), Feasibility::Weak, w, e) },
    Method { name: "cuts-polished", make: |w, e| polished(GreedyCuts::PLAIN, w, e) },
    Method { name: "insertion-polished", make: |w, e| polished(GreedyInsertion::default(), w, e) },
    Method { name: "hitting-set-polished", make: |w, e| polished(HittingSet::default(), w, e) },
];

/// An edge is swapped if that makes the largest error of its two triangles smaller.
const LARGEST_ERROR: Swap =
    Swap::DataDependent(DataDependent { fit: Fit::LInfinity, shape: Shape::AreaOverDiameter, quality_threshold: 0.0 });

/// Franklin's algorithm.
pub(crate) fn franklin(swap: Swap, window: &Window, tolerance: f64) -> Outcome<TileMesh> {
    let engine = GreedyInsertion { options: InsertionOptions { swap, ..InsertionOptions::default() } };
    on_domain(window, &rectangle(&window.tile), Feasibility::Weak, tolerance, |task, mesh| {
        engine.triangulate_by_turns(task, &mut Scratch::default(), mesh)
    })
}

/// An engine as a run uses it: sides of the fewest links, then the engine.
fn by_engine(engine: &dyn Engine, feasibility: Feasibility, window: &Window, tolerance: f64) -> Outcome<Made> {
    let place = TilePlace::alone(window.tile.width(), window.tile.height());
    let rim = Rim::new(&window.tile, tolerance, &[], &place, &mut MinLink::default(), &CancelToken::default())?;
    let mesh = on_domain(window, &rim.domain, feasibility, tolerance, |task, mesh| {
        engine.triangulate(task, &mut EngineScratch::default(), mesh)
    })?;
    Ok(Made::Tile(mesh))
}

/// A simplicial partition.
fn divided(squares: Squares, corners: Corners, window: &Window, tolerance: f64) -> Outcome<Made> {
    Ok(Made::Squares(partition(&window.tile, tolerance, squares, corners, &CancelToken::default())?))
}

/// A partition with free heights, stitched as the paper has it.
pub(crate) fn stitched(reading: Reading, window: &Window, tolerance: f64) -> Outcome<Literal> {
    Ok(stitch_literally(&window.tile, tolerance, reading, Corners::Free, &CancelToken::default())?)
}

fn on_domain<E: std::error::Error + 'static>(
    window: &Window,
    domain: &Domain,
    feasibility: Feasibility,
    tolerance: f64,
    make: impl FnOnce(&Task<'_>, &mut TileMesh) -> Result<(), E>,
) -> Outcome<TileMesh> {
    let (cancel, mut mesh) = (CancelToken::default(), TileMesh::default());
    let task = Task { tile: &window.tile, domain, tolerance, feasibility, max_stray: f64::INFINITY, cancel: &cancel };
    make(&task, &mut mesh)?;
    Ok(mesh)
}

/// A run as `terrabite simplify --quality balanced` makes it.
fn polished(engine: impl Into<EngineChoice>, window: &Window, tolerance: f64) -> Outcome<Made> {
    let control = Control::default();
    let field = Field::open(&window.band()?, &FieldOptions::default(), &control)?;
    let params = Params { engine: engine.into(), quality: Quality::Balanced, ..Params::new(tolerance) };
    Ok(Made::Run(Box::new(triangulate(&field, &params, &control)?)))
}
