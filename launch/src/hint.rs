//! Near misses: what a user may have meant.

/// Similarity below which a name is not worth proposing.
const THRESHOLD: f64 = 0.7;

/// The candidate most like `name`, if one is like it at all.
pub(crate) fn near_miss<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (strsim::jaro_winkler(&wanted, &c.to_lowercase()), c))
        .filter(|(score, _)| *score >= THRESHOLD)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c)
}

/// Names in backticks with commas between: "`a`, `b`", or `nothing` for an empty list.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = names.into_iter().map(|n| format!("`{n}`")).collect();
    if quoted.is_empty() { "nothing".into() } else { quoted.join(", ") }
}

/// `1 body`, `2 bodies`: a count with the form of the word that fits it.
pub(crate) fn count(n: usize, one: &str, many: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {many}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_is_found_and_a_stranger_is_not() {
        let names = ["oscillator", "two-tops"];
        assert_eq!(near_miss("oscilator", names), Some("oscillator"));
        assert_eq!(near_miss("Two_Tops", names), Some("two-tops"));
        assert_eq!(near_miss("quux", names), None);
    }

    #[test]
    fn counts_have_their_plural() {
        assert_eq!(count(1, "body", "bodies"), "1 body");
        assert_eq!(count(0, "body", "bodies"), "0 bodies");
    }
}
