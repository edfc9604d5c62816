//! `compare`: a model on the runs' own controls, another beside it, pictures.

use super::case::Case;
use super::flights::{BUNDLED, LINEAR};

/// A linear model, two of them beside each other, and the Level-1 model.
pub(crate) fn compare(case: &mut Case) {
    case.run(&format!("compare {BUNDLED} --model {LINEAR} --json one.json --svg one.svg"));
    case.json("one.json");
    case.drawing("one.svg");
    case.altered_model("r = -0.66163", "r = -0.5", "other.toml");
    case.fly("other.toml", 12, "pedal:3211:0.02:0.7", "a.csv");
    case.fly("other.toml", 13, "lat_cyclic:doublet:0.012:0.8", "b.csv");
    case.run(&format!("compare a.csv b.csv --model {LINEAR} --beside other.toml --json two.json --out pictures"));
    case.json("two.json");
    case.drawing("pictures/a.svg");
    case.run("compare a.csv --model puma --speed 51.44 --json level1.json");
    case.json("level1.json");
}
