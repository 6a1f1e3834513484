use super::*;
use crate::raster::Window;
use proptest::prelude::*;

fn window(column: usize, row: usize, width: usize, height: usize) -> Window {
    Window { column, row, width, height }
}

#[test]
fn marks_nan_and_refuses_infinite_and_misshapen() {
    let field = |v: Vec<f64>| Field::from_heights(2, 2, Heights::F64(v));
    let load = |v| field(v).expect("a shape").load(window(0, 0, 2, 2), &mut Tile::default());
    let mut tile = Tile::default();
    let hole = field(vec![-7.0, 1.0, f64::NAN, 2.0]).expect("a shape");
    hole.load(window(0, 0, 2, 2), &mut tile).expect("a hole");
    assert!(!tile.validity().is_whole() && !tile.validity().is_valid(0, 1) && tile.validity().is_valid(1, 1));
    assert_eq!((tile.at(0, 1), tile.at(0, 0), tile.at(1, 1)), (0.0, -7.0, 2.0));
    // Where it lies beside the window, the window is whole in itself only.
    hole.load(window(0, 0, 2, 1), &mut tile).expect("heights");
    assert!(!tile.validity().is_whole() && tile.validity().row(0) == [true, true]);
    field(vec![0.0; 4]).expect("a shape").load(window(0, 0, 2, 2), &mut tile).expect("heights");
    assert!(tile.validity().is_whole());
    assert!(matches!(load(vec![0.0, -f64::INFINITY, 0.0, 0.0]), Err(FieldError::NotAHeight { column: 1, row: 0, .. })));
    assert!(matches!(load(vec![0.0, 0.0, 0.0, 2e30]), Err(FieldError::NotAHeight { column: 1, row: 1, .. })));
    assert!(matches!(field(vec![0.0; 3]), Err(FieldError::Shape { found: 3, .. })));
}

proptest! {
    #[test]
    fn a_window_is_what_the_array_holds(
        width in 2usize..20, height in 2usize..20, seed in any::<u32>(), corner in any::<(u16, u16, u16, u16)>(),
    ) {
        let heights: Vec<f32> = (0..width * height).map(|i| (i as u32 ^ seed) as u16 as f32).collect();
        let field = Field::from_heights(width, height, Heights::F32(heights.clone())).unwrap();
        let (c, r) = (corner.0 as usize % width, corner.1 as usize % height);
        let w = window(c, r, 1 + corner.2 as usize % (width - c), 1 + corner.3 as usize % (height - r));
        let mut tile = Tile::default();
        field.load(w, &mut tile).unwrap();
        for row in 0..w.height {
            for column in 0..w.width {
                prop_assert_eq!(tile.at(column, row) as f32, heights[(r + row) * width + c + column]);
            }
        }
    }
}
