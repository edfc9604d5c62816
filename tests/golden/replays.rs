//! `replay`: the bundled recording through the pipeline, with every output that there is.

use super::case::Case;
use super::flights::{BUNDLED, LINEAR};
use super::log::Whole;

/// Smoothed states, output error at the end of each manoeuvre, log, smoothed file.
pub(crate) fn bundled(case: &mut Case) {
    case.run(&format!("replay {BUNDLED} --json answer.json --out log.mcap --smoothed smoothed.csv"));
    case.json_within("answer.json", 22_000);
    case.log("log.mcap", Whole::Some);
    case.table("smoothed.csv", true);
}

/// Output error twice a second; filtered states.
pub(crate) fn streaming(case: &mut Case) {
    case.fly(LINEAR, 1, "pedal:3211:0.02:0.7", "a.csv");
    case.run("replay a.csv --output-error streaming --states filtered --json answer.json --out log.mcap");
    case.json("answer.json");
    case.log("log.mcap", Whole::Ends);
}

/// Held against a model whose yaw damping is wrong: findings appear, and are refined.
pub(crate) fn with_model(case: &mut Case) {
    case.altered_model("r = -0.66163", "r = -0.5", "other.toml");
    case.fly("other.toml", 11, "pedal:3211:0.02:0.7", "flight.csv");
    case.run(&format!("replay flight.csv --model {LINEAR} --output-error off --json answer.json --out log.mcap"));
    case.json("answer.json");
    case.log("log.mcap", Whole::Ends);
}

/// Through shared memory, from another process.
pub(crate) fn through_shared_memory(case: &mut Case) {
    case.fly(LINEAR, 2, "lat_cyclic:doublet:0.012:0.8 pedal:doublet:0.015:1.0:8", "b.csv");
    case.run("replay b.csv --bus --out log.mcap --smoothed smoothed.mcap");
    case.log("log.mcap", Whole::Ends);
    case.log("smoothed.mcap", Whole::Ends);
}

/// A recording of MAVLink, with a key of the run overridden.
pub(crate) fn mavlink(case: &mut Case) {
    case.fly(LINEAR, 7, "pedal:3211:0.02:0.7", "flight.tlog");
    case.run("replay flight.tlog --set vane_position_m=[1.5,0,0.2] --output-error off --json answer.json --out log.mcap");
    case.json("answer.json");
    case.log("log.mcap", Whole::Ends);
}
