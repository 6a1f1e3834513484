//! The samples of one tile.

use std::sync::Arc;

use super::{SampleCut, Validity};
use crate::base::channels::ChannelError;
use crate::base::exact::{self, MAX_WEIGHT};
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;

/// The samples of one tile, copied out of the field: what every engine works on.
///
/// Row-major, `width` × `height` samples, every one a finite height: 0 where a sample is not valid. The memory is reused
/// from tile to tile.
///
/// Where an importance raster says how much errors weigh, or a hole is bridged, a tile has a weight for every sample, and holds its heights in
/// double precision whatever their type: kernels then have one precision for heights, weights and limits, and those for
/// single precision need not know of weights. So does a tile with samples beside lines that have heights of their own ([`EasedSample`]).
#[derive(Debug, Clone, Default)]
pub struct Tile {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// [`PADDING`] values more than there are samples.
    pub(crate) heights: Heights,
    /// The values of the channels, each row by row as the heights are, with [`PADDING`]. Empty where there is none.
    pub(crate) channels: Vec<Vec<f64>>,
    /// What an error in the channels counts; `None` where there are none.
    pub(crate) channel_error: Option<Arc<ChannelError>>,
    /// What errors weigh: empty where all weigh 1; else as long as the heights, which are double then. 0 at samples of
    /// bridged holes.
    pub(crate) weights: Vec<f64>,
    /// Samples beside lines with heights of their own, by rows, then by columns.
    pub(crate) eased: Vec<EasedSample>,
    /// Cells near lines, whose sides no limit on straying binds: row by row, one fewer than samples. Empty where there are none.
    pub(crate) unbound: Vec<bool>,
    /// Which samples are heights. The ground's loops keep engines away from the others.
    pub(crate) validity: Validity,
}

/// A sample beside a line with heights of its own: the surface may be from `low` to `high` there, give or take the tolerance. Its
/// height in the tile is one between, its weight allows no more than that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EasedSample {
    /// Its place in the tile: row · width + column.
    pub sample: u32,
    /// The height that it has in the raster.
    pub height: f64,
    /// The lesser of the sample's height and the line's.
    pub low: f64,
    /// The larger.
    pub high: f64,
}

/// Values behind the last sample, all 0: whole lanes can be read from every sample on.
pub(crate) const PADDING: usize = 8;

/// Heights in the narrowest type that holds all of them exactly.
#[derive(Debug, Clone)]
pub enum Heights {
    /// Integers of up to 16 bits, and single precision.
    F32(Vec<f32>),
    /// Everything else, scaled values included.
    F64(Vec<f64>),
}

impl Default for Heights {
    fn default() -> Self {
        Heights::F32(Vec::new())
    }
}

impl Heights {
    /// Room for `len` single-precision heights, reusing the memory if it is of that kind.
    pub(crate) fn as_f32(&mut self, len: usize) -> &mut [f32] {
        if let Heights::F64(_) = self {
            *self = Heights::F32(Vec::new());
        }
        match self {
            Heights::F32(v) => {
                v.resize(len + PADDING, 0.0);
                v[len..].fill(0.0);
                &mut v[..len]
            }
            Heights::F64(_) => unreachable!("made single above"),
        }
    }

    /// Room for `len` double-precision heights.
    pub(crate) fn as_f64(&mut self, len: usize) -> &mut [f64] {
        if let Heights::F32(_) = self {
            *self = Heights::F64(Vec::new());
        }
        match self {
            Heights::F64(v) => padded(v, len),
            Heights::F32(_) => unreachable!("made double above"),
        }
    }
}

/// Room for `len` numbers and the padding behind them.
pub(crate) fn padded(v: &mut Vec<f64>, len: usize) -> &mut [f64] {
    v.resize(len + PADDING, 0.0);
    v[len..].fill(0.0);
    &mut v[..len]
}

impl Tile {
    /// A tile of its own, from heights row by row.
    ///
    /// # Panics
    /// If `heights` is not `width` × `height` long.
    pub fn from_heights(width: usize, height: usize, mut heights: Heights) -> Tile {
        let len = match &heights {
            Heights::F32(v) => v.len(),
            Heights::F64(v) => v.len(),
        };
        assert_eq!(len, width * height, "a tile of {width} × {height} samples");
        match &mut heights {
            Heights::F32(v) => v.resize(len + PADDING, 0.0),
            Heights::F64(v) => v.resize(len + PADDING, 0.0),
        }
        Tile { width, height, heights, ..Tile::default() }
    }

    /// The same tile with channels, each row by row.
    ///
    /// # Panics
    /// If a channel is not as long as the tile has samples, there are more or fewer than the error is for, or the tile
    /// has weights.
    pub fn with_channels(self, mut channels: Vec<Vec<f64>>, error: ChannelError) -> Tile {
        let len = self.width * self.height;
        assert!(channels.iter().all(|c| c.len() == len), "lengths of channels");
        channels.iter_mut().for_each(|values| _ = padded(values, len));
        assert_eq!(channels.len(), error.scales().len(), "channels of the error");
        assert!(!self.is_weighted(), "channels beside weights");
        Tile { channels, channel_error: Some(Arc::new(error)), ..self }
    }

    /// The same tile with a weight for the error at every sample, row by row, from 0 to [`MAX_WEIGHT`].
    ///
    /// # Panics
    /// If `weights` is not `width` × `height` long, one is out of range, or the tile has channels.
    pub fn with_weights(self, mut weights: Vec<f64>) -> Tile {
        assert_eq!(weights.len(), self.width * self.height, "weights of {} × {} samples", self.width, self.height);
        assert!(self.channels.is_empty(), "weights beside channels");
        let wrong = weights.iter().find(|w| !(0.0..=MAX_WEIGHT).contains(*w));
        assert!(wrong.is_none(), "a weight of {wrong:?}");
        weights.resize(weights.len() + PADDING, 0.0);
        let heights = match self.heights {
            Heights::F32(single) => Heights::F64(single.into_iter().map(f64::from).collect()),
            double @ Heights::F64(_) => double,
        };
        Tile { heights, weights, ..self }
    }

    /// The same tile with no weight above 1.
    pub(crate) fn with_light_weights(&self) -> Tile {
        let mut tile = self.clone();
        tile.weights.iter_mut().for_each(|weight| *weight = weight.min(1.0));
        tile
    }

    /// The eased samples from a place of the tile on, by rows, then by columns.
    pub(crate) fn eased_from(&self, sample: u32) -> &[EasedSample] {
        &self.eased[self.eased.partition_point(|eased| eased.sample < sample)..]
    }

    /// Eases samples, by rows, then by columns: each has another height, and a weight, from now on.
    pub(crate) fn ease(&mut self, samples: Vec<(EasedSample, f64, f64)>) {
        if samples.is_empty() {
            return;
        }
        let len = self.width * self.height;
        if let Heights::F32(single) = &self.heights {
            self.heights = Heights::F64(single.iter().map(|&z| f64::from(z)).collect());
        }
        if self.weights.is_empty() {
            padded(&mut self.weights, len).fill(1.0);
        }
        for (eased, height, weight) in samples {
            if let Heights::F64(heights) = &mut self.heights {
                heights[eased.sample as usize] = height;
            }
            self.weights[eased.sample as usize] = weight;
            self.eased.push(eased);
        }
    }

    /// Whether a side between two neighbouring samples is one of an unbound cell.
    pub(crate) fn is_unbound(&self, [from, to]: [(usize, usize); 2]) -> bool {
        let (column, row) = (from.0.min(to.0), from.1.min(to.1));
        let before = if from.0 == to.0 { (column.wrapping_sub(1), row) } else { (column, row.wrapping_sub(1)) };
        let (across, down) = (self.width - 1, self.height - 1);
        let is_unbound = |(column, row): (usize, usize)| {
            column < across && row < down && self.unbound.get(row * across + column).is_some_and(|unbound| *unbound)
        };
        is_unbound((column, row)) || is_unbound(before)
    }

    /// Samples across.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Samples down.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The height of one sample.
    #[inline]
    pub fn at(&self, column: usize, row: usize) -> f64 {
        debug_assert!(column < self.width && row < self.height, "sample {column}, {row}");
        let index = row * self.width + column;
        match &self.heights {
            Heights::F32(v) => f64::from(v[index]),
            Heights::F64(v) => v[index],
        }
    }

    /// The value of a channel at one sample.
    #[inline]
    pub fn channel_at(&self, channel: usize, column: usize, row: usize) -> f64 {
        debug_assert!(column < self.width && row < self.height, "sample {column}, {row}");
        self.channels[channel][row * self.width + column]
    }

    /// The value of a channel at a vertex.
    ///
    /// # Panics
    /// If the vertex does not lie on a sample of the tile.
    pub fn channel_at_vertex(&self, channel: usize, vertex: Vertex) -> f64 {
        self.channels[channel][self.sample_of_vertex(vertex)]
    }

    /// The place of a vertex's sample in the tile: row · width + column.
    ///
    /// # Panics
    /// If the vertex does not lie on a sample of the tile.
    pub(crate) fn sample_of_vertex(&self, vertex: Vertex) -> usize {
        let sample = vertex.at.sample().filter(|&(column, row)| column < self.width && row < self.height);
        let (column, row) = sample.unwrap_or_else(|| panic!("{vertex:?} of a tile with channels lies on no sample"));
        row * self.width + column
    }

    /// Whether errors weigh differently from sample to sample.
    pub fn is_weighted(&self) -> bool {
        !self.weights.is_empty()
    }

    /// What an error at one sample weighs.
    #[inline]
    pub fn weight(&self, column: usize, row: usize) -> f64 {
        debug_assert!(column < self.width && row < self.height, "sample {column}, {row}");
        if self.weights.is_empty() { 1.0 } else { self.weights[row * self.width + column] }
    }

    /// The largest error allowed at one sample, where error × weight is to be within `tolerance`: see [`exact::limit`].
    /// Without weights it is the tolerance as it is.
    #[inline]
    pub fn limit(&self, column: usize, row: usize, tolerance: f64) -> f64 {
        if self.weights.is_empty() { tolerance } else { exact::limit(self.weight(column, row), tolerance) }
    }

    /// Which samples are heights.
    pub fn validity(&self) -> &Validity {
        &self.validity
    }

    /// Takes the ground away that an outline does not leave, see [`Validity`]: of every sample and those around, row by row.
    ///
    /// # Panics
    /// If they are not as many.
    pub(crate) fn cut(&mut self, cut: Vec<SampleCut>) {
        self.validity.cut(cut);
    }

    /// A checksum of heights, their validity, weights and channels, and of what is eased and unbound beside lines, bit for bit: equal
    /// tiles have equal ones on every machine of one byte order.
    pub fn checksum(&self) -> u32 {
        let len = self.width * self.height;
        let mut hasher = crc32fast::Hasher::new();
        match &self.heights {
            Heights::F32(v) => hasher.update(bytemuck::cast_slice(&v[..len])),
            Heights::F64(v) => hasher.update(bytemuck::cast_slice(&v[..len])),
        }
        self.channels.iter().for_each(|values| hasher.update(bytemuck::cast_slice(&values[..len])));
        if self.is_weighted() {
            hasher.update(bytemuck::cast_slice(&self.weights[..len]));
        }
        self.validity.bytes().iter().for_each(|bytes| hasher.update(bytes));
        for EasedSample { sample, height, low, high } in &self.eased {
            hasher.update(&sample.to_ne_bytes());
            hasher.update(bytemuck::cast_slice(&[*height, *low, *high]));
        }
        hasher.update(bytemuck::cast_slice(&self.unbound));
        hasher.finalize()
    }

    /// The place of the tile's last sample on its lattice.
    pub fn far_corner(&self) -> Point {
        Point::of_sample(self.width as i32 - 1, self.height as i32 - 1)
    }
}
