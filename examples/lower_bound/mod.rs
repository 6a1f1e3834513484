//! Lower bounds of the number of triangles of any mesh within the tolerance of all samples, wherever its vertices are.
//!
//! Every sample is in some closed triangle of the mesh. If samples have weights and no triangle can hold samples that weigh
//! more than 1 together, there are at least as many triangles as all samples weigh. `incompatible` gives the weight 1 to
//! samples of which no two go together; `sets` looks for all sets that go together, and `weights` weighs by them. `samples`
//! says what goes together, `polygon` which samples a convex polygon holds.

mod incompatible;
mod polygon;
mod samples;
mod sets;
#[cfg(test)]
mod tests;
mod weights;

use terrabite::base::Tile;

use incompatible::{incompatible, rough};
use samples::{At, Samples};
use sets::{Chosen, Search};
use weights::weights;

/// What proves that there are not fewer triangles.
pub(crate) struct Bounds {
    /// Samples of which a triangle holds one at the most.
    pub(crate) incompatible: Vec<At>,
    /// Samples that weigh something.
    pub(crate) weighed: Weighed,
}

/// Weights of samples.
pub(crate) struct Weighed {
    /// Samples and what they weigh.
    pub(crate) weights: Vec<(At, u64)>,
    /// The most that a triangle can hold of that.
    pub(crate) heaviest: u64,
}

impl Weighed {
    /// How many triangles there are at least.
    pub(crate) fn triangles(&self) -> u64 {
        self.weights.iter().map(|(_, weight)| weight).sum::<u64>().div_ceil(self.heaviest)
    }
}

/// Samples of polygons that are looked at with each choice of samples, at the most. Where that is not enough, the choice is given
/// up.
const BUDGET: usize = 20_000_000;

/// The best bounds of some choices of samples. The tile misses no sample.
pub(crate) fn lower_bounds(tile: &Tile, tolerance: f64) -> Bounds {
    let samples = Samples { tile, tolerance };
    let choices = [2, 3, 4].into_iter().flat_map(|step| [8, 10, 12].map(|most| (step, most)));
    let weighed = choices.filter_map(|(step, most)| {
        weighed(samples, rough(&samples, (0, 0), step, most).into_iter().map(|(at, _)| at).collect())
    });
    // One triangle at least.
    let least = Weighed { weights: vec![((0, 0), 1)], heaviest: 1 };
    let better = |a: Weighed, b: Weighed| if b.triangles() > a.triangles() { b } else { a };
    Bounds { incompatible: incompatible(&samples), weighed: weighed.fold(least, better) }
}

/// Weights of these samples, as good as they are found; none if there are too many sets.
fn weighed(samples: Samples<'_>, at: Vec<At>) -> Option<Weighed> {
    let chosen = Chosen::new(&samples, at);
    let mut search = Search { samples, chosen: &chosen, sets: Vec::new(), budget: BUDGET };
    if chosen.at.is_empty() || !search.run() {
        return None;
    }
    let (whole, heaviest) = weights(&search.sets, chosen.at.len());
    Some(Weighed { weights: chosen.at.iter().copied().zip(whole).collect(), heaviest })
}
