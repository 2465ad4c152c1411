//! Numbers as people read them.

/// Digits that are shown of a measured value.
const DIGITS: i32 = 4;

/// A value with four significant digits: `12.35`, `0.001235`, `1.235 × 10⁻¹⁵`.
pub(super) fn quantity(value: f64) -> String {
    if value.is_nan() {
        return "not a number".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞".into() } else { "−∞".into() };
    }
    if value == 0.0 {
        return "0".into();
    }
    let text = format!("{:.*e}", (DIGITS - 1) as usize, value.abs());
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or_default();
    let sign = if value < 0.0 { "−" } else { "" };
    if (-3..6).contains(&exponent) {
        let decimals = (DIGITS - 1 - exponent).max(0) as usize;
        return format!("{sign}{:.decimals$}", value.abs());
    }
    format!("{sign}{mantissa} × 10{}", superscript(exponent))
}

/// A value that somebody chose: as [`quantity`], without zeros that say nothing.
pub(super) fn limit(value: f64) -> String {
    let text = quantity(value);
    let (digits, power) = text.split_once(' ').map_or((text.as_str(), ""), |(digits, power)| (digits, power));
    if !digits.contains('.') {
        return text;
    }
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    if power.is_empty() { digits.into() } else { format!("{digits} {power}") }
}

/// A value that may be missing.
pub(super) fn maybe(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), quantity)
}

/// Ten to the power of a whole number, for an axis.
pub(super) fn power_of_ten(exponent: i32) -> String {
    match exponent {
        0 => "1".into(),
        1 => "10".into(),
        _ => format!("10{}", superscript(exponent)),
    }
}

/// A count with a thin space between groups of three digits.
pub(super) fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

fn superscript(number: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32('⁰' as u32 + (c as u32 - '0' as u32)).unwrap_or(c),
        other => other,
    };
    number.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_four_digits() {
        let cases = [
            (0.0, "0"),
            (12.345_67, "12.35"),
            (-0.001_234_56, "−0.001235"),
            (123_456.0, "123456"),
            (1.234_567e-15, "1.235 × 10⁻¹⁵"),
            (-6.02e23, "−6.020 × 10²³"),
            (9.999_96, "10.00"),
            (f64::NAN, "not a number"),
            (f64::INFINITY, "∞"),
        ];
        for (value, text) in cases {
            assert_eq!(quantity(value), text);
        }
    }

    #[test]
    fn limits_have_no_zeros_at_their_end() {
        assert_eq!([1e-12, 0.5, 100.0, 6e-5].map(limit), ["1 × 10⁻¹²", "0.5", "100", "6 × 10⁻⁵"]);
        assert_eq!(limit(f64::NAN), "not a number");
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!([count(7), count(1234), count(1_234_567)], ["7", "1\u{202f}234", "1\u{202f}234\u{202f}567"]);
        assert_eq!([power_of_ten(-12), power_of_ten(0), power_of_ten(3)], ["10⁻¹²", "1", "10³"]);
    }
}
