//! `diagnose`: a hidden effect found by a linear model, and by the Level-1 model.

use super::case::Case;
use super::flights::LINEAR;

/// A wrong derivative; what is extended, drawn and measured on the hold-out.
pub(crate) fn linear(case: &mut Case) {
    case.altered_model("r = -0.66163", "r = -0.5", "wrong.toml");
    case.fly("wrong.toml", 11, "pedal:3211:0.02:0.7", "a.csv");
    case.fly("wrong.toml", 12, "lat_cyclic:3211:0.008:0.5 pedal:doublet:0.015:1.0:8", "b.csv");
    case.fly("wrong.toml", 13, "pedal:doublet:0.02:1.0 lat_cyclic:doublet:0.01:0.8:7", "h.csv");
    case.run(&format!(
        "diagnose --model {LINEAR} --fit a.csv b.csv --holdout h.csv --json answer.json --extended extended.toml --html page.html"
    ));
    case.json_within("answer.json", 13_000);
    case.keys("extended.toml");
    case.drawing("page.html");
    // Nothing is wrong where the runs are the model's own.
    case.fly(LINEAR, 14, "pedal:3211:0.02:0.7", "healthy.csv");
    case.run(&format!("diagnose --model {LINEAR} --fit healthy.csv --json healthy.json"));
    case.json("healthy.json");
}

/// The Level-1 model trimmed at the runs' condition, held against runs of a helicopter whose actuators lag.
pub(crate) fn level1(case: &mut Case) {
    let flight =
        "simulate --model puma --speed 51.44 --density 1.024 --set actuators=first_order --noise flight --rate 50 --duration 12";
    case.prepare(&format!("{flight} --input pedal:3211:0.01:0.7 --seed 1 --out a.csv"));
    case.prepare(&format!("{flight} --input pedal:doublet:0.01:0.8 --seed 2 --out h.csv"));
    case.run("diagnose --model puma --density 1.024 --fit a.csv --holdout h.csv --causes 1 --json answer.json --extended extended.toml");
    case.json("answer.json");
    case.keys("extended.toml");
}
