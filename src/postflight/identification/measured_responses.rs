//! Measured frequency responses of a run: each state to each input, without a model.
//!
//! Consumes a run, the chosen states and inputs and a band; produces for each pair gain, phase and coherence at `FREQUENCIES`
//! frequencies evenly spaced in their logarithm, or the reason why there are none. A state is represented by the channel that
//! measures it (v by beta, w by alpha, u by tas); rows are resampled at even intervals by linear interpolation. Each input is
//! taken alone: inputs that move together, or other excitation, lower the coherence.
//! Source: M. B. Tischler and R. K. Remple, Aircraft and Rotorcraft System Identification, 2nd ed. 2012, ch. 7; the estimate
//! is that of `num::frequency_response`.

use super::columns::Columns;
use super::model_variables::ModelVariables;
use crate::num::frequency_response::{FrequencyResponsePoint, frequency_response};
use std::f64::consts::TAU;

/// Length of the record over that of a segment.
const PARTS: f64 = 3.0;
/// Longest segment, s.
const LONGEST_S: f64 = 40.0;
const FREQUENCIES: usize = 24;
/// Least coherence of a reliable response: Tischler and Remple, 2012.
pub const COHERENT: f64 = 0.6;

/// A response of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredResponse {
    /// Name of the run.
    pub run: String,
    /// Channel that measures the state.
    pub output: String,
    /// Name of the input.
    pub input: String,
    /// Length of a segment, s.
    pub segment_s: f64,
    /// The other input of highest mean coherence with this one, and that coherence, where it is [`COHERENT`] or more: the
    /// response then contains that of the other input.
    pub together: Option<(String, f64)>,
    /// By frequency, or the reason why there are none.
    pub points: Result<Vec<FrequencyResponsePoint>, String>,
}

/// The channel that measures a state.
pub fn channel(state: &str) -> &str {
    match state {
        "v" => "beta",
        "w" => "alpha",
        "u" => "tas",
        own => own,
    }
}

/// Responses of every state to every input of the choice, run by run, from and to those frequencies, Hz.
pub fn responses(runs: &[Columns], choice: &ModelVariables, from_hz: f64, to_hz: f64) -> Vec<MeasuredResponse> {
    let mut all = Vec::new();
    for run in runs {
        let span_s = run.times_s.last().zip(run.times_s.first()).map_or(0.0, |(last, first)| last - first);
        let interval_s = span_s / (run.times_s.len().max(2) - 1) as f64;
        let segment_s = (span_s / PARTS).min(LONGEST_S);
        let even = |name: &str| run.lines(name).map(|values| even(&run.times_s, &values, interval_s)).map_err(|e| e.to_string());
        // Two cycles a segment, half the sampling rate.
        let lowest = from_hz.max(2.0 / segment_s);
        let highest = to_hz.min(0.5 / interval_s);
        let of = |output: &str, input: &str| {
            if !(lowest < highest) {
                let range = format!("a record of {span_s:.1} s resolves {:.2} to {:.2} Hz", 2.0 / segment_s, 0.5 / interval_s);
                return Err(format!("{range}; the band is {from_hz} to {to_hz} Hz"));
            }
            let ratio = highest / lowest;
            let at = |k: usize| TAU * lowest * libm::pow(ratio, k as f64 / (FREQUENCIES - 1) as f64);
            // Rounding must not put the last one above half the sampling rate.
            let frequencies: Vec<f64> = (0..FREQUENCIES).map(|k| at(k).min(TAU * highest)).collect();
            let found = frequency_response(&even(input)?, &even(output)?, interval_s, segment_s, &frequencies);
            found.map_err(|error| error.to_string())
        };
        for input in &choice.inputs {
            let others = choice.inputs.iter().filter(|other| *other != input);
            let coherence = |other: &String| -> Option<(String, f64)> {
                let points = of(other, input).ok()?;
                let mean = points.iter().map(|point| point.coherence).sum::<f64>() / points.len() as f64;
                (mean >= COHERENT).then(|| (other.clone(), mean))
            };
            let together = others.filter_map(coherence).max_by(|a, b| a.1.total_cmp(&b.1));
            for state in &choice.states {
                let output = channel(state);
                let points = of(output, input);
                let (run, output, input) = (run.run.clone(), output.to_owned(), input.clone());
                all.push(MeasuredResponse { run, output, input, segment_s, together: together.clone(), points });
            }
        }
    }
    all
}

/// A series at even intervals, linear between its rows.
fn even(times_s: &[f64], values: &[f64], interval_s: f64) -> Vec<f64> {
    let Some(&first_s) = times_s.first() else { return Vec::new() };
    let mut after = 1;
    let at = |k: usize| {
        let time_s = first_s + interval_s * k as f64;
        while after + 1 < times_s.len() && times_s.get(after).is_some_and(|later| *later < time_s) {
            after += 1;
        }
        let pair = |series: &[f64]| Some((*series.get(after.checked_sub(1)?)?, *series.get(after)?));
        match (pair(times_s), pair(values)) {
            (Some((t0, t1)), Some((x0, x1))) => x0 + (x1 - x0) * ((time_s - t0) / (t1 - t0)).clamp(0.0, 1.0),
            _ => values.first().copied().unwrap_or(f64::NAN),
        }
    };
    (0..times_s.len()).map(at).collect()
}

impl MeasuredResponse {
    /// Ends, Hz, of the longest range of frequencies with a coherence of [`COHERENT`] or more.
    pub fn coherent(&self) -> Option<(f64, f64)> {
        let points = self.points.as_ref().ok()?;
        let stretches = points.chunk_by(|a, b| (a.coherence >= COHERENT) == (b.coherence >= COHERENT));
        let good = stretches.filter(|part| part.first().is_some_and(|point| point.coherence >= COHERENT));
        let widest = good.max_by_key(|part| part.len())?;
        Some((widest.first()?.rad_s / TAU, widest.last()?.rad_s / TAU))
    }

    /// The point of largest gain in that range.
    pub fn peak(&self) -> Option<&FrequencyResponsePoint> {
        let (from, to) = self.coherent()?;
        let good = self.points.as_ref().ok()?.iter().filter(|point| (from..=to).contains(&(point.rad_s / TAU)));
        good.max_by(|a, b| a.response.norm_sqr().total_cmp(&b.response.norm_sqr()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::run::RunGeometry;

    /// r' = -0.8 r + 2 pedal, pedal a sweep from well below the band that is compared, on uneven rows; exact to the step of the
    /// integration.
    fn run() -> Columns {
        let (mut r, mut times, mut pedals, mut rates) = (0.0, Vec::new(), Vec::new(), Vec::new());
        let fine = 1e-3;
        let sweep = |t: f64| f64::sin(TAU * (0.01 * t + 0.005 * t * t));
        for k in 0..90_000_u32 {
            let t = fine * f64::from(k);
            if k % 20 == 0 || k % 70 == 0 {
                times.push(t);
                pedals.push(sweep(t));
                rates.push(r);
            }
            let slope = |r: f64, t: f64| -0.8 * r + 2.0 * sweep(t);
            r += fine * slope(r + 0.5 * fine * slope(r, t), t + 0.5 * fine);
        }
        let columns = vec![("pedal".to_owned(), pedals), ("r".to_owned(), rates)];
        Columns::new("a".to_owned(), RunGeometry::DEFAULT, times, columns, 1.0).unwrap()
    }

    #[test]
    fn a_known_lag_is_recovered_and_the_band_is_limited_to_that_of_the_record() {
        let choice =
            ModelVariables { states: vec!["r".to_owned()], inputs: vec!["pedal".to_owned()], outputs: vec!["r".to_owned()] };
        let found = responses(&[run()], &choice, 0.01, 1.0);
        let [one] = found.as_slice() else { panic!("{found:?}") };
        let points = one.points.as_ref().unwrap();
        assert!((points[0].rad_s - TAU * 2.0 / one.segment_s).abs() < 1e-9 && (points[23].rad_s - TAU).abs() < 1e-9);
        for point in points.iter().filter(|point| (0.15..0.8).contains(&(point.rad_s / TAU))) {
            let s = nalgebra::Complex::new(0.0, point.rad_s);
            let exact = nalgebra::Complex::new(2.0, 0.0) / (s + 0.8);
            assert!(point.coherence > 0.95 && (point.response / exact - 1.0).norm() < 0.05, "{point:?} for {exact}");
        }
        assert!(one.coherent().unwrap().1 > 0.7 && one.peak().unwrap().rad_s < 2.0);
        let narrow = responses(&[run()], &choice, 0.01, 0.04);
        assert!(narrow[0].points.as_ref().unwrap_err().contains("resolves"));
    }
}
