//! What `replay`, `estimate` and `live` let a user choose of the state estimation.

use sideslip::estimation::config::RegressionStates;
use sideslip::pipeline::Config;

/// Options of the state estimation.
#[derive(clap::Args)]
pub(crate) struct EstimationOptions {
    /// Length of the window at the run's start whose mean is the trim, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    trim_window: Option<f64>,
    /// What the derivatives are estimated from: smoothed states (0.4 s late), or filtered ones (every signal through a causal
    /// filter, 0.16 s late; standard errors a fifth to two fifths larger)
    #[arg(long, value_enum, default_value_t = States::Smoothed)]
    states: States,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum States {
    Smoothed,
    Filtered,
}

impl EstimationOptions {
    /// The configuration that the options ask for.
    pub(crate) fn config(&self) -> Config {
        let mut config = Config::default();
        if let Some(seconds) = self.trim_window {
            config.estimation.trim_window_s = seconds;
        }
        config.estimation.regression_states = match self.states {
            States::Smoothed => RegressionStates::Smoothed,
            States::Filtered => RegressionStates::Filtered,
        };
        config
    }

    /// The same options for a call of another command.
    pub(crate) fn call(&self) -> Vec<String> {
        let mut call: Vec<String> = self.trim_window.iter().map(|seconds| format!("--trim-window={seconds}")).collect();
        if self.states == States::Filtered {
            call.push("--states=filtered".into());
        }
        call
    }
}
