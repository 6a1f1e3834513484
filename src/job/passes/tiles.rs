//! The first pass: a tile from its samples to a polished mesh whose rim is locked, because its neighbours have the same
//! vertices there.

use super::seams::Final;
use super::workspace::Workspace;
use super::{Job, Maker, Run};
use crate::base::control::Cancelled;
use crate::base::lattice;
use crate::base::mesh::{Domain, TileMesh};
use crate::base::tiling::TilePlace;
use crate::base::{Tile, Window};
use crate::job::goal::Told;
use crate::job::{Error, Quality, quality};
use crate::kernel::boundary;
use crate::kernel::measure::{Bare, Bound, ErrorStats, HeightStats, measure, measure_weighted, shape};
use crate::kernel::polish::{self, count_relaxed};
use crate::kernel::seam::{MinLink, Rim};
use crate::kernel::triangulate::insertion::mend_tile;
use crate::kernel::triangulate::{EngineScratch, Task};

/// What one thread needs to take a tile from its samples to its chunk.
#[derive(Default)]
pub(in crate::job) struct TileMaker {
    pub(in crate::job) shared: Workspace,
    min_link: MinLink,
    /// Samples that trimming has taken from the ground of the tile.
    trimmed: u64,
    pub(super) engine: EngineScratch,
    polish: polish::Scratch,
    pub(in crate::job) mesh: TileMesh,
    pub(in crate::job) told: Vec<Told>,
}

/// What a tile comes to that is made by itself.
#[derive(Debug, Clone, Copy)]
pub(in crate::job) struct Probed {
    pub(in crate::job) samples: u64,
    pub(in crate::job) vertices: u64,
    pub(in crate::job) triangles: u64,
    /// The sum of the squares of errors, and of how many; zeros where nobody wanted them.
    pub(in crate::job) squares: f64,
    pub(in crate::job) measured: u64,
}

/// What the heights of a tile's samples are like.
#[derive(Debug, Clone, Copy)]
pub(in crate::job) struct Looked {
    /// From the least to the greatest; none where there is no ground.
    pub(in crate::job) span: Option<f64>,
    /// Whether all are whole numbers.
    pub(in crate::job) are_whole: bool,
}

impl Maker for TileMaker {
    fn shared(&mut self) -> &mut Workspace {
        &mut self.shared
    }

    fn make(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<(), Error> {
        let Run { job, clocks, .. } = *run;
        let (rim, bound) = match &job.end {
            None => {
                clocks.load.time(|| self.shared.load(job.field, job.params, place.window))?;
                let mut rim = clocks.seams.time(|| self.rim(job, place))?;
                clocks.engine.time(|| self.cut(job, &mut rim))?;
                clocks.polish.time(|| self.polish(job, &rim))?;
                (rim, Bound::Within(job.params.tolerance.kept()))
            }
            Some(end) => clocks.engine.time(|| self.run_to(job, place, end))?,
        };
        let errors = clocks.measure.time(|| self.measure(run, place, bound));
        clocks.spool.time(|| {
            let checksum = self.shared.checksum();
            let Workspace { tile, chunk, .. } = &mut self.shared;
            chunk.fill(place.index, &rim, &mut self.mesh, errors, checksum);
            run.set_attributes(chunk, tile);
        });
        Ok(())
    }
}

impl TileMaker {
    /// Measures the mesh, and looks at its shape. If other passes follow, only at the shape and the weighted error of what they
    /// will not change: the last of them measures the height of every sample.
    fn measure(&mut self, run: &Run<'_>, place: &TilePlace, bound: Bound) -> ErrorStats {
        let params = run.job.params;
        if !run.later.is_empty() {
            let settled = Final::new(run.later, place);
            let settles = |corners: [lattice::Point; 3]| settled.has(corners);
            let seen = shape(&self.shared.tile, &self.mesh, params.tolerance.kept(), run.job.max_stray, settles);
            if self.mesh.relaxed > 0 {
                self.mesh.relaxed = count_relaxed(&self.shared.tile, &self.mesh, params.tolerance.kept(), settles);
            }
            let (tile, tolerance) = (&self.shared.tile, params.tolerance.kept());
            let extended = measure_weighted(tile, &self.mesh, tolerance, place, settles);
            let (trimmed, shape) = (self.trimmed, Some(Box::new(seen)));
            return ErrorStats { trimmed, shape, extended, ..ErrorStats::default() };
        }
        let mut errors = measure(&self.shared.tile, &self.mesh, bound, place, self.bare(run.job));
        errors.heights = Some(HeightStats::of(&self.shared.tile));
        assert_eq!(errors.trimmed, self.trimmed, "bare samples of the tile at {:?}", place.origin());
        // Whoever has no time for polishing has none for looking at it.
        if params.quality != Quality::None {
            errors.shape = Some(Box::new(shape(
                &self.shared.tile,
                &self.mesh,
                params.tolerance.kept(),
                run.job.max_stray,
                |_| true,
            )));
        }
        errors
    }

    /// Makes one tile as if it were a raster of its own, and tells what it comes to. Errors are measured if they are wanted.
    pub(in crate::job) fn probe(
        &mut self,
        job: &Job<'_>,
        place: &TilePlace,
        wants_errors: bool,
    ) -> Result<Probed, Error> {
        let place = TilePlace { last_column: true, last_row: true, ..*place };
        self.shared.load(job.field, job.params, place.window)?;
        let mut rim = self.rim(job, &place)?;
        self.cut(job, &mut rim)?;
        self.polish(job, &rim)?;
        let (width, height) = (place.window.width as u64, place.window.height as u64);
        let mut probed = Probed {
            samples: width * height,
            vertices: self.mesh.vertices.len() as u64,
            triangles: self.mesh.triangles.len() as u64,
            squares: 0.0,
            measured: 0,
        };
        if wants_errors {
            let bound = Bound::Within(job.params.tolerance.kept());
            let errors = measure(&self.shared.tile, &self.mesh, bound, &place, self.bare(job));
            (probed.squares, probed.measured) = (errors.squares, errors.samples);
        }
        Ok(probed)
    }

    /// Looks at the heights of a tile's samples.
    pub(in crate::job) fn look(&mut self, job: &Job<'_>, place: &TilePlace) -> Result<Looked, Error> {
        self.shared.load(job.field, job.params, place.window)?;
        let heights = HeightStats::of(&self.shared.tile).all();
        let tile = &self.shared.tile;
        let places = || (0..tile.height()).flat_map(|row| (0..tile.width()).map(move |column| (column, row)));
        let are_whole = places().all(|(column, row)| tile.at(column, row).fract() == 0.0);
        let validity = tile.validity();
        let is_ground = |(column, row)| validity.is_ground(column as i32, row as i32);
        let ground =
            if validity.is_whole() { places().count() } else { places().filter(|&place| is_ground(place)).count() };
        let span = (ground > 0 && !heights.is_empty()).then_some(heights.max - heights.min);
        Ok(Looked { span, are_whole })
    }

    /// What of the ground the mesh of the tile that is loaded may leave bare.
    fn bare(&self, job: &Job<'_>) -> Bare {
        let may_be_bare = job.params.trim > 0 && !self.shared.tile.validity().is_whole();
        if may_be_bare { Bare::Strip(job.params.trim) } else { Bare::Nothing }
    }

    /// The rim of the tile that is loaded, and the points inside it.
    fn rim(&mut self, job: &Job<'_>, place: &TilePlace) -> Result<Rim, Error> {
        self.find_points(job, place.window)?;
        let (Workspace { tile, points, chains, .. }, cancel) = (&self.shared, &job.control.cancel);
        let (tolerance, cells) = (job.params.tolerance.kept(), job.params.trim);
        let mut rim = Rim::with_sides(tile, tolerance, job.sides(), points, chains, place, &mut self.min_link, cancel)?;
        let fixed = rim.on_sides();
        let task = boundary::Task { tile, cells, tolerance, points, cancel };
        self.trimmed = boundary::trim(&task, &mut rim.domain, fixed)?;
        Ok(rim)
    }

    /// Finds the points of the tile that is loaded, and makes sure that they are on the ground.
    pub(super) fn find_points(&mut self, job: &Job<'_>, window: Window) -> Result<(), Error> {
        self.shared.find_features(job, window)?;
        let validity = self.shared.tile.validity();
        let off_ground = |&&(column, row): &&(usize, usize)| !validity.is_ground(column as i32, row as i32);
        match self.shared.points.iter().find(off_ground).filter(|_| !validity.is_whole()) {
            Some(&(column, row)) => {
                Err(Error::PointOffGround { column: window.column + column, row: window.row + row })
            }
            None => Ok(()),
        }
    }

    fn cut(&mut self, job: &Job<'_>, rim: &mut Rim) -> Result<(), Cancelled> {
        if rim.domain.loops.is_empty() {
            self.mesh.clear();
            return Ok(());
        }
        let tolerance = job.params.tolerance.kept();
        job.params.engine.triangulate(
            &task(&self.shared.tile, &rim.domain, tolerance, job),
            &mut self.engine,
            &mut self.mesh,
        )?;
        let nothing = Domain::default();
        let bare = task(&self.shared.tile, &nothing, tolerance, job);
        // What the sides leave, the passes after this one mend.
        mend_tile(&bare, &mut rim.domain, &mut self.engine, &mut self.mesh).map(|_| ())
    }

    fn polish(&mut self, job: &Job<'_>, rim: &Rim) -> Result<(), Cancelled> {
        let Some(options) = quality::polishing(job.params).filter(|_| !rim.domain.loops.is_empty()) else {
            return Ok(());
        };
        let task = task(&self.shared.tile, &rim.domain, job.params.tolerance.kept(), job);
        polish::polish(&task, &options, &mut self.polish, &mut self.mesh)
    }
}

/// What engines and polishing are given of a tile.
pub(super) fn task<'a>(tile: &'a Tile, domain: &'a Domain, tolerance: f64, job: &Job<'a>) -> Task<'a> {
    let (feasibility, max_stray, cancel) = (job.params.feasibility, job.max_stray, &job.control.cancel);
    Task { tile, domain, tolerance, feasibility, max_stray, cancel }
}
