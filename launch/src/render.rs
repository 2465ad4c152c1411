//! How findings and errors look on a terminal.

use std::io::{IsTerminal as _, Write as _};

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet, normalize_untrusted_str};
use cosplat_core::scene::{Diagnostic, Severity};

use crate::exit::{Code, Error, Problem};

/// Problems shown to people; a file with more is hardly a scene with mistakes. A program is given all of them.
const MOST_PROBLEMS: usize = 50;

/// Colours, where they are wanted. Everything must be understood without them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    on: bool,
}

impl Paint {
    /// Colours for standard error: on a terminal that has them, unless `NO_COLOR` is set.
    pub(crate) fn stderr() -> Self {
        Self { on: std::io::stderr().is_terminal() && colour_wanted() }
    }

    /// Colours for standard output, by the same rule.
    pub(crate) fn stdout() -> Self {
        Self { on: std::io::stdout().is_terminal() && colour_wanted() }
    }

    /// No colours.
    #[cfg(test)]
    pub(crate) fn off() -> Self {
        Self { on: false }
    }

    fn wrap(self, code: &str, text: &str) -> String {
        if self.on { format!("\x1b[{code}m{text}\x1b[0m") } else { text.into() }
    }

    /// Success.
    pub(crate) fn good(self, text: &str) -> String {
        self.wrap("32", text)
    }

    /// Failure.
    pub(crate) fn bad(self, text: &str) -> String {
        self.wrap("1;31", text)
    }

    /// Something to look at.
    pub(crate) fn warn(self, text: &str) -> String {
        self.wrap("33", text)
    }

    /// Hints, paths and literals.
    pub(crate) fn cyan(self, text: &str) -> String {
        self.wrap("36", text)
    }

    /// Labels.
    pub(crate) fn bold(self, text: &str) -> String {
        self.wrap("1", text)
    }

    fn renderer(self) -> Renderer {
        let renderer = if self.on { Renderer::styled() } else { Renderer::plain() };
        renderer.decor_style(DecorStyle::Ascii)
    }
}

/// <https://no-color.org>: any value that is not empty turns colours off.
fn colour_wanted() -> bool {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty());
    set("NO_COLOR").is_none() && set("TERM").is_none_or(|t| t != "dumb")
}

/// A finding about a scene file, with the lines it is about.
pub(crate) fn diagnostic(paint: Paint, file: &str, source: &str, found: &Diagnostic) -> String {
    let level = match found.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let message = normalize_untrusted_str(&found.message);
    let mut group: Group<'_> = Group::with_title(level.primary_title(message));
    group = if let Some(span) = &found.span {
        let start = source.floor_char_boundary(span.start);
        let end = source.floor_char_boundary(span.end).max(start);
        group.element(Snippet::source(source).path(file).annotation(AnnotationKind::Primary.span(start..end)))
    } else if found.path.is_empty() {
        group.element(Origin::path(file))
    } else {
        group.element(Origin::path(format!("{file}, `{}`", found.path)))
    };
    if let Some(help) = &found.help {
        group = group.element(Level::HELP.with_name("hint").message(normalize_untrusted_str(help)));
    }
    paint.renderer().render(&[group])
}

/// Turns a finding into a problem that can be listed with others.
pub(crate) fn problem_of(paint: Paint, file: &str, source: &str, found: &Diagnostic) -> Problem {
    let place = found.span.as_ref().map(|span| line_and_column(source, span.start));
    Problem {
        message: found.message.clone(),
        file: Some(file.into()),
        line: place.map(|p| p.0),
        column: place.map(|p| p.1),
        field: Some(found.path.clone()).filter(|p| !p.is_empty()),
        details: Vec::new(),
        hint: found.help.clone(),
        drawn: Some(diagnostic(paint, file, source, found)),
    }
}

/// Line and column of a byte, both from 1, the column in characters.
fn line_and_column(source: &str, byte: usize) -> (usize, usize) {
    let before = &source[..source.floor_char_boundary(byte)];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// An error in full: every problem up to [`MOST_PROBLEMS`], each with its place, its reasons and its hint.
pub(crate) fn error(paint: Paint, error: &Error) -> String {
    let (count, shown) = (error.problems.len(), error.problems.len().min(MOST_PROBLEMS));
    let mut parts: Vec<String> = error.problems[..shown].iter().map(|p| problem(paint, p)).collect();
    if count > shown {
        parts.push(format!("{count} problems, of which the first {shown} are shown: is this the right file?\n"));
    } else if count > 1 {
        parts.push(format!("{count} problems\n"));
    }
    parts.join("\n")
}

/// One problem.
fn problem(paint: Paint, problem: &Problem) -> String {
    if let Some(drawn) = &problem.drawn {
        return format!("{}\n", drawn.trim_end());
    }
    let message = format!("{} {}\n", paint.bad("error:"), printable(&problem.message));
    let details = problem.details.iter().map(|d| format!("  {}\n", printable(d)));
    let hint = problem.hint.iter().map(|h| format!("\n{} {}\n", paint.cyan("hint:"), printable(h)));
    [message].into_iter().chain(details).chain(hint).collect()
}

/// Rows as columns; the first row is the head.
pub(crate) fn table(paint: Paint, rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for (i, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        let line = cells.join("  ");
        let line = line.trim_end();
        text.push_str(&if i == 0 { paint.bold(line) } else { line.to_owned() });
        text.push('\n');
    }
    text
}

/// Prints a result on standard output. A reader that has seen enough and closed the pipe is no error.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(Code::Environment, Problem::new("Cannot write to standard output").because(e)))
        }
        _ => Ok(()),
    }
}

/// A result as JSON, with its fields in the order of their documentation.
///
/// # Errors
/// It has no JSON form.
pub(crate) fn json(value: &impl serde::Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|e| Error::new(Code::Environment, Problem::new("The result has no JSON form").because(e)))?;
    Ok(text + "\n")
}

/// Says something on standard error. A terminal that is gone must not take the run with it.
pub(crate) fn talk(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", text.trim_end_matches('\n'));
}

/// The text with every control character as one space, so that a file or a plugin cannot steer a terminal.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[clock]\nduration = -1.0\n";

    fn finding() -> Diagnostic {
        Diagnostic {
            span: Some(19..23),
            path: "clock.duration".into(),
            help: Some("give a positive time in seconds".into()),
            ..Diagnostic::error("`clock.duration` must be positive, but it is -1")
        }
    }

    #[test]
    fn a_finding_shows_its_line_and_its_hint() {
        let text = diagnostic(Paint::off(), "a.toml", SCENE, &finding());
        assert!(text.contains("a.toml:2:12"), "{text}");
        assert!(text.contains("duration = -1.0"), "{text}");
        assert!(text.contains("hint: give a positive time in seconds"), "{text}");
        assert!(!text.contains('\x1b'), "{text}");
    }

    #[test]
    fn the_place_of_a_finding_is_kept_for_machines() {
        let problem = problem_of(Paint::off(), "a.toml", SCENE, &finding());
        assert_eq!((problem.line, problem.column), (Some(2), Some(12)));
    }

    #[test]
    fn a_span_outside_the_text_is_moved_into_it() {
        let found = Diagnostic { span: Some(1000..2000), ..finding() };
        assert!(diagnostic(Paint::off(), "a.toml", SCENE, &found).contains("must be positive"));
    }

    #[test]
    fn errors_end_with_their_hints_and_a_plugin_cannot_steer_the_terminal() {
        let problem = Problem::new("It broke").because("because\x1b[2J of this").hint("mend it");
        let text = error(Paint::off(), &Error::new(Code::Process, problem));
        assert_eq!(text, "error: It broke\n  because [2J of this\n\nhint: mend it\n");
    }

    #[test]
    fn what_is_no_scene_does_not_fill_the_terminal() {
        let all = Error { code: Code::Scene, problems: vec![Problem::new("It broke"); 1000] };
        let text = error(Paint::off(), &all);
        assert_eq!(text.matches("It broke").count(), MOST_PROBLEMS);
        assert!(text.ends_with("1000 problems, of which the first 50 are shown: is this the right file?\n"), "{text}");
    }
}
