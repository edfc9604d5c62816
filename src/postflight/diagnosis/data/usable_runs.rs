//! Runs that can be diagnosed by a model, and those that are set aside.
//!
//! Consumes a model and runs; produces the records of those that have what it asks for, each with its place among all, and of
//! the others the reason.

use super::run_data::RunData;
use super::unit_check::unit_check;
use crate::flight::control::Control;
use crate::flight::run::RunGeometry;
use crate::postflight::diagnosis::likelihood::aircraft::Aircraft;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::record::Unusable;
use crate::postflight::recorded_run::RecordedRun;
use crate::postflight::validation::free_run;
use crate::simulation::flight_model::FlightModel;

/// The records with their places, and the names of the others with why.
pub(crate) type UsableRuns = (Vec<(usize, RunData)>, Vec<(String, Unusable)>);

pub(crate) fn usable_runs(model: &FlightModel, fit: &[RecordedRun]) -> UsableRuns {
    let (mut records, mut set_aside) = (Vec::new(), Vec::new());
    let aircraft = Aircraft::of(model);
    for (place, run) in fit.iter().enumerate() {
        match record_of(model, run).and_then(|record| in_its_units(model, &aircraft, record)) {
            Ok(record) => records.push((place, record)),
            Err(unfit) => set_aside.push((run.name.clone(), unfit)),
        }
    }
    (records, set_aside)
}

/// A run that has what the model asks for.
///
/// # Errors
/// [`Unusable`] where it has not.
pub(crate) fn record_of(model: &FlightModel, run: &RecordedRun) -> Result<RunData, Unusable> {
    // A model that knows its blades knows them for runs that do not say: their passing is no motion.
    let blades = run.geometry.blades.or(model.blades().map(|blades| blades as u32));
    let geometry = RunGeometry { blades, ..run.geometry };
    RunData::of(&run.name, &run.samples, geometry).and_then(|record| with_controls(record, &answering(model)))
}

/// Controls that the model answers to, its own effects with it.
fn answering(model: &FlightModel) -> Vec<Control> {
    let (in_trim, effects) = (model.flight(), model.file.own_effects());
    Control::ALL.into_iter().filter(|&control| free_run::answers_to(control, &in_trim, &effects)).collect()
}

/// A run that has all of these.
fn with_controls(run: RunData, answering: &[Control]) -> Result<RunData, Unusable> {
    match answering.iter().find(|control| run.inputs.get(control.index()).is_none_or(Option::is_none)) {
        Some(control) => Err(Unusable::NoControl(control.name(run.geometry.controls))),
        None => Ok(run),
    }
}

/// A run whose channels are in the units that it says.
fn in_its_units(model: &FlightModel, aircraft: &Aircraft, run: RunData) -> Result<RunData, Unusable> {
    let pose = |run: RunData| {
        DiagnosisProblem::new(aircraft.clone(), model.file.own_effects(), vec![run], model.file.tolerance, &model.file.stds)
    };
    match unit_check(&run, aircraft.trim(), &pose) {
        Some((channels, unit)) => Err(Unusable::Unit { channels, controls: run.geometry.controls, unit }),
        None => Ok(run),
    }
}
