//! Flights in which much is a little wrong, as in every real one: mild nonlinearity on every axis, unsteady aerodynamics or a
//! mass that falls, gusts of 0.1 to 0.5 m/s, vanes with a lag, a structural mode of 2 to 5 Hz that controls excite, instruments
//! inside of their specification, the model off the aircraft's trim. It is drawn first and kept; then something large is hidden.
//!
//! The share of the error of each part is what it alone changes in the recordings, mean square in standard deviations of noise.

use super::case::{Case, Plan, Recorded, Sort, plan};
use super::draw::{one_of, stream};
use super::flights::{flown, fly, noise_stds};
use super::motion::Motion;
use super::off_trim::off_trim;
use super::outside::Law;
use crate::support::uniform::Uniform;
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{AXES, Axis, Variable};
use sideslip::flight::effect::Effect;
use sideslip::flight::term::Term;
use sideslip::simulation::unmodelled::Unmodelled;

/// Part of an axis's motion that its own curvature makes up, at most.
const CURVATURE: f64 = 0.05;
/// Part of Z or N that follows alpha or beta late, at most.
const UNSTEADY: f64 = 0.08;
/// Mass burnt in a second, of the whole, at most.
const BURN: f64 = 1e-4;
const GRAVITY: f64 = 9.81;
/// How many draws a background may take until the aircraft survives it.
const DRAWS: u64 = 20;
/// Rms of the structural mode at the gyros, in standard deviations of their noise, at most, and its lever to the
/// accelerometers, m.
const MODE: f64 = 1.0;
const MODE_LEVER_M: f64 = 0.4;
/// Standard deviation of the gyros' noise, rad/s.
const GYRO_NOISE: f64 = 0.003;

/// One part of what is wrong, and its part of the error.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// What a diagnosis could call it; `None` where no effect describes it.
    pub(crate) effect: Option<Effect>,
    pub(crate) share: f64,
}

/// A case in that world.
pub(crate) struct CaseInBackground {
    pub(crate) case: Case,
    /// What was hidden, then the background.
    pub(crate) parts: Vec<Part>,
}

/// The case of that sort and seed with its background.
pub(crate) fn in_background(sort: Sort, seed: u64) -> CaseInBackground {
    let healthy = plan(Sort::Healthy, seed);
    let hidden = if sort == Sort::Healthy { plan(Sort::Healthy, seed) } else { plan(sort, seed) };
    let motion = Motion::of(&healthy);
    for attempt in 0..DRAWS {
        let mut uniform = Uniform(stream(seed, 5000 + attempt));
        let (effects, law) = (effects(&mut uniform, &motion), law(&mut uniform, &motion));
        let mode = Mode::draw(&mut uniform);
        let mut whole = hidden.without();
        whole.hidden = hidden.hidden.clone();
        whole.hidden.effects.extend(&effects);
        whole.hidden.law = Some(law.clone());
        let Some((mut fit, mut holdout)) = fly(&whole) else { continue };
        let Some(parts) = parts(&healthy, &hidden, &effects, &law) else { continue };
        let first = fit.len();
        for (run, recorded) in fit.iter_mut().chain(&mut holdout).enumerate() {
            mode.shake(&whole, run, recorded);
        }
        assert_eq!(first, fit.len());
        let model_text = off_trim(super::case::BASELINE, seed);
        let case = Case {
            seed,
            model_text,
            fit,
            holdout,
            hidden: hidden.hidden.effects.clone(),
            outside_library: None,
            share: hidden.hidden.share.clone(),
            off: hidden.truth.off,
        };
        return CaseInBackground { case, parts };
    }
    panic!("{sort:?} {seed}: no background in {DRAWS} draws that the aircraft survives");
}

/// The background's effects: curvature of every axis, gusts, vanes, and instruments inside of their specification.
fn effects(uniform: &mut Uniform, motion: &Motion) -> Vec<Effect> {
    let library: Vec<Term> = Term::library().collect();
    let mut effects = Vec::new();
    for axis in Axis::ALL {
        let term = one_of(uniform, &library);
        let size = uniform.within(CURVATURE) * motion.axis_rms(axis);
        let rms = motion.term_rms(term);
        if rms > 1e-6 {
            effects.push(Effect::Nonlinear { axis, term, coefficient: size / rms });
        }
    }
    effects.push(Effect::Turbulence { sigma: uniform.between(0.1, 0.5), length: uniform.between(100.0, 300.0) });
    for channel in [Channel::Alpha, Channel::Beta] {
        effects.push(Effect::SensorLag { channel, tau: uniform.between(0.01, 0.04) });
    }
    for (channel, bias, scale) in SPECIFICATION {
        effects.push(Effect::SensorBias { channel, value: uniform.within(bias) });
        effects.push(Effect::SensorScale { channel, factor: 1.0 + uniform.within(scale) });
    }
    effects
}

/// Largest bias and error of scale of an instrument that passes its calibration.
const SPECIFICATION: [(Channel, f64, f64); 11] = [
    (Channel::Ax, 0.02, 0.005),
    (Channel::Ay, 0.02, 0.005),
    (Channel::Az, 0.02, 0.005),
    (Channel::P, 0.0005, 0.005),
    (Channel::Q, 0.0005, 0.005),
    (Channel::R, 0.0005, 0.005),
    (Channel::Phi, 0.002, 0.002),
    (Channel::Theta, 0.002, 0.002),
    (Channel::Tas, 0.3, 0.01),
    (Channel::Alpha, 0.002, 0.02),
    (Channel::Beta, 0.002, 0.02),
];

/// Unsteady aerodynamics, or a mass that falls by what is burnt.
fn law(uniform: &mut Uniform, motion: &Motion) -> Law {
    let (unsteady, tau) = (uniform.within(1.0) < 0.0, uniform.between(0.1, 0.5));
    let (axis, variable) = one_of(uniform, &[(Axis::Z, Variable::W), (Axis::N, Variable::V)]);
    let rms = motion.term_rms(Term::Linear(variable)).max(1e-6);
    let size = uniform.within(UNSTEADY) * motion.axis_rms(axis) / rms;
    let burnt = uniform.between(0.2, 1.0) * BURN;
    let (said, flown) = if unsteady {
        let law = move |d: &[f64; sideslip::flight::derivative::VARIABLES], z: f64| {
            let mut added = [0.0; AXES];
            added[axis.index()] = size * (z - d[variable.index()]);
            (added, (d[variable.index()] - z) / tau)
        };
        (format!("{} {size:.4} times {variable:?}, {tau:.2} s late", axis.name()), Unmodelled::new(law))
    } else {
        // The memory is the clock; thrust and lift of the heavier aircraft accelerate the lighter one upward.
        let law = move |_: &[f64; sideslip::flight::derivative::VARIABLES], z: f64| {
            let mut added = [0.0; AXES];
            added[Axis::Z.index()] = -GRAVITY * burnt * z;
            (added, 1.0)
        };
        (format!("{burnt:.1e} of the mass burnt in a second"), Unmodelled::new(law))
    };
    Law { said, flown }
}

/// A structural mode: x'' + 2 zeta omega x' + omega^2 x = omega^2 u, u a control's deviation over the largest there is in a run.
/// The gyro and the accelerometer of its plane read x' beside the motion.
struct Mode {
    omega: f64,
    zeta: f64,
    by: Control,
    gyro: Channel,
    accelerometer: Channel,
    rms: f64,
}

impl Mode {
    fn draw(uniform: &mut Uniform) -> Self {
        let (gyro, accelerometer, by) = one_of(
            uniform,
            &[
                (Channel::Q, Channel::Az, Control::LonCyclic),
                (Channel::P, Channel::Ay, Control::LatCyclic),
                (Channel::R, Channel::Ay, Control::Pedal),
            ],
        );
        Mode {
            omega: core::f64::consts::TAU * uniform.between(2.0, 5.0),
            zeta: uniform.between(0.03, 0.08),
            by,
            gyro,
            accelerometer,
            rms: uniform.between(0.2, 1.0) * MODE * GYRO_NOISE,
        }
    }

    /// Adds it to what was recorded of that run.
    fn shake(&self, plan: &Plan, run: usize, recorded: &mut Recorded) {
        let Some(flown) = flown(plan, run) else { return };
        let at_trim = plan.truth.model.trim.controls[self.by.index()];
        let moved: Vec<f64> = flown.truth.iter().map(|state| state.blade[self.by.index()] - at_trim).collect();
        let most = moved.iter().map(|x| x.abs()).fold(1e-6, f64::max);
        const PARTS: usize = 16;
        let dt = 1.0 / (super::flights::RATE_HZ * PARTS as f64);
        let (mut x, mut rate) = (0.0, 0.0);
        let mut rates = Vec::new();
        for u in moved.iter().map(|x| x / most) {
            for _ in 0..PARTS {
                rate += dt * (self.omega * self.omega * (u - x) - 2.0 * self.zeta * self.omega * rate);
                x += dt * rate;
            }
            rates.push(rate);
        }
        let size = self.rms / super::motion::rms(rates.iter().copied()).max(1e-9);
        let at = |time_s: f64| {
            let place = (time_s - recorded.samples[0].time_s) * super::flights::RATE_HZ;
            rates.get(place as usize).copied().unwrap_or(0.0) * size
        };
        let added: Vec<f64> = recorded.samples.iter().map(|sample| at(sample.time_s)).collect();
        for (sample, x) in recorded.samples.iter_mut().zip(added) {
            for (channel, by) in [(self.gyro, 1.0), (self.accelerometer, self.omega * MODE_LEVER_M)] {
                if let Some(value) = sample.get(channel) {
                    sample.set(channel, value + by * x);
                }
            }
        }
    }
}

/// The part of the error of each thing alone; `None` where the aircraft does not survive one.
fn parts(healthy: &Plan, hidden: &Plan, background: &[Effect], law: &Law) -> Option<Vec<Part>> {
    let (clean, _) = fly(healthy)?;
    let alone = |one: super::draw::Hidden| {
        let plan = Plan { hidden: one, ..healthy.without() };
        Some(mean_square_difference(&fly(&plan)?.0, &clean))
    };
    let with = |effects: Vec<Effect>, law: Option<Law>| super::draw::Hidden { effects, law, share: Vec::new() };
    let mut parts = Vec::new();
    for &effect in hidden.hidden.effects.iter().chain(background) {
        parts.push(Part { effect: Some(effect), share: alone(with(vec![effect], None))? });
    }
    parts.push(Part { effect: None, share: alone(with(Vec::new(), Some(law.clone())))? });
    let sum: f64 = parts.iter().map(|part| part.share).sum();
    parts.iter_mut().for_each(|part| part.share /= sum.max(f64::MIN_POSITIVE));
    Some(parts)
}

/// Mean square difference between recordings of the same noise, in standard deviations of it.
fn mean_square_difference(some: &[Recorded], others: &[Recorded]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (one, other) in some.iter().zip(others) {
        for (a, b) in one.samples.iter().zip(&other.samples) {
            for (channel, std) in noise_stds() {
                if let (Some(a), Some(b)) = (a.get(channel), b.get(channel)) {
                    (sum, count) = (sum + ((a - b) / std).powi(2), count + 1.0);
                }
            }
        }
    }
    sum / f64::max(count, 1.0)
}
