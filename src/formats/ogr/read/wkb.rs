//! Triangles and lines in well-known binary, in the ISO's numbers and as GDAL gives it: little-endian.

/// A triangle's corners.
pub(super) type Corners = [[f64; 3]; 3];

/// How deep a geometry may lie in others.
const DEPTH: u32 = 4;

const LINE: u32 = 2;
const POLYGON: u32 = 3;
const MULTI_POLYGON: u32 = 6;
const COLLECTION: u32 = 7;
const POLYHEDRAL_SURFACE: u32 = 15;
const TIN: u32 = 16;
const TRIANGLE: u32 = 17;

/// Adds the triangles of a geometry to `triangles`.
///
/// # Errors
/// What it is, if it is not made of triangles with heights.
pub(super) fn triangles(wkb: &[u8], triangles: &mut Vec<Corners>) -> Result<(), String> {
    let mut rest = Rest(wkb);
    geometry(&mut rest, triangles, DEPTH)?;
    if rest.0.is_empty() { Ok(()) } else { Err(format!("{} bytes more than the geometry", rest.0.len())) }
}

/// The points of a line with heights.
///
/// # Errors
/// What it is, if it is none.
pub(super) fn line(wkb: &[u8]) -> Result<Vec<[f64; 3]>, String> {
    let mut rest = Rest(wkb);
    let [1] = rest.bytes::<1>()? else { return Err("big-endian numbers".to_string()) };
    let kind = rest.number()?;
    if kind != 1000 + LINE {
        return Err(format!("{} of another kind", name(kind % 1000)));
    }
    let count = rest.number()?;
    if rest.0.len() as u64 != 24 * u64::from(count) {
        return Err(format!("{} bytes for {count} points", rest.0.len()));
    }
    (0..count)
        .map(|_| {
            let mut point = [0.0; 3];
            for value in &mut point {
                *value = f64::from_le_bytes(rest.bytes()?);
            }
            Ok(point)
        })
        .collect()
}

fn geometry(rest: &mut Rest<'_>, triangles: &mut Vec<Corners>, depth: u32) -> Result<(), String> {
    if depth == 0 {
        return Err("geometries within geometries".to_string());
    }
    let [1] = rest.bytes::<1>()? else { return Err("big-endian numbers".to_string()) };
    let kind = rest.number()?;
    let (kind, with) = (kind % 1000, kind / 1000);
    let dimensions = match with {
        1 => 3,
        3 => 4,
        _ => return Err(format!("{} without heights", name(kind))),
    };
    let count = rest.number()?;
    match kind {
        POLYGON | TRIANGLE if count == 0 => Err(format!("{} that is empty", name(kind))),
        POLYGON | TRIANGLE if count > 1 => Err(format!("{} with {} holes", name(kind), count - 1)),
        POLYGON | TRIANGLE => {
            triangles.push(ring(rest, dimensions)?);
            Ok(())
        }
        MULTI_POLYGON | COLLECTION | POLYHEDRAL_SURFACE | TIN if count == 0 => {
            Err(format!("{} that is empty", name(kind)))
        }
        MULTI_POLYGON | COLLECTION | POLYHEDRAL_SURFACE | TIN => {
            (0..count).try_for_each(|_| geometry(rest, triangles, depth - 1))
        }
        other => Err(name(other)),
    }
}

/// Four points, the last of which is the first.
fn ring(rest: &mut Rest<'_>, dimensions: usize) -> Result<Corners, String> {
    let count = rest.number()?;
    if count != 4 {
        return Err(match count {
            0 => "a ring without points".to_string(),
            count => format!("a ring of {} corners", count - 1),
        });
    }
    let mut points = [[0.0; 3]; 4];
    for point in &mut points {
        for value in point.iter_mut() {
            *value = f64::from_le_bytes(rest.bytes()?);
        }
        if dimensions == 4 {
            rest.bytes::<8>()?;
        }
    }
    let [a, b, c, end] = points;
    if a != end && a.map(f64::to_bits) != end.map(f64::to_bits) {
        return Err("a ring of 4 points that is not closed".to_string());
    }
    Ok([a, b, c])
}

fn name(kind: u32) -> String {
    match kind {
        1 => "a point".to_string(),
        LINE => "a line".to_string(),
        POLYGON => "a polygon".to_string(),
        4 => "points".to_string(),
        5 => "lines".to_string(),
        MULTI_POLYGON => "a multipolygon".to_string(),
        COLLECTION => "a collection".to_string(),
        POLYHEDRAL_SURFACE => "a polyhedral surface".to_string(),
        TIN => "a TIN".to_string(),
        TRIANGLE => "a triangle".to_string(),
        other => format!("a geometry of kind {other}"),
    }
}

/// What is still to be read.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (bytes, rest) = self.0.split_first_chunk().ok_or("a geometry that is cut off")?;
        self.0 = rest;
        Ok(*bytes)
    }

    fn number(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn polygon(kind: u32, rings: &[&[[f64; 3]]]) -> Vec<u8> {
        let mut wkb = vec![1];
        wkb.extend(kind.to_le_bytes());
        wkb.extend((rings.len() as u32).to_le_bytes());
        for ring in rings {
            wkb.extend((ring.len() as u32).to_le_bytes());
            ring.iter().flatten().for_each(|v| wkb.extend(v.to_le_bytes()));
        }
        wkb
    }

    fn found(wkb: &[u8]) -> Result<Vec<Corners>, String> {
        let mut found = Vec::new();
        triangles(wkb, &mut found).map(|()| found)
    }

    const A: [f64; 3] = [0.0, 0.0, 1.0];
    const B: [f64; 3] = [1.0, 0.0, 2.0];
    const C: [f64; 3] = [0.0, 1.0, 3.0];

    #[test]
    fn only_triangles_pass() {
        assert_eq!(found(&polygon(1003, &[&[A, B, C, A]])), Ok(vec![[A, B, C]]));
        assert_eq!(found(&polygon(1017, &[&[A, B, C, A]])), Ok(vec![[A, B, C]]));
        for (wkb, expected) in [
            (polygon(1003, &[]), "a polygon that is empty"),
            (polygon(1003, &[&[]]), "a ring without points"),
            (polygon(1003, &[&[A, B, C, B, A]]), "a ring of 4 corners"),
            (polygon(1003, &[&[A, B, C, B]]), "a ring of 4 points that is not closed"),
            (polygon(1003, &[&[A, B, C, A], &[A, B, C, A]]), "a polygon with 1 holes"),
            (polygon(3, &[]), "a polygon without heights"),
            (polygon(1002, &[]), "a line"),
            (polygon(1016, &[]), "a TIN that is empty"),
            (polygon(1003, &[&[A, B, C, A]])[..80].to_vec(), "a geometry that is cut off"),
            ([polygon(1003, &[&[A, B, C, A]]), vec![0]].concat(), "1 bytes more than the geometry"),
            ([1, 239, 3, 0, 0, 1, 0, 0, 0].repeat(9), "geometries within geometries"),
        ] {
            assert_eq!(found(&wkb).expect_err("refused"), expected);
        }
    }

    #[test]
    fn only_lines_with_heights_are_lines() {
        let of = |kind: u32, count: u32, points: &[[f64; 3]]| {
            let mut wkb = [&[1][..], &kind.to_le_bytes(), &count.to_le_bytes()].concat();
            points.iter().flatten().for_each(|v| wkb.extend(v.to_le_bytes()));
            line(&wkb)
        };
        assert_eq!(of(1002, 2, &[A, B]), Ok(vec![A, B]));
        assert_eq!(of(1002, 0, &[]), Ok(vec![]));
        assert_eq!(of(1002, 3, &[A, B]), Err("48 bytes for 3 points".to_string()));
        assert_eq!(of(2, 2, &[A, B]), Err("a line of another kind".to_string()));
        assert_eq!(of(1003, 2, &[A, B]), Err("a polygon of another kind".to_string()));
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(prop_oneof![Just(0u8), Just(1), any::<u8>()], 0..200)) {
            let _ = (found(&bytes), line(&bytes));
        }
    }
}
