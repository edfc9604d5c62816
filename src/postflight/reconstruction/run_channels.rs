//! A run as the check takes it: channels as lines, a uniform mesh of times, readings at its nodes.
//!
//! Consumes samples and where instruments stand; produces the mesh (`gyro_coverage` at [`MESH_RATE_HZ`]), and for
//! given time skews each output's readings, those that fall to one node averaged. A stretch without rates longer than
//! [`GAP_S`] parts the run: nothing is carried over it, and as at both ends no output is compared within [`EDGE_S`] of it, where
//! a skew would take its reading, or an input's, out of the gap. Stretches without any sample are shortened (`shortened_gaps`):
//! times here are not the record's own after one.

use super::motion::STATES;
use super::parameter::{INPUT_CHANNELS, INPUTS, OUTPUT_CHANNELS, OUTPUTS, SCALE, Theta};
use super::shortened_gaps::with_shortened_gaps;
use crate::flight::channel::Channel;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::flight::signal::GAP_S;
use crate::flight::signal::gap_union::gap_union;
use crate::flight::signal::gyro_coverage::{FirstNode, GyroCoverage};
use crate::flight::signal::readings::{Groups, Mesh, Readings};
use crate::flight::signal::series::Series;
use crate::postflight::start_state::{start_reading, start_velocity};

/// Rate of the mesh, Hz: the motion of a rigid aircraft is slower, and what is faster (vibration, filters of
/// the instruments) is left to the average.
pub(crate) const MESH_RATE_HZ: f64 = 12.5;
/// Outputs are not compared so near to both ends and to gaps, so that a skew moves none of them out of the run, s.
const EDGE_S: f64 = 0.4;
/// Fewer readings of a channel are none.
const READINGS_MIN: usize = 20;

/// Channels of a run.
#[derive(Clone, Debug, Default)]
pub struct RunChannels {
    /// Accelerometers and gyros.
    pub inputs: [Option<Series>; INPUTS],
    /// Air data, attitude and altitude.
    pub outputs: [Option<Series>; OUTPUTS],
    /// Where the accelerometers are said to stand, m.
    pub accelerometer_place: [f64; 3],
    /// Where the vanes are said to stand, m.
    pub vane_place: [f64; 3],
    /// Whether velocities can be followed: there are accelerometers and an airspeed.
    pub velocities: bool,
    /// What a factor is taken about: zero, but the mean where only changes count.
    pub about: [f64; OUTPUTS],
    /// The mesh; without nodes where there are no gyros.
    pub mesh: Mesh,
    /// The gyros' own interval, s.
    pub sample_s: f64,
    /// Shortened gaps in the record's own time: the last sample before and the first after, s.
    pub long_gaps: Vec<[f64; 2]>,
    anew: Vec<bool>,
    /// Gaps of the inputs in order, those that overlap as one: last sample before and first after, s.
    gaps: Vec<[f64; 2]>,
    groups: Groups<OUTPUTS>,
}

impl RunChannels {
    /// Gathers a run's samples.
    pub fn of(samples: &[Sample], geometry: &RunGeometry) -> RunChannels {
        let (samples, long_gaps) = with_shortened_gaps(samples);
        let line = |channel: Channel| {
            let series = Series::of_channel(&samples, channel, READINGS_MIN)?;
            let still = series.samples().all(|(_, value)| (value - series.at(f64::NEG_INFINITY)).abs() < 1e-12);
            (!still).then_some(series)
        };
        let mut record = RunChannels {
            inputs: INPUT_CHANNELS.map(line),
            outputs: OUTPUT_CHANNELS.map(line),
            accelerometer_place: geometry.accelerometer_position_m,
            vane_place: geometry.vane_position_m,
            long_gaps,
            ..RunChannels::default()
        };
        let forces = record.inputs.iter().take(3).flatten().count();
        record.velocities = forces == 3 && record.outputs.first().is_some_and(Option::is_some);
        if !record.velocities {
            // Nothing says how the velocities move, so nothing can be compared with them.
            for (output, channel) in record.outputs.iter_mut().zip(OUTPUT_CHANNELS) {
                if !matches!(channel, Channel::Phi | Channel::Theta | Channel::Psi) {
                    *output = None;
                }
            }
        }
        for ((about, series), channel) in record.about.iter_mut().zip(&record.outputs).zip(OUTPUT_CHANNELS) {
            if let (Channel::Psi | Channel::Altitude, Some(series)) = (channel, series) {
                *about = series.at(f64::NEG_INFINITY);
            }
        }
        record.lay_mesh();
        record.group();
        record
    }

    /// The same with one channel's sign turned.
    #[must_use]
    pub fn turned(&self, channel: Channel) -> RunChannels {
        let mut other = self.clone();
        let named = INPUT_CHANNELS.iter().zip(&mut other.inputs).chain(OUTPUT_CHANNELS.iter().zip(&mut other.outputs));
        for (_, series) in named.filter(|(one, _)| **one == channel) {
            *series = series.take().map(|series| Series::of(series.samples().map(|(time_s, value)| (time_s, -value))));
        }
        other.group();
        other
    }

    /// The same with the two accelerometers across gravity under each other's names.
    #[must_use]
    pub fn exchanged(&self) -> RunChannels {
        let mut other = self.clone();
        other.inputs.swap(0, 1);
        other
    }

    /// Gives the outputs' samples to the nodes.
    fn group(&mut self) {
        if self.mesh.nodes > 0 {
            // Not at both ends, so that a skew moves none out of the run.
            let (from_s, to_s) = (self.mesh.first_s, self.mesh.time_s(self.mesh.nodes.saturating_sub(1)));
            let margin_s = EDGE_S.min(0.05 * (to_s - from_s));
            let within = (from_s + margin_s, to_s - margin_s);
            self.groups = if self.gaps.is_empty() {
                Groups::of(&self.outputs, &self.mesh, within)
            } else {
                let beside = |series: &Series| {
                    let near = |time_s: f64| self.gaps.iter().any(|[a, b]| time_s >= a - EDGE_S && time_s <= b + EDGE_S);
                    Series::of(series.samples().filter(|(time_s, _)| !near(*time_s)))
                };
                let outputs = core::array::from_fn(|output| self.outputs[output].as_ref().map(beside));
                Groups::of(&outputs, &self.mesh, within)
            };
        }
    }

    /// Lays the mesh over the time that the gyros cover.
    fn lay_mesh(&mut self) {
        let gyros = self.inputs.iter().skip(3).flatten();
        let coverage = GyroCoverage::of(gyros.clone());
        let GyroCoverage { first_s, last_s, interval_s } = coverage;
        if gyros.count() < 3 || !(last_s > first_s) || !(interval_s > 0.0) {
            return;
        }
        self.sample_s = interval_s;
        self.mesh = coverage.mesh(MESH_RATE_HZ, FirstNode::FirstSample);
        self.anew = vec![false; self.mesh.nodes];
        let longest_s = GAP_S.max(3.0 * self.mesh.step_s);
        let of_inputs = self.inputs.iter().flatten().flat_map(|series| series.gaps(first_s, longest_s));
        self.gaps = gap_union(of_inputs.map(|(from_s, to_s)| [from_s, to_s]).collect());
        // Meanwhile nothing is followed: each node is a start, and the last of them is where the record goes on.
        for [from_s, to_s] in &self.gaps {
            let place = |time_s: f64| ((time_s - first_s) / self.mesh.step_s).max(0.0);
            let (from, to) = (place(*from_s) as usize, libm::ceil(place(to_s + EDGE_S)) as usize);
            self.anew.iter_mut().take(to.saturating_add(1)).skip(from.saturating_add(1)).for_each(|anew| *anew = true);
        }
    }

    /// A channel, where it is there.
    pub fn series(&self, channel: Channel) -> Option<&Series> {
        let input = INPUT_CHANNELS.iter().position(|one| *one == channel).and_then(|place| self.inputs.get(place));
        let output = || OUTPUT_CHANNELS.iter().position(|one| *one == channel).and_then(|place| self.outputs.get(place));
        input.or_else(output)?.as_ref()
    }

    /// Whether nothing is carried to that node from the one before.
    pub fn starts_anew(&self, node: usize) -> bool {
        self.anew.get(node).copied().unwrap_or(false)
    }

    /// How many gaps part the run.
    pub fn gaps(&self) -> usize {
        self.gaps.len()
    }

    /// A first guess of the state at a node, by what is measured there.
    pub fn start(&self, node: usize, theta: &Theta) -> [f64; STATES] {
        let time_s = self.mesh.time_s(node);
        let read = |output: usize| {
            let series = self.outputs.get(output).and_then(Option::as_ref)?;
            let measured = INPUTS + output;
            let about = self.about[output];
            Some((start_reading(series, time_s) - theta.bias(measured) - about) / (1.0 + theta.values[SCALE + measured]) + about)
        };
        let speed = read(0).unwrap_or(50.0);
        let [alpha, beta, phi, theta, psi] = [1, 2, 3, 4, 5].map(|output| read(output).unwrap_or(0.0));
        let [u, v, w] = start_velocity(speed, alpha, beta);
        [u, v, w, phi, theta, psi, read(6).unwrap_or(0.0), 0.0]
    }

    /// Readings of every output by node, each at the time when it was true.
    pub fn readings(&self, theta: &Theta) -> Readings {
        self.groups.readings(&self.mesh, &core::array::from_fn(|output| theta.skew_s(INPUTS + output)))
    }
}
