//! Stretches of lines from where they end or meet to where they do again.

use super::Spot;
use super::required::SetBits;

/// A stretch's places, and the sets of lines that it is of.
type Stretch = (Vec<Spot>, SetBits);

/// From a place to another, each as (down, across), and the sets that the segment is of.
type Way = (Spot, Spot, SetBits);

/// All stretches of segments that are given with their sets. Where these change, a stretch ends. A ring that meets no other line begins
/// and ends at its first place, by rows and then by columns.
///
/// Memory: some 120 bytes for each segment.
pub(super) fn stretches<'s>(segments: impl Iterator<Item = &'s ([Spot; 2], SetBits)>) -> Vec<Stretch> {
    let turned = |(x, y): Spot| (y, x);
    let both = |&([a, b], sets): &([Spot; 2], SetBits)| {
        let [a, b] = [turned(a), turned(b)];
        [(a, b, sets), (b, a, sets)]
    };
    let mut ways: Vec<Way> = segments.flat_map(both).collect();
    ways.sort_unstable();
    let first = |spot: Spot| ways.partition_point(|way| way.0 < spot);
    let from = |spot: Spot| {
        let first = first(spot);
        first..first + ways[first..].iter().take_while(|way| way.0 == spot).count()
    };
    let goes_on = |of: &[Way]| of.len() == 2 && of[0].2 == of[1].2;
    let mut taken = vec![false; ways.len()];
    let mut found = Vec::new();
    // What begins at an end, then rings.
    for from_ends in [true, false] {
        for i in 0..ways.len() {
            let (start, mut at, sets) = ways[i];
            if taken[i] || from_ends && goes_on(&ways[from(start)]) {
                continue;
            }
            let mut stretch = vec![start];
            loop {
                let before = stretch[stretch.len() - 1];
                for (p, q) in [(before, at), (at, before)] {
                    let way = from(p).find(|&way| ways[way].1 == q);
                    taken[way.expect("a segment leads both ways")] = true;
                }
                stretch.push(at);
                let beside = from(at);
                if at == start || from_ends && !goes_on(&ways[beside.clone()]) {
                    break;
                }
                let Some(next) = beside.into_iter().find(|&way| !taken[way]) else { break };
                at = ways[next].1;
            }
            found.push((stretch.into_iter().map(turned).collect(), sets));
        }
    }
    found
}
