//! What the regression gets: every signal through one kernel, or through one causal filter, at the instants of its grid.
//!
//! Consumes samples with their filtered states; produces [`SmoothedRecord`]s, the run's trim, and the comparison of the vanes
//! with the kinematics. Velocity and attitude are the filter's through the kernel, and what the fixed-lag smoother has changed in
//! them since, which is slow, and the gusts that the air data measure; through the state-variable filter they are the filter's
//! alone.

use crate::dynamics::sensors::{flow_angles_at_foot, specific_force_at_foot};
use crate::flight::channel::Channel;
use crate::flight::sample::Sample;
use crate::realtime::estimation::config::RegressionStates;
use crate::realtime::estimation::consistency::{R2_CONTRARY, flow_angle_rates};
use crate::realtime::estimation::delay_line::Smoothed;
use crate::realtime::estimation::estimator::{
    AIRSPEED_SIGNAL, CONTROL_SIGNALS, Estimator, INSTANTS, KINEMATIC_SIGNALS, SIGNALS, VANE_SIGNALS,
};
use crate::realtime::estimation::gust_velocity::SmoothedReading;
use crate::realtime::estimation::process::{ATTITUDE, SCALE_ERROR, VELOCITY};
use crate::realtime::estimation::record::{Aid, EstimationEvent, SignalNoise, SmoothedRecord, StateRecord, TrimRecord};
use crate::realtime::estimation::trim::STEADY_RATE_RMS;

/// Parts of the white noise of airspeed, incidence and sideslip that the filter leaves in the velocities at 100 Hz, measured in
/// still air: airspeed and incidence are held by the attitude as well.
const PASSED_BY_FILTER: [f64; 3] = [0.3, 0.3, 0.6];
/// Place of the specific forces among the signals.
const FORCES: usize = 8;
/// Axis of the accelerometer that moves the velocity between the readings of airspeed, incidence and sideslip.
const MOVED_BY_FORCE: [usize; 3] = [0, 2, 1];

/// The instruments of the air data and their signals, in the order of `AirData::ALL`.
const AIR_DATA: [(Aid, usize); 3] =
    [(Aid::Airspeed, AIRSPEED_SIGNAL), (Aid::Incidence, VANE_SIGNALS), (Aid::Sideslip, VANE_SIGNALS + 1)];

impl Estimator {
    /// Puts a sample on the delay line, and into the trim while its window is open: what it does not carry is not sampled.
    pub(super) fn delay(&mut self, sample: &Sample, state: &StateRecord) {
        let value = |channel| sample.get(channel).unwrap_or(f64::NAN);
        let rates = [value(Channel::P), value(Channel::Q), value(Channel::R)];
        let [p, q, r]: [f64; 3] = core::array::from_fn(|i| self.input[3 + i]);
        let force = [value(Channel::Ax), value(Channel::Ay), value(Channel::Az)];
        // The kinematics hold where the accelerometers stand, so the vanes are brought there (small angles).
        let felt = self.ekf.as_ref().map_or(state.velocity, |ekf| core::array::from_fn(|i| ekf.state()[VELOCITY + i]));
        let arm = core::array::from_fn(|i| self.geometry.vane_position_m[i] - self.geometry.accelerometer_position_m[i]);
        let [tas, alpha, beta] = AIR_DATA.map(|(aid, _)| if self.is_spike(aid) { f64::NAN } else { value(aid.channel()) });
        let flow_angles = flow_angles_at_foot([alpha, beta], [p, q, r], arm, felt[0]);
        let attitude = [state.attitude[0], state.attitude[1]];
        let kinematic = flow_angle_rates(felt, attitude, force, [p, q, r]).unwrap_or([f64::NAN; 2]);
        let controls = Channel::CONTROLS.map(value);
        let mut row = [f64::NAN; SIGNALS];
        row[..3].copy_from_slice(&state.velocity);
        row[3..6].copy_from_slice(&rates);
        row[6..8].copy_from_slice(&attitude);
        row[8..CONTROL_SIGNALS].copy_from_slice(&force);
        row[CONTROL_SIGNALS..VANE_SIGNALS].copy_from_slice(&controls);
        row[VANE_SIGNALS..KINEMATIC_SIGNALS].copy_from_slice(&flow_angles);
        row[KINEMATIC_SIGNALS..AIRSPEED_SIGNAL].copy_from_slice(&kinematic);
        row[AIRSPEED_SIGNAL] = tas;
        self.delay.push(self.time_s, &row);
        self.through_filter(&row);

        let (velocity, velocity_std) = (state.velocity, state.velocity_std);
        let tick = TrimRecord { velocity, velocity_std, rates, attitude, specific_force: force, controls };
        if let Some((trim, rate_rms)) = self.trim.take(self.time_s, &tick) {
            self.output.trim = Some(trim);
            if rate_rms > STEADY_RATE_RMS {
                self.notice(EstimationEvent::TrimNotSteady { rate_rms });
            }
        }
    }

    /// Whether the newest reading of an aid stands out from those before it and is rejected by a filter that fuses most: no gust,
    /// which would be added to the velocity of the regression.
    fn is_spike(&self, aid: Aid) -> bool {
        let rejected = self.output.innovations.iter().any(|innovation| innovation.aid == aid && !innovation.fused);
        rejected && self.noise.stands_out(aid) && self.health[aid.index()].is_trusted()
    }

    /// Takes the instants of the regression grid off the delay line whose kernel is now covered.
    pub(super) fn emit_grid(&mut self) {
        let grid_s = self.config.grid_s;
        // The newest row of the delay line, not the sample: one so close to that row that it is none of its own covers no more,
        // and an instant that is asked for before it is covered is lost.
        let ready_s = self.delay.newest_s().unwrap_or(self.time_s) - self.config.lag_s;
        let origin_s = *self.grid_origin_s.get_or_insert(self.time_s);
        let mut centre_s = origin_s + self.next_grid as f64 * grid_s;
        if centre_s > self.time_s + grid_s {
            // A clock that was set back: the grid starts again.
            self.grid_origin_s = Some(self.time_s);
            self.next_grid = 0;
            return;
        }
        if ready_s - centre_s > INSTANTS as f64 * grid_s {
            // Silence, or a clock that was set forward: the grid goes on from here.
            self.next_grid = libm::floor((ready_s - origin_s) / grid_s) as u64;
            centre_s = origin_s + self.next_grid as f64 * grid_s;
        }
        // Instants closer than the samples would count the same information twice.
        let stride = libm::ceil(self.latest.interval_s() / grid_s - 0.01).clamp(1.0, INSTANTS as f64);
        for _ in 0..INSTANTS {
            if !(centre_s < ready_s) {
                break;
            }
            self.next_grid = self.next_grid.saturating_add(stride as u64);
            if let Some(smoothed) = self.delay.at(centre_s) {
                self.compare_vanes(&smoothed);
                let air_data_noise_vars = self.air_data_noise_vars(&smoothed);
                if self.config.regression_states == RegressionStates::Smoothed {
                    self.emit_smoothed(centre_s, stride * grid_s, &smoothed, &air_data_noise_vars);
                }
                self.signal_noise = self.noise_after_smoothing(&smoothed, &air_data_noise_vars);
            }
            centre_s = origin_s + self.next_grid as f64 * grid_s;
        }
    }

    /// One instant through the kernel, with what the fixed-lag smoother has changed since.
    fn emit_smoothed(&mut self, centre_s: f64, interval_s: f64, smoothed: &Smoothed<SIGNALS>, air_data_noise_vars: &[f64; 3]) {
        let slopes = [smoothed.slope[3], smoothed.slope[4], smoothed.slope[5]];
        let mut record = self.regressors(centre_s, interval_s, &smoothed.value, slopes);
        if let Some(correction) = self.fixed_lag.correction(centre_s, self.config.hold_s) {
            for i in 0..3 {
                record.velocity[i] += correction[VELOCITY + i];
            }
            for i in 0..2 {
                record.attitude[i] += correction[ATTITUDE + i];
            }
        }
        self.add_gust(&mut record, smoothed, air_data_noise_vars);
        let _ = self.output.smoothed.push(record);
    }

    /// Adds the gust that the air-data instruments measure at that instant.
    fn add_gust(&mut self, record: &mut SmoothedRecord, smoothed: &Smoothed<SIGNALS>, noise_vars: &[f64; 3]) {
        let velocity_rate = [smoothed.slope[0], smoothed.slope[1], smoothed.slope[2]];
        let flow_angles = [smoothed.value[VANE_SIGNALS], smoothed.value[VANE_SIGNALS + 1]];
        let arm = self.geometry.accelerometer_position_m;
        let [alpha, beta] = flow_angles_at_foot(flow_angles, record.rates, arm, record.velocity[0]);
        let scale_errors = self.ekf.as_ref().map_or([0.0; 3], |ekf| core::array::from_fn(|i| ekf.state()[SCALE_ERROR + i]));
        let values = [smoothed.value[AIRSPEED_SIGNAL], alpha, beta];
        let readings = core::array::from_fn(|i| {
            let (aid, signal) = AIR_DATA[i];
            let usable = self.health[aid.index()].is_trusted() && !self.delay.is_silent(signal);
            let value = values[i] / (1.0 + scale_errors[i]);
            (usable && value.is_finite()).then_some(SmoothedReading { value, noise_var: noise_vars[i] })
        });
        let gust = self.gust.step(record.interval_s, record.velocity, velocity_rate, readings);
        for (velocity, gust) in record.velocity.iter_mut().zip(gust) {
            *velocity += gust;
        }
    }

    /// Variances that the configured noise of airspeed, incidence and sideslip leaves in their smoothed readings.
    fn air_data_noise_vars(&self, smoothed: &Smoothed<SIGNALS>) -> [f64; 3] {
        AIR_DATA.map(|(aid, signal)| {
            let std = self.config.noise.of(aid);
            self.delay.ticks_a_sample(signal) * smoothed.value_noise_gain * std * std
        })
    }

    /// Asks the state-variable filter for the instants up to the sample, and gives it the signals of the regression.
    fn through_filter(&mut self, row: &[f64; SIGNALS]) {
        if self.config.regression_states != RegressionStates::Filtered {
            return;
        }
        // Instants closer than the samples would count the same information twice.
        let stride = libm::ceil(self.latest.interval_s() / self.config.grid_s - 0.01).clamp(1.0, INSTANTS as f64);
        let interval_s = stride * self.config.grid_s;
        let mut next_s = self.filtered_next_s.unwrap_or(self.time_s);
        if self.time_s - next_s > INSTANTS as f64 * interval_s {
            // Silence: the instants go on from here.
            next_s = self.time_s;
        }
        while next_s <= self.time_s {
            self.filtered.ask(next_s, interval_s);
            next_s += interval_s;
        }
        self.filtered_next_s = Some(next_s);
        let mut signals = [f64::NAN; VANE_SIGNALS];
        signals.copy_from_slice(&row[..VANE_SIGNALS]);
        self.filtered.push(self.time_s, &signals);
    }

    /// Takes the instants that every signal has come to through the state-variable filter.
    pub(super) fn emit_filtered(&mut self) {
        while !self.output.smoothed.is_full() {
            let Some(filtered) = self.filtered.take() else { return };
            let (value, slope) = (&filtered.value, &filtered.slope);
            // Not settled since the start or a hole: what every equation needs is not there.
            if value[..8].iter().all(|signal| signal.is_finite()) {
                let time_s = filtered.time_s - self.filtered.delay_s();
                let record = self.regressors(time_s, filtered.interval_s, value, [slope[3], slope[4], slope[5]]);
                let _ = self.output.smoothed.push(record);
            }
        }
    }

    /// What the regression gets of signals in the order of `SIGNALS`, the forces brought to the centre of mass.
    fn regressors<const S: usize>(&self, time_s: f64, interval_s: f64, value: &[f64; S], slopes: [f64; 3]) -> SmoothedRecord {
        const { assert!(S >= VANE_SIGNALS, "every signal of the regression") };
        let [u, v, w, p, q, r, phi, theta, ax, ay, az] = core::array::from_fn(|i| value[i]);
        let [dp, dq, dr] = slopes;
        let force = specific_force_at_foot([ax, ay, az], [p, q, r], [dp, dq, dr], self.geometry.accelerometer_position_m);
        let mut controls = [0.0; 4];
        let mut controls_present = [false; 4];
        for i in 0..4 {
            let control = value[CONTROL_SIGNALS + i];
            controls_present[i] = control.is_finite();
            if controls_present[i] {
                controls[i] = control;
            }
        }
        SmoothedRecord {
            time_s,
            interval_s,
            velocity: [u, v, w],
            rates: [p, q, r],
            attitude: [phi, theta],
            specific_force: force,
            angular_acceleration: [dp, dq, dr],
            controls,
            controls_present,
        }
    }

    /// White noise of gyros and accelerometers through the kernel; of the velocities what the filter leaves of the configured
    /// noise of airspeed and vanes, or, in the part of a reading that is taken for gust, all of it. The noise that the filter
    /// estimates of these is not used: it contains the gusts.
    fn noise_after_smoothing(&self, smoothed: &Smoothed<SIGNALS>, air_data_noise_vars: &[f64; 3]) -> SignalNoise {
        let estimated = self.noise.noise();
        let through = |signal: usize, gain: f64| libm::sqrt(gain * self.delay.ticks_a_sample(signal));
        let [rates, forces] = [3, FORCES].map(|first| core::array::from_fn(|i| through(first + i, smoothed.value_noise_gain)));
        let slopes: [f64; 3] = core::array::from_fn(|i| through(3 + i, smoothed.slope_noise_gain));
        let u = smoothed.value[0];
        let gust_gains = self.gust.gains();
        // Of airspeed, incidence, sideslip.
        let left: [f64; 3] = core::array::from_fn(|i| {
            let (_, signal) = AIR_DATA[i];
            let force = FORCES + MOVED_BY_FORCE[i];
            let is_held = smoothed.value[force].is_finite() && !self.delay.is_silent(force);
            // Without the accelerometer that moves it between readings the velocity follows each of them.
            let by_filter = if is_held { PASSED_BY_FILTER[i] / libm::sqrt(self.delay.ticks_a_sample(signal)) } else { 1.0 };
            libm::sqrt(air_data_noise_vars[i]) * libm::hypot((1.0 - gust_gains[i]) * by_filter, gust_gains[i])
        });
        let times = |gains: [f64; 3], stds: [f64; 3]| core::array::from_fn(|i| gains[i] * stds[i]);
        SignalNoise {
            velocity: [left[0], u * left[2], u * left[1]],
            rates: times(rates, estimated.gyro_std),
            specific_force: times(forces, estimated.accelerometer_std),
            angular_acceleration: times(slopes, estimated.gyro_std),
        }
    }

    fn compare_vanes(&mut self, smoothed: &Smoothed<SIGNALS>) {
        let n = *self.noise.noise();
        let u = smoothed.value[0];
        let vane_var = [n.incidence_std * n.incidence_std, n.sideslip_std * n.sideslip_std];
        // alpha moves by az and q, beta by ay and r.
        let inertial_var = [(n.accelerometer_std[2], n.gyro_std[1]), (n.accelerometer_std[1], n.gyro_std[2])]
            .map(|(force, rate)| force * force / (u * u) + rate * rate);
        let aids = [Aid::Incidence, Aid::Sideslip];
        for (i, aid) in aids.into_iter().enumerate() {
            let (vane, rate) = (VANE_SIGNALS + i, KINEMATIC_SIGNALS + i);
            let noise_var = self.delay.ticks_a_sample(vane) * smoothed.slope_noise_gain * vane_var[i]
                + self.delay.ticks_a_sample(rate) * smoothed.value_noise_gain * inertial_var[i];
            let measured = if self.delay.is_silent(vane) { f64::NAN } else { smoothed.slope[vane] };
            let kinematic = smoothed.value[rate];
            self.consistency[i].compare(measured, kinematic, noise_var);
            if let Some(r_squared) = self.consistency[i].r_squared() {
                self.vanes_contradict[i] = r_squared < R2_CONTRARY;
            }
            if self.disagreement_said[i] {
                continue;
            }
            if let Some(r_squared) = self.consistency[i].disagreement() {
                self.disagreement_said[i] = true;
                self.notice(EstimationEvent::KinematicsDisagree { aid, r_squared });
            }
        }
    }
}
