//! Units and multipliers of fields: the tables that UNIT and MULT messages fill, looked up by the letters of an FMTU.
//!
//! Consumes identifiers (one byte each) with a label or a multiplier; produces the unit and the scale of a field.
//! value = number * multiplier, in the unit named. A MULT of zero or the identifiers `-` (none) and `?` (not known) leave the
//! scale that the format character implies; any other takes its place, since multipliers apply to the raw number.
//! Source: ArduPilot, AP_Logger, README, "Units", "Multipliers".

use super::field::DataflashScale;

/// Longest label that is kept, bytes: that of the format character Z.
const LABEL_MAX: usize = 64;

/// Labels and multipliers by their identifier.
#[derive(Clone, Debug)]
pub struct DataflashUnits {
    labels: Vec<Option<Box<str>>>,
    scales: Vec<Option<DataflashScale>>,
}

impl Default for DataflashUnits {
    fn default() -> Self {
        DataflashUnits { labels: vec![None; 256], scales: vec![None; 256] }
    }
}

impl DataflashUnits {
    /// A label from a UNIT message.
    pub fn set_label(&mut self, id: u8, label: &[u8]) {
        let text = String::from_utf8_lossy(label.get(..LABEL_MAX).unwrap_or(label));
        if let Some(place) = self.labels.get_mut(usize::from(id)) {
            *place = Some(text.into());
        }
    }

    /// A multiplier from a MULT message.
    pub fn set_multiplier(&mut self, id: u8, multiplier: f64) {
        if let Some(place) = self.scales.get_mut(usize::from(id)) {
            *place = DataflashScale::of_multiplier(multiplier);
        }
    }

    /// The unit of that identifier; `None` where it has none or none is known.
    pub fn label(&self, id: u8) -> Option<&str> {
        self.labels.get(usize::from(id))?.as_deref().filter(|label| !label.is_empty() && *label != "UNKNOWN")
    }

    /// The scale of that identifier, where it states one.
    pub fn scale(&self, id: u8) -> Option<DataflashScale> {
        if matches!(id, b'-' | b'?') { None } else { self.scales.get(usize::from(id)).copied().flatten() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_that_say_nothing_have_neither_unit_nor_scale() {
        let mut units = DataflashUnits::default();
        units.set_label(b'k', b"deg/s");
        units.set_label(b'-', b"");
        units.set_label(b'?', b"UNKNOWN");
        units.set_multiplier(b'B', 0.01_f32.into());
        units.set_multiplier(b'-', 0.0);
        units.set_multiplier(b'?', 1.0);
        assert_eq!([b'k', b'-', b'?', b'x'].map(|id| units.label(id)), [Some("deg/s"), None, None, None]);
        assert_eq!([b'B', b'-', b'?', 0].map(|id| units.scale(id)), [Some(DataflashScale::Over(100.0)), None, None, None]);
    }
}
