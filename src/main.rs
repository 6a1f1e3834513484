//! The `terrabite` command: everything it does is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    terrabite::cli::main()
}
