//! The `terrabite` command.
fn main() -> std::process::ExitCode {
    terrabite::cli::main()
}
