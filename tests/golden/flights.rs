//! Flights that cases simulate with fixed seeds, 14 s at 50 Hz, and models that differ a little.

use super::case::Case;
use crate::support::program::own;

/// The bundled recording.
pub(crate) const BUNDLED: &str = "replay/recordings/puma-100kn-pedal-3211.csv";
/// The bundled linear model.
pub(crate) const LINEAR: &str = "replay/models/puma-like.toml";

impl Case {
    /// A flight of a linear model with instruments of flight-test quality, written as `name`.
    pub(crate) fn fly(&self, model: &str, seed: u32, inputs: &str, name: &str) {
        let inputs: String = inputs.split_whitespace().map(|input| format!(" --input {input}")).collect();
        self.prepare(&format!(
            "simulate --model {model} --rate 50 --noise flight --seed {seed} --duration 14{inputs} --out {name}"
        ));
    }

    /// Pedal, lateral and longitudinal flights of the bundled model, and one to be predicted: `a.csv b.csv c.csv h.csv`.
    pub(crate) fn fly_four(&self) {
        self.fly(LINEAR, 1, "pedal:3211:0.02:0.7", "a.csv");
        self.fly(LINEAR, 2, "lat_cyclic:doublet:0.012:0.8 pedal:doublet:0.015:1.0:8", "b.csv");
        self.fly(LINEAR, 3, "lon_cyclic:3211:0.012:0.7 collective:doublet:0.02:1:9", "c.csv");
        self.fly(LINEAR, 4, "pedal:doublet:0.02:0.9 lat_cyclic:3211:0.008:0.5:7", "h.csv");
    }

    /// The bundled model with one derivative altered, as `name`.
    pub(crate) fn altered_model(&self, before: &str, after: &str, name: &str) {
        let text = std::fs::read_to_string(own(LINEAR)).unwrap();
        assert_eq!(text.matches(before).count(), 1, "{before}");
        std::fs::write(self.folder.join(name), text.replace(before, after)).unwrap();
    }
}
