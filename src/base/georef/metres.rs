//! How long the units of coordinates and heights are.

/// What coordinates of a CRS are in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Metres {
    /// A unit of x and y is so many metres.
    PerUnit(f64),
    /// x and y are longitude and latitude on an ellipsoid.
    OnEllipsoid {
        /// The larger half axis, in metres.
        semi_major: f64,
        /// The smaller one.
        semi_minor: f64,
        /// Radians in a unit of x and y.
        radians: f64,
    },
}

impl Metres {
    /// Metres in a unit of x and of y where y is this: on an ellipsoid along the parallel and along the meridian (Snyder 1987,
    /// Map Projections, equations 4-18 and 4-20), to seven digits, so that they are short to write.
    pub fn at(self, y: f64) -> (f64, f64) {
        match self {
            Metres::PerUnit(metres) => (metres, metres),
            Metres::OnEllipsoid { semi_major, semi_minor, radians } => {
                let (sin, cos) = (y * radians).sin_cos();
                let squared = 1.0 - (semi_minor / semi_major).powi(2);
                let w = 1.0 - squared * sin * sin;
                let parallel = semi_major / w.sqrt() * cos;
                let meridian = semi_major * (1.0 - squared) / (w * w.sqrt());
                (digits(parallel * radians), digits(meridian * radians))
            }
        }
    }

    /// Metres in a unit of x and of y in the middle between two y; what is not known is taken for metres.
    pub fn between(metres: Option<Metres>, bottom: f64, top: f64) -> (f64, f64) {
        let across = metres.map_or((1.0, 1.0), |metres| metres.at((bottom + top) / 2.0));
        // At a pole all longitudes are the same place.
        if across.0 > 0.0 { across } else { (across.1, across.1) }
    }
}

fn digits(number: f64) -> f64 {
    format!("{number:.6e}").parse().unwrap_or(number)
}

/// Metres in a unit of length, as rasters and CRSs call it; `None` for a name that says nothing.
pub fn metres_in(unit: &str) -> Option<f64> {
    let name = unit.trim().to_ascii_lowercase().replace(['_', '-'], " ");
    match name.as_str() {
        "m" | "metre" | "meter" | "metres" | "meters" => Some(1.0),
        "ft" | "foot" | "feet" | "international foot" | "international feet" | "foot (international)" => Some(0.3048),
        "us ft" | "ftus" | "us foot" | "us feet" | "us survey foot" | "us survey feet" | "foot us" | "survey foot"
        | "u.s. foot" | "u.s. survey foot" | "sft" => Some(1200.0 / 3937.0),
        "km" | "kilometre" | "kilometer" => Some(1000.0),
        "dm" | "decimetre" | "decimeter" => Some(0.1),
        "cm" | "centimetre" | "centimeter" => Some(0.01),
        "mm" | "millimetre" | "millimeter" => Some(0.001),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_degree_on_the_earth() {
        let earth =
            Metres::OnEllipsoid { semi_major: 6_378_137.0, semi_minor: 6_356_752.314_245, radians: 1f64.to_radians() };
        // The lengths that tables have.
        assert_eq!(earth.at(0.0), (111_319.5, 110_574.3));
        assert_eq!(earth.at(45.0), (78_846.84, 111_131.8));
        assert_eq!(earth.at(-45.0), earth.at(45.0));
        let sphere = Metres::OnEllipsoid { semi_major: 1e6, semi_minor: 1e6, radians: 1.0 };
        assert_eq!(sphere.at(0.0), (1e6, 1e6));
        assert_eq!(Metres::PerUnit(0.3048).at(7.0), (0.3048, 0.3048));
    }

    #[test]
    fn units_by_their_names() {
        for (name, metres) in
            [("metre", 1.0), ("US survey foot", 1200.0 / 3937.0), ("ft", 0.3048), ("Foot_US", 1200.0 / 3937.0)]
        {
            assert_eq!(metres_in(name), Some(metres), "{name}");
        }
        assert_eq!(metres_in("fathom, about"), None);
    }
}
