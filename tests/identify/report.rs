//! The report: tables with units, pictures that follow the reader's colours, and nondimensional derivatives by hand.

use crate::support::identified::{derivative, identified};
use crate::support::program::{RunFile, ended, folder, own, path, sideslip};
use serde_json::Value;
use std::path::{Path, PathBuf};

const LATERAL: [&str; 4] = ["--states", "v,p,phi,r", "--inputs", "lat_cyclic,pedal"];
const WING: &str = "reference={area_m2=64,span_m=21.5,chord_m=3.159}";
const MASS: &str = "mass_kg=17631";
const INERTIA: &str = "inertia_kgm2={xx=133367,yy=252687,zz=359593,xz=11442}";
const ROTOR: &str = "reference={rotor_radius_m=7.5,tip_speed_mps=208}";

fn flown(name: &str) -> (PathBuf, [PathBuf; 2]) {
    let (folder, model) = (folder(name), own("replay/models/puma-like.toml"));
    let fly = |input: &str, name: &str, seed: &str| {
        let file = folder.join(name);
        let args = ["--model", path(&model), "--input", input, "--noise", "--seed", seed, "--out", path(&file)];
        let (status, _, said) = ended(&sideslip(&[&["simulate"][..], &args].concat()));
        assert_eq!(status, 0, "{said}");
        file
    };
    let files = [fly("pedal:3211:0.01:0.7", "a.csv", "1"), fly("lat_cyclic:3211:0.01:0.5", "b.csv", "2")];
    (folder, files)
}

fn said(files: &[PathBuf], more: &[&str]) -> Value {
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let (status, answer) = identified(&files, &[&LATERAL[..], more].concat());
    assert_eq!(status, 0);
    answer
}

fn coefficient(answer: &Value, name: &str) -> (f64, f64) {
    let all = answer["nondimensional"]["derivatives"].as_array().unwrap();
    let found = all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name} in {all:?}"));
    (found["value"].as_f64().unwrap(), found["std"].as_f64().unwrap())
}

fn near(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() < 1e-3 * expected.abs(), "{what}: {found}, by hand {expected}");
}

/// Text of the page between two marks.
fn between<'p>(page: &'p str, from: &str, to: &str) -> &'p str {
    page.split_once(from).unwrap_or_else(|| panic!("{from}")).1.split_once(to).unwrap_or_else(|| panic!("{to}")).0
}

#[test]
fn the_report_has_tables_with_units_and_pictures_without_ground_with_the_inputs() {
    let (folder, files) = flown("identify-report");
    let out = folder.join("out");
    let answer = said(&files, &["--out", path(&out), "--set", ROTOR, "--domain", "frequency"]);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains("<pre>") && !page.contains("<script") && !page.contains("src=") && !page.contains("http"));
    // Every derivative is a row of its own, with its unit.
    let table = between(&page, "<table aria-label=\"Derivatives\">", "</table>");
    for (name, unit) in [("N_v", "rad/(m s)"), ("N_r", "1/s"), ("Y_pedal", "m/(s^2 rad)"), ("L_lat_cyclic", "1/s^2")] {
        let row = between(table, &format!("<th scope=\"row\">{name}</th>"), "</tr>");
        assert!(row.contains(&format!("<td class=\"words\">{unit}</td>")), "{name}: {row}");
    }
    // Hz beside rad/s.
    let modes = between(&page, "<table aria-label=\"Modes\">", "</table>");
    assert!(modes.contains("omega, rad/s") && modes.contains("frequency, Hz"));
    let omega = answer["modes"]["dutch_roll"]["omega"].as_f64().unwrap();
    let row = between(modes, "<th scope=\"row\">Dutch roll</th>", "</tr>");
    let cells: Vec<f64> = row.split("<td").skip(1).filter_map(|cell| cell.split(['>', ' ']).nth(1)?.parse().ok()).collect();
    near(cells[0], omega, "omega");
    near(cells[1], omega / std::f64::consts::TAU, "Hz");
    // Every picture has a name for a reader who does not see it, no ground of its own, and its legend outside.
    let pictures: Vec<&str> = page.split("<svg ").skip(1).map(|rest| rest.split_once("</svg>").unwrap().0).collect();
    assert!(pictures.len() >= 8, "{}", pictures.len());
    for picture in &pictures {
        assert!(picture.contains("role=\"img\" aria-label=\""), "{}", &picture[..80]);
        assert!(!picture.contains("#FFFFFF") && !picture.contains(">measured<"));
    }
    assert_eq!(page.matches("aria-label=\"inputs, rad over time, s\"").count(), 2, "the controls of both runs");
    assert!(page.contains("prefers-color-scheme:dark") && page.contains("<figcaption>"));
    for head in ["Nondimensional derivatives", "Fit and prediction", "Modes"] {
        assert!(page.contains(&format!("<table aria-label=\"{head}\">")), "{head}");
    }
}

/// (1) and (2) of `nondimensional` with the numbers of the answer itself, and density of the standard atmosphere.
#[test]
fn coefficients_of_a_wing_are_those_by_hand() {
    let (_, files) = flown("identify-coefficients");
    let answer = said(&files, &["--set", WING, "--set", MASS, "--set", INERTIA]);
    let mut trims = files.iter().map(|file| {
        let run = RunFile::read(file);
        let mean = |name: &str| {
            let place = run.place(name);
            let first: Vec<f64> = run
                .rows
                .iter()
                .take_while(|row| row[0].parse::<f64>().unwrap() <= 1.0)
                .filter_map(|row| row[place].parse().ok())
                .collect();
            first.iter().sum::<f64>() / first.len() as f64
        };
        (mean("tas"), mean("altitude"))
    });
    let (one, other) = (trims.next().unwrap(), trims.next().unwrap());
    let (speed, altitude) = (0.5 * (one.0 + other.0), 0.5 * (one.1 + other.1));
    let density = 1.225 * (1.0 - 0.0065 * altitude / 288.15).powf(4.25588);
    let force = 0.5 * density * speed * speed * 64.0;
    let of = |name: &str| derivative(&answer, name);
    near(coefficient(&answer, "CY_beta").0, 17631.0 * of("Y_v").0 * speed / force, "CY_beta");
    near(coefficient(&answer, "CY_beta").1, 17631.0 * of("Y_v").1 * speed / force, "its error");
    let roll = (133_367.0 * of("L_p").0 - 11_442.0 * of("N_p").0) * 2.0 * speed / 21.5;
    near(coefficient(&answer, "Cl_p").0, roll / (force * 21.5), "Cl_p");
    let yaw = 359_593.0 * of("N_pedal").0 - 11_442.0 * of("L_pedal").0;
    near(coefficient(&answer, "Cn_pedal").0, yaw / (force * 21.5), "Cn_pedal");
    // Without inertia there are forces only, and the reader is told.
    let forces = said(&files, &["--set", WING, "--set", MASS]);
    let names: Vec<&str> =
        forces["nondimensional"]["derivatives"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert!(names.iter().all(|name| name.starts_with("CY_")) && names.len() == 5, "{names:?}");
    assert!(forces["nondimensional"]["missing"].to_string().contains("inertia_kgm2"));
    assert!(said(&files, &[])["nondimensional"].is_null());
}

#[test]
fn those_of_a_rotor_are_in_its_units_whatever_the_form_of_the_state() {
    let (_, files) = flown("identify-rotor-units");
    let by_velocity = said(&files, &["--set", ROTOR]);
    near(coefficient(&by_velocity, "n_v").0, derivative(&by_velocity, "N_v").0 * 7.5 * 7.5 / 208.0, "n_v");
    near(coefficient(&by_velocity, "l_p").0, derivative(&by_velocity, "L_p").0 * 7.5 / 208.0, "l_p");
    near(coefficient(&by_velocity, "y_pedal").0, derivative(&by_velocity, "Y_pedal").0 * 7.5 / (208.0 * 208.0), "y_pedal");
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let angle = ["--states", "beta,p,phi,r", "--inputs", "lat_cyclic,pedal", "--set", ROTOR];
    let by_angle = identified(&files, &angle).1;
    for name in ["y_v", "n_v", "y_pedal", "l_p"] {
        let ((one, std), (other, _)) = (coefficient(&by_velocity, name), coefficient(&by_angle, name));
        assert!((one - other).abs() < 0.3 * std, "{name}: {one} +- {std}, by sideslip {other}");
    }
}
