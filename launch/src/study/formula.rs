//! Closed forms of time, as in `0.5*(cos(2*PI*t) + cos(6*PI*t))`.
//!
//! Sums, products, powers (`^`, to the right), parentheses, the numbers `PI` and `E`, the variable `t` \[s\] and a
//! handful of functions. Nothing else can be said, so a formula from a foreign file can do no harm.

use crate::hint::{list, near_miss};

/// Deepest nesting of parentheses, powers and signs; a formula is written by hand.
const DEEPEST: usize = 64;

/// A function of one value, with its name.
type Named = (&'static str, fn(f64) -> f64);

/// Functions of one value.
const FUNCTIONS: [Named; 11] = [
    ("abs", f64::abs),
    ("acos", f64::acos),
    ("asin", f64::asin),
    ("atan", f64::atan),
    ("cos", f64::cos),
    ("cosh", f64::cosh),
    ("exp", f64::exp),
    ("log", f64::ln),
    ("sin", f64::sin),
    ("sqrt", f64::sqrt),
    ("tan", f64::tan),
];

/// A formula of `t`.
#[derive(Clone, Debug)]
pub(crate) struct Formula {
    text: String,
    root: Term,
}

#[derive(Clone, Debug)]
enum Term {
    Number(f64),
    Time,
    Minus(Box<Term>),
    Both(char, Box<Term>, Box<Term>),
    Call(fn(f64) -> f64, Box<Term>),
}

/// Where a formula cannot be understood, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mistake {
    /// Byte of the formula.
    pub(crate) at: usize,
    /// What is wrong, as a part of a sentence.
    pub(crate) why: String,
}

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// The first thing that cannot be understood.
    pub(crate) fn parse(text: &str) -> Result<Self, Mistake> {
        let mut reader = Reader { text, at: 0, depth: 0 };
        let root = reader.sum()?;
        match reader.peek() {
            None => Ok(Self { text: text.to_owned(), root }),
            Some(c) => Err(reader.mistake(format!("an operator was expected, not `{c}`"))),
        }
    }

    /// Its value at a time \[s\].
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        self.root.at(time_s)
    }

    /// As it was written.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }
}

impl Term {
    fn at(&self, t: f64) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Time => t,
            Self::Minus(term) => -term.at(t),
            Self::Call(function, term) => function(term.at(t)),
            Self::Both(operator, a, b) => {
                let (a, b) = (a.at(t), b.at(t));
                match operator {
                    '+' => a + b,
                    '-' => a - b,
                    '*' => a * b,
                    '/' => a / b,
                    _ => a.powf(b),
                }
            }
        }
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl Reader<'_> {
    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, wanted: &[char]) -> Option<char> {
        let found = self.peek().filter(|c| wanted.contains(c))?;
        self.at += found.len_utf8();
        Some(found)
    }

    fn mistake(&self, why: impl Into<String>) -> Mistake {
        Mistake { at: self.at, why: why.into() }
    }

    fn sum(&mut self) -> Result<Term, Mistake> {
        let mut term = self.product()?;
        while let Some(operator) = self.take(&['+', '-']) {
            term = Term::Both(operator, Box::new(term), Box::new(self.product()?));
        }
        Ok(term)
    }

    fn product(&mut self) -> Result<Term, Mistake> {
        let mut term = self.signed()?;
        while let Some(operator) = self.take(&['*', '/']) {
            term = Term::Both(operator, Box::new(term), Box::new(self.signed()?));
        }
        Ok(term)
    }

    /// A sign binds less than a power: `-t^2` is `-(t^2)`.
    fn signed(&mut self) -> Result<Term, Mistake> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.mistake(format!("it is nested deeper than {DEEPEST} levels")));
        }
        let term = match self.take(&['-', '+']) {
            Some('-') => Ok(Term::Minus(Box::new(self.signed()?))),
            Some(_) => self.signed(),
            None => self.power(),
        };
        self.depth -= 1;
        term
    }

    fn power(&mut self) -> Result<Term, Mistake> {
        let base = self.atom()?;
        match self.take(&['^']) {
            Some(operator) => Ok(Term::Both(operator, Box::new(base), Box::new(self.signed()?))),
            None => Ok(base),
        }
    }

    fn atom(&mut self) -> Result<Term, Mistake> {
        if self.take(&['(']).is_some() {
            return self.closed();
        }
        match self.peek() {
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.word(),
            Some(c) => Err(self.mistake(format!("a value was expected, not `{}`", c.escape_debug()))),
            None => Err(self.mistake("a value is missing at the end")),
        }
    }

    /// What stands in parentheses of which the first is read.
    fn closed(&mut self) -> Result<Term, Mistake> {
        let inner = self.sum()?;
        if self.take(&[')']).is_none() {
            return Err(self.mistake("a `)` is missing here"));
        }
        Ok(inner)
    }

    fn number(&mut self) -> Result<Term, Mistake> {
        let rest = &self.text[self.at..];
        let mut end = 0;
        for (i, c) in rest.char_indices() {
            let after_exponent = rest[..i].ends_with(['e', 'E']);
            if c.is_ascii_digit() || c == '.' || (c == 'e' || c == 'E') || ((c == '+' || c == '-') && after_exponent) {
                end = i + c.len_utf8();
            } else {
                break;
            }
        }
        let value = rest[..end].parse().map_err(|_| self.mistake(format!("`{}` is no number", &rest[..end])))?;
        self.at += end;
        Ok(Term::Number(value))
    }

    fn word(&mut self) -> Result<Term, Mistake> {
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let (word, begin) = (&rest[..end], self.at);
        self.at += end;
        match word {
            "t" => return Ok(Term::Time),
            "PI" => return Ok(Term::Number(std::f64::consts::PI)),
            "E" => return Ok(Term::Number(std::f64::consts::E)),
            _ => {}
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(name, _)| *name == word) else {
            let names = || FUNCTIONS.iter().map(|(name, _)| *name).chain(["t", "PI", "E"]);
            let hint = match near_miss(word, names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are {}", list(names())),
            };
            return Err(Mistake { at: begin, why: format!("`{word}` is unknown: {hint}") });
        };
        if self.take(&['(']).is_none() {
            return Err(self.mistake(format!("`{word}` needs its value in parentheses")));
        }
        Ok(Term::Call(*function, Box::new(self.closed()?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_have_the_values_of_school() {
        let cases = [
            ("1 + 2*3", 7.0),
            ("-t^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("8/4/2", 1.0),
            ("1 - 2 - 3", -4.0),
            ("1.5e-1*t", 0.3),
            ("log(E) + sqrt(abs(-4))", 3.0),
            (" ( 1 + t ) * ( t - 1 ) ", 3.0),
        ];
        for (text, value) in cases {
            // Up to five operations on numbers below 1000.
            let found = Formula::parse(text).unwrap().at(2.0);
            assert!((found - value).abs() < 1e-12, "{text}: {found}");
        }
        let oscillator = Formula::parse("0.5*(cos(2*PI*t) + cos(6*PI*t))").unwrap();
        // Two cosines of numbers below 20 and a sum: a few roundings.
        assert!((oscillator.at(0.1) - 0.25).abs() < 1e-15, "{}", oscillator.at(0.1));
    }

    #[test]
    fn mistakes_have_their_place() {
        let cases = [
            ("1 +", 3, "missing"),
            ("cos t", 4, "parentheses"),
            ("cos(t", 5, "`)`"),
            ("2*sine(t)", 2, "did you mean `sin`?"),
            ("2 t", 2, "operator"),
            ("1..2", 0, "no number"),
            ("ü", 0, "expected"),
            ("", 0, "missing"),
        ];
        for (text, at, why) in cases {
            let found = Formula::parse(text).unwrap_err();
            assert!(found.at == at && found.why.contains(why), "{text}: {found:?}");
        }
        for open in ["(", "-", "cos(", "2^"] {
            assert!(Formula::parse(&open.repeat(100_000)).unwrap_err().why.contains("nested"), "{open}");
        }
    }
}
