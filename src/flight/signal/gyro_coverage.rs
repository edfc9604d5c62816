//! The time that a run's gyros cover, and meshes over it.
//!
//! Consumes the series of p, q, r; produces a [`Mesh`] whose step is a whole number of the gyros' intervals, so that no step is
//! made up of parts of samples:
//!     h = T floor(max(1, 1/(f T) + 1e-6))                                                             (1)
//! with T the longest of their median intervals, s, and f the rate that is asked for, Hz: the longest such step within 1/f, or T.

use super::readings::Mesh;
use super::series::Series;

/// From the last of the gyros' first samples to the first of their last, and the longest of their median intervals; all in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GyroCoverage {
    /// First time.
    pub first_s: f64,
    /// Last time; before the first where they share none.
    pub last_s: f64,
    /// T of (1); zero where no gyro has two samples.
    pub interval_s: f64,
}

/// Where the first node of a mesh stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstNode {
    /// At the first sample.
    FirstSample,
    /// In the middle of the samples that fall to it.
    MiddleOfStep,
}

impl GyroCoverage {
    /// What these gyros cover together.
    pub fn of<'s>(gyros: impl Iterator<Item = &'s Series> + Clone) -> Self {
        let range = gyros.clone().filter_map(Series::range_s);
        let (first_s, last_s) = range.fold((f64::NEG_INFINITY, f64::INFINITY), |(a, b), (c, d)| (a.max(c), b.min(d)));
        let interval_s = gyros.filter_map(Series::interval_s).fold(0.0, f64::max);
        GyroCoverage { first_s, last_s, interval_s }
    }

    /// The mesh by (1), f given in Hz.
    pub fn mesh(&self, rate_hz: f64, first: FirstNode) -> Mesh {
        let step_s = self.interval_s * libm::floor((1.0 / (rate_hz * self.interval_s) + 1e-6).max(1.0));
        let first_s = match first {
            FirstNode::FirstSample => self.first_s,
            FirstNode::MiddleOfStep => self.first_s + 0.5 * (step_s - self.interval_s),
        };
        Mesh { first_s, step_s, nodes: ((self.last_s - first_s) / step_s + 1e-6) as usize + 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_a_whole_number_of_the_slowest_gyros_intervals() {
        let gyro = |from: u32, step: f64| Series::of((from..101).map(|k| (step * f64::from(k), 0.0)));
        let gyros = [gyro(0, 0.02), gyro(5, 0.02), gyro(0, 0.021)];
        let coverage = GyroCoverage::of(gyros.iter());
        assert_eq!((coverage.first_s, coverage.last_s), (0.1, 2.0));
        assert!((coverage.interval_s - 0.021).abs() < 1e-12);
        let mesh = coverage.mesh(12.5, FirstNode::FirstSample);
        assert_eq!((mesh.first_s, mesh.nodes), (0.1, 31));
        assert!((mesh.step_s - 3.0 * 0.021).abs() < 1e-12, "the longest within 0.08 s: {mesh:?}");
        assert!((coverage.mesh(32.0, FirstNode::MiddleOfStep).first_s - 0.1).abs() < 1e-12, "one sample a node");
    }
}
