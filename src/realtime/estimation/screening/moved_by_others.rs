//! Whether other instruments say that a channel moved: what tells a frozen channel that goes in steps from one at rest.
//!
//! Consumes the increments of the outputs over a window, measured and kinematic, and the channel's steps; a flow angle, the
//! airspeed or the attitude has moved by its kinematic increment, a gyro by what the attitude has turned beyond its reading.

use super::kinematic_agreement::{Increments, OUTPUT_CHANNELS, WINDOW_S};
use crate::flight::channel::{Channel, MOTION_CHANNELS};

/// By how many of its steps, and of the noise of what shows it, a channel has to have moved.
const STEPS: f64 = 4.0;

/// Whether other instruments say that a channel moved over a window by more than `STEPS` of its steps.
pub fn moved_by_others(
    channel: Channel,
    increments: &Increments,
    steps: &[f64; MOTION_CHANNELS],
    noise_var: impl Fn(usize) -> f64,
) -> bool {
    let Some(step) = steps.get(channel.index()).filter(|step| step.is_finite()) else { return false };
    let of = |output: Channel| {
        let k = OUTPUT_CHANNELS.iter().position(|other| *other == output)?;
        Some((k, (*increments.get(k)?)?))
    };
    let (by_others, noise) = match channel {
        Channel::Tas | Channel::Alpha | Channel::Beta | Channel::Phi | Channel::Theta | Channel::Psi => {
            (of(channel).map(|(_, (_, kinematic))| kinematic), 0.0)
        }
        // The rate that the attitude has turned by more, or less, than this gyro says.
        Channel::P | Channel::Q | Channel::R => {
            let output = [Channel::Phi, Channel::Theta, Channel::Psi][channel.index() - Channel::P.index()];
            let Some((k, (measured, kinematic))) = of(output) else { return false };
            (Some((measured - kinematic) / WINDOW_S), libm::sqrt(2.0 * noise_var(k)) / WINDOW_S)
        }
        _ => (None, 0.0),
    };
    by_others.is_some_and(|moved| moved.abs() > STEPS * (step + noise))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::estimation::screening::kinematic_agreement::COMPARED;

    #[test]
    fn a_gyro_has_moved_by_what_the_attitude_turned_beyond_it_and_an_angle_by_its_kinematics() {
        let mut increments: Increments = [None; COMPARED];
        let phi = OUTPUT_CHANNELS.iter().position(|output| *output == Channel::Phi).unwrap();
        increments[phi] = Some((0.08, 0.0));
        let steps = [0.01; MOTION_CHANNELS];
        // The bank turned at 0.1 rad/s, ten steps of a gyro that stood; it stood itself where the gyro says that it should turn.
        assert!(moved_by_others(Channel::P, &increments, &steps, |_| 0.0));
        assert!(!moved_by_others(Channel::P, &increments, &steps, |_| 1e-3), "within the noise of the bank");
        assert!(!moved_by_others(Channel::Phi, &increments, &steps, |_| 0.0));
        increments[phi] = Some((0.0, 0.08));
        assert!(moved_by_others(Channel::Phi, &increments, &steps, |_| 0.0));
        assert!(!moved_by_others(Channel::Phi, &increments, &[f64::INFINITY; MOTION_CHANNELS], |_| 0.0), "no step is known");
        assert!(
            !moved_by_others(Channel::Q, &increments, &steps, |_| 0.0)
                && !moved_by_others(Channel::Ax, &increments, &steps, |_| 0.0)
        );
    }
}
