//! Instruments of a flight against their closed forms: words, lags, delays, dropouts, vibration, and several rates at once.
//!
//! The tolerance of each statistical test is four standard deviations of its own law: with the seeds fixed nothing is left to
//! chance, and a right simulation with other seeds would fail one of them once in 16 000.

use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::model::{LinearModel, Trim};
use sideslip::flight::signal::piecewise_linear::History;
use sideslip::simulation::dropout::Dropouts;
use sideslip::simulation::fly::{Flight, FlightResult, uniform_times};
use sideslip::simulation::instrument::{Instrument, InstrumentSet};
use sideslip::simulation::instrument_file::InstrumentFile;
use std::f64::consts::TAU;

/// A flight in which nothing happens but that the pedal moves as told; nothing of it moves the aircraft.
fn flight(pedal: History, duration_s: f64, rate_hz: f64, instrument: Instrument) -> Flight {
    let trim = Trim { u: 50.0, rotor_speed: Some(27.0), ..Trim::default() };
    let mut flight = Flight::of(LinearModel::about(trim));
    flight.times_s = uniform_times(0.0, duration_s, rate_hz).unwrap();
    flight.inputs.controls[Control::Pedal.index()] = pedal;
    flight.instruments = InstrumentSet { channels: vec![instrument], ..InstrumentSet::perfect() };
    flight
}

fn readings(flown: &FlightResult, channel: Channel) -> Vec<(f64, f64)> {
    flown.samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?))).collect()
}

fn ramp(duration_s: f64) -> History {
    History::through(vec![(0.0, 0.0), (duration_s, 1.0)]).unwrap()
}

#[test]
fn the_error_of_a_word_has_the_standard_deviation_q_over_root_twelve_and_holds_at_the_ends() {
    let (bits, count) = (8, 20_000.0);
    let quantum = 1.0 / (f64::from(1 << bits) - 1.0);
    let word = Instrument { quantum: Some(quantum), range: Some([0.0, 1.0]), ..Instrument::perfect(Channel::Pedal) };
    let flown = flight(ramp(20.0), 20.0, 1000.0, word).fly().unwrap();
    let errors: Vec<f64> = readings(&flown, Channel::Pedal).iter().map(|(time, word)| word - time / 20.0).collect();
    assert!(errors.iter().all(|error| error.abs() <= 0.5 * quantum + 1e-12));
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt();
    // The ramp passes every part of a step alike: no chance in it; 78 samples a step leave 1/78^2.
    assert!((rms / quantum * 12f64.sqrt() - 1.0).abs() < 1e-3, "{rms}");
    let narrow = Instrument { range: Some([0.25, 0.5]), ..word };
    let flown = flight(ramp(20.0), 20.0, 100.0, narrow).fly().unwrap();
    for (time, word) in readings(&flown, Channel::Pedal) {
        let wanted = (time / 20.0).clamp(0.25, 0.5);
        assert!((word - wanted).abs() < quantum && (0.25..=0.5).contains(&word), "{time}: {word}");
    }
}

#[test]
fn lag_and_delay_of_a_ramp_are_the_closed_form() {
    let (tau, delay, slope) = (0.25, 0.0625, 0.125);
    let slow = Instrument { lag_s: tau, delay_s: delay, factor: 2.0, bias: 0.5, ..Instrument::perfect(Channel::Pedal) };
    let flown = flight(ramp(8.0), 8.0, 128.0, slow).fly().unwrap();
    for (time, read) in readings(&flown, Channel::Pedal) {
        let felt = (time - delay).max(0.0);
        let wanted = 2.0 * slope * (felt - tau * (1.0 - (-felt / tau).exp())) + 0.5;
        assert!((read - wanted).abs() < 1e-12, "{time}: {read} is not {wanted}");
    }
}

#[test]
fn what_is_lost_is_missing_at_its_rate() {
    let dropouts = Dropouts { rate: 0.5, mean_length_s: 0.4 };
    let (duration_s, rate_hz) = (4000.0, 20.0);
    let still = || History::constant(0.0);
    let mut lossy = flight(still(), duration_s, rate_hz, Instrument::perfect(Channel::Pedal));
    lossy.instruments.channels.push(Instrument { dropouts: Some(dropouts), ..Instrument::perfect(Channel::P) });
    let whole = lossy.times_s.len();
    let flown = lossy.fly().unwrap();
    // Means up 2 s and down 0.4 s: a sixth is lost, and the time lost varies by 2 (up down)^2 T / (up + down)^3.
    let std = (2.0 * (2.0 * 0.4f64).powi(2) * duration_s / 2.4f64.powi(3)).sqrt() / duration_s;
    let lost = 1.0 - readings(&flown, Channel::P).len() as f64 / whole as f64;
    assert!((lost - 1.0 / 6.0).abs() < 4.0 * std, "{lost}");
    assert_eq!(readings(&flown, Channel::Pedal).len(), whole);
    lossy.instruments.dropouts = Some(dropouts);
    let flown = lossy.fly().unwrap();
    let lost = 1.0 - flown.samples.len() as f64 / whole as f64;
    assert!((lost - 1.0 / 6.0).abs() < 4.0 * std, "{lost}");
    assert_eq!(flown.truth.len(), whole);
}

/// Amplitude of the line at a frequency, rad/s, over a whole number of its periods.
fn amplitude(readings: &[(f64, f64)], frequency: f64) -> f64 {
    let (mut cos, mut sin) = (0.0, 0.0);
    for (time, value) in readings {
        cos += value * (frequency * time).cos();
        sin += value * (frequency * time).sin();
    }
    2.0 * f64::hypot(cos, sin) / readings.len() as f64
}

#[test]
fn vibration_is_two_lines_at_the_blades_passing_and_their_frequency_follows_the_rotor() {
    // 8 pi rad/s and 4 blades: 16 Hz and 32 Hz, 256 periods of both in 16 s, a whole number of samples of each.
    let blade_passing = TAU * 16.0;
    let shaken = Instrument { vibration: Some([0.3, 0.1]), lag_s: 0.02, ..Instrument::perfect(Channel::P) };
    let mut steady = flight(History::constant(0.0), 16.0 - 1.0 / 256.0, 256.0, shaken);
    steady.model.trim.rotor_speed = Some(blade_passing / 4.0);
    steady.instruments.blades = Some(4.0);
    let read = readings(&steady.fly().unwrap(), Channel::P);
    assert_eq!(read.len(), 4096);
    for (order, wanted) in [(1.0, 0.3), (2.0, 0.1)] {
        let behind: f64 = order * blade_passing * 0.02;
        let found = amplitude(&read, order * blade_passing);
        assert!((found - wanted / (1.0 + behind * behind).sqrt()).abs() < 1e-9, "order {order}: {found}");
    }
    let rest: f64 = [0.5, 0.9375, 1.0625, 1.5].iter().map(|order| amplitude(&read, order * blade_passing)).sum();
    assert!(rest < 1e-9, "{rest}");

    // A rotor that speeds up evenly: the phase between two samples is the azimuth's, whatever it was before.
    let mut quickening = steady.clone();
    let speeds = History::through(vec![(0.0, 20.0), (15.0, 23.0)]).unwrap();
    quickening.inputs.rotor_speed = Some(speeds);
    quickening.instruments.channels[0] = Instrument { vibration: Some([1.0, 0.0]), ..Instrument::perfect(Channel::P) };
    let read = readings(&quickening.fly().unwrap(), Channel::P);
    let phase = |time: f64| 4.0 * (20.0 * time + 0.1 * time * time);
    // y(t) = cos(phase + f): f out of the sums over the first half must foretell the second.
    let (mut cos, mut sin) = (0.0, 0.0);
    for (time, value) in read.iter().take(read.len() / 2) {
        cos += value * phase(*time).cos();
        sin -= value * phase(*time).sin();
    }
    let drawn = sin.atan2(cos);
    // The sums' own ripple is of the order of one over the angle passed.
    for (time, value) in read.iter().skip(read.len() / 2).filter(|(time, _)| *time < 15.0) {
        assert!((value - (phase(*time) + drawn).cos()).abs() < 0.01, "{time}: {value}");
    }
}

#[test]
fn the_example_s_channels_come_at_their_own_rates_and_errors_have_their_sizes() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/replay/instruments/flight-test.toml")).unwrap();
    let described = InstrumentFile::parse(&text, |channel| channel != Channel::Rho).unwrap();
    let mut mixed = flight(History::constant(0.0), 300.0, described.rate_hz.unwrap(), Instrument::perfect(Channel::P));
    mixed.instruments = described.applied_to(InstrumentSet::flight_quality(1.0), 1.0);
    mixed.instruments.dropouts = None;
    let flown = mixed.fly().unwrap();
    for (channel, rate) in [(Channel::P, 256), (Channel::Az, 128), (Channel::Phi, 64), (Channel::Tas, 32), (Channel::Pedal, 128)]
    {
        assert_eq!(readings(&flown, channel).len(), 300 * rate + 1, "{channel:?}");
    }
    assert!(flown.samples.windows(2).all(|pair| pair[1].time_s > pair[0].time_s));
    // Sideslip: its bias, and about six losses.
    let vane = readings(&flown, Channel::Beta);
    assert!(vane.len() < 300 * 64 && vane.len() > 290 * 64);
    let mean = vane.iter().map(|(_, beta)| beta).sum::<f64>() / vane.len() as f64;
    assert!((mean + 0.004).abs() < 4.0 * 0.002 / (vane.len() as f64).sqrt(), "{mean}");
    // Roll rate: noise, two lines behind 8 ms, and the word's step.
    let rolls: Vec<f64> = readings(&flown, Channel::P).iter().map(|(_, p)| *p).collect();
    let mean = rolls.iter().sum::<f64>() / rolls.len() as f64;
    let variance = rolls.iter().map(|p| (p - mean) * (p - mean)).sum::<f64>() / rolls.len() as f64;
    let line = |amplitude: f64, order: f64| 0.5 * amplitude * amplitude / (1.0 + (order * 4.0 * 27.0 * 0.008).powi(2));
    let quantum: f64 = 3.0 / 4095.0;
    let wanted = 1e-6 + line(0.010, 1.0) + line(0.002, 2.0) + quantum * quantum / 12.0;
    assert!((variance / wanted - 1.0).abs() < 0.03, "{variance:e} for {wanted:e}");
}
