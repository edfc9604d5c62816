//! Readings of outputs by the nodes of a mesh.
//!
//! Consumes each output's samples; samples of one node of the mesh without skew are averaged once,
//! so that the groups do not depend on the skew and costs for different skews are comparable. Produces, for given skews, the
//! groups by node.

use super::series::Series;

/// Nodes at equal distances.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mesh {
    /// Time of the first, s.
    pub first_s: f64,
    /// Between two, s.
    pub step_s: f64,
    /// How many.
    pub nodes: usize,
}

impl Mesh {
    /// Time of a node, s.
    pub fn time_s(&self, node: usize) -> f64 {
        self.first_s + self.step_s * node as f64
    }

    /// From the first node to the last, s.
    pub fn length_s(&self) -> f64 {
        self.step_s * self.nodes.saturating_sub(1) as f64
    }

    /// Where a time lies, in nodes.
    fn place(&self, time_s: f64) -> f64 {
        (time_s - self.first_s) / self.step_s
    }
}

/// Samples of one output that are averaged.
#[derive(Clone, Copy, Debug)]
struct Group {
    time_s: f64,
    value: f64,
    count: f64,
}

/// The samples of `N` outputs in groups.
#[derive(Clone, Debug)]
pub struct Groups<const N: usize> {
    of: [Vec<Group>; N],
}

impl<const N: usize> Default for Groups<N> {
    fn default() -> Self {
        Groups { of: core::array::from_fn(|_| Vec::new()) }
    }
}

/// Samples of one output that fall to one node.
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
#[derive(Clone, Debug, Default)]
pub struct Readings {
    all: Vec<Reading>,
    begins: Vec<usize>,
}

impl<const N: usize> Groups<N> {
    /// Groups the samples of each output that fall to a node, and between these times.
    pub fn of(outputs: &[Option<Series>; N], mesh: &Mesh, (from_s, to_s): (f64, f64)) -> Self {
        let mut grouped = Groups::default();
        for (groups, series) in grouped.of.iter_mut().zip(outputs) {
            let Some(series) = series else { continue };
            let mut last = None;
            for (time_s, value) in series.samples().filter(|(time_s, _)| *time_s >= from_s && *time_s <= to_s) {
                let node = libm::round(mesh.place(time_s));
                if !(node >= 0.0 && node < mesh.nodes as f64) {
                    continue;
                }
                match groups.last_mut().filter(|_| last == Some(node)) {
                    Some(Group { time_s: mean_s, value: mean, count }) => {
                        *count += 1.0;
                        *mean += (value - *mean) / *count;
                        *mean_s += (time_s - *mean_s) / *count;
                    }
                    None => groups.push(Group { time_s, value, count: 1.0 }),
                }
                last = Some(node);
            }
        }
        grouped
    }

    /// Readings of every output by node, taken as of the time that its `late_s` before their own.
    pub fn readings(&self, mesh: &Mesh, late_s: &[f64; N]) -> Readings {
        let mut keyed: Vec<(usize, Reading)> = Vec::new();
        let last = mesh.nodes.saturating_sub(1) as f64;
        for (output, groups) in self.of.iter().enumerate() {
            for group in groups {
                let place = mesh.place(group.time_s - late_s[output]);
                // What a skew moves out of the run is held at its end, where a straight line leads to it.
                let node = libm::round(place).clamp(0.0, last);
                let late_s = (place - node) * mesh.step_s;
                keyed.push((node as usize, Reading { output, value: group.value, late_s, count: group.count }));
            }
        }
        keyed.sort_by_key(|(node, reading)| (*node, reading.output));
        let mut readings = Readings::default();
        for (node, reading) in keyed {
            while readings.begins.len() <= node {
                readings.begins.push(readings.all.len());
            }
            readings.all.push(reading);
        }
        while readings.begins.len() <= mesh.nodes {
            readings.begins.push(readings.all.len());
        }
        readings
    }
}

impl Readings {
    /// Those of one node.
    pub fn at(&self, node: usize) -> &[Reading] {
        let from = self.begins.get(node).copied().unwrap_or(0);
        let to = self.begins.get(node + 1).copied().unwrap_or(from);
        self.all.get(from..to).unwrap_or(&[])
    }
}
