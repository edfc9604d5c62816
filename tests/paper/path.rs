//! Section 4 in one call: descent, level and climb as test points, beside the Level-1 Puma trimmed at each.

use super::flown::{flights, flown_by, identified};
use crate::support::asked::seeds;
use crate::support::paper_cases::{DENSITY, PAPER, PaperCase, SPEED};
use crate::support::program::{ended, folder, path, sideslip};
use serde_json::Value;
use sideslip::flight::derivative::{Axis, Variable};
use std::path::{Path, PathBuf};

/// The paper's HELISTAB: Dutch roll and N_p.
const HELISTAB: [((f64, f64), f64); 3] = [((-0.106, 0.90), -0.227), ((-0.057, 0.94), -0.21), ((-0.037, 0.94), -0.19)];

const MODEL: [&str; 5] = ["--states", "v,p,phi,r", "--outputs", "beta,p,phi,r,ay", "--doubt-instruments"];

fn derivative<'a>(point: &'a Value, name: &str) -> &'a Value {
    let all = point["derivatives"].as_array().unwrap();
    all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name} in {all:?}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
#[ignore = "a study"]
fn three_paths_are_three_test_points_beside_the_simulation() {
    let folder = folder("paper-path");
    let runs: Vec<PathBuf> = PAPER.iter().flat_map(|case| flights(&folder, case, 3)).collect();
    let (density, out) = (DENSITY.to_string(), folder.join("out"));
    let mut more = MODEL.to_vec();
    more.extend(["--model", "puma", "--density", &density, "--out", path(&out)]);
    let answer = identified(&runs, &more);
    let points = answer["test_points"].as_array().unwrap();
    assert_eq!(points.len(), 3);
    for ((point, case), (helistab, n_p)) in points.iter().zip(PAPER).zip(HELISTAB) {
        let nominal = (case.climb / SPEED).asin().to_degrees();
        assert!((number(&point["path_deg"]) - nominal).abs() < 0.5, "{}", point["path_deg"]);
        let whole = &point["simulation"]["dutch_roll"];
        let (real, imag) = (number(&whole["real"]), number(&whole["imag"]));
        assert!((real - helistab.0).abs() < 0.03 && (imag - helistab.1).abs() < 0.05, "{}: {whole}", case.name);
        assert!((number(&derivative(point, "N_p")["simulation"]) - n_p).abs() < 0.01);
        let pair = &point["modes"]["dutch_roll"];
        let off = [("real", case.root.0), ("imag", case.root.1)]
            .map(|(part, known)| (number(&pair[part]) - known) / number(&pair[format!("std_{part}")]));
        let one = &point["effective_damping"];
        eprintln!("{}: roots off by {off:.2?} s.e.; {one}", case.name);
        // Both derived N_p are adverse yaw, and the new subsystem is nearer to the flight's frequency than the simulation is.
        let derived = [number(&one["n_p_by_26"]["value"]), number(&one["n_p_at_omega"]["value"])];
        assert!(derived.into_iter().all(|n_p| (-0.6..-0.05).contains(&n_p)), "{derived:?}");
        let moved = number(&one["new_subsystem_at_omega"]["imag"]);
        assert!((moved - case.root.1).abs() < (imag - case.root.1).abs(), "{moved}");
        // (26) has not all the damping: it leaves out Y_v and omega beside L_p.
        let (by_26, twice) = (number(&one["n_r_by_26"]), 2.0 * case.root.0);
        assert!(by_26 > twice, "{by_26} {twice}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(["N_v", "N_p", "L_p", "flight-path angle, deg", "Dutch roll: real part"].into_iter().all(|text| page.contains(text)));
    // The model of every test point is flown.
    for case in PAPER {
        let model = out.join(format!("model-{}-pedal-3.toml", case.name));
        let (status, text, said) = ended(&sideslip(&["linearise", "--model", path(&model), "--json", "-"]));
        assert_eq!(status, 0, "{said}");
        let written: Value = serde_json::from_str(&text).unwrap();
        let point = answer["test_points"].as_array().unwrap().iter().find(|point| {
            let value = number(&derivative(point, "N_r")["value"]);
            (number(&written["derivatives"]["N"]["r"]) - value).abs() < 1e-3 * value.abs()
        });
        assert!(point.is_some(), "{}: {written}", case.name);
    }
    // The long form: linear models have their own trims, and each test point takes the nearest.
    if seeds(0) == 0 {
        return;
    }
    let files = PAPER.map(|case| folder.join(format!("{}.toml", case.name)));
    let mut more = MODEL.to_vec();
    more.extend(files.iter().flat_map(|file| ["--model", path(file)]));
    for (point, case) in identified(&runs, &more)["test_points"].as_array().unwrap().iter().zip(PAPER) {
        let n_v = number(&derivative(point, "N_v")["simulation"]);
        assert!((n_v - case.model().derivative(Axis::N, Variable::V)).abs() < 1e-4, "{}: {n_v}", case.name);
        assert!((number(&point["simulation"]["dutch_roll_lateral"]["imag"]) - case.root.1).abs() < 1e-3);
    }
}

/// Behind a slow actuator the pedal is late and N_pedal too small; the tail pitch is what the tail rotor has.
#[test]
fn the_measured_tail_pitch_gives_back_what_the_actuator_took() {
    let folder = folder("paper-tail-pitch");
    let case: PaperCase = PAPER[1];
    let lag = "\n[[effect]]\nkind = \"actuator_lag\"\ncontrol = \"pedal\"\ntau = 0.15\n";
    let runs = flown_by(&folder, &case, &format!("{}{lag}", case.model_file()), 1);
    let answer = identified(&runs, &[&MODEL[..4], &["--model", "puma", "--density", "1.024"]].concat());
    let point = &answer["test_points"][0];
    let n_pedal = derivative(point, "N_pedal");
    let (by_pedal, by_tail) = (number(&n_pedal["value"]), number(&n_pedal["by_tail_pitch"]["value"]));
    let known = case.pedal[2];
    eprintln!("N_pedal {known}: by pedal {by_pedal:.3}, by tail pitch {by_tail:.3}");
    assert!((by_tail / known - 1.0).abs() < 0.02 && (by_pedal / known - 1.0).abs() > 0.03, "{n_pedal}");
}

/// A Level-1 flight trimmed at a sideslip, without input.
fn held(folder: &Path, sideslip_rad: f64) -> PathBuf {
    let file = folder.join(format!("held{sideslip_rad}.csv"));
    let (sideslip_rad, density) = (sideslip_rad.to_string(), DENSITY.to_string());
    let call = ["simulate", "--model", "puma", "--speed", "51.44", "--density", &density, "--sideslip", &sideslip_rad];
    let rest = ["--input", "pedal:step:0.00001:1", "--duration", "6", "--noise", "--out", path(&file)];
    let (status, _, said) = ended(&sideslip(&[&call[..], &rest[..]].concat()));
    assert_eq!(status, 0, "{said}");
    file
}

#[test]
fn steady_heading_sideslips_have_the_static_derivatives() {
    let folder = folder("paper-sideslips");
    let density = DENSITY.to_string();
    let runs: Vec<PathBuf> = ["pedal:3211:0.01:0.7", "lat_cyclic:3211:0.006:0.6"]
        .into_iter()
        .enumerate()
        .map(|(place, input)| {
            let (file, seed) = (folder.join(format!("moved{place}.csv")), place.to_string());
            let call = ["simulate", "--model", "puma", "--speed", "51.44", "--density", &density, "--input", input, "--noise"];
            let (status, _, said) = ended(&sideslip(&[&call[..], &["--seed", &seed, "--out", path(&file)]].concat()));
            assert_eq!(status, 0, "{said}");
            file
        })
        .collect();
    let slips: Vec<PathBuf> = [-0.09, -0.06, -0.03, 0.0, 0.03, 0.06, 0.09].iter().map(|&beta| held(&folder, beta)).collect();
    // Pitch and speed are coupled in: as inputs they keep out of the control derivatives.
    let inputs = ["--inputs", "lat_cyclic,pedal,q,alpha"];
    let mut more = vec!["--states", "v,p,phi,r", "--outputs", "beta,p,phi,r,ay", "--model", "puma", "--density", &density];
    more.extend(inputs);
    more.extend(slips.iter().flat_map(|file| ["--sideslips", path(file)]));
    let answer = identified(&runs, &more);
    let point = &answer["test_points"][0];
    let found = &point["steady_sideslips"];
    let slopes = found["slopes"].as_array().unwrap();
    for axis in ["N", "L"] {
        let name = format!("{axis}_v");
        let (value, std) = (number(&found[&name]["value"]), number(&found[&name]["std"]));
        let control = |slope: &Value| format!("{axis}_{}", slope["control"].as_str().unwrap());
        let known: f64 =
            slopes.iter().map(|slope| -number(&derivative(point, &control(slope))["simulation"]) * number(&slope["slope"])).sum();
        let small = number(&derivative(point, &name)["simulation"]);
        eprintln!("{name}: {value:.5} +- {std:.5}; {known:.5} with the simulation's controls, {small:.5} of small motions");
        assert!((value - known).abs() < 3.0 * std && std < 0.3 * value.abs(), "{name}: {found}");
        // The fin is dead at small sideslips: over nine degrees the yaw stiffness is more than about none, as the paper found.
        assert!(axis == "L" || known > 1.15 * small, "{known} {small}");
    }
    // Not of this test point.
    let other = folder.join("fast.csv");
    let call = ["simulate", "--model", "puma", "--speed", "70", "--input", "pedal:doublet:0.01:1", "--out", path(&other)];
    assert_eq!(ended(&sideslip(&call)).0, 0);
    let (status, _, said) = ended(&sideslip(&["identify", path(&runs[0]), "--sideslips", path(&other)]));
    assert!(status == 2 && said.contains("--sideslips: `fast` was flown at 70"), "{said}");
}
