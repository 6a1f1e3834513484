//! One axis of a data cube: the coordinates of columns or of rows, one by one.

use gdal::cpl::CslStringList;
use gdal::raster::{Dimension, Group, MDArray};

/// Coordinates that are read at a time.
const CHUNK: usize = 1 << 16;
/// How far, in cells, an even axis may be from a line.
const EVEN: f64 = 0.1;
/// Units that differ by so little are the same.
const SAME_UNIT: f64 = 0.01;

/// What an axis counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    Longitude,
    Latitude,
    Easting,
    Northing,
    Unknown,
}

impl Meaning {
    /// Of a coordinate by its attributes `standard_name`, `units` and `axis`, as the CF conventions have it.
    fn of(standard_name: &str, unit: &str, axis: &str) -> Meaning {
        match (standard_name, unit, axis) {
            ("longitude" | "grid_longitude", ..) => Meaning::Longitude,
            ("latitude" | "grid_latitude", ..) => Meaning::Latitude,
            ("projection_x_coordinate", ..) => Meaning::Easting,
            ("projection_y_coordinate", ..) => Meaning::Northing,
            (_, "degrees_east" | "degree_east" | "degree_E" | "degrees_E" | "degreeE" | "degreesE", _) => {
                Meaning::Longitude
            }
            (_, "degrees_north" | "degree_north" | "degree_N" | "degrees_N" | "degreeN" | "degreesN", _) => {
                Meaning::Latitude
            }
            (.., "X") => Meaning::Easting,
            (.., "Y") => Meaning::Northing,
            _ => Meaning::Unknown,
        }
    }

    /// West to east.
    pub(super) fn is_along(self) -> bool {
        matches!(self, Meaning::Longitude | Meaning::Easting)
    }

    /// South to north.
    pub(super) fn is_across(self) -> bool {
        matches!(self, Meaning::Latitude | Meaning::Northing)
    }
}

/// Where an axis and a geotransform differ most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Deviation {
    /// The column or row, as the file counts them.
    pub(super) index: usize,
    /// Where the file lists it.
    pub(super) listed: f64,
    /// Where the geotransform puts it.
    pub(super) placed: f64,
    /// The distance, in cells.
    pub(super) cells: f64,
}

/// The coordinates of one dimension.
#[derive(Debug)]
pub(super) struct Axis<'g> {
    pub(super) name: String,
    pub(super) meaning: Meaning,
    array: MDArray<'g>,
    length: usize,
    scale: f64,
    offset: f64,
    first: f64,
    last: f64,
}

impl<'g> Axis<'g> {
    /// The axis of a dimension: the array of its name in the innermost of `groups` that has one; or else one that says
    /// what it counts.
    pub(super) fn find(groups: &[&'g Group<'g>], dimension: &Dimension<'_>) -> Option<Axis<'g>> {
        let (name, length) = (dimension.name(), dimension.size());
        let of = |group: &&'g Group<'g>, array: &str| Axis::open(group, array, &name, length);
        let names = |group: &&'g Group<'g>| group.array_names(CslStringList::new());
        let own = groups.iter().filter(|group| names(group).contains(&name)).find_map(|group| of(group, &name));
        own.or_else(|| {
            let others = groups.iter().flat_map(|group| names(group).into_iter().map(move |array| (group, array)));
            others.filter_map(|(group, array)| of(group, &array)).find(|axis| axis.meaning != Meaning::Unknown)
        })
    }

    fn open(group: &'g Group<'g>, name: &str, dimension: &str, length: usize) -> Option<Axis<'g>> {
        let array = group.open_md_array(name, CslStringList::new()).ok()?;
        let its_own = matches!(&array.dimensions().ok()?[..], [d] if d.name() == dimension && d.size() == length);
        if !its_own || !array.datatype().class().is_numeric() || length < 2 {
            return None;
        }
        let text = |name: &str| array.attribute(name).map(|a| a.read_as_string()).unwrap_or_default();
        let number = |name: &str, default| array.attribute(name).map_or(default, |a| a.read_as_f64());
        let meaning = Meaning::of(&text("standard_name"), &array.unit(), &text("axis"));
        let (scale, offset) = (number("scale_factor", 1.0), number("add_offset", 0.0));
        let mut axis = Axis { name: name.to_string(), meaning, array, length, scale, offset, first: 0.0, last: 0.0 };
        let mut buffer = [0.0; 1];
        axis.first = axis.read(0, &mut buffer)?[0];
        axis.last = axis.read(length - 1, &mut buffer)?[0];
        // Numbers of columns or rows are no coordinates, and neither is what was never written.
        let counted = axis.last - axis.first == (length - 1) as f64 && (axis.first == 0.0 || axis.first == 1.0);
        let listed = axis.first != axis.last && !(counted && meaning == Meaning::Unknown);
        listed.then_some(axis)
    }

    fn read<'b>(&self, start: usize, buffer: &'b mut [f64]) -> Option<&'b mut [f64]> {
        self.array.read_into_slice(buffer, vec![start as u64], vec![buffer.len()]).ok()?;
        buffer.iter_mut().for_each(|v| *v = *v * self.scale + self.offset);
        Some(buffer)
    }

    /// The first coordinate and the step, if all are within a tenth of a cell of the line from the first to the last.
    pub(super) fn even(&self) -> Option<(f64, f64)> {
        let step = (self.last - self.first) / (self.length - 1) as f64;
        let worst = self.worst(|i| self.first + i as f64 * step, step, 1.0)?;
        (worst.cells <= EVEN).then_some((self.first, step))
    }

    /// Where the axis is farthest from a geotransform that puts the first sample of the raster at `first` and others
    /// `cell` apart; it may show the last sample of the axis first where it `may_turn` it. `None` if the axis cannot be read.
    pub(super) fn deviation(&self, first: f64, cell: f64, may_turn: bool) -> Option<Deviation> {
        let ahead = !may_turn || (self.last - self.first) * cell > 0.0;
        let last = self.length - 1;
        let placed = |i: usize| first + (if ahead { i } else { last - i }) as f64 * cell;
        self.worst(placed, cell, self.unit(placed(0), placed(last)))
    }

    /// What the coordinates are multiplied by: GDAL gives kilometres as metres, and angles of a satellite's view as lengths.
    fn unit(&self, first: f64, last: f64) -> f64 {
        let ratio = (last - first) / (self.last - self.first);
        let angle = matches!(self.meaning, Meaning::Longitude | Meaning::Latitude);
        if angle || (ratio - 1.0).abs() < SAME_UNIT || !ratio.is_finite() { 1.0 } else { ratio }
    }

    fn worst(&self, placed: impl Fn(usize) -> f64, cell: f64, unit: f64) -> Option<Deviation> {
        let mut buffer = vec![0.0; CHUNK.min(self.length)];
        let mut worst = Deviation { index: 0, listed: self.first, placed: self.first, cells: 0.0 };
        for start in (0..self.length).step_by(buffer.len()) {
            let count = buffer.len().min(self.length - start);
            for (i, &mut listed) in self.read(start, &mut buffer[..count])?.iter_mut().enumerate() {
                let (index, listed) = (start + i, listed * unit);
                let placed = placed(index);
                let mut away = listed - placed;
                if self.meaning == Meaning::Longitude {
                    away -= 360.0 * (away / 360.0).round();
                }
                let cells = (away / cell).abs();
                // What is no number is nowhere.
                let cells = if cells.is_nan() { f64::INFINITY } else { cells };
                if cells > worst.cells {
                    worst = Deviation { index, listed, placed, cells };
                }
            }
        }
        Some(worst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_meaning_of_an_axis() {
        assert_eq!(Meaning::of("latitude", "1", ""), Meaning::Latitude);
        assert_eq!(Meaning::of("", "degrees_east", "Y"), Meaning::Longitude);
        assert_eq!(Meaning::of("", "m", "Y"), Meaning::Northing);
        assert_eq!(Meaning::of("projection_x_coordinate", "km", ""), Meaning::Easting);
        assert_eq!(Meaning::of("height", "m", ""), Meaning::Unknown);
    }
}
