//! What `replay`, `estimate` and `live` let a user choose of the state estimation.

use super::live_diagnosis_options::{LiveDiagnosisModel, LiveDiagnosisOptions};
use sideslip::error::Failure;
use sideslip::flight::run::RunGeometry;
use sideslip::live::output_error::LiveOutputError;
use sideslip::live::output_error_config::LiveOutputErrorConfig as LiveConfig;
use sideslip::realtime::estimation::config::RegressionStates;
use sideslip::realtime::pipeline::PipelineConfig;
use std::path::PathBuf;

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
    /// Output error beside the regression: never, at the end of each manoeuvre, or twice a second on the growing record too
    /// [default: manoeuvre in `replay`, streaming elsewhere]
    #[arg(long, value_enum)]
    output_error: Option<OutputErrorSchedule>,
    #[command(flatten)]
    model: LiveDiagnosisOptions,
}

/// When output error is fitted.
#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
pub(crate) enum OutputErrorSchedule {
    /// Never.
    Off,
    /// At the end of each manoeuvre.
    Manoeuvre,
    /// While it goes on, too.
    Streaming,
}

impl OutputErrorSchedule {
    /// What fits so, for a run with its instruments there.
    pub(crate) fn live(self, geometry: RunGeometry) -> Option<LiveOutputError> {
        let streaming = match self {
            OutputErrorSchedule::Off => return None,
            OutputErrorSchedule::Manoeuvre => false,
            OutputErrorSchedule::Streaming => true,
        };
        Some(LiveOutputError::new(LiveConfig { streaming, ..LiveConfig::default() }, geometry))
    }
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum States {
    Smoothed,
    Filtered,
}

impl EstimationOptions {
    /// The files that they name.
    pub(crate) fn files(&self) -> Option<PathBuf> {
        self.model.file()
    }

    /// The configuration that the options ask for.
    pub(crate) fn config(&self) -> PipelineConfig {
        let mut config = PipelineConfig::default();
        if let Some(seconds) = self.trim_window {
            config.estimation.trim_window_s = seconds;
        }
        config.estimation.regression_states = match self.states {
            States::Smoothed => RegressionStates::Smoothed,
            States::Filtered => RegressionStates::Filtered,
        };
        config
    }

    /// When output error is fitted, where it is not said.
    pub(crate) fn output_error_schedule(&self, usual: OutputErrorSchedule) -> OutputErrorSchedule {
        self.output_error.unwrap_or(usual)
    }

    /// The model of the live diagnosis, where one is given.
    pub(crate) fn live_diagnosis_model(&self) -> Result<Option<LiveDiagnosisModel>, Failure> {
        self.model.read()
    }

    /// The same options for a call of another command.
    pub(crate) fn call(&self) -> Vec<String> {
        let mut call: Vec<String> = self.trim_window.iter().map(|seconds| format!("--trim-window={seconds}")).collect();
        if self.states == States::Filtered {
            call.push("--states=filtered".into());
        }
        match self.output_error {
            None => {}
            Some(OutputErrorSchedule::Off) => call.push("--output-error=off".into()),
            Some(OutputErrorSchedule::Manoeuvre) => call.push("--output-error=manoeuvre".into()),
            Some(OutputErrorSchedule::Streaming) => call.push("--output-error=streaming".into()),
        }
        call.extend(self.model.call());
        call
    }
}
