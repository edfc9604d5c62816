//! Start values of output error: equation error on the recorded states, every signal smoothed with one kernel.
//!
//! Consumes the structure and the runs' records; produces a value for every derivative. Row of A by row, with smoothed signals
//! and their slopes and one bias for each run,
//!     x_i' - sum_j known_ij x_j = sum_j theta_ij x_j + b_run                                           (1)
//! by least squares over all runs. The kernel commutes with the derivative, so (1) holds for smoothed signals too; noise of the
//! states biases the estimates, which are start values only.
//! Source: `num::kernel`; R. V. Jategaonkar, Flight Vehicle System Identification, 2006, ch. 6 (equation error).
//! An unidentifiable derivative (singular value near zero) starts at zero.

use super::identification_model::IdentificationModel;
use crate::num::kernel::weights;
use crate::postflight::output_error::InputOutputRecord;
use nalgebra::{DMatrix, DVector};

/// Half width of the kernel, s, and at least this many samples.
const HALF_WIDTH_S: f64 = 0.3;
const LEAST_SAMPLES: f64 = 4.0;

/// Relative singular value below which a direction is unidentifiable.
const SINGULAR: f64 = 1e-9;

/// Smoothed signals and slopes at each time that the kernel covers, signal by signal.
struct SmoothedSignals {
    values: Vec<Vec<f64>>,
    slopes: Vec<Vec<f64>>,
}

/// Start value of each derivative, in its unit.
pub fn starts(linear: &IdentificationModel, records: &[InputOutputRecord]) -> Vec<f64> {
    let mut found = vec![0.0; linear.derivatives.len()];
    let smooth: Vec<SmoothedSignals> = records.iter().filter_map(|record| smoothed(linear, record)).collect();
    let rows: usize = smooth.iter().map(|run| run.values.first().map_or(0, Vec::len)).sum();
    let structure = &linear.structure;
    for (place, (a, b)) in structure.a.iter().zip(&structure.b).enumerate() {
        let entries: Vec<_> = a.iter().chain(b).collect();
        let free: Vec<(usize, usize)> = entries
            .iter()
            .enumerate()
            .filter_map(|(variable, entry)| entry.terms.first().map(|&(parameter, _)| (variable, parameter)))
            .collect();
        if free.is_empty() || rows <= free.len() + smooth.len() {
            continue;
        }
        let mut x = DMatrix::zeros(rows, free.len() + smooth.len());
        let mut y = DVector::zeros(rows);
        let mut row = 0;
        for (run, signals) in smooth.iter().enumerate() {
            let Some(slopes) = signals.slopes.get(place) else { continue };
            for (k, slope) in slopes.iter().enumerate() {
                let value = |variable: usize| signals.values.get(variable).and_then(|one| one.get(k)).copied().unwrap_or(0.0);
                let known: f64 = entries.iter().enumerate().map(|(variable, entry)| entry.fixed * value(variable)).sum();
                y[row] = slope - known;
                for (column, &(variable, _)) in free.iter().enumerate() {
                    x[(row, column)] = value(variable);
                }
                x[(row, free.len() + run)] = 1.0;
                row += 1;
            }
        }
        let svd = x.svd(true, true);
        let largest = svd.singular_values.max();
        if let Ok(theta) = svd.solve(&y, SINGULAR * largest) {
            for (&(_, parameter), value) in free.iter().zip(theta.iter()) {
                if let Some(start) = found.get_mut(parameter).filter(|_| value.is_finite()) {
                    *start = *value;
                }
            }
        }
    }
    found
}

/// States, then inputs, of a record, each state from the output that measures it; `None` where one has none.
fn smoothed(linear: &IdentificationModel, record: &InputOutputRecord) -> Option<SmoothedSignals> {
    let states = linear.choice.states.iter().map(|state| measured(linear, state, record));
    let signals: Vec<Vec<f64>> = states.chain(record.inputs.iter().cloned().map(Some)).collect::<Option<_>>()?;
    // Samples at which every signal is known.
    let known: Vec<usize> = (0..record.times_s.len())
        .filter(|&k| signals.iter().all(|one| one.get(k).is_some_and(|value| value.is_finite())))
        .collect();
    let times: Vec<f64> = known.iter().filter_map(|&k| record.times_s.get(k).copied()).collect();
    let signals: Vec<Vec<f64>> = signals.iter().map(|one| known.iter().filter_map(|&k| one.get(k).copied()).collect()).collect();
    let span_s = times.last()? - times.first()?;
    let interval_s = span_s / (times.len().max(2) - 1) as f64;
    let half_width = HALF_WIDTH_S.max(LEAST_SAMPLES * interval_s);
    let (mut values, mut slopes) = (vec![Vec::new(); signals.len()], vec![Vec::new(); signals.len()]);
    for &centre in &times {
        let from = times.partition_point(|&time| time < centre - half_width).saturating_sub(1);
        let to = (times.partition_point(|&time| time <= centre + half_width) + 1).min(times.len());
        let window = times.get(from..to)?;
        let (mut smooth, mut slope) = (vec![0.0; window.len()], vec![0.0; window.len()]);
        if !weights(window, centre, half_width, half_width, &mut smooth, &mut slope) {
            continue;
        }
        for ((signal, values), slopes) in signals.iter().zip(&mut values).zip(&mut slopes) {
            let part = signal.get(from..to)?;
            values.push(part.iter().zip(&smooth).map(|(x, w)| x * w).sum());
            slopes.push(part.iter().zip(&slope).map(|(x, w)| x * w).sum());
        }
    }
    Some(SmoothedSignals { values, slopes })
}

/// A state over time by inversion of (8) of `identification_model` to first order, the vane's arm subtracted.
fn measured(linear: &IdentificationModel, state: &str, record: &InputOutputRecord) -> Option<Vec<f64>> {
    let output = |name: &str| {
        let place = linear.choice.outputs.iter().position(|output| output == name)?;
        record.outputs.get(place)
    };
    let rates = |name: &str| {
        let place = linear.choice.states.iter().position(|state| state == name);
        place.and_then(|_| output(name)).or_else(|| {
            let place = linear.choice.inputs.iter().position(|input| input == name)?;
            record.inputs.get(place)
        })
    };
    let ([u0, _, w0], speed) = (linear.reference_trim.velocity(), linear.reference_trim.airspeed);
    let s = libm::hypot(u0, w0);
    let (channel, scale) = match state {
        "v" => ("beta", speed * speed / s),
        "w" => ("alpha", s * s / u0),
        "u" => ("tas", speed / u0),
        other => (other, 1.0),
    };
    let place = linear.choice.outputs.iter().position(|output| output == channel)?;
    let mut values = record.outputs.get(place)?.clone();
    // Rates times the vane's arm.
    let row = linear.structure.c.get(place)?;
    for (entry, name) in row.iter().zip(&linear.choice.states).filter(|(entry, name)| entry.fixed != 0.0 && *name != state) {
        if let Some(rate) = rates(name) {
            values.iter_mut().zip(rate).for_each(|(value, rate)| *value -= entry.fixed * rate);
        }
    }
    values.iter_mut().for_each(|value| *value *= scale);
    Some(values)
}
