//! `cosplat completions`: what a shell needs to complete commands and options.

use clap::{Args, CommandFactory as _};
use clap_complete::{Shell, generate};

use crate::cli::Cli;
use crate::exit::{Code, Error};
use crate::render::print;

const EXAMPLES: &str = "\
Examples:
  cosplat completions bash > ~/.local/share/bash-completion/completions/cosplat
  cosplat completions zsh > ~/.zfunc/_cosplat   in a folder of `$fpath`
  cosplat completions fish > ~/.config/fish/completions/cosplat.fish";

/// `cosplat completions`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct CompletionsArgs {
    /// Shell to write for
    #[arg(value_name = "SHELL", value_enum)]
    pub(crate) shell: Shell,
}

/// Prints the completions of a shell.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<Code, Error> {
    print(&text(args.shell))?;
    Ok(Code::Ok)
}

fn text(shell: Shell) -> String {
    let mut bytes = Vec::new();
    generate(shell, &mut Cli::command(), "cosplat", &mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shell_learns_the_commands() {
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish, Shell::Elvish, Shell::PowerShell] {
            let text = text(shell);
            assert!(text.contains("check") && text.contains("plugins"), "{shell}: {text}");
        }
    }
}
