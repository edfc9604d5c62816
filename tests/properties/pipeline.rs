//! No samples make the pipeline panic, and a state that it gives is made of numbers.

use super::any_sample::{any_sample, times};
use crate::support::uniform::Uniform;
use proptest::prelude::*;
use sideslip::flight::channel::{CHANNELS, Channel};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::config::NoiseSource;
use sideslip::realtime::estimation::record::StateRecord;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig, Tick};

fn pipeline(geometry: RunGeometry) -> Box<Pipeline> {
    Box::new(Pipeline::new(&PipelineConfig::default(), geometry).unwrap())
}

fn numbers(state: &StateRecord) -> Vec<f64> {
    let three = [
        state.velocity,
        state.velocity_std,
        state.rates,
        state.rates_std,
        state.angular_acceleration,
        state.angular_acceleration_std,
        state.specific_force,
        state.specific_force_std,
        state.attitude,
        state.attitude_std,
        state.accelerometer_bias,
        state.accelerometer_bias_std,
        state.gyro_bias,
        state.gyro_bias_std,
    ];
    let mut numbers = three.concat();
    numbers.extend([state.time_s, state.altitude, state.altitude_std]);
    numbers
}

fn assert_sound(tick: &Tick) {
    if let Some(lagged) = &tick.smoothed {
        assert!(numbers(&lagged.state).iter().all(|number| number.is_finite()) && lagged.lag_s > 0.0, "{lagged:?}");
    }
    if let Some(state) = &tick.state {
        assert!(numbers(state).iter().all(|number| number.is_finite()), "{state:?}");
        let inertial = [state.rates_std, state.angular_acceleration_std, state.specific_force_std];
        let rest = [state.velocity_std, state.attitude_std, state.accelerometer_bias_std, state.gyro_bias_std];
        for std in inertial.concat().into_iter().chain(rest.concat()) {
            assert!(std > 0.0, "{state:?}");
        }
    }
    for innovation in &tick.innovations {
        assert!(innovation.innovation.is_finite() && innovation.innovation_var > 0.0, "{innovation:?}");
        assert_eq!(innovation.fused, innovation.test_ratio <= 1.0);
    }
    for equation in tick.derivatives.iter().flat_map(|derivatives| &derivatives.equations) {
        let published = !matches!(equation.status, sideslip::realtime::regression::record::Status::NotIdentifiable(_));
        for term in equation.terms.iter().filter(|_| published) {
            assert!(term.value.is_finite() && term.std.is_finite(), "{equation:?}");
        }
    }
    for pair in tick.modes.iter().filter_map(|modes| modes.dutch_roll) {
        assert!(pair.omega > 0.0 && pair.omega.is_finite() && pair.zeta.abs() <= 1.0, "{pair:?}");
    }
}

proptest! {
    #![proptest_config(super::cases(200))]

    #[test]
    fn no_samples_make_it_panic(
        times in times(),
        samples in prop::collection::vec(any_sample(), 60),
        vane in prop::array::uniform3(-30.0..30.0_f64),
        accelerometer in prop::array::uniform3(-30.0..30.0_f64),
    ) {
        let geometry = RunGeometry { vane_position_m: vane, accelerometer_position_m: accelerometer, ..RunGeometry::default() };
        let mut pipeline = pipeline(geometry);
        for (mut sample, time_s) in samples.into_iter().zip(times) {
            sample.time_s = time_s;
            assert_sound(pipeline.step(&sample));
        }
        assert_sound(pipeline.finish());
    }
}

/// How a long run goes: how often a sample is troubled, how much the aircraft moves, where the clock begins.
struct Weather {
    trouble_one_in: u64,
    size: f64,
    rate_hz: f64,
    begin_s: f64,
    config: PipelineConfig,
}

/// Settings at the ends of what is allowed.
fn extremes() -> [PipelineConfig; 3] {
    let (mut short, mut long, mut odd) = (PipelineConfig::default(), PipelineConfig::default(), PipelineConfig::default());
    let e = &mut short.estimation;
    [e.lag_s, e.grid_s, e.trim_window_s, e.gap_s, e.hold_s, e.gate_sigmas] = [0.021, 0.0051, 1e-6, 0.051, 0.011, 1.01];
    let r = &mut short.regression;
    [r.forgetting_s, r.exciting_s, r.stale_s, r.settled_s, r.f_remove, r.f_enter] = [1.01, 1e-3, 1e-3, 1e-3, 1e-3, 2e-3];
    let e = &mut long.estimation;
    [e.lag_s, e.grid_s, e.trim_window_s, e.gap_s, e.hold_s, e.gate_sigmas] = [5.0, 0.1, 60.0, 60.0, 60.0, 100.0];
    long.regression.forgetting_s = 1e9;
    let (e, tiny) = (&mut odd.estimation, 1e-9);
    [e.lag_s, e.grid_s, e.gap_s, e.accelerometer_bias_walk, e.gyro_bias_walk] = [5.0, 0.0051, 60.0, 0.0, 1.0];
    [e.noise.gyro_std, e.noise.accelerometer_std] = [[tiny; 3], [100.0; 3]];
    [e.noise.sideslip_std, e.noise.bank_std, e.smoother_lag_s] = [tiny, tiny, 5.0];
    odd.estimation.noise_source = NoiseSource::Configured;
    [short, long, odd]
}

/// Readings about level flight, as wild as `size` says; now and then any bits, any channels, any time.
fn wild(uniform: &mut Uniform, time_s: &mut f64, weather: &Weather) -> Sample {
    *time_s += uniform.between(0.5, 1.5) / weather.rate_hz;
    let mut sample = Sample::new(*time_s);
    let size = weather.size;
    for channel in Channel::ALL {
        let (middle, half) = match channel {
            Channel::Az => (-9.8, 20.0),
            Channel::Ax | Channel::Ay => (0.0, 20.0),
            Channel::Tas => (50.0, 60.0),
            Channel::Altitude => (500.0, 1e3),
            Channel::Psi => (0.0, 6.3),
            _ => (0.0, 1.5),
        };
        sample.set(channel, middle + uniform.within(half * size));
    }
    if uniform.bits().is_multiple_of(weather.trouble_one_in) {
        match uniform.bits() % 6 {
            0 => sample.present = uniform.bits() as u32,
            1 => sample.values[uniform.bits() as usize % CHANNELS] = f64::from_bits(uniform.bits()),
            2 => sample.time_s = f64::from_bits(uniform.bits()),
            3 => *time_s += uniform.between(-30.0, 30.0),
            4 => sample.values = std::array::from_fn(|_| f64::from_bits(uniform.bits())),
            _ => sample.present = 0,
        }
    }
    sample
}

#[test]
fn a_hundred_thousand_wild_samples_neither_panic_nor_give_a_state_that_is_no_number() {
    let mut uniform = Uniform(71);
    let [short, long, odd] = extremes();
    let usual = PipelineConfig::default();
    let weathers = [
        (20, 0.001, 50.0, 0.0, usual),
        (50, 0.1, 25.0, 1.7e9, usual),
        (5, 1.0, 100.0, -1e6, usual),
        (2, 0.3, 256.0, 1e-3, usual),
        (200, 0.02, 1_000.0, 1.7e12, usual),
        (100, 0.05, 50.0, 0.0, short),
        (100, 0.05, 50.0, 0.0, long),
        (100, 0.05, 50.0, 0.0, odd),
    ];
    let (mut states, mut numbers) = (0, 0);
    for (trouble_one_in, size, rate_hz, begin_s, config) in weathers {
        let weather = Weather { trouble_one_in, size, rate_hz, begin_s, config };
        let mut pipeline = Box::new(Pipeline::new(&weather.config, RunGeometry::default()).unwrap());
        let mut time_s = weather.begin_s;
        let (states_before, numbers_before) = (states, numbers);
        for _ in 0..12_500 {
            let tick = pipeline.step(&wild(&mut uniform, &mut time_s, &weather));
            assert_sound(tick);
            states += usize::from(tick.state.is_some());
            let equations = tick.derivatives.iter().flat_map(|record| &record.equations);
            numbers += equations.map(|equation| equation.terms.len()).sum::<usize>();
        }
        assert_sound(pipeline.finish());
        let (states, numbers) = (states - states_before, numbers - numbers_before);
        eprintln!("trouble 1 in {trouble_one_in}, size {size}, {rate_hz} Hz: {states} states, {numbers} numbers");
    }
    assert!(states > 30_000 && numbers > 1_000, "{states} states, {numbers} numbers: too few to prove anything");
}
