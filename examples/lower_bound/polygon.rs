//! Convex polygons with corners at samples.

use super::samples::{At, orient};

/// The corners of the convex hull of some samples, each turn to the same side, none straight.
pub(crate) fn hull(mut samples: Vec<At>) -> Vec<At> {
    samples.sort_unstable();
    samples.dedup();
    if samples.len() < 3 {
        return samples;
    }
    let mut corners: Vec<At> = Vec::with_capacity(samples.len() + 1);
    for pass in 0..2 {
        let start = corners.len();
        let order: &mut dyn Iterator<Item = &At> =
            if pass == 0 { &mut samples.iter() } else { &mut samples.iter().rev() };
        for &p in order {
            while corners.len() >= start + 2 && orient(corners[corners.len() - 2], corners[corners.len() - 1], p) <= 0 {
                corners.pop();
            }
            corners.push(p);
        }
        corners.pop();
    }
    corners
}

/// All samples of a convex polygon, its rim included: corners first, then by rows.
pub(crate) fn samples_of(corners: &[At], found: &mut Vec<At>) {
    found.clear();
    found.extend(corners);
    let rows = || corners.iter().map(|c| c.1);
    let (Some(top), Some(bottom)) = (rows().min(), rows().max()) else { return };
    for row in top..=bottom {
        let (mut first, mut last) = (i32::MAX, i32::MIN);
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let (a, b) = if a.1 <= b.1 { (a, b) } else { (b, a) };
            if row < a.1 || row > b.1 {
                continue;
            }
            if a.1 == b.1 {
                (first, last) = (first.min(a.0.min(b.0)), last.max(a.0.max(b.0)));
                continue;
            }
            let (across, down) = ((b.0 - a.0) * (row - a.1), b.1 - a.1);
            first = first.min(a.0 - (-across).div_euclid(down));
            last = last.max(a.0 + across.div_euclid(down));
        }
        found.extend((first..=last).map(|column| (column, row)).filter(|at| !corners.contains(at)));
    }
}

/// Whether some triangle holds the polygon and none of these samples, as far as directions tell: three sides leave them all
/// out, each side one that could pass by the polygon. A triangle that does so has three such sides.
pub(crate) fn triangle_leaves_out(corners: &[At], outside: &[At]) -> bool {
    // The normals of sides that leave a sample out are an open arc between those of the two tangents from it.
    let mut arcs: Vec<(f64, f64)> = outside.iter().map(|&s| arc(corners, s)).collect();
    // From the arc that is the shortest each end is a direction that one side may have.
    let Some(shortest) = arcs.iter().copied().min_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0))) else { return true };
    let inside = |direction: f64, (from, to): (f64, f64)| (direction - from).rem_euclid(TURN) <= to - from;
    let starts: Vec<f64> = arcs.iter().map(|a| a.1).filter(|&d| inside(d, shortest)).collect();
    starts.into_iter().any(|direction| {
        arcs.sort_unstable_by(|a, b| {
            let end = |a: &(f64, f64)| (a.1 - direction).rem_euclid(TURN);
            end(a).total_cmp(&end(b))
        });
        // Two more, each as far around as the first arc that is left allows.
        let (mut last, mut more) = (direction, 2);
        for &a in &arcs {
            if inside(direction, a) || inside(last, a) {
                continue;
            }
            if more == 0 {
                return false;
            }
            (last, more) = (a.1, more - 1);
        }
        true
    })
}

const TURN: f64 = std::f64::consts::TAU;

/// The directions from which a sample outside of a polygon is not hidden by it, from the first to the last, a little more than
/// they are: directions of a grid of some hundred samples differ by more than rounding and this together.
fn arc(corners: &[At], (x, y): At) -> (f64, f64) {
    const WIDER: f64 = 1e-9;
    let towards = |c: &At| f64::from(y - c.1).atan2(f64::from(x - c.0));
    let angles: Vec<f64> = corners.iter().map(towards).collect();
    // All within half a turn of the first.
    let turn = |a: f64| {
        let difference = (a - angles[0]).rem_euclid(TURN);
        if difference > TURN / 2.0 { difference - TURN } else { difference }
    };
    let (low, high) = angles.iter().fold((0.0f64, 0.0f64), |(low, high), &a| (low.min(turn(a)), high.max(turn(a))));
    // A side with this normal leaves the sample out if the normal is within a quarter turn of all directions from corners to it.
    (angles[0] + high - TURN / 4.0 - WIDER, angles[0] + low + TURN / 4.0 + WIDER)
}
