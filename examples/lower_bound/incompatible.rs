//! Samples of which a triangle holds one at the most, because no two of them are compatible.

use super::samples::{At, Samples};

/// Every `step`-th sample of every `step`-th row from `first` on that is incompatible with all but `most` of the 24 nearest of
/// them. On smooth ground, where more are compatible, every second one of these is looked at in the same way, and so on.
pub(crate) fn rough(samples: &Samples<'_>, first: At, step: i32, most: usize) -> Vec<(At, usize)> {
    let (width, height) = (samples.tile.width() as i32, samples.tile.height() as i32);
    let compatible = |p: At, step: i32| {
        let near = (-2..=2).flat_map(|i| (-2..=2).map(move |j| (p.0 + i * step, p.1 + j * step)));
        near.filter(|&q| q != p && (0..width).contains(&q.0) && (0..height).contains(&q.1))
            .filter(|&q| samples.bend(p, q).is_none())
            .count()
    };
    let mut found = Vec::new();
    for row in (first.1..height).step_by(step as usize) {
        for column in (first.0..width).step_by(step as usize) {
            let mut step = step;
            while step < width && (column - first.0) % step == 0 && (row - first.1) % step == 0 {
                let count = compatible((column, row), step);
                if count <= most {
                    found.push(((column, row), count));
                    break;
                }
                step *= 2;
            }
        }
    }
    found
}

/// Incompatible samples, as many as a greedy choice finds on any square grid: those first that have the fewest compatible ones
/// near them.
pub(crate) fn incompatible(samples: &Samples<'_>) -> Vec<At> {
    let grids = (2..=8).flat_map(|step| (0..step).flat_map(move |x| (0..step).map(move |y| ((x, y), step))));
    let mut best = Vec::new();
    for (first, step) in grids {
        let mut candidates = rough(samples, first, step, 12);
        candidates.sort_by_key(|&(_, compatible)| compatible);
        let mut chosen: Vec<At> = Vec::new();
        for (at, _) in candidates {
            if chosen.iter().all(|&other| samples.bend(other, at).is_some()) {
                chosen.push(at);
            }
        }
        if chosen.len() > best.len() {
            best = chosen;
        }
    }
    best
}
