//! The verifier against naive oracles, and against meshes that are broken on purpose.

mod broken;
mod oracle;
mod rasters;
mod scene;
mod sizes;
