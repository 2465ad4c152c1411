//! `cosplat`: checks scenes, runs them as one process per solver, and reports what the result is worth.

mod cli;
mod command;
mod estimate;
mod exit;
mod folder;
mod frames;
mod gallery;
mod geometry;
mod hint;
mod page;
mod plugins;
mod prepare;
mod progress;
mod render;
mod report;
mod rigidify;
mod scene_place;
mod scene_source;
mod stiffness;
mod study;
mod supervise;
mod verdict;
mod viewer;

use std::process::ExitCode;

use clap::Parser as _;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use cli::{Cli, Command, Format, RunArgs};
use exit::{Code, Error, Problem};
use render::Paint;
use supervise::signals::Signals;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    match cli.command.unwrap_or_else(|| Command::Run(RunArgs::default())) {
        Command::Solver(args) => command::solver::solver(&args),
        Command::Run(args) => finish(args.format, supervised(async |s| command::run::run(&args, s).await)),
        Command::Check(args) => finish(args.format, supervised(async |s| command::check::check(&args, s).await)),
        Command::List(args) => finish(args.format, command::list::list(&args)),
        Command::New(args) => finish(args.format, command::new::new(&args)),
        Command::Splat(args) => finish(args.format(), command::splat::splat(&args)),
        Command::Doctor(args) => finish(args.format, command::doctor::doctor(&args)),
        Command::Report(args) => finish(args.format, command::report::report(&args)),
        Command::Study(args) => finish(args.format(), supervised(async |s| command::study::study(&args, s).await)),
        Command::Man(args) => finish(Format::Human, command::man::man(&args)),
        Command::Completions(args) => finish(Format::Human, command::completions::completions(&args)),
        Command::Plugins(args) => finish(args.format, supervised(async |s| command::plugins::plugins(&args, s).await)),
    }
}

/// Runs a command on this thread, which lives as long as the program: processes end with the thread that started them.
fn supervised(command: impl AsyncFnOnce(&mut Signals) -> Result<Code, Error>) -> Result<Code, Error> {
    let cannot = |e: std::io::Error| {
        Error::new(Code::Environment, Problem::new("The system refuses what a supervisor needs").because(e))
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(cannot)?;
    runtime.block_on(async {
        let mut signals = Signals::take().map_err(cannot)?;
        command(&mut signals).await
    })
}

/// Reports an error, in both forms where both are wanted.
fn finish(format: Format, result: Result<Code, Error>) -> ExitCode {
    let error = match result {
        Ok(code) => return code.into(),
        Err(error) => error,
    };
    render::talk(&render::error(Paint::stderr(), &error));
    if format == Format::Json {
        let text = serde_json::json!({
            "status": "failed",
            "exit_code": error.code as u8,
            "problems": error.problems,
        });
        // Nothing is left to say it with if this fails too.
        let _ = render::print(&format!("{text:#}\n"));
    }
    error.code.into()
}

/// What clap has to say, with a hint where somebody gave a scene in place of a command.
fn usage(error: &clap::Error) -> ExitCode {
    // Nothing is left to say it with if this fails.
    let _ = error.print();
    if error.kind() == ErrorKind::InvalidSubcommand
        && let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
        && scene_source::looks_like_scene(word)
    {
        render::talk(&format!("\n{} to run a scene, write `cosplat run {word}`", Paint::stderr().cyan("hint:")));
    }
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(Code::Usage as u8))
}
