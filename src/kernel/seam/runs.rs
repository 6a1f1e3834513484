//! Straight runs between fixed vertices of a side.

use super::{LateVertex, Level, Limits, MinLink, Side, WeightedLine, levels};
use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};

/// How the sides of a tile are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides {
    /// Which part of the tolerance they are held to, up to 1.
    pub share: f64,
    /// Whether their links are short: at most a quarter of the side, or two cells.
    pub short_links: bool,
}

impl Sides {
    /// With all of the tolerance, and the fewest links.
    pub const FINAL: Sides = Sides { share: 1.0, short_links: false };
}

/// What a run is held to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    share: f64,
    /// How long links may be, in cells.
    longest: usize,
}

impl Hold {
    /// The tolerance alone.
    pub(super) const TOLERANCE: Hold = Hold { share: 1.0, longest: usize::MAX };
}

/// Short links are this part of a tile's side at most.
const SHORT: usize = 4;
/// The longest link, in cells, beside which every sample can be meshed within the limit on straying.
const ALWAYS_SHORT: usize = 2;

/// Finds the vertices over straight runs of a tile's samples.
pub(super) struct Runs<'a> {
    pub(super) tile: &'a Tile,
    tolerance: f64,
    sides: Sides,
    find: Find<'a>,
    cancel: &'a CancelToken,
}

enum Find<'a> {
    /// The fewest links.
    Path { min_link: &'a mut MinLink, line: Vec<f64>, limits: Vec<f64>, channels: Vec<Vec<f64>> },
    /// Nested vertices that are wanted. Those found, by sample.
    Nested { keeps: &'a dyn Fn(LateVertex) -> bool, late: Vec<(u32, LateVertex)> },
}

impl<'a> Runs<'a> {
    /// With the fewest links within the tolerance, or what sides are held to.
    pub(super) fn new(
        tile: &'a Tile,
        tolerance: f64,
        sides: Sides,
        min_link: &'a mut MinLink,
        cancel: &'a CancelToken,
    ) -> Runs<'a> {
        let channels = vec![Vec::new(); tile.channels.len()];
        let find = Find::Path { min_link, line: Vec::new(), limits: Vec::new(), channels };
        Runs { tile, tolerance, sides, find, cancel }
    }

    /// With those that `keeps` wants of the vertices that runs have at any tolerance, down to this one.
    pub(super) fn nested(
        tile: &'a Tile,
        tolerance: f64,
        keeps: &'a dyn Fn(LateVertex) -> bool,
        cancel: &'a CancelToken,
    ) -> Runs<'a> {
        Runs { tile, tolerance, sides: Sides::FINAL, find: Find::Nested { keeps, late: Vec::new() }, cancel }
    }

    /// What runs of a side with this number of samples are held to.
    pub(super) fn on_side(&self, len: usize) -> Hold {
        let Sides { share, short_links } = self.sides;
        let longest = if short_links { ((len - 1) / SHORT).max(ALWAYS_SHORT) } else { usize::MAX };
        Hold { share, longest }
    }

    /// The same where ground is on one side of a line between tiles only: nobody can change the run later, and no tile needs it to
    /// be closer to its samples.
    pub(super) fn beside_void(&self) -> Hold {
        let longest = if self.sides.short_links { ALWAYS_SHORT } else { usize::MAX };
        Hold { share: 1.0, longest }
    }

    /// The vertices between the ends of a run of `len` samples, by their numbers along it: sample i is at the column and row
    /// `place(i)`. `forced` ones are among them. Nested vertices are held to the tolerance alone.
    pub(super) fn between(
        &mut self,
        len: usize,
        forced: &[usize],
        hold: Hold,
        place: impl Fn(usize) -> (usize, usize),
    ) -> Result<Vec<usize>, Cancelled> {
        let Runs { tile, tolerance, find, cancel, .. } = self;
        let (tile, tolerance, longest) = (*tile, *tolerance * hold.share, hold.longest);
        let (min_link, line, limits, channels) = match find {
            Find::Path { min_link, line, limits, channels } => (min_link, line, limits, channels),
            Find::Nested { keeps, late } => {
                cancel.check()?;
                let run = Run { tile, tolerance, place: &place };
                let all = levels(len, forced, |a, b, k| run.error(a, b, k), |a, b, k| run.is_beyond(a, b, k));
                return Ok(all.into_iter().filter_map(|l| run.keep(l, keeps, late)).collect());
            }
        };
        line.clear();
        line.extend((0..len).map(|i| tile.at(place(i).0, place(i).1)));
        if tile.channel_error.is_some() {
            for (channel, values) in channels.iter_mut().enumerate() {
                values.clear();
                values.extend((0..len).map(|i| tile.channel_at(channel, place(i).0, place(i).1)));
            }
        } else if tile.is_weighted() {
            limits.clear();
            limits.extend((0..len).map(|i| tile.limit(place(i).0, place(i).1, tolerance)));
        }
        let mut find = |stops: &[usize]| {
            if let Some(error) = &tile.channel_error {
                let channels = WeightedLine { error, channels };
                min_link.path_weighted(line, channels, tolerance, stops, cancel)
            } else if tile.is_weighted() {
                min_link.path(line, Limits::Each(limits), stops, cancel)
            } else {
                min_link.path(line, Limits::Same(tolerance), stops, cancel)
            }
        };
        let mut path = find(forced)?;
        if path.windows(2).any(|link| link[1] - link[0] > longest) {
            let within = |link: &[usize]| {
                (link[0] + 1..link[1]).filter(|i| link[1] - link[0] > longest && i % longest == 0).collect::<Vec<_>>()
            };
            let stops: Vec<usize> = path.windows(2).flat_map(within).chain(path.iter().copied()).collect();
            path = find(&stops)?;
        }
        path.pop();
        path.remove(0);
        Ok(path)
    }

    /// The nested vertices that were kept, by sample (row · width + column), ascending.
    pub(super) fn into_late(self) -> Vec<(u32, LateVertex)> {
        let Find::Nested { mut late, .. } = self.find else { return Vec::new() };
        late.sort_unstable_by_key(|(sample, _)| *sample);
        late
    }
}

/// The samples of a run.
struct Run<'a> {
    tile: &'a Tile,
    tolerance: f64,
    place: &'a dyn Fn(usize) -> (usize, usize),
}

impl Run<'_> {
    fn height(&self, k: usize) -> f64 {
        let (column, row) = (self.place)(k);
        self.tile.at(column, row)
    }

    /// How far sample k is from the line between two others, times its weight.
    fn error(&self, from: usize, to: usize, k: usize) -> f64 {
        let (column, row) = (self.place)(k);
        let (before, after) = ((k - from) as f64, (to - k) as f64);
        let off = after * (self.height(from) - self.height(k)) + before * (self.height(to) - self.height(k));
        off.abs() / (before + after) * self.tile.weight(column, row)
    }

    /// Whether that is more than is allowed there, exactly.
    fn is_beyond(&self, from: usize, to: usize, k: usize) -> bool {
        let (column, row) = (self.place)(k);
        let (before, after) = ((k - from) as i64, (to - k) as i64);
        let terms = [(after, self.height(from)), (before, self.height(to)), (-before - after, self.height(k))];
        !crate::base::exact::within(&terms, before + after, self.tile.limit(column, row, self.tolerance))
    }

    /// The place of a vertex along the run if it is always there, or wanted; then it is noted.
    fn keep(
        &self,
        Level { at, level }: Level,
        keeps: &dyn Fn(LateVertex) -> bool,
        late: &mut Vec<(u32, LateVertex)>,
    ) -> Option<usize> {
        if level == f64::INFINITY {
            return Some(at);
        }
        let ((column, row), width) = ((self.place)(at), self.tile.width());
        let sample = row * width + column;
        // Corners are ends of runs, so no sample between is on two sides.
        let (side, place) = match (column, row) {
            (_, 0) => (Some(Side::North), column),
            (0, _) => (Some(Side::West), row),
            _ if column + 1 == width => (Some(Side::East), row),
            _ if row + 1 == self.tile.height() => (Some(Side::South), column),
            _ => (None, sample),
        };
        let vertex = LateVertex { side, at: place, level };
        if !keeps(vertex) {
            return None;
        }
        late.push((sample as u32, vertex));
        Some(at)
    }
}
