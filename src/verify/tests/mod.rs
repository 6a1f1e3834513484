//! The verifier against naive oracles, and against meshes that are broken on purpose.

mod broken;
mod ground;
mod holes;
mod observed;
mod oracle;
mod rasters;
mod scene;
mod sizes;
mod strays;
mod threads;
mod trim;
mod trim_oracle;

/// Architecture invariant: a verdict is worth something because the verifier shares no code with what it judges.
#[test]
fn nothing_here_imports_an_engine() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/verify");
    let files =
        [folder.clone(), folder.join("lines")].into_iter().flat_map(|folder| std::fs::read_dir(folder).unwrap());
    for path in files.map(|entry| entry.unwrap().path()) {
        if path.is_dir() || path.ends_with("lines/tests.rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        // Its own tests may use what they like.
        let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        for import in text.split("crate::").skip(1) {
            let mut names = import
                .split("::")
                .map(|name| name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>());
            let (first, second) = (names.next().unwrap(), names.next().unwrap_or_default());
            // What marks mean to the engines is reckoned in `stored`; of a job only the rule book is asked.
            let is_data = match first.as_str() {
                "base" => second != "stored",
                "job" => second == "rules",
                module => ["formats", "verify"].contains(&module),
            };
            assert!(is_data, "{}: {first}::{second}", path.display());
        }
    }
}
