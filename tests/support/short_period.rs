//! A short period for output error, and records of it with noise of a given colour.

use super::uniform::Uniform;
use sideslip::postflight::output_error::{FitParameter, InputOutputRecord, MatrixEntry, ModelStructure, RunParameters, predict};

/// Short period: states w, q; input elevator; outputs w, q, az.
/// Parameters Z_w, Z_elevator, M_w, M_q, M_elevator, and az per w.
pub(crate) const TRUTH: [f64; 6] = [-0.8, -0.3, -4.0, -1.6, -7.0, -9.0];

pub(crate) fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

pub(crate) fn structure() -> ModelStructure {
    let (free, fixed) = (MatrixEntry::free, MatrixEntry::fixed);
    ModelStructure {
        states: names(&["w", "q"]),
        inputs: names(&["elevator"]),
        outputs: names(&["w", "q", "az"]),
        a: vec![vec![free(0), fixed(1.0)], vec![free(2), free(3)]],
        b: vec![vec![free(1)], vec![free(4)]],
        c: vec![vec![fixed(1.0), fixed(0.0)], vec![fixed(0.0), fixed(1.0)], vec![free(5), fixed(0.2)]],
        d: vec![vec![fixed(0.0)], vec![fixed(0.0)], vec![MatrixEntry { fixed: 0.1, terms: vec![(1, 2.0)] }]],
        state_bias: vec![false, true],
        output_bias: vec![false, false, true],
        initial_state: vec![true, true],
    }
}

pub(crate) fn parameters(off: f64) -> Vec<FitParameter> {
    let names = ["Z_w", "Z_elevator", "M_w", "M_q", "M_elevator", "az_w"];
    let start = |j: usize| TRUTH[j] * (1.0 + off * if j.is_multiple_of(2) { 1.0 } else { -1.0 });
    names.iter().enumerate().map(|(j, name)| FitParameter { name: (*name).to_owned(), start: start(j), prior: None }).collect()
}

/// 3211 of a pulse's length, from 1 s.
pub(crate) fn input(t: f64, pulse_s: f64, size: f64) -> f64 {
    let at = (t - 1.0) / pulse_s;
    match at {
        _ if !(0.0..7.0).contains(&at) => 0.0,
        _ if at < 3.0 => size,
        _ if at < 5.0 => -size,
        _ if at < 6.0 => size,
        _ => -size,
    }
}

/// Noise of the outputs and how it is coloured: v(k) = colour v(k-1) + sqrt(1 - colour^2) white.
pub(crate) struct Noise {
    pub(crate) std: [f64; 3],
    pub(crate) colour: f64,
}

/// As good as normal here: the sum of twelve.
pub(crate) fn normal(uniform: &mut Uniform) -> f64 {
    (0..12).map(|_| uniform.within(0.5)).sum()
}

/// A record of the truth over some times.
pub(crate) fn record(
    times_s: Vec<f64>,
    pulse_s: f64,
    own: &RunParameters,
    noise: &Noise,
    uniform: &mut Uniform,
) -> InputOutputRecord {
    let inputs = vec![times_s.iter().map(|&t| input(t, pulse_s, 0.05)).collect()];
    let samples = times_s.len();
    let mut record =
        InputOutputRecord { times_s, inputs, outputs: vec![vec![f64::NAN; samples]; 3], input_noise_std: Vec::new() };
    record.outputs = predict(&structure(), &TRUTH, &[], &record, own).unwrap();
    for (output, std) in record.outputs.iter_mut().zip(noise.std) {
        let mut v = normal(uniform);
        for value in output {
            *value += std * v;
            v = noise.colour * v + (1.0 - noise.colour * noise.colour).sqrt() * normal(uniform);
        }
    }
    record
}
