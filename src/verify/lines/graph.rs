//! Stretches of lines from where they end or meet to where they do again.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::Spot;

/// A stretch's places, and the sets of lines that it is of.
type Stretch<'a> = (Vec<Spot>, &'a [usize]);

/// All stretches of segments that are given with their sets. Where these change, a stretch ends. A ring that meets no other line begins
/// and ends at its first place, by rows and then by columns.
pub(super) fn stretches(segments: Vec<&([Spot; 2], Vec<usize>)>) -> Vec<Stretch<'_>> {
    let mut beside: BTreeMap<Spot, BTreeSet<Spot>> = BTreeMap::new();
    let mut of: HashMap<[Spot; 2], &[usize]> = HashMap::new();
    let turned = |(x, y): Spot| (y, x);
    for &([a, b], sets) in &segments {
        let [a, b] = [turned(*a), turned(*b)];
        beside.entry(a).or_default().insert(b);
        beside.entry(b).or_default().insert(a);
        of.extend([([a, b], sets.as_slice()), ([b, a], sets)]);
    }
    let goes_on = |(spot, to): (&Spot, &BTreeSet<Spot>)| {
        let mut sets = to.iter().map(|to| of[&[*spot, *to]]);
        to.len() == 2 && sets.next() == sets.next()
    };
    let ends: Vec<Spot> = beside.iter().filter(|entry| !goes_on(*entry)).map(|(spot, _)| *spot).collect();
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
            let sets = of[&[stretch[0], stretch[1]]];
            found.push((stretch.into_iter().map(turned).collect(), sets));
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
