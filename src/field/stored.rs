use crate::exact::MAX_HEIGHT;
use crate::raster::{Nodata, Scaling};

/// What a stored type must tell to become a height.
pub(super) trait Stored: bytemuck::Pod + PartialEq {
    fn to_f64(self) -> f64;
    fn to_i128(self) -> i128;
    /// Whether a double holds it exactly.
    fn exact(self) -> bool;
    /// The nodata value in this type, if it has one there.
    fn nodata(nodata: Nodata) -> Option<Self>;
    /// Whether there are values that are no numbers.
    const HAS_NAN: bool;
}

macro_rules! stored {
    ($($t:ty: $exact:expr, $nodata:expr);* $(;)?) => {$(
        impl Stored for $t {
            const HAS_NAN: bool = <$t>::MAX as f64 > u64::MAX as f64;
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn to_i128(self) -> i128 {
                self as i128
            }
            #[inline(always)]
            fn exact(self) -> bool {
                const EXACT: fn($t) -> bool = $exact;
                EXACT(self)
            }
            fn nodata(nodata: Nodata) -> Option<Self> {
                const NODATA: fn(f64) -> Option<$t> = $nodata;
                match nodata {
                    Nodata::None => None,
                    Nodata::Real(v) => NODATA(v),
                    Nodata::I64(v) => Some(v as $t).filter(|n| *n as i128 == i128::from(v)),
                    Nodata::U64(v) => Some(v as $t).filter(|n| *n as i128 == i128::from(v)),
                }
            }
        }
    )*};
}
// A nodata tag beyond an integer type's range, or between its values, marks no sample; to a float type it is rounded.
stored!(
    u8: |_| true, |v| Some(v as u8).filter(|n| f64::from(*n) == v);
    i8: |_| true, |v| Some(v as i8).filter(|n| f64::from(*n) == v);
    u16: |_| true, |v| Some(v as u16).filter(|n| f64::from(*n) == v);
    i16: |_| true, |v| Some(v as i16).filter(|n| f64::from(*n) == v);
    u32: |_| true, |v| Some(v as u32).filter(|n| f64::from(*n) == v);
    i32: |_| true, |v| Some(v as i32).filter(|n| f64::from(*n) == v);
    u64: |v| v <= 1 << 53, |v| Some(v as u64).filter(|n| *n as f64 == v);
    i64: |v| v.unsigned_abs() <= 1 << 53, |v| Some(v as i64).filter(|n| *n as f64 == v);
    f32: |_| true, |v| Some(v as f32);
    f64: |_| true, Some;
);

/// The type heights are kept in.
pub(super) trait Height: Copy {
    const ZERO: Self;
    fn of<T: Stored>(stored: T, scaling: Option<Scaling>) -> Self;
    fn usable(self) -> bool;
}
impl Height for f32 {
    const ZERO: f32 = 0.0;
    #[inline(always)]
    fn of<T: Stored>(stored: T, _: Option<Scaling>) -> f32 {
        stored.to_f64() as f32
    }
    #[inline(always)]
    fn usable(self) -> bool {
        // Rounded to single precision the limit lies beyond itself.
        self.abs() < MAX_HEIGHT as f32
    }
}
impl Height for f64 {
    const ZERO: f64 = 0.0;
    #[inline(always)]
    fn of<T: Stored>(stored: T, scaling: Option<Scaling>) -> f64 {
        scaling.map_or(stored.to_f64(), |s| s.height(stored.to_f64()))
    }
    #[inline(always)]
    fn usable(self) -> bool {
        self.abs() <= MAX_HEIGHT
    }
}
