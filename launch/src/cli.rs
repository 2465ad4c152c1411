//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::command::completions::CompletionsArgs;
use crate::command::doctor::DoctorArgs;
use crate::command::list::ListArgs;
use crate::command::man::ManArgs;
use crate::command::new::NewArgs;
use crate::command::report::ReportArgs;
use crate::command::splat::SplatArgs;
use crate::command::study::StudyArgs;
use crate::viewer::{Place, parse_place};

/// Exit codes as the help lists them.
pub(crate) const EXIT_CODES: &str = "\
Exit codes:
    0  everything went as asked
    2  the command line makes no sense
    3  the scene, or a file named by it or by the command line, cannot be used
    4  the physics left the range in which a result means anything
    5  a solver process died, fell silent or broke the protocol, or the bus failed
    6  this machine lacks something: a plugin, a permission, space
    7  the run ended, but a verdict says that its result is not to be trusted
  130  stopped by the user";

const EXAMPLES: &str = "\
Examples:
  cosplat                                       run the default scene
  cosplat run two-tops                          run another built-in scene
  cosplat check my-scene.toml                   say what a run would do, without running
  cosplat run my-scene.toml --set clock.window=0.005
  cosplat report out                            put all runs in `out` on one page
  cosplat new plant --splat plant.ply           write a scene around a capture
  cosplat splat info plant.ply                  say what a capture holds, and which way is up
  cosplat doctor                                say what this machine lacks";

const INSIDE: &str = "\
Each solver of a run is a process of its own. For the built-in plugins it is this program again, started as `cosplat \
solver NAME`; `cosplat solver --help` says more.";

const RUN_EXAMPLES: &str = "\
Examples:
  cosplat run                                   the default scene, into `out/plant-and-rock`
  cosplat run scene.toml --out out/a --quiet    nothing on the terminal but errors
  cosplat run oscillator --set clock.window=0.005 --set clock.duration=2
  cosplat run two-tops --solver top=rigid        another plugin for a body
  cosplat run my-scene.toml --checkpoint-every 0.5
  cosplat run --resume out/oscillator           goes on where that was stopped or killed
  cosplat run my-scene.toml --live              watch it in a rerun viewer
  cosplat run my-scene.toml --serve             watch it in a browser on this machine
  cosplat run my-scene.toml --set output.video=true
  cosplat run oscillator --format json | jq .state_hash";

const CHECK_EXAMPLES: &str = "\
Examples:
  cosplat check my-scene.toml
  cosplat check oscillator --set clock.window=0.5
  cosplat check my-scene.toml --format json | jq .window_s";

const SOLVER_EXAMPLES: &str = "\
Examples:
  cosplat solver oscillator --describe | jq .materials
  cosplat solver rigid-lite < ticket.json       what `cosplat run` does for each process";

/// Makes captured 3D Gaussian Splatting scenes physically interact.
///
/// One command checks a scene, starts one process per solver, lets them advance in lock-step and leaves a folder with
/// the result and its error budgets. Without a command it runs the default scene.
#[derive(Debug, Parser)]
#[command(name = "cosplat", version, max_term_width = 100, after_help = EXAMPLES)]
#[command(after_long_help = long_after_help())]
pub(crate) struct Cli {
    /// What to do; without it the default scene is run.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

fn long_after_help() -> String {
    format!("{EXAMPLES}\n\n{INSIDE}\n\n{EXIT_CODES}")
}

/// Commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a scene
    Run(RunArgs),
    /// Say what a run of a scene would do, without running it
    ///
    /// Plugins are asked what they can do, so programs that the scene names as `command` are started with `--describe`.
    Check(CheckArgs),
    /// List the scenes inside this program
    List(ListArgs),
    /// Write a scene to begin with
    New(NewArgs),
    /// Put runs on one page, and compare those of one scene
    Report(ReportArgs),
    /// Measure error against run time: run a scene with several values of what may be varied, and compare
    Study(StudyArgs),
    /// Look at, convert or draw a splat file
    Splat(SplatArgs),
    /// List the solver plugins found on this machine
    Plugins(PluginsArgs),
    /// Say what this machine lacks, and the command that mends it
    Doctor(DoctorArgs),
    /// Print what a shell needs to complete commands and options
    Completions(CompletionsArgs),
    /// Print the manual page of a command
    Man(ManArgs),
    /// Be a solver process of a run
    ///
    /// `cosplat run` starts itself like this, once per process. The ticket that lets it join the run is read from
    /// standard input as one line; when standard input closes, it ends.
    #[command(hide = true, after_help = SOLVER_EXAMPLES)]
    Solver(SolverArgs),
}

/// Which scene, and what to change in it.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct SceneArgs {
    /// Change a value of the scene, as `clock.window=0.005`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = parse_override)]
    pub(crate) set: Vec<String>,
    /// Use another plugin for a body, a solver process, or all bodies of a material
    #[arg(long = "solver", value_name = "KIND_OR_BODY=PLUGIN", value_parser = parse_pair)]
    pub(crate) solver: Vec<(String, String)>,
    /// Threads for the solvers of one level; never changes a result
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Whether frames are shown while the run goes on; `run` says so.
    #[arg(skip)]
    pub(crate) live: bool,
}

/// `cosplat run`.
#[derive(Clone, Debug, Default, Args)]
#[command(after_help = RUN_EXAMPLES)]
pub(crate) struct RunArgs {
    /// Scene file, or name of a built-in scene [default: plant-and-rock]
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<String>,
    #[command(flatten)]
    pub(crate) changes: SceneArgs,
    /// Run folder [default: out/NAME-OF-SCENE]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Keep a checkpoint every so many seconds of simulated time, and one when the run is stopped
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub(crate) checkpoint_every: Option<f64>,
    /// Go on with a run that was stopped or killed, from the newest checkpoint in its folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["scene", "set", "solver", "out"])]
    pub(crate) resume: Option<PathBuf>,
    /// Show the run in a rerun viewer while it goes on: in the one that listens at ADDR on this machine, or in a window
    #[arg(long, value_name = "ADDR", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "window", value_parser = parse_place)]
    pub(crate) live: Option<Place>,
    /// Show the run to a browser on this machine while it goes on
    #[arg(long, conflicts_with = "live")]
    pub(crate) serve: bool,
    /// Form of the summary on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Say nothing but errors; `--format json` still prints its summary
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Be killed when the program that started this one ends
    #[arg(long, hide = true)]
    pub(crate) ends_with_parent: bool,
}

/// `cosplat check`.
#[derive(Clone, Debug, Args)]
#[command(after_help = CHECK_EXAMPLES)]
pub(crate) struct CheckArgs {
    /// Scene file, or name of a built-in scene
    #[arg(value_name = "SCENE")]
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) changes: SceneArgs,
    /// Draw each capture into this folder: what is kept, what is dropped, and the particles in a cut
    #[arg(long, value_name = "DIR")]
    pub(crate) draw: Option<PathBuf>,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// `cosplat plugins`.
#[derive(Clone, Debug, Args)]
pub(crate) struct PluginsArgs {
    /// Form of the list on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// `cosplat solver`.
#[derive(Clone, Debug, Args)]
pub(crate) struct SolverArgs {
    /// Built-in plugin
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// Print what the plugin is and can do, as JSON, and end
    #[arg(long)]
    pub(crate) describe: bool,
}

/// Form of what goes to standard output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For people.
    #[default]
    Human,
    /// For programs.
    Json,
}

/// Checks the shape of an override; what it means is the scene reader's business.
fn parse_override(text: &str) -> Result<String, String> {
    parse_pair(text).map(|(key, value)| format!("{key}={value}"))
}

/// A time that is longer than nothing.
pub(crate) fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds > 0.0 => Ok(seconds),
        _ => Err("expected a positive number of seconds, as in `0.5`".into()),
    }
}

/// Splits `key=value` at the first `=`.
fn parse_pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected a name, `=` and a value, as in `clock.window=0.005`".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn without_arguments_the_default_scene_is_meant() {
        assert!(Cli::try_parse_from(["cosplat"]).is_ok_and(|c| c.command.is_none()));
    }

    #[test]
    fn a_resumed_run_is_the_one_that_was_begun() {
        assert!(Cli::try_parse_from(["cosplat", "run", "--resume", "out/x", "--threads", "1"]).is_ok());
        for more in [["oscillator", "-q"], ["--set", "a=b"], ["--out", "out/y"], ["--checkpoint-every", "-1"]] {
            let words = ["cosplat", "run", "--resume", "out/x"].into_iter().chain(more);
            assert!(Cli::try_parse_from(words).is_err(), "{more:?}");
        }
    }

    #[test]
    fn overrides_are_split_at_the_first_equals_sign() {
        assert_eq!(parse_pair("a.b = c=d"), Ok(("a.b".into(), "c=d".into())));
        assert!(parse_pair("a").is_err());
        assert!(parse_pair("=3").is_err());
        assert!(parse_pair("a=").is_err());
    }

    #[test]
    fn the_short_help_does_not_show_what_people_do_not_call() {
        let help = Cli::command().render_help().to_string();
        assert!(!help.contains("solver NAME") && !help.contains("Be a solver"), "{help}");
        assert!(help.contains("Examples:"), "{help}");
    }
}
