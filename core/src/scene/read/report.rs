//! Collects findings while a scene is read.

use std::cell::RefCell;
use std::ops::Range;

use super::body::SolverUse;
use super::names::{Declaration, Mention};
use super::node::Origin;
use crate::scene::diagnostic::{Diagnostic, Severity};

/// Findings shown at most; a file with more of them is not a scene with mistakes but something else.
pub(super) const MOST_FINDINGS: usize = 1000;

/// The one syntax error that a line elsewhere can cause.
const DUPLICATE: &str = "duplicate key";

/// Everything noticed so far. Reading never stops at a mistake: what is wrong is reported and replaced by a stand-in,
/// and the scene is thrown away in the end.
#[derive(Default)]
pub(super) struct Report {
    findings: RefCell<Vec<Finding>>,
    pub(super) declarations: RefCell<Vec<Declaration>>,
    pub(super) mentions: RefCell<Vec<Mention>>,
    pub(super) solver_uses: RefCell<Vec<SolverUse>>,
    /// Published materials that are taken, each once.
    pub(super) presets: RefCell<Vec<String>>,
}

struct Finding {
    diagnostic: Diagnostic,
    /// The finding is that something is not there, so an unreadable line elsewhere may be its cause.
    is_absence: bool,
}

impl Report {
    /// Something that is there is wrong.
    pub(super) fn error(&self, origin: &Origin, path: &str, message: String, help: Option<String>) {
        self.add(origin, path, message, help, Severity::Error, false);
    }

    /// Something that should be there is not.
    pub(super) fn absence(&self, origin: &Origin, path: &str, message: String, help: Option<String>) {
        self.add(origin, path, message, help, Severity::Error, true);
    }

    /// Something is allowed but odd.
    pub(super) fn warning(&self, origin: &Origin, path: &str, message: String, help: Option<String>) {
        self.add(origin, path, message, help, Severity::Warning, false);
    }

    /// A finding that is complete.
    pub(super) fn push(&self, diagnostic: Diagnostic) {
        self.findings.borrow_mut().push(Finding { diagnostic, is_absence: false });
    }

    /// A published material is taken.
    pub(super) fn takes(&self, preset: &str) {
        let mut presets = self.presets.borrow_mut();
        if !presets.iter().any(|known| known == preset) {
            presets.push(preset.to_owned());
        }
    }

    /// Whether the scene cannot run.
    pub(super) fn has_errors(&self) -> bool {
        self.findings.borrow().iter().any(|finding| finding.diagnostic.severity == Severity::Error)
    }

    fn add(
        &self,
        origin: &Origin,
        path: &str,
        message: String,
        help: Option<String>,
        severity: Severity,
        is_absence: bool,
    ) {
        let (span, message) = match origin {
            Origin::File(span) => (Some(span.clone()), message),
            Origin::Override(assignment) => (None, format!("{message} (override {})", quoted(assignment))),
        };
        let diagnostic = Diagnostic { span, path: path.to_owned(), message, help, severity };
        self.findings.borrow_mut().push(Finding { diagnostic, is_absence });
    }

    /// The findings in the order of the file, those without a place last. With syntax errors, only what cannot be a
    /// consequence of them is kept beside them.
    pub(super) fn into_diagnostics(self, text: &str, mut syntax: Vec<Diagnostic>) -> Vec<Diagnostic> {
        let shadow = Shadow::of(text, &syntax);
        // Keys of a section whose header is broken fall into the section before it.
        let is_consequence =
            |d: &Diagnostic| d.message == DUPLICATE && d.span.as_ref().is_some_and(|s| s.start > shadow.from);
        syntax.retain(|d| !is_consequence(d));
        let findings = self.findings.into_inner().into_iter();
        let kept = findings.filter(|f| !shadow.covers(f)).map(|f| f.diagnostic);
        let mut all: Vec<Diagnostic> = syntax.into_iter().chain(kept).collect();
        all.sort_by_key(|d| d.span.as_ref().map_or((usize::MAX, 0), |s| (s.start, s.end)));
        if all.len() > MOST_FINDINGS {
            let message = format!("{} more findings are not shown", all.len() - MOST_FINDINGS);
            // Errors first, so that what is cut off never turns a broken scene into a good one.
            all.sort_by_key(|d| d.severity);
            all.truncate(MOST_FINDINGS);
            all.push(Diagnostic { severity: all[0].severity, ..Diagnostic::error(message) });
        }
        all
    }
}

/// The part of a file that its syntax errors make unreadable.
struct Shadow {
    lines: Vec<Range<usize>>,
    /// Begin of the first broken section header: what follows belongs to a section nobody knows.
    from: usize,
}

impl Shadow {
    fn of(text: &str, syntax: &[Diagnostic]) -> Self {
        let mut shadow = Self { lines: Vec::new(), from: usize::MAX };
        for diagnostic in syntax {
            let span = diagnostic.span.clone().unwrap_or(0..0);
            let at = text.floor_char_boundary(span.start);
            let start = text[..at].rfind('\n').map_or(0, |i| i + 1);
            let end = text[at..].find('\n').map_or(text.len(), |i| at + i);
            if diagnostic.message != DUPLICATE && text[start..end].trim_start().starts_with('[') {
                shadow.from = shadow.from.min(start);
            }
            shadow.lines.push(start..end.max(span.end));
        }
        shadow
    }

    fn covers(&self, finding: &Finding) -> bool {
        if self.lines.is_empty() {
            return false;
        }
        let meets = |span: &Range<usize>| {
            span.start >= self.from || self.lines.iter().any(|line| span.start <= line.end && line.start <= span.end)
        };
        finding.is_absence
            || finding.diagnostic.severity == Severity::Warning
            || finding.diagnostic.span.as_ref().is_some_and(meets)
    }
}

/// Text of a user in backticks: at most 60 characters, nothing unprintable.
pub(super) fn quoted(text: &str) -> String {
    let mut short: String = text.chars().take(60).flat_map(char::escape_debug).collect();
    if text.chars().count() > 60 {
        short.push('…');
    }
    format!("`{}`", short.replace("\\\"", "\"").replace("\\'", "'"))
}

/// The candidate the user most probably meant, if one is near.
pub(super) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word: String = word.chars().take(60).collect::<String>().to_lowercase();
    let distance = |candidate: &str| strsim::damerau_levenshtein(&word, candidate);
    let is_near = |candidate: &str| {
        let longest = word.chars().count().max(candidate.chars().count());
        distance(candidate) == 0
            || (distance(candidate) <= (longest / 3).max(1) && longest > 1)
            || (candidate.len() > 3 && word.starts_with(candidate))
            || (word.len() > 3 && candidate.starts_with(word.as_str()))
    };
    candidates.into_iter().filter(|c| is_near(c)).min_by_key(|c| distance(c))
}

/// "did you mean" the nearest candidate, else the list of all.
pub(super) fn suggestion(word: &str, candidates: &[&str], list_starts: &str) -> Option<String> {
    match nearest(word, candidates.iter().copied()) {
        Some(near) => Some(format!("did you mean `{near}`?")),
        None if candidates.is_empty() => None,
        None => Some(format!("{list_starts} {}", listed(candidates))),
    }
}

/// `a`, `b`, `c`.
pub(super) fn listed(words: &[&str]) -> String {
    let shown: Vec<String> = words.iter().take(30).map(|word| quoted(word)).collect();
    let rest = words.len().saturating_sub(30);
    if rest > 0 { format!("{} and {rest} more", shown.join(", ")) } else { shown.join(", ") }
}
