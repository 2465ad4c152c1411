//! As much of Markdown as the documents use.

/// Level of a heading; 0 for every other line.
fn level(line: &str) -> usize {
    let hashes = line.chars().take_while(|&c| c == '#').count();
    if line[hashes..].starts_with(' ') { hashes } else { 0 }
}

/// Lines with whether they stand inside a fenced block, the fences included.
fn with_fences(text: &str) -> impl Iterator<Item = (&str, bool)> {
    let mut open = false;
    text.split_inclusive('\n').map(move |line| {
        let fence = line.starts_with("```");
        let inside = open || fence;
        open ^= fence;
        (line, inside)
    })
}

/// Text below a heading, up to the next heading of its level or a higher one.
pub(crate) fn section<'t>(text: &'t str, heading: &str) -> Option<&'t str> {
    let mut at = 0;
    let mut found: Option<(usize, usize)> = None;
    for (line, inside) in with_fences(text) {
        let deep = if inside { 0 } else { level(line) };
        match found {
            None if deep > 0 && line[deep..].trim() == heading => found = Some((at + line.len(), deep)),
            Some((start, depth)) if deep > 0 && deep <= depth => return Some(&text[start..at]),
            _ => {}
        }
        at += line.len();
    }
    found.map(|(start, _)| &text[start..])
}

/// Cells of every row of every table, headings and rules left out.
pub(crate) fn rows(text: &str) -> Vec<Vec<String>> {
    let lines: Vec<&str> = with_fences(text).filter(|(_, inside)| !inside).map(|(line, _)| line.trim()).collect();
    let is_rule = |line: &str| line.starts_with('|') && line.chars().all(|c| "|-: ".contains(c));
    let is_heading = |i: usize| lines.get(i + 1).is_some_and(|next| is_rule(next));
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect();
    let wanted = |(i, line): &(usize, &&str)| line.starts_with('|') && !is_rule(line) && !is_heading(*i);
    lines.iter().enumerate().filter(wanted).map(|(_, line)| cells(line)).collect()
}

/// First cell of every row.
pub(crate) fn first_cells(text: &str) -> Vec<String> {
    rows(text).into_iter().filter_map(|row| row.into_iter().next()).collect()
}

/// Text of all fenced blocks of one language.
pub(crate) fn fenced(text: &str, language: &str) -> String {
    let fence = format!("```{language}");
    let mut inside = false;
    let mut found = String::new();
    for line in text.lines() {
        if line.starts_with("```") {
            inside = !inside && line.trim_end() == fence;
        } else if inside {
            found.push_str(line);
            found.push('\n');
        }
    }
    found
}

/// What stands between single backticks, outside fenced blocks.
pub(crate) fn literals(text: &str) -> Vec<&str> {
    let in_line = |line: &'_ str| -> Vec<(usize, usize)> {
        let ticks: Vec<usize> = line.match_indices('`').map(|(at, _)| at).collect();
        ticks.chunks_exact(2).map(|pair| (pair[0] + 1, pair[1])).collect()
    };
    let outside = with_fences(text).filter(|(_, inside)| !inside);
    outside.flat_map(|(line, _)| in_line(line).into_iter().map(|(a, b)| &line[a..b])).collect()
}

/// Targets of links inside the repository.
pub(crate) fn links(text: &str) -> Vec<&str> {
    let targets =
        text.match_indices("](").filter_map(|(at, _)| text[at + 2..].split_once(')').map(|(target, _)| target));
    targets.filter(|target| !target.contains("://") && !target.starts_with('#')).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: &str = "# One\n\n## Two\n\n| a | b |\n|---|:-:|\n| `x` | 1 |\n| y | 2 |\n\n```sh\n# no heading\ncosplat run\n\
                          ```\n\n### Deeper\n\n`lit` and [t](a/b.md) and [u](https://x)\n\n## Three\n\n```toml\n`a` = 1\n```\n";

    #[test]
    fn a_section_ends_at_the_next_heading_of_its_level() {
        let two = section(SAMPLE, "Two").expect("it is there");
        assert!(two.contains("cosplat run") && two.contains("lit") && !two.contains("Three"), "{two}");
        assert_eq!(section(SAMPLE, "no heading"), None);
        assert_eq!(section(SAMPLE, "Tw"), None);
    }

    #[test]
    fn rows_are_what_stands_below_the_rule() {
        assert_eq!(rows(SAMPLE), [["`x`", "1"], ["y", "2"]]);
        assert_eq!(first_cells(SAMPLE), ["`x`", "y"]);
    }

    #[test]
    fn blocks_literals_and_links_are_told_apart() {
        assert_eq!(fenced(SAMPLE, "sh"), "# no heading\ncosplat run\n");
        assert_eq!(literals(SAMPLE), ["x", "lit"]);
        assert_eq!(links(SAMPLE), ["a/b.md"]);
    }
}
