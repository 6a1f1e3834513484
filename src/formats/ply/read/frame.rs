use crate::base::GeoTransform;

use super::{PlyFile, ScalarType};

/// How places on the map and heights stand in a file: less an origin, heights times a factor, perhaps in single precision.
///
/// The header has it as the comments `offset X Y` (to be added to x and y) and `z_scale F` (z is the height times F), so
/// that whoever reads the file finds map coordinates, and the sample at which a vertex stands. Both directions are defined
/// here, operation by operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// What is taken from x and y.
    pub origin: (f64, f64),
    /// What heights are multiplied by; above 0.
    pub z_scale: f64,
    /// Whether x, y and z are written in single precision.
    pub single: bool,
}

impl Default for Frame {
    fn default() -> Self {
        Frame::PLAIN
    }
}

impl Frame {
    /// Map coordinates and heights as they are.
    pub const PLAIN: Frame = Frame { origin: (0.0, 0.0), z_scale: 1.0, single: false };

    /// That of a file: its header's comments, and the type of its coordinates. Comments that are not as terrabite writes
    /// them mean nothing.
    pub fn of(mesh: &PlyFile) -> Frame {
        let numbers = |name: &str| -> Option<Vec<f64>> {
            let mut words = mesh.comments().iter().filter_map(|c| c.strip_prefix(name)?.strip_prefix(' '));
            let numbers: Option<Vec<f64>> = words.next()?.split_whitespace().map(|w| w.parse().ok()).collect();
            numbers.filter(|n| n.iter().all(|n| n.is_finite()))
        };
        let origin = numbers("offset").and_then(|n| Some((*n.first()?, *n.get(1)?)).filter(|_| n.len() == 2));
        let z_scale = numbers("z_scale").and_then(|n| n.first().copied().filter(|&f| f > 0.0 && n.len() == 1));
        Frame {
            origin: origin.unwrap_or(Frame::PLAIN.origin),
            z_scale: z_scale.unwrap_or(Frame::PLAIN.z_scale),
            single: mesh.coordinate_types()[..2].iter().all(|t| *t == ScalarType::F32),
        }
    }

    /// What the header says of it.
    pub fn comments(&self) -> Vec<String> {
        let mut comments = Vec::new();
        if self.origin != Frame::PLAIN.origin {
            comments.push(format!("offset {} {}", self.origin.0, self.origin.1));
        }
        if self.z_scale != Frame::PLAIN.z_scale {
            comments.push(format!("z_scale {}", self.z_scale));
        }
        comments
    }

    /// What is written of a place: `x − X`, rounded to double, then perhaps to single precision.
    pub fn written_place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.rounded(x - self.origin.0), self.rounded(y - self.origin.1))
    }

    /// What is written of a height: `height × F`, rounded to double, then perhaps to single precision.
    pub fn written_height(&self, height: f64) -> f64 {
        self.rounded(height * self.z_scale)
    }

    /// The height of what is written: `z ÷ F`, rounded to double.
    pub fn height(&self, z: f64) -> f64 {
        z / self.z_scale
    }

    /// The place on the map of what is written, up to rounding.
    pub fn on_the_map(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (x + self.origin.0, y + self.origin.1)
    }

    /// The lattice point that is written as exactly this, bit for bit; `None` if there is none.
    pub fn lattice(&self, transform: &GeoTransform, at: (f64, f64)) -> Option<(i64, i64)> {
        let (x, y) = self.nearest_lattice(transform, at)?;
        let written = self.written_place(transform.apply(x, y));
        (written.0.to_bits() == at.0.to_bits() && written.1.to_bits() == at.1.to_bits()).then_some((x, y))
    }

    /// The lattice point nearest to what is written; `None` if it is out of any raster's range.
    pub fn nearest_lattice(&self, transform: &GeoTransform, at: (f64, f64)) -> Option<(i64, i64)> {
        let (x, y) = self.on_the_map(at);
        transform.nearest_lattice(x, y)
    }

    /// Whether every lattice point of a raster of so many samples is found again: neighbours stay apart.
    pub fn tells_apart(&self, transform: &GeoTransform, width: usize, height: usize) -> bool {
        let (far_x, far_y) = (4 * (width as i64 - 1), 4 * (height as i64 - 1));
        let corners = [(0, 0), (far_x, 0), (0, far_y), (far_x, far_y)].map(|(x, y)| transform.apply(x, y));
        let largest = |of: fn((f64, f64)) -> f64| {
            corners.iter().map(|&(x, y)| of((x - self.origin.0, y - self.origin.1)).abs()).fold(0.0, f64::max)
        };
        // At most so much is lost in rounding.
        let half_step = if self.single { f64::from(f32::EPSILON) / 2.0 } else { f64::EPSILON };
        let (dx, dy) = (largest(|p| p.0) * half_step, largest(|p| p.1) * half_step);
        let [_, xp, xl, _, yp, yl] = transform.coefficients();
        let determinant = transform.determinant().abs();
        let columns = (yl.abs() * dx + xl.abs() * dy) / determinant;
        let rows = (yp.abs() * dx + xp.abs() * dy) / determinant;
        // Half a lattice step is an eighth of a cell; the rest is for rounding on the way back.
        columns < 1.0 / 16.0 && rows < 1.0 / 16.0
    }

    fn rounded(&self, value: f64) -> f64 {
        if self.single { f64::from(value as f32) } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(comments: &str, number: &str) -> Frame {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("tin.ply");
        let header = format!(
            "ply\nformat ascii 1.0\n{comments}element vertex 0\nproperty {number} x\nproperty {number} y\nproperty \
             {number} z\nelement face 0\nproperty list uchar uint vertex_indices\nend_header\n"
        );
        std::fs::write(&path, header).expect("written");
        Frame::of(&PlyFile::open(&path).expect("a mesh"))
    }

    #[test]
    fn comments_come_back() {
        let frame = Frame { origin: (499_990.123_456_789, -1e-7), z_scale: 0.3048, single: true };
        let comments: String = frame.comments().iter().map(|c| format!("comment {c}\n")).collect();
        assert_eq!(of(&comments, "float"), frame);
        assert_eq!(of(&comments, "double"), Frame { single: false, ..frame });
        assert!(Frame::PLAIN.comments().is_empty());
    }

    #[test]
    fn other_comments_mean_nothing() {
        for comment in
            ["offset in feet", "offset 1", "offset 1 2 3", "offset 1 nan", "offsets 1 2", "z_scale 0", "z_scale -1"]
        {
            assert_eq!(of(&format!("comment {comment}\n"), "double"), Frame::PLAIN, "{comment}");
        }
    }

    proptest! {
        #[test]
        fn lattice_points_come_back_where_they_are_told_apart(
            corner in (-1e7f64..1e7, -1e7f64..1e7), cell in 1e-3f64..1e2, turn in -0.9f64..0.9, single: bool, near: bool,
            (x, y) in (0i64..40_000, 0i64..40_000),
        ) {
            let size = 10_001;
            let Ok(transform) = GeoTransform::new([corner.0, cell, cell * turn, corner.1, cell * turn, -cell], size, size)
            else { return Ok(()) };
            let origin = if near { (corner.0.round(), corner.1.round()) } else { (0.0, 0.0) };
            let frame = Frame { origin, z_scale: 1.0, single };
            prop_assert!(!near || frame.tells_apart(&transform, size, size));
            if frame.tells_apart(&transform, size, size) {
                prop_assert_eq!(frame.lattice(&transform, frame.written_place(transform.apply(x, y))), Some((x, y)));
            }
        }
    }
}
