//! The `terrabite` command.
fn main() {}
