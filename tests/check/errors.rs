//! The errors that are put in, and what they are together with what a run's instruments have of their own.

use sideslip::flight::channel::Channel;
use sideslip::flight::channel::Channel::{Alpha, Ax, Ay, Az, Beta, P, Phi, Psi, Q, R, Tas, Theta};
use sideslip::flight::effect::{Effect, PositionedSensor};

const ALL: [Channel; 12] = [Ax, Ay, Az, P, Q, R, Tas, Alpha, Beta, Phi, Theta, Psi];
const BIASES: [(Channel, f64); 11] = [
    (Ax, 0.4),
    (Ay, 0.4),
    (Az, -0.4),
    (P, 0.01),
    (Q, 0.01),
    (R, -0.01),
    (Tas, 5.0),
    (Alpha, 0.035),
    (Beta, 0.035),
    (Phi, 0.035),
    (Theta, -0.035),
];

/// Every error once: biases of both signs in turn, factors of 5 and 20 % either way, lags, skews, accelerometers 1 and 3 m off.
pub(crate) fn every_error() -> Vec<Effect> {
    let mut all: Vec<Effect> = BIASES.map(|(channel, value)| Effect::SensorBias { channel, value }).to_vec();
    for channel in ALL {
        all.extend([0.8, 0.95, 1.05, 1.2].map(|factor| Effect::SensorScale { channel, factor }));
        all.extend([0.1, 0.3].map(|tau| Effect::SensorLag { channel, tau }));
        all.extend([0.05, 0.2].map(|delay| Effect::SensorDelay { channel, delay }));
    }
    for axis in 0..3 {
        all.extend([1.0, -3.0].map(|offset| {
            let offset_m = std::array::from_fn(|i| if i == axis { offset } else { 0.0 });
            Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m }
        }));
    }
    all
}

/// The truth: a channel's own bias adds to the one that is put in.
pub(crate) fn with_own(errors: &[Effect], own: &[(Channel, f64)]) -> Vec<Effect> {
    errors
        .iter()
        .map(|error| match *error {
            Effect::SensorBias { channel, value } => {
                let own = own.iter().find(|(drawn, _)| *drawn == channel).map_or(0.0, |(_, bias)| *bias);
                Effect::SensorBias { channel, value: value + own }
            }
            other => other,
        })
        .collect()
}
