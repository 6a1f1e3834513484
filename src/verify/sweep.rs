//! Comparing the mesh with the samples, row by row.

use crate::base::control::{Control, Stage};

use super::VerifyError;
use super::band::{Band, Buffers, Planes};
use super::feed::Feed;
use super::finding::{Finding, SamplePlace, TouchPlace};
use super::grid::Grid;
use super::ground::{Ground, GroundFindings};
use super::lines::{RequiredLines, Unbound};
use super::observe::Observer;
use super::outline::{Outline, OutlineFindings};
use super::samples::{Bands, Rows};
use super::strays::{Held, StrayFindings, Strays};
use super::task::Told;
use super::triangle::{TRIANGLE_WORDS, Triangle, TriangleWords};
use super::verdict::{WeightedWorst, WorstSample};
use crate::base::external::{Scratch, Sorted};

/// What the comparison of all samples with all triangles finds.
#[derive(Debug, Default)]
pub(super) struct Comparison {
    /// Whether errors are weighted.
    pub(super) weighted: bool,
    pub(super) worst: Option<WorstSample>,
    /// Where error × weight is largest; `None` where errors are not weighted.
    pub(super) weighted_worst: Option<WeightedWorst>,
    /// Of the error, over the covered samples.
    pub(super) sum_of_squares: f64,
    /// Samples with a height that lie in a triangle.
    pub(super) covered: u64,
    pub(super) above: Finding<SamplePlace>,
    pub(super) overlapped: Finding<SamplePlace>,
    /// Samples beside lines whose heights are others.
    pub(super) beside: u64,
    /// Samples without a height that lie in a triangle.
    pub(super) touched: Finding<TouchPlace>,
    /// The least and the largest height.
    pub(super) range: Option<[f64; 2]>,
    pub(super) ground: GroundFindings,
    pub(super) outline: OutlineFindings,
    /// What was found out about straying, where there is a limit.
    pub(super) strays: Option<StrayFindings>,
}

/// Holds the triangles, sorted by first row, against the samples, band by band, and the edges of the boundary against
/// that of the ground. While all threads work on a band, one of them reads the next; while they work on a batch of
/// triangles, one of them gets the next.
///
/// Where lines are told, cells beside them are held to nothing, should there be a limit on straying.
///
/// Memory use is constant whatever the mesh and the threads, because two bands and two batches are held at a time, and
/// triangles that reach into the next band wait for it in a queue ([`Feed`]). An observer takes 4 bytes more for each sample of a
/// band, at most.
pub(super) fn sweep<'s, 'c>(
    mut reader: Bands<'_>,
    grid: Grid,
    triangles: Sorted<'s, TRIANGLE_WORDS>,
    outline: Outline<'s>,
    (tolerance, (held, lines)): (f64, (Option<Held<'c>>, Option<&'c RequiredLines>)),
    (scratch, observer): (&'s Scratch, Option<&mut dyn Observer>),
    control: &'c Control<'c>,
) -> Result<Comparison, VerifyError> {
    let bands = reader.count();
    let samples = grid.width as u64 * grid.height as u64;
    control.progress.begin(Stage::Compare, bands as u64, samples);
    let mut sweep = Sweep {
        grid,
        tolerance,
        held,
        lines,
        above: Rows::default(),
        control,
        observer,
        told: Vec::new(),
        buffers: Buffers::default(),
        triangles: Feed::new(triangles, scratch),
        batches: Default::default(),
        planes: Planes::default(),
        ground: Ground::new(grid, matches!(outline, Outline::Cut(_))),
        outline,
        comparison: Comparison {
            weighted: reader.are_weighted(),
            strays: held.map(|_| StrayFindings::default()),
            ..Comparison::default()
        },
        row: 0,
    };
    let (mut here, mut next) = (Rows::default(), Rows::default());
    reader.read(0, &mut here)?;
    for index in 0..bands {
        let ahead = || if index + 1 < bands { reader.read(index + 1, &mut next) } else { Ok(()) };
        let (is_read, is_done) = rayon::join(ahead, || sweep.pass(&here));
        is_done?;
        is_read?;
        std::mem::swap(&mut here, &mut next);
    }
    control.progress.end(Stage::Compare);
    let Sweep { ground, outline, comparison, .. } = sweep;
    let beside = reader.beside_lines();
    Ok(Comparison { ground: ground.found, outline: outline.found(), beside, ..comparison })
}

/// What passes over the raster.
struct Sweep<'s, 'c, 'o> {
    grid: Grid,
    tolerance: f64,
    /// What the surface between samples is held to, if it is.
    held: Option<Held<'c>>,
    /// The lines beside which it is held to nothing.
    lines: Option<&'c RequiredLines>,
    /// The row above the next ones, where there is a limit and a row.
    above: Rows,
    control: &'c Control<'c>,
    observer: Option<&'o mut dyn Observer>,
    /// The heights of the last row that it was told of.
    told: Vec<f64>,
    buffers: Buffers,
    triangles: Feed<'s, TRIANGLE_WORDS>,
    /// The batch that is worked on, and one that has been used; and what is made of a batch.
    batches: [Vec<TriangleWords>; 2],
    planes: Planes,
    ground: Ground,
    outline: Outline<'s>,
    comparison: Comparison,
    /// The first row that has not passed.
    row: i64,
}

impl Sweep<'_, '_, '_> {
    /// Passes over the next rows.
    fn pass(&mut self, rows: &Rows) -> Result<(), VerifyError> {
        let (grid, cancel) = (self.grid, &self.control.cancel);
        let (samples, buffers) = (rows.samples(), std::mem::take(&mut self.buffers));
        let mut band = Band::new((grid, self.tolerance), self.row, samples, buffers);
        let inside = self.observer.as_ref().and_then(|_| samples.inside());
        let heights = inside.as_deref().unwrap_or(samples.heights);
        let told = self.observer.as_ref().map(|o| Told { observer: o.row_observer(), heights, above: &self.told });
        if self.observer.as_ref().is_some_and(|observer| observer.needs_errors()) {
            band.hold_errors();
        }
        let above = (self.row > 0).then(|| self.above.samples());
        // Cells between the row above and the last one.
        let near =
            self.lines.filter(|_| self.held.is_some()).map(|lines| Unbound::near(lines, self.row - 1..band.rows.1));
        let unbound = near.transpose()?;
        let held = self.held.map(|held| Held { unbound: unbound.as_ref(), ..held });
        let mut strays = held.map(|held| Strays::new(grid, held, self.row, above, rows.samples()));
        self.row = band.rows.1;
        let (after, between) = (self.row, strays.is_some());
        let goes_on = |words: &TriangleWords| {
            let triangle = Triangle::from_words(words);
            (if between { triangle.rows_around(&grid) } else { triangle.rows(&grid) }).1 >= after
        };
        let (triangles, planes) = (&mut self.triangles, &mut self.planes);
        triangles.begin();
        let [here, next] = &mut self.batches;
        *here = triangles.next(std::mem::take(here), after, goes_on)?;
        loop {
            cancel.check()?;
            let is_last = Feed::is_last(here);
            if !is_last && told.is_some_and(|told| told.observer.is_some()) {
                band.hold_errors();
            }
            let mut compare = || {
                band.compare(here, planes, told.as_ref().filter(|_| is_last));
                strays.iter_mut().for_each(|strays| strays.compare(planes.all()));
            };
            if is_last {
                compare();
                break;
            }
            let used = std::mem::take(next);
            let (following, ()) = rayon::join(|| triangles.next(used, after, goes_on), compare);
            *next = std::mem::replace(here, following?);
        }
        cancel.check()?;
        band.add_to(&mut self.comparison);
        if let Some(observer) = &mut self.observer {
            observer.rows(&band.observed(heights, &self.told)).map_err(VerifyError::Observer)?;
            self.told.clear();
            self.told.extend_from_slice(&heights[heights.len() - grid.width as usize..]);
        }
        if let (Some(strays), Some(found)) = (&strays, &mut self.comparison.strays) {
            strays.add_to(found);
            self.above.keep_last(rows, grid.width as usize);
        }
        self.outline.follow(&mut self.ground.settle(band.samples, &band.marks))?;
        self.control.progress.step(Stage::Compare, band.samples.heights.len() as u64);
        self.buffers = band.into_buffers();
        Ok(())
    }
}
