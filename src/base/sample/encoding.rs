//! Heights that are stored as colours: three bands of bytes make one number.

/// How heights are stored as red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// Mapbox's: (65536 R + 256 G + B − 100000) / 10 metres, one division of doubles.
    TerrainRgb,
    /// Mapzen's: (65536 R + 256 G + B) / 256 − 32768 metres, exact in doubles.
    Terrarium,
}

impl Encoding {
    /// Its name, as `--encoding` takes it.
    pub fn name(self) -> &'static str {
        match self {
            Encoding::TerrainRgb => "terrain-rgb",
            Encoding::Terrarium => "terrarium",
        }
    }

    /// The height of a colour, in metres.
    pub fn height(self, [red, green, blue]: [u8; 3]) -> f64 {
        let number = i32::from(red) << 16 | i32::from(green) << 8 | i32::from(blue);
        match self {
            Encoding::TerrainRgb => f64::from(number - 100_000) / 10.0,
            Encoding::Terrarium => f64::from(number) / 256.0 - 32768.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_of_colours() {
        assert_eq!(Encoding::TerrainRgb.height([1, 134, 160]), 0.0);
        assert_eq!(Encoding::TerrainRgb.height([0, 0, 0]), -10000.0);
        assert_eq!(Encoding::TerrainRgb.height([1, 134, 161]), 0.1);
        assert_eq!(Encoding::Terrarium.height([128, 0, 0]), 0.0);
        assert_eq!(Encoding::Terrarium.height([128, 1, 128]), 1.5);
        assert_eq!(Encoding::Terrarium.height([0, 0, 0]), -32768.0);
    }
}
