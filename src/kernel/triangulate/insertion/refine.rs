//! Refinement: the best candidate is inserted, and what changed is scanned again, until none is left.

use super::candidates::Candidates;
use super::data_dependent::{self, Fits};
use super::importance::{self, Importance};
use super::options::{InsertionOptions, Selection, Swap};
use super::scan::{Candidate, Scanner};
use super::squares::Squares;
use super::surface::{Site, Surface};
use super::topology::next;
use crate::base::RasterRim;
use crate::base::control::{CancelToken, Cancelled};
use crate::base::handed_over::{DENSE, make_room};
use crate::base::lattice::Point;
use crate::base::mesh::{TileMesh, Vertex};
use crate::kernel::triangulate::feasible::Tester;
use crate::kernel::triangulate::progressive::Share;

/// A surface that is refined by inserting candidates, and all that has to follow each insertion.
pub(super) struct Refinement<'a> {
    pub(super) surface: &'a mut Surface,
    pub(super) candidates: &'a mut Candidates,
    pub(super) fits: &'a mut Fits,
    pub(super) star: &'a mut Vec<u32>,
    pub(super) scanner: Scanner<'a>,
    /// Where the strong test is asked for.
    pub(super) strong: Option<Tester<'a>>,
    /// What makes samples important, unless it is their error.
    pub(super) measure: Option<Box<dyn Importance>>,
    /// Memory for the samples of a triangle that a measure is asked about.
    pub(super) beyond: &'a mut Vec<Candidate>,
    pub(super) squares: &'a mut Squares,
    /// Whether samples on the rim are farther than the tolerance: vertices of it are still to come, or it was made for a
    /// larger tolerance, which the first such candidate tells; or there are channels, where rounding differs between a line
    /// and a triangle.
    pub(super) rim_is_loose: bool,
    /// Which of the rim is refined like everything else: its edges are split, which no neighbour knows of.
    pub(super) free_rim: FreeRim,
    /// Edges that are never split, the lower vertex first, in order.
    pub(super) fixed: &'a [(u32, u32)],
    /// The locked edges that were split, in their order.
    pub(super) splits: Vec<Split>,
    /// The sum of squared errors, where steps are noted.
    pub(super) sum: f64,
    /// Insertions end at this number of vertices.
    pub(super) most: usize,
    /// How it stood after every insertion, where somebody wants to know.
    pub(super) steps: Option<Vec<Step>>,
    pub(super) options: InsertionOptions,
    pub(super) cancel: &'a CancelToken,
}

/// A locked edge that was split, in its direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// Its ends.
    pub edge: [u32; 2],
    /// The vertex between them.
    pub vertex: u32,
}

/// Which locked edges may be split.
#[derive(Debug, Clone, Copy)]
pub(super) enum FreeRim {
    /// None.
    None,
    /// All.
    All,
    /// Those along the raster's own rim.
    Along(RasterRim),
    /// All others.
    Beside(RasterRim),
}

/// How a refinement stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Vertices so far.
    pub vertices: usize,
    /// The largest score of a candidate: the largest error, where that is the measure.
    pub largest: f64,
    /// The sum of squared errors over all samples.
    pub squares: f64,
}

/// Insertions between two looks at the cancellation token.
const INSERTIONS_BETWEEN_CHECKS: u32 = 256;

impl Refinement<'_> {
    /// Gives every triangle its candidate; where edges follow the data, looks at every edge once.
    pub(super) fn scan_all(&mut self) -> Result<(), Cancelled> {
        for t in 0..self.surface.topology.len() {
            if t.is_multiple_of(INSERTIONS_BETWEEN_CHECKS) {
                self.cancel.check()?;
            }
            self.rescan(t);
        }
        if let Swap::DataDependent(choice) = self.options.swap {
            for t in 0..self.surface.topology.len() {
                self.fits.rescan(self.surface, self.scanner.tile, choice.fit, t);
            }
            for e in 0..3 * self.surface.topology.len() {
                if e < self.surface.topology.twin(e) && !self.surface.topology.is_locked(e) {
                    data_dependent::swap_initial(self, choice, e);
                }
            }
        }
        Ok(())
    }

    /// Inserts candidates until there is none.
    pub(super) fn run(&mut self) -> Result<(), Cancelled> {
        match self.options.selection {
            Selection::Sequential => self.run_sequentially(),
            Selection::Fractional(share) => self.run_in_passes(share),
            // Only what is farther than the tolerance is a candidate: all are taken.
            Selection::Constant => self.run_in_passes(0.0),
        }
    }

    fn run_sequentially(&mut self) -> Result<(), Cancelled> {
        let mut insertions = 0u32;
        while let Some((t, candidate)) = self.candidates.best().filter(|_| self.surface.vertices.len() < self.most) {
            if insertions.is_multiple_of(INSERTIONS_BETWEEN_CHECKS) {
                self.cancel.check()?;
            }
            insertions = insertions.wrapping_add(1);
            self.insert(t, candidate.sample);
        }
        Ok(())
    }

    /// Passes that each insert all candidates with at least this share of the best score (section 5.4).
    fn run_in_passes(&mut self, share: f64) -> Result<(), Cancelled> {
        let mut selected: Vec<(Candidate, u32)> = Vec::new();
        while let Some((_, best)) = self.candidates.best().filter(|_| self.surface.vertices.len() < self.most) {
            self.cancel.check()?;
            self.select(share * best.score, &mut selected);
            for &(candidate, t) in &selected[..selected.len().min(self.most - self.surface.vertices.len())] {
                self.insert_again_located(t, candidate.sample);
            }
        }
        Ok(())
    }

    /// Rounds over the triangles that there are, in the order of their numbers: each of them, as it has become by its turn,
    /// gets its own candidate as a vertex, if it has one.
    pub(super) fn run_by_turns(&mut self) -> Result<(), Cancelled> {
        while !self.candidates.triangles().is_empty() {
            self.cancel.check()?;
            for t in 0..self.surface.topology.len() {
                if let Some(candidate) = self.candidates.get(t) {
                    self.insert(t, candidate.sample);
                }
            }
        }
        Ok(())
    }

    /// All candidates from a score on, best first, none twice.
    pub(super) fn select(&self, threshold: f64, into: &mut Vec<(Candidate, u32)>) {
        let all = || self.candidates.triangles().iter().filter_map(|&t| self.candidates.get(t).map(|c| (c, t)));
        let selected = || all().filter(|(c, _)| c.score >= threshold);
        make_room(into, selected().count());
        into.extend(selected());
        into.sort_unstable_by(|(a, t), (b, u)| {
            b.score.total_cmp(&a.score).then(a.sample.cmp(&b.sample)).then(t.cmp(u))
        });
        into.dedup_by_key(|(c, _)| c.sample);
    }

    /// Inserts a sample that was in a triangle once, wherever it is now.
    pub(super) fn insert_again_located(&mut self, near: u32, sample: u64) {
        let site = self.surface.locate(near, self.place(sample));
        self.insert_at(site, sample);
    }

    /// Inserts a sample of triangle `t` as a vertex. A triangle at it; `None` if the sample is on a locked edge, and then no
    /// such sample is a candidate from now on.
    pub(super) fn insert(&mut self, t: u32, sample: u64) -> Option<u32> {
        let site = self.surface.site_in(t, self.place(sample));
        let stays = self.stays(site);
        assert!(!stays || !self.rim_is_loose, "a candidate on a locked edge, whose samples are left out: {sample}");
        let inserted = self.insert_at(site, sample);
        assert!(
            inserted.is_some() || stays,
            "a candidate is no vertex yet: sample {sample} of {:?}",
            self.surface.corners(t)
        );
        inserted
    }

    /// Inserts a domain's point, before anything is scanned. A triangle at it.
    pub(super) fn preinsert(surface: &mut Surface, near: u32, vertex: Vertex) -> u32 {
        let v = surface.vertices.len() as u32;
        surface.vertices.push(vertex);
        let site = surface.locate(near, vertex.at);
        let connected = surface.connect(v, site);
        let near =
            connected.unwrap_or_else(|| panic!("a point at {:?} is inside the ground, found {site:?}", vertex.at));
        surface.legalize();
        near
    }

    pub(super) fn place(&self, sample: u64) -> Point {
        let width = self.scanner.tile.width as u64;
        Point::of_sample((sample % width) as i32, (sample / width) as i32)
    }

    /// Whether a place is on a locked edge that stays as it is.
    pub(super) fn stays(&self, site: Site) -> bool {
        let Site::Edge(e) = site else { return false };
        let ends = || [e, next(e)].map(|e| self.surface.at(self.surface.topology.origin(e)));
        let is_fixed = || {
            let [a, b] = [e, next(e)].map(|e| self.surface.topology.origin(e));
            self.fixed.binary_search(&(a.min(b), a.max(b))).is_ok()
        };
        self.surface.topology.is_locked(e)
            && match self.free_rim {
                _ if is_fixed() => true,
                FreeRim::None => true,
                FreeRim::All => false,
                FreeRim::Along(sides) => {
                    let [p, q] = ends();
                    !sides.joins(p, q)
                }
                FreeRim::Beside(sides) => {
                    let [p, q] = ends();
                    sides.joins(p, q)
                }
            }
    }

    /// Looks again at the triangles along the rim, now that samples on it are known to be farther than the tolerance.
    #[cold]
    fn leave_rim_out(&mut self) {
        if !std::mem::replace(&mut self.rim_is_loose, true) {
            for t in 0..self.surface.topology.len() {
                if self.locked(t) != [false; 3] {
                    self.rescan(t);
                }
            }
        }
    }

    /// A triangle at the new vertex; `None` where there is one already, or an edge that stays.
    pub(super) fn insert_at(&mut self, site: Site, sample: u64) -> Option<u32> {
        if self.stays(site) {
            self.leave_rim_out();
            return None;
        }
        let at = self.place(sample);
        let width = self.scanner.tile.width as u64;
        let height = self.scanner.tile.at((sample % width) as usize, (sample / width) as usize);
        let v = self.surface.vertices.len() as u32;
        let split = match site {
            Site::Edge(e) if self.surface.topology.is_locked(e) => {
                Some([e, next(e)].map(|e| self.surface.topology.origin(e)))
            }
            _ => None,
        };
        let t = self.surface.connect(v, site)?;
        self.splits.extend(split.map(|edge| Split { edge, vertex: v }));
        self.surface.vertices.push(Vertex { at, height });
        self.update(t);
        self.note(t);
        Some(t)
    }

    /// Notes how things stand; the new vertex is at corner 2 of triangle `t`.
    fn note(&mut self, t: u32) {
        if self.steps.is_none() {
            return;
        }
        self.sum += self.squares_changed(t, Share::ALL);
        let largest = self.candidates.best().map_or(0.0, |(_, c)| c.score);
        let step = Step { vertices: self.surface.vertices.len(), largest, squares: self.sum };
        self.steps.iter_mut().for_each(|steps| steps.push(step));
    }

    /// Puts the surroundings of a new vertex in order: edges, then candidates (INSERT of algorithms III and IV).
    pub(super) fn update(&mut self, t: u32) {
        match self.options.swap {
            Swap::Delaunay => {
                self.surface.legalize();
                let mut star = std::mem::take(self.star);
                self.surface.topology.star(t, &mut star);
                star.iter().for_each(|&t| self.rescan(t));
                *self.star = star;
            }
            Swap::DataDependent(choice) => data_dependent::swap_suspects(self, choice),
        }
    }

    /// Looks for a triangle's candidate anew.
    pub(super) fn rescan(&mut self, t: u32) {
        let corners = self.surface.corners(t);
        let candidate = match &self.measure {
            None => self.scanner.candidate(corners, self.left_out(t)),
            Some(measure) => {
                importance::candidate(&self.scanner, corners, self.left_out(t), measure.as_ref(), self.beyond)
            }
        };
        self.candidates.set(t, candidate.or_else(|| self.strong_candidate(t, corners)));
    }

    /// The edges of a triangle whose samples are no candidates: locked ones, once their samples are known to be farther than
    /// the tolerance.
    pub(super) fn left_out(&self, t: u32) -> [bool; 3] {
        if self.rim_is_loose { self.locked(t) } else { [false; 3] }
    }

    pub(super) fn locked(&self, t: u32) -> [bool; 3] {
        [0, 1, 2].map(|i| self.surface.topology.is_locked(3 * t + i))
    }

    /// Where the strong test is asked for and an edge of a triangle does not pass it: the sample of the triangle that is
    /// farthest from it. Its score is how far the edge strays.
    pub(super) fn strong_candidate(&self, t: u32, corners: [Vertex; 3]) -> Option<Candidate> {
        let tester = self.strong?;
        let mut strays = 0.0f64;
        let locked = self.locked(t);
        for i in 0..3 {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            if !locked[i] && !tester.strong_edge(p, q) {
                strays = strays.max(tester.edge_deviation(p, q));
            }
        }
        if strays == 0.0 {
            return None;
        }
        let sample = self.scanner.farthest_inside(corners, locked)?;
        Some(Candidate { score: strays, sample })
    }

    /// Hands the mesh over, and its memory back.
    pub(super) fn finish(self, mesh: &mut TileMesh) {
        mesh.relaxed = self.count_relaxed();
        std::mem::swap(&mut self.surface.vertices, &mut mesh.vertices);
        let topology = &self.surface.topology;
        if topology.len() as usize > DENSE {
            *self.candidates = Candidates::default();
        }
        make_room(&mut mesh.triangles, topology.len() as usize);
        mesh.triangles.extend((0..topology.len()).map(|t| topology.corners(t)));
    }

    /// Triangles with an edge that does not pass the strong test.
    pub(super) fn count_relaxed(&self) -> u64 {
        let Some(tester) = self.strong else { return 0 };
        let fails = |e: u32| {
            let topology = &self.surface.topology;
            let [p, q] = [topology.origin(e), topology.origin(next(e))].map(|v| self.surface.vertices[v as usize]);
            !topology.is_locked(e) && !tester.strong_edge(p, q)
        };
        (0..self.surface.topology.len()).filter(|t| (3 * t..3 * t + 3).any(fails)).count() as u64
    }
}
