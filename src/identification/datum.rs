//! The trim that a model is about, and what gravity and the flight speed do there to each state.
//!
//! Consumes the trims of the runs; produces their means, standard errors of those, and the entries of A that are known: (1) to
//! (7) of `linear`. A number of the trim that was not recorded is taken as zero, and noted.
//! Refused: runs at different speeds.

use super::columns::Columns;
use super::linear::NoModel;
use crate::flight::unit::STANDARD_GRAVITY as G0;
use nalgebra::DMatrix;

/// Part by which trims of runs that are flown as one may differ in airspeed.
pub const SAME_SPEED: f64 = 0.1;

/// Channels that the numbers of a trim are read from, in the order of [`Datum`].
pub(super) const NUMBERS: [&str; 5] = ["tas", "alpha", "beta", "theta", "phi"];

/// The trim that a model is about: means over the runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Datum {
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

impl Datum {
    /// Means over the runs of their trims; what a run did not record is taken as zero, and noted.
    ///
    /// # Errors
    /// [`NoModel`] where runs differ in airspeed, or one that is needed was not recorded.
    pub fn of(runs: &[Columns], needs_speed: bool, notes: &mut Vec<String>) -> Result<Self, NoModel> {
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
                        return Err(NoModel::Speeds {
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
        Ok(Datum { airspeed, alpha, beta, theta, phi })
    }

    /// u0 v0 w0, m/s.
    pub fn velocity(&self) -> [f64; 3] {
        let ((sin_alpha, cos_alpha), (sin_beta, cos_beta)) = (libm::sincos(self.alpha), libm::sincos(self.beta));
        [cos_alpha * cos_beta, sin_beta, sin_alpha * cos_beta].map(|part| self.airspeed * part)
    }

    /// Slopes of `beta`, `alpha` and `tas` over the three components of the velocity that they meet, (8) of `linear`.
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

    /// The known coefficient of a variable in a state's row, (1) to (7) of `linear`.
    pub fn known(&self, state: &str, variable: &str) -> f64 {
        let Datum { airspeed, theta, phi, .. } = *self;
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
        let known = |datum: &Datum| {
            DMatrix::from_fn(count, count, |i, j| match (states.get(i), states.get(j)) {
                (Some(state), Some(variable)) => datum.known(state, variable),
                _ => 0.0,
            })
        };
        let [airspeed, alpha, beta, theta, phi] = std;
        let at = *self;
        let moved = [
            Datum { airspeed: at.airspeed + airspeed, ..at },
            Datum { alpha: at.alpha + alpha, ..at },
            Datum { beta: at.beta + beta, ..at },
            Datum { theta: at.theta + theta, ..at },
            Datum { phi: at.phi + phi, ..at },
        ];
        moved.iter().map(|moved| known(moved) - known(&at)).filter(|step| step.iter().all(|x| x.is_finite())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::model::{LinearModel, Trim};
    use crate::simulation::linear::state_matrix;

    #[test]
    fn known_entries_are_those_of_the_simulation() {
        let datum = Datum { airspeed: 52.0, alpha: -0.03, beta: 0.17, theta: 0.04, phi: 0.2 };
        let [u, v, w] = datum.velocity();
        let trim = Trim { u, v, w, phi: datum.phi, theta: datum.theta, rotor_speed: None, controls: [0.0; 4] };
        let whole = state_matrix(&LinearModel::about(trim));
        let states = ["u", "w", "q", "theta", "v", "p", "phi", "r"];
        for (i, state) in states.into_iter().enumerate() {
            for (j, variable) in states.into_iter().enumerate() {
                assert!((datum.known(state, variable) - whole[(i, j)]).abs() < 1e-12, "{state} {variable}");
            }
        }
    }
}
