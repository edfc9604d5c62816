//! `simulate`, `linearise`, `design` and `inspect`: models flown, trimmed, and what recordings hold.

use super::case::Case;
use super::flights::{BUNDLED, LINEAR};
use super::log::Whole;

/// A condition of the built-in Level-1 model.
const CLIMB: &str = "--model puma --speed 51.44 --climb 5.08 --density 1.024";

/// A linear model: test inputs with noise, recorded controls without, an effect on an instrument and one in the controls.
pub(crate) fn linear(case: &mut Case) {
    let noisy = "--rate 50 --noise flight --seed 1 --duration 10";
    case.run(&format!(
        "simulate --model {LINEAR} {noisy} --input pedal:3211:0.02:0.7 --input lat_cyclic:doublet:0.01:1:6 --out a.csv"
    ));
    case.table("a.csv", true);
    case.run(&format!("simulate --model {LINEAR} --controls {BUNDLED} --out driven.csv"));
    case.table("driven.csv", true);
    case.run(&format!("simulate --model {LINEAR} {noisy} --turbulence 1 --input pedal:step:0.01:3 --out gusty.tlog"));
    case.bytes("gusty.tlog");
    let effects = "[[effect]]\nkind = \"sensor_delay\"\nchannel = \"r\"\ndelay = 0.12\n\n[[effect]]\nkind = \"actuator_lag\"\n\
                   control = \"pedal\"\ntau = 0.08\n";
    let model = std::fs::read_to_string(crate::support::program::own(LINEAR)).unwrap();
    std::fs::write(case.folder.join("effects.toml"), format!("{model}\n{effects}")).unwrap();
    case.run(&format!("simulate --model effects.toml {noisy} --input pedal:3211:0.02:0.7 --out effects.csv"));
    case.table("effects.csv", true);
}

/// The Level-1 model: its options, a pilot, gusts, and instruments by a file.
pub(crate) fn level1(case: &mut Case) {
    case.run("simulate --model puma --duration 8 --input pedal:doublet:0.02:1.0 --out plain.csv");
    case.table("plain.csv", true);
    case.run(&format!(
        "simulate {CLIMB} --set hub=exact --set flapping=first_order --set actuators=first_order --input pedal:prbs4:0.01:0.5 \
         --pilot attitude --turbulence 1 --instruments replay/instruments/flight-test.toml --seed 6 --duration 12 --out full.mcap"
    ));
    case.log("full.mcap", Whole::Ends);
    case.run(
        "simulate --model puma --set flapping=second_order --set inflow=dynamic --set rotor_speed=governed --duration 6 \
         --input collective:doublet:0.02:1.0 --noise 0.5 --seed 3 --out governed.csv",
    );
    case.table("governed.csv", true);
}

/// Level-1 models with options and at conditions, and a linear file.
pub(crate) fn linearise(case: &mut Case) {
    for (call, answer) in [
        (format!("{CLIMB} --set hub=exact"), "climb.json"),
        ("--model puma --set perturbation=small --set main_rotor.shaft_tilt=0.07".to_owned(), "level.json"),
        ("--model puma --speed 41 --sideslip 0.05 --set rotor_speed=governed --set inflow=dynamic".to_owned(), "slip.json"),
        (format!("--model {LINEAR}"), "linear.json"),
    ] {
        case.run(&format!("linearise {call} --json {answer}"));
        if case.folder.join(answer).is_file() {
            case.json(answer);
        }
    }
}

/// Spectra and standard errors of inputs, the best sequence.
pub(crate) fn design(case: &mut Case) {
    case.run(&format!(
        "design --model {LINEAR} --control pedal --derivatives N_v,N_p,N_r --limit phi=0.2 --longest 5 --clocks 0.5,0.7 --duration 12 \
         --svg inputs.svg --json answer.json"
    ));
    case.json("answer.json");
    case.drawing("inputs.svg");
    case.run(&format!("design {CLIMB} --control lon_cyclic --criterion logdet --longest 4 --duration 10 --json level1.json"));
    case.json("level1.json");
}

/// Recordings of each format.
pub(crate) fn inspect(case: &mut Case) {
    case.fly(LINEAR, 7, "pedal:3211:0.02:0.7", "flight.tlog");
    case.prepare(&format!(
        "simulate {CLIMB} --set hub=exact --input pedal:doublet:0.01:0.8 --instruments replay/instruments/flight-test.toml --seed 6 \
         --duration 8 --out flight.mcap"
    ));
    for (recording, answer) in [(BUNDLED, "csv.json"), ("flight.tlog", "tlog.json"), ("flight.mcap", "mcap.json")] {
        case.run(&format!("inspect {recording} --json {answer}"));
        case.json(answer);
    }
}
