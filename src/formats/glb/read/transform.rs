//! What nodes do to places, in doubles.

use super::document::Node;

/// A linear map, row by row, and then a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform {
    linear: [[f64; 3]; 3],
    way: [f64; 3],
}

const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Transform {
    /// Nothing.
    pub(super) const NONE: Transform = Transform { linear: UNIT, way: [0.0; 3] };

    /// What a node does to what is in it; `None` if that is not affine.
    pub(super) fn of(node: &Node) -> Option<Transform> {
        if let Some(m) = &node.matrix {
            let row = |i: usize| [m[i], m[i + 4], m[i + 8]];
            let is_affine = [m[3], m[7], m[11], m[15]] == [0.0, 0.0, 0.0, 1.0];
            return is_affine.then_some(Transform { linear: [row(0), row(1), row(2)], way: [m[12], m[13], m[14]] });
        }
        let [x, y, z, w] = node.rotation.as_deref().copied().unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let scale = node.scale.as_deref().copied().unwrap_or([1.0; 3]);
        let turn = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let linear = turn.map(|row| [row[0] * scale[0], row[1] * scale[1], row[2] * scale[2]]);
        Some(Transform { linear, way: node.translation.as_deref().copied().unwrap_or([0.0; 3]) })
    }

    /// First `inner`, then this.
    pub(super) fn after(&self, inner: &Transform) -> Transform {
        let column = |j: usize| [inner.linear[0][j], inner.linear[1][j], inner.linear[2][j]];
        let columns = [column(0), column(1), column(2)];
        let linear = self.linear.map(|row| columns.map(|column| dot(row, column)));
        Transform { linear, way: self.apply(inner.way) }
    }

    pub(super) fn apply(&self, place: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| dot(self.linear[i], place) + self.way[i])
    }

    /// The way, if there is nothing else.
    pub(super) fn as_way(&self) -> Option<[f64; 3]> {
        (self.linear == UNIT).then_some(self.way)
    }

    /// Whether it makes left what is right.
    pub(super) fn mirrors(&self) -> bool {
        let [a, b, c] = self.linear;
        dot(a, [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]]) < 0.0
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform(json: &str) -> Transform {
        Transform::of(&serde_json::from_str(json).expect("a node")).expect("affine")
    }

    #[test]
    fn turns_scales_and_ways_are_taken_in_their_order() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let quarter =
            format!(r#"{{"rotation": [0, {half}, 0, {half}], "scale": [2, 1, 1], "translation": [10, 0, 0]}}"#);
        let found = transform(&quarter).apply([1.0, 5.0, 0.0]);
        let expected = [10.0, 5.0, -2.0];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        let outer = transform(r#"{"matrix": [1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,7,1]}"#);
        assert!(outer.mirrors() && !transform(&quarter).mirrors());
        let found = outer.after(&transform(&quarter)).apply([1.0, 5.0, 0.0]);
        assert!(found.iter().zip([10.0, 5.0, 9.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn ways_add_up_exactly() {
        let ways = [r#"{"translation": [500000.12, 0, -5200000.77]}"#, "{}", r#"{"translation": [0.5, 0, 0]}"#];
        let sum = ways.iter().fold(Transform::NONE, |outer, json| outer.after(&transform(json)));
        assert_eq!(sum.as_way(), Some([500_000.12 + 0.5, 0.0, -5_200_000.77]));
        assert_eq!(transform(r#"{"scale": [1, 1, 2]}"#).as_way(), None);
        let lying = r#"{"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}"#;
        assert_eq!(Transform::of(&serde_json::from_str(lying).expect("a node")), None);
    }
}
