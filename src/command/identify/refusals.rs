//! Runs from which no derivatives can be estimated, and a search that fails or does not end.

use crate::command::message;
use sideslip::error::Failure;
use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::identify::{IdentificationError, IdentificationResult};
use sideslip::postflight::identification::model_variables::{IdentificationModelError, ModelVariables};
use sideslip::postflight::output_error::OutputErrorFitError;
use sideslip::realtime::pipeline::PipelineConfig;
use std::path::{Path, PathBuf};

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
                return Err(Failure::NoAnswer(format!(
                    "{}: `{name}` is sampled at {rate_hz:.1} Hz: expected {least_hz} Hz or more, for derivatives need the rates; \
                     record them faster, or take another recording of the flight",
                    file.display()
                )));
            }
        }
    }
    Ok(())
}

/// A search without a result, or runs that nothing can be estimated from, are no wrong call.
pub(super) fn not_identified(wrong: IdentificationError) -> Failure {
    match wrong {
        IdentificationError::Fit(OutputErrorFitError::Singular { .. } | OutputErrorFitError::Diverges { .. }) => {
            Failure::NoAnswer(wrong.to_string())
        }
        IdentificationError::Model(IdentificationModelError::NoInput) => Failure::NoAnswer(wrong.to_string()),
        _ => Failure::Input(wrong.to_string()),
    }
}

/// Whether a fit has converged; where not, that no model of it is written, and what to do. A signal may have ended it.
pub(super) fn is_converged(identified: &IdentificationResult, model: Option<&Path>, stopped: bool) -> bool {
    if identified.fitted.converged {
        return true;
    }
    let runs: Vec<&str> = identified.fit.iter().map(|flown| flown.run.as_str()).collect();
    let iterations = identified.fitted.iterations;
    let unwritten = model.map(|model| format!("; {} is not written", model.display())).unwrap_or_default();
    let advice = if stopped {
        "It needs more time"
    } else {
        "Take fewer states or inputs (--states, --inputs), or runs in which each of them moves by itself; `sideslip check` finds \
         instruments in error"
    };
    message(format_args!(
        "sideslip: {}: the search has not converged in {iterations} iterations, so the numbers are no estimates{unwritten}. {advice}",
        runs.join(", ")
    ));
    false
}
