//! Algorithms I and II of the paper (sections 4.1 and 4.2), small and slow: what algorithm III must agree with. And Franklin's.

use super::super::first;
use super::super::scan::Scan;
use super::super::surface::{Site, Surface};
use crate::base::Tile;
use crate::base::lattice::Point;
use crate::base::mesh::{Domain, TileMesh, Vertex};
use crate::kernel::triangulate::feasible::Plane;

/// Algorithm I: on every pass every sample is located and interpolated anew.
pub(super) fn algorithm_i(tile: &Tile, domain: &Domain, tolerance: f64) -> TileMesh {
    let mut oracle = Oracle::new(tile, domain, tolerance);
    loop {
        let errors: Vec<f64> = (0..tile.width() * tile.height()).map(|sample| oracle.error(sample)).collect();
        let Some(best) = oracle.best(&errors) else { return oracle.into_mesh() };
        oracle.insert(best);
    }
}

/// Algorithm II: errors are kept, and computed anew where the triangulation has changed.
pub(super) fn algorithm_ii(tile: &Tile, domain: &Domain, tolerance: f64) -> TileMesh {
    let mut oracle = Oracle::new(tile, domain, tolerance);
    let mut cache: Vec<f64> = (0..tile.width() * tile.height()).map(|sample| oracle.error(sample)).collect();
    while let Some(best) = oracle.best(&cache) {
        let changed = oracle.insert(best);
        for (sample, error) in cache.iter_mut().enumerate() {
            let p = oracle.place(sample);
            if changed.iter().any(|&t| oracle.holds(t, p)) {
                *error = oracle.error(sample);
            }
        }
    }
    oracle.into_mesh()
}

/// Franklin's rounds: every triangle that there is when a round begins, in turn, is searched for its farthest sample.
pub(super) fn by_turns(tile: &Tile, domain: &Domain, tolerance: f64) -> TileMesh {
    let mut oracle = Oracle::new(tile, domain, tolerance);
    loop {
        let (before, samples) = (oracle.surface.vertices.len(), tile.width() * tile.height());
        for t in 0..oracle.surface.topology.len() {
            let error = |sample| if oracle.holds(t, oracle.place(sample)) { oracle.error_in(t, sample) } else { -1.0 };
            let errors: Vec<f64> = (0..samples).map(error).collect();
            oracle.best(&errors).map(|best| oracle.insert(best));
        }
        if oracle.surface.vertices.len() == before {
            return oracle.into_mesh();
        }
    }
}

struct Oracle<'a> {
    tile: &'a Tile,
    tolerance: f64,
    surface: Surface,
}

impl Oracle<'_> {
    fn new<'a>(tile: &'a Tile, domain: &Domain, tolerance: f64) -> Oracle<'a> {
        let mut surface = Surface::default();
        first::triangulate(domain, &mut surface);
        Oracle { tile, tolerance, surface }
    }

    fn place(&self, sample: usize) -> Point {
        Point::of_sample((sample % self.tile.width()) as i32, (sample / self.tile.width()) as i32)
    }

    fn holds(&self, t: u32, p: Point) -> bool {
        let [a, b, c] = self.surface.corners(t).map(|v| v.at);
        [(a, b), (b, c), (c, a)].iter().all(|&(a, b)| crate::base::lattice::orient(a, b, p) >= 0)
    }

    /// LOCATE_AND_INTERPOLATE, and how far the sample is from it; negative unless it is beyond the tolerance, exactly.
    fn error(&self, sample: usize) -> f64 {
        let p = self.place(sample);
        let t = match self.surface.locate(0, p) {
            Site::Vertex(_) | Site::Outside => return -1.0,
            Site::Edge(e) => e / 3,
            Site::Triangle(t) => t,
        };
        self.error_in(t, sample)
    }

    fn error_in(&self, t: u32, sample: usize) -> f64 {
        let p = self.place(sample);
        let [a, b, c] = self.surface.corners(t);
        let (column, row) = (sample % self.tile.width(), sample / self.tile.width());
        let height = self.tile.at(column, row);
        if Plane::new(a, b, c).within(p, height, self.tolerance) {
            return -1.0;
        }
        Scan::new(self.tile.width(), [a, b, c]).error(column as i32, row as i32, height)
    }

    fn best(&self, errors: &[f64]) -> Option<usize> {
        let mut best = None;
        for (sample, &error) in errors.iter().enumerate() {
            if error >= 0.0 && best.is_none_or(|b: usize| error > errors[b]) {
                best = Some(sample);
            }
        }
        best
    }

    /// INSERT; the triangles around the new vertex.
    fn insert(&mut self, sample: usize) -> Vec<u32> {
        let at = self.place(sample);
        let height = self.tile.at(sample % self.tile.width(), sample / self.tile.width());
        let site = self.surface.locate(0, at);
        let v = self.surface.vertices.len() as u32;
        self.surface.vertices.push(Vertex { at, height });
        let t = self.surface.connect(v, site).expect("no vertex is there yet");
        self.surface.legalize();
        self.surface.topology.check();
        let mut star = Vec::new();
        self.surface.topology.star(t, &mut star);
        star
    }

    fn into_mesh(self) -> TileMesh {
        let topology = &self.surface.topology;
        let triangles = (0..topology.len()).map(|t| topology.corners(t)).collect();
        TileMesh { triangles, vertices: self.surface.vertices, relaxed: 0 }
    }
}
