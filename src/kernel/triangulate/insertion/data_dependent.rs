//! Data-dependent swapping (section 4.5, algorithm IV): of the two diagonals of a quadrilateral, the one whose triangles
//! fit the samples better stays, unless the other's shapes are much better.

use super::options::{DataDependent, Fit, Shape};
use super::refine::Refinement;
use super::scan::{Candidate, Farthest, Scan};
use super::surface::Surface;
use super::topology::{next, prev};
use crate::base::lattice::{Point, distance2, orient};
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};

/// The fit of every triangle, kept so that it is never computed twice. Memory: 8 bytes per triangle.
#[derive(Debug, Default)]
pub(super) struct Fits {
    of: Vec<f64>,
}

impl Fits {
    pub(super) fn clear(&mut self) {
        self.of.clear();
    }

    fn set(&mut self, t: u32, fit: f64) {
        if t as usize >= self.of.len() {
            self.of.resize(t as usize + 1, 0.0);
        }
        self.of[t as usize] = fit;
    }

    /// Computes the fit of one triangle.
    pub(super) fn rescan(&mut self, surface: &Surface, tile: &Tile, fit: Fit, t: u32) {
        let mut plane = FitPlane::new(tile, surface.corners(t));
        scan_triangle(tile, fit, &mut plane);
        self.set(t, plane.fit);
    }
}

/// What is gathered over a triangle while it is scanned, in one pass (the paper's *FitPlane*): its fit and its farthest
/// sample. Where there are channels errors are weighted errors, as in section 4.6. The fit counts every sample once among the triangles that share its edge; the farthest is that of the closed
/// triangle, so that no sample is overlooked whichever triangle is scanned later.
struct FitPlane {
    scan: Scan,
    corners: [Vertex; 3],
    fit: f64,
    farthest: Farthest,
    done: bool,
}

impl FitPlane {
    fn new(tile: &Tile, corners: [Vertex; 3]) -> FitPlane {
        let farthest = Farthest { error: -1.0, sample: 0 };
        FitPlane { scan: Scan::of(tile, corners), corners, fit: 0.0, farthest, done: false }
    }

    /// A triangle that was scanned before (FITPLANE_EXTRACT).
    fn known(tile: &Tile, corners: [Vertex; 3], fit: f64) -> FitPlane {
        FitPlane { fit, done: true, ..FitPlane::new(tile, corners) }
    }

    /// SCAN_POINT.
    #[inline(always)]
    fn point(&mut self, tile: &Tile, accumulate: Fit, column: i32, row: i32, height: f64, counts: bool) {
        let error = self.scan.counted(tile, column, row, height);
        if counts {
            match accumulate {
                Fit::L2 => self.fit += error * error,
                Fit::LInfinity | Fit::MaxSum => self.fit = if error > self.fit { error } else { self.fit },
            }
        }
        let sample = row as u64 * self.scan.width() as u64 + column as u64;
        let farther = error > self.farthest.error || error == self.farthest.error && sample < self.farthest.sample;
        if farther {
            self.farthest = Farthest { error, sample };
        }
    }
}

/// ERROR_COMBINE.
fn combine(fit: Fit, a: f64, b: f64) -> f64 {
    match fit {
        Fit::L2 | Fit::MaxSum => a + b,
        Fit::LInfinity => a.max(b),
    }
}

/// Scans a triangle for its own plane.
fn scan_triangle(tile: &Tile, fit: Fit, plane: &mut FitPlane) {
    let visit = |plane: &mut FitPlane, column: i32, row: i32, height: f64, owned: bool| {
        plane.point(tile, fit, column, row, height, owned);
    };
    let [a, b, c] = plane.corners;
    each_sample(tile, [a, b, c], |column, row, height, owned| visit(plane, column, row, height, owned));
}

/// Visits the samples of a closed triangle, by row, and says which are its own (see [`crate::kernel::triangulate::feasible::Spans`]).
fn each_sample(tile: &Tile, corners: [Vertex; 3], mut visit: impl FnMut(i32, i32, f64, bool)) {
    match &tile.heights {
        Heights::F32(heights) => each_sample_of(tile, heights, corners, &mut visit),
        Heights::F64(heights) => each_sample_of(tile, heights, corners, &mut visit),
    }
}

#[inline(always)]
fn each_sample_of<H: Copy + Into<f64>>(
    tile: &Tile,
    heights: &[H],
    [a, b, c]: [Vertex; 3],
    visit: &mut impl FnMut(i32, i32, f64, bool),
) {
    let spans = crate::kernel::triangulate::feasible::Spans::new(a.at, b.at, c.at);
    let (right_rim, lower_rim) = (tile.width as i32 - 1, tile.height as i32 - 1);
    for row in spans.rows() {
        let (first, last) = spans.columns(row);
        let (own_first, own_last) = spans.own_columns(row, right_rim, lower_rim);
        let offset = row as usize * tile.width;
        for column in first..=last {
            let owned = own_first <= column && column <= own_last;
            visit(column, row, heights[offset + column as usize].into(), owned);
        }
    }
}

/// The paper's four subtriangles in one pass: every sample of the quadrilateral a, b, c, d, cut by its diagonals, is held
/// against the plane of the triangle it lies in with diagonal b–d and the one with diagonal a–c. A sample on a–c is held
/// against both of the latter.
fn scan_quadrilateral(
    tile: &Tile,
    fit: Fit,
    ends: (Point, Point),
    current: [&mut FitPlane; 2],
    other: [&mut FitPlane; 2],
) {
    let [dac, bca] = other;
    for plane in current {
        let corners = plane.corners;
        each_sample(tile, corners, |column, row, height, owned| {
            if !plane.done {
                plane.point(tile, fit, column, row, height, owned);
            }
            let side = orient(ends.0, ends.1, Point::of_sample(column, row));
            if side >= 0 {
                dac.point(tile, fit, column, row, height, owned);
            }
            if side <= 0 {
                bca.point(tile, fit, column, row, height, owned && side < 0);
            }
        });
    }
}

/// Looks at an edge of the first triangulation.
pub(super) fn swap_initial(refinement: &mut Refinement<'_>, choice: DataDependent, e: u32) {
    check_swap(refinement, choice, e, None);
    swap_suspects(refinement, choice);
}

/// CHECK_SWAP for all edges marked as suspect, and those that become so.
pub(super) fn swap_suspects(refinement: &mut Refinement<'_>, choice: DataDependent) {
    // What the flip before found out about the triangle left of a suspect edge.
    let mut known: Vec<(u32, FitPlane)> = Vec::new();
    while let Some(e) = refinement.surface.take_suspect() {
        let left = known.pop_if(|(t, _)| *t == e / 3).map(|(_, plane)| plane);
        let flipped = check_swap(refinement, choice, e, left);
        known.extend(flipped.into_iter().flatten());
    }
}

/// Decides for the edge `e` from b to d, with a to its left and c to its right; `abd` is what is known of the left
/// triangle. After a flip: the two new triangles with their planes, in the order in which their outer edges are suspect.
fn check_swap(
    refinement: &mut Refinement<'_>,
    choice: DataDependent,
    e: u32,
    abd: Option<FitPlane>,
) -> Option<[(u32, FitPlane); 2]> {
    let tile = refinement.scanner.tile;
    let t = e / 3;
    let [b, d, a] = corners_from(refinement.surface, e);
    let mut abd = abd.unwrap_or_else(|| FitPlane::new(tile, [a, b, d]));
    let f = refinement.surface.topology.twin(e);
    if refinement.surface.topology.is_locked(e) || !refinement.surface.is_convex(e) {
        if !abd.done {
            scan_triangle(tile, choice.fit, &mut abd);
        }
        set_candidate(refinement, t, &abd);
        return None;
    }
    let u = f / 3;
    let c = corners_from(refinement.surface, f)[2];
    let mut cdb = FitPlane::known(tile, [c, d, b], refinement.fits.of[u as usize]);
    let (mut dac, mut bca) = (FitPlane::new(tile, [d, a, c]), FitPlane::new(tile, [b, c, a]));
    scan_quadrilateral(tile, choice.fit, (a.at, c.at), [&mut abd, &mut cdb], [&mut dac, &mut bca]);
    let shapes = [shape(choice.shape, [a, b, c, d]), shape(choice.shape, [b, c, d, a])];
    let fits = [combine(choice.fit, abd.fit, cdb.fit), combine(choice.fit, dac.fit, bca.fit)];
    abd.done = true;
    if first_is_better(choice.quality_threshold, shapes, fits) {
        set_candidate(refinement, t, &abd);
        return None;
    }
    let [t, u] = refinement.surface.flip(e);
    (dac.done, bca.done) = (true, true);
    // flip marks u's outer edge first, then t's: t's is looked at first. t = (b, c, a), u = (c, d, a).
    debug_assert_eq!(refinement.surface.corners(t), [b, c, a]);
    Some([(u, dac), (t, bca)])
}

/// The ends of a half-edge and the vertex opposite, as vertices.
fn corners_from(surface: &Surface, e: u32) -> [Vertex; 3] {
    [e, next(e), prev(e)].map(|e| surface.vertices[surface.topology.origin(e) as usize])
}

/// SET_CANDIDATE.
fn set_candidate(refinement: &mut Refinement<'_>, t: u32, plane: &FitPlane) {
    refinement.fits.set(t, plane.fit);
    if refinement.measure.is_some() {
        return refinement.rescan(t);
    }
    let corners = refinement.surface.corners(t);
    let locked = refinement.left_out(t);
    let tile = refinement.scanner.tile;
    let plain = !tile.is_weighted() && tile.channel_error.is_none();
    let candidate: Option<Candidate> = if locked == [false; 3] && plain {
        refinement.scanner.settle(&plane.scan, plane.corners, plane.farthest)
    } else {
        refinement.scanner.candidate(corners, locked)
    };
    let candidate = candidate.or_else(|| refinement.strong_candidate(t, corners));
    refinement.candidates.set(t, candidate);
}

/// FIRST_BETTER.
fn first_is_better(threshold: f64, shapes: [f64; 2], fits: [f64; 2]) -> bool {
    let (low, high) = (shapes[0].min(shapes[1]), shapes[0].max(shapes[1]));
    if low <= threshold * high { shapes[0] >= shapes[1] } else { fits[0] <= fits[1] }
}

/// SHAPE_QUALITY of the quadrilateral a, b, c, d split by b–d.
fn shape(shape: Shape, [a, b, c, d]: [Vertex; 4]) -> f64 {
    let triangles = [[a.at, b.at, d.at], [c.at, d.at, b.at]];
    let area = |[p, q, r]: [Point; 3]| orient(p, q, r) as f64;
    let sides = |[p, q, r]: [Point; 3]| [distance2(q, r), distance2(r, p), distance2(p, q)].map(|d| d as f64);
    match shape {
        Shape::AreaOverDiameter => {
            let of = |t| area(t) / sides(t).into_iter().fold(0.0, f64::max).sqrt();
            of(triangles[0]) * of(triangles[1])
        }
        Shape::SmallestAngle => {
            // The smallest angle of a triangle is below 90°, where the sine grows: 2·area over the two longer sides.
            let of = |t| {
                let [x, y, z] = sides(t);
                area(t) / (x * y * z / x.min(y).min(z)).sqrt()
            };
            of(triangles[0]).min(of(triangles[1]))
        }
    }
}
