//! A value being read: each reader takes one type, and reports a value of another type or outside its range.
//!
//! A stand-in is returned for what is wrong; see [`Report`].

use std::ops::RangeInclusive;

use super::fields::Fields;
use super::limits::{Limits, number};
use super::names;
use super::node::{Node, Table, Value};
use super::report::{Report, quoted, suggestion};

/// A value with its place.
#[derive(Clone)]
pub(super) struct At<'a> {
    pub(super) node: &'a Node,
    pub(super) path: String,
    pub(super) report: &'a Report,
}

impl<'a> At<'a> {
    /// Something is wrong with the value.
    pub(super) fn error(&self, message: String, help: Option<String>) {
        self.report.error(&self.node.origin, &self.path, message, help);
    }

    /// The value is allowed but odd.
    pub(super) fn warning(&self, message: String, help: Option<String>) {
        self.report.warning(&self.node.origin, &self.path, message, help);
    }

    /// The value must be something else.
    pub(super) fn must_be(&self, what: &str, help: Option<String>) {
        let message = match &self.node.value {
            Value::Text(text) => format!("`{}` must be {what}, but is the string {}", self.key(), quoted(text)),
            Value::Number { value, .. } => format!("`{}` must be {what}, but is {}", self.key(), number(*value)),
            Value::Flag(flag) => format!("`{}` must be {what}, but is {flag}", self.key()),
            other => format!("`{}` must be {what}, but is {}", self.key(), other.type_name()),
        };
        self.error(message, help);
    }

    /// Last part of the path.
    pub(super) fn key(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or_default()
    }

    /// A number within limits.
    pub(super) fn num(&self, limits: Limits) -> f64 {
        let Value::Number { value, .. } = self.node.value else {
            self.must_be("a number", None);
            return f64::NAN;
        };
        match limits.complaint(value) {
            None => value,
            Some(complaint) => {
                self.error(format!("`{}` must be {complaint}", self.key()), None);
                f64::NAN
            }
        }
    }

    /// A whole number in a range.
    pub(super) fn count(&self, range: RangeInclusive<u64>) -> u64 {
        let (least, most) = range.into_inner();
        match self.node.value {
            Value::Number { value, is_integer: true } if value >= least as f64 && value <= most as f64 => value as u64,
            _ => {
                self.must_be(&format!("a whole number between {least} and {}", number(most as f64)), None);
                least
            }
        }
    }

    /// A list of `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, limits: Limits) -> [f64; N] {
        let mut result = [0.0; N];
        match &self.node.value {
            Value::List(items) if items.len() == N => {
                for (i, (number, item)) in result.iter_mut().zip(items).enumerate() {
                    *number = self.item(i, item).num(limits);
                }
            }
            Value::List(items) => {
                let help = Some(format!("write it as [{}]", vec!["…"; N].join(", ")));
                self.error(format!("`{}` must have {N} numbers, but has {}", self.key(), items.len()), help);
            }
            _ => self.must_be(&format!("a list of {N} numbers"), None),
        }
        result
    }

    /// Any number of vectors.
    pub(super) fn vectors(&self, limits: Limits) -> Vec<[f64; 3]> {
        self.items().iter().map(|item| item.numbers(limits)).collect()
    }

    /// `N` vectors.
    pub(super) fn rows<const N: usize>(&self, limits: Limits) -> [[f64; 3]; N] {
        let rows = self.vectors(limits);
        let length = rows.len();
        rows.try_into().unwrap_or_else(|_| {
            if matches!(self.node.value, Value::List(_)) {
                self.error(format!("`{}` must have {N} rows of 3 numbers, but has {length}", self.key()), None);
            }
            [[0.0; 3]; N]
        })
    }

    /// A direction: any vector but zero, scaled to length one.
    pub(super) fn direction(&self) -> [f64; 3] {
        let vector: [f64; 3] = self.numbers(Limits::any(""));
        let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length < 1e-12 && matches!(&self.node.value, Value::List(items) if items.len() == 3) {
            self.error(format!("`{}` has no direction: its length is zero", self.key()), None);
        }
        vector.map(|x| x / length)
    }

    /// A string that is not empty.
    pub(super) fn text(&self) -> String {
        match &self.node.value {
            Value::Text(text) if text.is_empty() => self.error(format!("`{}` is empty", self.key()), None),
            Value::Text(text) => return text.clone(),
            _ => self.must_be("a string", None),
        }
        String::new()
    }

    /// A name of the allowed pattern.
    pub(super) fn name(&self) -> String {
        let name = self.text();
        if !name.is_empty() {
            names::check_pattern(&name, &self.node.origin, &self.path, self.report);
        }
        name
    }

    /// True or false.
    pub(super) fn flag(&self) -> bool {
        let Value::Flag(flag) = self.node.value else {
            self.must_be("true or false", None);
            return false;
        };
        flag
    }

    /// One of several words.
    pub(super) fn word<T: Copy>(&self, words: &[(&'static str, T)]) -> Option<T> {
        let keys: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        let Value::Text(text) = &self.node.value else {
            self.must_be(&format!("one of {}", super::report::listed(&keys)), None);
            return None;
        };
        let found = words.iter().find(|(word, _)| word == text);
        if found.is_none() {
            let help = suggestion(text, &keys, "it can be");
            self.error(format!("`{}` cannot be {}", self.key(), quoted(text)), help);
        }
        found.map(|(_, value)| *value)
    }

    /// The items of a list.
    pub(super) fn items(&self) -> Vec<At<'a>> {
        let Value::List(items) = &self.node.value else {
            self.must_be("a list", None);
            return Vec::new();
        };
        items.iter().enumerate().map(|(i, node)| self.item(i, node)).collect()
    }

    /// The items of a list of tables that is written with `[[key]]`.
    pub(super) fn tables(&self, key: &str) -> Vec<At<'a>> {
        if matches!(self.node.value, Value::Table(_)) {
            self.error(
                format!("`{key}` must be a list of tables"),
                Some(format!("write `[[{key}]]` for each of them")),
            );
            return Vec::new();
        }
        self.items()
    }

    /// The table.
    pub(super) fn as_table(&self) -> Option<&'a Table> {
        let Value::Table(table) = &self.node.value else {
            self.must_be("a table", None);
            return None;
        };
        Some(table)
    }

    /// Reads the table, unknown keys included.
    pub(super) fn table<T>(&self, read: impl FnOnce(&Fields<'a>) -> T) -> Option<T> {
        let table = self.as_table()?;
        Some(Fields::read(table, &self.node.origin, &self.path, self.report, read))
    }

    fn item(&self, index: usize, node: &'a Node) -> Self {
        Self { node, path: format!("{}[{index}]", self.path), report: self.report }
    }
}
