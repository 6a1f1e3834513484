//! Triangles by their smallest angles.

/// Bins: whole degrees, the last one for 60, too.
const DEGREES: usize = 60;

/// Steps of a table of squares of sines.
const STEPS: usize = 256;

/// Counts of triangles by the whole degrees of their smallest angle, seen from above with square cells.
pub(super) struct Angles {
    counts: [u64; DEGREES],
    /// The squares of the sines of 1°, 2° and so on. They are a trifle less, so that what is 45° but for rounding counts as that.
    squares: [f64; DEGREES],
    /// The bin of each multiple of 1 / [`STEPS`].
    bins: [u8; STEPS + 1],
}

impl Angles {
    pub(super) fn new() -> Angles {
        let square = |degrees: usize| match degrees + 1 {
            // It has no next.
            DEGREES => f64::INFINITY,
            degrees => (degrees as f64).to_radians().sin().powi(2) * (1.0 - 1e-12),
        };
        let squares: [f64; DEGREES] = std::array::from_fn(square);
        let bin = |step: usize| squares.partition_point(|least| *least <= step as f64 / STEPS as f64) as u8;
        Angles { counts: [0; DEGREES], squares, bins: std::array::from_fn(bin) }
    }

    /// Counts a triangle.
    pub(super) fn count(&mut self, [a, b, c]: [(i64, i64); 3]) {
        let squared = |p: (i64, i64), q: (i64, i64)| {
            let (x, y) = ((p.0 - q.0) as f64, (p.1 - q.1) as f64);
            x * x + y * y
        };
        let [x, y, z] = [squared(a, b), squared(b, c), squared(c, a)];
        let area = (b.0 - a.0) as f64 * (c.1 - a.1) as f64 - (b.1 - a.1) as f64 * (c.0 - a.0) as f64;
        // It lies between the two longer sides.
        let longer = (x * y).max(y * z).max(z * x);
        let square = area * area / longer;
        // As near to it as there is a table, and from there on.
        let mut bin = usize::from(self.bins[((square * STEPS as f64) as u32 as usize).min(STEPS)]);
        while self.squares[bin] <= square {
            bin += 1;
        }
        self.counts[bin] += 1;
    }

    /// How many have which.
    pub(super) fn counts(&self) -> Vec<u64> {
        self.counts.to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_cosine_rule() {
        let far = 1i64 << 40;
        let triangles = [
            [(0, 0), (8, 0), (0, 8)],
            [(0, 0), (0, far), (far, 0)],
            [(-3, 2), (17, 5), (4, 40)],
            [(0, 0), (1000, 0), (500, 866)],
            [(0, 0), (1000, 1), (2000, 0)],
            [(0, 0), (1000, 400), (2000, 0)],
            [(0, 0), (100, 0), (0, 173)],
        ];
        let mut angles = Angles::new();
        let mut expected = vec![0; DEGREES];
        for triangle in triangles {
            angles.count(triangle);
            let [a, b, c] = triangle.map(|(x, y)| (x as f64, y as f64));
            let side = |p: (f64, f64), q: (f64, f64)| (p.0 - q.0).hypot(p.1 - q.1);
            let [x, y, z] = [side(b, c), side(c, a), side(a, b)];
            let opposite = |x: f64, y: f64, z: f64| ((y * y + z * z - x * x) / (2.0 * y * z)).acos().to_degrees();
            let least = opposite(x, y, z).min(opposite(y, z, x)).min(opposite(z, x, y));
            expected[(least + 1e-6) as usize] += 1;
        }
        assert_eq!(angles.counts(), expected);
        assert_eq!(expected[45], 2);
    }
}
