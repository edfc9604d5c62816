//! The estimation stage: samples in; state, innovations, smoothed regressors, trim and events out.
//!
//! Consumes [`Sample`]s in order of time; produces an [`EstimationOutput`] a sample. It starts as soon as rates,
//! airspeed and attitude are sampled, and reports missing instruments as events.

use super::admission::{Admission, Verdict};
mod regressors;

use super::aid::inertial;
use super::centre_of_mass::{lagged, state_record};
use super::config::{ConfigError, EstimationConfig};
use super::consistency::Consistency;
use super::delay_line::DelayLine;
use super::ekf::{Ekf, FilterObserver};
use super::fixed_lag::FixedLag;
use super::gust_velocity::GustVelocity;
use super::health::AidHealth;
use super::latest::{INPUTS, Input, Latest};
use super::noise::NoiseStatistics;
use super::process::{
    ACCELEROMETER_BIAS, ALTITUDE, ANGULAR_ACCELERATION, ATTITUDE, GYRO_BIAS, RATES, SCALE_ERROR, SPECIFIC_FORCE, STATES, State,
    VELOCITY,
};
use super::record::{
    AIDS, Aid, EstimationEvent, Innovation, Instrumentation, LaggedRecord, NoiseRecord, SignalNoise, SmoothedRecord, StateRecord,
    StateSet, TrimRecord,
};
use super::screening::{Screening, ScreeningEvent};
use super::state_variable::StateVariable;
use super::trim::TrimWindow;
use super::vibration::LineNotch;
use crate::dynamics::sensors::velocity_of_air_data;
use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::flight::unit::STANDARD_GRAVITY as G0;
use crate::num::ud::Breakdown;
use crate::realtime::estimation::aid;
use heapless::Vec;

/// Signals that go through the delay line: u v w, p q r, phi theta, ax ay az, controls, then measured alpha and beta and
/// their rates by kinematics, and the measured airspeed.
const SIGNALS: usize = 20;
const CONTROL_SIGNALS: usize = 11;
/// The regression's signals end here.
const VANE_SIGNALS: usize = 15;
const KINEMATIC_SIGNALS: usize = 17;
const AIRSPEED_SIGNAL: usize = 19;

/// rad/s of 1 Hz.
const TURN: f64 = 2.0 * core::f64::consts::PI;

/// Instants of the regression grid that one sample can complete; slower samples than so many instants are too slow for
/// derivatives.
pub const INSTANTS: usize = 4;

/// Events that one sample can bring: two of its time, one a channel (taken out, standing still, or judged as an aid), the start
/// or a breakdown, the trim, two vanes that disagree, a gross error, and once the states, the lines of vibration and the
/// instruments that are missing.
pub const EVENTS: usize = 2 + CHANNELS + 1 + 1 + 2 + 3 + 3 + AIDS + 1;

/// Time that the filter waits for optional aids before it starts, s.
const START_WAIT_S: f64 = 0.5;
/// Interval of updates of the noise statistics, s.
const NOISE_STEP_S: f64 = 0.1;
/// What angular accelerations and specific forces may be when the filter starts, rad/s^2 and m/s^2 (standard deviations), and
/// the rates, rad/s: the instruments have the say at once.
const START_STD: [f64; 3] = [1.0, 2.0, 30.0];
/// Standard deviation of a scale error that is taken as exact: variances must be positive.
const EXACT_STD: f64 = 1e-9;
/// Gate of gyros and accelerometers, which are never rejected.
const NO_GATE: f64 = 1e9;
/// Time after the start at which an instrument without samples is missing, s.
const MISSING_AFTER_S: f64 = 1.0;

/// Results of one sample.
#[derive(Clone, Debug, Default)]
pub struct EstimationOutput {
    /// The filtered state at the sample.
    pub state: Option<StateRecord>,
    /// Innovations of the aids.
    pub innovations: Vec<Innovation, AIDS>,
    /// A state of the fixed-lag smoother, where one is due. The biases are the filter's newest.
    pub lagged: Option<LaggedRecord>,
    /// Smoothed signals at the instants of the regression grid that the sample completed.
    pub smoothed: Vec<SmoothedRecord, INSTANTS>,
    /// The trim, at the one sample that completed its window.
    pub trim: Option<TrimRecord>,
    /// Events at this sample.
    pub events: Vec<EstimationEvent, EVENTS>,
}

impl EstimationOutput {
    const EMPTY: EstimationOutput = EstimationOutput {
        state: None,
        innovations: Vec::new(),
        lagged: None,
        smoothed: Vec::new(),
        trim: None,
        events: Vec::new(),
    };
}

/// The estimation stage.
#[derive(Clone, Debug)]
pub struct Estimator {
    config: EstimationConfig,
    geometry: RunGeometry,
    admission: Admission,
    screening: Screening,
    vibration: LineNotch,
    latest: Latest,
    ekf: Option<Ekf>,
    /// Biases and scale errors at the last restart, with their standard deviations: those of instruments outlast a silence.
    errors_before: Option<(State, State)>,
    fixed_lag: FixedLag,
    gust: GustVelocity,
    noise: NoiseStatistics,
    noise_due_s: f64,
    time_s: f64,
    input: Input,
    waiting_since_s: Option<f64>,
    started_s: f64,
    missing_said: bool,
    folded_said: bool,
    health: [AidHealth; AIDS],
    delay: DelayLine<SIGNALS>,
    next_grid: u64,
    grid_origin_s: Option<f64>,
    filtered: StateVariable<VANE_SIGNALS>,
    /// The next instant to ask it for.
    filtered_next_s: Option<f64>,
    trim: TrimWindow,
    consistency: [Consistency; 2],
    disagreement_said: [bool; 2],
    /// By the last comparison that was determined.
    vanes_contradict: [bool; 2],
    signal_noise: SignalNoise,
    output: EstimationOutput,
}

impl Estimator {
    /// A stage for a run with that geometry.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that cannot be used.
    pub fn new(config: EstimationConfig, geometry: RunGeometry) -> Result<Self, ConfigError> {
        config.validate()?;
        Ok(Estimator::of(config, geometry))
    }

    /// The same for a configuration that has been validated; at compile time too.
    pub(crate) const fn of(config: EstimationConfig, geometry: RunGeometry) -> Self {
        Estimator {
            admission: Admission::new(config.gap_s),
            screening: Screening::NEW,
            vibration: LineNotch::new(geometry.blades, config.hold_s),
            latest: Latest::new(config.hold_s),
            ekf: None,
            errors_before: None,
            fixed_lag: FixedLag::new(config.smoother_lag_s, config.grid_s),
            gust: GustVelocity::NEW,
            noise: NoiseStatistics::new(&config),
            noise_due_s: 0.0,
            time_s: 0.0,
            input: [0.0; INPUTS],
            waiting_since_s: None,
            started_s: 0.0,
            missing_said: false,
            folded_said: false,
            health: [AidHealth::NEW; AIDS],
            delay: DelayLine::new(config.lag_s, config.hold_s),
            next_grid: 0,
            grid_origin_s: None,
            filtered: StateVariable::new(TURN * config.cutoff_hz, config.hold_s),
            filtered_next_s: None,
            trim: TrimWindow::new(config.trim_window_s),
            consistency: [Consistency::NEW; 2],
            disagreement_said: [false; 2],
            vanes_contradict: [false; 2],
            signal_noise: SignalNoise::NONE,
            output: EstimationOutput::EMPTY,
            config,
            geometry,
        }
    }

    /// Which instruments have been found.
    pub fn instrumentation(&self) -> Instrumentation {
        let found = self.latest.instrumentation(self.ekf.is_some());
        let moves = |channel| !self.screening.stands_still(channel);
        Instrumentation {
            gyros: found.gyros && [Channel::P, Channel::Q, Channel::R].into_iter().all(moves),
            accelerometers: core::array::from_fn(|i| found.accelerometers[i] && moves(Channel::ACCELEROMETERS[i])),
            aids: Aid::ALL.map(|aid| found.aids[aid.index()] && moves(aid.channel())),
            confirmations: self.screening.confirmations(),
            doubt: self.screening.doubt(),
            trusted: self.health.map(|health| health.is_trusted()),
            as_expected: self.health.map(|health| health.is_as_expected()),
            // A disagreement is kept: quiet flight afterwards only adds noise to the comparison.
            vanes_disagree: self.disagreement_said,
            vanes_contradict: self.vanes_contradict,
            controls_stood: self.screening.controls_stood(),
            inertial_stood: self.screening.inertial_stood(),
            noise: self.signal_noise,
            ..found
        }
    }

    /// The filter, where it runs.
    pub fn filter(&self) -> Option<&Ekf> {
        self.ekf.as_ref()
    }

    /// The noise statistics in use.
    pub fn noise(&self) -> &NoiseRecord {
        self.noise.record()
    }

    /// Coefficients of determination of the flow-angle rates (incidence, sideslip) by the kinematics, where determined.
    pub fn consistency(&self) -> [Option<f64>; 2] {
        self.consistency.map(|comparison| comparison.r_squared())
    }

    /// One sample.
    pub fn step(&mut self, sample: &Sample) -> &EstimationOutput {
        self.step_with(sample, &mut ())
    }

    /// One sample, with an observer of the filter's steps.
    pub fn step_with(&mut self, sample: &Sample, observer: &mut impl FilterObserver) -> &EstimationOutput {
        self.output = EstimationOutput::default();
        let mut sample = *sample;
        let events = &mut self.output.events;
        let screening = &mut self.screening;
        let verdict = self.admission.admit(&mut sample, |event| {
            if let EstimationEvent::OutOfRange { channel, .. } = event {
                screening.out_of_range(channel);
            }
            // `EVENTS` has a place for every channel and for the time.
            let _ = events.push(event);
        });
        match verdict {
            Verdict::Drop => return &self.output,
            Verdict::Restart => self.restart(),
            Verdict::Use => {}
        }
        self.screening.step(&mut sample, &self.geometry, |event| {
            let event = match event {
                ScreeningEvent::GrossError(error, r_squared) => EstimationEvent::GrossError { error, r_squared },
                ScreeningEvent::StandsStill(channel) => EstimationEvent::StandsStill { channel },
            };
            let _ = self.output.events.push(event);
        });
        self.vibration.clean(&mut sample);
        let silence_s = self.latest.silence_s(sample.time_s);
        if silence_s > self.config.hold_s && verdict == Verdict::Use && !self.latest.completes_rates(&sample) {
            // The rates are too old to run the filter on.
            self.notice(EstimationEvent::RatesSilent { seconds: silence_s });
            self.restart();
        }
        let tick = self.latest.take(&sample);
        self.noise.take(&sample);
        if sample.time_s >= self.noise_due_s || self.noise_due_s - sample.time_s > NOISE_STEP_S {
            self.noise_due_s = sample.time_s + NOISE_STEP_S;
            self.noise.update();
        }
        if self.ekf.is_none() {
            if tick {
                self.start(sample.time_s);
            }
        } else if self.advance(&sample, tick, observer).is_err() {
            self.notice(EstimationEvent::NumericBreakdown);
            self.restart();
            self.errors_before = None;
        }
        &self.output
    }

    fn notice(&mut self, event: EstimationEvent) {
        let _ = self.output.events.push(event);
    }

    fn restart(&mut self) {
        self.errors_before = self.ekf.take().map(|ekf| (*ekf.state(), ekf.stds())).or(self.errors_before);
        self.fixed_lag.clear();
        self.noise.break_off();
        self.waiting_since_s = None;
        self.latest.clear();
        self.delay.clear();
        self.filtered.clear();
        self.filtered_next_s = None;
        self.health = [AidHealth::NEW; AIDS];
    }

    /// Starts the filter where the instruments allow it.
    fn start(&mut self, time_s: f64) {
        let waiting_since_s = *self.waiting_since_s.get_or_insert(time_s);
        let patient = time_s - waiting_since_s < START_WAIT_S;
        let latest = &self.latest;
        let get = |channel| latest.get(channel, time_s);
        let wanted = Aid::ALL.iter().all(|aid| get(aid.channel()).is_some()) && get(Channel::Ay).is_some();
        if patient && !wanted {
            return;
        }
        let Some(tas) = get(Channel::Tas).filter(|tas| *tas > aid::prediction::AIRSPEED_MIN_M_S) else { return };
        let n = self.noise.noise();
        let (phi, theta, attitude_std) = match (get(Channel::Phi), get(Channel::Theta)) {
            (Some(phi), Some(theta)) => (phi, theta, n.bank_std.max(n.pitch_std)),
            // No attitude gyro: level by the accelerometers, as if the aircraft were not accelerating.
            _ => match (get(Channel::Ax), get(Channel::Ay), get(Channel::Az)) {
                (Some(ax), Some(ay), Some(az)) => (libm::atan2(-ay, -az), libm::asin((ax / G0).clamp(-1.0, 1.0)), 0.1),
                _ => return,
            },
        };
        let (alpha, alpha_std) = get(Channel::Alpha).map_or((0.0, 0.2), |alpha| (alpha, n.incidence_std));
        let (beta, beta_std) = get(Channel::Beta).map_or((0.0, 0.1), |beta| (beta, n.sideslip_std));
        let (psi, psi_std) = get(Channel::Psi).map_or((0.0, 3.0), |psi| (psi, n.heading_std));
        let (altitude, altitude_std) = get(Channel::Altitude).map_or((0.0, 1e3), |h| (h, n.altitude_std));
        let mut x: State = [0.0; STATES];
        x[VELOCITY..VELOCITY + 3].copy_from_slice(&velocity_of_air_data(tas, alpha, beta));
        x[ATTITUDE] = phi;
        x[ATTITUDE + 1] = theta;
        x[ATTITUDE + 2] = psi;
        x[ALTITUDE] = altitude;
        let square = |std: f64| std * std;
        let mut variances = [0.0; STATES];
        variances[VELOCITY] = square(n.airspeed_std);
        variances[VELOCITY + 1] = square(tas * beta_std);
        variances[VELOCITY + 2] = square(tas * alpha_std);
        variances[ATTITUDE] = square(attitude_std);
        variances[ATTITUDE + 1] = square(attitude_std);
        variances[ATTITUDE + 2] = square(psi_std);
        variances[ALTITUDE] = square(altitude_std);
        let [rate_std, acceleration_std, force_std] = START_STD;
        for i in 0..3 {
            variances[RATES + i] = square(rate_std);
            variances[ANGULAR_ACCELERATION + i] = square(acceleration_std);
            variances[SPECIFIC_FORCE + i] = square(force_std);
            variances[ACCELEROMETER_BIAS + i] = square(self.config.accelerometer_bias_std);
            variances[GYRO_BIAS + i] = square(self.config.gyro_bias_std);
            variances[SCALE_ERROR + i] = square(self.config.scale_error_std[i].max(EXACT_STD));
        }
        if let Some((before, stds)) = &self.errors_before {
            for i in (0..3).flat_map(|i| [ACCELEROMETER_BIAS + i, GYRO_BIAS + i, SCALE_ERROR + i]) {
                x[i] = before[i];
                variances[i] = variances[i].min(square(stds[i].max(EXACT_STD)));
            }
        }
        self.input = self.latest.input(time_s, &x).0;
        x[RATES..RATES + 3].copy_from_slice(&self.input[3..]);
        x[SPECIFIC_FORCE..SPECIFIC_FORCE + 3].copy_from_slice(&self.input[..3]);
        let mut ekf = Ekf::new(x, variances);
        for (place, channel) in inertial::INERTIAL.into_iter().enumerate() {
            let Some(observation) = get(channel) else { continue };
            let prediction = inertial::predict(place, ekf.state(), self.noise.noise());
            if ekf.fuse(observation, &prediction, NO_GATE).is_err() {
                self.notice(EstimationEvent::NumericBreakdown);
                return;
            }
        }
        self.ekf = Some(ekf);
        self.time_s = time_s;
        self.started_s = time_s;
        self.notice(EstimationEvent::Initialised);
    }

    fn advance(&mut self, sample: &Sample, tick: bool, observer: &mut impl FilterObserver) -> Result<(), Breakdown> {
        let Some(mut ekf) = self.ekf.take() else { return Ok(()) };
        let time_s = sample.time_s;
        let dt = time_s - self.time_s;
        let (input, measured) = self.latest.input(time_s, ekf.state());
        ekf.propagate(dt, &self.noise.process(&self.config, measured))?;
        self.fixed_lag.propagate(ekf.transition());
        observer.propagate(ekf.transition());
        self.input = input;
        self.time_s = time_s;
        for (place, channel) in inertial::INERTIAL.into_iter().enumerate() {
            let Some(observation) = sample.get(channel) else { continue };
            let prediction = inertial::predict(place, ekf.state(), self.noise.noise());
            let fusion = ekf.fuse(observation, &prediction, NO_GATE)?;
            self.fixed_lag.fuse(&prediction.row, &fusion);
            observer.fuse(&prediction.row, &fusion);
        }
        for aid in Aid::ALL {
            let Some(observation) = sample.get(aid.channel()) else { continue };
            let Some(prediction) = aid::predict(aid, ekf.state(), &self.geometry, self.noise.noise()) else { continue };
            let fusion = ekf.fuse(observation, &prediction, self.config.gate_sigmas)?;
            self.fixed_lag.fuse(&prediction.row, &fusion);
            observer.fuse(&prediction.row, &fusion);
            let innovation = Innovation {
                time_s,
                aid,
                observation,
                observation_var: prediction.noise_var,
                innovation: fusion.innovation,
                innovation_var: fusion.innovation_var,
                test_ratio: fusion.test_ratio,
                fused: fusion.gain.is_some(),
            };
            // Judged by the aid's noise without inflation.
            let own_var = fusion.innovation_var - prediction.noise_var + self.noise.without_inflation(aid);
            if let Some(event) = self.health[aid.index()].judge(&innovation, own_var) {
                self.notice(event);
            }
            if innovation.fused {
                self.noise.fused(aid, fusion.innovation * fusion.innovation / fusion.innovation_var);
            }
            let _ = self.output.innovations.push(innovation);
        }
        let state = self.record(&ekf);
        self.output.state = Some(state);
        if tick {
            self.output.lagged = self.fixed_lag.tick(time_s, &ekf).map(|point| lagged(&point, time_s, &ekf, &self.geometry));
        }
        self.ekf = Some(ekf);
        if self.vibration.folded() && !self.folded_said {
            self.folded_said = true;
            self.notice(EstimationEvent::LineFolded);
        }
        self.delay(sample, &state);
        if tick {
            self.emit_grid();
            self.emit_filtered();
        }
        if !self.missing_said && time_s - self.started_s > MISSING_AFTER_S {
            self.missing_said = true;
            let found = self.instrumentation();
            let scale_error = core::array::from_fn(|i| found.aids[i] && self.config.scale_error_std[i] > 0.0);
            let set = StateSet { specific_force: found.accelerometers, scale_error };
            self.notice(EstimationEvent::StatesChosen { set });
            if let Some(passing_hz) = self.vibration.passing_hz() {
                self.notice(EstimationEvent::LinesNotched { passing_hz });
            }
            for (channel, _) in Channel::ACCELEROMETERS.into_iter().zip(found.accelerometers).filter(|(_, found)| !found) {
                self.notice(EstimationEvent::NoAccelerometer { channel });
            }
            for aid in Aid::ALL.into_iter().filter(|aid| !found.aids[aid.index()]) {
                self.notice(EstimationEvent::AidMissing { aid });
            }
        }
        Ok(())
    }

    fn record(&self, ekf: &Ekf) -> StateRecord {
        let fused = self.output.innovations.iter().filter(|innovation| innovation.fused).count() as u8;
        StateRecord { fused, ..state_record(self.time_s, ekf.state(), &ekf.stds(), &self.geometry) }
    }
}
