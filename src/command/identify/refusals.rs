//! Runs from which no derivatives can be estimated, and the messages of a search that fails.

use sideslip::error::Failure;
use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::identify::IdentificationError;
use sideslip::postflight::identification::model_variables::ModelVariables;
use sideslip::postflight::output_error::OutputErrorFitError;
use sideslip::realtime::pipeline::PipelineConfig;
use std::path::PathBuf;

/// A run that is there twice would count twice, and one that is fitted foretells itself.
pub(super) fn refuse_twice(runs: &[(&PathBuf, &Columns)]) -> Result<(), Failure> {
    for (place, (file, run)) in runs.iter().enumerate() {
        if let Some((first, _)) = runs.iter().take(place).find(|(_, other)| run.is_same_recording(other)) {
            let found = format!("expected each run once, found the same recording as {}", first.display());
            return Err(Failure::file(file, found));
        }
    }
    Ok(())
}

/// Derivatives need fast rates.
pub(super) fn refuse_slow_rates(runs: &[(&PathBuf, &Columns)], choice: &ModelVariables) -> Result<(), Failure> {
    let least_hz = PipelineConfig::DEFAULT.regression.rate_min_hz;
    for (file, run) in runs {
        for name in choice.states.iter().filter(|name| matches!(name.as_str(), "p" | "q" | "r")) {
            if let Some(rate_hz) = run.rate_hz(name).filter(|rate_hz| *rate_hz < least_hz) {
                return Err(Failure::file(
                    file,
                    format!(
                        "`{name}` is sampled at {rate_hz:.1} Hz: expected {least_hz} Hz or more, for derivatives need the rates"
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// A search without a result is no wrong call.
pub(super) fn not_identified(wrong: IdentificationError) -> Failure {
    match wrong {
        IdentificationError::Fit(OutputErrorFitError::Singular { .. } | OutputErrorFitError::Diverges { .. }) => {
            Failure::Running(wrong.to_string())
        }
        _ => Failure::Input(wrong.to_string()),
    }
}
