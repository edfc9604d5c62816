//! What no instrument measures makes the state uncertain by what it may have done, whatever else comes in between.

use sideslip::flight::channel::Channel;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::estimator::Estimator;

/// Level flight without a lateral accelerometer or vane, 5 s; the last standard deviation of v. `between` puts a sample of
/// altitude alone half way between the ticks.
fn std_of_v_without_ay(between: bool) -> f64 {
    let mut estimator = Box::new(Estimator::new(EstimationConfig::default(), RunGeometry::default()).unwrap());
    let mut std = f64::NAN;
    for k in 0..250 {
        let mut sample = Sample::new(0.02 * f64::from(k));
        let level = [(Channel::Tas, 50.0), (Channel::Az, -9.80665), (Channel::Altitude, 300.0)];
        let zero = [Channel::Ax, Channel::P, Channel::Q, Channel::R, Channel::Phi, Channel::Theta, Channel::Psi, Channel::Alpha];
        for (channel, value) in level.into_iter().chain(zero.map(|channel| (channel, 0.0))) {
            sample.set(channel, value);
        }
        std = estimator.step(&sample).state.map_or(std, |state| state.velocity_std[1]);
        if between {
            let mut sample = Sample::new(sample.time_s + 0.01);
            sample.set(Channel::Altitude, 300.0);
            estimator.step(&sample);
        }
    }
    std
}

#[test]
fn a_missing_accelerometer_widens_the_velocity_however_often_aids_come() {
    let (alone, between) = (std_of_v_without_ay(false), std_of_v_without_ay(true));
    // A white acceleration of 2 (1 m/s^2)^2 s over some 4.5 s, on top of a start of 0.1 V.
    let expected = libm::sqrt(2.0 * 4.5 + 25.0);
    assert!((alone / expected - 1.0).abs() < 0.1, "{alone} for {expected}");
    assert!((between / alone - 1.0).abs() < 0.05, "{between} and {alone}");
}
