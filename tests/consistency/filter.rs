//! Normalised innovations and state errors of the filter over 50 flights whose noise is what it was told.
//!
//! For a consistent filter the normalised innovation squared is chi-square with one degree of freedom and white, so its mean
//! over M innovations is within 1 +- 3.29 sqrt(2/M) in 99.9 % (the band). A mean above says overconfidence, below says that the
//! filter is told too much noise. Seven aids are judged, and all together: one false alarm in 125 runs of this test, were the
//! seeds not fixed.

use crate::support::asked::seeds;
use crate::support::manoeuvre::{INPUTS, fly, over_seeds};
use crate::support::puma::puma_100kn;
use sideslip::flight::channel::Channel;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::estimation::config::{EstimationConfig, Noise, NoiseSource};
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::estimation::record::{AIDS, Aid};
use sideslip::simulation::instrument::InstrumentSet;

/// Quantile of the standard normal for a two-sided 99.9 % band.
const BAND: f64 = 3.29;

/// A filter that is told the very noise of these instruments, and that their biases stay.
fn matched(instruments: &InstrumentSet) -> EstimationConfig {
    let noise = |channel: Channel| instruments.channels.iter().find(|one| one.channel == channel).unwrap();
    EstimationConfig {
        noise: Noise {
            accelerometer_std: [noise(Channel::Ax).noise_std; 3],
            gyro_std: [noise(Channel::P).noise_std; 3],
            airspeed_std: noise(Channel::Tas).noise_std,
            incidence_std: noise(Channel::Alpha).noise_std,
            sideslip_std: noise(Channel::Beta).noise_std,
            bank_std: noise(Channel::Phi).noise_std,
            pitch_std: noise(Channel::Theta).noise_std,
            heading_std: noise(Channel::Psi).noise_std,
            altitude_std: noise(Channel::Altitude).noise_std,
        },
        noise_source: NoiseSource::Configured,
        accelerometer_bias_std: noise(Channel::Ax).bias_std,
        gyro_bias_std: noise(Channel::P).bias_std,
        accelerometer_bias_walk: 0.0,
        gyro_bias_walk: 0.0,
        ..EstimationConfig::default()
    }
}

/// Sums of one flight.
#[derive(Clone, Copy, Default)]
struct Flight {
    nis: [f64; AIDS],
    count: [u64; AIDS],
    rejected: u64,
    /// Squared error over variance of u v w phi theta at the end of each second, and how many.
    nees: [f64; 5],
    seconds: u64,
}

fn flight(seed: u64) -> Flight {
    let model = puma_100kn().unwrap();
    let instruments = InstrumentSet::flight_quality(1.0);
    let flown = fly(&model, &INPUTS, &instruments, seed);
    let mut estimator = Box::new(Estimator::new(matched(&instruments), RunGeometry::default()).unwrap());
    let mut sums = Flight::default();
    for (sample, truth) in flown.samples.iter().zip(&flown.truth) {
        let output = estimator.step(sample);
        for innovation in &output.innovations {
            let place = innovation.aid.index();
            sums.nis[place] += innovation.innovation * innovation.innovation / innovation.innovation_var;
            sums.count[place] += 1;
            sums.rejected += u64::from(!innovation.fused);
        }
        let Some(state) = output.state else { continue };
        if (sample.time_s * 100.0).round() as u64 % 100 == 99 {
            let errors = [
                (state.velocity[0] - truth.air_velocity[0], state.velocity_std[0]),
                (state.velocity[1] - truth.air_velocity[1], state.velocity_std[1]),
                (state.velocity[2] - truth.air_velocity[2], state.velocity_std[2]),
                (state.attitude[0] - truth.motion.attitude[0], state.attitude_std[0]),
                (state.attitude[1] - truth.motion.attitude[1], state.attitude_std[1]),
            ];
            for (nees, (error, std)) in sums.nees.iter_mut().zip(errors) {
                *nees += error * error / (std * std);
            }
            sums.seconds += 1;
        }
    }
    sums
}

#[test]
fn normalised_innovations_are_inside_their_band_over_50_flights() {
    if puma_100kn().is_none() {
        return;
    }
    let flights = over_seeds(seeds(50), flight);
    let (mut all, mut all_count, mut outside) = (0.0, 0.0, Vec::new());
    let mut judge = |name: String, sum: f64, count: f64| {
        let (mean, band) = (sum / count, BAND * (2.0 / count).sqrt());
        eprintln!("{name:10} mean normalised innovation squared {mean:.4}, band 1 +- {band:.4} ({count} innovations)");
        if !((mean - 1.0).abs() <= band) {
            outside.push(name);
        }
    };
    for aid in Aid::ALL {
        let sum: f64 = flights.iter().map(|flight| flight.nis[aid.index()]).sum();
        let count = flights.iter().map(|flight| flight.count[aid.index()]).sum::<u64>() as f64;
        judge(format!("{aid:?}"), sum, count);
        all += sum;
        all_count += count;
    }
    judge("all".into(), all, all_count);
    assert!(outside.is_empty(), "outside the 99.9 % band: {outside:?}");
    // Beyond five standard deviations: 6e-7 each, so of some 700,000 innovations hardly one.
    let rejected: u64 = flights.iter().map(|flight| flight.rejected).sum();
    assert!(rejected <= 5, "{rejected} innovations rejected");
}

#[test]
fn state_errors_are_as_large_as_their_variances_over_50_flights() {
    if puma_100kn().is_none() {
        return;
    }
    let flights = over_seeds(seeds(50), flight);
    let mut outside = Vec::new();
    for (place, name) in ["u", "v", "w", "phi", "theta"].into_iter().enumerate() {
        // The mean over a flight is one draw: its seconds are correlated. The spread over flights judges the mean.
        let means: Vec<f64> = flights.iter().map(|flight| flight.nees[place] / flight.seconds as f64).collect();
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let std = (means.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>() / (count - 1.0)).sqrt();
        // Student's t for 49 degrees of freedom, two-sided 99.9 %.
        let band = 3.5 * std / count.sqrt();
        eprintln!("{name:6} mean normalised error squared {mean:.3}, band 1 +- {band:.3}");
        if !((mean - 1.0).abs() <= band) {
            outside.push(name);
        }
    }
    assert!(outside.is_empty(), "outside the 99.9 % band: {outside:?}");
}
