//! The same cases off the model's trim, as every flight is: controls by up to 3 mrad, attitude and flow by up to 4 mrad, u by
//! up to 1 m/s. The aircraft flies in its own trim, so that the forces of both balance.

use super::case::{Case, Sort, drawn};
use super::draw::stream;
use crate::support::uniform::Uniform;
use toml::{Table, Value};

/// Largest differences: m/s of u, m/s of v and w, rad of attitude, rad of controls, rad/s of the rotor.
const SPEED: f64 = 1.0;
const FLOW: f64 = 0.2;
const ATTITUDE: f64 = 0.004;
const CONTROL: f64 = 0.003;
const ROTOR: f64 = 0.05;

/// The case of that sort and seed, its model in another trim; `None` where nothing that is drawn is to be seen.
pub(crate) fn drawn_off_trim(sort: Sort, seed: u64) -> Option<Case> {
    let case = drawn(sort, seed)?;
    Some(Case { model_text: off_trim(&case.model_text, seed), ..case })
}

/// That model in another trim, which the seed draws.
pub(crate) fn off_trim(model_text: &str, seed: u64) -> String {
    let mut uniform = Uniform(stream(seed, 7));
    let mut file: Table = model_text.parse().unwrap();
    let trim = file["trim"].as_table_mut().unwrap();
    let mut shift = |table: &mut Table, key: &str, most: f64| {
        let at_trim = table[key].as_float().unwrap();
        table.insert(key.to_owned(), Value::Float(at_trim + uniform.within(most)));
    };
    for (key, most) in [("u", SPEED), ("v", FLOW), ("w", FLOW), ("phi", ATTITUDE), ("theta", ATTITUDE), ("rotor_speed", ROTOR)] {
        shift(trim, key, most);
    }
    let controls = trim["controls"].as_table_mut().unwrap();
    for key in ["collective", "lon_cyclic", "lat_cyclic", "pedal"] {
        shift(controls, key, CONTROL);
    }
    toml::to_string(&file).unwrap()
}
