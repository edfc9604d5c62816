//! `--domain frequency`: the same form of answer, from a band; measured responses beside it.

use crate::support::program::{ended, folder, own, path, puma, real, sideslip};
use serde_json::Value;
use std::path::Path;

fn in_band(file: &Path, more: &[&str]) -> Value {
    let args = [&["identify", path(file), "--domain", "frequency", "--json", "-"], more].concat();
    let (status, out, said) = ended(&sideslip(&args));
    assert_eq!(status, 0, "{said}");
    assert!(said.contains("Measured frequency responses"), "{said}");
    serde_json::from_str(&out).unwrap()
}

/// A derivative of the run's own equation with its standard error.
fn term(answer: &Value, name: &str) -> (f64, f64) {
    let terms = answer["runs"][0]["equations"][&name[..1]]["terms"].as_array().unwrap();
    let found = terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{name} in {terms:?}"));
    (found["value"].as_f64().unwrap(), found["std"].as_f64().unwrap())
}

/// By output error over the same run.
fn by_output_error(answer: &Value, name: &str) -> (f64, f64) {
    let parameters = answer["output_error"]["parameters"].as_array().unwrap();
    let found = parameters.iter().find(|one| one["name"] == name).unwrap();
    (found["value"].as_f64().unwrap(), found["std"].as_f64().unwrap())
}

fn responses<'a>(answer: &'a Value, output: &str, input: &str) -> &'a Value {
    let all = answer["frequency_responses"].as_array().unwrap();
    all.iter().find(|one| one["output"] == output && one["input"] == input).unwrap()
}

#[test]
fn the_attas_rudder_run_has_its_rudder_in_the_band() {
    let Some(file) = real("attas-rud1.csv") else { return };
    let out = folder("identify-frequency");
    let more = ["--states", "beta,p,phi,r", "--inputs", "aileron,rudder", "--set", "vane_position_m=[13.08,0,0]"];
    let answer = in_band(&file, &[&more[..], &["--band", "0.1:1.2", "--out", path(&out)]].concat());
    assert_eq!((&answer["domain"], &answer["band"]["to_hz"]), (&"frequency".into(), &1.2.into()));
    assert_eq!(answer["runs"][0]["domain"], "frequency");
    for (name, published) in [("N_rudder", -1.761), ("L_rudder", 1.145), ("L_p", -2.067)] {
        let (value, std) = term(&answer, name);
        eprintln!("{name} {value:.3} +- {std:.3}, published {published}");
        assert!((value - published).abs() < (4.0 * std).max(0.1 * f64::abs(published)), "{name} {value} +- {std}");
    }
    let yaw = responses(&answer, "r", "rudder")["points"].as_array().unwrap();
    let coherence: Vec<f64> = yaw.iter().map(|point| point["coherence"].as_f64().unwrap()).collect();
    assert!(coherence.iter().all(|c| (0.0..=1.0).contains(c)) && coherence.iter().any(|c| *c > 0.9), "{coherence:?}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("measured frequency responses") && page.contains("coherence"));
}

#[test]
fn the_attas_elevator_run_has_in_the_band_what_output_error_finds() {
    let Some(file) = real("attas-elv1.csv") else { return };
    let more = ["--states", "alpha,q", "--inputs", "elevator", "--set", "vane_position_m=[13.08,0,0]"];
    let answer = in_band(&file, &more);
    for name in ["M_q", "M_elevator"] {
        let ((one, one_std), (other, other_std)) = (term(&answer, name), by_output_error(&answer, name));
        eprintln!("{name}: band {one:.3} +- {one_std:.3}, output error {other:.3} +- {other_std:.3}");
        assert!((one - other).abs() < 3.0 * one_std.hypot(other_std), "{name}: {one} +- {one_std}, {other} +- {other_std}");
    }
}

/// A flight whose derivatives are known to every digit.
#[test]
fn a_simulated_flight_comes_back_from_the_band() {
    let (folder, model) = (folder("identify-frequency-simulated"), own("replay/models/puma-like.toml"));
    let file = folder.join("run.csv");
    let call =
        ["simulate", "--model", path(&model), "--input", "pedal:3211:0.01:0.7", "--noise", "--seed", "2", "--out", path(&file)];
    assert_eq!(ended(&sideslip(&call)).0, 0);
    let (_, text, _) = ended(&sideslip(&["linearise", "--model", path(&model), "--json", "-"]));
    let truth: Value = serde_json::from_str(&text).unwrap();
    let answer = in_band(&file, &["--states", "v,p,phi,r", "--inputs", "pedal"]);
    for name in ["N_v", "N_p", "N_r", "N_pedal", "L_v", "L_p"] {
        let (value, std) = term(&answer, name);
        let exact = truth["derivatives"][&name[..1]][&name[2..]].as_f64().unwrap();
        assert!((value - exact).abs() < 4.0 * std && (value / exact - 1.0).abs() < 0.1, "{name} {value} +- {std}, {exact}");
    }
    assert_eq!(answer["modes"]["dutch_roll"].is_object(), answer["output_error"]["converged"] == true);
}

#[test]
fn a_band_that_is_none_is_refused_with_a_line() {
    let file = puma();
    let wrong: [&[&str]; 4] = [
        &["--band", "0.1:1.2"],
        &["--domain", "frequency", "--band", "2:1"],
        &["--domain", "frequency", "--band", "1"],
        &["--domain", "frequency", "--band", "0.1:20"],
    ];
    for more in wrong {
        let (status, out, said) = ended(&sideslip(&[&["identify", path(&file)], more].concat()));
        assert!(status == 2 && out.is_empty() && said.contains("--band"), "{more:?}: {status} {said}");
    }
}
