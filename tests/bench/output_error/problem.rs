//! The problem that is timed: 17 derivatives of a lateral model from 30 s at 100 Hz, 4 states, 2 inputs, 5 outputs.

use sideslip::postflight::output_error::{FitParameter, InputOutputRecord, MatrixEntry, ModelStructure, RunParameters, predict};

/// Names and true values, SI and radians.
pub(crate) const TRUTH: [(&str, f64); 17] = [
    ("Y_beta", -0.15),
    ("Y_p", 0.02),
    ("Y_r", 0.03),
    ("Y_rudder", 0.05),
    ("L_beta", -3.8),
    ("L_p", -2.1),
    ("L_r", 1.0),
    ("L_aileron", -6.3),
    ("L_rudder", 1.1),
    ("N_beta", 3.0),
    ("N_p", -0.18),
    ("N_r", -0.49),
    ("N_aileron", -0.39),
    ("N_rudder", -1.76),
    ("ay_beta", -15.0),
    ("ay_p", 0.8),
    ("ay_rudder", 4.0),
];

const SAMPLES: usize = 3000;
const INTERVAL_S: f64 = 0.01;
/// Standard deviations of the noise on beta, p, r, phi, ay.
const NOISE: [f64; 5] = [0.002, 0.004, 0.002, 0.002, 0.03];

/// States beta, p, r, phi; inputs aileron, rudder.
pub(crate) fn structure() -> ModelStructure {
    let name = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    let free = MatrixEntry::free;
    let fixed = MatrixEntry::fixed;
    let yaw = MatrixEntry { fixed: -1.0, terms: vec![(2, 1.0)] };
    let unit = |at: usize| (0..4).map(|i| fixed(f64::from(u8::from(i == at)))).collect::<Vec<_>>();
    ModelStructure {
        states: name(&["beta", "p", "r", "phi"]),
        inputs: name(&["aileron", "rudder"]),
        outputs: name(&["beta", "p", "r", "phi", "ay"]),
        a: vec![
            vec![free(0), free(1), yaw, fixed(9.81 / 100.0)],
            vec![free(4), free(5), free(6), fixed(0.0)],
            vec![free(9), free(10), free(11), fixed(0.0)],
            vec![fixed(0.0), fixed(1.0), fixed(0.0), fixed(0.0)],
        ],
        b: vec![vec![fixed(0.0), free(3)], vec![free(7), free(8)], vec![free(12), free(13)], vec![fixed(0.0), fixed(0.0)]],
        c: vec![unit(0), unit(1), unit(2), unit(3), vec![free(14), free(15), fixed(0.0), fixed(0.0)]],
        d: [vec![vec![fixed(0.0), fixed(0.0)]; 4], vec![vec![fixed(0.0), free(16)]]].concat(),
        state_bias: vec![false; 4],
        output_bias: vec![false; 5],
        initial_state: vec![false; 4],
    }
}

/// The truth, begun away from it as a regression might: each off by up to 30 %.
pub(crate) fn parameters() -> Vec<FitParameter> {
    let off = |j: usize| 1.0 + 0.3 * libm::sin(2.3 * j as f64 + 1.0);
    let named = TRUTH.iter().enumerate();
    named.map(|(j, (name, value))| FitParameter { name: (*name).to_owned(), start: value * off(j), prior: None }).collect()
}

/// Doublet on the aileron and 3211 on the rudder with their edges rounded by sampling, then white noise on the outputs.
pub(crate) fn record() -> InputOutputRecord {
    let times_s: Vec<f64> = (0..SAMPLES).map(|k| k as f64 * INTERVAL_S).collect();
    let steps = |edges: &[(f64, f64)], t: f64| edges.iter().rev().find(|(from, _)| t >= *from).map_or(0.0, |(_, value)| *value);
    let rudder = [(1.0, 0.05), (3.1, -0.05), (4.5, 0.05), (5.2, -0.05), (5.9, 0.0), (20.0, 0.03), (21.0, -0.03), (22.0, 0.0)];
    let aileron = [(10.0, 0.04), (11.5, -0.04), (13.0, 0.0), (16.0, -0.03), (17.0, 0.03), (18.0, 0.0)];
    let inputs =
        vec![times_s.iter().map(|&t| steps(&aileron, t)).collect(), times_s.iter().map(|&t| steps(&rudder, t)).collect()];
    let mut record =
        InputOutputRecord { times_s, inputs, outputs: vec![vec![f64::NAN; SAMPLES]; 5], input_noise_std: Vec::new() };
    let theta: Vec<f64> = TRUTH.iter().map(|(_, value)| *value).collect();
    let own = RunParameters { initial_state: vec![0.0; 4], state_bias: vec![0.0; 4], output_bias: vec![0.0; 5] };
    record.outputs = predict(&structure(), &theta, &[], &record, &own).unwrap();
    let mut seed = 0x2545_f491_4f6c_dd1d_u64;
    let mut uniform = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for (output, std) in record.outputs.iter_mut().zip(NOISE) {
        for value in output {
            let sum: f64 = (0..12).map(|_| uniform()).sum();
            *value += std * (sum - 6.0);
        }
    }
    record
}
