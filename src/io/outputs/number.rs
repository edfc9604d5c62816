//! Numbers as text: significant digits, and a value rounded by its standard error.
//!
//! Three roundings of "value +- error" differ where the error is just below a power of ten, or very small; each output keeps its own:
//! [`measured`] (tables of estimates), [`estimate_text`] (sentences of causes), [`short_measured_text`] (sentences and tables of
//! manoeuvres, at most four decimals).

use crate::postflight::manoeuvres::record::Measured;
use std::fmt::{self, Display, Formatter};

/// A number to that many significant digits, plain between 1e-4 and 1e6 in size; `-` where it is not finite.
#[derive(Clone, Copy, Debug)]
pub struct Digits(pub f64, pub u8);

impl Display for Digits {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Digits(value, digits) = *self;
        if !value.is_finite() {
            return f.write_str("-");
        }
        let digits = i32::from(digits.clamp(1, 17));
        let size = libm::fabs(value);
        if size > 0.0 && !(1e-4..1e6).contains(&size) {
            let decimals = usize::try_from(digits - 1).unwrap_or(0);
            return write!(f, "{value:.decimals$e}");
        }
        let magnitude = if size > 0.0 { libm::floor(libm::log10(size)) as i32 } else { 0 };
        let decimals = usize::try_from(digits - 1 - magnitude).unwrap_or(0);
        f.write_str(&rounded(value, decimals))
    }
}

/// A number with that many decimals; what rounds to zero has no minus sign.
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|letter| matches!(letter, b'0' | b'.')) => size.to_owned(),
        _ => text,
    }
}

/// A number with that many decimals for a table, as a power of ten from ten million on in size, and from a hundred thousand on
/// where it would not fit its column; a word where it is no number:
/// `none`, `infinite`. Width, alignment and a plus sign are those of the format.
#[derive(Clone, Copy, Debug)]
pub struct Fixed(pub f64, pub usize);

impl Display for Fixed {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Fixed(value, decimals) = *self;
        if value.is_nan() {
            return f.pad("none");
        }
        if value.is_infinite() {
            return f.pad(if value > 0.0 { "infinite" } else { "-infinite" });
        }
        let signed = |text: String| if f.sign_plus() && !text.starts_with('-') { format!("+{text}") } else { text };
        let size = libm::fabs(value);
        let plain = (size < 1e7).then(|| signed(rounded(value, decimals)));
        let fits = |plain: &String| size < 1e5 || f.width().is_none_or(|width| plain.len() <= width);
        f.pad(&plain.filter(fits).unwrap_or_else(|| signed(format!("{value:.2e}"))))
    }
}

/// A number as a power of ten with that many decimals; a word where it is no number, as [`Fixed`].
#[derive(Clone, Copy, Debug)]
pub struct Power(pub f64, pub usize);

impl Display for Power {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Power(value, decimals) = *self;
        if value.is_finite() { f.pad(&format!("{value:.decimals$e}")) } else { Fixed(value, 0).fmt(f) }
    }
}

/// A band of frequencies to two decimals, `0.25-1.50`; a band of one line is that line.
pub fn band_text((low, high): (f64, f64)) -> String {
    let (low, high) = (Fixed(low, 2).to_string(), Fixed(high, 2).to_string());
    if low == high { low } else { format!("{low}-{high}") }
}

/// A number and its standard error: two significant digits of the error, the number to the same decimal place.
pub fn measured(value: f64, std: f64) -> (String, String) {
    let plain = |size: f64| size == 0.0 || (1e-7..1e6).contains(&size);
    if !(std > 0.0 && std.is_finite() && plain(std) && plain(libm::fabs(value))) {
        return (Digits(value, 4).to_string(), Digits(std, 2).to_string());
    }
    // Of an error just below a power of ten the rounding may bring a third digit.
    let magnitude = libm::floor(libm::log10(std * 1.005)) as i32;
    let decimals = usize::try_from(1 - magnitude).unwrap_or(0);
    (rounded(value, decimals), rounded(std, decimals))
}

/// [`measured`] as one text, `value +- error`.
pub fn measured_text(value: f64, std: f64) -> String {
    let (value, std) = measured(value, std);
    format!("{value} +- {std}")
}

/// A value with its standard error, both to the error's second digit; the value alone to four decimals where there is no error.
pub fn estimate_text(value: f64, std: f64) -> String {
    if !(std.is_finite() && std > 0.0) {
        return Fixed(value, 4).to_string();
    }
    let places = (1.0 - libm::floor(libm::log10(std))).clamp(0.0, 9.0) as usize;
    format!("{} +- {}", Fixed(value, places), Fixed(std, places))
}

/// A value with its standard error, to the error's two leading digits, at most four decimals.
pub fn short_measured_text(one: Measured) -> String {
    let places = if one.std > 0.0 && one.std.is_finite() { 1 - libm::floor(libm::log10(one.std)) as i32 } else { 3 };
    let places = usize::try_from(places.clamp(0, 4)).unwrap_or(0);
    format!("{} +- {}", Fixed(one.value, places), Fixed(one.std, places))
}

/// Decimals that show `digits` significant digits of a number of that size, at most `most`.
pub fn decimals(size: f64, digits: u8, most: u8) -> usize {
    (f64::from(digits) - 1.0 - libm::floor(libm::log10(size))).clamp(0.0, f64::from(most)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_that_many_digits() {
        let cases = [
            (0.0, "0.00"),
            (1.814_9, "1.81"),
            (-0.087_26, "-0.0873"),
            (0.000_123_4, "0.000123"),
            (12_345.6, "12346"),
            (0.000_012_34, "1.23e-5"),
            (9.0e7, "9.00e7"),
            (f64::NAN, "-"),
            (f64::NEG_INFINITY, "-"),
        ];
        for (value, text) in cases {
            assert_eq!(Digits(value, 3).to_string(), text);
        }
    }

    #[test]
    fn a_table_has_a_word_where_there_is_no_number_and_no_row_of_digits() {
        let cases = [(1.25, "  1.2"), (-1e300, "-1.00e300"), (f64::NAN, " none"), (f64::INFINITY, "infinite"), (9e6, "9.00e6")];
        for (value, text) in cases {
            assert_eq!(format!("{:>5}", Fixed(value, 1)), text);
        }
        assert_eq!(
            format!("{:+} {:+} {:<6}|", Fixed(1.0, 2), Fixed(-1.0, 2), Fixed(f64::NEG_INFINITY, 2)),
            "+1.00 -1.00 -infinite|"
        );
        assert_eq!(format!("{} {:+} {}", Fixed(-0.004, 2), Fixed(-0.004, 2), Digits(-0.0, 3)), "0.00 +0.00 0.00");
        assert_eq!((estimate_text(1e300, f64::NAN), estimate_text(f64::NAN, 0.1)), ("1.00e300".into(), "none +- 0.10".into()));
        assert_eq!(short_measured_text(Measured { value: 1e200, std: f64::INFINITY }), "1.00e200 +- infinite");
    }

    #[test]
    fn an_error_has_two_digits_and_sets_those_of_its_number() {
        let cases = [
            (1.8349, 0.0123, "1.835", "0.012"),
            (-0.5, 0.099_7, "-0.50", "0.10"),
            (12_345.6, 250.0, "12346", "250"),
            (3.0, f64::NAN, "3.000", "-"),
            (2.0, 0.0, "2.000", "0.0"),
        ];
        for (value, std, shown, error) in cases {
            assert_eq!(measured(value, std), (shown.to_owned(), error.to_owned()));
        }
    }
}
