//! Stretches of lines from where they end or meet to where they do again.

use std::collections::{BTreeMap, BTreeSet};

use super::Spot;

/// The places of every stretch. A ring that meets no other line begins and ends at its first place, by rows and then by columns.
pub(super) fn stretches(segments: Vec<&[Spot; 2]>) -> Vec<Vec<Spot>> {
    let mut beside: BTreeMap<Spot, BTreeSet<Spot>> = BTreeMap::new();
    let turned = |(x, y): Spot| (y, x);
    for &&[a, b] in &segments {
        beside.entry(turned(a)).or_default().insert(turned(b));
        beside.entry(turned(b)).or_default().insert(turned(a));
    }
    let ends: Vec<Spot> = beside.iter().filter(|(_, to)| to.len() != 2).map(|(spot, _)| *spot).collect();
    let mut found = Vec::new();
    let mut take = |start: Spot, beside: &mut BTreeMap<Spot, BTreeSet<Spot>>, is_end: &dyn Fn(Spot) -> bool| {
        while let Some(&next) = beside[&start].first() {
            let (mut stretch, mut at) = (vec![start], next);
            loop {
                let before = stretch[stretch.len() - 1];
                for (p, q) in [(before, at), (at, before)] {
                    beside.get_mut(&p).into_iter().for_each(|to| {
                        to.remove(&q);
                    });
                }
                stretch.push(at);
                match beside[&at].first() {
                    Some(&on) if at != start && !is_end(at) => at = on,
                    _ => break,
                }
            }
            found.push(stretch.into_iter().map(turned).collect());
        }
    };
    for &end in &ends {
        take(end, &mut beside, &|spot| ends.binary_search(&spot).is_ok());
    }
    let all: Vec<Spot> = beside.keys().copied().collect();
    for start in all {
        take(start, &mut beside, &|_| false);
    }
    found
}
