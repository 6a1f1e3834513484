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
