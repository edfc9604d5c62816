//! A measured number with its standard error.

use crate::postflight::manoeuvres::record::Measured;

/// A number with its error, to the error's two leading digits.
pub(crate) fn shown(one: Measured) -> String {
    let places = if one.std > 0.0 && one.std.is_finite() { 1 - libm::floor(libm::log10(one.std)) as i32 } else { 3 };
    let places = usize::try_from(places.clamp(0, 4)).unwrap_or(0);
    format!("{:.places$} +- {:.places$}", one.value, one.std)
}
