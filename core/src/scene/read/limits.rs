//! Allowed ranges of numbers, with their unit.

/// Largest size of any number in a scene; its square is still finite in single precision.
const LARGEST: f64 = 1e18;

/// A range and the unit it is in.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    low: Edge,
    high: Edge,
    unit: &'static str,
}

#[derive(Clone, Copy)]
enum Edge {
    Open,
    With(f64),
    Without(f64),
}

impl Limits {
    /// Any finite number.
    pub(super) const fn any(unit: &'static str) -> Self {
        Self { low: Edge::Open, high: Edge::Open, unit }
    }

    /// Greater than zero.
    pub(super) const fn positive(unit: &'static str) -> Self {
        Self { low: Edge::Without(0.0), high: Edge::Open, unit }
    }

    /// Zero or more.
    pub(super) const fn not_negative(unit: &'static str) -> Self {
        Self { low: Edge::With(0.0), high: Edge::Open, unit }
    }

    /// From `low` to `high`, both allowed.
    pub(super) const fn between(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low: Edge::With(low), high: Edge::With(high), unit }
    }

    /// Greater than `low`.
    pub(super) const fn above(low: f64, unit: &'static str) -> Self {
        Self { low: Edge::Without(low), high: Edge::Open, unit }
    }

    /// Above `low` and below `high`, neither allowed.
    pub(super) const fn inside(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low: Edge::Without(low), high: Edge::Without(high), unit }
    }

    /// Says what the value must be if it is not, as in "greater than 0 kg, but is -2 kg".
    pub(super) fn complaint(self, value: f64) -> Option<String> {
        let low = match self.low {
            Edge::Open => true,
            Edge::With(edge) => value >= edge,
            Edge::Without(edge) => value > edge,
        };
        let high = match self.high {
            Edge::Open => true,
            Edge::With(edge) => value <= edge,
            Edge::Without(edge) => value < edge,
        };
        if !value.is_finite() {
            Some(format!("a finite number, but is {value}"))
        } else if !(low && high) {
            Some(format!("{}, but is {}", self.words(), self.with_unit(value)))
        } else if value.abs() > LARGEST {
            Some(format!("at most {} in size, but is {}", self.with_unit(LARGEST), self.with_unit(value)))
        } else {
            None
        }
    }

    fn words(self) -> String {
        match (self.low, self.high) {
            (Edge::With(low), Edge::With(high)) => format!("between {} and {}", number(low), self.with_unit(high)),
            (low, high) => {
                let low = match low {
                    Edge::Open => None,
                    Edge::With(edge) => Some(format!("at least {}", self.with_unit(edge))),
                    Edge::Without(edge) => Some(format!("greater than {}", self.with_unit(edge))),
                };
                let high = match high {
                    Edge::Open => None,
                    Edge::With(edge) => Some(format!("at most {}", self.with_unit(edge))),
                    Edge::Without(edge) => Some(format!("less than {}", self.with_unit(edge))),
                };
                [low, high].into_iter().flatten().collect::<Vec<_>>().join(" and ")
            }
        }
    }

    fn with_unit(self, value: f64) -> String {
        if self.unit.is_empty() { number(value) } else { format!("{} {}", number(value), self.unit) }
    }
}

/// A number for people: plain where that is short.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-4..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_complaint_names_value_range_and_unit() {
        let said = |limits: Limits, value| limits.complaint(value).unwrap_or_default();
        assert_eq!(said(Limits::positive("kg"), -2.0), "greater than 0 kg, but is -2 kg");
        assert_eq!(said(Limits::not_negative(""), -1e-9), "at least 0, but is -1e-9");
        assert_eq!(said(Limits::between(0.0, 1.0, ""), 1.5), "between 0 and 1, but is 1.5");
        assert_eq!(said(Limits::inside(-1.0, 0.5, ""), 0.5), "greater than -1 and less than 0.5, but is 0.5");
        assert_eq!(said(Limits::any("m"), f64::NAN), "a finite number, but is NaN");
        assert_eq!(said(Limits::any("m"), 1e300), "at most 1e18 m in size, but is 1e300 m");
        assert_eq!(Limits::any("m").complaint(-3.0), None);
    }
}
