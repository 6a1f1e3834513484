//! The verifier against naive oracles, and against meshes that are broken on purpose.

mod broken;
mod ground;
mod holes;
mod oracle;
mod rasters;
mod scene;
mod sizes;
mod trim;
mod trim_oracle;

/// Architecture invariant: a verdict is worth something because the verifier shares no code with what it judges.
#[test]
fn nothing_here_imports_an_engine() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/verify");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for import in text.split("crate::").skip(1) {
            let module = import.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap();
            assert!(
                ["control", "decimal", "ply", "raster", "verify"].contains(&module),
                "{}: {module}",
                path.display()
            );
        }
    }
}
