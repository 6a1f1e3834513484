//! Fields with channels: further bands beside the heights, or instead of them.

use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::decode::units;
use super::load::Missing;
use super::source::Source;
use super::{Access, Choice, Field, FieldError, FieldOptions};
use crate::base::Validity;
use crate::base::channels::{Channel, ChannelBands, ChannelError, PLANAR_UNIT, Range, Ranges};
use crate::base::control::{Control, Stage};
use crate::base::{Band, Marks, SampleType, Scaling, Window, channels_of, with_sample_type};

/// The channels of a field: one field per band, what each is called, and the error they make.
pub(super) struct Channels {
    pub(super) fields: Vec<Field>,
    named: Vec<Channel>,
    pub(super) error: Arc<ChannelError>,
}

/// Finds the ranges that the weighted error is scaled by. Samples of 8 and 16 bits without a sign have the range of
/// their type, 0 to 255 and 0 to 65535 (the paper's colours from 0 to 1); of other bands and of the heights every
/// sample is read once, through GDAL, in parallel on the current rayon pool. Nothing is read of a planar image of such
/// samples.
///
/// # Errors
/// [`FieldError`], for samples without a value among others.
pub fn find_ranges(heights: &Band, options: &ChannelBands, control: &Control<'_>) -> Result<Ranges, FieldError> {
    let bands = &options.bands;
    let searched: Vec<&Band> = (!options.planar)
        .then_some(heights)
        .into_iter()
        .chain(bands.iter().filter(|b| type_range(b).is_none()))
        .collect();
    let (steps, samples) = searched.iter().fold((0, 0), |(steps, samples), r| {
        (steps + units(r).len() as u64, samples + r.width() as u64 * r.height() as u64)
    });
    control.progress.begin(Stage::Ranges, steps, samples);
    let range = if options.planar { Range { min: 0.0, max: 0.0 } } else { search(heights, heights, control)? };
    let own = |band: &Band| search(if options.planar { band } else { heights }, band, control);
    let range_of = |band: &Band| type_range(band).map_or_else(|| own(band), Ok);
    let channels = bands.iter().map(range_of).collect::<Result<Vec<_>, FieldError>>()?;
    control.progress.end(Stage::Ranges);
    let unit = if options.planar { PLANAR_UNIT } else { range.width() };
    Ok(Ranges { heights: range, channels, unit })
}

/// Finds the least and the largest height of a raster: what its type says, of samples of 8 and 16 bits without scale and
/// offset, else every sample is read once, through GDAL, in parallel on the current rayon pool.
///
/// # Errors
/// [`FieldError`].
pub fn height_range(band: &Band, control: &Control<'_>) -> Result<Range, FieldError> {
    let (min, max) = match band.sample_type() {
        SampleType::U8 => (0.0, 255.0),
        SampleType::I8 => (-128.0, 127.0),
        SampleType::U16 => (0.0, 65535.0),
        SampleType::I16 => (-32768.0, 32767.0),
        _ => (f64::NAN, f64::NAN),
    };
    if min <= max && band.scaling().is_none() {
        return Ok(Range { min, max });
    }
    searched_range(band, control)
}

/// Finds the least and the largest value of a band that any sample has: every sample is read once, in parallel on the
/// current rayon pool.
///
/// # Errors
/// [`FieldError`].
pub fn searched_range(band: &Band, control: &Control<'_>) -> Result<Range, FieldError> {
    let steps = units(band).len() as u64;
    control.progress.begin(Stage::Ranges, steps, band.samples());
    let range = search(band, band, control)?;
    control.progress.end(Stage::Ranges);
    Ok(range)
}

fn type_range(band: &Band) -> Option<Range> {
    let max = match band.sample_type() {
        SampleType::U8 => 255.0,
        SampleType::U16 => 65535.0,
        _ => return None,
    };
    band.scaling().is_none().then_some(Range { min: 0.0, max })
}

/// The least and the largest value do not depend on who finds them.
fn search(heights: &Band, band: &Band, control: &Control<'_>) -> Result<Range, FieldError> {
    let options = FieldOptions { choice: Choice::Windows, ..FieldOptions::default() };
    let field = Field::open(band, &options, control)?.called_after(heights, band);
    let of_heights = heights.number() == band.number();
    let search_unit = |(values, scratch, validity): &mut (Vec<f64>, Vec<u64>, Validity), &unit: &Window| {
        control.cancel.check()?;
        validity.reset(unit, (field.width, field.height));
        // Heights may be missing; what is missing of a channel may be so where there is a height.
        let missing = if of_heights { Missing::Marked(validity) } else { Missing::Refused };
        field.load_values(unit, values, scratch, missing)?;
        control.progress.step(Stage::Ranges, unit.len() as u64);
        let valid = |i: usize| validity.is_valid((i % unit.width) as i32, (i / unit.width) as i32);
        let there = values.iter().enumerate().filter(|(i, _)| valid(*i));
        // A zero has no sign here.
        Ok(there.fold(Range::EMPTY, |r, (_, &v)| r.and(Range { min: v + 0.0, max: v + 0.0 })))
    };
    let units = units(band);
    units.par_iter().map_init(Default::default, search_unit).try_reduce(|| Range::EMPTY, |a, b| Ok(a.and(b)))
}

impl Field {
    /// Makes the heights of `band` readable (or takes them as 0, see [`ChannelBands::planar`]), and the channels
    /// beside them, each as [`Field::open`] does.
    ///
    /// # Errors
    /// [`FieldError`]; nothing is left behind.
    ///
    /// # Panics
    /// If the ranges are not those of the channels, or [`ChannelError::new`] does.
    pub fn open_extended(
        band: &Band,
        options: &FieldOptions,
        channels: &ChannelBands,
        ranges: &Ranges,
        control: &Control<'_>,
    ) -> Result<Field, FieldError> {
        assert_eq!(channels.bands.len(), ranges.channels.len(), "ranges of channels");
        let open = |own: &Band| Ok(Field::open(own, options, control)?.called_after(band, own));
        let fields = channels.bands.iter().map(open).collect::<Result<Vec<Field>, FieldError>>()?;
        let heights = match channels.planar {
            true => Field::level(band, fields[0].access.clone()),
            false => Field::open(band, options, control)?,
        };
        Ok(heights.with_channels(
            fields.into_iter().zip(channels_of(&channels.bands)).collect(),
            ChannelError::new(channels.emphasis, ranges),
        ))
    }

    /// The same field with these channels, each a field whose heights are the channel's values.
    ///
    /// # Panics
    /// If a channel has another size, there are more or fewer than the error is for, or the field has weights or bridged
    /// holes.
    pub fn with_channels(self, channels: Vec<(Field, Channel)>, error: ChannelError) -> Field {
        assert!(self.importance.is_none(), "channels beside weights");
        assert!(self.holes.is_none(), "channels beside bridged holes");
        let (fields, named): (Vec<Field>, Vec<Channel>) = channels.into_iter().unzip();
        assert!(fields.iter().all(|f| (f.width, f.height) == (self.width, self.height)), "sizes of channels");
        assert_eq!(fields.len(), error.scales().len(), "channels of the error");
        Field { channels: Some(Channels { fields, named, error: Arc::new(error) }), ..self }
    }

    /// What channels there are beside the heights.
    pub fn channels(&self) -> &[Channel] {
        self.channels.as_ref().map_or(&[], |c| &c.named)
    }

    /// What an error in the channels counts, where there are some.
    pub fn channel_error(&self) -> Option<&ChannelError> {
        self.channels.as_ref().map(|c| c.error.as_ref())
    }

    /// Whether it has no heights, but is an image of its channels.
    pub(super) fn is_image(&self) -> bool {
        matches!(self.source, Source::Level)
    }

    /// The fields that are read: that of the heights, unless they are 0, and those of the channels.
    pub fn each(&self) -> impl Iterator<Item = &Field> {
        let heights = (!self.is_image()).then_some(self);
        heights.into_iter().chain(self.channels.iter().flat_map(|c| &c.fields))
    }

    /// Copies a window's values, as doubles.
    pub(super) fn load_values(
        &self,
        window: Window,
        values: &mut Vec<f64>,
        scratch: &mut Vec<u64>,
        missing: Missing<'_>,
    ) -> Result<(), FieldError> {
        values.resize(window.len(), 0.0);
        with_sample_type!(self.sample_type, T => self.copy::<T, f64>(window, scratch, values, missing))
    }

    /// Height 0 everywhere, but outside of the cutline.
    fn level(band: &Band, access: Access) -> Field {
        Field {
            name: band.path().to_path_buf(),
            width: band.width(),
            height: band.height(),
            block: band.block_size(),
            sample_type: SampleType::U8,
            scaling: Scaling::NONE,
            marks: Marks::default(),
            tag: None,
            geo_transform: band.geo_transform(),
            source: Source::Level,
            mask: None,
            cutline: band.cutline().cloned(),
            access,
            channels: None,
            importance: None,
            holes: None,
            watches: Arc::default(),
        }
    }

    /// Messages name the band where it is not that of the heights.
    fn called_after(self, heights: &Band, band: &Band) -> Field {
        if heights.number() == band.number() {
            return self;
        }
        Field { name: PathBuf::from(format!("{} (band {})", band.path().display(), band.number())), ..self }
    }
}

#[cfg(test)]
mod tests;
