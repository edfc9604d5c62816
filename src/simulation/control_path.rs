//! The path from the pilot's control to the blade: dead zone, mixing, delay, rate limit, lag.
//!
//! Consumes the pilot's controls as deviations from trim and the effects; produces the blade's deviations at the
//! times asked for. In the order from pilot to blade, whatever their order in the list:
//!     dead zone of each control, cross feeds (of the deviations past the dead zones, each from the pilot's own
//!     control: a feed does not feed on another), transport delay, rate limit, and last the lag
//!     tau y' = x - y                                                                     (1)
//! Several of one kind on one control act one after the other. All but (1) are exact on straight lines; with x a straight
//! line over a step h, x(t) = x0 + s t, (1) has the exact solution that is used here
//!     y(h) = x(h) - s tau + (y(0) - x0 + s tau) exp(-h / tau)                            (2)
//! The controls are processed in segments, so that a pilot in the loop takes the same path.
//! The control effectiveness is not here: it changes derivatives (`linear`).

use crate::flight::control::{CONTROLS, Control};
use crate::flight::effect::Effect;
use crate::flight::signal::piecewise_linear::{History, RateLimiter};

/// The way of each control, with what is under way in it.
#[derive(Clone, Debug)]
pub(crate) struct ControlPath {
    ways: [Way; CONTROLS],
}

/// What stands between one control and its blade.
#[derive(Clone, Debug)]
struct Way {
    dead_zones: Vec<f64>,
    /// Place of the control that feeds into this one, and its gain.
    feeds: Vec<(usize, f64)>,
    delay_s: f64,
    limits: Vec<RateLimiter>,
    lags: Vec<Lag>,
    /// What has come through all but the lags; nothing before the first piece.
    commanded: Option<History>,
}

impl Way {
    fn of(control: Control, effects: &[Effect]) -> Self {
        let mut way = Way {
            dead_zones: Vec::new(),
            feeds: Vec::new(),
            delay_s: 0.0,
            limits: Vec::new(),
            lags: Vec::new(),
            commanded: None,
        };
        for effect in effects {
            match *effect {
                Effect::DeadZone { control: c, half_width } if c == control => way.dead_zones.push(half_width),
                Effect::CrossFeed { from, to, gain } if to == control => way.feeds.push((from.index(), gain)),
                Effect::TransportDelay { control: c, delay } if c == control => way.delay_s += delay,
                Effect::RateLimit { control: c, rate } if c == control => way.limits.push(RateLimiter::new(rate)),
                Effect::ActuatorLag { control: c, tau } if c == control && tau > 0.0 => way.lags.push(Lag::new(tau)),
                _ => {}
            }
        }
        way
    }
}

impl ControlPath {
    /// The path that these effects make; nothing has moved.
    pub(crate) fn new(effects: &[Effect]) -> Self {
        ControlPath { ways: Control::ALL.map(|control| Way::of(control, effects)) }
    }

    /// What the pilot's controls do next, as deviations from trim: pieces that go on where the last ones ended.
    pub(crate) fn extend(&mut self, deviations: &[History; CONTROLS]) {
        let past_dead_zone: [History; CONTROLS] = Control::ALL.map(|control| {
            let (moved, way) = (deviations[control.index()].clone(), &self.ways[control.index()]);
            way.dead_zones.iter().fold(moved, |moved, &half_width| moved.with_dead_zone(half_width))
        });
        for control in Control::ALL {
            let way = &mut self.ways[control.index()];
            let mut moved = past_dead_zone[control.index()].clone();
            for &(from, gain) in &way.feeds {
                moved = past_dead_zone.get(from).map_or(moved.clone(), |feed| moved.plus(gain, feed));
            }
            moved = moved.delayed(way.delay_s);
            for limit in &mut way.limits {
                moved = limit.follow(&moved);
            }
            match &mut way.commanded {
                Some(commanded) => commanded.append(&moved),
                nothing => *nothing = Some(moved),
            }
        }
    }

    /// Times between these two where a commanded line bends, s.
    pub(crate) fn bends(&self, start_s: f64, end_s: f64) -> impl Iterator<Item = f64> {
        let commanded = self.ways.iter().filter_map(|way| way.commanded.as_ref());
        commanded.flat_map(move |history| {
            let first = history.points().partition_point(|&(time_s, _)| time_s < start_s);
            history.times().skip(first).take_while(move |&time_s| time_s <= end_s)
        })
    }

    /// The blade's deviations at these increasing times, steady before the first that was ever asked for; the next are asked
    /// for from the last of these on.
    pub(crate) fn blade(&mut self, times_s: &[f64]) -> Vec<[f64; CONTROLS]> {
        let mut blade = vec![[0.0; CONTROLS]; times_s.len()];
        for control in Control::ALL {
            let way = &mut self.ways[control.index()];
            let Some(commanded) = &way.commanded else { continue };
            if way.lags.is_empty() && commanded.points().iter().all(|&(_, moved)| moved == 0.0) {
                continue;
            }
            let mut after = times_s.first().map_or(0, |&first_s| commanded.points().partition_point(|&(t, _)| t <= first_s));
            let mut line: Vec<f64> = times_s.iter().map(|&time_s| commanded.at_next(time_s, &mut after)).collect();
            for lag in &mut way.lags {
                lag.follow(times_s, &mut line);
            }
            for (place, value) in blade.iter_mut().zip(line) {
                place[control.index()] = value;
            }
        }
        blade
    }
}

/// A first-order lag, equation (2), as its input comes in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lag {
    tau: f64,
    /// Time, input and output at the end of what came in.
    last: Option<(f64, f64, f64)>,
}

impl Lag {
    /// Nothing has come in; `tau` is more than zero.
    pub(crate) fn new(tau: f64) -> Self {
        Lag { tau, last: None }
    }

    /// The output at a time, the input a straight line since the last; the first time it is settled.
    pub(crate) fn step(&mut self, time_s: f64, input: f64) -> f64 {
        let output = match self.last {
            Some((t0, x0, y)) if time_s > t0 => {
                let h = time_s - t0;
                let s_tau = (input - x0) / h * self.tau;
                input - s_tau + (y - x0 + s_tau) * libm::exp(-h / self.tau)
            }
            Some((_, _, y)) => y,
            None => input,
        };
        self.last = Some((time_s, input, output));
        output
    }

    /// Straight lines between these times, in place.
    pub(crate) fn follow(&mut self, times_s: &[f64], values: &mut [f64]) {
        for (&time_s, value) in times_s.iter().zip(values) {
            *value = self.step(time_s, *value);
        }
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
        for steps in [5, 1000] {
            let mut path = ControlPath::new(&[lagged]);
            path.extend(&ramp_on_pedal());
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
        let blade_of = |effects: &[Effect]| {
            let mut path = ControlPath::new(effects);
            path.extend(&ramp_on_pedal());
            path.blade(&times)
        };
        let blade = blade_of(&effects);
        let wanted = [(0.0, 0.0), (0.0, 0.5), (0.5, 0.5), (1.0, 0.5), (1.0, 0.5)];
        for (found, (lon_cyclic, pedal)) in blade.iter().zip(wanted) {
            assert_eq!((found[0], found[3]), (lon_cyclic, pedal));
        }
        effects.reverse();
        assert_eq!(blade_of(&effects), blade);
    }

    #[test]
    fn piece_after_piece_is_the_whole() {
        let pedal = Control::Pedal;
        let effects = [
            Effect::DeadZone { control: pedal, half_width: 0.1 },
            Effect::CrossFeed { from: Control::Pedal, to: Control::LonCyclic, gain: 2.0 },
            Effect::TransportDelay { control: pedal, delay: 0.13 },
            Effect::RateLimit { control: pedal, rate: 0.6 },
            Effect::ActuatorLag { control: pedal, tau: 0.2 },
        ];
        let moved = ramp_on_pedal();
        let times: Vec<f64> = (0..=400).map(|k| f64::from(k) * 0.01).collect();
        let mut whole = ControlPath::new(&effects);
        whole.extend(&moved.clone().map(|history| history.until(4.0)));
        let (whole, mut path, mut pieces) = (whole.blade(&times), ControlPath::new(&effects), Vec::new());
        for (place, part) in times.chunks(40).enumerate() {
            let (start, end) = (times[40 * place], times[(40 * place + 40).min(400)]);
            path.extend(&moved.clone().map(|history| if place == 0 { history.until(end) } else { history.within(start, end) }));
            pieces.extend(path.blade(part));
        }
        for (a, b) in whole.iter().zip(&pieces) {
            assert!((a[0] - b[0]).abs() < 1e-12 && (a[3] - b[3]).abs() < 1e-12, "{a:?} {b:?}");
        }
        assert_eq!(whole.len(), pieces.len());
    }
}
