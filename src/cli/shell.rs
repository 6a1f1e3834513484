//! `completions` and `man`: what shells and readers of manuals need, from the definition of the command line.

use std::process::ExitCode;

use super::{Failure, print};

/// Print completions for a shell
///
/// For bash: terrabite completions bash > ~/.local/share/bash-completion/completions/terrabite
#[derive(Debug, clap::Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// Print a page of the manual, in the form that man reads
///
/// terrabite man simplify > terrabite-simplify.1; man -l terrabite-simplify.1 shows it
#[derive(Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// The command; without one, the page is that of terrabite itself
    command: Option<String>,
}

/// Does `completions`.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut super::command(), "terrabite", &mut text);
    printed(text)
}

/// Does `man`.
pub(crate) fn man(args: &ManArgs) -> Result<ExitCode, Failure> {
    let mut root = super::command();
    root.build();
    let page = match &args.command {
        None => root,
        Some(name) => {
            let names = || root.get_subcommands().map(clap::Command::get_name).collect::<Vec<_>>().join(", ");
            let command = root.find_subcommand(name);
            let unknown = || Failure::usage(format!("{name}: expected a command ({})", names()));
            let title = format!("terrabite-{name}");
            command.ok_or_else(unknown)?.clone().name(title)
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text).map_err(Failure::new)?;
    printed(text)
}

fn printed(text: Vec<u8>) -> Result<ExitCode, Failure> {
    print::report(String::from_utf8_lossy(&text).trim_end())?;
    Ok(ExitCode::SUCCESS)
}
