use super::{Limits, MinLink, WeightedLine};
use crate::control::{CancelToken, Cancelled};
use crate::field::Tile;

/// Finds the fewest links over straight runs of a tile's samples.
pub(super) struct Runs<'a> {
    pub(super) tile: &'a Tile,
    tolerance: f64,
    min_link: &'a mut MinLink,
    cancel: &'a CancelToken,
    line: Vec<f64>,
    limits: Vec<f64>,
    channels: Vec<Vec<f64>>,
}

impl<'a> Runs<'a> {
    pub(super) fn new(tile: &'a Tile, tolerance: f64, min_link: &'a mut MinLink, cancel: &'a CancelToken) -> Runs<'a> {
        let channels = vec![Vec::new(); tile.channels.len()];
        Runs { tile, tolerance, min_link, cancel, line: Vec::new(), limits: Vec::new(), channels }
    }

    /// The vertices between the ends of a run of `len` samples, by their numbers along it: sample i is at the column and row
    /// `place(i)`. `forced` ones are among them.
    pub(super) fn between(
        &mut self,
        len: usize,
        forced: &[usize],
        place: impl Fn(usize) -> (usize, usize),
    ) -> Result<Vec<usize>, Cancelled> {
        let Runs { tile, tolerance, min_link, cancel, line, limits, channels } = self;
        let (tile, tolerance) = (*tile, *tolerance);
        line.clear();
        line.extend((0..len).map(|i| tile.at(place(i).0, place(i).1)));
        let mut path = if let Some(error) = &tile.channel_error {
            for (channel, values) in channels.iter_mut().enumerate() {
                values.clear();
                values.extend((0..len).map(|i| tile.channel_at(channel, place(i).0, place(i).1)));
            }
            let channels = WeightedLine { error, channels };
            min_link.path_weighted(line, channels, tolerance, forced, cancel)?
        } else if tile.is_weighted() {
            limits.clear();
            limits.extend((0..len).map(|i| tile.limit(place(i).0, place(i).1, tolerance)));
            min_link.path(line, Limits::Each(limits), forced, cancel)?
        } else {
            min_link.path(line, Limits::Same(tolerance), forced, cancel)?
        };
        path.pop();
        path.remove(0);
        Ok(path)
    }
}
