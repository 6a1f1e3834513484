//! A file of quantized-mesh 1.0, read by code that shares nothing with what wrote it.

/// A decoded file.
#[derive(Debug, Clone)]
pub(super) struct Decoded {
    pub(super) centre: [f64; 3],
    /// In half axes.
    pub(super) occlusion_point: [f64; 3],
    pub(super) minimum: f64,
    pub(super) maximum: f64,
    pub(super) sphere: ([f64; 3], f64),
    /// From the west, from the south, and above the minimum, 0 to 32767 each.
    pub(super) vertices: Vec<[u16; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// West, south, east, north, as the file lists them.
    pub(super) sides: [Vec<u32>; 4],
    /// Of each vertex, where there are some.
    pub(super) normals: Option<Vec<[u8; 2]>>,
}

/// The largest coordinate.
pub(super) const LAST: u16 = 32767;

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or_else(|| format!("expected {count} bytes of {what} at byte {}, found the end", self.at))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn double(&mut self, what: &str) -> Result<f64, String> {
        let bytes = self.take(8, what)?.try_into().map_err(|_| what.to_string())?;
        let value = f64::from_le_bytes(bytes);
        if value.is_finite() { Ok(value) } else { Err(format!("expected finite {what}, found {value}")) }
    }

    fn three(&mut self, what: &str) -> Result<[f64; 3], String> {
        Ok([self.double(what)?, self.double(what)?, self.double(what)?])
    }

    fn single(&mut self, what: &str) -> Result<f64, String> {
        let bytes = self.take(4, what)?.try_into().map_err(|_| what.to_string())?;
        let value = f32::from_le_bytes(bytes);
        if value.is_finite() { Ok(value.into()) } else { Err(format!("expected finite {what}, found {value}")) }
    }

    fn count(&mut self, what: &str) -> Result<usize, String> {
        let bytes = self.take(4, what)?.try_into().map_err(|_| what.to_string())?;
        Ok(u32::from_le_bytes(bytes) as usize)
    }

    fn shorts(&mut self, count: usize, what: &str) -> Result<Vec<u16>, String> {
        let bytes = self.take(count.saturating_mul(2), what)?;
        Ok(bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect())
    }
}

/// Undoes differences in zig-zag order.
fn undone(codes: &[u16], what: &str) -> Result<Vec<u16>, String> {
    let mut value = 0i32;
    let mut all = Vec::with_capacity(codes.len());
    for &code in codes {
        value += if code % 2 == 0 { i32::from(code / 2) } else { -i32::from(code / 2) - 1 };
        let known = u16::try_from(value).ok().filter(|v| *v <= LAST);
        all.push(known.ok_or_else(|| format!("expected {what} from 0 to {LAST}, found {value}"))?);
    }
    Ok(all)
}

/// Reads a file.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, String> {
    let mut cursor = Cursor { bytes, at: 0 };
    let centre = cursor.three("centre")?;
    let (minimum, maximum) = (cursor.single("least height")?, cursor.single("greatest height")?);
    let sphere = (cursor.three("sphere's centre")?, cursor.double("sphere's radius")?);
    let occlusion_point = cursor.three("occlusion point")?;
    let count = cursor.count("number of vertices")?;
    if count > 65_536 {
        return Err(format!("expected at most 65536 vertices, found {count}"));
    }
    let mut column = |what: &str| undone(&cursor.shorts(count, what)?, what);
    let (u, v, heights) = (column("u")?, column("v")?, column("height")?);
    let vertices: Vec<[u16; 3]> = (0..count).map(|i| [u[i], v[i], heights[i]]).collect();
    let triangles = cursor.count("number of triangles")?;
    if triangles > 2 * 65_536 {
        return Err(format!("expected at most {} triangles, found {triangles}", 2 * 65_536));
    }
    let codes = cursor.shorts(triangles.saturating_mul(3), "triangles")?;
    let (mut highest, mut corners) = (0u32, Vec::with_capacity(codes.len()));
    for code in codes {
        let index = highest.checked_sub(u32::from(code)).filter(|index| (*index as usize) < count);
        let index = index.ok_or_else(|| format!("expected vertices in the order of first use, found code {code}"))?;
        highest += u32::from(code == 0);
        corners.push(index);
    }
    let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let mut sides: [Vec<u32>; 4] = Default::default();
    for side in &mut sides {
        let count = cursor.count("number of border vertices")?;
        *side = cursor.shorts(count, "border vertices")?.into_iter().map(u32::from).collect();
        if let Some(wrong) = side.iter().find(|i| **i as usize >= vertices.len()) {
            return Err(format!("expected border vertices below {}, found {wrong}", vertices.len()));
        }
    }
    let mut normals = None;
    while cursor.at < bytes.len() {
        let id = cursor.take(1, "extension")?[0];
        let length = cursor.count("length of an extension")?;
        let content = cursor.take(length, "extension")?;
        if id == 1 {
            if length != 2 * vertices.len() {
                return Err(format!("expected {} bytes of normals, found {length}", 2 * vertices.len()));
            }
            normals = Some(content.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect());
        }
    }
    Ok(Decoded { centre, occlusion_point, minimum, maximum, sphere, vertices, triangles, sides, normals })
}

impl Decoded {
    /// The height of a vertex: exact where the range is 32767 steps of a power of two.
    pub(super) fn height(&self, vertex: usize) -> f64 {
        let step = (self.maximum - self.minimum) / f64::from(LAST);
        self.minimum + f64::from(self.vertices[vertex][2]) * step
    }
}
