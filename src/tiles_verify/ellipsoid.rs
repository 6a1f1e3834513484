//! Points on an ellipsoid and above it, by the parametric latitude; the maker of tiles has formulas of its own.

/// Half axes in metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ellipsoid {
    pub(super) a: f64,
    pub(super) b: f64,
}

pub(super) type Point = [f64; 3];

pub(super) fn less(p: Point, q: Point) -> Point {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

pub(super) fn times(p: Point, q: Point) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

pub(super) fn across(p: Point, q: Point) -> Point {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

/// Cosine and sine of a longitude.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meridian {
    cos: f64,
    sin: f64,
}

impl Meridian {
    /// The one at a longitude in degrees.
    pub(super) fn of(lon: f64) -> Meridian {
        let lambda = lon.to_radians();
        Meridian { cos: lambda.cos(), sin: lambda.sin() }
    }

    /// How far a point is east of its plane.
    pub(super) fn east(&self, p: Point) -> f64 {
        p[1] * self.cos - p[0] * self.sin
    }

    /// How far a point is from the axis, in its plane.
    pub(super) fn forward(&self, p: Point) -> f64 {
        p[0] * self.cos + p[1] * self.sin
    }
}

/// A circle of one latitude: how far it is from the axis, how high above the equator's plane, and where its normals point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parallel {
    pub(super) reach: f64,
    pub(super) rise: f64,
    pub(super) cos: f64,
    pub(super) sin: f64,
}

impl Parallel {
    /// Its point on a meridian, and the normal there.
    pub(super) fn foot(&self, meridian: Meridian) -> (Point, Point) {
        let foot = [self.reach * meridian.cos, self.reach * meridian.sin, self.rise];
        (foot, [self.cos * meridian.cos, self.cos * meridian.sin, self.sin])
    }

    /// Up, east and north at its point on a meridian.
    pub(super) fn directions(&self, meridian: Meridian) -> (Point, Point, Point) {
        let up = [self.cos * meridian.cos, self.cos * meridian.sin, self.sin];
        let north = [-self.sin * meridian.cos, -self.sin * meridian.sin, self.cos];
        (up, [-meridian.sin, meridian.cos, 0.0], north)
    }

    /// How far a point is from its foot in the plane of a meridian: along the ellipsoid to the north, and along the normal. The point is
    /// given by how far it is from the axis, and from the plane of the equator.
    pub(super) fn seen_from_foot(&self, from_axis: f64, from_equator: f64) -> (f64, f64) {
        let (out, up) = (from_axis - self.reach, from_equator - self.rise);
        (up * self.cos - out * self.sin, out * self.cos + up * self.sin)
    }
}

impl Ellipsoid {
    /// How far the longest chord of a tile's parts sags where the ellipsoid is most curved, on its meridian at the equator: parts are a
    /// 128th of the tile wide, or two cells of a grid of 2ᴳ from pole to pole.
    pub(super) fn sag(&self, level: u32, grid_exponent: u32) -> f64 {
        let parts = (2f64.powi(grid_exponent as i32 - level as i32) / 2.0).min(128.0);
        let side = std::f64::consts::PI * self.a / 2f64.powi(level as i32) / parts;
        let radius = self.b * self.b / self.a;
        // The diagonal's square is twice the side's.
        side * side / (4.0 * radius)
    }

    /// The point of the ellipsoid at a longitude and latitude in degrees, and the normal there.
    pub(super) fn foot(&self, lon: f64, lat: f64) -> (Point, Point) {
        self.parallel(lat).foot(Meridian::of(lon))
    }

    /// The parallel at a latitude in degrees.
    pub(super) fn parallel(&self, lat: f64) -> Parallel {
        let phi = lat.to_radians();
        let beta = (self.b * phi.sin()).atan2(self.a * phi.cos());
        Parallel { reach: self.a * beta.cos(), rise: self.b * beta.sin(), cos: phi.cos(), sin: phi.sin() }
    }

    /// What bounds the second derivatives of longitude and latitude, in radians, along straight lines whose points are no nearer than that to the axis, and to the centre
    /// of curvature of the meridian there; infinite where they may be in either. Of the longitude it is 1 ÷ p², p being the
    /// distance from the axis. Of the latitude it is (1 + c) ÷ ρ² + 1 ÷ ρp: its gradient is 1 ÷ ρ, ρ the distance from the centre of curvature,
    /// which changes by cρ at the most, c = 3e² ÷ 2(1 − e²).
    pub(super) fn bends(&self, from_axis: f64, from_centre: f64) -> [f64; 2] {
        if from_axis <= 0.0 || from_centre <= 0.0 {
            return [f64::INFINITY; 2];
        }
        let change = 1.5 * (self.a * self.a - self.b * self.b) / (self.b * self.b) * self.a / from_centre;
        [1.0 / (from_axis * from_axis), (1.0 + change) / (from_centre * from_centre) + 1.0 / (from_centre * from_axis)]
    }

    /// The least radius of curvature.
    pub(super) fn least_radius(&self) -> f64 {
        self.b * self.b / self.a
    }

    /// The radius of curvature of a meridian where it crosses a parallel.
    pub(super) fn along_meridian(&self, parallel: &Parallel) -> f64 {
        let share = 1.0 - (self.a * self.a - self.b * self.b) / (self.a * self.a) * parallel.sin * parallel.sin;
        self.b * self.b / self.a / (share * share.sqrt())
    }

    pub(super) fn point(&self, lon: f64, lat: f64, height: f64) -> Point {
        let (foot, normal) = self.foot(lon, lat);
        std::array::from_fn(|i| foot[i] + height * normal[i])
    }

    /// Longitude, latitude and height of a point, to the last digits that doubles have.
    pub(super) fn geodetic(&self, p: Point) -> (f64, f64, f64) {
        let (lon, lat) = self.place(p, 4);
        let (foot, normal) = self.foot(lon, lat);
        (lon, lat, times(less(p, foot), normal))
    }

    /// Longitude and latitude of a point, by Newton's method in Bowring's form. One round is off by less than a millimetre near the
    /// ellipsoids of planets.
    pub(super) fn place(&self, p: Point, rounds: usize) -> (f64, f64) {
        let (a, b) = (self.a, self.b);
        let reach = p[0].hypot(p[1]);
        let (e2, second) = ((a * a - b * b) / (a * a), (a * a - b * b) / (b * b));
        let mut beta = (p[2] * a).atan2(reach * b);
        let mut phi = 0.0f64;
        for _ in 0..rounds {
            let (sin, cos) = beta.sin_cos();
            phi = (p[2] + second * b * sin * sin * sin).atan2(reach - e2 * a * cos * cos * cos);
            beta = (b * phi.sin()).atan2(a * phi.cos());
        }
        (p[1].atan2(p[0]).to_degrees(), phi.to_degrees())
    }

    /// Whether the ellipsoid hides a point, given in half axes, only from where it hides a vertex, too: the point is not nearer to the
    /// horizon that the vertex has on its side. Points far out are hidden from nowhere that a client is.
    pub(super) fn hides_later(&self, occlusion_point: Point, vertex: Point) -> bool {
        const FAR: f64 = 1e5;
        let length = |p: Point| times(p, p).sqrt();
        let vertex = [vertex[0] / self.a, vertex[1] / self.a, vertex[2] / self.b];
        let reach = length(occlusion_point);
        // What is under the ellipsoid counts as on it.
        let angle = length(across(occlusion_point, vertex)).atan2(times(occlusion_point, vertex));
        let horizon = angle + (1.0 / length(vertex).max(1.0)).acos();
        reach >= FAR || reach >= 1.0 - 1e-12 && (1.0 / reach).min(1.0).acos() >= horizon - 1e-7
    }

    /// The error at which clients go one level deeper.
    pub(super) fn client_error(&self, level: u32) -> f64 {
        std::f64::consts::TAU * self.a / (4.0 * 65.0 * 2.0) / 2f64.powi(level as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn points_come_back(lon in -180.0f64..180.0, lat in -89.9f64..89.9, height in -11_000.0f64..9000.0) {
            let earth = Ellipsoid { a: 6_378_137.0, b: 6_356_752.314_245_179 };
            let (x, y, z) = earth.geodetic(earth.point(lon, lat, height));
            prop_assert!((z - height).abs() < 1e-8, "{z} for {height}");
            prop_assert!((x - lon).abs() < 1e-9 && (y - lat).abs() < 1e-11, "{x} {y}");
        }

        #[test]
        fn one_round_is_enough_near_the_ellipsoid(lon in -180.0f64..180.0, lat in -89.9f64..89.9, height in -20_000.0f64..20_000.0) {
            let mars = Ellipsoid { a: 3_396_190.0, b: 3_376_200.0 };
            let (x, y) = mars.place(mars.point(lon, lat, height), 1);
            prop_assert!((x - lon).abs() < 1e-9 && (y - lat).abs().to_radians() * mars.a < 1e-3, "{x} {y}");
        }
    }
}
