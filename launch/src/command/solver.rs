//! `cosplat solver`: be a solver process of a run.

use std::process::ExitCode;

use crate::cli::SolverArgs;
use crate::exit::{Code, Error, Problem};
use crate::hint::{list, near_miss};
use crate::plugins::built_in;
use crate::render::{Paint, error, talk};

/// Serves a built-in plugin until its run ends, or describes it.
pub(crate) fn solver(args: &SolverArgs) -> ExitCode {
    let Some(mut plugin) = built_in::make(&args.name) else {
        let problem = Problem::new(format!("There is no built-in solver `{}`", args.name))
            .because(format!("there are {}", list(built_in::names())));
        let problem = match near_miss(&args.name, built_in::names()) {
            Some(near) => problem.hint(format!("did you mean `{near}`?")),
            None => {
                problem.hint("`cosplat plugins` lists all that is found; other plugins are started by their own name")
            }
        };
        talk(&error(Paint::stderr(), &Error::new(Code::Usage, problem)));
        return Code::Usage.into();
    };
    if args.describe { cosplat_bus::describe(plugin.as_ref()) } else { cosplat_bus::run_plugin(plugin.as_mut()) }
}
