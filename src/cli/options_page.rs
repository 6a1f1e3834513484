//! `docs/options.md`, printed from the command line's definition and the rule book. `TERRABITE_BLESS=1 cargo test
//! options_page` writes it.

use std::fmt::Write;
use std::path::Path;

use clap::builder::StyledStr;
use clap::{Arg, ArgAction, Command};

use super::combinations::table;

const HEAD: &str = "\
# Options

Printed from the program: `TERRABITE_BLESS=1 cargo test options_page` writes this page, and a test keeps it true. The
same is said by `terrabite COMMAND --help`. [What cannot be combined](#what-cannot-be-combined) is at the end.
";

const COMBINATIONS: &str = "
## What cannot be combined

Each of these is refused with exit code 2 before anything is read, or as soon as the raster's type is known where that
decides. When several rules are broken, all are reported at once, and doing what they say together leads to no further
refusal. Rules about samples and attributes hold for `verify`, `info` and `preview`, too, as far as they have the options.
";

#[test]
fn options_page() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/options.md");
    let page = page();
    if std::env::var_os("TERRABITE_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(&path, &page).expect("written");
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = page.lines().zip(there.lines()).find(|(new, old)| new != old);
    assert!(page == there, "TERRABITE_BLESS=1 cargo test options_page writes docs/options.md; {differs:?}");
}

#[test]
fn words_that_markdown_would_take_for_its_own_are_escaped() {
    assert_eq!(escape("a|b * c_d <E> [default: 1]"), "a\\|b \\* c\\_d \\<E> \\[default: 1]");
    assert_eq!(escape("see --quality, or `a|b_c`."), "see `--quality`, or `a\\|b_c`.");
    assert_eq!(escape("(--polish-…) --a"), "(`--polish-…`) `--a`");
}

fn page() -> String {
    let mut root = super::command();
    root.build();
    let mut page = HEAD.to_string();
    for command in root.get_subcommands() {
        describe(command, &mut page);
    }
    page.push_str(COMBINATIONS);
    page.push_str("\n| option | | other options | why | what to do instead |\n|---|---|---|---|---|\n");
    for row in table() {
        let cells: Vec<String> = row.iter().map(|cell| escape(cell)).collect();
        writeln!(page, "| {} |", cells.join(" | ")).expect("a string");
    }
    page
}

fn describe(command: &Command, page: &mut String) {
    let about = command.get_long_about().or(command.get_about()).map(StyledStr::to_string).unwrap_or_default();
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ").trim();
    writeln!(page, "\n## `{}`\n\n{}\n\n    {usage}", command.get_bin_name().unwrap_or_default(), paragraphs(&about))
        .expect("a string");
    let mut headings: Vec<&str> = Vec::new();
    let shown = || command.get_arguments().filter(|a| !a.is_hide_set() && !is_help(a));
    for argument in shown() {
        let heading = heading(argument);
        if !headings.contains(&heading) {
            headings.push(heading);
        }
    }
    for of in headings {
        writeln!(page, "\n### {}\n\n| | what it does | default |\n|---|---|---|", escape(of)).expect("a string");
        for argument in shown().filter(|a| heading(a) == of) {
            let cells = [name(argument), meaning(command, argument), default(argument)];
            writeln!(page, "| {} |", cells.join(" | ")).expect("a string");
        }
    }
}

fn is_help(argument: &Arg) -> bool {
    matches!(argument.get_action(), ArgAction::Help | ArgAction::HelpShort | ArgAction::HelpLong | ArgAction::Version)
}

fn heading(argument: &Arg) -> &str {
    match argument.get_help_heading() {
        Some(heading) => heading,
        None if argument.is_positional() => "Arguments",
        None => "Options",
    }
}

/// The option, its short form, and the name of its value, as code.
fn name(argument: &Arg) -> String {
    let values: Vec<String> = match argument.get_action().takes_values() {
        true => argument.get_value_names().unwrap_or_default().iter().map(|v| v.to_string()).collect(),
        false => Vec::new(),
    };
    let long = argument.get_long().map(|long| format!("--{long}"));
    let words: Vec<String> = long.into_iter().chain(values).collect();
    let short = argument.get_short().map(|short| format!(", `-{short}`")).unwrap_or_default();
    format!("`{}`{short}", words.join(" ").replace('|', "\\|"))
}

fn meaning(command: &Command, argument: &Arg) -> String {
    let help = argument.get_long_help().or(argument.get_help()).map(StyledStr::to_string).unwrap_or_default();
    let (help, _) = split_default(&help);
    let mut cell = escape(&help.split_whitespace().collect::<Vec<_>>().join(" "));
    let is_switch = !argument.get_action().takes_values();
    for value in argument.get_possible_values().iter().filter(|v| !v.is_hide_set() && !is_switch) {
        let help = value.get_help().map(|help| format!(": {}", escape(&help.to_string()))).unwrap_or_default();
        write!(cell, "<br>• `{}`{help}", value.get_name()).expect("a string");
    }
    let others: Vec<String> = command
        .get_arg_conflicts_with(argument)
        .into_iter()
        .filter_map(|other| other.get_long())
        .map(|long| format!("`--{long}`"))
        .collect();
    if !others.is_empty() {
        write!(cell, "<br>Not together with {}.", others.join(", ")).expect("a string");
    }
    cell
}

/// What stands in brackets at the end, where the default depends on other options.
fn split_default(help: &str) -> (&str, Option<&str>) {
    match help.split_once(" [default: ").filter(|(_, rest)| rest.ends_with(']')) {
        Some((help, default)) => (help, Some(&default[..default.len() - 1])),
        None => (help, None),
    }
}

fn default(argument: &Arg) -> String {
    let help = argument.get_help().map(StyledStr::to_string).unwrap_or_default();
    if let (_, Some(said)) = split_default(&help) {
        return escape(&said.split_whitespace().collect::<Vec<_>>().join(" "));
    }
    let values: Vec<String> = match argument.get_action().takes_values() {
        true => argument.get_default_values().iter().map(|v| format!("`{}`", v.to_string_lossy())).collect(),
        false => Vec::new(),
    };
    values.join(" ")
}

/// Paragraphs, each a line.
fn paragraphs(text: &str) -> String {
    text.split("\n\n")
        .map(|p| escape(&p.split_whitespace().collect::<Vec<_>>().join(" ")))
        .collect::<Vec<_>>()
        .join("\n\n")
}

/// Text as Markdown shows it, in a table or not: options become code, and what is code stays so.
fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for (i, part) in text.split('`').enumerate() {
        if i % 2 == 1 {
            write!(escaped, "`{}`", part.replace('|', "\\|")).expect("a string");
            continue;
        }
        let mut rest = part;
        while let Some(at) = rest.find("--") {
            let is_begin = !rest[..at].ends_with(|c: char| c.is_alphanumeric() || c == '-');
            let length = rest[at..].find(|c: char| !(c.is_ascii_alphanumeric() || c == '-' || c == '…'));
            let option = &rest[at..at + length.unwrap_or(rest.len() - at)];
            escaped.push_str(&escape_plain(&rest[..at]));
            if is_begin && option.len() > 2 {
                write!(escaped, "`{option}`").expect("a string");
            } else {
                escaped.push_str(&escape_plain(option));
            }
            rest = &rest[at + option.len()..];
        }
        escaped.push_str(&escape_plain(rest));
    }
    escaped
}

fn escape_plain(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        if matches!(c, '|' | '*' | '_' | '<' | '[' | '\\') {
            escaped.push('\\');
        }
        escaped.push(c);
    }
    escaped
}
