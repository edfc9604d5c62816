//! A force or moment that no effect describes, with states of its own, to be added to a flight.
//!
//! Consumes the deviations from trim (velocity through the air, rates, blade positions) and the law's memory z; produces what is
//! added to the accelerations of the six axes, and the memory's rate:
//!     a_axis += f_axis(deviations, z),   dz/dt = g(deviations, z),   z = 0 at the start             (1)
//! It is integrated with the motion, so its rates are to be no faster than the model's own modes ask for.

use crate::flight::derivative::{AXES, VARIABLES};
use std::fmt;
use std::sync::Arc;

/// The law (1): accelerations by axis (m/s^2, rad/s^2) and the memory's rate, for deviations from trim and the memory.
pub type Law = dyn Fn(&[f64; VARIABLES], f64) -> ([f64; AXES], f64) + Send + Sync;

/// A law that is flown besides the model; two are equal where they are the same one.
#[derive(Clone)]
pub struct Unmodelled(Arc<Law>);

impl Unmodelled {
    /// That law.
    pub fn new(law: impl Fn(&[f64; VARIABLES], f64) -> ([f64; AXES], f64) + Send + Sync + 'static) -> Self {
        Unmodelled(Arc::new(law))
    }

    /// Equation (1).
    pub fn at(&self, deviations: &[f64; VARIABLES], memory: f64) -> ([f64; AXES], f64) {
        (self.0)(deviations, memory)
    }
}

impl PartialEq for Unmodelled {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for Unmodelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Unmodelled")
    }
}

#[cfg(test)]
mod tests {
    use super::super::fly::{Flight, uniform_times};
    use super::*;
    use crate::flight::derivative::{Axis, Variable};
    use crate::flight::model::{LinearModel, Trim};

    /// No derivative but L_p = -1; the law adds 0.2 - z with dz/dt = p: p'' + p' + p = 0, p'(0) = 0.2.
    #[test]
    fn a_memory_is_integrated_with_the_motion() {
        let mut model = LinearModel::about(Trim { u: 50.0, ..Trim::default() });
        *model.derivative_mut(Axis::L, Variable::P) = -1.0;
        let law = |deviations: &[f64; VARIABLES], memory: f64| {
            let mut added = [0.0; AXES];
            added[Axis::L.index()] = 0.2 - memory;
            (added, deviations[Variable::P.index()])
        };
        let times_s = uniform_times(0.0, 4.0, 10.0).unwrap();
        let flight = Flight { times_s, unmodelled: Some(Unmodelled::new(law)), ..Flight::of(model) };
        let truth = flight.fly().unwrap().truth;
        let omega = libm::sqrt(0.75);
        for state in &truth {
            let wanted = 0.2 / omega * libm::exp(-0.5 * state.time_s) * libm::sin(omega * state.time_s);
            assert!((state.motion.rates[0] - wanted).abs() < 1e-9, "{}: {}", state.time_s, state.motion.rates[0]);
        }
        assert_eq!(truth.len(), 41);
        assert_eq!((flight.clone(), format!("{:?}", flight.unmodelled)), (flight, "Some(Unmodelled)".to_owned()));
    }
}
