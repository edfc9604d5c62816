//! The built-in Level-1 Puma against the published matrices, the prototype's, and the Dutch roll of the paper.
//!
//! Sources: G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, appendix 4B (matrices); G. D. Padfield et al., UK
//! research into system identification for helicopter flight mechanics, 1987 (Dutch roll and N_p); and the outputs of a
//! prototype of our own.

use crate::support::puma::{BOOK_KNOT, published_puma};
use sideslip::dynamics::linear::{input_matrix, state_matrix};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::realtime::modes::naming::eigenmodes;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use std::path::PathBuf;

fn puma(speed: f64, climb: f64, density: f64, set: &[&str]) -> FlightModel {
    let set = set.iter().map(|&text| text.to_owned()).collect();
    let asked = FlightRequest { speed: Some(speed), climb: Some(climb), density: Some(density), sideslip: None, set };
    FlightModel::puma(&asked).unwrap()
}

#[test]
fn main_derivatives_are_the_published_ones() {
    const MAIN: [(&str, usize, usize); 9] = [
        ("X_u", 0, 0),
        ("Z_w", 1, 1),
        ("M_q", 2, 2),
        ("Y_v", 4, 4),
        ("L_v", 5, 4),
        ("L_p", 5, 5),
        ("L_r", 5, 7),
        ("N_p", 7, 5),
        ("N_r", 7, 7),
    ];
    const STATES: [&str; 8] = ["X", "Z", "M", "theta", "Y", "L", "phi", "N"];
    const INPUTS: [&str; 4] = ["collective", "lon_cyclic", "lat_cyclic", "pedal"];
    let mut beyond = Vec::new();
    for knots in [20, 40, 60, 80, 100, 120, 140] {
        let Some(published) = published_puma(knots) else { return };
        let model = puma(f64::from(knots) * BOOK_KNOT, 0.0, 1.225, &[]);
        let (a, b) = (state_matrix(model.linear()), input_matrix(model.linear(), &[]));
        let mut worst = (0.0, String::new());
        let mut compare = |name: String, found: f64, wanted: f64| {
            // The source prints four decimals.
            let off = ((found - wanted).abs() - 0.5e-4).max(0.0) / wanted.abs();
            if off > worst.0 {
                worst = (off, format!("{name} {found:.4} for {wanted:.4}"));
            }
            if off > 0.02 {
                beyond.push(format!("{knots} kn {name}: {found:.4} for {wanted:.4}, {:.1} %", 100.0 * off));
            }
        };
        for (name, row, column) in MAIN {
            compare(name.to_owned(), a[(row, column)], published.a[row][column]);
        }
        for (row, column) in (0..8).flat_map(|row| (0..4).map(move |column| (row, column))) {
            let wanted = published.b[row][column];
            // Entries that are nothing of their column are not what the control does.
            let largest = published.b.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
            if wanted.abs() > 0.01 * largest {
                compare(format!("{}_{}", STATES[row], INPUTS[column]), b[(row, column)], wanted);
            }
        }
        let n_v = a[(7, 4)] - published.a[7][4];
        let (phi, theta) = (model.linear().trim.phi, model.linear().trim.theta);
        let book = published.trim();
        eprintln!(
            "{knots} kn: worst {:.2} % {}; N_v off {n_v:+.4}; phi off {:+.5}, theta off {:+.5} rad",
            100.0 * worst.0,
            worst.1,
            phi - book.phi,
            theta - book.theta
        );
        assert!(n_v.abs() < 0.003, "{knots} kn: N_v off by {n_v}");
        assert!((phi - book.phi).abs() < 1e-3 && (theta - book.theta).abs() < 1e-3, "{knots} kn: {phi} {theta}");
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}

#[test]
fn matrices_are_those_of_the_prototype() {
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "..", "shared", "reference", "puma", "level1_reference.json"].iter().collect();
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("SKIPPED: {} is absent", path.display());
        return;
    };
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut worst = (0.0, String::new());
    for case in document["cases"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64().unwrap();
        let hub = if case["geom"] == "helisim" { "hub=published" } else { "hub=exact" };
        let knot = 1852.0 / 3600.0;
        let climb = number("roc_fpm") * 0.3048 / 60.0;
        let model = puma(number("kt") * knot, climb, number("rho"), &[hub]);
        let (a, b) = (state_matrix(model.linear()), input_matrix(model.linear(), &[]));
        let wanted_a: [[f64; 8]; 8] = serde_json::from_value(case["A"].clone()).unwrap();
        let wanted_b: [[f64; 4]; 8] = serde_json::from_value(case["B"].clone()).unwrap();
        let mut compare = |name: &str, row: usize, column: usize, found: f64, wanted: f64, largest: f64| {
            let off = (found - wanted).abs() / largest;
            if off > worst.0 {
                worst = (
                    off,
                    format!("{} {} kn {}: {name}({row}, {column}) {found} for {wanted}", case["geom"], case["kt"], case["case"]),
                );
            }
        };
        for row in 0..8 {
            let largest = wanted_a[row].iter().fold(0.0f64, |most, x| most.max(x.abs()));
            (0..8).for_each(|column| compare("A", row, column, a[(row, column)], wanted_a[row][column], largest));
            let largest = wanted_b[row].iter().fold(1e-9f64, |most, x| most.max(x.abs()));
            (0..4).for_each(|column| compare("B", row, column, b[(row, column)], wanted_b[row][column], largest));
        }
        let trim = model.linear().trim;
        let x0: [f64; 8] = serde_json::from_value(case["x0"].clone()).unwrap();
        assert!((trim.theta - x0[3]).abs() < 5e-5 && (trim.phi - x0[6]).abs() < 5e-5, "{case:#?}");
    }
    eprintln!("largest difference {:.4} % of the largest entry in its row: {}", 100.0 * worst.0, worst.1);
    assert!(worst.0 < 0.005, "{worst:?}");
}

#[test]
fn the_dutch_roll_of_the_paper_and_its_damping_in_order() {
    let mut dampings = Vec::new();
    for (climb_ft_min, real, imag, n_p) in
        [(-1000.0, -0.106, 0.90, -0.227), (0.0, -0.057, 0.94, -0.21), (1000.0, -0.037, 0.94, -0.19)]
    {
        let model = puma(100.0 * 1852.0 / 3600.0, climb_ft_min * 0.3048 / 60.0, 1.024, &[]);
        let linear = model.linear();
        let mode = eigenmodes(&state_matrix(linear)).unwrap().dutch_roll.unwrap();
        let found = linear.derivative(Axis::N, Variable::P);
        eprintln!("{climb_ft_min:+} ft/min: {:.4} +- {:.4}i, N_p {found:.4}", mode.re, mode.im);
        assert!((mode.re - real).abs() < 0.03 && (mode.im - imag).abs() < 0.05, "{mode}");
        assert!((found - n_p).abs() < 0.01, "{found}");
        dampings.push(mode.re);
    }
    assert!(dampings.windows(2).all(|pair| pair[0] < pair[1]), "{dampings:?}");
}
