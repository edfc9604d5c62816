//! Every real recording through the real-time pipeline: what is reported agrees with what is published, and where nothing
//! trustworthy is known the answer is wide or none.
//!
//! Published values, with what is known of their own errors, are those listed beside the recordings: output error of the ATTAS'
//! four lateral states and of its short period, stepwise regression of the Twin Otter's pitching moment.

use crate::support::program::{real, replayed};
use serde_json::Value;

const ATTAS_DUTCH_ROLL: [(&str, f64, f64); 2] = [("omega", 1.81, 0.05), ("zeta", 0.088, 0.01)];
const ATTAS_SHORT_PERIOD: [(&str, f64, f64); 2] = [("omega", 2.53, 0.05), ("zeta", 0.49, 0.02)];

/// The run of a recording as the program reports it.
fn reported(name: &str) -> Option<Value> {
    let file = real(name)?;
    let (status, run, said) = replayed(&file, &[]);
    // 4: nothing could be estimated of it.
    assert!(status == 0 || status == 4, "{name}: {said}");
    Some(run)
}

/// Numbers of a mode in standard errors from the published ones, which have a tolerance of their own.
fn scores(mode: &Value, published: &[(&str, f64, f64)]) -> Vec<f64> {
    let score = |&(key, value, within): &(&str, f64, f64)| {
        let number = |key: &str| mode[key].as_f64();
        let (found, std) = (number(key)?, number(&format!("std_{key}"))?);
        Some((found - value) / std.hypot(within))
    };
    published.iter().filter_map(score).collect()
}

/// Terms of an equation with a number, biases left out: value over standard error.
fn terms(equation: &Value) -> Vec<(String, f64)> {
    let terms = equation["terms"].as_array().into_iter().flatten();
    let known = terms.map(|term| {
        let ratio = term["value"].as_f64().unwrap() / term["std"].as_f64().unwrap();
        (term["name"].as_str().unwrap().to_owned(), ratio)
    });
    known.filter(|(name, _)| !name.ends_with("_0")).collect()
}

#[test]
fn modes_of_the_attas_are_the_published_ones_or_wide() {
    for name in ["attas-rud1.csv", "attas-ail1.csv", "attas-elv1.csv"] {
        let Some(run) = reported(name) else { return };
        let (regression, output_error) = (&run["modes"], &run["output_error"]["modes"]);
        for (source, modes) in [("regression", regression), ("output error", output_error)] {
            for (mode, published) in [("dutch_roll", ATTAS_DUTCH_ROLL), ("short_period", ATTAS_SHORT_PERIOD)] {
                let scores = scores(&modes[mode], &published);
                eprintln!("{name}, {mode} by {source}: {scores:.1?} standard errors from the published one");
                assert!(scores.iter().all(|score| score.abs() < 3.0), "{name}, {mode} by {source}: {}", modes[mode]);
            }
        }
        let (moved, silent) = if name == "attas-elv1.csv" { ("short_period", "dutch_roll") } else { ("dutch_roll", "") };
        assert!(output_error[moved].is_object(), "{name}: {output_error}");
        assert!(output_error[silent].is_null(), "{name} moves the other plane: {output_error}");
    }
}

#[test]
fn recordings_without_sideslip_have_no_lateral_numbers() {
    for name in [
        "citation-2018-dutchroll.csv",
        "citation-2018-dutchroll-yawdamper.csv",
        "citation-2018-aperiodic-roll.csv",
        "citation-2018-short-period.csv",
        "citation-2019-dutchroll.csv",
        "citation-2019-dutchroll-yawdamper.csv",
    ] {
        let Some(run) = reported(name) else { return };
        assert!(run["modes"]["dutch_roll"].is_null() && run["output_error"]["modes"]["dutch_roll"].is_null(), "{name}");
        for axis in ["Y", "L", "N"] {
            assert_eq!(terms(&run["equations"][axis]), [], "{name}, {axis}");
        }
    }
}

#[test]
fn nothing_is_settled_where_no_linear_model_holds() {
    // Stall, flight test with an active control system, and light turbulence without lateral inputs.
    for name in ["attas-stall-1.csv", "harv-lon-250h.csv", "hfb320.csv"] {
        let Some(run) = reported(name) else { return };
        for axis in ["X", "Y", "Z", "L", "M", "N"] {
            assert_ne!(run["equations"][axis]["status"], "converged", "{name}, {axis}");
        }
        let known = |pair: &Value| pair["omega"].as_f64() > pair["std_omega"].as_f64().map(|std| 20.0 * std);
        for modes in [&run["modes"], &run["output_error"]["modes"]] {
            assert!(!known(&modes["dutch_roll"]), "{name}: {}", modes["dutch_roll"]);
        }
    }
}

#[test]
fn commands_in_counts_and_held_air_data_have_no_number() {
    for manoeuvre in ["ail-1", "ail-2", "ail-3", "ail-4", "el-1", "el-2", "el-3", "el-4", "rud-1"] {
        let name = format!("uav-2022-{manoeuvre}.csv");
        let Some(run) = reported(&name) else { return };
        for axis in ["X", "Y", "Z", "L", "M", "N"] {
            assert_eq!(terms(&run["equations"][axis]), [], "{name}, {axis}");
        }
        assert!(run["output_error"]["modes"].as_object().is_none_or(|modes| modes.values().all(Value::is_null)), "{name}");
    }
}

#[test]
fn pitch_of_the_twin_otter_is_that_of_the_published_regression() {
    // Cm of alpha, qhat, elevator = -1.476, -36.35, -1.869 with errors of 1.5, 1.9 and 1.1 %; the ratios of the derivatives
    // need neither inertia nor dynamic pressure: M_elevator/(V M_w) = 1.266, and V is that of the run.
    for name in ["twin-otter-020213f1_018.csv", "twin-otter-020213f1_019.csv"] {
        let Some(run) = reported(name) else { return };
        let speed = mean_airspeed(name);
        let (w, w_std) = term(&run, "M_w");
        let (elevator, elevator_std) = term(&run, "M_elevator");
        let ratio = elevator / (speed * w);
        let std = ratio.abs() * (w_std / w).hypot(elevator_std / elevator).hypot(0.02);
        eprintln!("{name}: M_elevator/M_alpha {ratio:.3} +- {std:.3}, published 1.266");
        assert!((ratio - 1.266).abs() < 3.0 * std, "{name}: {ratio} +- {std}");
        assert!(run["modes"]["dutch_roll"].is_null(), "{name}: nothing moved sideways");
    }
}

fn term(run: &Value, name: &str) -> (f64, f64) {
    let terms = run["equations"]["M"]["terms"].as_array().unwrap();
    let term = terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{name} in {terms:?}"));
    (term["value"].as_f64().unwrap(), term["std"].as_f64().unwrap())
}

/// Mean airspeed of a recording in ft/s, m/s.
fn mean_airspeed(name: &str) -> f64 {
    let table = crate::support::program::RunFile::read(&real(name).unwrap());
    let place = table.place("tas[ft/s]");
    let values: Vec<f64> = table.rows.iter().filter_map(|row| row[place].parse().ok()).collect();
    0.3048 * values.iter().sum::<f64>() / values.len() as f64
}
