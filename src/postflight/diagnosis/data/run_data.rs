//! A run as the diagnosis takes it: outputs and inputs as lines, a uniform mesh of times, noise of each channel.
//!
//! Consumes samples and where instruments stand; produces the mesh (`gyro_coverage` at [`MESH_RATE_HZ`]) and, for a given time
//! skew, each output's readings, those that fall to one node averaged. Vibration of the rotor's blades is taken out first
//! (`blade_passing`), so that what is left of a channel's third differences is its noise. The rotor's speed moves slowly beside
//! its noise, which would bias what correlates with it towards zero: it is smoothed (`rotor_speed_smoother`).

use super::rotor_speed_smoother::smoothed;
use crate::flight::channel::Channel;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::flight::signal::GAP_S;
use crate::flight::signal::gyro_coverage::{FirstNode, GyroCoverage};
use crate::flight::signal::readings::{Groups, Mesh, Readings};
use crate::flight::signal::series::Series;
use crate::postflight::diagnosis::data::blade_passing;
use crate::postflight::diagnosis::record::{LENGTH_MIN_S, Unusable};

/// Rate of the mesh, Hz: f of [`gyro_coverage`](crate::flight::signal::gyro_coverage).
pub const MESH_RATE_HZ: f64 = 32.0;
/// An input moves that goes through so many times its noise.
const STILL: f64 = 12.0;
/// Fewer readings of a channel are none.
const READINGS_MIN: usize = 16;

/// Number of outputs.
pub const OUTPUTS: usize = 13;
/// Place of ax, ay, az among the outputs.
pub const FORCE_OUTPUT: usize = 0;
/// Place of p, q, r.
pub const RATE_OUTPUT: usize = 3;
/// Place of phi, theta, psi.
pub const ATTITUDE_OUTPUT: usize = 6;
/// Place of the airspeed.
pub const TAS_OUTPUT: usize = 9;
/// Place of the incidence.
pub const ALPHA_OUTPUT: usize = 10;
/// Place of the sideslip.
pub const BETA_OUTPUT: usize = 11;
/// Places of what shows u, v and w.
pub const FLOW_OUTPUTS: [usize; 3] = [TAS_OUTPUT, BETA_OUTPUT, ALPHA_OUTPUT];
/// Place of the altitude.
pub const ALTITUDE_OUTPUT: usize = 12;
/// Channels of the outputs, in the order of their places.
pub const OUTPUT_CHANNELS: [Channel; OUTPUTS] = [
    Channel::Ax,
    Channel::Ay,
    Channel::Az,
    Channel::P,
    Channel::Q,
    Channel::R,
    Channel::Phi,
    Channel::Theta,
    Channel::Psi,
    Channel::Tas,
    Channel::Alpha,
    Channel::Beta,
    Channel::Altitude,
];
/// What moves the aircraft: four controls, the rotor's speed, what accelerometers felt on axes without a model.
pub const INPUTS: usize = CONTROLS + 4;
/// Place of the rotor's speed among the inputs.
pub const ROTOR: usize = CONTROLS;
/// First place of what accelerometers felt.
pub const MEASURED_FORCE: usize = CONTROLS + 1;
/// No instrument is better than this.
const NOISE_FLOOR: [f64; OUTPUTS] = [0.01, 0.01, 0.01, 1e-4, 1e-4, 1e-4, 2e-4, 2e-4, 2e-4, 0.03, 2e-4, 2e-4, 0.1];

/// The channel of an input.
pub fn input_channel(input: usize) -> Channel {
    match Control::ALL.get(input) {
        Some(control) => control.channel(),
        None if input == ROTOR => Channel::RotorSpeed,
        None => OUTPUT_CHANNELS.get(input.wrapping_sub(MEASURED_FORCE)).copied().unwrap_or(Channel::Az),
    }
}

/// From the least to the most of a series.
fn span(series: &Series) -> f64 {
    let (least, most) = series.samples().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, x)| (a.min(x), b.max(x)));
    most - least
}

/// The time that the rates cover, without a gap.
fn gyros_of(gyros: &[Option<Series>]) -> Result<GyroCoverage, Unusable> {
    if let Some((_, name)) = gyros.iter().zip(["p", "q", "r"]).find(|(series, _)| series.is_none()) {
        return Err(Unusable::NoRates(name));
    }
    let coverage = GyroCoverage::of(gyros.iter().flatten());
    let GyroCoverage { first_s, last_s, interval_s } = coverage;
    if !(last_s - first_s >= LENGTH_MIN_S) {
        return Err(Unusable::Short((last_s - first_s).max(0.0)));
    }
    if !(interval_s <= 0.126) {
        return Err(Unusable::Seldom(interval_s));
    }
    match gyros.iter().flatten().find_map(|series| series.gaps(first_s, GAP_S).next()) {
        Some((before_s, time_s)) => Err(Unusable::Gap(before_s, time_s)),
        None => Ok(coverage),
    }
}

/// A run.
#[derive(Clone, Debug)]
pub struct RunData {
    /// Its name.
    pub name: String,
    /// What it says of itself.
    pub geometry: RunGeometry,
    /// What was seen, by place.
    pub outputs: [Option<Series>; OUTPUTS],
    /// What was moved, by place.
    pub inputs: [Option<Series>; INPUTS],
    /// Standard deviation of one sample of each output, as the filter takes it.
    pub output_noise: [f64; OUTPUTS],
    /// The same by the record alone, from third differences.
    pub recorded_noise: [f64; OUTPUTS],
    /// Standard deviation of one sample of each input.
    pub input_noise: [f64; INPUTS],
    /// Density of the noise of the rotor's acceleration, rad^2/s^3.
    pub rotor_rate_density: f64,
    /// The mesh.
    pub mesh: Mesh,
    gyros: GyroCoverage,
    groups: Groups<OUTPUTS>,
}

impl RunData {
    /// Gathers a run's samples.
    ///
    /// # Errors
    /// [`Unusable`] where time goes back or the rates do not make a run.
    pub fn of(name: &str, samples: &[Sample], geometry: RunGeometry) -> Result<RunData, Unusable> {
        let back = samples.windows(2).position(|pair| matches!(pair, [before, after] if after.time_s < before.time_s));
        if let Some((place, [before, after])) = back.and_then(|place| Some((place, samples.get(place..place + 2)?))) {
            return Err(Unusable::Back { sample: place + 2, before_s: before.time_s, time_s: after.time_s });
        }
        let line = |channel: Channel| Series::of_channel(samples, channel, READINGS_MIN);
        let mut outputs = OUTPUT_CHANNELS.map(line);
        let gyros = gyros_of(&outputs[RATE_OUTPUT..ATTITUDE_OUTPUT])?;
        let mut inputs = core::array::from_fn(|input| if input < MEASURED_FORCE { line(input_channel(input)) } else { None });
        let noise = |series: &Option<Series>| series.as_ref().map_or(0.0, Series::noise_std);
        let mut input_noise = core::array::from_fn(|i| noise(&inputs[i]));
        let mut rotor_rate_density = 0.0;
        if let Some(rotor) = &mut inputs[ROTOR] {
            let smoothed = smoothed(rotor);
            (*rotor, input_noise[ROTOR], rotor_rate_density) = (smoothed.series, smoothed.noise_std, smoothed.slope_density);
        }
        if let Some(rotor) = &inputs[ROTOR] {
            let shown = || outputs[..3].iter().rev().flatten().find_map(|series| blade_passing::blades_of(series, rotor));
            if let Some(blades) = geometry.blades.or_else(shown) {
                for series in outputs.iter_mut().take(6).flatten() {
                    *series = blade_passing::removed(series, rotor, f64::from(blades));
                }
            }
        }
        let output_noise = core::array::from_fn(|c| noise(&outputs[c]).max(NOISE_FLOOR[c]));
        let mut record = RunData {
            name: name.to_owned(),
            geometry,
            outputs,
            inputs,
            output_noise,
            recorded_noise: output_noise,
            input_noise,
            rotor_rate_density,
            mesh: Mesh::default(),
            gyros,
            groups: Groups::default(),
        };
        record.lay_mesh(MESH_RATE_HZ);
        Ok(record)
    }

    /// Whether an input goes through more than its noise.
    pub fn moves(&self, place: usize) -> bool {
        let noise = self.input_noise.get(place).copied().unwrap_or_default();
        self.inputs.get(place).and_then(Option::as_ref).is_some_and(|series| span(series) > STILL * noise.max(1e-6))
    }

    /// Gives two channels each other's records; both outputs or both inputs.
    pub fn exchange(&mut self, channels: [Channel; 2]) {
        let [one, other] = channels;
        let outputs = [one, other].map(|channel| OUTPUT_CHANNELS.iter().position(|output| *output == channel));
        let inputs = [one, other].map(|channel| (0..MEASURED_FORCE).find(|&input| input_channel(input) == channel));
        if let [Some(one), Some(other)] = outputs {
            self.outputs.swap(one, other);
            self.output_noise.swap(one, other);
            self.recorded_noise.swap(one, other);
            self.regroup();
        } else if let [Some(one), Some(other)] = inputs {
            self.inputs.swap(one, other);
            self.input_noise.swap(one, other);
        }
    }

    /// Turns the sign of an output.
    pub fn turn_output(&mut self, place: usize) {
        if let Some(series) = self.outputs.get_mut(place).and_then(Option::as_mut) {
            *series = series.mapped(|value| -value);
            self.regroup();
        }
    }

    /// Turns the sign of an input: of its readings where they begin nearer to the trim so, else of their deviations from it.
    pub fn turn_input(&mut self, place: usize, trim: f64) {
        if let Some(series) = self.inputs.get_mut(place).and_then(Option::as_mut) {
            let begins = series.range_s().map_or(trim, |(from_s, _)| series.mean(from_s, from_s + 1.0));
            let about = if libm::fabs(begins + trim) < libm::fabs(begins - trim) { 0.0 } else { trim };
            *series = series.mapped(|value| 2.0 * about - value);
        }
    }

    /// Takes the accelerometer along an axis without a model for what moved the aircraft along it.
    pub fn use_measured_force(&mut self, axis: usize) {
        let (Some(output), Some(input)) = (self.outputs.get_mut(axis), self.inputs.get_mut(MEASURED_FORCE + axis)) else {
            return;
        };
        *input = output.take();
        self.input_noise[MEASURED_FORCE + axis] = self.output_noise[axis];
        self.regroup();
    }

    /// Lays the mesh anew at this rate, Hz.
    pub fn lay_mesh(&mut self, rate_hz: f64) {
        self.mesh = self.gyros.mesh(rate_hz, FirstNode::MiddleOfStep);
        self.regroup();
    }

    fn regroup(&mut self) {
        self.groups = Groups::of(&self.outputs, &self.mesh, (f64::NEG_INFINITY, f64::INFINITY));
    }

    /// Readings of every output by node, taken as of the time that `late_s` before their own.
    pub fn readings(&self, late_s: &[f64; OUTPUTS]) -> Readings {
        self.groups.readings(&self.mesh, late_s)
    }
}
