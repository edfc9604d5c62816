//! Settings of output error beside a flight.

/// Settings of output error during a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveOutputErrorConfig {
    /// Whether to fit during a manoeuvre; otherwise at the end of each only.
    pub streaming: bool,
    /// Interval between fits during a manoeuvre, s.
    pub every_s: f64,
    /// Recorded manoeuvres, s, beyond which the interval is longer in proportion.
    pub full_pace_s: f64,
    /// Time of trim before excitation is detected that belongs to a manoeuvre, s.
    pub lead_s: f64,
    /// Window of a manoeuvre's trim, s.
    pub trim_s: f64,
    /// Excitation that is shorter is no manoeuvre, s.
    pub shortest_s: f64,
    /// A manoeuvre that is longer is cut, s.
    pub longest_s: f64,
    /// Samples that are kept.
    pub capacity: usize,
    /// Sampling rate of a fit, Hz: samples are averaged over blocks.
    pub rate_hz: f64,
    /// Largest number of steps of a fit.
    pub iterations: usize,
    /// Excitation from which on all terms are free, not only those that the regression has selected, s.
    pub all_terms_s: f64,
    /// Whether a control at rest is replaced by its mean: see `resting_controls`.
    pub hold_controls: bool,
    /// Time without excitation after which estimates are stale, s.
    pub stale_s: f64,
    /// Time that estimates must have stayed within two standard errors to be converged, s.
    pub settled_s: f64,
}

impl Default for LiveOutputErrorConfig {
    fn default() -> Self {
        LiveOutputErrorConfig {
            streaming: true,
            every_s: 0.5,
            full_pace_s: 20.0,
            lead_s: 4.0,
            trim_s: 1.0,
            shortest_s: 2.0,
            longest_s: 40.0,
            capacity: 16_384,
            rate_hz: 32.0,
            iterations: 12,
            all_terms_s: 10.0,
            hold_controls: true,
            stale_s: 10.0,
            settled_s: 2.0,
        }
    }
}
