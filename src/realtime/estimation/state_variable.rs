//! State-variable filter: every signal through the same causal low-pass, with the exact derivative of its output.
//!
//! Consumes one row of signals a sample, at uneven times, some of them not sampled, and the instants that are asked for;
//! produces every signal y and its derivative y' at those instants, both states of
//!     y''/omega^2 + 2 y'/omega + y = x                                                            (1)
//! The same linear filter for all commutes with differentiation: where dx/dt = a x + b z, the filtered signals obey the same
//! equation but for the transient of the start, exp(-omega t) (1 + omega t) of the acceleration there. All are delayed by the
//! same 2/omega at low frequency, so no signal is skewed against another.
//! Between samples x = x_0 + s t is a straight line, as the conventions say, and with e = exp(-omega t)
//!     y = x_0 + s t - 2 s/omega + (c + d t) e          c = y_0 - x_0 + 2 s/omega                  (2)
//!     y' = s + (d - omega (c + d t)) e                 d = y'_0 - s + omega c
//! exactly, at any interval. A signal that comes more slowly than the others is not held: an instant waits for each signal's
//! next sample.
//! Source: P. C. Young, Automatica 17(1), 1981, pp. 23-39 (state-variable filters); L. Ljung, System Identification, 2nd ed.,
//! 1999, ch. 7 (one prefilter for all signals of a linear regression).
//! Returns NaN of a signal within `SETTLED`/omega of its first sample, or of the first after a gap.

/// Settling time in 1/omega, after which 4 % of the transient are left.
pub const SETTLED: f64 = 5.0;

/// Length of a gap of all signals, in 1/omega.
const HOLE: f64 = 2.5;

/// Instants that can wait for a signal's next sample; the oldest is dropped where more are requested.
const WAITING: usize = 8;

/// One signal's filter, brought up to its last sample.
#[derive(Clone, Copy, Debug)]
struct Filter {
    /// The first sample, and the last one.
    began_s: f64,
    last_s: f64,
    x: f64,
    y: f64,
    slope: f64,
}

impl Filter {
    const NEW: Filter = Filter { began_s: f64::NAN, last_s: f64::NAN, x: f64::NAN, y: f64::NAN, slope: f64::NAN };

    /// At rest at its first sample.
    fn begin(time_s: f64, x: f64) -> Self {
        Filter { began_s: time_s, last_s: time_s, x, y: x, slope: 0.0 }
    }

    /// y and y' so long after the last sample, (2), the signal rising by `rise` a second.
    fn after(&self, t: f64, rise: f64, omega: f64) -> (f64, f64) {
        let behind = 2.0 * rise / omega;
        let c = self.y - self.x + behind;
        let d = self.slope - rise + omega * c;
        let (free, e) = (c + d * t, libm::exp(-omega * t));
        (self.x + rise * t - behind + free * e, rise + (d - omega * free) * e)
    }
}

/// Every signal at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered<const S: usize> {
    /// When it was asked for; the signals are those of 2/omega earlier, s.
    pub time_s: f64,
    /// How far apart instants are, as it was asked for, s.
    pub interval_s: f64,
    /// Filtered signals.
    pub value: [f64; S],
    /// Their derivatives, 1/s.
    pub slope: [f64; S],
}

/// The same filter for `S` signals, at most 32.
#[derive(Clone, Debug)]
pub struct StateVariable<const S: usize> {
    omega: f64,
    hold_s: f64,
    newest_s: f64,
    filters: [Filter; S],
    waiting: [Filtered<S>; WAITING],
    /// A bit for each signal that an instant has.
    have: [u32; WAITING],
    first: usize,
    len: usize,
}

impl<const S: usize> StateVariable<S> {
    const FITS: () = assert!(S <= 32, "a bit for each signal");

    /// Filter of that omega, rad/s; an instant waits for a signal for at most `hold_s`.
    pub const fn new(omega: f64, hold_s: f64) -> Self {
        let () = Self::FITS;
        let none = Filtered { time_s: 0.0, interval_s: 0.0, value: [f64::NAN; S], slope: [f64::NAN; S] };
        StateVariable {
            omega,
            hold_s,
            newest_s: f64::NAN,
            filters: [Filter::NEW; S],
            waiting: [none; WAITING],
            have: [0; WAITING],
            first: 0,
            len: 0,
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.newest_s = f64::NAN;
        self.filters = [Filter::NEW; S];
        self.len = 0;
    }

    /// How late the filtered signals are at low frequency, 2/omega, s.
    pub fn delay_s(&self) -> f64 {
        2.0 / self.omega
    }

    /// Asks for an instant: after the newest sample, and not after the next one.
    pub fn ask(&mut self, time_s: f64, interval_s: f64) {
        if self.len == WAITING {
            self.first = (self.first + 1) % WAITING;
            self.len -= 1;
        }
        let place = (self.first + self.len) % WAITING;
        self.waiting[place] = Filtered { time_s, interval_s, value: [f64::NAN; S], slope: [f64::NAN; S] };
        self.have[place] = 0;
        self.len += 1;
    }

    /// A sample: signals that were not sampled are NaN. Times must increase.
    pub fn push(&mut self, time_s: f64, row: &[f64; S]) {
        if time_s - self.newest_s > HOLE / self.omega {
            self.clear();
        }
        self.newest_s = time_s;
        for (signal, &x) in row.iter().enumerate() {
            if !x.is_nan() {
                self.sampled(signal, time_s, x);
            }
        }
    }

    /// A signal's next sample: its filter comes up to it, past the instants between.
    fn sampled(&mut self, signal: usize, time_s: f64, x: f64) {
        let before = self.filters[signal];
        let interval = time_s - before.last_s;
        let goes_on = interval > 0.0 && interval <= self.hold_s;
        let rise = (x - before.x) / interval;
        for age in 0..self.len {
            let place = (self.first + age) % WAITING;
            let instant = &mut self.waiting[place];
            if self.have[place] >> signal & 1 == 1 || instant.time_s > time_s {
                continue;
            }
            self.have[place] |= 1 << signal;
            if goes_on && instant.time_s - before.began_s >= SETTLED / self.omega {
                (instant.value[signal], instant.slope[signal]) = before.after(instant.time_s - before.last_s, rise, self.omega);
            }
        }
        self.filters[signal] = if goes_on {
            let (y, slope) = before.after(interval, rise, self.omega);
            Filter { last_s: time_s, x, y, slope, ..before }
        } else {
            Filter::begin(time_s, x)
        };
    }

    /// The oldest instant, once every signal has come that has not kept away for longer than the hold.
    pub fn take(&mut self) -> Option<Filtered<S>> {
        if self.len == 0 {
            return None;
        }
        let have = self.have[self.first];
        let is_there =
            |(signal, filter): (usize, &Filter)| have >> signal & 1 == 1 || !(self.newest_s - filter.last_s <= self.hold_s);
        if !self.filters.iter().enumerate().all(is_there) {
            return None;
        }
        let instant = self.waiting[self.first];
        self.first = (self.first + 1) % WAITING;
        self.len -= 1;
        Some(instant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = 12.0;

    /// Filter answers at multiples of 0.08 s for samples at those times; `None`: not sampled.
    fn run<const S: usize>(times: &[f64], row: impl Fn(usize, f64) -> [f64; S]) -> Vec<Filtered<S>> {
        let mut filter = StateVariable::<S>::new(OMEGA, 0.5);
        let (mut out, mut next_s) = (Vec::new(), 0.0);
        for (i, &t) in times.iter().enumerate() {
            while next_s <= t {
                filter.ask(next_s, 0.08);
                next_s += 0.08;
            }
            filter.push(t, &row(i, t));
            out.extend(std::iter::from_fn(|| filter.take()));
        }
        out
    }

    fn even(interval_s: f64, seconds: f64) -> Vec<f64> {
        (0..(seconds / interval_s) as usize).map(|i| interval_s * i as f64).collect()
    }

    /// Intervals between 1 and 40 ms, in no order.
    fn uneven(seconds: f64) -> Vec<f64> {
        let (mut times, mut t, mut state) = (Vec::new(), 0.0, 1u64);
        while t < seconds {
            times.push(t);
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            t += 0.001 + 0.039 * (state >> 40) as f64 / (1u64 << 24) as f64;
        }
        times
    }

    #[test]
    fn a_ramp_follows_the_closed_form_at_any_sampling() {
        // From rest at x_0: y = x_0 + s t - 2 s/omega + s (2/omega + t) e.
        let (start, rise) = (3.0, -2.0);
        for times in [even(0.01, 3.0), even(0.125, 3.0), uneven(3.0)] {
            let out = run(&times, |_, t| [start + rise * t]);
            let settled: Vec<_> = out.iter().filter(|instant| instant.value[0].is_finite()).collect();
            assert!(settled.len() > 28, "{}", settled.len());
            for instant in settled {
                let (t, e) = (instant.time_s, libm::exp(-OMEGA * instant.time_s));
                let y = start + rise * t - 2.0 * rise / OMEGA + rise * (2.0 / OMEGA + t) * e;
                let slope = rise - rise * (1.0 + OMEGA * t) * e;
                assert!(t >= SETTLED / OMEGA);
                assert!((instant.value[0] - y).abs() < 1e-12 && (instant.slope[0] - slope).abs() < 1e-11, "{t}: {instant:?}");
            }
        }
    }

    #[test]
    fn a_sine_comes_out_with_the_amplitude_and_phase_of_the_filter() {
        for hz in [0.2, 1.0, 2.0] {
            let w = 2.0 * core::f64::consts::PI * hz;
            let out = run(&even(0.001, 6.0), |_, t| [libm::sin(w * t)]);
            let gain = 1.0 / (1.0 + (w / OMEGA) * (w / OMEGA));
            let phase = -2.0 * libm::atan(w / OMEGA);
            for instant in out.iter().filter(|instant| instant.time_s > 3.0) {
                let angle = w * instant.time_s + phase;
                assert!((instant.value[0] - gain * libm::sin(angle)).abs() < 1e-5, "{hz} Hz");
                assert!((instant.slope[0] - gain * w * libm::cos(angle)).abs() < 1e-4, "{hz} Hz");
            }
        }
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_value() {
        // Instants 1e-4 s apart under rough signals at uneven times.
        let mut filter = StateVariable::<1>::new(OMEGA, 0.5);
        let mut checked = 0;
        let mut near: Vec<Filtered<1>> = Vec::new();
        for (i, t) in uneven(2.0).into_iter().enumerate() {
            if i > 60 {
                (1..=3).for_each(|k| filter.ask(t - 6e-4 + 1e-4 * f64::from(k), 0.08));
            }
            filter.push(t, &[libm::sin(40.0 * t) + if i % 3 == 0 { 1.0 } else { 0.0 }]);
            near.clear();
            near.extend(std::iter::from_fn(|| filter.take()));
            if let [before, now, after] = near[..] {
                let difference = (after.value[0] - before.value[0]) / 2e-4;
                // y'' jumps by omega^2 x', x' < 2e3/s, in its slope: the difference is off by less than 3e5 h^2/6.
                assert!((difference - now.slope[0]).abs() < 5e-4, "{difference} {now:?}");
                checked += 1;
            }
        }
        assert!(checked > 20, "{checked}");
    }

    #[test]
    fn a_linear_equation_holds_between_filtered_signals() {
        // dx/dt = -0.7 x + 3 z, z steps; x and z every 5 ms, x exact for z a straight line between them.
        let (a, b, dt) = (-0.7, 3.0, 0.005);
        let z = |i: usize| if (i / 140).is_multiple_of(2) { 0.0 } else { 1.0 };
        let mut x = vec![0.0];
        for i in 1..2000 {
            let (z0, s) = (z(i - 1), (z(i) - z(i - 1)) / dt);
            // Particular solution -(b/a)(z0 + s t) - b s/a^2.
            let offset = -b / a * z0 - b * s / (a * a);
            x.push((x[i - 1] - offset) * libm::exp(a * dt) + offset - b / a * s * dt);
        }
        let out = run(&even(dt, 10.0), |i, _| [x[i], z(i)]);
        let mut largest = 0.0_f64;
        for instant in out.iter().filter(|instant| instant.value[0].is_finite()) {
            let error = instant.slope[0] - a * instant.value[0] - b * instant.value[1];
            assert!(error.abs() < 2e-3, "{instant:?}: {error}");
            largest = largest.max(instant.slope[0].abs());
        }
        assert!(largest > 1.0, "{largest}");
    }

    #[test]
    fn a_slow_signal_is_not_late_behind_a_fast_one() {
        let out = run(&even(0.01, 4.0), |i, t| [libm::sin(t), if i % 10 == 0 { libm::sin(t) } else { f64::NAN }]);
        assert!(out.len() > 45);
        for instant in out.iter().filter(|instant| instant.time_s > 1.0) {
            // Straight lines 0.1 s long lie h^2/12 = 0.0008 inside the curve in the mean; held, it would be 0.05 off.
            assert!((instant.value[0] - instant.value[1]).abs() < 0.002, "{instant:?}");
        }
    }

    #[test]
    fn after_a_hole_nothing_is_told_until_the_filter_has_settled() {
        let mut times = even(0.01, 2.0);
        times.extend(even(0.01, 2.0).iter().map(|t| t + 2.3));
        let out = run(&times, |_, t| [t]);
        let told = |instant: &Filtered<1>| instant.value[0].is_finite();
        assert!(
            out.iter().filter(|instant| told(instant)).all(|instant| !(1.99..2.3 + SETTLED / OMEGA).contains(&instant.time_s))
        );
        assert!(out.iter().any(|instant| told(instant) && instant.time_s > 2.8));
    }

    #[test]
    fn a_signal_that_stops_or_never_came_holds_nothing_up() {
        let out = run(&even(0.01, 4.0), |_, t| [t, if t < 2.0 { 1.0 } else { f64::NAN }, f64::NAN]);
        assert!(out.iter().all(|instant| instant.value[2].is_nan()));
        assert!(out.iter().any(|instant| instant.time_s < 1.95 && instant.value[1].is_finite()));
        let late: Vec<_> = out.iter().filter(|instant| instant.time_s > 2.6).collect();
        assert!(late.len() > 15 && late.iter().all(|instant| instant.value[0].is_finite() && instant.value[1].is_nan()));
    }
}
