//! The reference trim of a model, and the entries of A that it determines (gravity, flight speed).
//!
//! Consumes the trims of the runs; produces their means, the standard errors of these, and the known entries of A: (1) to (7) of
//! `identification_model`. A trim value that was not recorded is taken as zero, and noted.
//! Returns [`IdentificationModelError`] for runs at different airspeeds.

use super::columns::Columns;
use super::model_variables::IdentificationModelError;
use crate::dynamics::linear::{STATES, kinematic_entries};
use crate::dynamics::sensors::flow_direction;
use nalgebra::DMatrix;

/// Largest relative difference in airspeed between the trims of runs of one model.
pub const SAME_SPEED: f64 = 0.1;

/// Channels of a trim, in the order of the fields of [`ReferenceTrim`].
pub(crate) const NUMBERS: [&str; 5] = ["tas", "alpha", "beta", "theta", "phi"];

/// The trim that a model is linearised about: means over the runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceTrim {
    /// V0, m/s.
    pub airspeed: f64,
    /// alpha0, beta0, theta0, phi0, rad.
    pub alpha: f64,
    /// See `alpha`.
    pub beta: f64,
    /// See `alpha`.
    pub theta: f64,
    /// See `alpha`.
    pub phi: f64,
}

impl ReferenceTrim {
    /// Means over the runs of their trims; a channel that was not recorded is taken as zero, with a note.
    ///
    /// # Errors
    /// [`IdentificationModelError`] where runs differ in airspeed, or a needed airspeed was not recorded.
    pub fn of(runs: &[Columns], needs_speed: bool, notes: &mut Vec<String>) -> Result<Self, IdentificationModelError> {
        let mut sums = [0.0; NUMBERS.len()];
        let mut first: Option<(String, f64)> = None;
        for run in runs {
            for (name, sum) in NUMBERS.into_iter().zip(&mut sums) {
                match run.trim(name) {
                    Ok(value) => *sum += value / runs.len() as f64,
                    Err(error) if name == "tas" && needs_speed => return Err(error.into()),
                    Err(_) if name == "tas" => {}
                    Err(_) => notes.push(format!("{}: `{name}` in trim is not known and taken as zero", run.run)),
                }
            }
            if let Ok(speed) = run.trim("tas") {
                match &first {
                    None => first = Some((run.run.clone(), speed)),
                    Some((name, known)) if (speed - known).abs() > SAME_SPEED * known.abs() => {
                        return Err(IdentificationModelError::Speeds {
                            first: name.clone(),
                            first_speed: *known,
                            other: run.run.clone(),
                            other_speed: speed,
                        });
                    }
                    Some(_) => {}
                }
            }
        }
        let [airspeed, alpha, beta, theta, phi] = sums;
        Ok(ReferenceTrim { airspeed, alpha, beta, theta, phi })
    }

    /// u0 v0 w0, m/s.
    pub fn velocity(&self) -> [f64; 3] {
        flow_direction(self.alpha, self.beta).map(|part| self.airspeed * part)
    }

    /// Derivatives of `beta`, `alpha` or `tas` with respect to u v w, (8) of
    /// `identification_model`.
    pub fn flow_slopes(&self, output: &str) -> Option<[f64; 3]> {
        let ([u0, v0, w0], speed) = (self.velocity(), self.airspeed);
        let (s2, s) = (u0 * u0 + w0 * w0, libm::hypot(u0, w0));
        let per = s * speed * speed;
        match output {
            "beta" => Some([-u0 * v0 / per, s2 / per, -w0 * v0 / per]),
            "alpha" => Some([-w0 / s2, 0.0, u0 / s2]),
            "tas" => Some([u0, v0, w0].map(|part| part / speed)),
            _ => None,
        }
    }

    /// The known coefficient of a variable in a state's row, (1) to (7) of `identification_model`.
    pub fn known(&self, state: &str, variable: &str) -> f64 {
        match (state, variable) {
            ("beta", _) => self.known("v", variable) / self.airspeed,
            ("alpha", "q") => 1.0,
            ("alpha", "p" | "theta" | "phi") => self.known("w", variable) / self.airspeed,
            _ => {
                let place = |name: &str| STATES.iter().position(|state| *state == name);
                let (Some(row), Some(column)) = (place(state), place(variable)) else { return 0.0 };
                let entries = kinematic_entries(self.velocity(), self.phi, self.theta);
                entries.iter().find(|entry| (entry.0, entry.1) == (row, column)).map_or(0.0, |entry| entry.2)
            }
        }
    }

    /// Standard errors of these numbers: of the mean over the runs, from the scatter in their windows.
    pub fn std(runs: &[Columns]) -> [f64; NUMBERS.len()] {
        NUMBERS.map(|name| {
            let squares: f64 = runs.iter().map(|run| run.trim_std(name) * run.trim_std(name)).sum();
            libm::sqrt(squares) / runs.len().max(1) as f64
        })
    }

    /// Change of A [n x n] for a change of each number by its standard error, derivatives held.
    pub fn steps(&self, std: [f64; NUMBERS.len()], states: &[String]) -> Vec<DMatrix<f64>> {
        let count = states.len();
        let known = |reference_trim: &ReferenceTrim| {
            DMatrix::from_fn(count, count, |i, j| match (states.get(i), states.get(j)) {
                (Some(state), Some(variable)) => reference_trim.known(state, variable),
                _ => 0.0,
            })
        };
        let [airspeed, alpha, beta, theta, phi] = std;
        let at = *self;
        let perturbed = [
            ReferenceTrim { airspeed: at.airspeed + airspeed, ..at },
            ReferenceTrim { alpha: at.alpha + alpha, ..at },
            ReferenceTrim { beta: at.beta + beta, ..at },
            ReferenceTrim { theta: at.theta + theta, ..at },
            ReferenceTrim { phi: at.phi + phi, ..at },
        ];
        perturbed
            .iter()
            .map(|perturbed| known(perturbed) - known(&at))
            .filter(|step| step.iter().all(|x| x.is_finite()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::linear::state_matrix;
    use crate::flight::model::{LinearModel, Trim};

    #[test]
    fn known_entries_are_those_of_the_simulation() {
        let reference_trim = ReferenceTrim { airspeed: 52.0, alpha: -0.03, beta: 0.17, theta: 0.04, phi: 0.2 };
        let [u, v, w] = reference_trim.velocity();
        let trim = Trim { u, v, w, phi: reference_trim.phi, theta: reference_trim.theta, rotor_speed: None, controls: [0.0; 4] };
        let whole = state_matrix(&LinearModel::about(trim));
        let states = ["u", "w", "q", "theta", "v", "p", "phi", "r"];
        for (i, state) in states.into_iter().enumerate() {
            for (j, variable) in states.into_iter().enumerate() {
                assert!((reference_trim.known(state, variable) - whole[(i, j)]).abs() < 1e-12, "{state} {variable}");
            }
        }
    }
}
