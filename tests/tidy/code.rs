//! Rust text without what is not code: enough of the language's surface to search it without false alarms.

/// The text with comments, strings and characters blanked. Every line keeps its number and every character its place; a
/// character outside ASCII becomes an `x`, so that bytes and characters are the same.
pub(crate) fn masked(source: &str) -> String {
    let text: Vec<char> = source.chars().collect();
    let mut out = String::with_capacity(source.len());
    let mut at = 0;
    while at < text.len() {
        let length = comment(&text[at..]).or_else(|| literal(&text, at)).unwrap_or(0);
        if length == 0 {
            out.push(if text[at].is_ascii() { text[at] } else { 'x' });
            at += 1;
            continue;
        }
        out.extend(text[at..at + length].iter().map(|&c| if c == '\n' { '\n' } else { ' ' }));
        at += length;
    }
    out
}

/// Length of the comment that begins here, its line end not counted.
fn comment(text: &[char]) -> Option<usize> {
    match text {
        ['/', '/', ..] => Some(text.iter().position(|&c| c == '\n').unwrap_or(text.len())),
        ['/', '*', ..] => {
            let (mut depth, mut at) = (0, 0);
            while at < text.len() {
                let (step, change) = match text[at..] {
                    ['/', '*', ..] => (2, 1),
                    ['*', '/', ..] => (2, -1),
                    _ => (1, 0),
                };
                depth += change;
                at += step;
                if depth == 0 {
                    return Some(at);
                }
            }
            Some(text.len())
        }
        _ => None,
    }
}

/// Length of the string or character that begins at `at`, its prefix included.
fn literal(text: &[char], at: usize) -> Option<usize> {
    let rest = &text[at..];
    let inside_a_word = at > 0 && is_word(text[at - 1]);
    match rest {
        ['"', ..] => Some(quoted(rest, '"')),
        ['\'', '\\', ..] | ['\'', _, '\'', ..] => Some(quoted(rest, '\'')),
        ['b' | 'c', 'r', ..] if !inside_a_word => raw(&rest[2..]).map(|length| length + 2),
        ['r', ..] if !inside_a_word => raw(&rest[1..]).map(|length| length + 1),
        _ => None,
    }
}

/// Length up to the closing quote that no backslash escapes.
fn quoted(text: &[char], quote: char) -> usize {
    let mut at = 1;
    while at < text.len() && text[at] != quote {
        at += if text[at] == '\\' { 2 } else { 1 };
    }
    (at + 1).min(text.len())
}

/// Length of a raw string from its first `#` or quote; nothing for a raw name.
fn raw(text: &[char]) -> Option<usize> {
    let hashes = text.iter().take_while(|&&c| c == '#').count();
    if text.get(hashes) != Some(&'"') {
        return None;
    }
    let closes =
        |at: usize| text[at] == '"' && text.len() > at + hashes && text[at + 1..=at + hashes].iter().all(|&c| c == '#');
    let end = (hashes + 1..text.len()).find(|&at| closes(at)).unwrap_or(text.len() - 1);
    Some((end + 1 + hashes).min(text.len()))
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Beginnings of attributes after which an item exists in tests only.
const TEST_ONLY: [&str; 2] = ["#[cfg(test)]", "#[cfg(all(test"];

/// Masked text with every item that exists in tests only blanked.
pub(crate) fn without_tests(masked: &str) -> String {
    let mut bytes = masked.as_bytes().to_vec();
    for (start, end) in test_items(masked) {
        bytes[start..end].iter_mut().filter(|b| **b != b'\n').for_each(|b| *b = b' ');
    }
    String::from_utf8(bytes).expect("masked text is ASCII")
}

/// Names of modules in files of their own that exist in tests only: `#[cfg(test)] mod name;`.
pub(crate) fn test_modules(masked: &str) -> Vec<String> {
    let named = |&(start, end): &(usize, usize)| {
        let item = masked[start..end].trim_end().strip_suffix(';')?;
        let (_, name) = item.rsplit_once("mod ")?;
        Some(name.trim().to_owned())
    };
    test_items(masked).iter().filter_map(named).collect()
}

/// First byte and byte after the last of every item that exists in tests only, its attribute included.
fn test_items(masked: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(start) = TEST_ONLY.iter().filter_map(|a| masked[from..].find(a)).min().map(|at| from + at) {
        let end = item_end(masked, start);
        found.push((start, end));
        from = end;
    }
    found
}

/// End of the item whose attribute begins at `start`: behind its first `;`, or behind the braces that come before one.
fn item_end(masked: &str, start: usize) -> usize {
    let mut depth = 0_usize;
    for (at, byte) in masked.bytes().enumerate().skip(start) {
        match byte {
            b'{' => depth += 1,
            b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 && matches!(byte, b';' | b'}') {
            return at + 1;
        }
    }
    masked.len()
}

/// Numbers of the lines, from 1, on which `pattern` stands; where it begins or ends with a letter, as a whole word.
pub(crate) fn lines_with(masked: &str, pattern: &str) -> Vec<usize> {
    let starts_in_word = pattern.starts_with(is_word);
    let ends_in_word = pattern.ends_with(is_word);
    let stands_alone = |line: &str, at: usize| {
        let goes_on_before = starts_in_word && line[..at].ends_with(is_word);
        let goes_on_after = ends_in_word && line[at + pattern.len()..].starts_with(is_word);
        !goes_on_before && !goes_on_after
    };
    let holds = |line: &str| line.match_indices(pattern).any(|(at, _)| stands_alone(line, at));
    masked.lines().enumerate().filter(|(_, line)| holds(line)).map(|(number, _)| number + 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: &str = r##"
// a.unwrap() in a comment
/* b.unwrap() /* nested */ c.unwrap() */
fn f<'a>(x: &'a str) { x.unwrap(); }
const S: &str = "d.unwrap() \" e.unwrap()";
const R: &str = r#"f.unwrap() " g.unwrap()"#;
const C: [char; 3] = ['"', '\'', 'ä']; fn g() { h.unwrap(); }
#[cfg(test)]
mod tests { fn t() { i.unwrap(); } }
#[cfg(test)] mod more;
#[cfg(test)] use a::{b, c};
fn unsafely() { unwrap_me(); }
#[cfg(not(test))]
fn k() { l.unwrap(); }
"##;

    #[test]
    fn only_code_outside_tests_is_searched() {
        let masked = masked(SAMPLE);
        assert_eq!(masked.lines().count(), SAMPLE.lines().count());
        assert!(masked.is_ascii());
        assert_eq!(lines_with(&masked, ".unwrap()"), [4, 7, 9, 14]);
        assert_eq!(lines_with(&without_tests(&masked), ".unwrap()"), [4, 7, 14]);
    }

    #[test]
    fn words_are_found_whole() {
        let masked = masked("unsafe { }\nfn unsafely() {}\nlet not_unsafe = 1;\n(unsafe)");
        assert_eq!(lines_with(&masked, "unsafe"), [1, 4]);
    }

    #[test]
    fn modules_in_files_of_their_own_are_known_by_name() {
        assert_eq!(test_modules(&masked(SAMPLE)), ["more"]);
    }

    #[test]
    fn unfinished_text_does_not_stop_the_scanner() {
        for text in ["\"open", "r#\"open", "/* open", "'\\", "#[cfg(test)] mod a {", "r#", "b", "'"] {
            let _ = without_tests(&masked(text));
        }
    }
}
