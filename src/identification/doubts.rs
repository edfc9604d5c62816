//! What the instruments may be wrong by, found with the derivatives: vanes' scales, the trim's airspeed and incidence, lateness.
//!
//! Consumes a structure and, of a first fit, what the model says of each run; produces the structure with further parameters,
//! each known beforehand to [`SCALE`], [`SPEED`], [`INCIDENCE`] or [`LATENESS_S`] about nothing:
//!     beta = (1 + k_beta) (v/V0 + ..)     alpha = (1 + k_alpha) (w/u0 + ..)                            (1)
//!     V0 (1 + k_V) and alpha0 + d_alpha for V0 and alpha0 in the kinematics' rows and in v/V0, w/u0    (2)
//!     y_read = y - tau dy/dt     for every output, dy/dt that of the first fit's prediction            (3)
//! to first order. The kinematics are what tells them: v' = ay + w p - u r + g phi holds whatever the aircraft, and phi' = p.
//! A vane that reads 2 % too much, or a gyro 8 ms late, is else found in the derivatives, and no standard error knows of it. What
//! all outputs have in common of (3) is as much the controls' own lag: they are recorded where they are measured.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2006, ch. 10; the linearised delay is ours.
//! Numerics: (3) is good while tau times the fastest root is small; a first-order lag is a delay to that order.

use super::linear::Linear;
use crate::regression::output_error::{Entry, Fitted, Parameter, Record};

/// Standard deviation of a vane's scale about one.
pub const SCALE: f64 = 0.03;
/// Of the trim's airspeed, over itself.
pub const SPEED: f64 = 0.02;
/// Of the trim's incidence, rad.
pub const INCIDENCE: f64 = 0.01;
/// Of an output's lateness, s; of airspeed, which comes through pipes.
pub const LATENESS_S: f64 = 0.02;
/// See [`LATENESS_S`].
pub const LATENESS_OF_AIRSPEED_S: f64 = 0.4;

/// One of these parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// `beta_scale`, `alpha_scale`, `tas_scale`, `alpha_trim`, `late_p`.
    pub name: String,
    /// Its standard deviation beforehand, about zero: a scale is over one.
    pub prior_std: f64,
    /// Unit.
    pub unit: &'static str,
}

impl Linear {
    /// Adds the parameters to the structure; they stand behind the derivatives.
    pub fn doubt(&mut self) {
        let states = self.choice.states.clone();
        let outputs = self.choice.outputs.clone();
        let has = |names: &[&str]| states.iter().any(|state| names.contains(&state.as_str()));
        for (output, of) in [("beta", ["v", "beta"]), ("alpha", ["w", "alpha"])] {
            if let Some(row) = outputs.iter().position(|name| name == output).filter(|_| has(&of)) {
                let place = self.add(format!("{output}_scale"), SCALE, "");
                let c = self.structure.c.get_mut(row).into_iter().flatten();
                let d = self.structure.d.get_mut(row).into_iter().flatten();
                for entry in c.chain(d) {
                    let factor = entry.fixed;
                    follow(entry, place, factor);
                }
            }
        }
        let (u0, w0) = (self.datum.airspeed * libm::cos(self.datum.alpha), self.datum.airspeed * libm::sin(self.datum.alpha));
        let gravity = self.datum.known("beta", "phi");
        let by_speed = [("v", "r", -u0), ("v", "p", w0), ("w", "q", u0), ("u", "q", -w0), ("beta", "phi", -gravity)];
        let by_incidence = [("v", "p", u0), ("v", "r", w0), ("w", "q", -w0), ("u", "q", -u0), ("beta", "p", 1.0)];
        for (name, std, unit, factors) in [("tas_scale", SPEED, "", by_speed), ("alpha_trim", INCIDENCE, "rad", by_incidence)] {
            let there: Vec<_> = factors.into_iter().filter(|(state, ..)| has(&[state])).collect();
            if there.is_empty() {
                continue;
            }
            let place = self.add(name.to_owned(), std, unit);
            for (state, variable, factor) in there {
                self.row_entry(state, variable, |entry| follow(entry, place, factor));
            }
            if name == "tas_scale" {
                for (output, state) in [("beta", "v"), ("alpha", "w")] {
                    let row = outputs.iter().position(|known| known == output);
                    let column = states.iter().position(|known| known == state);
                    if let Some(entry) = row.zip(column).and_then(|(i, j)| self.structure.c.get_mut(i)?.get_mut(j)) {
                        let factor = -entry.fixed;
                        follow(entry, place, factor);
                    }
                }
            }
        }
        for (row, output) in outputs.iter().enumerate() {
            let std = if output == "tas" { LATENESS_OF_AIRSPEED_S } else { LATENESS_S };
            let place = self.add(format!("late_{output}"), std, "s");
            self.structure.inputs.push(format!("rate of {output}"));
            self.structure.b.iter_mut().for_each(|b| b.push(Entry::default()));
            for (other, d) in self.structure.d.iter_mut().enumerate() {
                d.push(if other == row { Entry { fixed: 0.0, terms: vec![(place, -1.0)] } } else { Entry::default() });
            }
        }
    }

    fn add(&mut self, name: String, prior_std: f64, unit: &'static str) -> usize {
        self.doubts.push(Doubt { name, prior_std, unit });
        self.derivatives.len() + self.doubts.len() - 1
    }

    /// An entry of A, or of B where the variable is an input.
    fn row_entry(&mut self, state: &str, variable: &str, change: impl FnOnce(&mut Entry)) {
        let Some(row) = self.choice.states.iter().position(|known| known == state) else { return };
        let column = |names: &[String]| names.iter().position(|known| known == variable);
        let (a, b) = (self.structure.a.get_mut(row), self.structure.b.get_mut(row));
        let entry = match (column(&self.choice.states), column(&self.choice.inputs)) {
            (Some(column), _) => a.and_then(|a| a.get_mut(column)),
            (None, Some(column)) => b.and_then(|b| b.get_mut(column)),
            (None, None) => None,
        };
        if let Some(entry) = entry {
            change(entry);
        }
    }

    /// The parameters of a second fit, which starts where the first one ended.
    pub fn doubted_parameters(&self, first: &Fitted) -> Vec<Parameter> {
        let mut parameters = self.parameters(&first.theta);
        parameters.extend(self.doubts.iter().map(|doubt| Parameter {
            name: doubt.name.clone(),
            start: 0.0,
            prior: Some((0.0, doubt.prior_std)),
        }));
        parameters
    }

    /// A record with the rates of change of what the first fit predicts behind its inputs, by output.
    pub fn doubted_record(&self, mut record: Record, predicted: &[Vec<f64>]) -> Record {
        let rates = predicted.iter().map(|values| rates(&record.times_s, values));
        let rates: Vec<Vec<f64>> = rates.collect();
        record.inputs.extend(rates);
        record
    }
}

/// The entry moves by that factor with the parameter.
fn follow(entry: &mut Entry, parameter: usize, factor: f64) {
    if factor != 0.0 {
        entry.terms.push((parameter, factor));
    }
}

/// Slope at every time: of the parabola through a point and its neighbours, one-sided at the ends.
fn rates(times_s: &[f64], values: &[f64]) -> Vec<f64> {
    let count = times_s.len().min(values.len());
    let slope = |i: usize, j: usize| match (times_s.get(i), times_s.get(j), values.get(i), values.get(j)) {
        (Some(t0), Some(t1), Some(x0), Some(x1)) if t1 > t0 => Some(((x1 - x0) / (t1 - t0), t1 - t0)),
        _ => None,
    };
    let at = |k: usize| {
        let before = k.checked_sub(1).and_then(|before| slope(before, k));
        match (before, slope(k, k + 1)) {
            (Some((left, h0)), Some((right, h1))) => (left * h1 + right * h0) / (h0 + h1),
            (Some((one, _)), None) | (None, Some((one, _))) => one,
            (None, None) => 0.0,
        }
    };
    (0..count).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::rates;

    #[test]
    fn a_parabola_has_its_own_slope_whatever_the_intervals() {
        let times = [0.0, 0.1, 0.25, 0.3, 0.5];
        let values: Vec<f64> = times.iter().map(|t| 3.0 - 2.0 * t + 4.0 * t * t).collect();
        let found = rates(&times, &values);
        for (t, slope) in times.iter().zip(&found).skip(1).take(3) {
            assert!((slope - (8.0 * t - 2.0)).abs() < 1e-12, "{t}: {slope}");
        }
        assert!((found[0] - (8.0 * 0.05 - 2.0)).abs() < 1e-12 && rates(&[], &[]).is_empty());
    }
}
