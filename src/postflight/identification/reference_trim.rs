//! The reference trim of a model, and the entries of A that it determines (gravity, flight speed).
//!
//! Consumes the trims of the runs; produces their means, the standard errors of these, and the known entries of A: (1) to (7) of
//! `identification_model`. A trim value that was not recorded is taken as zero, and noted.
//! Refused: runs at different airspeeds.

use super::columns::Columns;
use super::model_variables::IdentificationModelError;
use crate::flight::unit::STANDARD_GRAVITY as G0;
use nalgebra::DMatrix;

/// Part by which trims of runs that are flown as one may differ in airspeed.
pub const SAME_SPEED: f64 = 0.1;

/// Channels that the numbers of a trim are read from, in the order of [`ReferenceTrim`].
pub(crate) const NUMBERS: [&str; 5] = ["tas", "alpha", "beta", "theta", "phi"];

/// The trim that a model is about: means over the runs.
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
    /// Means over the runs of their trims; what a run did not record is taken as zero, and noted.
    ///
    /// # Errors
    /// [`IdentificationModelError`] where runs differ in airspeed, or one that is needed was not recorded.
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
        let ((sin_alpha, cos_alpha), (sin_beta, cos_beta)) = (libm::sincos(self.alpha), libm::sincos(self.beta));
        [cos_alpha * cos_beta, sin_beta, sin_alpha * cos_beta].map(|part| self.airspeed * part)
    }

    /// Slopes of `beta`, `alpha` and `tas` over the three components of the velocity that they meet, (8) of
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
        let ReferenceTrim { airspeed, theta, phi, .. } = *self;
        let [u0, v0, w0] = self.velocity();
        let (sin_theta, cos_theta) = libm::sincos(theta);
        let (sin_phi, cos_phi) = libm::sincos(phi);
        match (state, variable) {
            ("u", "q") => -w0,
            ("u", "r") => v0,
            ("u", "theta") => -G0 * cos_theta,
            ("v", "p") => w0,
            ("v", "r") => -u0,
            ("v", "theta") => -G0 * sin_theta * sin_phi,
            ("v", "phi") => G0 * cos_theta * cos_phi,
            ("w", "p") => -v0,
            ("w", "q") => u0,
            ("w", "theta") => -G0 * sin_theta * cos_phi,
            ("w", "phi") => -G0 * cos_theta * sin_phi,
            ("beta", _) => self.known("v", variable) / airspeed,
            ("alpha", "p" | "theta" | "phi") => self.known("w", variable) / airspeed,
            ("alpha", "q") | ("phi", "p") => 1.0,
            ("phi", "q") => sin_theta / cos_theta * sin_phi,
            ("phi", "r") => sin_theta / cos_theta * cos_phi,
            ("theta", "q") => cos_phi,
            ("theta", "r") => -sin_phi,
            _ => 0.0,
        }
    }

    /// Standard errors of these numbers: of the mean over the runs, from the scatter in their windows.
    pub fn std(runs: &[Columns]) -> [f64; NUMBERS.len()] {
        NUMBERS.map(|name| {
            let squares: f64 = runs.iter().map(|run| run.trim_std(name) * run.trim_std(name)).sum();
            libm::sqrt(squares) / runs.len().max(1) as f64
        })
    }

    /// How A moves with each of these numbers out by its standard error, all derivatives held.
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
        let moved = [
            ReferenceTrim { airspeed: at.airspeed + airspeed, ..at },
            ReferenceTrim { alpha: at.alpha + alpha, ..at },
            ReferenceTrim { beta: at.beta + beta, ..at },
            ReferenceTrim { theta: at.theta + theta, ..at },
            ReferenceTrim { phi: at.phi + phi, ..at },
        ];
        moved.iter().map(|moved| known(moved) - known(&at)).filter(|step| step.iter().all(|x| x.is_finite())).collect()
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
