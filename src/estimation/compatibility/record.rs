//! A run as the check takes it: channels as lines, a uniform mesh of times, readings at its nodes.
//!
//! Consumes samples and where instruments stand; produces the mesh (the gyros' own interval, at most [`RATE_MAX_HZ`]), and for
//! given time skews each output's readings, those that fall to one node averaged. A stretch without rates longer than
//! [`GAP_S`] parts the run: nothing is carried over it.

use super::motion::STATES;
use super::parameter::{INPUT_CHANNELS, INPUTS, OUTPUT_CHANNELS, OUTPUTS, SCALE, Theta};
use super::series::Series;
use crate::flight::channel::Channel;
use crate::flight::run::RunGeometry;
use crate::telemetry::record::Sample;

/// The mesh is not finer than this, Hz: the motion of a rigid aircraft is slower, and what is faster (vibration, filters of
/// the instruments) is left to the average.
pub const RATE_MAX_HZ: f64 = 12.5;
/// A gap that parts the run, s.
pub const GAP_S: f64 = 0.5;
/// Outputs are not compared so near to both ends, so that a skew moves none of them out of the run, s.
const EDGE_S: f64 = 0.4;
/// Fewer readings of a channel are none.
const READINGS_MIN: usize = 20;

/// Channels of a run.
#[derive(Clone, Debug, Default)]
pub struct Record {
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
    /// Interval of the mesh, s.
    pub step_s: f64,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// The gyros' own interval, s.
    pub sample_s: f64,
    first_s: f64,
    anew: Vec<bool>,
    groups: [Vec<Group>; OUTPUTS],
}

/// Samples of one output that are averaged.
#[derive(Clone, Copy, Debug)]
struct Group {
    time_s: f64,
    value: f64,
    count: f64,
}

/// Readings of one output that fall to one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Which output.
    pub output: usize,
    /// Their mean.
    pub value: f64,
    /// Their mean time less the node's, s.
    pub late_s: f64,
    /// How many.
    pub count: f64,
}

/// Readings by node.
pub struct Readings {
    all: Vec<Reading>,
    begins: Vec<usize>,
}

impl Readings {
    /// Those of one node.
    pub fn at(&self, node: usize) -> &[Reading] {
        let from = self.begins.get(node).copied().unwrap_or(0);
        let to = self.begins.get(node + 1).copied().unwrap_or(from);
        self.all.get(from..to).unwrap_or(&[])
    }
}

impl Record {
    /// Gathers a run's samples.
    pub fn of(samples: &[Sample], geometry: &RunGeometry) -> Record {
        let line = |channel: Channel| {
            let series = Series::of(samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?))));
            let still = series.samples().all(|(_, value)| (value - series.at(f64::NEG_INFINITY)).abs() < 1e-12);
            (series.len() >= READINGS_MIN && !still).then_some(series)
        };
        let mut record = Record {
            inputs: INPUT_CHANNELS.map(line),
            outputs: OUTPUT_CHANNELS.map(|channel| {
                let series = line(channel)?;
                Some(if matches!(channel, Channel::Psi | Channel::Phi) { series.unwrapped() } else { series })
            }),
            accelerometer_place: geometry.accelerometer_position_m,
            vane_place: geometry.vane_position_m,
            ..Record::default()
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
        record.mesh();
        if record.nodes > 0 {
            record.group();
        }
        record
    }

    /// Lays the mesh over the time that the gyros cover.
    fn mesh(&mut self) {
        let gyros: Vec<&Series> = self.inputs.iter().skip(3).flatten().collect();
        let range = gyros.iter().filter_map(|series| series.range_s());
        let (first_s, last_s) = range.fold((f64::NEG_INFINITY, f64::INFINITY), |(a, b), (c, d)| (a.max(c), b.min(d)));
        let interval_s = gyros.iter().filter_map(|series| series.interval_s()).fold(0.0, f64::max);
        if gyros.len() < 3 || !(last_s > first_s) || !(interval_s > 0.0) {
            return;
        }
        (self.first_s, self.sample_s) = (first_s, interval_s);
        // Whole intervals of the gyros, so that no step is made up of parts of samples.
        self.step_s = interval_s * libm::floor((1.0 / (RATE_MAX_HZ * interval_s) + 1e-6).max(1.0));
        self.nodes = ((last_s - first_s) / self.step_s + 1e-6) as usize + 1;
        self.anew = vec![false; self.nodes];
        for series in self.inputs.iter().flatten() {
            let mut before_s = first_s;
            for (time_s, _) in series.samples() {
                if time_s - before_s > GAP_S.max(3.0 * self.step_s) {
                    let node = ((time_s - first_s) / self.step_s).ceil() as usize;
                    if let Some(anew) = self.anew.get_mut(node) {
                        *anew = true;
                    }
                }
                before_s = time_s;
            }
        }
    }

    /// Time of a node, s.
    pub fn time_s(&self, node: usize) -> f64 {
        self.first_s + self.step_s * node as f64
    }

    /// Length of the mesh, s.
    pub fn length_s(&self) -> f64 {
        self.step_s * self.nodes.saturating_sub(1) as f64
    }

    /// Whether nothing is carried to that node from the one before.
    pub fn starts_anew(&self, node: usize) -> bool {
        self.anew.get(node).copied().unwrap_or(false)
    }

    /// How many gaps part the run.
    pub fn gaps(&self) -> usize {
        self.anew.iter().filter(|anew| **anew).count()
    }

    /// A first guess of the state at a node, by what is measured there.
    pub fn start(&self, node: usize, theta: &Theta) -> [f64; STATES] {
        let time_s = self.time_s(node);
        let read = |output: usize| {
            let series = self.outputs.get(output).and_then(Option::as_ref)?;
            let measured = INPUTS + output;
            let about = self.about[output];
            let mean = series.mean(time_s, time_s + 0.2);
            Some((mean - theta.bias(measured) - about) / (1.0 + theta.values[SCALE + measured]) + about)
        };
        let speed = read(0).unwrap_or(50.0).max(3.0);
        let [alpha, beta, phi, theta, psi] = [1, 2, 3, 4, 5].map(|output| read(output).unwrap_or(0.0));
        let (sin_beta, cos_beta) = libm::sincos(beta);
        let (sin_alpha, cos_alpha) = libm::sincos(alpha);
        let altitude = read(6).unwrap_or(0.0);
        [speed * cos_alpha * cos_beta, speed * sin_beta, speed * sin_alpha * cos_beta, phi, theta, psi, altitude, 0.0]
    }

    /// Averages each output over the mesh as it stands without any skew: the same groups of samples whatever is tried later.
    fn group(&mut self) {
        let (from_s, to_s) = (self.first_s, self.time_s(self.nodes.saturating_sub(1)));
        let margin_s = EDGE_S.min(0.05 * (to_s - from_s));
        for (groups, series) in self.groups.iter_mut().zip(&self.outputs) {
            let Some(series) = series else { continue };
            let mut last = None;
            for (time_s, value) in series.samples().filter(|(t, _)| *t >= from_s + margin_s && *t <= to_s - margin_s) {
                let node = libm::round((time_s - self.first_s) / self.step_s);
                match groups.last_mut().filter(|_| last == Some(node)) {
                    Some(Group { time_s: mean_s, value: mean, count }) => {
                        *count += 1.0;
                        *mean_s += (time_s - *mean_s) / *count;
                        *mean += (value - *mean) / *count;
                    }
                    None => groups.push(Group { time_s, value, count: 1.0 }),
                }
                last = Some(node);
            }
        }
    }

    /// Readings of every output by node, each at the time when it was true.
    pub fn readings(&self, theta: &Theta) -> Readings {
        let mut by_node: Vec<Reading> = Vec::new();
        let mut keyed: Vec<(usize, Reading)> = Vec::new();
        for (output, groups) in self.groups.iter().enumerate() {
            let skew = theta.skew_s(INPUTS + output);
            for group in groups {
                let place = (group.time_s - skew - self.first_s) / self.step_s;
                let node = libm::round(place).clamp(0.0, self.nodes.saturating_sub(1) as f64);
                let late_s = (place - node) * self.step_s;
                keyed.push((node as usize, Reading { output, value: group.value, late_s, count: group.count }));
            }
        }
        keyed.sort_by_key(|(node, reading)| (*node, reading.output));
        let mut begins = Vec::with_capacity(self.nodes + 1);
        for (node, reading) in keyed {
            while begins.len() <= node {
                begins.push(by_node.len());
            }
            by_node.push(reading);
        }
        while begins.len() <= self.nodes {
            begins.push(by_node.len());
        }
        Readings { all: by_node, begins }
    }
}
