//! The file as a tree of values that know where they come from.

use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// Where a value or key stands.
#[derive(Clone, Debug)]
pub(super) enum Origin {
    /// Bytes of the file.
    File(Range<usize>),
    /// An override such as `clock.window=0.005`.
    Override(Rc<str>),
}

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) origin: Origin,
}

/// A TOML value; dates are of no use here and keep their text only.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Text(String),
    Number { value: f64, is_integer: bool },
    Flag(bool),
    Date(String),
    List(Vec<Node>),
    Table(Table),
}

/// Entries by key.
#[derive(Clone, Debug, Default)]
pub(super) struct Table(pub(super) BTreeMap<String, Entry>);

/// A key's place and its value.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) key: Origin,
    pub(super) node: Node,
}

impl Value {
    /// The type in words, to stand after "but is".
    pub(super) fn type_name(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Number { .. } => "a number",
            Self::Flag(_) => "true or false",
            Self::Date(_) => "a date",
            Self::List(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

impl Table {
    /// Converts a parsed table of the file.
    pub(super) fn from_file(table: &DeTable<'_>) -> Self {
        Self::build(table, &Origin::File)
    }

    fn build(table: &DeTable<'_>, origin: &impl Fn(Range<usize>) -> Origin) -> Self {
        let entry = |(key, value): (&Spanned<_>, &Spanned<_>)| {
            let key: &Spanned<std::borrow::Cow<'_, str>> = key;
            (key.get_ref().to_string(), Entry { key: origin(key.span()), node: Node::build(value, origin) })
        };
        Self(table.iter().map(entry).collect())
    }
}

impl Node {
    /// Converts the value of an override.
    pub(super) fn from_override(value: &Spanned<DeValue<'_>>, assignment: &Rc<str>) -> Self {
        Self::build(value, &|_| Origin::Override(assignment.clone()))
    }

    fn build(value: &Spanned<DeValue<'_>>, origin: &impl Fn(Range<usize>) -> Origin) -> Self {
        let converted = match value.get_ref() {
            DeValue::String(text) => Value::Text(text.to_string()),
            DeValue::Integer(integer) => Value::Number { value: integer_value(integer), is_integer: true },
            // What overflows becomes infinite and is refused as such where it is read.
            DeValue::Float(float) => {
                Value::Number { value: float.as_str().parse().unwrap_or(f64::NAN), is_integer: false }
            }
            DeValue::Boolean(flag) => Value::Flag(*flag),
            DeValue::Datetime(date) => Value::Date(date.to_string()),
            DeValue::Array(items) => Value::List(items.iter().map(|item| Self::build(item, origin)).collect()),
            DeValue::Table(table) => Value::Table(Table::build(table, origin)),
        };
        Self { value: converted, origin: origin(value.span()) }
    }
}

/// The nearest f64; integers of more than 127 bits only occur in base ten.
fn integer_value(integer: &DeInteger<'_>) -> f64 {
    i128::from_str_radix(integer.as_str(), integer.radix())
        .map_or_else(|_| integer.as_str().parse().unwrap_or(f64::INFINITY), |value| value as f64)
}
