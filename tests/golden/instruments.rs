//! `check`: one run, and several, of which one has an instrument that is wrong.

use super::case::Case;
use super::flights::{BUNDLED, LINEAR};

/// The bundled recording, four healthy runs, and a run with instruments by a file.
pub(crate) fn check(case: &mut Case) {
    case.run(&format!("check {BUNDLED} --json one.json"));
    case.json("one.json");
    case.fly_four();
    case.run("check a.csv b.csv c.csv h.csv --json several.json");
    case.json("several.json");
    case.prepare(&format!(
        "simulate --model {LINEAR} --input pedal:3211:0.02:0.7 --input lat_cyclic:doublet:0.01:1:7 --seed 6 --duration 14 \
         --instruments replay/instruments/flight-test.toml --out wrong.mcap"
    ));
    case.run("check wrong.mcap --set vane_position_m=[3,0,0] --json wrong.json");
    case.json("wrong.json");
}
