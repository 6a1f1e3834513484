//! Chunks as bytes: little-endian, fixed-size records, a checksum at the end.

use super::{Attribute, Chunk};
use crate::base::handed_over::make_room;
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::kernel::measure::{ANGLES, BINS, ErrorStats, Extent, HeightStats, OVERSHOOTS, ShapeStats, WeightedStats};
use crate::kernel::seam::{Foreign, RimCounts};

const MAGIC: &[u8; 4] = b"TBCK";
const VERSION: u32 = 14;

/// What every chunk has: its head, the statistics of its errors, the checksum.
const FIXED_BYTES: usize = 260 + 8 * (BINS + ANGLES + OVERSHOOTS);

/// What is wrong with some bytes: (expected, found).
pub(super) type Damage = (String, String);

/// Writes a chunk to the end of `out`.
pub(super) fn encode(chunk: &Chunk, out: &mut Vec<u8>) {
    let start = out.len();
    out.extend_from_slice(MAGIC);
    for word in [VERSION, chunk.shared, chunk.pending, chunk.samples_checksum] {
        out.extend_from_slice(&word.to_le_bytes());
    }
    for word in [chunk.tile as u64, chunk.relaxed] {
        out.extend_from_slice(&word.to_le_bytes());
    }
    let RimCounts { corners, north, west, east, south } = chunk.rim;
    let Chunk { vertices, borrowed, foreign, triangles, attributes, .. } = chunk;
    let lengths = [vertices.len(), borrowed.len(), foreign.len(), triangles.len(), attributes.len()];
    let values: usize = attributes.iter().map(|a| 12 + a.name.len() + 8 * a.values.len()).sum();
    out.reserve_exact(
        16 * (vertices.len() + borrowed.len() + foreign.len()) + 12 * triangles.len() + values + FIXED_BYTES,
    );
    for count in [corners, north, west, east, south].into_iter().chain(lengths.map(|l| l as u32)) {
        out.extend_from_slice(&count.to_le_bytes());
    }
    for vertex in vertices.iter().chain(borrowed) {
        out.extend_from_slice(&vertex.at.x.to_le_bytes());
        out.extend_from_slice(&vertex.at.y.to_le_bytes());
        out.extend_from_slice(&vertex.height.to_le_bytes());
    }
    for &foreign in foreign {
        let words = match foreign {
            Foreign::NorthEast => [0, 0, 0, 0],
            Foreign::SouthWest => [1, 0, 0, 0],
            Foreign::SouthEast => [2, 0, 0, 0],
            Foreign::East(ordinal) => [3, ordinal as i32, 0, 0],
            Foreign::South(ordinal) => [4, ordinal as i32, 0, 0],
            // Shifted grids lend to the right and down only, one tile at a time.
            Foreign::At { across, down, at } => [5, across + 4 * down as i32, at.x, at.y],
        };
        words.iter().for_each(|word| out.extend_from_slice(&word.to_le_bytes()));
    }
    for index in triangles.as_flattened() {
        out.extend_from_slice(&index.to_le_bytes());
    }
    for Attribute { name, values } in attributes {
        out.extend_from_slice(&(name.len() as u32).to_le_bytes());
        out.extend_from_slice(name.as_bytes());
        values.iter().for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
    }
    encode_errors(&chunk.errors, out);
    let checksum = crc32fast::hash(&out[start..]);
    out.extend_from_slice(&checksum.to_le_bytes());
}

fn encode_errors(errors: &ErrorStats, out: &mut Vec<u8>) {
    let numbers = [errors.max, errors.weighted_max, errors.squares].map(f64::to_bits);
    let ErrorStats { samples, nodata, stray, bridged, beside, trimmed, worst, .. } = *errors;
    let counts = [samples, nodata, stray, bridged, beside, trimmed, worst.0, worst.1];
    for word in counts.into_iter().chain(numbers) {
        out.extend_from_slice(&word.to_le_bytes());
    }
    for count in errors.histogram.iter() {
        out.extend_from_slice(&count.to_le_bytes());
    }
    let nothing = ShapeStats::default();
    let ShapeStats { angles, overshoots, overshoot_max, astray } = errors.shape.as_deref().unwrap_or(&nothing);
    out.extend_from_slice(&u64::from(errors.shape.is_some()).to_le_bytes());
    for word in angles.iter().chain(overshoots).chain([&overshoot_max.to_bits(), astray]) {
        out.extend_from_slice(&word.to_le_bytes());
    }
    let WeightedStats { max, worst } = errors.extended.unwrap_or_default();
    for word in [u64::from(errors.extended.is_some()), max.to_bits(), worst.0, worst.1] {
        out.extend_from_slice(&word.to_le_bytes());
    }
    let HeightStats { far, near, by_nearness } = errors.heights.unwrap_or_default();
    let numbers = [far.min, far.max, near.min, near.max].map(f64::to_bits);
    for word in [u64::from(errors.heights.is_some()), u64::from(by_nearness)].into_iter().chain(numbers) {
        out.extend_from_slice(&word.to_le_bytes());
    }
}

/// Reads a chunk from exactly these bytes, reusing its memory. Believes nothing before the checksum has been compared.
pub(super) fn decode(bytes: &[u8], chunk: &mut Chunk) -> Result<(), Damage> {
    let Some((body, checksum)) = bytes.split_last_chunk::<4>() else {
        return Err(("a chunk".to_string(), format!("{} bytes", bytes.len())));
    };
    let (expected, found) = (u32::from_le_bytes(*checksum), crc32fast::hash(body));
    if expected != found {
        return Err((format!("the checksum {expected:08x}"), format!("{found:08x}")));
    }
    let mut reader = Reader { rest: body };
    let magic = reader.array::<4>()?;
    let version = reader.u32()?;
    if magic != *MAGIC || version != VERSION {
        return Err((format!("version {VERSION}"), format!("version {version}")));
    }
    chunk.shared = reader.u32()?;
    chunk.pending = reader.u32()?;
    chunk.samples_checksum = reader.u32()?;
    chunk.tile = reader.u64()? as usize;
    chunk.relaxed = reader.u64()?;
    chunk.rim = RimCounts {
        corners: reader.u32()?,
        north: reader.u32()?,
        west: reader.u32()?,
        east: reader.u32()?,
        south: reader.u32()?,
    };
    let [vertices, borrowed, foreign, triangles, attributes] =
        [reader.u32()?, reader.u32()?, reader.u32()?, reader.u32()?, reader.u32()?].map(|n| n as usize);
    let vertex = |r: [u8; 16]| {
        let [x, y] = [&r[0..4], &r[4..8]].map(le_i32);
        Ok(Vertex { at: Point { x, y }, height: f64::from_bits(le_u64(&r[8..16])) })
    };
    reader.records(vertices, &mut chunk.vertices, vertex)?;
    reader.records(borrowed, &mut chunk.borrowed, vertex)?;
    reader.records(foreign, &mut chunk.foreign, |r: [u8; 16]| {
        let [kind, word, x, y] = [&r[0..4], &r[4..8], &r[8..12], &r[12..16]].map(le_i32);
        let ordinal = word as u32;
        Ok(match kind {
            0 => Foreign::NorthEast,
            1 => Foreign::SouthWest,
            2 => Foreign::SouthEast,
            3 => Foreign::East(ordinal),
            4 => Foreign::South(ordinal),
            5 if (-1..=7).contains(&word) => {
                let down = (word + 1) as u32 / 4;
                Foreign::At { across: word - 4 * down as i32, down, at: Point { x, y } }
            }
            other => return Err(("a kind of vertex from 0 to 5".to_string(), other.to_string())),
        })
    })?;
    let in_tile = (vertices + foreign.max(borrowed)) as u32;
    reader.records(triangles, &mut chunk.triangles, |r: [u8; 12]| {
        let corners = [&r[0..4], &r[4..8], &r[8..12]].map(|b| le_i32(b) as u32);
        match corners.iter().find(|&&i| i >= in_tile) {
            Some(wrong) => Err((format!("vertices below {in_tile}"), wrong.to_string())),
            None => Ok(corners),
        }
    })?;
    chunk.attributes.clear();
    for _ in 0..attributes {
        let length = reader.u32()? as usize;
        let name = String::from_utf8_lossy(reader.take(length)?).into_owned();
        let mut values = Vec::new();
        reader.records(vertices, &mut values, |r: [u8; 8]| Ok(f64::from_bits(le_u64(&r))))?;
        chunk.attributes.push(Attribute { name, values });
    }
    chunk.errors = decode_errors(&mut reader)?;
    if reader.rest.is_empty() {
        Ok(())
    } else {
        Err(("the end".to_string(), format!("{} bytes more", reader.rest.len())))
    }
}

fn decode_errors(reader: &mut Reader<'_>) -> Result<ErrorStats, Damage> {
    let mut errors = ErrorStats {
        samples: reader.u64()?,
        nodata: reader.u64()?,
        stray: reader.u64()?,
        bridged: reader.u64()?,
        beside: reader.u64()?,
        trimmed: reader.u64()?,
        worst: (reader.u64()?, reader.u64()?),
        max: f64::from_bits(reader.u64()?),
        weighted_max: f64::from_bits(reader.u64()?),
        squares: f64::from_bits(reader.u64()?),
        ..ErrorStats::default()
    };
    for bin in 0..BINS {
        errors.histogram[bin] = reader.u64()?;
    }
    let has_shape = reader.u64()? == 1;
    let mut shape = Box::<ShapeStats>::default();
    for bin in 0..ANGLES {
        shape.angles[bin] = reader.u64()?;
    }
    for bin in 0..OVERSHOOTS {
        shape.overshoots[bin] = reader.u64()?;
    }
    shape.overshoot_max = f64::from_bits(reader.u64()?);
    shape.astray = reader.u64()?;
    errors.shape = has_shape.then_some(shape);
    let is_there = reader.u64()? == 1;
    let weighted = WeightedStats { max: f64::from_bits(reader.u64()?), worst: (reader.u64()?, reader.u64()?) };
    errors.extended = is_there.then_some(weighted);
    let has_heights = reader.u64()? == 1;
    let by_nearness = reader.u64()? == 1;
    let [far, near] = [reader.extent()?, reader.extent()?];
    errors.heights = has_heights.then_some(HeightStats { far, near, by_nearness });
    Ok(errors)
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, bytes: usize) -> Result<&'a [u8], Damage> {
        let missing = || (format!("{bytes} bytes"), format!("{}", self.rest.len()));
        let (taken, rest) = self.rest.split_at_checked(bytes).ok_or_else(missing)?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Damage> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn u32(&mut self) -> Result<u32, Damage> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Damage> {
        self.array().map(u64::from_le_bytes)
    }

    fn extent(&mut self) -> Result<Extent, Damage> {
        Ok(Extent { min: f64::from_bits(self.u64()?), max: f64::from_bits(self.u64()?) })
    }

    /// Reads `count` records of N bytes; the bytes are there before memory is taken for them.
    fn records<const N: usize, T>(
        &mut self,
        count: usize,
        into: &mut Vec<T>,
        record: impl Fn([u8; N]) -> Result<T, Damage>,
    ) -> Result<(), Damage> {
        let bytes = self.take(count.saturating_mul(N))?;
        make_room(into, count);
        let (records, _) = bytes.as_chunks::<N>();
        records.iter().try_for_each(|&r| record(r).map(|t| into.push(t)))
    }
}

fn le_i32(bytes: &[u8]) -> i32 {
    i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn le_u64(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
}
