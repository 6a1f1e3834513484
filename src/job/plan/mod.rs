//! What a run will need: memory, disk, and how many triangles it will come to.

mod density;
mod disk;
mod estimate;
mod memory;
mod stages;
#[cfg(test)]
mod tests;

pub use density::{Expected, probe, probe_field};
pub use disk::{DiskTooSmall, DiskUse, check_disk};
pub use estimate::{DENSEST, Estimate, SAMPLES_PER_TRIANGLE, estimate};
pub use memory::{BudgetTooSmall, Load, Plan, default_budget};
