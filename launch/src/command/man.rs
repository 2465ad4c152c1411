//! `cosplat man`: the manual pages.

use clap::{Args, CommandFactory as _};
use clap_mangen::Man;

use crate::cli::Cli;
use crate::exit::{Code, Error, Problem};
use crate::render::print;

const EXAMPLES: &str = "\
Examples:
  cosplat man > ~/.local/share/man/man1/cosplat.1
  cosplat man splat convert > ~/.local/share/man/man1/cosplat-splat-convert.1";

/// `cosplat man`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ManArgs {
    /// Command to describe, as `splat convert`; without one the whole program
    #[arg(value_name = "COMMAND")]
    pub(crate) command: Vec<String>,
}

/// Prints a manual page.
///
/// # Errors
/// There is no such command, or standard output cannot be written.
pub(crate) fn man(args: &ManArgs) -> Result<Code, Error> {
    print(&text(&args.command)?)?;
    Ok(Code::Ok)
}

/// The page in the language of `man`.
fn text(path: &[String]) -> Result<String, Error> {
    let mut whole = Cli::command();
    // Commands below another one learn their full names here.
    whole.build();
    let mut command = &whole;
    for name in path {
        command = command.find_subcommand(name).ok_or_else(|| unknown(command, name))?;
    }
    let name = command.get_display_name().unwrap_or("cosplat").to_owned();
    let mut page = Vec::new();
    let failed = |e| Error::new(Code::Environment, Problem::new("The manual page cannot be made").because(e));
    Man::new(command.clone()).title(name).render(&mut page).map_err(failed)?;
    Ok(String::from_utf8_lossy(&page).into_owned())
}

fn unknown(parent: &clap::Command, name: &str) -> Error {
    let known: Vec<&str> = parent.get_subcommands().map(clap::Command::get_name).collect();
    let mut problem =
        Problem::new(format!("`{}` has no command `{name}`", parent.get_display_name().unwrap_or("cosplat")));
    problem.hint = (!known.is_empty()).then(|| format!("its commands are {}", known.join(", ")));
    Error::new(Code::Usage, problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_its_own_name() {
        let top = text(&[]).unwrap();
        assert!(top.starts_with(".ie") && top.contains(".TH cosplat 1"), "{top}");
        let deep = text(&["splat".into(), "convert".into()]).unwrap();
        assert!(deep.contains("cosplat\\-splat\\-convert") || deep.contains("cosplat-splat-convert"), "{deep}");
    }

    #[test]
    fn a_command_that_is_not_there_is_refused_with_those_that_are() {
        let error = text(&["fly".into()]).unwrap_err();
        assert_eq!(error.code, Code::Usage);
        assert!(error.problems[0].hint.as_deref().unwrap_or_default().contains("run"), "{error:?}");
    }
}
