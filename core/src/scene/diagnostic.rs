//! What is wrong with a scene file, where, and what would help.

use std::fmt::Write as _;
use std::ops::Range;

/// Widest part of a source line that is quoted, in characters.
const QUOTE_WIDTH: usize = 100;

/// Whether a scene with this finding can run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// It cannot.
    Error,
    /// It can, but the user may have meant something else.
    Warning,
}

/// One finding about a scene file. It does not know the file's name, so it also serves text that is in no file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Bytes of the text it is about; none for what stands in no text, such as an override of the command line.
    pub span: Option<Range<usize>>,
    /// Place in the scene, as in `body[2].material.density`; empty for the whole scene.
    pub path: String,
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// Whether the scene can run.
    pub severity: Severity,
}

impl Diagnostic {
    /// An error without a place; fill in what is known.
    pub fn error(message: impl Into<String>) -> Self {
        Self { span: None, path: String::new(), message: message.into(), help: None, severity: Severity::Error }
    }
}

/// Renders findings as plain text: message, file, line and column, the line quoted with carets below, help.
pub fn render(file_name: &str, source: &str, diagnostics: &[Diagnostic]) -> String {
    let mut text = String::new();
    for diagnostic in diagnostics {
        render_one(&mut text, file_name, source, diagnostic);
        text.push('\n');
    }
    text.push_str(&summary(diagnostics));
    text
}

/// `2 errors, 1 warning`, or nothing when there is nothing.
fn summary(diagnostics: &[Diagnostic]) -> String {
    let count = |severity| diagnostics.iter().filter(|d| d.severity == severity).count();
    let words = |n, word| match n {
        0 => None,
        1 => Some(format!("1 {word}")),
        _ => Some(format!("{n} {word}s")),
    };
    let parts: Vec<String> = [words(count(Severity::Error), "error"), words(count(Severity::Warning), "warning")]
        .into_iter()
        .flatten()
        .collect();
    if parts.is_empty() { String::new() } else { parts.join(", ") + "\n" }
}

fn render_one(text: &mut String, file_name: &str, source: &str, diagnostic: &Diagnostic) {
    let word = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    // Writing to a `String` cannot fail.
    let _ = writeln!(text, "{word}: {}", printable(&diagnostic.message));
    let mut margin = 1;
    if let Some(span) = &diagnostic.span {
        let place = Place::find(source, span);
        margin = place.line.to_string().len();
        let _ = writeln!(text, "{:margin$}--> {file_name}:{}:{}", "", place.line, place.column);
        let _ = writeln!(text, "{:margin$} |", "");
        let _ = writeln!(text, "{} | {}", place.line, place.quote);
        let _ = writeln!(text, "{:margin$} | {:indent$}{}", "", "", "^".repeat(place.width), indent = place.indent);
    } else if !diagnostic.path.is_empty() {
        let _ = writeln!(text, " --> {file_name}, `{}`", printable(&diagnostic.path));
    } else {
        let _ = writeln!(text, " --> {file_name}");
    }
    if let Some(help) = &diagnostic.help {
        let _ = writeln!(text, "{:margin$} = help: {}", "", printable(help));
    }
}

/// Where a span begins, and the part of its line to quote.
struct Place {
    /// Counted from 1.
    line: usize,
    /// Counted from 1, in characters.
    column: usize,
    /// The line, or the part of a long line around the span.
    quote: String,
    /// Characters of `quote` before the carets.
    indent: usize,
    /// Number of carets.
    width: usize,
}

impl Place {
    /// Finds the first line of `span`; a span outside the text is moved to its end.
    fn find(source: &str, span: &Range<usize>) -> Self {
        let start = source.floor_char_boundary(span.start);
        let end = source.floor_char_boundary(span.end).max(start);
        let line_start = source[..start].rfind('\n').map_or(0, |i| i + 1);
        let line_end = source[start..].find('\n').map_or(source.len(), |i| start + i);
        let before = source[line_start..start].chars().count();
        let width = source[start..end.min(line_end)].chars().count().max(1);

        let skipped = if before + width > QUOTE_WIDTH { before.saturating_sub(QUOTE_WIDTH / 2) } else { 0 };
        let line = source[line_start..line_end].trim_end_matches('\r');
        let mut quote: String = line.chars().skip(skipped).take(QUOTE_WIDTH).collect();
        if line.chars().count() > skipped + QUOTE_WIDTH {
            quote.push('…');
        }
        let mark = if skipped > 0 { "…" } else { "" };
        let indent = before - skipped + mark.chars().count();
        Self {
            line: source[..line_start].matches('\n').count() + 1,
            column: before + 1,
            quote: format!("{mark}{}", printable(&quote)),
            indent,
            width: width.min((QUOTE_WIDTH + 1).saturating_sub(indent).max(1)),
        }
    }
}

/// The text with every control character, tabs included, as one space, so that a file cannot steer a terminal.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(span: Range<usize>) -> Diagnostic {
        Diagnostic { span: Some(span), help: Some("try less".into()), ..Diagnostic::error("too much") }
    }

    #[test]
    fn the_line_is_quoted_with_carets_below_the_span() {
        let text = render("a.toml", "x = 1\nmässe = 22\n", &[at(15..17)]);
        assert_eq!(
            text,
            "error: too much\n --> a.toml:2:9\n  |\n2 | mässe = 22\n  |         ^^\n  = help: try less\n\n1 error\n"
        );
    }

    #[test]
    fn spans_outside_or_inside_a_character_do_not_panic() {
        let source = "ä\nö";
        for start in 0..8 {
            for end in 0..8 {
                let text = render("a", source, &[at(Range { start, end })]);
                assert!(text.contains("--> a:"), "{text}");
            }
        }
    }

    #[test]
    fn long_lines_are_cut_around_the_span() {
        let source = "0123456789".repeat(1000);
        let text = render("a", &source, &[at(5000..5003)]);
        let longest = text.lines().map(|l| l.chars().count()).max();
        assert!(longest < Some(QUOTE_WIDTH + 10), "{longest:?}");
        assert!(text.contains("^^^\n") && text.contains("a:1:5001"), "{text}");
    }

    #[test]
    fn findings_without_a_span_name_the_path() {
        let finding = Diagnostic { path: "clock.window".into(), ..Diagnostic::error("too long") };
        assert_eq!(render("a.toml", "", &[finding]), "error: too long\n --> a.toml, `clock.window`\n\n1 error\n");
    }
}
