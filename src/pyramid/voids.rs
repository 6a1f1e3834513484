//! Voids: samples of the grid that lie on the raster, where that has no height; and what tiles have there.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::grid::TileKey;
use super::quantize::Relief;

/// What tiles have where the raster has no height. What lies beyond its outermost samples is no void.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VoidAs {
    /// Ground at the height that is taken outside.
    #[default]
    Outside,
    /// Ground at this height, in metres above the ellipsoid.
    Height(f64),
    /// Nothing: triangles are left out.
    Hole,
}

/// What stands for the height of a void among samples.
pub(super) const VOID: f64 = f64::INFINITY;

/// How far below the lowest ground of a level the floor of its holes is, in errors of the level: so far that no triangle within the
/// error of ground reaches it, and half as far as clients let skirts hang.
const DEPTH: f64 = 2.5;

/// Levels whose tiles have more cells have no floor: vertices are rounded by so much of a cell there that no mesh is found beside
/// steep drops.
const MOST_CELLS: i64 = 4096;

impl VoidAs {
    /// Whether voids are told from what lies outside.
    pub(super) fn is_marked(self) -> bool {
        self != VoidAs::Outside
    }

    /// Whether it is what goes without saying.
    pub(super) fn is_outside(&self) -> bool {
        *self == VoidAs::Outside
    }

    /// The height of voids at a level whose tiles are `cells` cells wide. Where holes are cut it is that of a floor, so that there are
    /// triangles along their rim.
    pub(super) fn height(self, reliefs: &BTreeMap<TileKey, Relief>, max_error: f64, cells: i64, outside: f64) -> f64 {
        match self {
            VoidAs::Outside => outside,
            VoidAs::Height(height) => height,
            VoidAs::Hole => {
                let lowest = reliefs.values().map(|r| r.low).fold(f64::INFINITY, f64::min);
                if cells > MOST_CELLS { lowest } else { lowest - DEPTH * max_error }
            }
        }
    }
}

impl std::fmt::Display for VoidAs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            VoidAs::Outside => f.write_str("outside"),
            VoidAs::Height(height) => write!(f, "{}", crate::base::exact_double(*height)),
            VoidAs::Hole => f.write_str("hole"),
        }
    }
}

/// The reliefs of tiles with that of their voids.
pub(super) fn with_voids(reliefs: &BTreeMap<TileKey, Relief>, height: f64) -> BTreeMap<TileKey, Relief> {
    let void = Relief::of(height);
    let with = |relief: Relief| if relief.has_void { relief.with(void) } else { relief };
    reliefs.iter().map(|(key, relief)| (*key, with(*relief))).collect()
}
