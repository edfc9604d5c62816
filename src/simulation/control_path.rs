//! The path from the pilot's control to the blade: dead zone, mixing, delay, rate limit, lag.
//!
//! Consumes the pilot's controls as deviations from trim and the effects; produces the blade's deviations at the
//! times asked for. In the order in which they stand between hand and blade, whatever their order in the list:
//!     dead zone of each control, cross feeds (of the deviations past the dead zones, each from the pilot's own
//!     control: a feed does not feed on another), transport delay, rate limit, and last the lag
//!     tau y' = x - y                                                                     (1)
//! Several of one kind on one control act one after the other. All but (1) are exact on straight lines; with x a straight
//! line over a step h, x(t) = x0 + s t, (1) has the exact solution that is used here
//!     y(h) = x(h) - s tau + (y(0) - x0 + s tau) exp(-h / tau)                            (2)
//! The control effectiveness is not here: it changes derivatives (`linear`).

use super::history::History;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::effect::Effect;

/// The way of each control up to its lags.
#[derive(Clone, Debug)]
pub(crate) struct ControlPath {
    commanded: [History; CONTROLS],
    lags: [Vec<f64>; CONTROLS],
}

impl ControlPath {
    /// The path of these deviations from trim.
    pub(crate) fn new(deviations: &[History; CONTROLS], effects: &[Effect]) -> Self {
        let past_dead_zone: [History; CONTROLS] = Control::ALL.map(|control| {
            let mut moved = deviations[control.index()].clone();
            for effect in effects {
                match *effect {
                    Effect::DeadZone { control: c, half_width } if c == control => moved = moved.with_dead_zone(half_width),
                    _ => {}
                }
            }
            moved
        });
        let commanded = Control::ALL.map(|control| {
            let mut moved = past_dead_zone[control.index()].clone();
            for effect in effects {
                match *effect {
                    Effect::CrossFeed { from, to, gain } if to == control => {
                        moved = moved.plus(gain, &past_dead_zone[from.index()])
                    }
                    _ => {}
                }
            }
            for effect in effects {
                match *effect {
                    Effect::TransportDelay { control: c, delay } if c == control => moved = moved.delayed(delay),
                    _ => {}
                }
            }
            for effect in effects {
                match *effect {
                    Effect::RateLimit { control: c, rate } if c == control => moved = moved.with_rate_limit(rate),
                    _ => {}
                }
            }
            moved
        });
        let lags = Control::ALL.map(|control| {
            let of = |effect: &Effect| match *effect {
                Effect::ActuatorLag { control: c, tau } if c == control && tau > 0.0 => Some(tau),
                _ => None,
            };
            effects.iter().filter_map(of).collect()
        });
        ControlPath { commanded, lags }
    }

    /// Times where a commanded line bends, s.
    pub(crate) fn bends(&self) -> impl Iterator<Item = f64> {
        self.commanded.iter().flat_map(History::times)
    }

    /// The blade's deviations at these increasing times, steady before the first of them.
    pub(crate) fn blade(&self, times_s: &[f64]) -> Vec<[f64; CONTROLS]> {
        let mut blade = vec![[0.0; CONTROLS]; times_s.len()];
        for control in Control::ALL {
            let commanded = &self.commanded[control.index()];
            let mut line: Vec<f64> = times_s.iter().map(|&time_s| commanded.at(time_s)).collect();
            for &tau in &self.lags[control.index()] {
                lag(times_s, &mut line, tau);
            }
            for (place, value) in blade.iter_mut().zip(line) {
                place[control.index()] = value;
            }
        }
        blade
    }
}

/// First-order lag of straight lines between these times, equation (2), in place; it starts settled.
pub(crate) fn lag(times_s: &[f64], values: &mut [f64], tau: f64) {
    let Some(&(mut x0)) = values.first() else { return };
    let mut y = x0;
    let steps = times_s.iter().zip(times_s.iter().skip(1));
    for ((t0, t1), value) in steps.zip(values.iter_mut().skip(1)) {
        let (h, x1) = (t1 - t0, *value);
        if h > 0.0 {
            let s_tau = (x1 - x0) / h * tau;
            y = x1 - s_tau + (y - x0 + s_tau) * libm::exp(-h / tau);
        }
        (x0, *value) = (x1, y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp_on_pedal() -> [History; CONTROLS] {
        let still = History::constant(0.0);
        [still.clone(), still.clone(), still, History::through(vec![(1.0, 0.0), (2.0, 1.0)]).unwrap()]
    }

    #[test]
    fn the_lag_of_a_ramp_is_the_closed_form() {
        let lagged = Effect::ActuatorLag { control: Control::Pedal, tau: 0.25 };
        let path = ControlPath::new(&ramp_on_pedal(), &[lagged]);
        for steps in [5, 1000] {
            let times: Vec<f64> = (0..=steps).map(|k| 1.0 + f64::from(k) / f64::from(steps)).collect();
            let blade = path.blade(&times);
            let wanted = 1.0 - 0.25 + 0.25 * (-1.0f64 / 0.25).exp();
            assert!((blade.last().unwrap()[3] - wanted).abs() < 1e-12, "{steps}");
        }
    }

    #[test]
    fn effects_stand_in_the_order_of_the_path_whatever_the_order_of_the_list() {
        let mut effects = vec![
            Effect::TransportDelay { control: Control::LonCyclic, delay: 0.5 },
            Effect::CrossFeed { from: Control::Pedal, to: Control::LonCyclic, gain: 2.0 },
            Effect::DeadZone { control: Control::Pedal, half_width: 0.5 },
        ];
        let times = [0.0, 2.0, 2.25, 2.5, 9.0];
        let blade = ControlPath::new(&ramp_on_pedal(), &effects).blade(&times);
        let wanted = [(0.0, 0.0), (0.0, 0.5), (0.5, 0.5), (1.0, 0.5), (1.0, 0.5)];
        for (found, (lon_cyclic, pedal)) in blade.iter().zip(wanted) {
            assert_eq!((found[0], found[3]), (lon_cyclic, pedal));
        }
        effects.reverse();
        assert_eq!(ControlPath::new(&ramp_on_pedal(), &effects).blade(&times), blade);
    }
}
