//! Licence expressions as packages write them: `MIT OR (Apache-2.0 AND ISC)`, `Apache-2.0 WITH LLVM-exception`.

/// Whether a licence, with its exception if there is one, may be used.
pub(crate) type Accepts<'a> = &'a dyn Fn(&str, Option<&str>) -> bool;

/// Whether the expression leaves a choice whose every part is accepted; nothing where it is no expression.
///
/// `AND` binds stronger than `OR`, `WITH` stronger than both. The old `A/B` means `A OR B`.
pub(crate) fn satisfied(expression: &str, accepts: Accepts<'_>) -> Option<bool> {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut parser = Parser { words: &words, accepts };
    let answer = parser.any()?;
    parser.words.is_empty().then_some(answer)
}

struct Parser<'a> {
    words: &'a [&'a str],
    accepts: Accepts<'a>,
}

impl<'a> Parser<'a> {
    /// `all (OR all)*`
    fn any(&mut self) -> Option<bool> {
        let mut answer = self.all()?;
        while self.take("OR") {
            answer |= self.all()?;
        }
        Some(answer)
    }

    /// `one (AND one)*`
    fn all(&mut self) -> Option<bool> {
        let mut answer = self.one()?;
        while self.take("AND") {
            answer &= self.one()?;
        }
        Some(answer)
    }

    /// `( any )` or a licence, perhaps `WITH` an exception.
    fn one(&mut self) -> Option<bool> {
        if self.take("(") {
            let answer = self.any()?;
            return self.take(")").then_some(answer);
        }
        let licence = self.name()?;
        let exception = if self.take("WITH") { Some(self.name()?) } else { None };
        Some((self.accepts)(licence, exception))
    }

    fn name(&mut self) -> Option<&'a str> {
        let (&word, rest) = self.words.split_first()?;
        if ["AND", "OR", "WITH", "(", ")"].contains(&word) {
            return None;
        }
        self.words = rest;
        Some(word)
    }

    fn take(&mut self, word: &str) -> bool {
        match self.words.split_first() {
            Some((&first, rest)) if first == word => {
                self.words = rest;
                true
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good(expression: &str) -> Option<bool> {
        satisfied(expression, &|licence, exception| {
            ["MIT", "ISC"].contains(&licence) && exception.is_none_or(|e| e == "LLVM-exception")
        })
    }

    #[test]
    fn a_choice_needs_one_accepted_side_and_a_sum_needs_all() {
        for (expression, answer) in [
            ("MIT", true),
            ("GPL-3.0", false),
            ("GPL-3.0 OR MIT", true),
            ("GPL-3.0/MIT", true),
            ("GPL-3.0 AND MIT", false),
            ("MIT AND ISC", true),
            ("GPL-3.0 AND MIT OR ISC", true),
            ("GPL-3.0 AND (MIT OR ISC)", false),
            ("(MIT OR GPL-3.0) AND ISC", true),
            ("  GPL-3.0 OR ISC", true),
            ("MIT WITH LLVM-exception", true),
            ("MIT WITH Other-exception", false),
        ] {
            assert_eq!(good(expression), Some(answer), "{expression}");
        }
    }

    #[test]
    fn what_is_no_expression_is_not_accepted() {
        for broken in ["", "MIT OR", "OR MIT", "(MIT", "MIT)", "MIT ISC", "MIT WITH", "()"] {
            assert_eq!(good(broken), None, "{broken}");
        }
    }
}
