//! The answer of a diagnosis, with the runs that it rests on.

use super::args::DiagnoseArgs;
use crate::command::recordings::provenance::Provenance;
use crate::command::terminal::output_file::write_whole;
use crate::command::terminal::progress_line::watched;
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::io::outputs::words::set_aside::reason;
use sideslip::postflight::diagnosis::diagnose::{Diagnosis, diagnose};
use sideslip::postflight::diagnosis::search::next_cause::SearchSettings;
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::simulation::flight_model::FlightModel;
use std::path::PathBuf;

/// A model, its diagnosis, and the extension that follows from it.
pub(super) struct Answer {
    pub(super) model: FlightModel,
    pub(super) diagnosis: Diagnosis,
    pub(super) extension: Vec<DeclaredEffect>,
    pub(super) controls: ControlNames,
    pub(super) extended: Option<PathBuf>,
}

/// The runs, for pictures.
pub(super) struct Flights<'r> {
    pub(super) fit: &'r [RecordedRun],
    pub(super) holdout: &'r [RecordedRun],
    pub(super) provenance: &'r Provenance,
}

impl Answer {
    /// Diagnoses a model by the runs of one test point.
    pub(super) fn of(
        args: &DiagnoseArgs,
        model: FlightModel,
        (fit, holdout): (&[RecordedRun], &[RecordedRun]),
        controls: ControlNames,
        losses: &mut Vec<String>,
    ) -> Result<Self, Failure> {
        let (diagnosed, stopped) = watched("causes searched", |work| {
            let settings = SearchSettings { causes: args.causes, watch: Some(work), ..SearchSettings::default() };
            diagnose(&model, fit, holdout, &settings)
        })?;
        let diagnosis = diagnosed.map_err(|wrong| Failure::Input(wrong.to_string()))?;
        if stopped {
            let what = "stopped by a signal: these are the causes found until then, and what is unexplained may have another";
            losses.push(what.to_owned());
        }
        losses.extend(diagnosis.set_aside.iter().map(|(name, why)| format!("{name}: set aside: {}", reason(why))));
        let extension = diagnosis.extension();
        let extended = args.extended.clone().filter(|_| !extension.is_empty());
        Ok(Answer { model, diagnosis, extension, controls, extended })
    }

    /// The extended model to its file.
    pub(super) fn write_extended(&self) -> Result<(), Failure> {
        let Some(path) = &self.extended else { return Ok(()) };
        let all: Vec<DeclaredEffect> = self.model.file.effects.iter().chain(&self.extension).copied().collect();
        let text = self.model.with_effects(&all).map_err(|wrong| Failure::Running(wrong.to_string()))?;
        write_whole(path, |file| file.write_all(text.as_bytes()))
    }
}
