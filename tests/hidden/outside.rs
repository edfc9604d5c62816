//! Causes that no effect describes: hysteresis, memory, uneven and even terms, what comes and goes, what shakes of itself.
//!
//! Sized as the other terms are. One that a single linear or library term would mostly make up is not outside: it is drawn
//! again.

use super::draw::{coefficient, one_of};
use super::motion::{Motion, rms};
use crate::support::uniform::Uniform;
use sideslip::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use sideslip::flight::term::{MOTION, Term};
use sideslip::simulation::unmodelled::Unmodelled;

/// Most that one term may make up of a cause outside, of 1.
const TOLD_BY_ONE_TERM: f64 = 0.5;

/// How fast a play follows what pushes it, 1/s.
const PLAY_RATE: f64 = 25.0;

/// How many sorts of cause take turns.
pub(crate) const TURNS: u64 = 8;

/// A cause in words and as it is flown.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    pub(crate) said: String,
    pub(crate) flown: Unmodelled,
}

/// Value and rate of the memory for deviations and memory, before it is given its size.
type Shape = Box<dyn Fn(&[f64; VARIABLES], f64) -> (f64, f64) + Send + Sync>;

/// A cause of the seed's turn, with an axis and numbers drawn; `None` where a term of the library makes it up.
pub(crate) fn draw(seed: u64, attempt: u64, uniform: &mut Uniform, share: f64, motion: &Motion) -> Option<Law> {
    // An axis on which nothing was to be seen in a third of the draws gives way to the next.
    let axis = Axis::ALL[((seed % TURNS + seed / TURNS + attempt / 20) % 6) as usize];
    let variable = one_of(uniform, &MOTION);
    let (x, moves) = (variable.index(), motion.term_rms(Term::Linear(variable)));
    let other = one_of(uniform, &MOTION.into_iter().filter(|&other| other != variable).collect::<Vec<_>>());
    let y = other.index();
    let pedal = one_of(uniform, &[Variable::LonCyclic, Variable::LatCyclic, Variable::Pedal]);
    let c = pedal.index();
    let name = |variable: Variable| variable.name(sideslip::flight::channel::ControlNames::Rotorcraft);
    let (x_name, y_name, c_name) = (name(variable), name(other), name(pedal));
    let (what, shape): (String, Shape) = match seed % TURNS {
        0 => {
            let play = moves * uniform.between(0.4, 0.9);
            let shape = move |d: &[f64; VARIABLES], z: f64| {
                let apart = d[x] - z;
                let held = apart.clamp(-play, play);
                (held, PLAY_RATE * (apart - held))
            };
            (format!("hysteresis of {x_name}, play {play:.4}"), Box::new(shape))
        }
        1 => {
            let tau = uniform.between(0.4, 1.5);
            (format!("memory of {x_name}, {tau:.2} s"), Box::new(move |d, z| (z, (d[x] - z) / tau)))
        }
        2 => (format!("{x_name}*|{y_name}|"), Box::new(move |d, _| (d[x] * d[y].abs(), 0.0))),
        3 => (format!("|{x_name}|"), Box::new(move |d, _| (d[x].abs(), 0.0))),
        4 => (format!("{c_name}*{c_name}"), Box::new(move |d, _| (d[c] * d[c], 0.0))),
        5 => (format!("{c_name}*{x_name}"), Box::new(move |d, _| (d[c] * d[x], 0.0))),
        6 => {
            let onset = moves * uniform.between(0.6, 1.2);
            let shape = move |d: &[f64; VARIABLES], _: f64| (((d[x].abs() - onset) / (0.1 * onset)).clamp(0.0, 1.0), 0.0);
            (format!("onset where |{x_name}| > {onset:.4}"), Box::new(shape))
        }
        _ => {
            let omega = uniform.between(4.0, 15.0);
            // The memory is the clock.
            (format!("shaking at {omega:.2} rad/s"), Box::new(move |_, z| ((omega * z).sin(), 1.0)))
        }
    };
    let sized = |size: f64, shape: Shape| {
        Unmodelled::new(move |deviations, memory| {
            let (value, rate) = shape(deviations, memory);
            let mut added = [0.0; AXES];
            added[axis.index()] = size * value;
            (added, rate)
        })
    };
    let shape = std::sync::Arc::new(shape);
    let plain = shape.clone();
    let values = motion.law(&sized(1.0, Box::new(move |d, z| plain(d, z))), axis);
    let most = values.iter().map(|values| rms(values.iter().copied())).fold(0.0, f64::max);
    let size = coefficient(uniform, share, axis, most, motion)?;
    if motion.told_by_one_term(&values) > TOLD_BY_ONE_TERM {
        return None;
    }
    let said = format!("{} {size:.4} times {what}", axis.name());
    Some(Law { said, flown: sized(size, Box::new(move |d, z| shape(d, z))) })
}
