//! What a run will need: memory, disk, and how many triangles it will come to.

mod density;
mod disk;
mod estimate;
mod holdings;
mod machine;
mod memory;
mod stages;
#[cfg(test)]
mod tests;

pub use density::{Expected, probe, probe_field};
pub use disk::{DiskTooSmall, DiskUse, check_disk};
pub use estimate::{DENSEST, Estimate, SAMPLES_PER_TRIANGLE, estimate};
pub use holdings::{BudgetTooSmall, Fitted};
#[cfg(feature = "gdal")]
pub(crate) use holdings::{Holdings, mebibytes};
pub(crate) use machine::all_cores;
pub use machine::{default_budget, peak_memory};
pub use memory::{Load, Plan};
#[cfg(feature = "gdal")]
pub(crate) use stages::POLISHING;
