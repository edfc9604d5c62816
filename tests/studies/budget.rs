//! Which instruments the error comes from: one group at a time noisy, all others perfect.
//!
//! Errors this small add as squares, so the squares of the groups' scatter come to that of all together where the method is
//! linear in the noise. The manoeuvre and the aircraft are those of `honesty`.

use super::flown::{fly, puma};
use super::honesty::{Found, QUANTITIES, at_times, inputs, truth};
use super::score::Score;
use super::sheet::Sheet;
use crate::support::asked::seeds;
use crate::support::manoeuvre::{DURATION_S, over_seeds};
use sideslip::flight::channel::Channel;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::{Instrument, InstrumentSet};

/// Groups of channels by name; noise and biases of one group are two.
const GROUPS: [(&str, &[Channel], bool, bool); 8] = [
    ("rates", &[Channel::P, Channel::Q, Channel::R], true, false),
    ("rate biases", &[Channel::P, Channel::Q, Channel::R], false, true),
    ("accelerometers", &[Channel::Ax, Channel::Ay, Channel::Az], true, false),
    ("accelerometer biases", &[Channel::Ax, Channel::Ay, Channel::Az], false, true),
    ("vanes", &[Channel::Alpha, Channel::Beta], true, false),
    ("airspeed and altitude", &[Channel::Tas, Channel::Altitude], true, false),
    ("attitude", &[Channel::Phi, Channel::Theta, Channel::Psi], true, false),
    ("controls", &Channel::CONTROLS, true, false),
];

fn only(channels: &[Channel], noise: bool, biases: bool) -> InstrumentSet {
    let mut instruments = InstrumentSet::flight_quality(1.0);
    for instrument in &mut instruments.channels {
        let inside = channels.contains(&instrument.channel);
        let kept = |kept: bool, value: f64| if inside && kept { value } else { 0.0 };
        let (noise_std, bias_std) = (kept(noise, instrument.noise_std), kept(biases, instrument.bias_std));
        *instrument = Instrument { noise_std, bias_std, ..*instrument };
    }
    instruments
}

#[test]
fn where_the_error_comes_from() {
    let model = puma(100.0).linear().clone();
    let (aircraft, truth, count) = (Flight::of(model.clone()), truth(&model), seeds(8).min(32));
    let scores = |instruments: &InstrumentSet| -> [Score; 5] {
        let found: Vec<Found> =
            over_seeds(count, |seed| at_times(&fly(&aircraft, &inputs(), instruments, DURATION_S, seed), &[DURATION_S])[0]);
        std::array::from_fn(|quantity| Score::of(found.iter().map(|one| one[quantity]), truth[quantity]))
    };
    let all = scores(&InstrumentSet::flight_quality(1.0));
    let mut sheet = Sheet::new("budget", &["instruments", "quantity", "seeds", "bias", "scatter", "share_of_variance"]);
    let mut shares = [0.0; 5];
    for (name, channels, noise, biases) in GROUPS {
        let alone = scores(&only(channels, noise, biases));
        for (place, (score, (quantity, _))) in alone.iter().zip(QUANTITIES).enumerate() {
            let share = (score.scatter / all[place].scatter).powi(2);
            shares[place] += share;
            sheet.row(&[name, quantity], &[count as f64, score.bias, score.scatter, share]);
            eprintln!("{quantity:6} {name:22} bias {:+.5}, scatter {:.5}, {share:.2} of the variance", score.bias, score.scatter);
        }
    }
    sheet.write();
    for (share, (quantity, _)) in shares.iter().zip(QUANTITIES) {
        eprintln!("{quantity:6} all groups together make {share:.2} of the variance of all at once");
        assert!((0.2..5.0).contains(share), "{quantity}: {share}");
    }
}
