//! Recordings that are fitted and recordings of the hold-out: one grammar for every command that takes both.

use super::telemetry_source::RecordingSource;
use sideslip::error::Failure;

/// Recordings, by what is done with them.
#[derive(clap::Args)]
pub(crate) struct FittedRuns {
    /// Recordings that are fitted, a run each; their format is recognised by their content; a stream of PCM is
    /// pcm+file://PATH?format=FRAME.toml, Chapter 10 whose setup does not name the channels ch10+file://PATH?format=FILE.toml
    #[arg(required_unless_present = "fit", value_name = "RUN", value_parser = RecordingSource::parser())]
    runs: Vec<RecordingSource>,
    /// The same behind a name: one or more
    #[arg(long, value_name = "RUN", num_args = 1.., value_parser = RecordingSource::parser())]
    fit: Vec<RecordingSource>,
    /// Recordings that are predicted and not fitted: one or more
    #[arg(long, value_name = "RUN", num_args = 1.., value_parser = RecordingSource::parser())]
    holdout: Vec<RecordingSource>,
}

impl FittedRuns {
    /// The recordings that are fitted, and those of the hold-out; none stands in both, and none twice.
    pub(crate) fn lists(&self) -> Result<(Vec<RecordingSource>, &[RecordingSource]), Failure> {
        let fitted: Vec<RecordingSource> = self.runs.iter().chain(&self.fit).cloned().collect();
        if let Some(both) = self.holdout.iter().find(|run| fitted.iter().any(|other| other.is_same_file(run))) {
            let what = "--holdout: expected a recording that is not fitted, found it among those; of one flight, `sideslip convert \
                        --manoeuvre N` makes a recording of a manoeuvre";
            return Err(Failure::file(&both.file, what));
        }
        refuse_twice(&fitted.iter().chain(&self.holdout).collect::<Vec<_>>())?;
        Ok((fitted, &self.holdout))
    }
}

/// Refuses a recording that stands twice among the runs.
pub(crate) fn refuse_twice(runs: &[&RecordingSource]) -> Result<(), Failure> {
    for (place, source) in runs.iter().enumerate() {
        if runs.iter().take(place).any(|other| other.is_same(source)) {
            return Err(Failure::file(&source.file, "expected each run once, found the same file twice"));
        }
    }
    Ok(())
}
