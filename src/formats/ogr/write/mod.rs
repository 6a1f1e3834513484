//! OGR's writer.

mod driver;
mod flat;
mod layer;
mod link;
mod sink;
mod values;
mod wkb;

pub use driver::named;
pub use sink::OgrSink;
