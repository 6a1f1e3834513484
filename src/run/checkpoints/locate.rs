//! The surface at places between samples.

use crate::base::GeoTransform;

/// Finds the face over each of some places, as all faces pass. Memory: 56 bytes for each place.
pub(super) struct Locator {
    /// In quarters of cells from the first sample, by y: x, y, and which place it is.
    places: Vec<(f64, f64, usize)>,
    /// How far inside of the face the place is, as its least weight there, and the surface.
    found: Vec<Option<(f64, f64)>>,
}

/// Quarters of cells in a cell.
const STEPS: f64 = 4.0;
/// What rounding may do to places, in quarters of cells; and to weights.
const NEAR: f64 = 1e-6;

impl Locator {
    /// For places on the map; those that are beyond all numbers are over no face.
    pub(super) fn new(transform: GeoTransform, places: impl Iterator<Item = (f64, f64)>) -> Locator {
        let place = |(index, (x, y)): (usize, (f64, f64))| {
            let (column, row) = transform.sample_coordinates(x, y);
            (column * STEPS, row * STEPS, index)
        };
        let mut places: Vec<_> = places.enumerate().map(place).collect();
        let found = vec![None; places.len()];
        places.retain(|(x, y, _)| x.is_finite() && y.is_finite());
        places.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.2.cmp(&b.2)));
        Locator { places, found }
    }

    /// Of faces that share a place the one counts that it lies farthest inside of, of several such the first.
    pub(super) fn face(&mut self, corners: [(i64, i64); 3], heights: [f64; 3]) {
        let [a, b, c] = corners.map(|(x, y)| (x as f64, y as f64));
        let (low, high) = (a.1.min(b.1).min(c.1) - NEAR, a.1.max(b.1).max(c.1) + NEAR);
        let first = self.places.partition_point(|place| place.1 < low);
        for &(x, y, index) in self.places[first..].iter().take_while(|place| place.1 <= high) {
            let turn = |p: (f64, f64), q: (f64, f64)| (q.0 - p.0) * (y - p.1) - (q.1 - p.1) * (x - p.0);
            let weights = [turn(b, c), turn(c, a), turn(a, b)];
            let area: f64 = weights.iter().sum();
            let weights = weights.map(|weight| weight / area);
            let least = weights[0].min(weights[1]).min(weights[2]);
            let found = &mut self.found[index];
            if least >= -NEAR && found.is_none_or(|(before, _)| least > before) {
                let [za, zb, zc] = heights;
                let surface = za + (weights[1] * (zb - za) + weights[2] * (zc - za));
                *found = surface.is_finite().then_some((least, surface)).or(*found);
            }
        }
    }

    /// The surface at each of the places, in their order.
    pub(super) fn finish(self) -> impl Iterator<Item = Option<f64>> {
        self.found.into_iter().map(|found| found.map(|(_, surface)| surface))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_faces_on_their_edges_and_beyond() {
        let places = [(1.0, -1.0), (2.5, -2.5), (0.5, -0.5), (9.0, -1.0), (f64::NAN, 0.0), (2.5, -0.5)];
        let mut locator = Locator::new(GeoTransform::DEFAULT, places.into_iter());
        // z = column + 10 row, with columns and rows from the first sample, at (0.5, -0.5).
        let z = |(x, y): (i64, i64)| x as f64 / 4.0 + 10.0 * y as f64 / 4.0;
        for face in [[(0, 0), (8, 0), (8, 8)], [(0, 0), (8, 8), (0, 8)]] {
            locator.face(face, face.map(z));
        }
        let found: Vec<_> = locator.finish().collect();
        assert_eq!(found, [Some(5.5), Some(22.0), Some(0.0), None, None, Some(2.0)]);
    }
}
