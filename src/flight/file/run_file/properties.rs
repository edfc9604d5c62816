//! The keys `mass_kg`, `inertia_kgm2` and `reference` of a run: what nondimensional derivatives are formed with.
//!
//! Consumes the value of a key; produces kg, kg m^2, m^2, m and m/s. Refused, with what was expected: a number that is not finite
//! or, but for the product of inertia, not more than zero; a table with other keys; moments of inertia of no body
//! (xx zz <= xz^2).

use crate::flight::run::{AircraftProperties, Inertia, ReferenceDimensions};
use toml::{Table, Value};

const INERTIA: &str = "a table {xx, yy, zz, xz} in kg m^2, xx, yy, zz more than zero and xx zz more than xz^2";
const REFERENCE: &str =
    "a table {area_m2, span_m, chord_m} of a wing or {rotor_radius_m, tip_speed_mps} of a rotor, each more than zero";

/// Sets what the key is about; what was expected where its value is wrong.
pub(super) fn set(properties: &mut AircraftProperties, key: &str, value: &Value) -> Result<(), &'static str> {
    match key {
        "mass_kg" => properties.mass_kg = Some(positive(Some(value)).ok_or("a mass in kg, more than zero")?),
        "inertia_kgm2" => properties.inertia = Some(value.as_table().and_then(inertia).ok_or(INERTIA)?),
        _ => properties.reference = Some(value.as_table().and_then(reference).ok_or(REFERENCE)?),
    }
    Ok(())
}

fn number(value: Option<&Value>) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "kilograms and metres: far below 2^53")]
    let number = value.and_then(|value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64)));
    number.filter(|number| number.is_finite())
}

fn positive(value: Option<&Value>) -> Option<f64> {
    number(value).filter(|number| *number > 0.0)
}

/// Whether the table has these keys and no other.
fn has_only(table: &Table, keys: &[&str]) -> bool {
    table.keys().all(|key| keys.contains(&key.as_str()))
}

fn inertia(table: &Table) -> Option<Inertia> {
    let xz = if table.contains_key("xz") { number(table.get("xz"))? } else { 0.0 };
    let [xx, yy, zz] = ["xx", "yy", "zz"].map(|key| positive(table.get(key)));
    let inertia = Inertia { xx: xx?, yy: yy?, zz: zz?, xz };
    (has_only(table, &["xx", "yy", "zz", "xz"]) && inertia.xx * inertia.zz > xz * xz).then_some(inertia)
}

fn reference(table: &Table) -> Option<ReferenceDimensions> {
    let at = |key: &str| positive(table.get(key));
    if has_only(table, &["area_m2", "span_m", "chord_m"]) {
        Some(ReferenceDimensions::Wing { area_m2: at("area_m2")?, span_m: at("span_m")?, chord_m: at("chord_m")? })
    } else if has_only(table, &["rotor_radius_m", "tip_speed_mps"]) {
        Some(ReferenceDimensions::Rotor { radius_m: at("rotor_radius_m")?, tip_speed_mps: at("tip_speed_mps")? })
    } else {
        None
    }
}
