//! Reading PLY files of any origin, and refusing damaged ones.

use std::io::Write;

use proptest::prelude::*;

use super::{Encoding, PlyError, PlyFile, ScalarType};

/// A file with these bytes; it is deleted with the handle.
fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    file
}

type Mesh = (Vec<[f64; 3]>, Vec<[u64; 3]>);

fn read(bytes: &[u8]) -> Result<Mesh, PlyError> {
    let file = file(bytes);
    let mut ply = PlyFile::open(file.path())?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    ply.for_each_face(|index, face| {
        assert_eq!(index, faces.len() as u64);
        faces.push(face);
        Ok::<(), PlyError>(())
    })?;
    ply.for_each_vertex(|index, vertex| {
        assert_eq!(index, vertices.len() as u64);
        vertices.push(vertex);
        Ok::<(), PlyError>(())
    })?;
    Ok((vertices, faces))
}

const TRIANGLE: &str = "ply\nformat ascii 1.0\ncomment  made by hand \nelement vertex 3\nproperty double x\n\
    property double y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 1.5\n1 0 -2e3\n0 1 nan\n3 0 1 2\n";

/// The triangle of `TRIANGLE` in binary, with properties and elements that nobody asked for in between.
fn rich_binary(big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut out = format!(
        "ply\r\nformat {format} 1.0\r\nobj_info whatever\r\nelement strip 2\r\nproperty list ushort short ids\r\n\
         property uchar flag\r\nelement face 1\r\nproperty float quality\r\nproperty list int8 uint vertex_index\r\n\
         element user 5\r\nproperty double d\r\nelement vertex 3\r\nproperty double z\r\n\
         property list uchar float extra\r\nproperty short y\r\nproperty uchar red\r\nproperty float x\r\nend_header\r\n"
    )
    .into_bytes();
    macro_rules! put {
        ($($v:expr),*) => {$(out.extend(if big { $v.to_be_bytes().to_vec() } else { $v.to_le_bytes().to_vec() });)*};
    }
    put!(2u16, 7i16, 8i16, 1u8, 0u16, 2u8);
    put!(0.5f32, 3i8, 0u32, 1u32, 2u32);
    put!(1.0f64, 2.0f64, 3.0f64, 4.0f64, 5.0f64);
    for (x, y, z) in [(0.0f32, 0i16, 1.5f64), (1.0, 0, -2e3), (0.0, 1, f64::NAN)] {
        put!(z, 1u8, 9.0f32, y, 255u8, x);
    }
    out
}

fn assert_is_the_triangle((vertices, faces): Mesh) {
    assert_eq!(vertices[..2], [[0.0, 0.0, 1.5], [1.0, 0.0, -2e3]]);
    assert_eq!(vertices[2][..2], [0.0, 1.0]);
    assert!(vertices[2][2].is_nan());
    assert_eq!(faces, [[0, 1, 2]]);
}

#[test]
fn reads_every_encoding_and_any_order_of_elements() {
    assert_is_the_triangle(read(TRIANGLE.as_bytes()).unwrap());
    assert_is_the_triangle(read(&rich_binary(false)).unwrap());
    assert_is_the_triangle(read(&rich_binary(true)).unwrap());
    assert_is_the_triangle(read(TRIANGLE.replace('\n', " \r\n").as_bytes()).unwrap());
    assert_is_the_triangle(read(TRIANGLE.trim_end().as_bytes()).unwrap());
}

#[test]
fn shows_what_the_header_says() {
    let f = file(TRIANGLE.as_bytes());
    let ply = PlyFile::open(f.path()).unwrap();
    assert_eq!((ply.vertex_count(), ply.face_count()), (3, 1));
    assert_eq!(ply.comments(), ["made by hand"]);
    assert_eq!(ply.encoding(), Encoding::Ascii);
    assert_eq!(ply.coordinate_types(), [ScalarType::F64; 3]);
}

#[test]
fn ascii_singles_are_rounded_to_singles() {
    let (vertices, _) = read(TRIANGLE.replace("double x", "float x").replace("\n1 0", "\n0.1 0").as_bytes()).unwrap();
    assert_eq!(vertices[1][0], f64::from(0.1f32));
}

macro_rules! assert_error {
    ($bytes:expr, $pattern:pat) => {
        let result = read($bytes);
        assert!(matches!(result, Err($pattern)), "{result:?}");
    };
}

#[test]
fn damaged_headers_name_the_line() {
    assert_error!(b"", PlyError::Header { line: 1, .. });
    assert_error!(&[0xff; 5000], PlyError::Header { line: 1, .. });
    assert_error!(b"ply\nformat ascii 2.0\n", PlyError::Header { line: 2, .. });
    let broken = |from: &str, to: &str| TRIANGLE.replace(from, to).into_bytes();
    assert_error!(&broken("vertex 3", "vertex -3"), PlyError::Header { line: 4, .. });
    assert_error!(&broken("vertex 3", "vertex 99999999999999999999"), PlyError::Header { line: 4, .. });
    assert_error!(&broken("double z", "real z"), PlyError::Header { line: 7, .. });
    assert_error!(&broken("element vertex 3\n", ""), PlyError::Header { line: 4, .. });
    assert_error!(&broken("list uchar", "list float"), PlyError::Header { line: 9, .. });
    assert_error!(&broken("end_header", "end_head"), PlyError::Header { line: 10, .. });
    assert_error!(&broken("double z", "double h"), PlyError::Missing { .. });
    assert_error!(&broken("face", "polygon"), PlyError::Missing { .. });
    assert_error!(&broken("int vertex_indices", "float vertex_indices"), PlyError::Missing { .. });
    let endless = format!("ply\nformat ascii 1.0\n{}", "comment x\n".repeat(200_000));
    assert_error!(endless.as_bytes(), PlyError::HeaderTooLong { .. });
    assert_error!(&TRIANGLE.as_bytes()[..100], PlyError::Header { .. });
}

#[test]
fn lying_counts_are_found_before_reading() {
    let lie = |from: &str, to: &str| TRIANGLE.replace(from, to).into_bytes();
    assert_error!(&lie("vertex 3", "vertex 18446744073709551615"), PlyError::Count { .. });
    assert_error!(&lie("face 1", "face 1000000000000"), PlyError::Count { .. });
    assert_error!(&lie("face 1", "face 2"), PlyError::Truncated { index: 1, .. } | PlyError::Count { .. });
    // Elements without properties take no bytes, however many there are.
    let void = lie("element face", "element void 18446744073709551615\nelement face");
    assert_is_the_triangle(read(&void).unwrap());
}

#[test]
fn damaged_bodies_name_the_element() {
    let broken = |from: &str, to: &str| TRIANGLE.replace(from, to).into_bytes();
    assert_error!(&broken("3 0 1 2", "4 0 1 2 0"), PlyError::NotATriangle { face: 0, found: 4, .. });
    assert_error!(&broken("3 0 1 2", "3 0 1 3"), PlyError::VertexIndex { face: 0, found: 3, vertices: 3, .. });
    assert_error!(&broken("3 0 1 2", "3 0 -1 2"), PlyError::VertexIndex { found: -1, .. });
    assert_error!(&broken("3 0 1 2", "3 0 x 2"), PlyError::Number { index: 0, .. });
    assert_error!(&broken("3 0 1 2", "300 0 1 2"), PlyError::Number { index: 0, .. });
    assert_error!(&broken("list uchar", "list char").replace(b"3 0 1 2", b"-1 0 12"), PlyError::ListLength { .. });
    assert_error!(&broken("1 0 -2e3", &"9".repeat(5000)), PlyError::Number { index: 1, .. });
}

#[test]
fn the_visitor_can_stop_a_pass() {
    let f = file(TRIANGLE.as_bytes());
    let mut ply = PlyFile::open(f.path()).unwrap();
    let mut seen = 0;
    let stopped = ply.for_each_vertex(|_, _| {
        seen += 1;
        Err(Stop::Visitor)
    });
    assert!(matches!(stopped, Err(Stop::Visitor)));
    assert_eq!(seen, 1);
}

enum Stop {
    Visitor,
    Ply,
}

impl From<PlyError> for Stop {
    fn from(_: PlyError) -> Stop {
        Stop::Ply
    }
}

trait Replace {
    fn replace(self, from: &[u8], to: &[u8]) -> Vec<u8>;
}
impl Replace for Vec<u8> {
    fn replace(mut self, from: &[u8], to: &[u8]) -> Vec<u8> {
        let at = self.windows(from.len()).position(|w| w == from).unwrap();
        self.splice(at..at + from.len(), to.iter().copied());
        self
    }
}

proptest! {
    #[test]
    fn cut_files_are_errors(cut in 1usize..60, big in any::<bool>()) {
        let whole = rich_binary(big);
        prop_assert!(read(&whole[..whole.len() - cut]).is_err());
    }

    #[test]
    fn damage_never_panics(
        binary in any::<bool>(), damage in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = if binary { rich_binary(true) } else { TRIANGLE.as_bytes().to_vec() };
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let _ = read(&bytes);
    }
}
