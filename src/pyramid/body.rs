//! The ellipsoid that tiles lie on.

/// An ellipsoid of revolution, by its half axes in metres.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Body {
    /// The larger half axis.
    pub semi_major: f64,
    /// The smaller one.
    pub semi_minor: f64,
}

/// Sine and cosine of a longitude or latitude.
#[derive(Debug, Clone, Copy)]
pub(super) struct Angle {
    pub(super) sin: f64,
    pub(super) cos: f64,
}

impl Angle {
    /// Of an angle in degrees, the same on every machine. At a pole the cosine is 0.
    pub(super) fn of(degrees: f64) -> Angle {
        if degrees.abs() == 90.0 {
            return Angle { sin: degrees.signum(), cos: 0.0 };
        }
        let (sin, cos) = libm::sincos(degrees.to_radians());
        Angle { sin, cos }
    }
}

pub(super) type Vector = [f64; 3];

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

impl Body {
    /// The square of the first eccentricity.
    pub(super) fn eccentricity2(&self) -> f64 {
        1.0 - (self.semi_minor / self.semi_major) * (self.semi_minor / self.semi_major)
    }

    /// The vertical error in metres at which a client goes from tiles of this level to the next: CesiumJS's
    /// 2πa ÷ 4 ÷ (65 samples × two tiles of level 0), halved from level to level.
    pub fn client_error(&self, level: u32) -> f64 {
        2.0 * std::f64::consts::PI * self.semi_major * 0.25 / 130.0 / (1u64 << level) as f64
    }

    /// By how much the chord of the diagonal of a square with sides of `degrees` sags under the ellipsoid at the most: no triangle
    /// in the square sags more.
    pub(super) fn sag(&self, degrees: f64) -> f64 {
        let side = degrees.to_radians() * self.semi_major;
        // The least radius of curvature is that of the meridian at the equator.
        2.0 * side * side / (8.0 * self.semi_minor * self.semi_minor / self.semi_major)
    }

    /// The direction of the normal.
    pub(super) fn normal(lon: Angle, lat: Angle) -> Vector {
        [lat.cos * lon.cos, lat.cos * lon.sin, lat.sin]
    }

    /// A point this high above the ellipsoid, from its centre.
    pub(super) fn point(&self, lon: Angle, lat: Angle, height: f64) -> Vector {
        let e2 = self.eccentricity2();
        let across = self.semi_major / (1.0 - e2 * lat.sin * lat.sin).sqrt();
        let reach = (across + height) * lat.cos;
        [reach * lon.cos, reach * lon.sin, (across * (1.0 - e2) + height) * lat.sin]
    }

    /// The radii of curvature there: across the meridian, and along it.
    pub(super) fn radii(&self, lat: Angle) -> (f64, f64) {
        let e2 = self.eccentricity2();
        let w2 = 1.0 - e2 * lat.sin * lat.sin;
        let across = self.semi_major / w2.sqrt();
        (across, across * (1.0 - e2) / w2)
    }

    /// Metres in a degree of longitude and of latitude there.
    pub(super) fn metres_in_degree(&self, lat: Angle) -> (f64, f64) {
        let (across, along) = self.radii(lat);
        (1f64.to_radians() * across * lat.cos, 1f64.to_radians() * along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Body = Body { semi_major: 6_378_137.0, semi_minor: 6_356_752.314_245_179 };

    #[test]
    fn the_errors_of_clients_are_those_of_cesium() {
        assert!((EARTH.client_error(0) - 77_067.34).abs() < 0.01);
        let moon = Body { semi_major: 1_737_400.0, semi_minor: 1_737_400.0 };
        assert!((moon.client_error(0) - 20_993.09).abs() < 0.01);
    }

    #[test]
    fn points_are_those_of_tables() {
        // Greenwich on the equator, and 90° E; the pole.
        let at = |lon: f64, lat: f64| EARTH.point(Angle::of(lon), Angle::of(lat), 100.0);
        assert!(length(minus(at(0.0, 0.0), [6_378_237.0, 0.0, 0.0])) < 1e-8);
        assert!(length(minus(at(90.0, 0.0), [0.0, 6_378_237.0, 0.0])) < 1e-8);
        assert!(length(minus(at(33.0, -90.0), [0.0, 0.0, -6_356_852.314_245_179])) < 1e-8);
        let (across, along) = EARTH.metres_in_degree(Angle::of(45.0));
        assert!((across - 78_846.8).abs() < 0.1 && (along - 111_131.8).abs() < 0.1, "{across} {along}");
    }

    #[test]
    fn no_chord_sags_more_than_its_bound() {
        for degrees in [0.1, 1.0, 5.625] {
            for lat in [-60.0, 0.0, 45.0] {
                let corner = |x: f64, y: f64| EARTH.point(Angle::of(x * degrees), Angle::of(lat + y * degrees), 0.0);
                let (a, b) = (corner(0.0, 0.0), corner(1.0, 1.0));
                let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
                let below = corner(0.5, 0.5);
                assert!(length(minus(middle, below)) <= EARTH.sag(degrees) * 1.5);
                let up = Body::normal(Angle::of(0.5 * degrees), Angle::of(lat + 0.5 * degrees));
                assert!(dot(minus(below, middle), up) <= EARTH.sag(degrees), "{degrees} at {lat}");
            }
        }
    }
}
