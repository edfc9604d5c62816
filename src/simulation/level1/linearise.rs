//! Linearisation about a trim: derivatives by finite differences, and the whole system with its internal states.
//!
//! Consumes a trim; produces the derivatives of specific force and angular acceleration with respect to velocity, rates, controls
//! and rotor speed (`linear` adds the kinematics), internal states quasi-steady and rotor speed held. Differences of five points,
//!     f'(x) = [8 (f(x + h) - f(x - h)) - (f(x + 2h) - f(x - 2h))]/(12 h)                               (1)
//! whose error is of the order of h^4 (of h at rest, where forces vary as V|V|), or, as an option, of two points with the
//! finite half widths that the model gives,
//!     f'(x) = [f(x + h) - f(x - h)]/(2 h)                                                              (2)
//! which includes nonlinearity: the fin, with little lift at small sideslip, makes N_v grow with h. The states of the whole
//! system are u w q theta v p phi r and the active internal ones; its eigenvalues include the modes of rotor and engine.

use super::aircraft::{Equations, Situation};
use super::inflow::InflowGuess;
use super::internal_states::{INNER, InternalStates};
use super::trim::{Trimmed, situation};
use crate::flight::control::CONTROLS;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::flight::model::LinearModel;
use crate::num::eigen::eigenvalues_8;
use crate::simulation::motion::Motion;
use nalgebra::{Complex, SMatrix, Schur};

/// Half widths for (1): velocity m/s, rate rad/s, control rad, part of the rotor speed.
const SMALL: [f64; 4] = [5e-3, 5e-4, 5e-4, 5e-4];

/// States of the whole system.
const WHOLE: usize = 8 + INNER;

impl Trimmed {
    /// The linear model about this trim, tolerances and effects left to the caller.
    pub fn linear(&self) -> LinearModel {
        let mut model = LinearModel::about(self.trim);
        let finite = self.aircraft.options.finite_perturbation.then_some(self.aircraft.perturbation);
        for variable in Variable::ALL {
            let small = match variable {
                Variable::U | Variable::V | Variable::W => (SMALL[0], finite.map(|sizes| sizes.velocity)),
                Variable::P | Variable::Q | Variable::R => (SMALL[1], finite.map(|sizes| sizes.rate)),
                _ => (SMALL[2], finite.map(|sizes| sizes.control)),
            };
            let slopes = differences(small, |by| self.accelerations_at(variable, by));
            for axis in Axis::ALL {
                *model.derivative_mut(axis, variable) = slopes[axis.index()];
            }
        }
        let nominal = self.aircraft.main_rotor.speed;
        model.rotor_speed = differences((SMALL[3] * nominal, None), |by| {
            let mut met = self.situation();
            met.rotor_speed += by;
            self.aircraft.respond(&met).accelerations
        });
        model
    }

    /// The situation of the trim.
    pub fn situation(&self) -> Situation {
        let trim = &self.trim;
        let velocity = [trim.u, trim.v, trim.w];
        situation(velocity, [0.0; 3], trim.controls, self.aircraft.main_rotor.speed, self.condition.density)
    }

    fn accelerations_at(&self, variable: Variable, by: f64) -> [f64; AXES] {
        let mut met = self.situation();
        let place = match variable {
            Variable::U => &mut met.velocity[0],
            Variable::V => &mut met.velocity[1],
            Variable::W => &mut met.velocity[2],
            Variable::P => &mut met.rates[0],
            Variable::Q => &mut met.rates[1],
            Variable::R => &mut met.rates[2],
            control => &mut met.blade[control.index() - Variable::LonCyclic.index()],
        };
        *place += by;
        self.aircraft.respond(&met).accelerations
    }

    /// Eigenvalues of the whole system, those of states that the options leave out left out; `None` where they cannot be
    /// computed.
    pub fn whole_eigenvalues(&self) -> Option<Vec<Complex<f64>>> {
        let active = self.aircraft.options.active();
        let count = 8 + active.iter().filter(|&&active| active).count();
        // A state that is left out stands alone with an eigenvalue that no aircraft has.
        const APART: f64 = -1e7;
        let mut a = SMatrix::<f64, WHOLE, WHOLE>::from_diagonal_element(APART);
        let places: Vec<usize> = (0..8).chain((0..INNER).filter(|&place| active[place]).map(|place| 8 + place)).collect();
        let (centre, equations) = (self.whole_state(), self.aircraft.equations());
        for &column in &places {
            let size = match column {
                0 | 1 | 4 => SMALL[0],
                2 | 5 | 7 => SMALL[1],
                3 | 6 => SMALL[2],
                _ if column == 8 + 8 => 1e-3 * centre[column],
                _ if column == 8 + 9 => 1.0,
                _ if column == 8 + 7 => SMALL[3] * centre[column],
                // So small that no actuator meets its rate, five points wide.
                _ if column >= 8 + 10 => self
                    .aircraft
                    .actuators
                    .get(column - (8 + 10))
                    .map_or(1e-4, |actuator| f64::min(1e-4, 0.2 * actuator.tau * actuator.rate)),
                _ => 1e-4,
            };
            let slopes = differences((size, None), |by| {
                let mut state = centre;
                state[column] += by;
                self.whole_rates(&equations, &state)
            });
            for &row in &places {
                a[(row, column)] = slopes[row];
            }
        }
        if !a.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        if count == 8 {
            let entries = core::array::from_fn(|row| core::array::from_fn(|column| a[(row, column)]));
            return Some(eigenvalues_8(&entries)?.to_vec());
        }
        let mut roots: Vec<Complex<f64>> = Schur::try_new(a, f64::EPSILON, 2000)?.complex_eigenvalues().iter().copied().collect();
        roots.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
        roots.truncate(count);
        Some(roots)
    }

    /// u w q theta v p phi r and the inner states in trim.
    fn whole_state(&self) -> [f64; WHOLE] {
        let trim = &self.trim;
        let mut state = [0.0; WHOLE];
        let motion = [trim.u, trim.w, 0.0, trim.theta, trim.v, 0.0, trim.phi, 0.0];
        for (place, value) in state.iter_mut().zip(motion.into_iter().chain(self.inner.to_vector())) {
            *place = value;
        }
        state
    }

    fn whole_rates(&self, equations: &Equations<'_>, state: &[f64; WHOLE]) -> [f64; WHOLE] {
        let [u, w, q, theta, v, p, phi, r, inner @ ..] = *state;
        let met = Situation { velocity: [u, v, w], rates: [p, q, r], ..self.situation() };
        let instant =
            self.instant(equations, (&met, &InternalStates::from_vector(inner), InflowGuess::NONE), &[1.0; CONTROLS], |_, _| {
                None
            });
        let [ax, ay, az, dp, dq, dr] = instant.response.accelerations;
        let motion = Motion { velocity: met.velocity, rates: met.rates, attitude: [phi, theta, 0.0], altitude: 0.0 };
        let change = motion.rate_of_change([ax, ay, az], [dp, dq, dr]);
        let ([du, dv, dw], [dphi, dtheta, _]) = (change.velocity, change.attitude);
        let mut rates = [0.0; WHOLE];
        let motion = [du, dw, dq, dtheta, dv, dp, dphi, dr];
        for (place, value) in rates.iter_mut().zip(motion.into_iter().chain(instant.rates.to_vector())) {
            *place = value;
        }
        rates
    }
}

/// (2) where a finite half width is given, else (1) with the small one.
fn differences<const N: usize>((small, finite): (f64, Option<f64>), f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let pair = |h: f64| {
        let (up, down) = (f(h), f(-h));
        core::array::from_fn::<f64, N, _>(|i| up[i] - down[i])
    };
    match finite {
        Some(h) => pair(h).map(|difference| difference / (2.0 * h)),
        None => {
            let (near, far) = (pair(small), pair(2.0 * small));
            core::array::from_fn(|i| (8.0 * near[i] - far[i]) / (12.0 * small))
        }
    }
}
