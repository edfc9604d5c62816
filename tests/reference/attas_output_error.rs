//! ATTAS by output error: the author's derivatives from the records that are here.
//!
//! His ten lateral ones come from these two runs and a repeat of each, his short period from this one and a repeat; so ours are
//! to agree within their errors, not to the digit.

use crate::support::program::{RunFile, real};
use sideslip::postflight::output_error::{
    FitParameter, FitResult, FitSettings, InputOutputRecord, MatrixEntry, ModelStructure, fit,
};

/// Channels of a run as deviations from their means over the first second, in the file's units (degrees throughout).
fn record(name: &str, inputs: &[&str], outputs: &[&str]) -> Option<InputOutputRecord> {
    let file = RunFile::read(&real(name)?);
    let place = |name: &str| file.header.iter().position(|found| found.split('[').next() == Some(name)).unwrap();
    let column = |name: &str| -> Vec<f64> { file.rows.iter().map(|row| row[place(name)].trim().parse().unwrap()).collect() };
    let times_s = column("time");
    let first = times_s.iter().filter(|&&t| t < times_s[0] + 1.0).count();
    let deviation = |name: &&str| {
        let values = column(name);
        let mean = values[..first].iter().sum::<f64>() / first as f64;
        values.iter().map(|value| value - mean).collect()
    };
    let (inputs, outputs) = (inputs.iter().map(deviation).collect(), outputs.iter().map(deviation).collect());
    Some(InputOutputRecord { times_s, inputs, outputs, input_noise_std: Vec::new() })
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

/// Both states are measured; a free constant in each equation, free initial states.
fn two_states(states: [&str; 2], inputs: &[&str], a: Vec<Vec<MatrixEntry>>, b: Vec<Vec<MatrixEntry>>) -> ModelStructure {
    let one = |on: bool| MatrixEntry::fixed(f64::from(u8::from(on)));
    ModelStructure {
        states: names(&states),
        inputs: names(inputs),
        outputs: names(&states),
        a,
        c: vec![vec![one(true), one(false)], vec![one(false), one(true)]],
        d: vec![vec![one(false); inputs.len()]; 2],
        b,
        state_bias: vec![true; 2],
        output_bias: vec![false; 2],
        initial_state: vec![true; 2],
    }
}

/// Name, start, the author's value.
type Known = (&'static str, f64, f64);

fn fitted(structure: &ModelStructure, known: &[Known], records: &[InputOutputRecord]) -> FitResult {
    let named = |(name, start, _): &Known| FitParameter { name: (*name).to_owned(), start: *start, prior: None };
    let parameters: Vec<FitParameter> = known.iter().map(named).collect();
    let fitted = fit(structure, &parameters, &[], records, &FitSettings::default()).unwrap();
    assert!(fitted.converged);
    for (j, (name, _, published)) in known.iter().enumerate() {
        let (value, std) = (fitted.theta[j], fitted.std[j]);
        let white = fitted.std_cramer_rao[j];
        eprintln!("{name} {value:.4} +- {std:.4} (Cramer-Rao {white:.4}), published {published:.4}");
        assert!((value - published).abs() < 3.0 * std, "{name}: {value} +- {std}, published {published}");
    }
    fitted
}

#[test]
fn the_ten_lateral_derivatives_are_the_authors() {
    let channels = ["aileron", "rudder", "beta"];
    let read = |name: &str| record(name, &channels, &["p", "r"]);
    let (Some(rudder), Some(aileron)) = (read("attas-rud1.csv"), read("attas-ail1.csv")) else { return };
    let known: [Known; 10] = [
        ("L_p", -1.0, -2.067),
        ("L_r", 0.5, 1.029),
        ("L_aileron", -3.0, -6.306),
        ("L_rudder", 0.5, 1.145),
        ("L_beta", -2.0, -3.844),
        ("N_p", -0.1, -0.1839),
        ("N_r", -0.3, -0.4856),
        ("N_aileron", -0.1, -0.3912),
        ("N_rudder", -1.0, -1.761),
        ("N_beta", 2.0, 3.031),
    ];
    let row = |places: &[usize]| places.iter().map(|&j| MatrixEntry::free(j)).collect::<Vec<_>>();
    let structure = two_states(["p", "r"], &channels, vec![row(&[0, 1]), row(&[5, 6])], vec![row(&[2, 3, 4]), row(&[7, 8, 9])]);
    let found = fitted(&structure, &known, &[rudder, aileron]);
    for j in [0, 2, 4, 8, 9] {
        let (name, _, published) = known[j];
        let apart = found.theta[j] / published - 1.0;
        assert!(apart.abs() < 0.03, "{name}: {apart:.4} apart");
    }
    // Colour widens these errors some threefold: with the bound alone half of the ten would disagree.
    let wider = found.std.iter().zip(&found.std_cramer_rao).map(|(std, bound)| std / bound).sum::<f64>() / 10.0;
    assert!((2.0..=5.0).contains(&wider), "{wider}");
    assert!(found.insignificant.is_empty(), "{:?}", found.insignificant);
}

#[test]
fn the_short_period_is_the_authors() {
    let Some(elevator) = record("attas-elv1.csv", &["elevator"], &["alpha", "q"]) else { return };
    let known: [Known; 6] = [
        ("Z_alpha", -0.7, -0.4834),
        ("Z_q", 0.0, 0.1042),
        ("Z_elevator", 0.0, 0.6763),
        ("M_alpha", -3.0, -4.926),
        ("M_q", -1.0, -2.006),
        ("M_elevator", -5.0, -7.208),
    ];
    let turning = MatrixEntry { fixed: 1.0, terms: vec![(1, 1.0)] };
    let a = vec![vec![MatrixEntry::free(0), turning], vec![MatrixEntry::free(3), MatrixEntry::free(4)]];
    let structure = two_states(["alpha", "q"], &["elevator"], a, vec![vec![MatrixEntry::free(2)], vec![MatrixEntry::free(5)]]);
    let found = fitted(&structure, &known, &[elevator]);
    let theta = &found.theta;
    let omega = (theta[0] * theta[4] - (1.0 + theta[1]) * theta[3]).sqrt();
    let zeta = -0.5 * (theta[0] + theta[4]) / omega;
    eprintln!("short period {omega:.4} rad/s, zeta {zeta:.4}");
    assert!((omega / 2.525 - 1.0).abs() < 0.01, "{omega}");
    assert!((zeta / 0.493 - 1.0).abs() < 0.04, "{zeta}");
}
