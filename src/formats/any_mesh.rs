//! Any mesh, for the tests that hold every format to its promises.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::{Crs, Header, Heights, OptionName, RunOption};
use crate::base::channels::{Channel, Number};
use crate::base::{CoordinateFrame, LineEdge, LineType, Window};

/// A mesh as a sink is given it.
#[derive(Debug, Clone)]
pub(super) struct Given {
    pub(super) header: Header,
    pub(super) vertices: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u64; 3]>,
    pub(super) attributes: Vec<(Channel, Vec<f64>)>,
    /// Sides of triangles.
    pub(super) edges: Vec<LineEdge<u64>>,
    /// How many vertices or triangles come at a time.
    pub(super) batch: usize,
}

impl Given {
    /// Whether some edges are soft.
    pub(super) fn edges_have_types(&self) -> bool {
        self.edges.iter().any(|edge| edge.line_type == LineType::Soft)
    }
}

fn text() -> impl Strategy<Value = String> {
    let awkward = select(vec![
        "dem.tif",
        "a\nb",
        "\"quoted\" 'twice'",
        "Größe ⛰ 高さ",
        "a\\",
        "\\\n\\",
        "#1",
        "comment x",
        "end_header",
        "f 1 2 3",
        "x\r\ny",
        "  padded  ",
        "{a}%s\u{0}\t.",
        "offset 1 2",
    ]);
    let any = "[!-~][ -~äß⛰\n]{0,600}";
    prop_oneof![awkward.prop_map(str::to_string), any.prop_map(|text| text)]
}

fn header() -> impl Strategy<Value = Header> {
    use proptest::option::of;
    let option = (select(OptionName::ALL.to_vec()), text()).prop_filter_map("no other option", |(name, value)| {
        // `cutline layer x` could be either.
        (!value.trim_start().starts_with("layer")).then(|| RunOption::new(name, value))
    });
    let frame = (
        prop_oneof![Just((0.0, 0.0)), (-1e7f64..1e7, -1e7f64..1e7)],
        prop_oneof![Just(1.0), 1e-3f64..1e3],
        prop_oneof![Just((1.0, 1.0)), (1e-3f64..1e6, 1e-3f64..1e6)],
        any::<bool>(),
    );
    let crs = (of(text()), of(text()), of(text()));
    let heights = (of(text()), of(text()));
    let window = of((0..9usize, 0..9usize, 1..9usize, 1..9usize));
    let notes = vec(text().prop_map(|t| format!("note {t}")), 0..3);
    let facts = (of(text()), of(text()), window, of(0.0f64..1e9), vec(option, 0..4), notes);
    (frame, crs, heights, facts).prop_map(|((origin, z_scale, xy_scale, single), crs, heights, facts)| {
        let (made_by, source, window, tolerance, options, notes) = facts;
        let name = crs.1;
        Header {
            made_by,
            source,
            crs: Crs { definition: crs.0, name, esri_wkt: crs.2, ..Crs::default() },
            heights: Heights { crs: heights.0, unit: heights.1 },
            frame: CoordinateFrame { origin, xy_scale, z_scale, single },
            window: window.map(|(column, row, width, height)| Window { column, row, width, height }),
            tolerance,
            options,
            notes,
        }
    })
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -1e7f64..1e7,
        (-40_000i32..40_000).prop_map(|i| f64::from(i) / 4.0),
        select(vec![0.0, -0.0, 1e-300, -1e22, 0.1, 1e-7, 123_456_789.012_345_67]),
    ]
}

fn attribute(count: usize) -> impl Strategy<Value = (Number, Vec<f64>)> {
    let of = |number: Number| {
        let value = move |v: f64| match number {
            Number::U8 => v.abs() % 256.0,
            Number::F32 => f64::from(v as f32),
            Number::F64 => v,
        };
        let whole = move |v: f64| if number == Number::U8 { value(v).floor() } else { value(v) };
        vec(self::number().prop_map(whole), count).prop_map(move |values| (number, values))
    };
    prop_oneof![of(Number::U8), of(Number::F32), of(Number::F64)]
}

/// Any mesh.
pub(super) fn given() -> impl Strategy<Value = Given> {
    (3usize..40, 1usize..50, 1usize..20, 0usize..4)
        .prop_flat_map(|(vertices, triangles, batch, attributes)| {
            let corner = 0..vertices as u64;
            (
                header(),
                vec([number(), number(), number()], vertices),
                vec([corner.clone(), corner.clone(), corner], triangles),
                vec(attribute(vertices), attributes),
                vec((any::<prop::sample::Index>(), 0..3usize, any::<bool>()), 0..9),
                Just(batch),
            )
        })
        .prop_map(|(header, vertices, triangles, attributes, sides, batch)| {
            let side = |(triangle, from, is_soft): (prop::sample::Index, usize, bool)| {
                let corners: [u64; 3] = *triangle.get(&triangles);
                let line_type = if is_soft { LineType::Soft } else { LineType::Hard };
                LineEdge { ends: [corners[from], corners[(from + 1) % 3]], line_type }
            };
            let edges = sides.into_iter().map(side).collect();
            let name = |i: usize| ["red", "band_7", "_heat", "Z9"][i].to_string();
            let attributes = attributes.into_iter().enumerate();
            let attributes =
                attributes.map(|(i, (number, values))| (Channel { name: name(i), number }, values)).collect();
            Given { header, vertices, triangles, attributes, edges, batch }
        })
}
